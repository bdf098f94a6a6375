"""Recipes do what a designer would do by hand with the parts."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from hybrid_dynamics_core import InputError, Robot, load
from hybrid_dynamics_core.design import (
    Design,
    Duty,
    keep_regular,
    level_force,
    ranged,
    swept_measure,
    widest_workspace,
)
from hybrid_dynamics_core.design.recipes import unevenness
from hybrid_dynamics_core.kernels.run import VARIABLE


@pytest.fixture(autouse=True, scope="module")
def _without_compiler() -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(VARIABLE, "python")
        yield


def test_a_level_force_is_level_within_the_stroke() -> None:
    robot = load("excavator")
    pins = {
        "loops.boom_loop.pin.boom[0]": (1.6, 3.2),
        "joints.boom_barrel_pitch.origin.xyz[2]": (0.9, 1.6),
    }
    swing = [Duty({"boom_pitch": angle}) for angle in np.linspace(-0.3, 0.8, 5)]
    given = ("slew", "boom_pitch", "stick_cylinder", "bucket_cylinder")
    design, result = level_force(robot, "boom_cylinder", pins, swing, given)
    assert result.feasible
    assert result.objective < 0.5 * float(unevenness(design.cycle(), "boom_cylinder").value)
    lower, upper = robot.description.joints["boom_cylinder"].limits
    strokes = design.cycle(list(result.values.values())).coordinate("boom_cylinder").value
    assert lower - 1e-6 <= strokes.min() <= strokes.max() <= upper + 1e-6


def test_singular_places_stay_away_from_a_workspace() -> None:
    """The least distance grows, and the new robot has it where the drives close it."""
    robot = load("delta")
    variables = {
        "modules.delta.parameters.arm": (0.2, 0.4),
        "modules.delta.parameters.base_radius": (0.1, 0.4),
    }
    corners = [{"x": x, "y": y, "z": 0.0, "q4": 0.0} for x in (-0.2, 0.2) for y in (-0.2, 0.2)]
    places = [Duty(corner) for corner in corners]
    design, result = keep_regular(robot, variables, places, given=("x", "y", "z", "q4"))
    before = float(design.cycle().distance().value.min())
    assert -result.objective > before + 0.1
    distances: list[float] = []
    for corner in corners:
        pose = result.robot.close_given(corner)
        distances.append(float(result.robot.close(pose.u).distances.min()))
    assert min(distances) == pytest.approx(-result.objective, rel=1e-6)


TWO_BARS = """
format: 1
name: two_bars
active: [a, b]
parameters: {L: 1.0, upper: 0.7}
base: ground
links: {ground: {}, arm: {mass: 1.0}, forearm: {mass: 1.0}}
joints:
  a: {type: revolute, parent: ground, child: arm, axis: [0, 0, 1]}
  b: {type: revolute, parent: arm, child: forearm, axis: [0, 0, 1], origin: {xyz: [upper, 0, 0]}}
end_effector: {link: forearm, xyz: [L - upper, 0, 0]}
"""
TURNS = {"a": (-1.0, 1.0), "b": (0.2, 2.5)}


def test_the_widest_workspace_of_two_bars_has_equal_bars(tmp_path: Path) -> None:
    """It sweeps l1 l2 times an integral of sin b, and l1 + l2 is given; by hand."""
    path = tmp_path / "two_bars.yaml"
    path.write_text(TWO_BARS, encoding="utf-8")
    robot = load(str(path))
    design, result = widest_workspace(robot, {"upper": (0.2, 0.9)}, TURNS, ("x", "y"))
    by_hand = 2.0 * (np.cos(0.2) - np.cos(2.5))
    before = swept_measure(design.cycle(), list(TURNS), ("x", "y"))
    assert float(before.value) == pytest.approx(0.7 * 0.3 * by_hand, rel=1e-9)
    assert float(before.slope[0]) == pytest.approx((1.0 - 2 * 0.7) * by_hand, rel=1e-9)
    assert result.values["upper"] == pytest.approx(0.5, abs=1e-4)
    assert -result.objective == pytest.approx(0.25 * by_hand, rel=1e-6)


def test_the_area_that_cylinders_sweep_is_that_of_the_outline() -> None:
    """Boom and stick of the excavator: the area within the way round the rectangle of strokes."""
    robot = load("excavator")
    strokes = {"boom_cylinder": (0.5, 0.9), "stick_cylinder": (0.5, 0.9)}
    design = Design(robot, {"links.boom.mass": (100.0, 5000.0)}, ranged(strokes))
    measure = swept_measure(design.cycle(), list(strokes), ("x", "z"))
    assert float(measure.value) == pytest.approx(area_within(robot, strokes), rel=1e-5)


def area_within(robot: Robot, strokes: dict[str, tuple[float, float]]) -> float:
    """Area of the polygon of tool places, as the corners of a rectangle are passed."""
    (a, b), (c, d) = strokes.values()
    corners = [(a, c), (b, c), (b, d), (a, d), (a, c)]
    ways = [np.linspace(p, q, 400) for p, q in pairwise(corners)]
    rows = np.concatenate(ways)
    u = np.tile(robot.reference, (len(rows), 1))
    for name, values in zip(strokes, rows.T, strict=True):
        u[:, robot.active.index(name)] = values
    x, _, z = robot.forward_kinematics(robot.close(u)).position.T
    return abs(0.5 * float(np.sum(x[:-1] * z[1:] - x[1:] * z[:-1])))


def test_ranges_and_directions_are_checked() -> None:
    robot = load("excavator")
    with pytest.raises(InputError, match="boom_cylinder: the range is"):
        ranged({"boom_cylinder": (0.9, 0.5)})
    cycle = Design(robot, {"links.boom.mass": (100.0, 5000.0)}, [Duty({})]).cycle()
    with pytest.raises(InputError, match="direction"):
        cycle.manipulability(axes=("x", "u"))
