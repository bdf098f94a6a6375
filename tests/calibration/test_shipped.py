"""Every shipped robot: derivatives of its closed states, and simulated measurements."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.calibration.accuracy import apart
from benchmarks.calibration.simulated import FREE, NOISE, TURN, measured, poses
from hybrid_dynamics_core.calibration import calibrate
from hybrid_dynamics_core.calibration.adjustable import AdjustableRobot
from hybrid_dynamics_core.calibration.free_robot import FreeRobot
from hybrid_dynamics_core.calibration.observations import observe
from hybrid_dynamics_core.calibration.sensitivity import Sensitivity
from hybrid_dynamics_core.formats.tables import table_of
from hybrid_dynamics_core.robot.robot import Robot
from tests.sampling import swept

SAMPLE = ("five_bar",)
pytestmark = pytest.mark.usefixtures("without_compiler")
SIGMA = {"m": NOISE, "rad": TURN}
STEP = 1e-5  # [m or rad]


@pytest.fixture
def without_compiler(monkeypatch):
    """Robots that are closed a few times only need no compiled code."""
    monkeypatch.setenv("HYBRID_DYNAMICS_KERNELS", "python")


@pytest.mark.parametrize("name", swept(FREE, SAMPLE))
def test_the_estimate_is_the_machine(name):
    rng = np.random.default_rng(5)
    data = measured(name, rng, 30)
    result = calibrate(name, data.columns, FREE[name], SIGMA)
    for one, truth in zip(result.parameters.values(), data.truth, strict=True):
        assert one.identifiable
        assert abs(one.value - truth) < 5.0 * one.deviation
    assert 0.5 < result.chi2 < 1.6
    u = poses(data.nominal, rng, 20)
    # 20 poses times three of noise, shared by the parameters
    assert apart(Robot(result.description), data.true, u) < 2.0 * NOISE


@pytest.mark.parametrize("name", swept(FREE, SAMPLE))
def test_derivatives_are_those_of_the_closed_robot(name):
    rng = np.random.default_rng(6)
    data = measured(name, rng, 5)
    adjustable = AdjustableRobot(name)
    free_robot = FreeRobot(adjustable, adjustable.parameters(FREE[name].split(",")))
    observations = observe(free_robot, table_of(data.columns))
    sensitivity = Sensitivity(free_robot, observations)
    jacobian = sensitivity.jacobian(sensitivity.at_start()) * sensitivity.scales
    u = observations.readings
    for k in range(len(free_robot.parameters)):
        ends = []
        for sign in (1.0, -1.0):
            values = free_robot.start.copy()
            values[k] += sign * STEP
            robot = Robot(adjustable.described(free_robot.parameters, values))
            ends.append(robot.forward_kinematics(robot.close(u)).position)
        expected = (ends[0] - ends[1]) / (2.0 * STEP)
        # errors of central differences, by third derivatives of the order of 1 / size^2
        assert np.abs(jacobian[:, :3, k] - expected).max() < 1e-6 * max(1.0, np.abs(expected).max())
