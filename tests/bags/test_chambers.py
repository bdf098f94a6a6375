"""Pressure sensors on the wrong side are named, live and in recordings; loads are no reason."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import Payload, load
from hybrid_dynamics_ros.bags.analysis.collect import collect
from hybrid_dynamics_ros.bags.input_topic import INPUT
from hybrid_dynamics_ros.bags.job import Job
from hybrid_dynamics_ros.bags.process import process
from hybrid_dynamics_ros.bags.recorded_pressures import PRESSURE_INPUT
from hybrid_dynamics_ros.messages.interfaces import JOINT_STATE
from hybrid_dynamics_ros.messages.joint_samples import JointSample
from hybrid_dynamics_ros.messages.pressures import PRESSURES, PressureSample
from hybrid_dynamics_ros.stream.pipeline import Pipeline
from tests.bags.messages import START, joint_state
from tests.bags.test_pressures import CYLINDERS, pressures, swung, write
from tests.sampling import examples

STEP = 50_000_000  # [ns]
COUNT = 80
WORDS = ": pressures fit the motion better with cap and rod side exchanged"


@pytest.fixture(scope="module")
def excavator():
    return load("excavator")


def recorded(robot, mass, exchanged):
    """Stamps, u, u', cap and rod pressures of a motion with a load that nobody knows of."""
    time = np.arange(COUNT) * STEP * 1e-9
    u, du, ddu = swung(robot, time)
    state = robot.close(u, du)
    laden = robot.loads.with_payload(Payload(mass, [-0.6, 0.35, 0.0]))
    cylinders = robot.hydraulics(state, robot.inverse_dynamics(state, ddu, laden))
    cap = np.array([cylinders[name].cap_pressure for name in CYLINDERS]).T
    rod = np.array([cylinders[name].rod_pressure for name in CYLINDERS]).T
    for name in exchanged:
        k = CYLINDERS.index(name)
        cap[:, k], rod[:, k] = rod[:, k].copy(), cap[:, k].copy()
    return START + STEP * np.arange(COUNT), u, du, cap, rod


@given(
    mass=st.sampled_from([0.0, 900.0, 2000.0]),
    exchanged=st.lists(st.sampled_from(CYLINDERS), unique=True),
)
@examples(8)
def test_a_stream_names_the_cylinders_with_exchanged_chambers(excavator, mass, exchanged):
    pipeline = Pipeline(excavator, 10.0, 0.5)
    rows = zip(*recorded(excavator, mass, exchanged), strict=True)
    for stamp, u, du, cap, rod in rows:
        pipeline.pressures.take(PressureSample(int(stamp), CYLINDERS, cap, rod))
        pipeline.process(JointSample(int(stamp), excavator.active, u, du))
    named = [name for name in excavator.drives if name in exchanged]
    assert pipeline.chambers.problem == (f"{', '.join(named)}{WORDS}" if named else "")
    pipeline.chambers.clear()
    assert pipeline.chambers.problem == ""


@pytest.mark.parametrize("exchanged", [(), ("boom_cylinder",)])
def test_a_processed_bag_tells_it(excavator, exchanged, tmp_path: Path):
    entries = []
    for stamp, u, du, cap, rod in zip(*recorded(excavator, 900.0, exchanged), strict=True):
        data = pressures(int(stamp), CYLINDERS, cap, rod)
        entries.append((PRESSURE_INPUT, PRESSURES, int(stamp), data))
        data = joint_state(int(stamp), excavator.active, u, du)
        entries.append((INPUT, JOINT_STATE, int(stamp), data))
    outcome = process(Job(write(tmp_path / "in", entries), tmp_path / "out", "excavator"))
    told = [loss for loss in outcome.losses if WORDS in loss]
    assert told == [f"{name}{WORDS}" for name in exchanged]


def entries_of(excavator, exchanged, scale=1.0):
    entries = []
    for stamp, u, du, cap, rod in zip(*recorded(excavator, 900.0, exchanged), strict=True):
        data = pressures(int(stamp), CYLINDERS, scale * cap, scale * rod)
        entries.append((PRESSURE_INPUT, PRESSURES, int(stamp), data))
        data = joint_state(int(stamp), excavator.active, u, du)
        entries.append((INPUT, JOINT_STATE, int(stamp), data))
    return entries


@pytest.mark.parametrize("exchanged", [(), ("boom_cylinder", "stick_cylinder")])
def test_an_evaluated_bag_tells_it(excavator, exchanged, tmp_path: Path):
    bag = write(tmp_path / "in", entries_of(excavator, exchanged))
    losses = collect(bag, "excavator", None, "spline", None, 1000).losses
    assert losses == ([f"{', '.join(exchanged)}{WORDS}"] if exchanged else [])


def test_pressures_that_stay_above_the_supply_are_told_in_bags(excavator, tmp_path: Path):
    highest = recorded(excavator, 900.0, ())[3].max()
    scale = 450e5 / highest  # of a sensor with a wrong range
    bag = write(tmp_path / "in", entries_of(excavator, (), scale))
    words = "boom_cylinder: a measured pressure of 450 bar, 100 bar beyond its supply of 350 bar"
    losses = collect(bag, "excavator", None, "spline", None, 1000).losses
    assert words in losses
    outcome = process(Job(bag, tmp_path / "out", "excavator"))
    assert words in list(outcome.losses)


def test_a_stream_tells_pressures_that_stay_above_the_supply(excavator):
    supply = Pipeline(excavator, 10.0, 0.5).pressures.supply
    zeros = np.zeros(len(CYLINDERS))
    high = np.full(len(CYLINDERS), 400e5)
    for k in range(200):  # peaks at stops are no reason
        cap = high if k % 20 == 0 else zeros
        supply.take(PressureSample(START + STEP * k, CYLINDERS, cap, zeros))
    assert supply.problem == ""
    for k in range(100):
        supply.take(PressureSample(START + STEP * k, CYLINDERS, high, zeros))
    for name in CYLINDERS:
        assert f"{name}: a measured pressure of 400 bar, 50 bar beyond its supply" in supply.problem
    supply.clear()
    assert supply.problem == ""
