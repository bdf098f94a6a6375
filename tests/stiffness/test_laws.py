"""Laws of elastic structures, on robots nobody has seen.

Tolerances: statics through loops is good to 1e-13 over the square of their margin (at least 0.01),
so 1e-8 of the largest entry.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given

from hybrid_dynamics_core import Payload, Robot, SingularityError, load
from hybrid_dynamics_core.stiffness import DriveStiffness, Elasticity, Stiffness
from tests.agreement.mujoco_model import MujocoRobot
from tests.generated.case import Case
from tests.generated.class_three import FourBar, Plan, build, built
from tests.generated.robots import STATES, examples, robots
from tests.sampling import swept
from tests.stiffness.test_finite_elements import elasticity_of

SAME = 1e-8
DRIVEN = ("excavator", "palletizer", "forging_chu2020", "delta", "gough")
TOOL = "end_effector"


def at(case: Case, seed: int, elasticity: Elasticity, frame: str = TOOL) -> Stiffness:
    state = case.robot.close(case.somewhere(seed)[: case.n])
    return case.robot.stiffness(state, elasticity, frame)


def size(matrix: np.ndarray) -> float:
    return float(np.abs(matrix).max())


def harder(elasticity: Elasticity, factor: float) -> Elasticity:
    """Everything stiffer by a factor."""
    drives = {n: factor * elasticity.drive(n).stiffness for n in elasticity.drives}
    pins = {}
    for name, bearing in elasticity.pins.items():
        tilt = None if bearing.tilt is None else factor * bearing.tilt
        pins[name] = replace(bearing, radial=factor * bearing.radial, tilt=tilt)
    links = {n: replace(b, E=factor * b.E, G=factor * b.G) for n, b in elasticity.links.items()}
    return Elasticity(drives, pins, links)


@examples(12)
@given(robots(), STATES)
def test_energy_shares_and_reciprocity(case: Case, seed: int) -> None:
    stiffness = at(case, seed, elasticity_of(case.robot, seed))
    compliance = stiffness.compliance
    assert np.array_equal(compliance, compliance.T)
    assert np.linalg.eigvalsh(compliance).min() >= -SAME * size(compliance)
    shares = sum(stiffness.shares.values())
    np.testing.assert_allclose(shares, compliance, atol=1e-14 * size(compliance))
    wrench = np.random.default_rng(seed).normal(size=6)
    under = stiffness.under(wrench)
    assert under.energy == pytest.approx(0.5 * wrench @ compliance @ wrench, rel=1e-12)
    assert sum(under.energy_by_element.values()) == pytest.approx(under.energy, rel=1e-12)
    np.testing.assert_allclose(sum(under.by_element.values()), under.displacement, atol=1e-18)


@examples(8)
@given(robots(), STATES)
def test_maxwell_and_betti(case: Case, seed: int) -> None:
    """What a force at one place does at another, the same force there does here."""
    robot, elasticity = case.robot, elasticity_of(case.robot, seed)
    other = [name for name in robot.description.links if name != robot.description.base][-1]
    here, there = at(case, seed, elasticity), at(case, seed, elasticity, other)
    none = robot.loads.with_gravity(np.zeros(3)).with_effects(
        stiffness=np.zeros(len(robot.coordinates)), preload=np.zeros(len(robot.coordinates))
    )
    none = replace(none, payloads={})
    one, two = np.random.default_rng(seed).normal(size=(2, 6))
    moved = there.deflection(none.with_wrench(one, TOOL)).displacement
    back = here.deflection(none.with_wrench(two, other)).displacement
    largest = max(size(here.compliance), size(there.compliance))
    assert two @ moved == pytest.approx(one @ back, abs=SAME * largest)


@examples(8)
@given(robots(), STATES)
def test_what_is_stiffer_never_gives_more(case: Case, seed: int) -> None:
    elasticity = elasticity_of(case.robot, seed)
    compliance = at(case, seed, elasticity).compliance
    name = sorted(elasticity.drives)[seed % len(elasticity.drives)]
    drives = {**elasticity.drives, name: DriveStiffness(3.0 * elasticity.drive(name).stiffness)}
    for other in (
        Elasticity(drives, elasticity.pins, elasticity.links),
        Elasticity({**drives, name: np.inf}, elasticity.pins, elasticity.links),
        Elasticity(elasticity.drives, elasticity.pins),
        Elasticity(elasticity.drives, {}, elasticity.links),
    ):
        relieved = compliance - at(case, seed, other).compliance
        assert np.linalg.eigvalsh(relieved).min() >= -SAME * size(compliance)


@examples(6)
@given(robots(), STATES)
def test_the_rigid_limit_is_reached_in_proportion(case: Case, seed: int) -> None:
    elasticity = elasticity_of(case.robot, seed)
    compliance = at(case, seed, elasticity).compliance
    far = at(case, seed, harder(elasticity, 1e9)).compliance
    np.testing.assert_allclose(1e9 * far, compliance, atol=SAME * size(compliance))
    rigid = Elasticity(dict.fromkeys(case.robot.all_drives, np.inf))
    stiffness = at(case, seed, rigid)
    assert size(stiffness.compliance) == 0.0
    assert len(stiffness.rigid_directions) == 6
    assert stiffness.stiffness_along([0, 0, 1]) == np.inf
    with pytest.raises(SingularityError, match="rigid in 6 of 6 directions"):
        _ = stiffness.stiffness


@examples(6)
@given(robots(), STATES)
def test_frames_of_a_rigid_link_see_one_compliance(case: Case, seed: int) -> None:
    see_one_compliance(case, seed)


def test_an_equation_of_springs_alone_is_none_of_joints() -> None:
    """Its row of the joints is rounding, here 1e-17 of the others, and has no direction."""
    loops = FourBar("D", "RRR", parallelogram=True), FourBar("B", "RPR", parallelogram=False)
    pair = "pair", 53, FourBar("A", "RRR", parallelogram=True)
    span = "span", 37, FourBar("A", "RRR", parallelogram=False)
    see_one_compliance(built(build(Plan(loops, (pair, span), True, 2615))), 69)


def see_one_compliance(case: Case, seed: int) -> None:
    """C_b = X C_a X^T, X = [1, -[r]; 0, 1] with the arm r from a to b."""
    robot = case.robot
    elasticity = elasticity_of(robot, seed)
    frame = robot.description.frames[TOOL]
    links = {n: beam for n, beam in elasticity.links.items() if n != frame.link}
    elasticity = Elasticity(elasticity.drives, elasticity.pins, links)
    a, b = at(case, seed, elasticity, frame.link), at(case, seed, elasticity)
    state = robot.close(case.somewhere(seed)[: case.n])
    ends = [robot.forward_kinematics(state, name).position for name in (frame.link, TOOL)]
    x, y, z = ends[1] - ends[0]
    moved = np.eye(6)
    moved[:3, 3:] = -np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    expected = moved @ a.compliance @ moved.T
    np.testing.assert_allclose(b.compliance, expected, atol=SAME * size(expected))


@examples(6)
@given(robots(), STATES)
def test_modes_are_orthogonal_and_rayleigh_bounds_the_lowest(case: Case, seed: int) -> None:
    robot, elasticity = case.robot, elasticity_of(case.robot, seed)
    stiffness = at(case, seed, Elasticity(elasticity.drives, elasticity.pins))  # rigid links
    loads = replace(robot.loads, payloads={})
    armature = np.zeros(len(robot.coordinates))
    loads = loads.with_effects(armature=armature)
    modes = stiffness.modes(loads)
    state = robot.close(case.somewhere(seed)[: case.n])

    def mass(one: dict, other: dict) -> np.ndarray:
        return sum(kinetic(robot, state, n, one[n], other[n]) for n in robot.description.links)

    products = mass(modes.links, modes.links)
    np.testing.assert_allclose(products, np.eye(len(products)), atol=1e-6)
    sag = stiffness.deflection(loads)
    shape = {name: moved[None] for name, moved in sag.links.items()}
    moving = mass(shape, shape)[0, 0]
    if moving > 0.0:
        rayleigh = np.sqrt(2.0 * sag.energy / moving) / (2 * np.pi)
        assert modes.frequencies[0] <= rayleigh * (1 + 1e-6)
    heavier = stiffness.modes(loads.with_payload(Payload(5.0)))
    count = min(len(heavier.frequencies), len(modes.frequencies))
    assert (heavier.frequencies[:count] <= modes.frequencies[:count] * (1 + 1e-6)).all()
    for shares in zip(*modes.energy_by_element.values(), strict=True):
        assert sum(shares) == pytest.approx(1.0, abs=1e-9)


def kinetic(robot: Robot, state, name: str, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Products (k, m) of displacements (k, 6) and (m, 6) of a link by its mass matrix."""
    link = robot.description.links[name]
    if name == robot.description.base:
        return np.zeros((len(one), len(other)))
    rotation = robot.forward_kinematics(state, name).rotation
    arm = rotation @ link.com
    at_com = [d[:, :3] + np.cross(d[:, 3:], arm) for d in (one, other)]
    inertia = rotation @ link.inertia @ rotation.T
    return link.mass * at_com[0] @ at_com[1].T + one[:, 3:] @ inertia @ other[:, 3:].T


