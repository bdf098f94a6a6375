"""Recipes do what a designer would do by hand with the parts."""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core import load
from hybrid_dynamics_core.design import Duty, keep_regular, level_force
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
