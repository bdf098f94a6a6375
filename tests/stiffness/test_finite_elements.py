"""Every shipped robot with elastic drives, pins and links, against finite elements."""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core import Robot, load, shipped_robots
from hybrid_dynamics_core.stiffness import Beam, Bearing, Elasticity, Section
from tests.sampling import swept
from tests.stiffness.finite_elements import Model

NAMES = shipped_robots()
SAMPLE = ("delta", "excavator", "type_c")
HINGED = ("excavator", "palletizer", "forging_chu2020", "five_bar")
# relative: beams of finite elements are 1e6 as stiff along as across, and ties are multipliers, so
# that half of 16 digits and more are lost
CLOSE = 1e-5


def elasticity_of(robot: Robot, seed: int, *, hinges: bool = False) -> Elasticity:
    """Random drives, pins, and a beam for each link that has a length.

    Args:
        robot: the robot.
        seed: of the random numbers.
        hinges: whether pins of planar loops hold all that a hinge holds.
    """
    rng = np.random.default_rng(seed)
    description = robot.description
    drives = {name: 10 ** rng.uniform(6, 8) for name in robot.all_drives}
    pins = {}
    for closure in description.closures:
        rigid = {"axial": np.inf, "tilt": np.inf} if hinges else {}
        pins[closure.name] = Bearing(radial=10 ** rng.uniform(7, 9), **rigid)
    for name in list(description.joints)[::2]:
        if description.joints[name].type == "revolute":
            pins[name] = Bearing(radial=10 ** rng.uniform(7, 9), tilt=10 ** rng.uniform(6, 8))
    links = {}
    for name in description.links:
        ends = [j.translation for j in description.joints.values() if j.parent == name]
        ends += [f.translation for c in description.closures for f in c.frames() if f.link == name]
        ends += [f.translation for f in description.frames.values() if f.link == name]
        tip = max(ends, key=np.linalg.norm, default=np.zeros(3))
        if np.linalg.norm(tip) > 0.01:
            a, iy, iz, j = 10 ** rng.uniform((-3, -6, -6, -6), (-2, -4, -4, -4))
            links[name] = Beam(210e9, 81e9, Section(a, iy, iz, j), tip, z=rng.normal(size=3))
    return Elasticity(drives, pins, links)


def states_of(robot: Robot, seed: int):
    """The reference and a state near it that closes."""
    rng = np.random.default_rng(seed)
    yield robot.close(robot.reference)
    for _ in range(20):
        state = robot.close(
            robot.reference + 0.05 * rng.normal(size=len(robot.active)), check=False
        )
        if state.status == 0:
            yield state
            return


def difference(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.abs(one - other).max() / np.abs(other).max())


@pytest.mark.parametrize("name", swept(NAMES, SAMPLE))
def test_compliance_is_that_of_finite_elements(name):
    robot = load(name)
    for state in states_of(robot, 1):
        elasticity = elasticity_of(robot, 2)
        expected = Model(robot, state, elasticity).compliance()
        assert difference(robot.stiffness(state, elasticity).compliance, expected) < CLOSE


@pytest.mark.parametrize("name", swept(HINGED, ["excavator"]))
def test_hinges_of_planar_loops_share_loads_by_compliance(name):
    """Five directions each: more than the loops need, so that statics leaves forces open."""
    robot = load(name)
    state = robot.close(robot.reference)
    elasticity = elasticity_of(robot, 3, hinges=True)
    expected = Model(robot, state, elasticity).compliance()
    assert difference(robot.stiffness(state, elasticity).compliance, expected) < CLOSE


@pytest.mark.parametrize("name", swept([name for name in NAMES if name != "staicu2015"], SAMPLE))
def test_frequencies_are_those_of_finite_elements(name):
    robot = load(name)
    state = robot.close(robot.reference)
    elasticity = elasticity_of(robot, 4)
    expected = Model(robot, state, elasticity).frequencies()
    frequencies = robot.stiffness(state, elasticity).modes().frequencies
    count = min(12, len(expected), len(frequencies))
    np.testing.assert_allclose(frequencies[:count], expected[:count], rtol=1e-5)
