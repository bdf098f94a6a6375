"""The vocabulary of URDF: words that are read, and notes on words left out.

http://wiki.ros.org/urdf/XML, and URDF+. No element or attribute is ignored silently. A word that is
not read gets a note with its line. A likely misspelling is refused.
"""

from __future__ import annotations

from dataclasses import dataclass

from ...description.document import KeyPath
from ...ground.suggestions import did_you_mean, fold_name
from ..extras_reader import TAG
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from ..xml.vocabulary import Vocabulary, vocabulary

_POSE = vocabulary("xyz rpy quat_xyzw")
_DIRECTION = vocabulary("xyz")
_LINK = vocabulary("link")
_LOOP_END = vocabulary("link", "origin")
_FIXED_JOINT = "fixed joint"
URDF: dict[str, Vocabulary] = {
    "robot": vocabulary(
        "name version",
        "link joint gazebo transmission ros2_control loop coupling constraint material"
        f" drake:ball_constraint {TAG}",
    ),
    "link": vocabulary("name", "inertial visual"),
    "inertial": vocabulary("", "origin mass inertia"),
    "origin": _POSE,
    "mass": vocabulary("value"),
    "inertia": vocabulary("ixx iyy izz ixy ixz iyz"),
    "joint": vocabulary("name type independent", "parent child origin axis limit dynamics mimic"),
    _FIXED_JOINT: vocabulary("name type independent", "parent child origin"),
    "parent": _LINK,
    "child": _LINK,
    "axis": _DIRECTION,
    "limit": vocabulary("lower upper effort velocity acceleration"),
    "dynamics": vocabulary("damping friction"),
    "mimic": vocabulary("joint multiplier offset"),
    "loop": vocabulary("name type", "predecessor successor axis"),
    "coupling": vocabulary("name", "predecessor successor ratio"),
    "predecessor": _LOOP_END,
    "successor": _LOOP_END,
    "ratio": vocabulary("value"),
    "constraint": vocabulary(
        "name type", "parent child parent_origin child_origin parent_axis child_axis"
    ),
    "parent_origin": _POSE,
    "child_origin": _POSE,
    "parent_axis": _DIRECTION,
    "child_axis": _DIRECTION,
}
# Words that are known and not read:
OMITTED: dict[str, Vocabulary] = {
    "link": vocabulary("type", "collision sensor"),
    "inertia": vocabulary("iyx izx izy"),  # redundant by symmetry
    "joint": vocabulary("", "calibration safety_controller"),
    _FIXED_JOINT: vocabulary("", "axis limit dynamics mimic calibration safety_controller"),
    "limit": vocabulary("deceleration jerk"),
}
# Words that change the mechanics, and are not read:
REFUSED = {
    "quat": "write it as quat_xyzw",
    "quat_wxyz": "write it as quat_xyzw",
    "loop_joint": "give the loop as <loop>, or under closures",
    "drake:joint": 'write it as a <joint>, of type "spherical" for a ball; others in a robot.yaml',
    "drake:distance_constraint": "it ties two links; take it out, or write a rod as a link",
    "drake:tendon_constraint": "it ties joints; take it out, or give it under couplings",
    "drake:linear_bushing_rpy": (
        "it puts springs between two links; take it out, or write a stiff one as"
        " <drake:ball_constraint>"
    ),
}
_SEVERAL = frozenset(
    {
        "link",
        "joint",
        "gazebo",
        "transmission",
        "ros2_control",
        "loop",
        "coupling",
        "constraint",
        "drake:ball_constraint",
        "material",
        "visual",
    }
)
_NAMED = frozenset({"link", "joint", "loop", "coupling", "constraint"})
_NOTHING = vocabulary()
_VERSIONS = ("", "1", "1.0", "1.1", "1.2")
_MAX_SHOWN = 20  # characters of a text


@dataclass
class _Place:
    """First place of a word left out, and its number of occurrences."""

    element: LocatedElement
    count: int = 0


