"""Passages through change points and dead centres, as MuJoCo makes them with soft loops.

MuJoCo has all joints as coordinates, which are smooth at such places. Its ties are as stiff as the
step allows, so that half the step has less error.
"""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.closed_state.state import ClosedState
from hybrid_dynamics_core.ground.arrays import Array
from hybrid_dynamics_core.simulation import simulate
from tests.agreement.mujoco_model import MujocoRobot
from tests.simulation.test_passing import SliderCrank, general_row, started, through

STEP = 1e-4  # [s]
RATE = 50.0  # [1/s] samples that are compared


def moved_in_mujoco(machine: Robot, start: ClosedState, end: float) -> Array:
    """All coordinates (N, n_s) at the samples."""
    other = MujocoRobot(machine.description, machine.coordinates)
    model, data = other.model, other.data
    model.opt.timestep = STEP
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    model.eq_solref[:] = [2.0 * STEP, 1.0]
    model.eq_solimp[:, :3] = [0.9999, 0.9999, 0.001]
    other.place(start.s, start.ds)
    rows = [data.qpos.copy()]
    for _ in range(round(end * RATE)):
        mujoco.mj_step(model, data, round(1.0 / RATE / STEP))
        rows.append(data.qpos.copy())
    return np.array(rows)[:, other.index]


@pytest.mark.parametrize("count", [1, 2])
def test_folded_four_bars_go_on_alike(count: int) -> None:
    """All bars of the row lie in one line at the passage: each loop could cross there."""
    machine = general_row(count)
    start = machine.close([0.0], [-1.0])
    motion = simulate(
        machine, start, None, None, (0.0, 1.5), through(rtol=1e-10, atol=1e-12, rate=RATE)
    )
    assert any(event.passage is not None for event in motion.events)
    expected = moved_in_mujoco(machine, start, 1.5)
    # 8e-8 rad of two loops by their softness; on the other branch the bars differ by radians
    assert motion.state.s == pytest.approx(expected, abs=1e-6)


def test_a_flywheel_carries_a_slider_crank_through_its_dead_centres_alike() -> None:
    machine = SliderCrank().robot(0.7)
    start = started(machine, 9.0)
    motion = simulate(
        machine, start, None, None, (0.0, 1.2), through(rtol=1e-10, atol=1e-12, rate=RATE)
    )
    assert sum(event.passage is not None for event in motion.events) == 4
    # 1e-8 rad by the softness of the tie, 1e-9 at half the step
    assert motion.state.s == pytest.approx(moved_in_mujoco(machine, start, 1.2), abs=1e-6)
