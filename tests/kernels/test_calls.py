"""Compiled calls: the numbers of thorough calls, every kind of argument, errors with evidence."""

from __future__ import annotations

import gc
import inspect
import sys
import tracemalloc
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from hybrid_dynamics_core import ClosureError, InputError, Payload, Robot, SingularityError, load
from hybrid_dynamics_core.description.model import Link
from hybrid_dynamics_core.dynamics.loads import Loads
from hybrid_dynamics_core.errors import MassSingularityError
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.kernels import native, run
from tests.kernels.programs_of import BACKENDS
from tests.mechanisms import changed
from tests.robots import ROBOTS, random_states, random_vector, robot
from tests.sampling import swept

U = np.array([0.3, 0.15, 0.175, 0.4])
DU = np.array([0.2, 0.03, -0.02, 0.5])
DDU = np.array([-0.1, 0.2, 0.1, 0.3])
OUT_OF_REACH = np.array([0.0, 0.9, 0.1, 0.0])
CALLS = 10  # of which memory is watched
# robots with a loop that is iterated: closing it is a call of its own
ITERATED = ("ankle", "gough", "seven_bar", "staicu2015", "three_rrr", "welded")


@pytest.fixture(params=BACKENDS, scope="module")
def machine(request: pytest.FixtureRequest, forging: Robot) -> Robot:
    """The forging robot, compiled and not."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(run, "default_backend", lambda: request.param)
        patch.setattr(native, "LEVEL", 0)  # compiled in a fifth of the time
        made = Robot(forging.description)
        for kernels in (made.kernels, made.kernels.at("l3"), made.kernels.under(_laden(made))):
            for name in (
                "close",
                "forward_kinematics",
                "jacobian",
                "inverse_dynamics",
                "minimal_form",
            ):
                getattr(kernels, name)
        made.close(U)
    assert {kernel.backend for kernel in made._kernels.kernels.values()} == {request.param}
    return made


def _laden(machine: Robot) -> Loads:
    return machine.loads.with_payload(Payload(10.0))


@pytest.mark.parametrize("name", swept(ROBOTS))
def test_fused_calls_are_the_thorough_calls(name: str) -> None:
    machine = robot(name)
    kernels = machine.kernels
    for k, state in enumerate(random_states(name, 3)):
        ddu, tau = random_vector(machine, k), random_vector(machine, k, 50.0)
        guess = {"guess": state.s, "branch": state.signs}
        pairs: list[tuple[Any, Any]] = [
            (kernels.close(state.u, state.du, **guess), (state.s, state.ds)),
            (kernels.jacobian(state.u, **guess), machine.jacobian(state)),
            (
                kernels.inverse_dynamics(state.u, state.du, ddu, **guess),
                machine.inverse_dynamics(state, ddu),
            ),
            (
                kernels.forward_dynamics(state.u, state.du, tau, **guess),
                machine.forward_dynamics(state, tau),
            ),
            (kernels.minimal_form(state.u, state.du, **guess), machine.minimal_form(state)),
        ]
        pose = machine.forward_kinematics(state)
        pairs.append((kernels.forward_kinematics(state.u, **guess), (pose.position, pose.rotation)))
        for found, expected in pairs:
            for a, b in _each(found, expected):
                assert np.abs(a - b).max() <= 1e-12 * max(1.0, np.abs(b).max())


@pytest.mark.parametrize("laden", [False, True])
@pytest.mark.parametrize("name", swept(name for name in ROBOTS if name not in ITERATED))
def test_closure_and_efforts_in_one_call_are_those_of_two_to_the_last_bit(
    name: str, laden: bool
) -> None:
    """Recordings take batches of two calls, the node's stream takes one: they must agree."""
    machine = robot(name)
    assert not machine.follows
    loads = _laden(machine) if laden else machine.loads
    call = machine.kernels.under(loads).closed_inverse_dynamics
    for k, state in enumerate(random_states(name, 20)):
        ddu = random_vector(machine, k)
        tau, *closed = call(state.u, state.du, ddu)
        assert np.array_equal(tau, machine.inverse_dynamics(state, ddu, loads))
        made = machine.closed_state(state.u, state.du, closed)
        for part in ("u", "du", "s", "ds", "R", "bias", "residual", "distances", "signs"):
            assert np.array_equal(getattr(made, part), getattr(state, part)), part
        assert (made.branch, made.status, made.iterations) == (
            state.branch,
            state.status,
            state.iterations,
        )


