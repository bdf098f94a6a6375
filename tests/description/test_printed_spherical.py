"""Spherical loops of files with few digits: their axes are made to meet in one point."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from hybrid_dynamics_core import DescriptionError, Robot
from hybrid_dynamics_core.description.geometry import rotation_from_rpy, rpy_of, unit_axis
from hybrid_dynamics_core.description.model import RobotDescription
from hybrid_dynamics_core.ground.arrays import frozen
from tests.generated.assembly import BASE, Assembly, unit
from tests.generated.reframed import reframed
from tests.sampling import examples

CUTS = ("axis", "frame", "point")
SEEDS = st.integers(0, 10**4)


def spherical(cut: str, seed: int, loops: int = 1) -> RobotDescription:
    """A platform on a driven spherical crank, and legs of hinges that meet in the same centre."""
    a = Assembly(np.random.default_rng(seed))
    centre = a.rng.normal(size=3)

    def hung(parent: str, name: str) -> str:
        axis = unit(a.rng.normal(size=3))
        return a.hang(parent, "revolute", axis, centre + a.rng.normal() * axis, name=name)

    platform = hung(hung(BASE, "crank"), "platform")
    if loops == 2:
        platform = hung(platform, "wrist")
    for leg in range(loops):
        end = hung(BASE, f"lower_{leg}")
        axis = unit(a.rng.normal(size=3))
        if cut == "frame":
            end = a.hang(end, "revolute", axis, centre + a.rng.normal() * axis, name=f"upper_{leg}")
        place = centre + a.rng.uniform(0.3, 1.0) * axis
        a.tie(platform, end, place, cut, axis, name=f"cut_{leg}")
    return a.description(("q_crank",), platform)


def printed(robot: RobotDescription, digits: int) -> RobotDescription:
    """The robot as a file with so many decimals has it."""

    def numbers(values: np.ndarray) -> np.ndarray:
        return frozen(np.round(values, digits))

    def turned(rotation: np.ndarray) -> np.ndarray:
        return rotation_from_rpy(*np.round(rpy_of(rotation), digits))

    joints = {}
    for name, joint in robot.joints.items():
        joints[name] = replace(
            joint,
            rotation=turned(joint.rotation),
            translation=numbers(joint.translation),
            axis=unit_axis(np.round(joint.axis, digits).tolist()),
        )
    closures = []
    for closure in robot.closures:
        rounded = replace(
            closure,
            point_a=numbers(closure.point_a),
            point_b=numbers(closure.point_b),
            rotation_a=turned(closure.rotation_a),
            rotation_b=turned(closure.rotation_b),
        )
        closures.append(rounded)
    return replace(robot, joints=joints, closures=tuple(closures))


@examples(24)
@given(st.sampled_from(CUTS), SEEDS, SEEDS, st.sampled_from([5, 6, 8]), st.sampled_from([1, 2]))
def test_a_printed_spherical_loop_moves_as_the_exact_one(
    cut: str, seed: int, frames: int, digits: int, loops: int
) -> None:
    exact = Robot(spherical(cut, seed, loops))
    start = exact.close(exact.reference)
    assume(start.singularity > 0.1)
    description, zeros = reframed(exact.description, frames)
    rounded = Robot(printed(description, digits))
    shift = np.array([zeros[name] for name in exact.coordinates])
    u, ddu = exact.reference + 0.03, np.ones(1)
    state = exact.close(u, ddu, check=False)
    assume(state.status == 0 and state.singularity > 0.05)
    other = rounded.close(u - shift[:1], ddu)
    # a chain of up to six joints, each off by half a digit, with levers of up to some metres
    off = 100.0 * 10.0**-digits / float(state.singularity)
    np.testing.assert_allclose(other.s + shift, state.s, atol=off)
    efforts = exact.inverse_dynamics(state, ddu)
    scale = 1.0 + np.abs(efforts).max()
    np.testing.assert_allclose(rounded.inverse_dynamics(other, ddu), efforts, atol=10 * off * scale)
    noted = [note for note in rounded.description.notes if "moved by" in note]
    assert noted or digits == 8


@pytest.mark.parametrize("cut", CUTS)
def test_an_exact_one_is_not_changed(cut: str) -> None:
    robot = Robot(spherical(cut, 1))
    assert not robot.description.notes


def test_the_note_names_joint_and_distance() -> None:
    notes = Robot(printed(spherical("axis", 1), 5)).description.notes
    assert any("meet in one point" in note and "moved by" in note for note in notes)


def test_axes_that_miss_by_more_are_refused() -> None:
    with pytest.raises(DescriptionError, match=r"stay 0\.01\d* m"):
        Robot(printed(spherical("axis", 1), 2))
