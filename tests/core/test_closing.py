"""Closing from other coordinates, along motions, and in every assembly mode."""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core import ClosureError, InputError, Robot
from tests.robots import robot

U = np.array([0.3, 0.15, 0.175, 0.4])
DU = np.array([0.2, 0.03, -0.02, 0.5])
DDU = np.array([-0.1, 0.2, 0.1, 0.3])

# any joint of a loop may be the given one: crank, cylinder, barrel angle, bars of the
# parallelograms
INDEPENDENT = [
    ("q1", "q2", "q3", "q4"),
    ("q1", "q11", "q21", "q4"),
    ("q1", "q12", "q3", "q4"),
    ("q4", "q22", "q31", "q1"),
    ("q1", "q2", "q41", "q4"),
    ("q1", "q32", "q22", "q4"),
]


@pytest.mark.parametrize("names", INDEPENDENT, ids=",".join)
def test_any_independent_set_gives_the_same_state(forging: Robot, names: tuple[str, ...]) -> None:
    state = forging.close(U, DU)
    dds = forging.accelerations(state, DDU)
    index = [forging.coordinates.index(name) for name in names]
    values, rates, pushes = (
        dict(zip(names, part[index], strict=True)) for part in (state.s, state.ds, dds)
    )
    found = forging.close_given(values, rates, pushes, near=forging.close(U + 0.01))
    assert found.u == pytest.approx(U, abs=1e-12)
    assert found.s == pytest.approx(state.s, abs=1e-12)
    assert found.ds == pytest.approx(state.ds, abs=1e-11)
    assert found.dds == pytest.approx(dds, abs=1e-10)
    assert found.branch == state.branch
    assert found.residual < 1e-13


@pytest.mark.parametrize(
    ("names", "words"),
    [
        (("q1", "q12", "q2", "q4"), "do not determine .*q3"),  # crank and cylinder of one loop
        (("q1", "q2", "q31", "q4"), "do not determine"),  # both long bars of a parallelogram
        (("q1", "q2", "q3"), "name 4"),
        (("q1", "q2", "q3", "q4", "q12"), "name 4"),
        (("q1", "q2", "q3", "q5"), "no coordinate 'q5'"),
    ],
)
def test_a_set_that_does_not_determine_the_rest_is_refused(
    forging: Robot, names: tuple[str, ...], words: str
) -> None:
    with pytest.raises(InputError, match=words):
        forging.close_given(dict.fromkeys(names, 0.1))


def test_given_values_are_checked(forging: Robot) -> None:
    good = {"q1": 0.0, "q2": 2.3, "q3": -1.6, "q4": 0.0}
    with pytest.raises(InputError, match="q2 is nan"):
        forging.close_given({**good, "q2": np.nan})
    with pytest.raises(InputError, match="rates: 'q12' is not among"):
        forging.close_given(good, rates={"q12": 1.0})


def test_a_path_is_the_states_one_by_one(forging: Robot) -> None:
    time = np.linspace(0.0, 10.0, 51)
    u = np.stack([0.17 * time, 0.1 + 0.01 * time, 0.15 + 0.005 * time, 0.09 * time], axis=1)
    path, batch = forging.close_path(u), forging.close(u)
    assert np.array_equal(path.s, batch.s)
    assert path.branch == batch.branch


def test_a_path_names_the_first_row_out_of_reach(forging: Robot) -> None:
    with pytest.raises(
        ClosureError, match=r"row 2: loop 'theta_1' cannot close: q12 = 0\.9"
    ) as caught:
        forging.close_path([[0, 0.1, 0.1, 0], [0, 0.2, 0.1, 0], [0, 0.9, 0.1, 0], [0, 0.2, 0.1, 0]])
    assert caught.value.index == 2


def test_all_assembly_modes_close_and_differ(forging: Robot) -> None:
    modes = forging.assembly_modes(U)
    assert len(modes) == 4  # two cylinders, each with its crank on one side or the other
    for mode in modes:
        assert mode.state.residual < 1e-13
        again = forging.close(U, branch=mode.branch)
        assert np.array_equal(again.s, mode.state.s)
        assert dict(again.branch) == dict(mode.branch)
    pitches = {tuple(np.round(mode.state.z[:2], 6)) for mode in modes}
    assert len(pitches) == 4


def test_the_mode_of_the_state_before_is_kept(forging: Robot) -> None:
    other = next(m for m in forging.assembly_modes(U) if m.branch["theta_2"] == "clockwise")
    moved = forging.close(U + 0.01, near=other.state)
    assert moved.branch["theta_2"] == "clockwise"
    assert moved.s == pytest.approx(other.state.s, abs=0.2)


@pytest.mark.parametrize(
    ("branch", "words"),
    [
        ({"theta_9": "clockwise"}, "no loop 'theta_9'"),
        ({"theta_1": "up"}, "no mode 'up'; known: counterclockwise"),
    ],
)
def test_unknown_modes_are_refused(forging: Robot, branch: dict[str, str], words: str) -> None:
    with pytest.raises(InputError, match=words):
        forging.close(U, branch=branch)


def test_the_limits_of_a_cylinder_are_told_beside_the_range_of_its_loop() -> None:
    """The two differ: a loop may close beyond the stroke that the file gives."""
    excavator = robot("excavator")
    with pytest.raises(
        ClosureError,
        match=r"where the loop closes; the limits of boom_cylinder are \[0.05, 1.15\] m$",
    ) as caught:
        excavator.close([0.0, 2.0, 0.7, 0.6])
    assert caught.value.allowed == pytest.approx(tuple(excavator.closing_range[1]))
