"""Loops of Type A to D appended to an arm: Chu et al. (2020), Section 2.

Each is closed in the plane of its base, at the angles of the reference.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from ...errors import InputError
from ...ground.arrays import Array
from .arm import Arm, ArmLink
from .loops import ArmLoop
from .planar import along, angle_of, distance, meeting_point, point, turned

_ORIGIN = point(0.0, 0.0)


def add_with_loops(arm: Arm, link: ArmLink, loops: Sequence[ArmLoop]) -> None:
    """Add a link of the arm with the loops at its joint.

    Raises:
        InputError: a loop does not close at the reference, or stands on a wrong link.
    """
    replacing = [loop for loop in loops if loop.type in "CD"]
    if not replacing:
        arm.add_link(link)
    for loop in loops:
        site = _site(arm, link, loop)
        _ADD[loop.type](site)


@dataclass(frozen=True, eq=False)
class _Site:
    """Where a loop is built.

    Attributes:
        arm: the arm so far.
        link: the link l_i.
        loop: the loop.
        base: the link l_(i-1).
        origin: place of the arm's joint on the base, in the plane of the loop (2,) [m].
        pivot: place of the first added link's joint there (2,) [m].
    """

    arm: Arm
    link: ArmLink
    loop: ArmLoop
    base: str
    origin: Array
    pivot: Array

    @property
    def place(self) -> str:
        """The loop, for messages."""
        return self.loop.phrase.place

    @property
    def base_pitch(self) -> float:
        """Angle of the base in the plane of the loop [rad]."""
        return self.arm.pitches[self.base]

    def hang_first(self, angle: float) -> None:
        """Add the joint of the first added link, at the pivot."""
        joint, _ = self.loop.joints
        first, _ = self.loop.links
        links = (self.base, first)
        self.arm.add_hinge(joint, angle, links, self.pivot)

    def add_bars(self, names: Sequence[str], vectors: Sequence[Array], start: Array) -> None:
        """Add two slender rods along vectors (2,); the second one from a start (2,) [m]."""
        lengths = [distance(vector, _ORIGIN) for vector in vectors]
        masses = self.loop.masses(lengths)
        starts = (_ORIGIN, start)
        for name, mass, vector, begin in zip(names, masses, vectors, starts, strict=True):
            self.arm.add_bar(name, mass, vector, begin)

    def close(self, k2: str, arm: str, pins: Mapping[str, Array]) -> None:
        """Add the loop, with its pins on two links (2,) [m]."""
        places: dict[str, list[float]] = {}
        for name, pin in pins.items():
            places[name] = self.arm.xyz_on(name, pin)
        first, _ = self.loop.links
        self.arm.data["loops"][self.loop.name] = {
            "type": self.loop.type,
            "base": self.base,
            "arm": arm,
            "k1": first,
            "k2": k2,
            "pin": places,
        }


def _site(arm: Arm, link: ArmLink, loop: ArmLoop) -> _Site:
    """Where a loop stands.

    Raises:
        InputError: its base does not hold the arm's joint.
    """
    place = loop.phrase.place
    usual = link.on or arm.tip
    carrier = arm.carriers.get(link.name, usual)
    base = loop.phrase.word("base", carrier)
    arm.require_link(place, base)
    if base == carrier:
        origin = arm.end_of(base)
    elif arm.carriers.get(base) == carrier:
        origin = _ORIGIN
    else:
        raise InputError(
            f"{place}: {base} does not hold {link.joint}; expected base={carrier}, or a carrier of"
            " Type B at its end"
        )
    return _Site(arm, link, loop, base, origin, loop.point("pivot"))


def _add_drive(site: _Site, link: str, joint: str, pin: Array) -> Array:
    """Add a cylinder, or crank and coupler, from the pivot on the base to a pin.

    Args:
        site: where.
        link: the rod or coupler.
        joint: its joint.
        pin: the pin at the reference, in the plane of the base (2,) [m].

    Returns:
        The pin on the rod or coupler (2,) [m].
    """
    if "barrel" in site.loop.phrase.words:
        return _add_cylinder(site, link, joint, pin)
    return _add_crank(site, link, joint, pin)


def _add_cylinder(site: _Site, link: str, joint: str, pin: Array) -> Array:
    phrase = site.loop.phrase
    first, _ = site.loop.links
    barrel = phrase.positive("barrel", "m")
    rod = phrase.positive("rod", "m", barrel)
    length = distance(pin, site.pivot)
    if length < barrel:
        raise InputError(
            f"{site.place}: does not close: its pins are {length:.4g} m apart in the reference,"
            f" less than its barrel of {barrel:.4g} m"
        )
    angle = angle_of(pin - site.pivot)
    site.hang_first(angle)
    lower, upper = phrase.numbers("stroke", "m", 2, (0.0, barrel))
    if not lower <= length - barrel <= upper:
        raise InputError(
            f"{site.place}: its stroke is {length - barrel:.4g} m in the reference; expected"
            f" {lower:.4g} to {upper:.4g} m"
        )
    site.arm.add_slide(joint, length - barrel, (first, link), barrel, (lower, upper))
    vectors = (along(0.0, barrel), along(0.0, rod))
    site.add_bars((first, link), vectors, point(-rod, 0.0))
    site.arm.data["active"].append(joint)
    return _ORIGIN


def _add_crank(site: _Site, link: str, joint: str, pin: Array) -> Array:
    loop = site.loop
    first, _ = loop.links
    loop.require("crank", "coupler")
    crank = loop.phrase.positive("crank", "m")
    coupler = loop.phrase.positive("coupler", "m")
    elbow = meeting_point(site.place, (site.pivot, pin), (crank, coupler), loop.left)
    angle = angle_of(elbow - site.pivot)
    onward = turned(pin - elbow, -angle)
    tip = point(crank, 0.0)
    site.hang_first(angle)
    site.arm.add_hinge(joint, angle_of(onward), (first, link), tip)
    end = point(coupler, 0.0)
    site.add_bars((first, link), (tip, end), _ORIGIN)
    site.arm.data["active"].append(loop.joints[0])
    return end


def _add_a(site: _Site) -> None:
    """A cylinder or crank drives the link of the arm."""
    arm, name = site.arm, site.link.name
    turn = arm.pitches[name] - site.base_pitch
    pin = site.loop.point("pin")
    here = site.origin + turned(pin, turn)
    _, second = site.loop.links
    arm.data["active"].remove(site.link.joint)
    end = _add_drive(site, second, site.loop.joints[1], here)
    site.close(second, name, {second: end, name: pin})


def _add_b(site: _Site) -> None:
    """A bar beside the link of the arm guides a carrier at its end, which carries the arm on."""
    arm, loop, name = site.arm, site.loop, site.link.name
    turn = arm.pitches[name] - site.base_pitch
    end = site.origin + along(turn, site.link.length)
    pin = site.pivot - site.origin
    if not pin.any():
        raise InputError(f"{site.place}: its pivot is the joint itself; expected it beside")
    bar = site.link.length
    meeting = end + pin
    if not loop.is_parallelogram:
        loop.require("bar", "pin")
        pin = loop.point("pin")
        bar = loop.phrase.positive("bar", "m")
        bars = (bar, distance(pin, _ORIGIN))
        meeting = meeting_point(site.place, (site.pivot, end), bars, loop.left)
    level = angle_of(meeting - end) - angle_of(pin)
    first, second = loop.links
    angle = angle_of(meeting - site.pivot)
    site.hang_first(angle)
    arm.add_hinge(loop.joints[1], level - turn, (name, second), arm.end_of(name))
    carrier = loop.phrase.size("carrier", "m", 0.0)
    body = pin
    if carrier:
        body = point(carrier, 0.0)
    bar_end = point(bar, 0.0)
    site.add_bars((first, second), (bar_end, body), _ORIGIN)
    arm.carry_on(second, name, carrier, site.base_pitch + level)
    site.close(second, name, {first: bar_end, second: pin})
    if loop.is_parallelogram:
        arm.data["loops"][loop.name]["assembly"] = "parallelogram"


def _add_c(site: _Site) -> None:
    """The link of the arm hangs on a driven link and is tied to the base by a bar."""
    arm, loop, link = site.arm, site.loop, site.link
    pin = loop.point("pin")
    bar = loop.phrase.positive("bar", "m")
    length = loop.phrase.positive("k2", "m")
    turn = loop.phrase.number("at", "rad", link.at)
    end = site.origin + along(turn, length)
    bars = (bar, distance(pin, _ORIGIN))
    meeting = meeting_point(site.place, (site.pivot, end), bars, loop.left)
    tilt = angle_of(meeting - end) - angle_of(pin)
    first, second = loop.links
    tip = point(length, 0.0)
    bar_end = point(bar, 0.0)
    angle = angle_of(meeting - site.pivot)
    site.arm.add_hinge(loop.joints[1], turn, (site.base, second), site.origin)
    site.add_bars((first, second), (bar_end, tip), _ORIGIN)
    site.arm.add_hinge(link.joint, tilt - turn, (second, link.name), tip)
    site.hang_first(angle)
    arm.add_arm_body(link.name, link)
    arm.carry_on(link.name, second, link.length, site.base_pitch + tilt)
    arm.data["active"].append(loop.joints[1])
    site.close(second, link.name, {first: bar_end, link.name: pin})


def _add_d(site: _Site) -> None:
    """The link of the arm is a rod or coupler, and drives the link that carries the arm on."""
    arm, loop, link = site.arm, site.loop, site.link
    pin = loop.point("pin")
    here = site.origin + turned(pin, link.at)
    _, boom = loop.links
    end = _add_drive(site, link.name, link.joint, here)
    site.arm.add_hinge(loop.joints[1], link.at, (site.base, boom), site.origin)
    arm.add_arm_body(boom, link)
    arm.carry_on(boom, site.base, link.length, site.base_pitch + link.at)
    site.close(boom, link.name, {link.name: end, boom: pin})


_ADD: dict[str, Callable[[_Site], None]] = {"A": _add_a, "B": _add_b, "C": _add_c, "D": _add_d}
