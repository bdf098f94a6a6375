"""Small mechanisms of every kind of closure, with random inertias.

The laws hold on them as on the shipped robots.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from types import MappingProxyType

import numpy as np

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.description.geometry import rotation_from_rpy, unit_axis
from hybrid_dynamics_core.description.model import Closure, Frame, Joint, Link, RobotDescription
from hybrid_dynamics_core.ground.arrays import frozen

# Name, type, parent, child, xyz, axis.
JointRow = tuple[str, str, str, str, Sequence[float], str | list[float]]


def random_link(name: str, rng: np.random.Generator, size: float = 0.3) -> Link:
    """A link of 1 to 6 kg with a valid inertia."""
    mass = float(rng.uniform(1.0, 6.0))
    com = rng.uniform(-size, size, 3)
    points = rng.uniform(-size, size, (6, 3))
    points -= points.mean(axis=0)
    moments = points.T @ points / 6.0 * mass
    inertia = np.trace(moments) * np.eye(3) - moments
    return Link(name, mass, frozen(com), frozen(inertia))


def describe(
    name: str,
    rows: Sequence[JointRow],
    closures: Sequence[Closure],
    active: Sequence[str],
    reference: dict[str, float],
    massless: Sequence[str] = (),
) -> RobotDescription:
    """A description with random masses; the end effector on the last link."""
    rng = np.random.default_rng(sum(map(ord, name)))
    rotation = frozen(np.eye(3))
    joints = {}
    links = {}
    for joint, kind, parent, child, xyz, axis in rows:
        origin = frozen(xyz)
        joints[joint] = Joint(joint, kind, parent, child, rotation, origin, unit_axis(axis))
        links[child] = random_link(child, rng)
        if child in massless:
            links[child] = Link(child)
    last = rows[-1][3]
    tip = Frame(last, rotation_from_rpy(0.3, -0.4, 0.5), frozen([0.1, 0.05, -0.2]))
    return RobotDescription(
        name=name,
        source="generated",
        gravity=frozen([0.3, -0.5, -9.7]),
        base="base",
        links=MappingProxyType(links),
        joints=MappingProxyType(joints),
        closures=tuple(closures),
        loops=MappingProxyType({}),
        active=tuple(active),
        end_effector="end_effector",
        frames=MappingProxyType({"end_effector": tip}),
        reference=reference,
    )


def _serial() -> RobotDescription:
    rows: list[JointRow] = [
        ("a", "revolute", "base", "l1", (0, 0, 0.2), "z"),
        ("b", "revolute", "l1", "l2", (0.1, 0, 0.3), [0.2, 1, 0.1]),
        ("c", "prismatic", "l2", "l3", (0.2, 0.1, 0), [1, 0, 0.3]),
        ("d", "revolute", "l3", "l4", (0.3, 0, 0.1), "x"),
    ]
    return describe(
        "serial", rows, [], ["a", "b", "c", "d"], {"a": 0.3, "b": 0.4, "c": 0.1, "d": -0.2}
    )


def _two_cranks() -> RobotDescription:
    rows: list[JointRow] = [
        ("a", "revolute", "base", "l1", (0, 0, 0), "y"),
        ("b", "revolute", "l1", "l2", (0.4, 0, 0), "y"),
        ("c", "revolute", "base", "l3", (0.5, 0, 0), "-y"),
        ("d", "revolute", "l3", "l4", (0.4, 0, 0), "y"),
    ]
    pin = Closure(
        "pin", "l2", frozen([0.6, 0, 0]), "l4", frozen([0.6, 0, 0]), assembly="counterclockwise"
    )
    return describe("two_cranks", rows, [pin], ["a", "c"], {"a": -1.9, "c": 1.2})


def _slider_crank() -> RobotDescription:
    """On a turntable, so that the loop's plane turns."""
    rows: list[JointRow] = [
        ("t", "revolute", "base", "table", (0, 0, 0.1), "z"),
        ("a", "revolute", "table", "crank", (0.1, 0, 0), "y"),
        ("b", "revolute", "crank", "rod", (0.2, 0, 0), "y"),
        ("s", "prismatic", "table", "slide", (0.3, 0, 0.05), "x"),
    ]
    pin = Closure(
        "pin", "rod", frozen([0.5, 0, 0]), "slide", frozen([0, 0, 0]), assembly="extended"
    )
    return describe("slider_crank", rows, [pin], ["t", "a"], {"a": 0.6})


def _three_rrr() -> RobotDescription:
    """Planar platform on three legs: an irreducible block of four."""
    rows: list[JointRow] = []
    closures = []
    for k, angle in enumerate((0.0, 2 * math.pi / 3, 4 * math.pi / 3), start=1):
        foot = (0.5 * math.cos(angle), 0.5 * math.sin(angle), 0)
        rows += [
            (f"a{k}", "revolute", "base", f"lower{k}", foot, "z"),
            (f"b{k}", "revolute", f"lower{k}", f"upper{k}", (0.3, 0, 0), "z"),
        ]
        if k == 1:
            rows.append(("c", "revolute", "upper1", "platform", (0.3, 0, 0), "z"))
        else:
            corner = frozen([0.15 * (math.cos(angle) - 1.0), 0.15 * math.sin(angle), 0])
            closures.append(
                Closure(f"leg{k}", f"upper{k}", frozen([0.3, 0, 0]), "platform", corner)
            )
    reference = {"a1": 2.2, "b1": 1.3, "c": -3.5, "a2": 4.29, "b2": 1.3, "a3": 6.39, "b3": 1.3}
    return describe("three_rrr", rows, closures, ["a1", "a2", "a3"], reference)


