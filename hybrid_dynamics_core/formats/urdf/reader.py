"""Reader of URDF: links and joints of a document. Fixed joints are merged later.

Collisions and other content without mechanics are left out, with notes. Joints may be
replaced: a spherical joint by three revolute joints NAME_X, NAME_Y, NAME_Z whose axes meet, a
universal joint by two.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from ...description.document import Data, Document, KeyPath
from ...ground.file_options import file_options
from ...ground.regular_files import may_be_file
from ...ground.suggestions import suggestion
from ..packages import PackageError, Packages
from ..xacro.expand import expand_xacro, is_xacro_name
from ..xml.located_xml import LocatedElement, read_xml
from ..xml.reader import XmlReader
from .closing_joints import ClosingJoints
from .cut_loops import note_cut_loops
from .gazebo import read_gazebo
from .gazebo_joints import GazeboJoints
from .joints import JointReader
from .plus_reader import add_extras, add_loops, add_motors, has_loops, note_untied
from .replacements import add_replacement
from .transmissions import Drives
from .visuals import VisualReader
from .words import WordCheck

_INERTIA_KEYS = ("xx", "yy", "zz", "xy", "xz", "yz")
_PRODUCTS = ("xy", "xz", "yz")
_XACRO = (
    "is a xacro file; its expressions are evaluated only where its name ends in .xacro: rename it,"
    " or run it through xacro first"
)
_WORLD = "world"
_MAX_LISTED = 8  # links in a message


def add_urdf(
    document: Document,
    file: Path,
    replacements: Mapping[str, str],
    replacements_path: KeyPath,
    is_alone: bool = False,
) -> str:
    """Add links, joints and loops of a URDF(+) to a document; its root link becomes the base.

    Args:
        document: the document to extend.
        file: the URDF.
        replacements: replacement of joints by name: SPHERICAL, FIXED, UJOINT_XY and so on.
        replacements_path: path of these entries, for errors.
        is_alone: whether no other file has the driven joints and other data that URDF cannot
            express.

    Returns:
        The name of the robot.

    Raises:
        DescriptionError: the file is wrong, or has unsupported content.
    """
    root = _root_of(document, file)
    xml = XmlReader(file, root, document)
    reader = _UrdfReader(xml)
    reader.check_root()
    joint_names = [element.get("name") for element in root.all("joint")]
    for joint in replacements:
        if joint not in joint_names:
            hint = suggestion(joint, joint_names)
            raise document.error(
                (*replacements_path, joint), f"there is no joint '{joint}' in {file.name}{hint}"
            )
    for element in root.all("link"):
        reader.add_link(element)
    for element in root.all("joint"):
        reader.add_joint(element, replacements, replacements_path)
    reader.visuals.words.add_notes()
    reader.add_base()
    drives = Drives(xml)
    drives.read()
    add_loops(xml)
    closing = ClosingJoints(xml)
    closing.add_constraints()
    read_gazebo(xml, GazeboJoints(xml, closing))
    note_untied(xml)
    xml.note_collected()
    if is_alone:
        note_cut_loops(xml)
        _add_active(xml, drives.motors)
    return root.get("name", file.stem)


def _root_of(document: Document, file: Path) -> LocatedElement:
    """The root element of a file; a .xacro file is expanded."""
    if not is_xacro_name(file):
        return read_xml(file)
    expansion = expand_xacro(file, document.options)
    document.add_files(expansion.files)
    document.notes.extend(expansion.notes)
    return expansion.root


def _add_active(xml: XmlReader, motors: list[str]) -> None:
    """Add the active joints and the extras of a robot with loops."""
    if has_loops(xml.root):
        add_extras(xml)
    elif xml.document.section("closures"):
        add_motors(xml.document, motors)


def expand_urdf(document: Document, is_alone: bool = False) -> str:
    """Add the content of the URDF file that a description names.

    Args:
        document: the description.
        is_alone: whether no other file has the driven joints and other data that URDF cannot
            express.

    Returns:
        The robot's name in the URDF; empty if the description names no URDF.

    Raises:
        DescriptionError: the file is missing or wrong, or has unsupported content.
    """
    entry = document.data.pop("urdf", None)
    if entry is None:
        return ""
    key: KeyPath = ("urdf", "file")
    if isinstance(entry, str):
        entry = {"file": entry}
        key = ("urdf",)
    file = _named_file(document, entry["file"], key)
    given = entry.get("xacro_args", {})
    arguments = file_options(xacro_args=given).xacro_args
    options = document.options
    document.options = replace(options, xacro_args={**arguments, **options.xacro_args})
    replacements = entry.get("replace", {})
    return add_urdf(document, file, replacements, ("urdf", "replace"), is_alone)


def _named_file(document: Document, name: str, key: KeyPath) -> Path:
    """The file that a description names, by a relative path or in a package."""
    here = Path(document.file or "robot.yaml")
    try:
        file = Packages(here, document.options.search_path).resolve(name, here.parent)
    except PackageError as error:
        raise document.error(key, str(error)) from error
    if not may_be_file(file):
        raise document.error(
            key, f"there is no file {file}; the path starts at the folder of this file"
        )
    return file


class _UrdfReader:
    def __init__(self, xml: XmlReader) -> None:
        self.xml = xml
        self.document = xml.document
        self.children: set[str] = set()  # links that are the child of a joint
        self.visuals = VisualReader(xml)

    def check_root(self) -> None:
        """Refuse a file that is no URDF, and add notes on words left out."""
        root = self.xml.root
        if root.tag == "sdf":
            raise self.xml.error(root, (), "is SDFormat, not URDF; load() reads it")
        if root.tag == "gazebo" and root.get("version"):
            raise self.xml.error(root, (), "is SDFormat before 1.3; 'gz sdf -p FILE' converts it")
        if root.tag != "robot":
            raise self.xml.error(root, (), f"<{root.tag}> is not a URDF; its root is <robot>")
        if _is_xacro(root):
            raise self.xml.error(root, (), _XACRO)
        WordCheck(self.xml).check()

    # -- links

    def add_link(self, element: LocatedElement) -> None:
        name = self.xml.name(element, "links")
        path = ("links", name)
        entry: Data = {}
        inertial = element.first("inertial")
        if inertial is not None:
            entry = self.body(inertial, path)
            for key in entry:
                self.xml.locate((*path, key), inertial)
        visuals = self.visuals.entries(element, path)
        if visuals:
            entry["visuals"] = visuals
        self.xml.add(path, entry, element)
        self.document.rounded_links.add(name)

    def body(self, inertial: LocatedElement, path: KeyPath) -> Data:
        """Mass, centre of mass and inertia of a link."""
        mass = inertial.first("mass")
        if mass is None:
            if self.is_base(path):
                self.xml.note(inertial, "<inertial> of the base has no <mass>; left out")
                return {}
            raise self.xml.error(inertial, path, "<inertial> has no <mass>")
        origin = self.xml.origin(inertial, path)
        entry: Data = {
            "mass": self.xml.number(mass, "value", (*path, "mass")),
            "com": origin["xyz"],
        }
        inertia = inertial.first("inertia")
        if inertia is not None:
            inertia_path = (*path, "inertia")
            tensor: Data = {}
            for key in _INERTIA_KEYS:
                default = None
                if key in _PRODUCTS:
                    default = 0.0
                tensor[key] = self.xml.number(inertia, f"i{key}", inertia_path, default)
            missing = [f"i{key}" for key in _PRODUCTS if not inertia.get(f"i{key}")]
            if missing:
                self.xml.note(inertia, f"<inertia> has no {', '.join(missing)}; taken: 0")
            tensor["frame"] = {"rpy": origin["rpy"]}
            entry["inertia"] = tensor
        return entry

    def is_base(self, path: KeyPath) -> bool:
        """Whether a link is no child of any joint."""
        _, name = path
        ends = [joint.first("child") for joint in self.xml.root.all("joint")]
        return all(end is None or end.get("link") != name for end in ends)

    # -- joints

    def add_joint(
        self,
        element: LocatedElement,
        replacements: Mapping[str, str],
        replacements_path: KeyPath,
    ) -> None:
        name = self.xml.name(element, "joints")
        joint = JointReader(self.xml, element, name)
        entry = joint.connection()
        self.children.add(entry["child"])
        if name in replacements:
            kind = replacements[name].upper()
            written = (*replacements_path, name)
            add_replacement(self.xml, element, entry, kind, written)
            return
        if entry["type"] != "fixed":
            entry |= joint.motion()
        self.xml.add(("joints", name), entry, element)
        if entry["type"] == "free":
            self.leave_idle(name)

    def leave_idle(self, name: str) -> None:
        """Exclude a joint from the driven ones, unless the description lists it."""
        data = self.document.data
        idle = data.setdefault("idle", [])
        if name not in (*idle, *data.get("active", [])):
            idle.append(name)

    # -- base

    def add_base(self) -> None:
        """Set the base: the only link without a parent, or a link `world` below several of them."""
        links = [element.get("name") for element in self.xml.root.all("link")]
        roots = [name for name in links if name not in self.children] or self.undeclared(links)
        if len(roots) == 1:
            self.document.data.setdefault("base", roots[0])
            return
        if not links:
            problem = "there are no links; a file of macros alone is included by one of a robot"
            raise self.xml.error(self.xml.root, (), problem)
        if not roots:
            problem = (
                "the joints form a cycle, no link is without a parent; cut it and give the loop"
                " under closures"
            )
            raise self.xml.error(self.xml.root, (), problem)
        self.put_on_world(roots)

    def undeclared(self, links: list[str]) -> list[str]:
        """A parent link without an element of its own, with a note."""
        joints = self.document.section("joints").values()
        parents = dict.fromkeys(joint["parent"] for joint in joints)
        names = [name for name in parents if name not in links]
        if len(names) != 1:
            return []
        self.xml.note(self.xml.root, f"there is no <link> '{names[0]}'; taken as what stands still")
        return names

    def put_on_world(self, roots: list[str]) -> None:
        """Fix links without a parent at the origin of the world, as other programs do."""
        base = _WORLD
        while base in self.document.section("links"):
            base += "_"
        self.document.section("links")[base] = {}
        self.document.data.setdefault("base", base)
        joints = self.document.section("joints")
        for root in roots:
            name = f"{base}_to_{root}"
            while name in joints:
                name += "_"
            joints[name] = {"type": "fixed", "parent": base, "child": root}
        listed = ", ".join(roots[:_MAX_LISTED])
        text = f"{len(roots)} links are without a parent ({listed}); taken as standing on the world"
        self.xml.note(self.xml.root, text)


def _is_xacro(root: LocatedElement) -> bool:
    has_namespace = any(name.startswith("xmlns:xacro") for name in root.attributes)
    has_elements = any(child.tag.startswith("xacro:") for child in root.children)
    return has_namespace and has_elements
