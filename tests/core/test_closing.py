"""Closing from other coordinates, along motions, and in every assembly mode."""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core import ClosedState, ClosureError, IKStatus, InputError, Robot
from hybrid_dynamics_core.formats.reader import parse_description
from tests.robots import robot
from tests.sampling import swept

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


@pytest.mark.parametrize("names", INDEPENDENT[:3], ids=",".join)
def test_a_batch_given_is_its_rows_one_by_one(forging: Robot, names: tuple[str, ...]) -> None:
    """Arrays by name, with numbers for what all rows share, from one state or one a row."""
    positions = U + np.array([[0.0, 0.0, 0.0, 0.0], [0.0, 0.01, 0.0, 0.2], [0.0, 0.0, 0.02, -0.3]])
    states = forging.close(positions, np.tile(DU, (3, 1)))
    index = [forging.coordinates.index(name) for name in names]
    values, rates = (
        dict(zip(names, part[:, index].T, strict=True)) for part in (states.s, states.ds)
    )
    values["q1"] = U[0]
    pushes = {"q1": 0.3}
    for near in (forging.close(U), states):
        batch = forging.close_given(values, rates, pushes, near)
        assert batch.s == pytest.approx(states.s, abs=1e-12)
        for k in range(3):
            row = {name: np.broadcast_to(value, 3)[k] for name, value in values.items()}
            slopes = {name: rate[k] for name, rate in rates.items()}
            start = near if near.u.ndim == 1 else near.rows(k)
            alone = forging.close_given(row, slopes, pushes, start)
            assert batch.dds is not None
            assert alone.dds is not None
            assert np.array_equal(batch.s[k], alone.s)
            assert np.array_equal(batch.ds[k], alone.ds)
            assert np.array_equal(batch.dds[k], alone.dds)
    tau = forging.inverse_dynamics(batch, np.zeros((3, 4)))
    assert tau == pytest.approx(forging.inverse_dynamics(states, np.zeros((3, 4))), rel=1e-9)


def test_a_row_given_that_does_not_close_is_named(forging: Robot) -> None:
    values = {"q1": 0.0, "q12": [0.1, 0.15, 9.0], "q22": 0.15, "q4": 0.0}
    with pytest.raises(ClosureError, match="row 2: ") as caught:
        forging.close_given(values)
    assert caught.value.index == 2


GIVEN_WRONG = {
    "a list": ([0.0, 2.3, -1.6, 0.0], "values is of type list; expected values by name"),
    "none": (None, r"\(0 coordinates\) cannot be given together"),
    "two dimensions": ({"q1": [[0.0]]}, r"q1 has shape \(1, 1\); expected a number, or \(N,\)"),
    "lengths": ({"q1": [0.0, 0.1], "q2": [2.3]}, r"lengths differ \(q1 2, q2 1\)"),
    "not finite": ({"q1": [0.0, np.inf]}, "q1 in row 1 is inf; expected finite numbers"),
    "text": ({"q1": "0.1"}, "values: q1 is not an array of numbers"),
    "no rows": ({"q1": []}, "the batch is empty"),
}


@pytest.mark.parametrize(("values", "words"), GIVEN_WRONG.values(), ids=GIVEN_WRONG.keys())
def test_given_values_of_another_form(forging: Robot, values: object, words: str) -> None:
    good = {"q1": 0.0, "q2": 2.3, "q3": -1.6, "q4": 0.0}
    if isinstance(values, dict):
        values = {**good, **values}
    with pytest.raises(InputError, match=words):
        forging.close_given(values)


def test_no_given_values_are_no_empty_words(forging: Robot) -> None:
    with pytest.raises(InputError, match=r"^no names \(0 coordinates\) cannot be given"):
        forging.close_given({})


def test_rates_and_states_of_another_length(forging: Robot) -> None:
    good = {"q1": [0.0, 0.1], "q2": 2.3, "q3": -1.6, "q4": 0.0}
    with pytest.raises(InputError, match=r"lengths differ \(values 2, rates 3\)"):
        forging.close_given(good, {"q2": [0.0, 0.1, 0.2]})
    with pytest.raises(InputError, match="near holds 3 states; expected one, or one a row"):
        forging.close_given(good, near=forging.close(np.tile(U, (3, 1))))
    with pytest.raises(InputError, match="expected a ClosedState"):
        forging.close_given(good, near=U)


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