def _each(found: Any, expected: Any) -> list[tuple[np.ndarray, np.ndarray]]:
    return (
        list(zip(found, expected, strict=True)) if isinstance(found, tuple) else [(found, expected)]
    )


def test_fused_calls_and_simulations_do_not_take_each_others_kernels() -> None:
    machine = load("five_bar")
    state = machine.close(machine.reference)
    for _ in range(2):  # in both orders
        machine.motion_near(state)(state.u, state.du, np.zeros(state.n))
        s, _ = machine.kernels.close(state.u)
        assert s == pytest.approx(state.s, abs=1e-14)
        machine = load("five_bar")
        machine.kernels.close(state.u)


def test_a_link_may_be_called_none() -> None:
    """Kernels are told apart by frames: no name is the end effector."""
    text = "format: 1\nname: odd\nlinks: {base: {}, None: {mass: 1}}\njoints:\n"
    text += "  a: {type: revolute, parent: base, child: None, axis: z}\n"
    machine = Robot(
        parse_description(text + "active: [a]\nend_effector: {link: None, xyz: [1, 0, 0]}\n")
    )
    state = machine.close([0.0])
    assert machine.forward_kinematics(state).position == pytest.approx([1.0, 0.0, 0.0])
    assert machine.forward_kinematics(state, "None").position == pytest.approx([0.0, 0.0, 0.0])


@pytest.mark.parametrize("name", swept(["seven_bar", "gough"], ["gough"]))
def test_loops_without_a_closed_form_are_followed(name: str) -> None:
    """Far from the reference Newton may go to another assembly: so loops are followed."""
    machine = robot(name)
    for state in random_states(name, 3):
        s, ds = machine.kernels.close(state.u, state.du)
        assert s == pytest.approx(state.s, abs=1e-9)
        assert ds == pytest.approx(state.ds, rel=1e-6, abs=1e-6)
        many = machine.kernels.close(np.tile(state.u, (3, 1)), state.du)
        assert many[0] == pytest.approx(np.tile(state.s, (3, 1)), abs=1e-9)


def test_out_is_filled_and_given_back(machine: Robot) -> None:
    kernels = machine.kernels
    out = np.full(4, 7.0)
    assert kernels.inverse_dynamics(U, DU, DDU, out) is out
    assert np.array_equal(out, kernels.inverse_dynamics(U, DU, DDU))
    outs = (np.empty((4, 4)), np.empty(4), np.empty(4))
    found = kernels.minimal_form(U, DU, out=outs)
    assert all(a is b for a, b in zip(found, outs, strict=True))
    rows = np.full((5, 4), 7.0)
    assert kernels.inverse_dynamics(np.tile(U, (5, 1)), DU, DDU, out=rows) is rows
    assert rows == pytest.approx(np.tile(out, (5, 1)), rel=1e-13)


def test_every_way_to_give_the_arguments(machine: Robot) -> None:
    """Compiled code takes the plain ways, and hands on all others."""
    call = machine.kernels.inverse_dynamics
    expected = call([*U], [*DU], [*DDU])
    out = np.empty(4)
    last = {"out": out}
    assert all(
        np.array_equal(tau, expected)
        for tau in (
            call(U, DU, DDU),
            call(U, DU, DDU, None),
            call(U, DU, ddu=DDU),
            call(u=U, du=DU, ddu=DDU, out=None),
            call(U, DU, DDU, check=False),
            call(U, DU, DDU, gravity=machine.loads.gravity),
            call(U, DU, DDU, threads=1, **last),
        )
    )
    for one in (call(U, DU, DDU, out), call(U, DU, DDU, **last)):
        assert one is out
        assert np.array_equal(one, expected)
    names = list(inspect.signature(call).parameters)
    assert names[:7] == ["u", "du", "ddu", "out", "check", "threads", "start"]
    for wrong in ({"output": out}, {"ddu": DDU}):
        with pytest.raises(TypeError, match=next(iter(wrong))):
            call(U, DU, DDU, **wrong)
    with pytest.raises(TypeError, match="ddu"):
        call(U, DU)
    with pytest.raises(TypeError, match="positional"):
        call(U, DU, DDU, out, True)


