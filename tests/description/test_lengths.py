"""Millimetres in place of metres are reported; large machines and shipped robots are not."""

from __future__ import annotations

import pytest

from hybrid_dynamics_core import load, shipped_robots
from tests.description.robots import HEAD, parse

ARM = (
    HEAD
    + """\
parameters: {length: LENGTH}
links:
  base: {}
  arm: {mass: 1, com: [length/2, 0, 0]}
  slide: {mass: 1}
joints:
  motor: {type: revolute, parent: base, child: arm, axis: z}
  out: {type: prismatic, parent: arm, child: slide, origin: {xyz: [length, 0, 0]}, axis: x}
active: [motor, out]
end_effector: {link: slide, xyz: [TIP, 0, 0]}
"""
)


def warnings(length: float, tip: float = 0.0) -> tuple[str, ...]:
    return parse(ARM.replace("LENGTH", str(length)).replace("TIP", str(tip))).warnings


def test_millimetres_are_reported_where_the_largest_length_stands() -> None:
    (reported,) = warnings(1200.0, 300.0)
    assert (
        reported
        == "small.yaml:11: joints.out.origin: 1200 m, and the robot reaches 1500 m from its base:"
        " are these millimetres? Lengths are in metres: 1200 mm are written 1.2"
    )
    assert warnings(200.0, 300.0)[0].startswith(
        "small.yaml:13: end_effector: 300 m, and the robot reaches 500 m"
    )


@pytest.mark.parametrize(("length", "tip"), [(0.2, 0.1), (100.0, 125.0), (200.0, 49.0)])
def test_large_machines_are_accepted(length: float, tip: float) -> None:
    """The longest machine on land, a bucket-wheel excavator, is 225 m long."""
    assert not warnings(length, tip)


@pytest.mark.parametrize("name", shipped_robots())
def test_no_shipped_robot_is_doubted(name: str) -> None:
    assert not load(name).description.warnings


@pytest.mark.parametrize(
    ("limits", "doubted"),
    [
        ("0, 150", True),
        ("-80, 0", True),
        ("0, 35", False),
        ("-1000, 1000", False),
        ("0, 0.5", False),
    ],
)
def test_strokes_in_millimetres_are_reported(limits: str, doubted: bool) -> None:
    """A robot of a metre has no stroke of forty; one on a long track has."""
    text = (
        ARM.replace("LENGTH", "0.5")
        .replace("TIP", "0.4")
        .replace("axis: x}", f"axis: x, limits: [{limits}]}}")
    )
    reported = parse(text).warnings
    assert bool(reported) == doubted
    if doubted:
        number = max(abs(float(end)) for end in limits.split(","))
        assert (
            f"joints.out.limits: {number:g} m, and the robot reaches 0.9 m from its base"
            in reported[0]
        )
        assert f"{number:g} mm are written {number / 1000.0:g}" in reported[0]