@pytest.mark.parametrize("name", swept(DRIVEN, ["excavator", "gough"]))
def test_frequencies_on_drives_are_those_of_mujoco(name):
    """M of its tree and R of its equality constraints, against springs on drives."""
    robot = load(name)
    drives = {q: 10.0 ** (5 + k % 3) for k, q in enumerate(robot.all_drives)}
    state = robot.close(robot.reference)
    engine = MujocoRobot(robot.description, robot.coordinates)
    count, zero = len(robot.coordinates), np.zeros(len(robot.coordinates))
    still = engine.tree_forces(state.s, zero, zero)
    mass = np.column_stack([engine.tree_forces(state.s, zero, e) - still for e in np.eye(count)])
    rates = engine.velocity_map(state.s, len(robot.active))
    rows = [robot.coordinates.index(q) for q in drives]
    along = rates[rows]
    springs = along.T @ np.diag(list(drives.values())) @ along
    squares = np.linalg.eigvals(np.linalg.solve(rates.T @ mass @ rates, springs))
    expected = np.sort(np.sqrt(squares.real)) / (2 * np.pi)
    loads = replace(robot.loads.with_effects(armature=zero), payloads={})
    modes = robot.stiffness(state, Elasticity(drives)).modes(loads)
    np.testing.assert_allclose(modes.frequencies, expected, rtol=1e-5)  # its links of 1e-12 kg