def test_results_of_compiled_calls_are_let_go(machine: Robot) -> None:
    """Each result has one owner, those of refused calls have none."""
    tau, out = machine.kernels.inverse_dynamics(U, DU, DDU), np.empty(4)
    parts = machine.kernels.minimal_form(U, DU)
    plain = np.empty(4)
    assert sys.getrefcount(tau) == sys.getrefcount(plain)
    part = parts[0]
    assert sys.getrefcount(part) == sys.getrefcount(plain) + 1
    before = sys.getrefcount(out)
    for _ in range(3):
        machine.kernels.inverse_dynamics(U, DU, DDU, out=out)
    assert sys.getrefcount(out) == before
    tracemalloc.start()
    for _ in range(CALLS):
        with pytest.raises(ClosureError):
            machine.kernels.minimal_form(OUT_OF_REACH, DU)
    gc.collect()
    grown = [tracemalloc.get_traced_memory()[0]]
    for _ in range(CALLS):
        with pytest.raises(ClosureError):
            machine.kernels.minimal_form(OUT_OF_REACH, DU)
    gc.collect()
    grown.append(tracemalloc.get_traced_memory()[0])
    tracemalloc.stop()
    assert grown[1] - grown[0] < CALLS * 4 * 4 * 8


def test_out_may_be_an_input(machine: Robot) -> None:
    expected = machine.kernels.inverse_dynamics(U, DU, DDU)
    u = U.copy()
    machine.kernels.inverse_dynamics(u, DU, DDU, out=u)
    assert np.array_equal(u, expected)
    many = np.tile(U, (100, 1)) + np.linspace(0.0, 0.01, 100)[:, None]
    expected = machine.kernels.inverse_dynamics(many, DU, DDU)
    again = np.empty((101, 4))
    again[1:] = many
    machine.kernels.inverse_dynamics(again[1:], DU, DDU, out=again[:-1])
    assert np.array_equal(again[:-1], expected)


@pytest.mark.parametrize(
    "kind",
    [
        list,
        tuple,
        lambda a: np.repeat(a, 2)[::2],
        lambda a: a.astype(">f8"),
        lambda a: np.frombuffer(b"x" + a.tobytes(), dtype=np.uint8)[1:].view(np.float64),
        np.ma.masked_array,
        lambda a: np.asfortranarray(np.tile(a, (3, 1)))[1],
    ],
    ids=["list", "tuple", "strided", "big endian", "unaligned", "subclass", "column order"],
)
def test_any_array_of_numbers_will_do(machine: Robot, kind: Any) -> None:
    u = np.array([0.25, 0.125, 0.1875, 0.5])  # exact in single precision
    expected = machine.kernels.inverse_dynamics(u, u, u)
    assert np.array_equal(machine.kernels.inverse_dynamics(kind(u), u, kind(u)), expected)
    many = np.tile(u, (3, 1))
    assert np.array_equal(
        machine.kernels.inverse_dynamics(np.asfortranarray(many), u, many)[2], expected
    )


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((U[:3], DU, DDU), r"u has shape \(3,\)"),
        ((np.append(U, 0.0), DU, DDU), r"u has shape \(5,\)"),
        ((U, DU[:2], DDU), r"du has shape \(2,\)"),
        ((U[None, None], DU, DDU), r"u has shape \(1, 1, 4\)"),
        ((None, DU, DDU), "u is not an array of numbers: it holds object"),
        (
            ("up", DU, DDU),
            r"u is text \('up'\); expected a list of numbers in the order q1, q12, q22, q4",
        ),
        ((U * 1j, DU, DDU), "u is not an array of numbers: it holds complex128"),
        ((np.array([0.3, np.nan, 0.175, 0.4]), DU, DDU), "u: q12 is nan"),
        ((U, DU, DDU * [1, 1, np.inf, 1]), "ddu: q22 is inf"),
        ((U, DU, np.tile(DDU, (2, 1))), r"ddu has shape \(2, 4\); expected \(4,\)"),
        (
            (np.tile(U, (3, 1)), np.tile(DU, (2, 1)), DDU),
            r"du has shape \(2, 4\); expected \(3, 4\)",
        ),
        (([U, U, U * np.nan], DU, DDU), "u: q1 in row 2 is nan"),
    ],
)
def test_bad_arguments_are_refused(machine: Robot, arguments: tuple[Any, ...], words: str) -> None:
    with pytest.raises(InputError, match=words):
        machine.kernels.inverse_dynamics(*arguments)


