"""Reader of SDFormat: links and joints of one model.

Joints form a spanning tree from the base, in either direction; the others close loops. All
coordinates are zero in the drawn configuration. So both ends of a loop joint are known there.
http://sdformat.org/spec, versions 1.2 to 1.12.
"""

from __future__ import annotations

from pathlib import Path

from ...description.defaults import driven_joints, farthest_link
from ...description.document import Data, Document, KeyPath
from ...description.geometry import Transform, rotation_from_rpy, rpy_to_axis, unit_axis
from ...ground.file_options import NO_OPTIONS, FileOptions
from ..extras_reader import TAG, read_extras
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from .auto_inertia import AutoInertia, is_auto
from .base import find_base
from .gearboxes import GEARBOX, GearboxReader
from .gravity import gravity_entry
from .joints import Freedom, JointReader
from .poses import WORLD, ModelPoses, pose_entry
from .selection import Selection
from .spanning_tree import spanning_tree
from .versions import YES, read_version
from .visuals import VisualReader
from .vocabulary import WELD

_DEFAULT_INERTIA = {
    "xx": 1.0,
    "yy": 1.0,
    "zz": 1.0,
    "xy": 0.0,
    "xz": 0.0,
    "yz": 0.0,
}


def sdf_document(root: LocatedElement, file: Path, options: FileOptions = NO_OPTIONS) -> Document:
    """The document of an SDFormat file.

    Args:
        root: root element of the file.
        file: path of it.
        options: the model to read, and the search path of included models.

    Raises:
        InputError: the file has no model of the name in the options.
        DescriptionError: the file has unsupported content.
    """
    data = {
        "format": 1,
        "name": file.stem,
        "links": {},
        "joints": {},
        "closures": {},
    }
    document = Document(data, file, {}, options)
    xml = XmlReader(file, root, document)
    version = read_version(xml, root)
    chosen = Selection(xml, version, options).chosen()
    model = chosen.model
    _SdfReader(xml, model, chosen.world).read()
    if not document.data["joints"]:
        raise xml.error(model, (), "no joint connects two of its links; a robot needs one")
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


# joint types of the chains that form one joint of several freedoms
_SEVERAL = {
    "ball": ["revolute", "revolute", "revolute"],
    "universal": ["revolute", "revolute"],
    "revolute2": ["revolute", "revolute"],
    "screw": ["revolute", "prismatic"],
}
_KINDS = {"revolute2": "universal"}