def _rssr() -> RobotDescription:
    """A spatial four-bar: a rod on a universal joint, its end on a ball joint."""
    rows: list[JointRow] = [
        ("a", "revolute", "base", "crank", (0, 0, 0), "z"),
        ("p", "revolute", "crank", "cross", (0.2, 0, 0), "z"),
        ("q", "revolute", "cross", "rod", (0, 0, 0), "y"),
        ("r", "revolute", "base", "rocker", (0.6, 0.1, 0.3), "x"),
    ]
    ball = Closure("ball", "rod", frozen([0.6, 0, 0.1]), "rocker", frozen([0, 0.35, 0]), "point")
    return describe(
        "rssr", rows, [ball], ["a"], {"a": 0.4, "p": -0.2, "q": -0.3, "r": 0.2}, massless=["cross"]
    )


def _seven_bar() -> RobotDescription:
    """One chain of seven turning joints, welded to the base: a Newton block of six."""
    axes = ["z", [0.1, 1, 0.2], [1, 0.2, 0.1], "z", [0.2, 1, 0.3], [1, 0.1, 0.4], [0.1, 0.9, 1]]
    places = [
        (0, 0, 0),
        (0.3, 0, 0.1),
        (0.3, 0.1, 0),
        (0.2, 0.3, 0),
        (0, 0.3, 0.1),
        (-0.3, 0.2, 0),
        (-0.3, 0, 0.1),
    ]
    rows: list[JointRow] = []
    parent = "base"
    for k, (axis, place) in enumerate(zip(axes, places, strict=True)):
        rows.append((f"q{k}", "revolute", parent, f"l{k}", place, axis))
        parent = f"l{k}"
    end = frozen(np.sum([*places, (-0.1, 0.1, 0.05)], axis=0))
    weld = Closure("weld", "l6", frozen([-0.1, 0.1, 0.05]), "base", end, "frame")
    return describe("seven_bar", rows, [weld], ["q0"], {})


def _welded_five_bar() -> RobotDescription:
    """A planar loop closed by a whole frame: more equations than it needs."""
    rows: list[JointRow] = [
        ("a", "revolute", "base", "l1", (0, 0, 0), "z"),
        ("b", "revolute", "l1", "l2", (0.5, 0, 0), "z"),
        ("c", "revolute", "l2", "l3", (0.6, 0, 0), "z"),
        ("d", "revolute", "base", "l4", (0.7, 0, 0), "z"),
    ]
    pin = Closure("axle", "l3", frozen([0.3, 0, 0]), "l4", frozen([0.4, 0, 0]), "frame")
    return describe("welded", rows, [pin], ["a"], {"a": 0.9, "b": -0.6, "c": -1.2, "d": -0.9})


def _parallelogram() -> RobotDescription:
    """A four-bar of equal opposite bars with a dyad: regular where its bars are in line."""
    rows: list[JointRow] = [
        ("a", "revolute", "base", "crank", (0, 0, 0), "z"),
        ("b", "revolute", "crank", "coupler", (0.4, 0, 0), "z"),
        ("c", "revolute", "base", "rocker", (0.5, 0, 0), "z"),
        ("d", "revolute", "coupler", "arm", (0.25, 0.1, 0), "x"),
    ]
    pin = Closure(
        "pin",
        "coupler",
        frozen([0.5, 0, 0]),
        "rocker",
        frozen([0.4, 0, 0]),
        assembly="parallelogram",
    )
    return describe("parallelogram", rows, [pin], ["a", "d"], {"a": 1.0, "b": -1.0, "c": 1.0})


_MAKERS = {
    "serial": _serial,
    "two_cranks": _two_cranks,
    "slider_crank": _slider_crank,
    "three_rrr": _three_rrr,
    "rssr": _rssr,
    "seven_bar": _seven_bar,
    "welded": _welded_five_bar,
    "parallelogram": _parallelogram,
}
MECHANISMS = tuple(_MAKERS)


@cache
def mechanism(name: str) -> Robot:
    """A mechanism by name."""
    return Robot(_MAKERS[name]())


def with_masses(robot: Robot) -> Robot:
    """The robot with links of random inertia."""
    rng = np.random.default_rng(7)
    links = {name: random_link(name, rng, 0.1) for name in robot.description.links}
    return changed(robot, links=MappingProxyType(links))


def changed(robot: Robot, **changes: object) -> Robot:
    """The robot with other entries of its description."""
    return Robot(replace(robot.description, **changes))  # type: ignore[arg-type]
