"""Loops of Type A to D on an assembly, in planes tilted in space.

Each link and joint where the configuration has it.

All four types are one linkage: a stub S on the base, a first link F on the base, a second one c on
F, and the pin between c and S. Type A: arm S, k1 F, k2 c; B: k1 S, arm F, k2 c; C: k1 S, k2 F, arm
c; D: k2 S, k1 F, arm c.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hybrid_dynamics_core.description import Loop
from tests.generated.assembly import Assembly, frame_with_normal, unit

ROLES = {
    "A": ("S", "F", "c"),
    "B": ("F", "S", "c"),
    "C": ("c", "S", "F"),
    "D": ("c", "F", "S"),
}  # arm, k1, k2
GOES_ON = {"A": "S", "B": "c", "C": "c", "D": "S"}
KIND = {"R": "revolute", "P": "prismatic"}
# joints of S, F and c; the pin is the fourth
MIXES = (
    "RRR",
    "RRP",
    "RPR",
    "PRR",
    "PPR",
    "PRP",
    "RPP",
)


@dataclass(frozen=True)
class FourBar:
    """Type letter; joints of S, F and c.

    Whether opposite bars are equal (RRR only) and named so.
    """

    letter: str
    mix: str = "RRR"
    parallelogram: bool = False


class Plane:
    """A plane through a point of space: 2D places and directions to space and back."""

    def __init__(self, assembly: Assembly, origin: np.ndarray, normal: np.ndarray) -> None:
        self.assembly = assembly
        self.origin = origin
        self.basis = frame_with_normal(normal, assembly.tilting)
        self.normal = normal

    def space(self, place: np.ndarray, along: float = 0.0) -> np.ndarray:
        """A point of space, `along` the normal off the plane."""
        return self.origin + self.basis @ np.array([*place, along])

    def place(self, point: np.ndarray) -> np.ndarray:
        """2D place of a point."""
        return (self.basis.T @ (point - self.origin))[:2]

    def axis(self, kind: str) -> np.ndarray:
        """The axis of a joint that moves in the plane."""
        rng = self.assembly.rng
        if kind == "revolute":
            return self.normal * rng.choice([-1.0, 1.0])
        angle = rng.integers(4) * np.pi / 2.0 if self.assembly.tidy else rng.uniform(-np.pi, np.pi)
        return self.basis[:, :2] @ np.array([np.cos(angle), np.sin(angle)])


def joint_point(a: Assembly, link: str) -> np.ndarray:
    """A point on the axis of the joint that carries a link."""
    return a.poses[link][1]


def plane_of(a: Assembly, link: str) -> Plane:
    """A plane in which the link's joint moves it."""
    normal = a.axes[f"q_{link}"]
    if a.joint_of(link).type == "prismatic":
        normal = a.across(normal)
    return Plane(a, joint_point(a, link), normal)


def corner(rng: np.random.Generator, size: float = 0.5) -> np.ndarray:
    """A place in a plane, not too near the origin."""
    angle = rng.uniform(-np.pi, np.pi)
    return size * rng.uniform(0.4, 1.2) * np.array([np.cos(angle), np.sin(angle)])


def new_four_bar(
    a: Assembly, base: str, at: np.ndarray, normal: np.ndarray, bar: FourBar
) -> dict[str, str]:
    """A four-bar with three new links on the base: link by 'S', 'F', 'c'."""
    plane = Plane(a, at, normal)
    kind = KIND[bar.mix[0]]
    stub = a.hang(base, kind, plane.axis(kind), plane.space(np.zeros(2)))
    return {"S": stub, **_closing_links(a, base, stub, plane, bar)}


def added_four_bar(a: Assembly, base: str, stub: str, bar: FourBar) -> dict[str, str]:
    """A four-bar with two new links, on a pair of links that has a joint already."""
    return {"S": stub, **_closing_links(a, base, stub, plane_of(a, stub), bar)}


def _closing_links(a: Assembly, base: str, stub: str, plane: Plane, bar: FourBar) -> dict[str, str]:
    """The links F and c, and the pin between c and the stub."""
    rng = a.rng
    places = [corner(rng), corner(rng), corner(rng)]  # pivots of F and c, the pin
    if bar.parallelogram:
        centre = plane.place(joint_point(a, stub))
        places = [centre + places[0], centre + places[0] + places[1], centre + places[1]]
    off = np.zeros(3) if a.tidy else rng.normal(size=3) * 0.1
    kinds = [KIND[letter] for letter in bar.mix[1:]]
    f = a.hang(base, kinds[0], plane.axis(kinds[0]), plane.space(places[0], off[0]))
    c = a.hang(f, kinds[1], plane.axis(kinds[1]), plane.space(places[1], off[1]))
    links = {"base": base, "S": stub, "F": f, "c": c}
    name = a.fresh("loop")
    mode = "parallelogram" if bar.parallelogram else None
    ends = (c, stub) if rng.integers(2) else (stub, c)
    a.tie(*ends, plane.space(places[2], off[2]), name=name, assembly=mode)
    arm, k1, k2 = (links[role] for role in ROLES[bar.letter])
    a.loops[name] = Loop(name, bar.letter, base, arm, k1, k2)
    a.rank += 2
    return {"F": f, "c": c}