class _SdfReader:
    def __init__(self, xml: XmlReader, model: LocatedElement, world: LocatedElement | None) -> None:
        self.xml = xml
        self.document = xml.document
        self.model = model
        self.world = world
        self.poses = ModelPoses(xml, model)
        self.visuals = VisualReader(xml, self.poses)

    def read(self) -> None:
        """Fill the document."""
        data = self.document.data
        data["name"] = self.model.get("name", data["name"])
        data["source"] = str(self.xml.file.name)
        for link in self.model.all("link"):
            if not self.is_world(link):
                self.add_link(link)
        self.visuals.words.add_notes()
        self.add_joints()
        self.require_still()
        data["gravity"] = gravity_entry(self.xml, self.poses, self.model, self.world)
        for frame in self.model.all("frame"):
            if not frame.get("name").endswith("__"):  # frames of nested models
                self.add_frame(frame)
        data["active"] = driven_joints(self.document)
        data["active_set"] = "motors"

    def add_joints(self) -> None:
        """Add the joints of the tree, closures in place of all others, and what ties joints."""
        joints: list[JointReader] = []
        gearboxes: list[JointReader] = []
        for element in self.model.all("joint"):
            joint = JointReader(self.xml, self.poses, element)
            group = gearboxes if joint.type == GEARBOX else joints
            group.append(joint)
        base = find_base(self.xml, self.poses, joints)
        self.document.data["base"] = base.link
        directions = spanning_tree(base.joints, [base.link, *base.on_it])
        for joint in base.joints:
            joint.note_unused()
            if joint.name in directions:
                self.add_joint(joint, directions[joint.name])
            else:
                self.add_closure(joint)
        for element in self.model.all(WELD):
            self.add_weld(element)
        gears = GearboxReader(self.xml, self.poses, joints)
        for gearbox in gearboxes:
            gears.add(gearbox)

    # -- links

    def is_world(self, element: LocatedElement) -> bool:
        """Whether a link of the name `world` stands still, as a parent only, so is the world."""
        if element.get("name") != WORLD:
            return False
        children = [joint.first("child") for joint in self.model.all("joint")]
        if any(child is not None and child.text.strip() == WORLD for child in children):
            return False
        text = "link 'world' is moved by no joint; taken as the world, which stands still"
        self.xml.note(element, text)
        return True

    def require_still(self) -> None:
        """Raise if a joint moves a kinematic link, which Gazebo moves by no force."""
        base = self.document.data["base"]
        for link in self.model.all("link"):
            kinematic = link.first("kinematic")
            if kinematic is None or kinematic.text.strip() not in YES:
                continue
            if self.carrier(link.get("name")) != base:
                problem = (
                    f"<kinematic> of <link> is '{kinematic.text.strip()}', but joints move it;"
                    " take it out, or fix the link to the world"
                )
                raise self.xml.error(kinematic, ("links", link.get("name")), problem)
            self.xml.note(kinematic, "<kinematic> is passed over: its link stands still")

    def add_link(self, element: LocatedElement) -> None:
        name = self.xml.name(element, "links")
        path = ("links", name)
        if name == WORLD:
            raise self.xml.error(element, path, "is a name that SDFormat reserves; rename the link")
        inertial = element.first("inertial")
        if inertial is None:
            inertia = {"xx": 1.0, "yy": 1.0, "zz": 1.0}
            entry: Data = {"mass": 1.0, "inertia": inertia}
            self.document.notes.append(
                f"{name}: no inertial given; SDFormat takes 1 kg and 1 kg m^2"
            )
        elif is_auto(inertial):
            entry = AutoInertia(self.xml, self.visuals).body(element, inertial, path)
        else:
            entry = self.body(inertial, path)
        visuals = self.visuals.entries(element, path)
        if visuals:
            entry["visuals"] = visuals
        self.document.rounded_links.add(name)
        self.xml.add(path, entry, element)

    def body(self, inertial: LocatedElement, path: KeyPath) -> Data:
        """Mass, centre of mass and inertia of a link."""
        density = inertial.first("density")
        if density is not None:
            self.xml.note(density, f"<density> of {path[-1]} is left out: its mass is given")
        pose_element = inertial.first("pose")
        if pose_element is not None and pose_element.get("relative_to") not in ("", path[-1]):
            problem = (
                "the <pose> of <inertial> is always in its link; leave out"
                f' relative_to="{pose_element.get("relative_to")}", or convert the pose'
            )
            raise self.xml.error(pose_element, path, problem)
        pose = pose_entry(self.poses.read(pose_element, path))
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

    # -- joints

    def add_joint(self, joint: JointReader, is_reversed: bool) -> None:
        """Add a joint as a chain of hinges and slides, reversed if the tree starts at its child."""
        freedoms = joint.freedoms()
        start, end = joint.parent(), joint.child()
        pose = self.poses.joint(joint.element)
        held_at = joint.held_at()
        if is_reversed:
            start, end = end, start
            held_at = held_at.inverse()
            if joint.type != "ball":  # whose coordinates have no names in the file
                freedoms = [freedom.reversed() for freedom in reversed(freedoms)]
            text = f"joint {joint.name} is turned around: it leads from {start} to {end} here"
            self.xml.note(joint.element, text)
        origin = pose_entry(self.poses.in_link(start, pose) @ held_at)
        if not freedoms:
            entry = {"type": "fixed", "parent": start, "child": end, "origin": origin}
            self.xml.add(("joints", joint.name), entry, joint.element)
        self.add_row(joint, freedoms, (start, end), origin)
        link_pose = pose.inverse() @ self.poses.link(end)
        if not link_pose.is_identity():
            frames = self.document.section("frames")
            frames[end] = {"link": end, **pose_entry(link_pose)}

    def add_row(
        self, joint: JointReader, freedoms: list[Freedom], ends: tuple[str, str], origin: Data
    ) -> None:
        """Add a chain of hinges and slides, with massless links in between.

        Args:
            joint: the joint of the file.
            freedoms: hinges and slides in order.
            ends: the links before and after the chain.
            origin: pose of the first joint in the link before it.
        """
        start, end = ends
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
                "axis": (freedom.axis + 0.0).tolist(),  # no minus zero
                **freedom.constraints,
            }
            self.xml.add(("joints", freedom.name), entry, joint.element)
            start = link
            origin = pose_entry(Transform())
        several = _SEVERAL.get(joint.type)
        if several == [freedom.type for freedom in freedoms]:
            kind = _KINDS.get(joint.type, joint.type)
            names = [freedom.name for freedom in freedoms]
            self.document.section("multi_dof")[joint.name] = {"type": kind, "joints": names}

    def add_closure(self, joint: JointReader) -> None:
        """Add a loop joint as a closure, from the drawn configuration."""
        pose = self.poses.joint(joint.element)
        parent, child = self.end_of(joint.parent()), self.end_of(joint.child())
        if parent == child:
            raise self.xml.error_at(joint.element, "has both ends on one link")
        at_child = self.poses.in_link(child, pose)
        kind = joint.closure_kind()
        if kind and self.carrier(parent) == self.carrier(child):
            text = f"joint {joint.name} is left out: nothing moves between its ends"
            self.xml.note(joint.element, text)
            return
        if not kind:
            parent, at_parent = self.add_end(joint, parent)
            self.tie(joint, "frame", {parent: at_parent, child: at_child})
            return
        if joint.has_limits():
            self.document.notes.append(f"{joint.name}: closes a loop; its limits are not kept")
        turn = Transform()
        if kind == "axis":
            axis = unit_axis(joint.axis().tolist())
            turn = Transform(rotation_from_rpy(*rpy_to_axis(axis)))
        at_parent = self.poses.in_link(parent, pose)
        self.tie(joint, kind, {parent: at_parent @ turn, child: at_child @ turn})

    def carrier(self, link: str) -> str:
        """The link to which fixed joints lead from another one."""
        carriers: dict[str, str] = {}
        for joint in self.document.section("joints").values():
            if joint["type"] == "fixed":
                carriers[joint["child"]] = joint["parent"]
        while link in carriers:
            link = carriers[link]
        return link

    def add_weld(self, element: LocatedElement) -> None:
        """Add Drake's weld of two frames as a closure; they may be apart as drawn."""
        between: Data = {}
        for tag in ("parent", "child"):
            end = element.first(tag)
            if end is None or not end.text.strip():
                raise self.xml.error(element, (WELD,), f"has no <{tag}>")
            name = end.text.strip()
            link = self.end_of(self.poses.link_of(name, element))
            frame = self.poses.resolve(name, element)
            between[link] = pose_entry(self.poses.in_link(link, frame))
        if len(between) == 1:
            raise self.xml.error(element, (WELD,), "has both ends on one link")
        closures = self.document.section("closures")
        entry = {"kind": "frame", "between": between}
        name = element.get("name") or f"weld{len(closures) + 1}"
        self.xml.add(("closures", name), entry, element)

    def add_end(self, joint: JointReader, parent: str) -> tuple[str, Transform]:
        """Add a massless link for a loop joint that no closure can replace.

        Args:
            joint: the loop joint.
            parent: its parent link.

        Returns:
            A massless link after the hinges and slides of the joint, or the parent of a fixed
            joint; and the pose at which the child is welded to it.
        """
        pose = self.poses.in_link(parent, self.poses.joint(joint.element))
        freedoms = joint.freedoms()
        if not freedoms:
            return parent, pose @ joint.held_at()
        link = f"{joint.name}_end"
        self.xml.add(("links", link), {}, joint.element)
        self.add_row(joint, freedoms, (parent, link), pose_entry(pose))
        text = f"joint {joint.name} closes a loop: it moves {link}, which is welded to its child"
        self.xml.note(joint.element, text)
        return link, Transform()

    def tie(self, joint: JointReader, kind: str, ends: dict[str, Transform]) -> None:
        """Add a closure that replaces a joint."""
        between = {link: pose_entry(pose) for link, pose in ends.items()}
        entry = {"kind": kind, "between": between}
        self.xml.add(("closures", joint.name), entry, joint.element)

    def end_of(self, link: str) -> str:
        """The link; for the world, the base."""
        if link == WORLD:
            return str(self.document.data["base"])
        return link

    # -- frames

    def add_frame(self, element: LocatedElement) -> None:
        name = self.xml.name(element, "frames")
        link = self.end_of(self.poses.link_of(name, element))
        pose = self.poses.in_link(link, self.poses.resolve(name, element))
        frames = self.document.section("frames")
        frames.setdefault(name, {"link": link, **pose_entry(pose)})