@pytest.mark.parametrize("name", swept(["excavator", "delta", "five_bar"], ["excavator"]))
def test_small_loads_move_the_real_machine_so(name):
    """Drives on springs, loops closed at their new place: the error falls with the load."""
    robot = load(name)
    stiffness = 1e7
    state = robot.close(robot.reference)
    elastic = robot.stiffness(state, Elasticity(dict.fromkeys(robot.all_drives, stiffness)))
    errors = []
    for share in (1e-2, 1e-3):
        loads = robot.loads.with_gravity(share * np.array([3.0, 2.0, -9.0]))
        loads = loads.with_wrench(share * np.array([80.0, 50.0, -90.0, 9.0, 5.0, 4.0]))
        u = robot.reference.copy()
        for _ in range(50):
            needed = robot.inverse_dynamics(robot.close(u), np.zeros(len(u)), loads)
            u = robot.reference - needed / stiffness
        place = robot.forward_kinematics(robot.close(u)).position
        moved = place - robot.forward_kinematics(state).position
        expected = elastic.deflection(loads).displacement[:3]
        errors.append(np.linalg.norm(moved - expected) / np.linalg.norm(expected))
    assert errors[1] < 0.2 * errors[0] or errors[1] < 1e-6  # of 1e-9 m


@examples(10)
@given(robots(), STATES)
def test_elastic_drives_alone_give_the_compliance_of_jacobians_on_random_robots(
    case: Case, seed: int
) -> None:
    """Equations that are redundant among themselves, as in parallelograms, hold no drive."""
    robot = case.robot
    assume(set(robot.all_drives) == set(robot.active))
    state = robot.close(case.somewhere(seed)[: case.n])
    found = robot.stiffness(state, Elasticity(dict.fromkeys(robot.active, 1e4))).compliance
    jacobian = robot.jacobian(state)
    expected = jacobian @ jacobian.T / 1e4
    assert np.abs(found - expected).max() <= 1e-10 * np.abs(expected).max()
