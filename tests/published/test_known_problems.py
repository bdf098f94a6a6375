"""The field's benchmark problems, each against a reference that owes nothing to this library."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.problems import references
from benchmarks.problems.catalogue import PROBLEMS, ROBOTS, Problem, error
from benchmarks.problems.four_bars import four_bars
from benchmarks.problems.solve import Solver
from hybrid_dynamics_core.simulation import Settings, simulate

BY_NAME = {problem.name: problem for problem in PROBLEMS}
SHORT = {"pendulum": 2.0, "four_bars_2": 2.0, "slider_crank": 0.3}  # [s] to which a test goes


@pytest.mark.parametrize("name", SHORT)
def test_motions_are_those_of_the_references(name: str) -> None:
    solver = Solver(BY_NAME[name])
    end = SHORT[name]
    motion = simulate(solver.robot, solver.start, None, None, (0.0, end), Settings(rate=20.0))
    problem = solver.problem
    assert problem.reference is not None
    reference = problem.reference(motion.t)
    assert error(problem.measured(solver.robot, motion), reference) < 1e-5
    assert np.abs(motion.energy_error).max() < 1e-6


@pytest.mark.sweep(sample="test_motions_are_those_of_the_references")
@pytest.mark.parametrize("problem", PROBLEMS, ids=lambda problem: problem.name)
def test_the_accuracy_asked_is_reached(problem: Problem) -> None:
    answer = Solver(problem).answer(1e-9)
    assert answer.drift < 1e-5
    if problem.reference is not None:
        assert answer.reached < problem.asked


def test_bricards_mechanism_keeps_its_energy() -> None:
    solver = Solver(BY_NAME["bricard"])
    motion = simulate(solver.robot, solver.start, None, None, (0.0, 1.0), Settings(rate=20.0))
    assert motion.completed
    assert np.ptp(motion.u) > 0.1
    assert np.abs(motion.energy_error).max() < 1e-6


@pytest.mark.parametrize("count", [1, 2, 10, 40])
def test_files_of_four_bars_are_those_of_the_rule(count: int) -> None:
    text = (ROBOTS / f"four_bars_{count}.yaml").read_text(encoding="utf-8")
    assert text == four_bars(count)


def test_published_places_of_the_slider_are_near_the_reference() -> None:
    """Gonzalez's solution in the IFToMM library, as kept with Exudyn."""
    times = np.array([0.0, 0.1, 0.5, 1.0])
    published = [0.2, 0.226785384, 0.184952803, 0.211754668]
    assert references.slider_crank(times)[:, 0] == pytest.approx(published, abs=5e-5)