def hung_four_bars(a: Assembly, base: str, at: np.ndarray, normal: np.ndarray, letter: str) -> str:
    """Two loops as the forging robot's parallelograms.

    The second stands on the coupler of the first.

    The next link of the arm turns on the pivot of that coupler. Returns the link that carries the
    arm on.
    """
    first = new_four_bar(a, base, at, normal, FourBar("B"))
    pivot = joint_point(a, first["c"])
    arm = a.hang(first["F"], "revolute", a.axes[f"q_{first['c']}"], pivot)
    plane = Plane(a, pivot, normal)
    if letter == "A":
        added_four_bar(a, first["c"], arm, FourBar("A"))
        return arm
    rng = a.rng
    k1, k2, pin = (plane.space(corner(rng)) for _ in range(3))
    stub = a.hang(first["c"], "revolute", plane.axis("revolute"), k1)
    second = a.hang(arm, "revolute", plane.axis("revolute"), k2)
    name = a.fresh("loop")
    a.tie(stub, second, pin, name=name)
    a.loops[name] = Loop(name, "B", first["c"], arm, stub, second)
    a.rank += 2
    return second


def spanning_cylinder(a: Assembly, base: str, far: str, mix: str, kind: str) -> None:
    """Two new links between a link and one two joints on, in one plane.

    A loop with two degrees of freedom.
    """
    plane = plane_of(a, far)
    rng = a.rng
    kinds = [KIND[letter] for letter in mix]
    f = a.hang(base, kinds[0], plane.axis(kinds[0]), plane.space(corner(rng)))
    c = a.hang(f, kinds[1], plane.axis(kinds[1]), plane.space(corner(rng)))
    a.tie(c, far, plane.space(corner(rng)), kind, plane.normal)
    a.rank += 2


def framed_loop(a: Assembly, base: str, stub: str) -> None:
    """A four-bar cut through its coupler and closed by a whole frame.

    Six equations, of which three count.
    """
    plane = plane_of(a, stub)
    rng = a.rng
    f = a.hang(base, "revolute", plane.axis("revolute"), plane.space(corner(rng)))
    c = a.hang(f, "revolute", plane.axis("revolute"), plane.space(corner(rng)))
    half = a.hang(stub, "revolute", plane.axis("revolute"), plane.space(corner(rng)))
    a.tie(c, half, plane.space(corner(rng)), "frame")
    a.rank += 3


def leg_anywhere(a: Assembly, on: str, to: str, kind: str) -> None:
    """A leg from one link to another, wherever they are. It adds no freedom."""
    foot, tip = (joint_point(a, link) + 0.4 * a.rng.normal(size=3) for link in (on, to))
    leg(a, on, to, foot, tip, kind)


def leg(a: Assembly, on: str, to: str, foot: np.ndarray, tip: np.ndarray, kind: str) -> str:
    """A leg between two points, with a ball at its tip.

    UPS, or RUS and PUS, whose rod is carried by a crank or slide.

    Returns its driven joint.
    """
    rng = a.rng
    link = on
    at = foot
    driven = ""
    along = unit(tip - foot)
    if kind != "UPS":
        if kind == "RUS":
            axis = unit(np.cross(along, rng.normal(size=3)))
            at = foot + 0.3 * np.cross(axis, along)
        else:
            axis = unit(along + 0.3 * rng.normal(size=3))
        link = a.hang(link, KIND[kind[0]], axis, foot)
        driven = f"q_{link}"
        along = unit(tip - at)
    first = unit(np.cross(along, rng.normal(size=3)))
    second = np.cross(along, first)
    if not a.tidy:
        first = unit(first + 0.2 * rng.normal(size=3))
        second = unit(second + 0.2 * rng.normal(size=3))
    link = a.hang(link, "revolute", first, at)
    link = a.hang(link, "revolute", second, at)
    if kind == "UPS":
        if not a.tidy:
            along = unit(along + 0.2 * rng.normal(size=3))  # a cylinder need not point at the ball
        link = a.hang(link, "prismatic", along, 0.5 * (at + tip))
        driven = f"q_{link}"
    a.tie(link, to, tip, "point")
    a.rank += 3
    return driven
