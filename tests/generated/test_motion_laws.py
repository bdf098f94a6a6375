"""Laws of motions and of coordinates given.

Branches kept, jumps refused, any independent set gives the rest.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given

from hybrid_dynamics_core import InputError
from hybrid_dynamics_core.errors import StateError
from tests.generated.case import Case, independent_columns
from tests.generated.class_three import class_three
from tests.generated.robots import STATES, examples, robots


def apart(case: Case, a: np.ndarray, b: np.ndarray) -> float:
    """Largest difference of two configurations; whole turns are none."""
    turning = np.array([kind == "revolute" for kind in case.robot.joint_types.values()])
    return float(
        np.abs(np.where(turning, np.remainder(a - b + np.pi, 2.0 * np.pi) - np.pi, a - b)).max()
    )


@examples(5)
@given(robots(), STATES)
def test_one_long_step_ends_where_small_steps_do(case: Case, seed: int) -> None:
    """Where the oracle comes through, far from singular places, the step is taken, and to the same
    configuration.

    Where it does not, the step is refused or ends in a closed configuration.
    """
    rng = np.random.default_rng(seed)
    near = case.robot.close(case.start[: case.n])
    active = range(case.n)
    for _ in range(2):
        way = rng.normal(size=case.n)
        way *= rng.uniform(0.3, 1.5) / np.linalg.norm(way)
        done, s = case.space.follow(
            near.s, active, way, 0.3 * case.space.margin(near.s, active), far=2.5
        )
        try:
            state = case.robot.close(near.u + way, near=near)
        except StateError:
            assert done < 1.0
            continue
        assert case.space.gap(state.s) < 1e-11
        if done == 1.0:
            assert apart(case, state.s, s) < 1e-10 / case.space.margin(s, active)
        near = state


@examples(12)
@given(class_three(max_links=3, max_loops=3), STATES)
def test_step_that_is_not_refused_has_a_smooth_way(case: Case, seed: int) -> None:
    """However long: the oracle comes there too, in steps down to a thousandth, by the same way.

    Named parallelograms are left out: they pass through places that are singular for their pins.
    """
    assume(all(c.assembly is None for c in case.description.closures))
    rng = np.random.default_rng(seed)
    near = case.robot.close(case.start[: case.n])
    for _ in range(4):
        way = rng.normal(size=case.n)
        way *= rng.uniform(0.5, 3.0) / np.linalg.norm(way)
        try:
            state = case.robot.close(near.u + way, near=near)
        except StateError:
            continue
        done, s = case.space.follow(near.s, range(case.n), way, shortest=1e-3)
        assert done == 1.0
        assert apart(case, state.s, s) < 1e-10 / case.space.margin(s, range(case.n))
        near = state


@examples(8)
@given(robots(), STATES)
def test_path_is_its_steps(case: Case, seed: int) -> None:
    ends = np.array([case.somewhere(seed + k) for k in range(2)])[:, : case.n]
    u = np.concatenate(
        [np.linspace(case.start[: case.n], ends[0], 4), np.linspace(ends[0], ends[1], 4)[1:]]
    )
    du = np.array([case.rates(seed + k) for k in range(len(u))])
    steps = []
    try:
        for k, row in enumerate(u):
            steps.append(case.robot.close(row, du[k], near=steps[-1] if steps else None))
    except StateError:
        with pytest.raises(StateError) as refused:
            case.robot.close_path(u, du)
        assert refused.value.index == len(steps)
        return
    path = case.robot.close_path(u, du)
    for k, step in enumerate(steps):
        assert apart(case, path.s[k], step.s) < 1e-10
        assert path.ds[k] == pytest.approx(step.ds, abs=1e-8)


def another_set(case: Case, seed: int) -> list[int]:
    """Coordinates that determine the rest, chosen at random."""
    _, jacobian = case.space.equations(case.start)
    order = np.random.default_rng(seed).permutation(len(case.start)).tolist()
    passive = independent_columns(jacobian, order)
    return [k for k in order if k not in passive]


@examples(9)
@given(robots(), STATES)
def test_any_independent_coordinates_give_the_rest(case: Case, seed: int) -> None:
    """From the reference along the straight way of the coordinates given, which the oracle follows
    in small steps.
    """
    given_ones = another_set(case, seed)
    start_margin = case.space.margin(case.start, given_ones)
    assume(len(given_ones) == case.n and start_margin > 0.02)
    rng = np.random.default_rng(seed)
    way = 0.3 * rng.uniform(-1.0, 1.0, size=case.n) / np.sqrt(case.n)
    _, s = case.space.follow(case.start, given_ones, way, 0.5 * start_margin, far=2.5)
    margin = min(1.0, case.space.margin(s, given_ones))
    names = [case.robot.coordinates[k] for k in given_ones]
    rates, push = (rng.uniform(-1.0, 1.0, size=case.n) for _ in range(2))
    state = case.robot.close_given(
        *(dict(zip(names, values.tolist(), strict=True)) for values in (s[given_ones], rates, push))
    )
    assert np.abs(state.s - s).max() < 1e-11 / margin
    slopes = case.space.velocity_map(s, given_ones)
    assert np.abs(state.ds - slopes @ rates).max() < 1e-10 / margin**2
    assert state.dds is not None
    assert np.abs(state.dds[given_ones] - push).max() < 1e-8
    # the accelerations are those of the robot's own active joints, which other laws hold to be
    # derivatives
    size = max(
        1.0, np.abs(state.dds).max(), np.abs(state.R).max() * np.abs(state.dds[: case.n]).max()
    )
    assert (
        np.abs(state.R @ state.dds[: case.n] + state.bias - state.dds).max() < 1e-8 * size / margin
    )


@examples(9)
@given(robots(), STATES)
def test_what_passive_ones_give_gives_them_back(case: Case, seed: int) -> None:
    """Active to passive by `close`, passive to active by `close_given` from nearby."""
    s = case.somewhere(seed)
    given_ones = another_set(case, seed)
    margin = case.space.margin(s, given_ones)
    assume(
        len(given_ones) == case.n
        and margin > 0.05
        and case.space.margin(case.start, given_ones) > 0.02
    )
    state = case.robot.close(s[: case.n], case.rates(seed))
    acceleration = case.robot.accelerations(state, case.rates(seed + 1))
    names = [case.robot.coordinates[k] for k in given_ones]
    back = case.robot.close_given(
        *(
            dict(zip(names, v[given_ones].tolist(), strict=True))
            for v in (state.s, state.ds, acceleration)
        ),
        near=state,
    )
    assert apart(case, back.s, state.s) < 1e-9
    assert back.ds == pytest.approx(state.ds, abs=1e-8 * max(1.0, np.abs(state.ds).max()))
    assert back.dds == pytest.approx(acceleration, abs=1e-7 * max(1.0, np.abs(acceleration).max()))


@examples(18)
@given(class_three(max_links=4, max_loops=4), STATES)
def test_coordinates_that_do_not_determine_the_rest_are_refused(case: Case, seed: int) -> None:
    """As many as there are degrees of freedom, but dependent.

    At the reference, and a little way off.
    """
    given_ones = np.random.default_rng(seed).permutation(len(case.start))[: case.n].tolist()
    places = [case.start, *(case.somewhere(seed + k) for k in range(2))]
    assume(max(case.space.margin(s, given_ones) for s in places) < 1e-10)
    names = [case.robot.coordinates[k] for k in given_ones]
    with pytest.raises(InputError, match=r"cannot be given together: .+"):
        case.robot.close_given({name: case.description.reference[name] for name in names})


@examples(9)
@given(robots(), STATES)
def test_missing_or_surplus_coordinates_are_refused(case: Case, seed: int) -> None:
    names = np.random.default_rng(seed).permutation(case.robot.coordinates).tolist()
    degrees = f"{case.n} degree" + "s" * (case.n != 1) + " of freedom"
    for number in {case.n - 1, case.n + 1} & set(range(1, len(names) + 1)):
        with pytest.raises(InputError, match=degrees):
            case.robot.close_given(
                {name: case.description.reference[name] for name in names[:number]}
            )


@examples(15)
@given(class_three(max_links=4, max_loops=4), STATES)
def test_a_mode_named_is_kept(case: Case, seed: int) -> None:
    s = case.somewhere(seed)
    u = s[: case.n]
    own = case.robot.close(u)
    for loop, mode in own.branch.items():
        named = case.robot.close(u, branch={loop: mode})
        assert np.array_equal(named.s, own.s)
        modes = (
            [m.branch[loop] for m in case.robot.assembly_modes(u)] if len(own.branch) < 4 else []
        )
        for other in set(modes) - {mode, "reference"}:
            if "mode_" in other:  # of an iteration: listed, but not to be asked for by name
                continue
            try:
                state = case.robot.close(u, branch={loop: other})
            except StateError:
                continue  # later loops need not close there
            assert case.space.gap(state.s) < 1e-10
            assert apart(case, state.s, own.s) > 1e-4
            assert state.branch[loop] == other
            stayed = case.robot.close(u, near=state)
            assert stayed.branch == state.branch
            assert apart(case, stayed.s, state.s) < 1e-12
            with pytest.raises(InputError, match="the branch of near is kept"):
                case.robot.close(u, near=own, branch={loop: other})


@examples(12)
@given(class_three(max_links=3, max_loops=2), STATES)
def test_assembly_modes_are_distinct_closed_and_hold_the_own_one(case: Case, seed: int) -> None:
    s = case.somewhere(seed)
    modes = case.robot.assembly_modes(s[: case.n])
    found = [mode.state.s for mode in modes]
    assert min(apart(case, f, s) for f in found) < 1e-8
    for k, one in enumerate(found):
        assert case.space.gap(one) < 1e-9
        assert all(apart(case, one, other) > 1e-6 for other in found[:k])
    assert len({tuple(sorted(mode.branch.items())) for mode in modes}) == len(modes)
