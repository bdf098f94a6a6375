"""Inverse kinematics in closed form of platforms whose frames and axes stand anywhere."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from hybrid_dynamics_core import IKStatus, Robot, load
from tests.core.test_closed_form_ik import WITH_PLATFORM
from tests.generated.reframed import reframed
from tests.mechanisms import JointRow, describe
from tests.sampling import examples, swept
from tests.strategies import positions


@pytest.mark.parametrize("name", swept(WITH_PLATFORM))
@examples(4)  # a robot of its own each, whose programs are traced
@given(data=st.data(), frames=st.integers(0, 10**6))
def test_it_does_not_depend_on_where_frames_stand(
    name: str, data: st.DataObject, frames: int
) -> None:
    robot = load(name)
    description, zeros = reframed(robot.description, frames)
    other = Robot(description)
    assert other.pose_chain is not None
    shift = np.array([zeros[name] for name in robot.active])
    u = robot.reference + 0.5 * (data.draw(positions(robot)) - robot.reference)
    state = other.close(u - shift, check=False)
    assume(state.status == 0 and state.singularity > 0.1)
    pose = other.forward_kinematics(state)
    result = other.inverse_kinematics(pose)
    assert (result.status, result.iterations) == (IKStatus.SOLVED, 0)
    reached = other.forward_kinematics(result.state)
    np.testing.assert_allclose(reached.position, pose.position, atol=1e-10)
    np.testing.assert_allclose(reached.rotation, pose.rotation, atol=1e-10)


@examples(36)
@given(slides=st.integers(0, 3), turns=st.integers(0, 3), seed=st.integers(0, 10**6))
def test_slides_and_turns_about_any_axes_that_meet(slides: int, turns: int, seed: int) -> None:
    """Axes at any angles to each other, which meet away from all origins."""
    assume(slides + turns > 0)
    rng = np.random.default_rng(seed)
    axes = [vector / np.linalg.norm(vector) for vector in rng.normal(size=(slides + turns, 3))]
    angles = np.array(axes)[slides:]
    if turns > 1:
        assume(np.linalg.svd(angles, compute_uv=False)[-1] > 0.3)
    if slides > 1:
        assume(np.linalg.svd(np.array(axes)[:slides], compute_uv=False)[-1] > 0.3)
    centre = rng.normal(size=3)
    rows: list[JointRow] = []
    parent, last = "base", np.zeros(3)
    for k, axis in enumerate(axes):
        kind = "prismatic" if k < slides else "revolute"
        place = rng.normal(size=3) if k < slides else centre + rng.normal() * axis
        rows.append((f"j{k}", kind, parent, f"l{k}", tuple(place - last), axis.tolist()))
        parent, last = f"l{k}", place
    names = [f"j{k}" for k in range(slides + turns)]
    machine = Robot(describe(f"chain{seed}", rows, [], names, {}))
    assert machine.pose_chain is not None
    u = rng.uniform(-0.8, 0.8, slides + turns)
    pose = machine.forward_kinematics(machine.close(u))
    result = machine.inverse_kinematics(pose)
    assert (result.status, result.iterations) == (IKStatus.SOLVED, 0)
    reached = machine.forward_kinematics(result.state)
    np.testing.assert_allclose(reached.position, pose.position, atol=1e-9)
    np.testing.assert_allclose(reached.rotation, pose.rotation, atol=1e-9)
