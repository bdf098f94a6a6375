"""Serial arms link by link, as data for a description file.

Links stand upright (x ahead, z up, as a column does) or are pitched (x along the link, y up in the
plane of its loops, z the pitch axis).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from ...errors import InputError
from ...ground.arrays import Array
from ...ground.suggestions import no_such_name
from .phrases import Phrase, parse_phrases
from .planar import point

TURNS = ("yaw", "pitch", "roll")
DENSITY = 20.0  # [kg/m] where no mass is given
RADIUS = 0.05  # [m] of links that roll
UPRIGHT = "upright"
PITCHED = "pitched"
MOST = 9  # links, and loops: q11 is the first coordinate of loop 1
_KEYS = ("length", "tail", "mass", "radius", "at", "on", "limits")
_USUAL = ("yaw", "pitch", "pitch", "roll", "pitch", "roll")
_LENGTHS = {"yaw": 0.4, "pitch": 0.6, "roll": 0.2}  # [m] where none is given
_TO_PITCH = ["pi/2", 0, 0]  # roll, pitch, yaw from an upright frame to a pitched one


@dataclass(frozen=True)
class ArmLink:
    """A link of the arm, with the joint that moves it.

    Attributes:
        number: i of its names, from 1: link l_i, joint q_i.
        turn: yaw, pitch or roll.
        length: to the next joint [m].
        tail: beyond its own joint, backward [m].
        mass: [kg].
        radius: about its own axis [m]; 0 for a slender rod.
        at: angle of its joint in the reference [rad].
        on: link that carries it; empty for the one that carries the arm on.
        limits: of its joint [rad].
    """

    number: int
    turn: str
    length: float
    tail: float = 0.0
    mass: float = 0.0
    radius: float = 0.0
    at: float = 0.0
    on: str = ""
    limits: tuple[float, ...] = ()

    @property
    def name(self) -> str:
        """Its name."""
        return f"l{self.number}"

    @property
    def joint(self) -> str:
        """The name of its joint."""
        return f"q{self.number}"


def parse_links(text: str) -> tuple[ArmLink, ...]:
    """Links of an arm: their number, or one phrase each, as `yaw: length=0.3; pitch: length=0.7`.

    Raises:
        InputError: a part has another form, or there are more than nine.
    """
    if text.strip().isdigit():
        count = int(text)
        turns = [*_USUAL, *["pitch"] * count][:count]
        if count == 1:
            turns = ["pitch"]
        text = "; ".join(f"{turn}:" for turn in turns)
    phrases = parse_phrases("link", text)
    if len(phrases) > MOST:
        raise InputError(f"there are {len(phrases)} links; expected {MOST} at most")
    return tuple(_link(k, phrase) for k, phrase in enumerate(phrases, start=1))


def _link(number: int, phrase: Phrase) -> ArmLink:
    if phrase.head not in TURNS:
        raise InputError(f"{phrase.place}: {no_such_name('kind of link', phrase.head, TURNS)}")
    phrase.require_keys(_KEYS)
    length = phrase.positive("length", "m", _LENGTHS[phrase.head])
    tail = phrase.size("tail", "m", 0.0)
    rolls = phrase.head == "roll"
    return ArmLink(
        number=number,
        turn=phrase.head,
        length=length,
        tail=tail,
        mass=phrase.positive("mass", "kg", DENSITY * (length + tail)),
        radius=phrase.size("radius", "m", RADIUS if rolls else 0.0),
        at=phrase.number("at", "rad", _usual_angle(number, phrase.head)),
        on=phrase.word("on", ""),
        limits=phrase.numbers("limits", "rad", 2),
    )


def _usual_angle(number: int, turn: str) -> float:
    """Angle in the reference where none is given: an arm that reaches up, then ahead."""
    if turn != "pitch":
        return 0.0
    return math.radians(60.0) if number <= 2 else math.radians(-60.0)


@dataclass(eq=False)
class Arm:
    """An arm that grows link by link.

    Attributes:
        data: the description file.
        frames: `upright` or `pitched`, by link.
        lengths: to the next joint [m], by link.
        carriers: link that a link hangs on, by link.
        pitches: angle in the plane of the loops at the reference [rad], by link.
        tip: link that carries the arm on.
    """

    data: dict[str, Any]
    frames: dict[str, str] = field(default_factory=lambda: {"base": UPRIGHT})
    lengths: dict[str, float] = field(default_factory=lambda: {"base": 0.0})
    carriers: dict[str, str] = field(default_factory=dict)
    pitches: dict[str, float] = field(default_factory=lambda: {"base": 0.0})
    tip: str = "base"

    def require_link(self, place: str, name: str) -> None:
        """Raise InputError for a link that is not there yet."""
        if name not in self.frames:
            raise InputError(f"{place}: {no_such_name('link', name, self.frames)}")

    def end_of(self, link: str) -> Array:
        """Where the next joint of a link is, in the plane of loops (2,) [m]."""
        length = self.lengths[link]
        if self.frames[link] == UPRIGHT:
            return point(0.0, length)
        return point(length, 0.0)

    def xyz_on(self, link: str, place: Array) -> list[float]:
        """A place (2,) in the plane of loops, in the frame of a link [m]."""
        x, y = place.tolist()
        if self.frames[link] == UPRIGHT:
            return [written(x), 0, written(y)]
        return [written(x), written(y), 0]

    def origin_of(self, link: str, place: Array) -> dict[str, Any]:
        """Origin of a joint that pitches, at a place (2,) in the plane of loops [m]."""
        origin: dict[str, Any] = {"xyz": self.xyz_on(link, place)}
        if self.frames[link] == UPRIGHT:
            origin["rpy"] = _TO_PITCH
        return origin

    def add_bar(self, link: str, mass: float, vector: Array, start: Array) -> None:
        """Add a pitched link that is a slender rod along a vector (2,) from a start (2,) [m]."""
        self.frames[link] = PITCHED
        self.lengths[link] = 0.0
        x, y = vector.tolist()
        square = x * x + y * y
        share = mass / 12.0
        inertia = {
            "xx": written(share * y * y),
            "yy": written(share * x * x),
            "zz": written(share * square),
        }
        if x and y:
            inertia["xy"] = written(-share * x * y)
        com = self.xyz_on(link, start + 0.5 * vector)
        self.data["links"][link] = {"mass": written(mass), "com": com, "inertia": inertia}

    def add_arm_body(self, name: str, link: ArmLink, frame: str = PITCHED) -> None:
        """Add the body of a link of the arm."""
        self.frames[name] = frame
        full_length = link.length + link.tail
        middle = 0.5 * (link.length - link.tail)
        across = link.mass * full_length * full_length / 12.0
        axial = 0.5 * link.mass * link.radius**2
        inertia = dict.fromkeys(("xx", "yy", "zz"), written(across))
        com = [written(middle), 0, 0]
        inertia["xx"] = written(axial)
        if frame == UPRIGHT:
            com = [0, 0, written(middle)]
            inertia = {"xx": written(across), "yy": written(across), "zz": written(axial)}
        self.data["links"][name] = {"mass": written(link.mass), "com": com, "inertia": inertia}

    def carry_on(self, link: str, carrier: str, length: float, pitch: float) -> None:
        """Carry the arm on from a link.

        Args:
            link: the link.
            carrier: link that it hangs on.
            length: to the next joint [m].
            pitch: its angle in the plane of the loops at the reference [rad].
        """
        self.carriers[link] = carrier
        self.lengths[link] = length
        self.pitches[link] = pitch
        self.tip = link

    def add_joint(self, name: str, at: float, **entries: Any) -> None:
        """Add a joint, with its coordinate in the reference."""
        self.data["joints"][name] = entries
        self.data["reference"][name] = written(at)

    def add_hinge(self, name: str, at: float, links: tuple[str, str], place: Array) -> None:
        """Add a joint that pitches, between two links at a place (2,) of the first [m]."""
        parent, child = links
        self.frames[child] = PITCHED
        origin = self.origin_of(parent, place)
        self.add_joint(
            name,
            at,
            type="revolute",
            parent=parent,
            child=child,
            origin=origin,
            axis="z",
        )

    def add_slide(
        self,
        name: str,
        at: float,
        links: tuple[str, str],
        barrel: float,
        limits: Sequence[float],
    ) -> None:
        """Add a joint that slides along the first of two links, beyond its barrel [m]."""
        parent, child = links
        self.frames[child] = PITCHED
        entries: dict[str, Any] = {"type": "prismatic", "parent": parent, "child": child}
        entries["origin"] = {"xyz": [written(barrel), 0, 0]}
        entries["axis"] = "x"
        entries["limits"] = [written(limit) for limit in limits]
        self.add_joint(name, at, **entries)

    def add_link(self, link: ArmLink) -> None:
        """Add a link and its joint at the end of the link that carries it.

        Raises:
            InputError: there is no such carrier, or a link rolls on an upright one.
        """
        place = f"link {link.number} ({link.turn})"
        carrier = link.on or self.tip
        self.require_link(place, carrier)
        is_upright = self.frames[carrier] == UPRIGHT
        if link.turn == "roll" and is_upright:
            raise InputError(
                f"{place}: rolls about a link that points ahead; pitch comes before it"
            )
        frame = PITCHED
        axis = {"yaw": "y", "pitch": "z", "roll": "x"}[link.turn]
        if is_upright and link.turn == "yaw":
            frame, axis = UPRIGHT, "z"
        end = self.end_of(carrier)
        origin: dict[str, Any] = {"xyz": self.xyz_on(carrier, end)}
        pitch = 0.0
        if link.turn == "pitch":
            origin = self.origin_of(carrier, end)
            pitch = link.at
        entries: dict[str, Any] = {"type": "revolute", "parent": carrier, "child": link.name}
        entries["origin"] = origin
        entries["axis"] = axis
        if link.limits:
            entries["limits"] = list(link.limits)
        self.add_joint(link.joint, link.at, **entries)
        self.add_arm_body(link.name, link, frame)
        self.carry_on(link.name, carrier, link.length, self.pitches[carrier] + pitch)
        self.data["active"].append(link.joint)


def written(value: float) -> float:
    """A number with twelve digits; an integer without a point."""
    rounded = float(f"{value:.12g}")
    return int(rounded) if rounded.is_integer() else rounded