_FIXED = np.zeros(4)
_FIXED.flags.writeable = False


@pytest.mark.parametrize(
    ("out", "words"),
    [
        (np.empty(3), r"float64 of shape \(3,\); expected float64 of shape \(4,\)"),
        (np.empty((1, 4)), "expected float64 of shape"),
        (np.empty(4, dtype=np.float32), "float32"),
        (np.empty(4, dtype=int), "int64"),
        (np.empty(8)[::2], "C order"),
        (_FIXED, "writable"),
        ([0.0] * 4, "list"),
        ((np.empty(4),), "tuple"),
    ],
)
def test_bad_outs_are_refused(machine: Robot, out: Any, words: str) -> None:
    with pytest.raises(InputError, match=words):
        machine.kernels.inverse_dynamics(U, DU, DDU, out)
    if not isinstance(out, tuple):
        with pytest.raises(InputError, match="out"):
            machine.kernels.minimal_form(U, DU, out)
        with pytest.raises(InputError, match="out"):
            machine.kernels.minimal_form(U, DU, (np.empty((4, 4)), np.empty(4), out))
    assert not _FIXED.any()


def test_bad_parameters_are_refused(machine: Robot) -> None:
    call = machine.kernels.inverse_dynamics
    for gravity, words in (
        ([0, 0], r"gravity has shape \(2,\)"),
        ([0, 0, np.nan], "not finite"),
        ("g", "not an array"),
    ):
        with pytest.raises(InputError, match=words):
            call(U, DU, DDU, gravity=gravity)
    for threads in (0, -1, 1.5, "2", None):
        with pytest.raises(InputError, match="threads"):
            call(np.tile(U, (2, 1)), DU, DDU, threads=threads)
    with pytest.raises(TypeError):
        call(U, DU, DDU, payload=1.0)
    with pytest.raises(InputError, match="no frame 'l99'"):
        machine.kernels.at("l99")


def test_states_that_do_not_close_are_refused_with_evidence(machine: Robot) -> None:
    with pytest.raises(
        ClosureError, match=r"loop 'theta_1' cannot close: q12 = 0\.9 m is outside"
    ) as caught:
        machine.kernels.inverse_dynamics(OUT_OF_REACH, DU, DDU)
    assert caught.value.index is None
    with pytest.raises(SingularityError):
        machine.kernels.close(np.array([0.0, 0.7, 0.1, 0.0]))
    many = np.tile(U, (80, 1))
    many[70] = OUT_OF_REACH
    with pytest.raises(ClosureError, match="row 70: loop 'theta_1'") as caught:
        machine.kernels.minimal_form(many, DU)
    assert caught.value.index == 70


def test_without_check_rows_that_do_not_close_are_nan(machine: Robot) -> None:
    many = np.tile(U, (80, 1))
    many[70] = OUT_OF_REACH
    out = np.zeros((80, 4))
    tau = machine.kernels.inverse_dynamics(many, DU, DDU, out, check=False)
    assert np.isnan(tau[70]).all()
    assert np.isfinite(np.delete(tau, 70, axis=0)).all()
    assert np.isnan(machine.kernels.jacobian(OUT_OF_REACH, check=False)).all()


def test_nothing_plausible_is_left_in_out_after_a_refusal(machine: Robot) -> None:
    out = np.zeros(4)
    with pytest.raises(ClosureError):
        machine.kernels.inverse_dynamics(OUT_OF_REACH, DU, DDU, out)
    assert np.isnan(out).all()


def test_results_beyond_the_floating_point_numbers_are_refused(machine: Robot) -> None:
    with pytest.raises(InputError, match="too large to compute with"):
        machine.kernels.inverse_dynamics(U, DU, 1e307 * DDU)
    with pytest.raises(InputError, match="in row 1 is not finite"):
        machine.kernels.inverse_dynamics(np.tile(U, (2, 1)), DU, np.array([DDU, 1e307 * DDU]))