DEAD_CENTRE = """\
format: 1
name: dead_centre
links: {base: {}, crank: {mass: 1}, rod: {mass: 1}, ram: {mass: 1}}
joints:
  a: {type: revolute, parent: base, child: crank, axis: z}
  b: {type: revolute, parent: crank, child: rod, axis: z, origin: {xyz: [0.2, 0, 0]}}
  x: {type: prismatic, parent: base, child: ram, axis: x}
closures: {cl: {kind: planar, between: {rod: [0.5, 0, 0], ram: [0, 0, 0]}}}
active: [a]
end_effector: {link: ram}
reference: {a: 0, b: 0, x: 0.7}
"""


def test_coordinates_are_judged_where_the_motion_comes_from() -> None:
    """At its dead centre, the reference, the ram says nothing of the crank; elsewhere it does."""
    machine = Robot(parse_description(DEAD_CENTRE, file="dead.yaml"))
    with pytest.raises(InputError, match=r"x cannot be given together: .*singular"):
        machine.close_given({"x": 0.55})
    near = machine.close_path(np.array([[0.3], [0.9]])).rows(-1)
    state = machine.close_given({"x": 0.55}, near=near)
    expected = np.arccos((0.55**2 + 0.2**2 - 0.5**2) / (2 * 0.55 * 0.2))  # cosine rule
    assert state.u[0] == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("name", swept(["excavator", "five_bar", "gough"], ["five_bar", "gough"]))
def test_rows_on_different_modes_are_followed_as_each_alone(name: str) -> None:
    machine = robot(name)
    modes = machine.assembly_modes(machine.reference)
    near = ClosedState.joined([mode.state for mode in modes])
    rng = np.random.default_rng(4)
    reached = 0
    for size in (0.02, 0.1, 0.4):  # the longer ones are followed in steps
        u = machine.reference + size * rng.uniform(-1.0, 1.0, (len(modes), len(machine.active)))
        batch = machine.close(u, near=near, check=False)
        for k, mode in enumerate(modes):
            alone = machine.close(u[k], near=mode.state, check=False)
            assert alone.status == batch.status[k]
            np.testing.assert_allclose(batch.s[k], alone.s, atol=1e-9, equal_nan=True)
            reached += alone.status == 0
    assert reached > len(modes)


FOLLOWED = """\
format: 1
name: followed
links: {base: {}, a: {mass: 1, com: [0.5, 0, 0]}, b: {mass: 1, com: [0.5, 0, 0]}}
joints:
  q: {type: revolute, parent: base, child: a, axis: y, limits: [-2, 2]}
  f: {type: revolute, parent: a, child: b, axis: y, origin: {xyz: [1, 0, 0]}, limits: [-1, 1.5],
    mimic: {joint: q, multiplier: -2, offset: 0.1}}
active: [q]
end_effector: {link: b, xyz: [1, 0, 0]}
"""


def test_limits_of_a_joint_that_follows_are_limits_of_the_one_it_follows() -> None:
    machine = Robot(parse_description(FOLLOWED, file="followed.yaml"))
    np.testing.assert_allclose(machine.limits, [[-0.7, 0.55]])  # f = 0.1 - 2 q, by hand
    pose = machine.forward_kinematics(machine.close([0.6]))  # as a pose: a place has two ways
    result = machine.inverse_kinematics(pose)
    assert result.status is IKStatus.LIMIT, result.message
    assert "q (0.6 rad, limit 0.55 rad)" in result.message


def test_limits_of_a_joint_that_follows_are_none_of_other_joints() -> None:
    text = FOLLOWED.replace("links: {", "links: {tip: {mass: 1}, ").replace(
        "active: [q]", "  p: {type: prismatic, parent: b, child: tip, axis: x}\nactive: [p, q]"
    )
    machine = Robot(parse_description(text, file="followed.yaml"))
    np.testing.assert_allclose(machine.limits, [[-np.inf, np.inf], [-0.7, 0.55]])


def test_what_has_no_loops_is_nowhere_near_a_singularity_of_one() -> None:
    text = FOLLOWED.replace("mimic: {joint: q, multiplier: -2, offset: 0.1}", "effort_limit: 5")
    text = text.replace("active: [q]", "active: [q, f]")
    machine = Robot(parse_description(text, file="serial.yaml"))
    assert machine.close([0.1, 0.2]).singularity == 1.0
    assert machine.close([[0.1, 0.2], [0.3, 0.4], [0.5, 0.6]]).singularity.tolist() == [1.0] * 3
