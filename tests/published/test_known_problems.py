"""The field's benchmark problems, each against a reference that owes nothing to this library."""

from __future__ import annotations

import shutil

import numpy as np
import pytest
from scipy.optimize import brentq

from benchmarks.problems import closed_references, references, sides
from benchmarks.problems.catalogue import PROBLEMS, ROBOTS, Problem, error
from benchmarks.problems.four_bars import four_bars
from benchmarks.problems.sides import Reached
from benchmarks.problems.solve import Solver
from benchmarks.problems.table import times
from benchmarks.problems.turns import NOTHING, Result
from hybrid_dynamics_core import load
from hybrid_dynamics_core.simulation import Settings, simulate

BY_NAME = {problem.name: problem for problem in PROBLEMS}
SHORT = {  # [s] to which a test goes
    "pendulum": 2.0,
    "four_bars_2": 2.0,
    "bricard": 0.5,
    "rectangular_bricard": 0.25,
    "diagonal_spring": 0.5,
    "slider_crank": 0.3,
}


@pytest.mark.parametrize("name", SHORT)
def test_motions_are_those_of_the_references(name: str) -> None:
    solver = Solver(BY_NAME[name])
    end = SHORT[name]
    motion = simulate(solver.robot, solver.start, None, None, (0.0, end), Settings(rate=20.0))
    problem = solver.problem
    reference = problem.reference(motion.t)
    assert error(problem.observed.of_states(solver.robot, motion.state), reference) < 1e-5
    assert np.abs(motion.energy_error).max() < 1e-6


@pytest.mark.sweep(sample="test_motions_are_those_of_the_references")
@pytest.mark.parametrize("problem", PROBLEMS, ids=lambda problem: problem.name)
def test_the_accuracy_asked_is_reached(problem: Problem) -> None:
    answer = Solver(problem).answer(1e-9)
    assert answer.drift < 1e-5
    assert answer.reached < problem.asked


@pytest.mark.parametrize("name", ["four_bars_2", "andrews"])
def test_the_c_export_reaches_the_accuracy_asked(name: str) -> None:
    problem = BY_NAME[name]
    if shutil.which("cc") is None:
        pytest.skip("there is no C compiler")
    run = sides.opened(sides.OURS, problem)
    reached = run(20)
    assert reached.error < problem.asked
    assert reached.drift < 1e-6


@pytest.mark.parametrize(
    ("side", "name", "steps"),
    [
        ("mujoco", "pendulum", 2),
        ("mujoco", "andrews", 10),
        ("pinocchio", "pendulum", 2),
        ("pinocchio", "andrews", 10),
    ],
)
def test_other_engines_reach_the_same_references(side: str, name: str, steps: int) -> None:
    """They share the description and the reference, and nothing else."""
    pytest.importorskip(side)
    assert sides.opened(side, BY_NAME[name])(steps).error < 1e-3


def test_a_side_that_is_missing_or_fails_is_told() -> None:
    problem = BY_NAME["pendulum"]
    absent = Result("exudyn", NOTHING, float("nan"), "cannot run: no exudyn", is_reached=False)
    slow = Result("mujoco", Reached(0.5, float("nan"), 2.0), 1.0, "", is_reached=False)
    ours = Result(sides.OURS, Reached(1e-4, 1e-8, 1e-3), 2.0, "", is_reached=True)
    table = times([problem], {problem.name: [ours, slow, absent]}, ["mujoco", "exudyn"])
    assert "not reached: 5e-01 in 2 s" in table[-1]
    assert "cannot run: no exudyn" in table[-1]


def test_the_spring_of_the_four_bar_swings_as_the_reference_says() -> None:
    """The natural frequency at rest: no simulation, and no derivative by differences."""
    robot = BY_NAME["diagonal_spring"].robot()

    def push(angle: float) -> float:
        return float(closed_references.diagonal_energies(angle + 1e-30j)[1].imag / 1e-30)

    rest = brentq(push, -1.2, 0.2, xtol=1e-14)
    state = robot.close([rest])
    assert robot.forward_dynamics(state, [0.0]) == pytest.approx([0.0], abs=1e-9)
    slope = (push(rest + 1e-6) - push(rest - 1e-6)) / 2e-6
    inertia = closed_references.diagonal_energies(complex(rest))[0].real
    by_u = robot.forward_dynamics_derivatives(state, [0.0])[0]
    # central differences of an exact slope: h^2 and rounding / h
    assert -by_u[0, 0] == pytest.approx(slope / inertia, rel=1e-8)


def test_the_three_legs_have_the_six_poses_of_an_equation_by_hand() -> None:
    """Differences of the circles are linear in the place, so that one equation is left."""
    feet = np.array([0.0, 15.91, 10.0j])
    tip = (17.04**2 + 20.84**2 - 16.54**2) / (2.0 * 17.04)
    tips = np.array([0.0, 17.04, tip + 1j * np.sqrt(20.84**2 - tip**2)])
    lengths = np.array([14.98, 15.38, 12.0])

    def gap(angle: float) -> float:
        ways = np.exp(1j * angle) * tips - feet
        rows = 2.0 * np.column_stack([ways.real, ways.imag])[1:]
        right = lengths[1:] ** 2 - lengths[0] ** 2 - np.abs(ways[1:]) ** 2
        scale = np.linalg.det(rows)
        place = np.array(
            [
                right[0] * rows[1, 1] - right[1] * rows[0, 1],
                rows[0, 0] * right[1] - rows[1, 0] * right[0],
            ]
        )
        return float(place @ place - (lengths[0] * scale) ** 2)

    grid = np.linspace(-np.pi, np.pi, 2001)
    values = [gap(angle) for angle in grid]
    brackets = zip(grid, grid[1:], values, values[1:], strict=False)
    expected = [brentq(gap, a, b, xtol=1e-14) for a, b, x, y in brackets if x * y < 0.0]
    robot = load(ROBOTS / "three_legs.yaml")
    modes = robot.assembly_modes(robot.reference)
    assert modes.complete
    turn = robot.coordinates.index("turn")
    found = sorted(float(np.angle(np.exp(1j * mode.state.s[turn]))) for mode in modes)
    assert found == pytest.approx(expected, abs=1e-12)


def test_dietmaiers_forty_poses_are_proved_to_be_all() -> None:
    robot = load(ROBOTS / "dietmaier.yaml")
    modes = robot.assembly_modes(robot.reference)
    assert (len(modes), modes.complete) == (40, True)


@pytest.mark.parametrize("count", [1, 2, 10, 40])
def test_files_of_four_bars_are_those_of_the_rule(count: int) -> None:
    text = (ROBOTS / f"four_bars_{count}.yaml").read_text(encoding="utf-8")
    assert text == four_bars(count)


def test_published_places_of_the_slider_are_near_the_reference() -> None:
    """Gonzalez's solution in the IFToMM library, as kept with Exudyn."""
    times = np.array([0.0, 0.1, 0.5, 1.0])
    published = [0.2, 0.226785384, 0.184952803, 0.211754668]
    assert references.slider_crank(times)[:, 0] == pytest.approx(published, abs=5e-5)