@pytest.mark.parametrize("name", ["forging_chu2020", "excavator"])
def test_what_closing_refuses_is_refused_though_efforts_have_a_number(name: str) -> None:
    """Without masses no effort knows of rates whose squares are beyond all numbers; R' u' does."""
    machine = load(name)
    machine = changed(machine, links={link: Link(link) for link in machine.description.links})
    rng, u, refused = np.random.default_rng(0), machine.reference, 0
    for size in 10.0 ** rng.uniform(148, 160, 200):
        du = size * rng.normal(size=len(u))
        with np.errstate(all="ignore"):
            try:
                expected = machine.close(u, du)
            except InputError:
                refused += 1
                with pytest.raises(InputError):
                    machine.kernels.closed_inverse_dynamics(u, du, np.zeros_like(u))
                continue
            _, *closed = machine.kernels.closed_inverse_dynamics(u, du, np.zeros_like(u))
        assert np.array_equal(machine.closed_state(u, du, closed).bias, expected.bias)
    assert 0 < refused < 200


def test_a_robot_without_inertia_has_no_forward_dynamics(forging: Robot) -> None:
    links = {
        name: replace(link, inertia=np.zeros((3, 3)))
        for name, link in forging.description.links.items()
    }
    thin = changed(forging, links=links)
    with pytest.raises(MassSingularityError):
        thin.kernels.forward_dynamics(U, DU, DDU)
    assert np.isfinite(thin.kernels.inverse_dynamics(U, DU, DDU)).all()


def test_gravity_and_loads_are_arguments_of_the_same_code(machine: Robot) -> None:
    kernels = machine.kernels
    state = machine.close(U, DU)
    assert kernels.inverse_dynamics(U, DU, DDU, gravity=np.zeros(3)) == pytest.approx(
        machine.inverse_dynamics(state, DDU, replace(machine.loads, gravity=np.zeros(3))),
        rel=1e-12,
        abs=1e-12,
    )
    made = len(machine._kernels.kernels)
    for mass in (10.0, 20.0):
        loads = machine.loads.with_payload(Payload(mass))
        found = kernels.under(loads).inverse_dynamics(U, DU, DDU)
        assert found == pytest.approx(machine.inverse_dynamics(state, DDU, loads), rel=1e-12)
    assert len(machine._kernels.kernels) == made


def test_frames_by_name(machine: Robot) -> None:
    state = machine.close(U)
    position, rotation = machine.kernels.at("l3").forward_kinematics(U)
    pose = machine.forward_kinematics(state, frame="l3")
    assert np.array_equal(position, pose.position)
    assert np.array_equal(rotation, pose.rotation)
    assert np.array_equal(machine.kernels.at("l3").jacobian(U), machine.jacobian(state, frame="l3"))


@pytest.mark.parametrize("count", [0, 1, 2, 63, 64, 65, 1000])
@pytest.mark.parametrize("threads", [1, 2, 3])
def test_threads_give_the_same_rows(machine: Robot, threads: int, count: int) -> None:
    rng = np.random.default_rng(count)
    u = U + rng.uniform(-0.02, 0.02, (count, 4))
    du, ddu = rng.uniform(-1, 1, (2, count, 4))
    expected = machine.kernels.inverse_dynamics(u, du, ddu)
    assert expected.shape == (count, 4)
    assert np.array_equal(machine.kernels.inverse_dynamics(u, du, ddu, threads=threads), expected)


def test_calls_from_several_threads_do_not_mix(machine: Robot) -> None:
    from concurrent.futures import ThreadPoolExecutor

    call = machine.kernels.inverse_dynamics
    states = U + np.linspace(0.0, 0.02, 200)[:, None]
    expected = [call(u, DU, DDU) for u in states]
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda u: call(u, DU, DDU), states))
    assert np.array_equal(found, expected)


@pytest.mark.parametrize("part", ["whole", "view"])
def test_a_refused_state_is_refused_whatever_out_lies_on(machine: Robot, part: str) -> None:
    room = np.zeros(8)
    u = room[2:6]
    u[:] = OUT_OF_REACH
    out = u if part == "whole" else room[4:8]
    with pytest.raises(ClosureError, match="q12"):
        machine.kernels.inverse_dynamics(u, DU, DDU, out=out)
    u[:] = OUT_OF_REACH
    assert np.isnan(machine.kernels.inverse_dynamics(u, DU, DDU, out=out, check=False)).all()
    u[:] = U
    expected = machine.kernels.inverse_dynamics(U, DU, DDU)
    assert np.array_equal(machine.kernels.inverse_dynamics(u, DU, DDU, out=out), expected)
