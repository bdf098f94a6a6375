"""MJCF as this library writes it -> a document: bodies on hinges and slides, closures, motors.

Closures are equality constraints. MuJoCo's format says much that has no meaning here: contacts,
tendons, defaults, meshes that make up masses. What would change the robot is refused with its line;
what is only seen is omitted.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from ...description.defaults import driven_joints, farthest_link
from ...description.document import Data, Document, KeyPath
from ...description.followers import mimic_entry
from ...description.geometry import rotation_from_quaternion, rpy_of
from ...errors import DescriptionError
from ..extras_reader import TAG, read_extras
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from ..xml.vocabulary import VocabularyCheck
from .joints import read_joint
from .vocabulary import ADVICE, MJCF

NEGLIGIBLE = 1e-9  # [kg, kg m^2] stands for none, since MuJoCo wants some mass of what moves
_CLOSURE_KINDS = {"connect": "point", "weld": "frame"}
_GRAVITY = (0.0, 0.0, -9.81)  # of a file that does not say
_COMPONENTS = ("xx", "yy", "zz", "xy", "xz", "yz")
_ZERO_VECTOR = (0.0, 0.0, 0.0)
_NO_TURN = (1.0, 0.0, 0.0, 0.0)
_OTHER_ORIENTATIONS = ("euler", "axisangle", "xyaxes", "zaxis")
_SHORTEST_QUATERNION = 1e-9


def mjcf_document(root: LocatedElement, file: Path) -> Document:
    """The document of an MJCF file.

    Raises:
        DescriptionError: the file says what is not covered.
    """
    data = {
        "format": 1,
        "name": root.get("model", file.stem),
        "base": "world",
        "links": {},
        "joints": {},
        "closures": {},
        "source": file.name,
    }
    document = Document(data, file, {})
    xml = XmlReader(file, root, document)
    VocabularyCheck(xml, MJCF, ADVICE).check(root)
    reader = _MjcfReader(xml)
    reader.read_settings()
    for world in root.all("worldbody"):
        reader.add_content(world, "world")
    reader.add_equalities()
    reader.add_active()
    reader.add_reference()
    for custom in root.all("custom"):
        for text in custom.all("text"):
            if text.get("name") == TAG:
                read_extras(document, text.get("data"), file, text.line)
    if "end_effector" not in document.data:
        document.data["end_effector"] = {"link": farthest_link(document)}
    return document


class _MjcfReader:
    def __init__(self, xml: XmlReader) -> None:
        self.xml = xml
        self.document = xml.document
        self.sites: dict[str, tuple[str, Data]] = {}  # link and pose on it
        self.joint_order: list[str] = []  # as MuJoCo numbers them

    def error(self, element: LocatedElement, problem: str) -> DescriptionError:
        key: KeyPath = (element.tag,)
        if element.get("name"):
            key = (element.tag, element.get("name"))
        return self.xml.error(element, key, problem)

    # -- settings

    def read_settings(self) -> None:
        """Read angles, bounds and gravity; of repeated attributes the last holds, as in MuJoCo."""
        root = self.xml.root
        angle_unit = "degree"
        for compiler in root.all("compiler"):
            angle_unit = compiler.get("angle", angle_unit)
            self.check_bounds(compiler)
        if angle_unit != "radian":
            raise self.xml.error(
                root, ("compiler",), 'counts angles in degrees; expected angle="radian"'
            )
        gravity = list(_GRAVITY)
        for option in root.all("option"):
            gravity = self.xml.numbers(option, "gravity", 3, ("option",), gravity)
        self.document.data["gravity"] = gravity

    def check_bounds(self, compiler: LocatedElement) -> None:
        """Refuse bounds above what stands for none: MuJoCo raises lighter bodies to them."""
        for attribute in ("boundmass", "boundinertia"):
            bound = self.xml.number(compiler, attribute, ("compiler",), 0.0)
            if bound > NEGLIGIBLE:
                raise self.xml.error(
                    compiler,
                    ("compiler",),
                    f"{attribute} is {bound:g}, to which MuJoCo raises lighter bodies; expected"
                    f" {NEGLIGIBLE:g} at most: give each body the mass that is meant",
                )

    # -- bodies

    def add_content(self, body: LocatedElement, link: str) -> None:
        """Add sites and bodies that stand on a body."""
        for geom in body.all("geom"):
            if geom.attributes.get("mass") not in ("0", "0.0"):
                raise self.error(
                    geom, 'a <geom> makes up mass; give it mass="0" and the body an <inertial>'
                )
        for site in body.all("site"):
            name = self.xml.name(site, "sites")
            if name in self.sites:
                raise self.error(site, "has the name of another site; rename one of them")
            pose = self.pose(site, ("sites",))
            self.sites[name] = (link, pose)
        for child in body.all("body"):
            self.add_body(child, link)

    def add_body(self, body: LocatedElement, parent: str) -> None:
        """Add a body as a link on a joint, and all that stands on it."""
        link = self.xml.name(body, "links")
        link_path = ("links", link)
        inertial = self.inertial(body, link_path)
        self.xml.add(link_path, inertial, body)
        entry: Data = {
            "parent": parent,
            "child": link,
            "origin": self.pose(body, link_path),
        }
        joint = self.only_joint(body, link)
        if joint is None:
            entry["type"] = "fixed"
            self.xml.add(("joints", f"{link}_fixed"), entry, body)
        else:
            name = self.xml.name(joint, "joints")
            entry |= read_joint(self.xml, joint, name)
            self.joint_order.append(name)
            self.xml.add(("joints", name), entry, joint)
        self.add_content(body, link)

    def only_joint(self, body: LocatedElement, link: str) -> LocatedElement | None:
        joints = body.all("joint")
        if len(joints) > 1:
            raise self.error(
                joints[1],
                f"body '{link}' has {len(joints)} joints; expected one, or none where it is fixed",
            )
        return body.first("joint")

    def inertial(self, body: LocatedElement, path: KeyPath) -> Data:
        """Mass, centre of mass and inertia of a body; nothing where they stand for none."""
        inertial = body.first("inertial")
        if inertial is None:
            return {}
        mass = self.xml.number(inertial, "mass", (*path, "mass"))
        pose = self.pose(inertial, path)
        tensor = self.tensor(inertial, (*path, "inertia"))
        largest_moment = max(tensor["xx"], tensor["yy"], tensor["zz"])
        if mass <= NEGLIGIBLE and largest_moment <= NEGLIGIBLE:
            return {}
        inertia = {**tensor, "frame": {"rpy": pose["rpy"]}}
        return {"mass": mass, "com": pose["xyz"], "inertia": inertia}

    def tensor(self, inertial: LocatedElement, key: KeyPath) -> dict[str, float]:
        """Components of an inertia tensor [kg m^2]."""
        if "fullinertia" in inertial.attributes:
            values = self.xml.numbers(inertial, "fullinertia", 6, key)
        else:
            moments = self.xml.numbers(inertial, "diaginertia", 3, key)
            values = [*moments, 0.0, 0.0, 0.0]
        return dict(zip(_COMPONENTS, values, strict=True))

    def pose(self, element: LocatedElement, path: KeyPath) -> dict[str, list[float]]:
        for attribute in _OTHER_ORIENTATIONS:
            if attribute in element.attributes:
                raise self.xml.error(element, path, f"is turned by {attribute}; expected quat")
        quaternion = self.xml.numbers(element, "quat", 4, path, _NO_TURN)
        if math.hypot(*quaternion) < _SHORTEST_QUATERNION:
            raise self.xml.error(element, path, "has a quat without length; 1 0 0 0 is no turn")
        rotation = rotation_from_quaternion(np.array(quaternion))
        translation = self.xml.numbers(element, "pos", 3, path, _ZERO_VECTOR)
        return {"xyz": translation, "rpy": rpy_of(rotation).tolist()}

    # -- equality constraints

    def add_equalities(self) -> None:
        """Add closures between sites and followers; all other sites become frames."""
        tied_sites: set[str] = set()
        for equality in self.xml.root.all("equality"):
            for element in equality.children:
                if element.tag == "joint":
                    self.add_follower(element)
                elif element.tag == "tendon":
                    self.add_tendon_follower(element)
                elif element.tag in _CLOSURE_KINDS:
                    tied_sites.update(self.add_closure(element))
                else:
                    raise self.error(
                        element, f"<{element.tag}> is not covered; expected connect, weld or joint"
                    )
        frames = self.document.section("frames")
        for name, (link, pose) in self.sites.items():
            if name not in tied_sites:
                frames[name] = {"link": link, **pose}

    def add_closure(self, element: LocatedElement) -> tuple[str, str]:
        """Add a closure; returns the names of its sites."""
        sites = (element.get("site1"), element.get("site2"))
        between: Data = {}
        for site in sites:
            if site not in self.sites:
                raise self.error(
                    element,
                    f"ties the site '{site}', which is not there; name two sites as site1 and"
                    " site2",
                )
            link, pose = self.sites[site]
            between[link] = pose
        if len(between) < 2:
            raise self.error(element, "ties two sites of one body")
        entry = {"kind": _CLOSURE_KINDS[element.tag], "between": between}
        name = self.xml.name(element, "closures")
        self.xml.add(("closures", name), entry, element)
        return sites

    def add_follower(self, element: LocatedElement) -> None:
        follower = element.get("joint1")
        source = element.get("joint2")
        key = ("joints", follower, "mimic")
        offset, multiplier, *higher = self.xml.numbers(element, "polycoef", 5, key)
        joints = self.document.section("joints")
        if follower not in joints or not source or any(higher):
            raise self.error(
                element, "expected joint1 that follows joint2 by a polynomial of first degree"
            )
        mimic = {"joint": source, "multiplier": multiplier, "offset": offset}
        joints[follower]["mimic"] = mimic

    def add_tendon_follower(self, element: LocatedElement) -> None:
        """Add the first joint of a tendon of fixed length as a follower of the others."""
        tendon = self.tendon(element)
        length, *higher = self.xml.numbers(element, "polycoef", 5, ("equality",))
        if any(higher):
            raise self.error(element, "expected a polynomial of degree 0, for one tendon")
        coefficients: dict[str, float] = {}
        for joint in tendon.all("joint"):
            name = joint.get("joint")
            if name not in self.joint_order:
                raise self.error(joint, f"there is no joint '{name}' in the bodies")
            coefficients[name] = self.xml.number(joint, "coef", ("joints", name, "mimic"))
        follower, *sources = coefficients
        scale = coefficients[follower]
        if not sources or not scale:
            raise self.error(tendon, "expected two joints or more, the first with a coef")
        multipliers = {source: -coefficients[source] / scale for source in sources}
        mimic = mimic_entry(multipliers, length / scale)
        self.document.section("joints")[follower]["mimic"] = mimic

    def tendon(self, element: LocatedElement) -> LocatedElement:
        """The fixed tendon that an equality names."""
        name = element.get("tendon1")
        for tendons in self.xml.root.all("tendon"):
            for tendon in tendons.all("fixed"):
                if tendon.get("name") == name and tendon.children:
                    return tendon
        raise self.error(element, f"there is no <fixed> tendon '{name}' with joints")

    # -- motors and reference

    def add_active(self) -> None:
        """Make the joints with motors active."""
        active: list[str] = []
        for actuator in self.xml.root.all("actuator"):
            for element in actuator.children:
                joint = element.get("joint")
                if element.tag != "motor" or joint not in self.joint_order:
                    raise self.error(
                        element, f"<{element.tag}> is not covered; expected <motor joint=...>"
                    )
                active.append(joint)
        if not active and self.document.section("closures"):
            raise self.xml.error(
                self.xml.root,
                ("actuator",),
                "has no motors; with closures, name the driven joints so",
            )
        self.document.data["active"] = active or driven_joints(self.document)
        self.document.data["active_set"] = "motors"

    def add_reference(self) -> None:
        """Read the first keyframe; without one, all coordinates are zero."""
        count = len(self.joint_order)
        zero = [0.0] * count
        values = zero
        for keyframe in self.xml.root.all("keyframe"):
            key = keyframe.first("key")
            if key is not None:
                values = self.xml.numbers(key, "qpos", count, ("keyframe",), zero)
                break
        reference = dict(zip(self.joint_order, values, strict=True))
        self.document.data["reference"] = reference