class WordCheck:
    """Checks the elements of a URDF, except `<gazebo>` and others with readers of their own.

    Args:
        xml: the file.
    """

    def __init__(self, xml: XmlReader) -> None:
        self.xml = xml
        self.places: dict[str, _Place] = {}

    def check(self) -> None:
        """Check all elements, and add the notes.

        Raises:
            DescriptionError: a word is likely misspelled, or ties links or joints in an unsupported
                way.
        """
        root = self.xml.root
        version = root.get("version").strip()
        if version not in _VERSIONS:
            self.xml.note(root, f"version {version} is not known; taken as 1.2")
        self._check(root, ())
        for words, place in self.places.items():
            times = ""
            if place.count > 1:
                times = f", here and {place.count - 1} times more"
            self.xml.note(place.element, f"{words} is left out{times}")

    def _check(self, element: LocatedElement, key: KeyPath) -> None:
        kind = _kind(element)
        if element.tag in _NAMED:
            key = (f"{element.tag}s", element.get("name"))
        self._check_attributes(element, kind, key)
        read: set[str] = set()
        for child in element.children:
            if child.tag in read and child.tag not in _SEVERAL:
                raise self.xml.error(child, key, f"has a second <{child.tag}>; leave one out")
            if self._is_read(child, kind, key):
                read.add(child.tag)
        text = element.text.strip()
        if text and element.tag != TAG:
            self._omit(element, f"the text '{text[:_MAX_SHOWN]}' in <{element.tag}>")

    def _check_attributes(self, element: LocatedElement, kind: str, key: KeyPath) -> None:
        covered = URDF[kind].attributes
        omitted = OMITTED.get(kind, _NOTHING).attributes
        for name in element.attributes:
            if name in covered or name.startswith("xmlns"):
                continue
            if name in REFUSED:
                problem = f"the attribute {name} is not covered; {REFUSED[name]}"
                raise self.xml.error(element, key or (element.tag,), problem)
            if name not in omitted:
                self._refuse_slip(element, f"the attribute {name}", name, covered, key)
            self._omit(element, f"{name} of <{kind}>")

    def _is_read(self, child: LocatedElement, kind: str, key: KeyPath) -> bool:
        """Whether an element is read; if so it is checked, otherwise noted or refused."""
        tag = child.tag
        covered = URDF[kind].elements or frozenset()
        if tag in covered:
            if tag in URDF:
                self._check(child, key)
            return True
        if tag in REFUSED:
            raise self.xml.error(child, (tag,), f"is not covered; {REFUSED[tag]}")
        if tag not in (OMITTED.get(kind, _NOTHING).elements or ()):
            self._refuse_slip(child, f"the element <{tag}>", tag, covered, key)
        self._omit(child, f"<{tag}> of <{kind}>")
        return False

    def _refuse_slip(
        self,
        element: LocatedElement,
        shown: str,
        word: str,
        covered: frozenset[str],
        key: KeyPath,
    ) -> None:
        """Refuse a word that is almost equal to a known one."""
        for meant in sorted(covered):
            if _is_slip(fold_name(word), meant):
                hint = did_you_mean(meant)
                raise self.xml.error(element, key or (element.tag,), f"{shown} is not known{hint}")

    def _omit(self, element: LocatedElement, words: str) -> None:
        place = self.places.setdefault(words, _Place(element))
        place.count += 1


def _kind(element: LocatedElement) -> str:
    """The key of an element in the tables of words."""
    if element.tag == "joint" and element.get("type") == "fixed":
        return _FIXED_JOINT
    return element.tag


def _is_slip(word: str, meant: str) -> bool:
    """Whether two words differ by one inserted, missing, wrong or swapped letter."""
    start = 0
    while start < min(len(word), len(meant)) and word[start] == meant[start]:
        start += 1
    one, other = word[start:], meant[start:]
    exchanged = one[:2] == other[1::-1] and one[2:] == other[2:]
    return exchanged or one[1:] == other[1:] or one[1:] == other or one == other[1:]
