"""SDFormat -> a document: links and joints of one model.

Joints make up a tree from the base, in whatever direction they are written; the others close loops.
SDFormat draws the model in one configuration and counts every coordinate from there. Loop joints
are at rest in that configuration, so both ends of their frames are known.
http://sdformat.org/spec, versions 1.3 to 1.12.
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
from .joints import CLOSURE_KINDS, LIMITS, JointReader
from .poses import WORLD, ModelPoses, pose_entry
from .spanning_tree import reached_links, spanning_tree
from .vocabulary import Version, check_vocabulary, read_version

_GRAVITY = (0.0, 0.0, -9.8)  # of a world that does not say
_STANDARD_GRAVITY = (0.0, 0.0, -9.81)
_DEFAULT_INERTIA = {
    "xx": 1.0,
    "yy": 1.0,
    "zz": 1.0,
    "xy": 0.0,
    "xz": 0.0,
    "yz": 0.0,
}
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
    version = read_version(xml)
    model, world = _find_model(xml)
    check_vocabulary(xml, model, world, version)
    _SdfReader(xml, model, world).read(version)
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
    for child in xml.root.children:
        if child not in (model, world_around):
            xml.note(child, f"<{child.tag}> beside the model is left out")
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

    def read(self, version: Version) -> None:
        """Fill the document."""
        data = self.document.data
        data["name"] = self.model.get("name", data["name"])
        data["source"] = str(self.xml.file.name)
        for link in self.model.all("link"):
            self.add_link(link)
        elements = self.model.all("joint")
        joints = [JointReader(self.xml, self.poses, element, version) for element in elements]
        base, joints = self.find_base(joints)
        data["base"] = base
        self.set_gravity(base)
        directions = spanning_tree(joints, base)
        for joint in joints:
            joint.note_unused()
            if joint.name in directions:
                self.add_joint(joint, directions[joint.name])
            else:
                self.add_closure(joint)
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
        links = self.document.section("links")
        if not grounded:
            base = self.first_root(joints)
            self.check_reached(joints, base)
            self.document.notes.append(
                f"{base}: not joined to the world; taken as what stands still"
            )
            return base, joints
        self.check_reached(joints, WORLD)
        ground, *further = grounded
        others = [joint for joint in joints if joint is not ground]
        if further or ground.type != "fixed":
            links.setdefault(WORLD, {})
            return WORLD, joints
        ground.note_unused()
        return ground.child(), others

    def first_root(self, joints: list[JointReader]) -> str:
        """The first link without a parent; the first one where all have one."""
        links = list(self.document.section("links"))
        children = {joint.child() for joint in joints}
        roots = [link for link in links if link not in children]
        return next(iter([*roots, *links]), WORLD)

    def check_reached(self, joints: list[JointReader], base: str) -> None:
        """Refuse links that no joint connects with the base."""
        reached = reached_links(joints, base)
        loose = [link for link in self.document.section("links") if link not in reached]
        if loose:
            listed = ", ".join(loose[:_MAX_LISTED])
            raise self.xml.error(
                self.model,
                ("links",),
                f"no joint connects {listed} with {base}, so it would fly; join it to a link or the"
                " world",
            )

    def set_gravity(self, base: str) -> None:
        """Set the gravity of the world, in the base frame: the model may stand in it at a slant."""
        rotation = np.eye(3)
        if base != WORLD:
            rotation = self.poses.model.rotation @ self.poses.link(base).rotation
        in_base = rotation.T @ self.gravity() + 0.0  # no minus zero
        self.document.data["gravity"] = in_base.tolist()

    def gravity(self) -> list[float]:
        """Gravity in the world [m/s^2]; the standard one for a model without a world."""
        if self.world is None:
            return list(_STANDARD_GRAVITY)
        element = self.world.first("gravity")
        physics = self.world.first("physics")
        if element is None and physics is not None:
            element = physics.first("gravity")  # where older files have it
        return self.xml.text_numbers(element, 3, ("gravity",), _GRAVITY)

    # -- joints

    def add_joint(self, joint: JointReader, is_reversed: bool) -> None:
        """Add a joint as hinges and slides in a row; walked from its child, they turn around."""
        freedoms = joint.freedoms()
        start, end = joint.parent(), joint.child()
        sign = 1.0
        if is_reversed:
            start, end = end, start
            sign = -1.0
            freedoms.reverse()
            text = f"joint {joint.name} is turned around: it leads from {start} to {end} here"
            self.xml.note(joint.element, text)
        pose = self.poses.joint(joint.element)
        origin = pose_entry(self.poses.in_link(start, pose))
        if not freedoms:
            entry = {"type": "fixed", "parent": start, "child": end, "origin": origin}
            self.xml.add(("joints", joint.name), entry, joint.element)
        for freedom in freedoms:
            link = end
            if freedom is not freedoms[-1]:
                link = f"{freedom.name}_link"
                self.xml.add(("links", link), {}, joint.element)
            entry = {
                "type": freedom.type,
                "parent": start,
                "child": link,
                "origin": origin,
                "axis": (sign * freedom.axis + 0.0).tolist(),  # no minus zero
                **freedom.constraints,
            }
            self.xml.add(("joints", freedom.name), entry, joint.element)
            start = link
            origin = pose_entry(Transform())
        link_pose = pose.inverse() @ self.poses.link(end)
        if not link_pose.is_identity():
            frames = self.document.section("frames")
            frames[end] = {"link": end, **pose_entry(link_pose)}

    def add_closure(self, joint: JointReader) -> None:
        """Add a joint whose child hangs on another one as a closure of the drawn configuration."""
        name = joint.name
        if joint.type not in CLOSURE_KINDS:
            expected = ", ".join(CLOSURE_KINDS)
            raise self.xml.error(
                joint.element,
                joint.path,
                f"closes a loop with a joint of type '{joint.type}'; expected one of {expected}:"
                " cut the loop at such a joint",
            )
        kind = CLOSURE_KINDS[joint.type]
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
        limits = [constraints.pop(key, None) for key in LIMITS]
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
