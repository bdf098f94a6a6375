"""SDFormat -> a document: links and joints of one model.

A joint whose child already has a parent closes a loop. SDFormat draws the model in one
configuration and counts every coordinate from there. Loop joints are at rest in that configuration,
so both ends of their frames are known. http://sdformat.org/spec, versions 1.7 to 1.12.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...description.defaults import driven_joints, farthest_link
from ...description.document import Data, Document, KeyPath
from ...description.geometry import Transform, rotation_from_rpy, rpy_to_axis, unit_axis
from ..extras_reader import TAG, read_extras
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from .joints import JointReader
from .poses import WORLD, ModelPoses, pose_entry
from .vocabulary import check_version, check_vocabulary

_JOINT_TYPES = {
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "fixed": "fixed",
}
_CLOSURE_KINDS = {
    "revolute": "axis",
    "continuous": "axis",
    "ball": "point",
    "fixed": "frame",
}
_GRAVITY = (0.0, 0.0, -9.8)  # of a world that does not say
_DEFAULT_INERTIA = {
    "xx": 1.0,
    "yy": 1.0,
    "zz": 1.0,
    "xy": 0.0,
    "xz": 0.0,
    "yz": 0.0,
}
_LIMITS = ("limits", "effort_limit", "velocity_limit")
_MAX_LISTED = 8  # links in a message


def sdf_document(root: LocatedElement, file: Path) -> Document:
    """The document of an SDFormat file.

    Raises:
        DescriptionError: the file says what is not covered.
    """
    data = {
        "format": 1,
        "name": file.stem,
        "links": {},
        "joints": {},
        "closures": {},
    }
    document = Document(data, file, {})
    xml = XmlReader(file, root, document)
    check_version(xml)
    model, world = _find_model(xml)
    check_vocabulary(xml, model, world)
    _SdfReader(xml, model, world).read()
    extras = [child for child in model.children if _is_extras(child)]
    for element in extras:
        read_extras(document, element.text, file, element.line)
    if not extras and document.data["closures"]:
        document.notes.append(
            "SDFormat does not say what is driven; independent joints are taken in its order"
        )
    if "end_effector" not in document.data:
        document.data["end_effector"] = {"link": farthest_link(document)}
    return document


def _is_extras(element: LocatedElement) -> bool:
    _, _, local_tag = element.tag.rpartition(":")
    return local_tag == TAG


def _find_model(xml: XmlReader) -> tuple[LocatedElement, LocatedElement | None]:
    """The one model with joints, and the world around it if there is one."""
    models: list[tuple[LocatedElement, LocatedElement | None]] = []
    models.extend((model, None) for model in xml.root.all("model"))
    for world in xml.root.all("world"):
        models.extend((model, world) for model in world.all("model") if model.all("joint"))
    if len(models) != 1:
        problem = f"holds {len(models)} models with joints; expected one"
        raise xml.error(xml.root, ("model",), problem)
    model, world_around = models[0]
    for tag in ("include", "model"):
        inner = model.first(tag)
        if inner is not None:
            problem = f"has <{tag}> in it, which is not covered; join them first"
            raise xml.error(inner, ("model",), problem)
    return model, world_around


class _SdfReader:
    def __init__(self, xml: XmlReader, model: LocatedElement, world: LocatedElement | None) -> None:
        self.xml = xml
        self.document = xml.document
        self.model = model
        self.world = world
        self.poses = ModelPoses(xml, model)

    def read(self) -> None:
        """Fill the document."""
        data = self.document.data
        data["name"] = self.model.get("name", data["name"])
        data["source"] = str(self.xml.file.name)
        for link in self.model.all("link"):
            self.add_link(link)
        elements = self.model.all("joint")
        joints = [JointReader(self.xml, self.poses, element) for element in elements]
        base, joints = self.find_base(joints)
        data["base"] = base
        self.set_gravity(base)
        hung_links = {base}
        for joint in joints:
            child = joint.child()
            if child in hung_links:
                self.add_closure(joint)
            else:
                hung_links.add(child)
                self.add_joint(joint)
        for frame in self.model.all("frame"):
            self.add_frame(frame)
        data["active"] = driven_joints(self.document)
        data["active_set"] = "motors"

    # -- links

    def add_link(self, element: LocatedElement) -> None:
        name = self.xml.name(element, "links")
        path = ("links", name)
        inertial = element.first("inertial")
        if inertial is None:
            inertia = {"xx": 1.0, "yy": 1.0, "zz": 1.0}
            entry: Data = {"mass": 1.0, "inertia": inertia}
            self.document.notes.append(
                f"{name}: no inertial given; SDFormat takes 1 kg and 1 kg m^2"
            )
        else:
            entry = self.body(inertial, path)
        self.document.rounded_links.add(name)
        self.xml.add(path, entry, element)

    def body(self, inertial: LocatedElement, path: KeyPath) -> Data:
        """Mass, centre of mass and inertia of a link."""
        pose = pose_entry(self.poses.read(inertial.first("pose"), path))
        tensor: Data = dict(_DEFAULT_INERTIA)
        inertia = inertial.first("inertia")
        if inertia is not None:
            for key, default in _DEFAULT_INERTIA.items():
                component = inertia.first(f"i{key}")
                tensor[key] = self.xml.text_number(component, path, default)
        tensor["frame"] = {"rpy": pose["rpy"]}
        mass_path = (*path, "mass")
        mass = self.xml.text_number(inertial.first("mass"), mass_path, 1.0)
        return {"mass": mass, "com": pose["xyz"], "inertia": tensor}

    def find_base(self, joints: list[JointReader]) -> tuple[str, list[JointReader]]:
        """The link that does not move, and all joints but its own."""
        grounded = [joint for joint in joints if joint.is_grounded()]
        children = {joint.child() for joint in joints}
        links = self.document.section("links")
        roots = [link for link in links if link not in children]
        if grounded:
            ground = grounded[0]
            if len(grounded) > 1 or ground.type != "fixed" or roots:
                links.setdefault(WORLD, {})
                return WORLD, joints
            return ground.child(), [joint for joint in joints if joint is not ground]
        if len(roots) != 1:
            listed = ", ".join(roots[:_MAX_LISTED])
            problem = f"{len(roots)} links are without a parent ({listed}); a robot has one"
            raise self.xml.error(self.model, ("links",), problem)
        base = roots[0]
        self.document.notes.append(f"{base}: not joined to the world; taken as what stands still")
        return base, joints

    def set_gravity(self, base: str) -> None:
        """Set the gravity of the world, in the base frame."""
        if self.world is None:
            return
        rotation = np.eye(3)
        if base != WORLD:
            rotation = self.poses.model.rotation @ self.poses.link(base).rotation
        element = self.world.first("gravity")
        gravity = self.xml.text_numbers(element, 3, ("gravity",), _GRAVITY)
        in_base = rotation.T @ gravity + 0.0  # no minus zero
        self.document.data["gravity"] = in_base.tolist()

    # -- joints

    def add_joint(self, joint: JointReader) -> None:
        name = self.xml.name(joint.element, "joints")
        if joint.type not in _JOINT_TYPES:
            problem = f"is '{joint.type}'; expected one of {', '.join(_JOINT_TYPES)}"
            raise self.xml.error(joint.element, (*joint.path, "type"), problem)
        child = joint.child()
        parent = joint.parent()
        pose = self.poses.joint(joint.element)
        entry: Data = {
            "type": _JOINT_TYPES[joint.type],
            "parent": parent,
            "child": child,
            "origin": pose_entry(self.poses.in_link(parent, pose)),
        }
        link_pose = pose.inverse() @ self.poses.link(child)
        if not link_pose.is_identity():
            frames = self.document.section("frames")
            frames[child] = {"link": child, **pose_entry(link_pose)}
        if joint.type != "fixed":
            entry["axis"] = joint.axis().tolist()
            entry |= joint.constraints()
        self.xml.add(("joints", name), entry, joint.element)

    def add_closure(self, joint: JointReader) -> None:
        """Add a joint whose child hangs on another one as a closure of the drawn configuration."""
        name = self.xml.name(joint.element, "joints")
        if joint.type not in _CLOSURE_KINDS:
            expected = ", ".join(_CLOSURE_KINDS)
            raise self.xml.error(
                joint.element,
                joint.path,
                f"closes a loop with a joint of type '{joint.type}'; expected one of {expected}:"
                " cut the loop at such a joint",
            )
        kind = _CLOSURE_KINDS[joint.type]
        self.refuse_constraints(joint)
        pose = self.poses.joint(joint.element)
        turn = Transform()
        if kind == "axis":
            axis = unit_axis(joint.axis().tolist())
            turn = Transform(rotation_from_rpy(*rpy_to_axis(axis)))
        between: Data = {}
        for link in (joint.parent(), joint.child()):
            end = self.document.data["base"] if link == WORLD else link
            between[end] = pose_entry(self.poses.in_link(end, pose) @ turn)
        if len(between) < 2:
            raise self.xml.error_at(joint.element, "has both ends on one link")
        entry = {"kind": kind, "between": between}
        self.xml.add(("closures", name), entry, joint.element)

    def refuse_constraints(self, joint: JointReader) -> None:
        """Refuse what a joint that closes a loop cannot have; its limits are omitted."""
        constraints = joint.constraints()
        limits = [constraints.pop(key, None) for key in _LIMITS]
        if any(limits):
            _, name = joint.path
            self.document.notes.append(f"{name}: closes a loop; its limits are not kept")
        if constraints:
            raise self.xml.error(
                joint.element,
                joint.path,
                f"has {' and '.join(constraints)}, which a joint that closes a loop cannot have"
                " here; put another joint of the loop behind it",
            )

    # -- frames

    def add_frame(self, element: LocatedElement) -> None:
        name = self.xml.name(element, "frames")
        link = self.poses.link_of(name, element)
        pose = self.poses.in_link(link, self.poses.resolve(name, element))
        frames = self.document.section("frames")
        frames.setdefault(name, {"link": link, **pose_entry(pose)})
