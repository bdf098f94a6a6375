"""Arguments of another form end in an error of the library that says what was expected."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np
import pytest

from hybrid_dynamics_core import InputError, Payload, Pose, Robot
from hybrid_dynamics_core.control import (
    ComputedTorque,
    GravityCompensation,
    JointTrajectory,
    efforts_along,
)
from hybrid_dynamics_core.errors import HybridDynamicsError
from hybrid_dynamics_core.export import to_gepetto, to_mjcf, to_sdf, to_urdf, to_urdf_plus
from hybrid_dynamics_core.ground.check_arrays import all_finite
from hybrid_dynamics_core.identification import base_parameters, identify, random_motion
from hybrid_dynamics_core.simulation import Settings, simulate
from tests.robots import robot

NAME = "five_bar"
EXPORTS = (to_gepetto, to_urdf, to_urdf_plus, to_mjcf, to_sdf)
JUNK: dict[str, Any] = {
    "a number": 0.3,
    "a text": "q_L",
    "a list of texts": ["a", "b", "c"],
    "a bare array": np.zeros(2),
    "a scalar array": np.array(0.1),
    "an empty list": [],
    "two dimensions": np.zeros((2, 2)),
    "three dimensions": np.zeros((2, 3, 3)),
    "rows of several lengths": [[0.1, 0.2], [0.3]],
    "complex numbers": np.zeros(3, dtype=complex),
    "not a number": [0.0, np.nan, 0.0],
    "infinite": [0.0, np.inf, 0.0],
    "a dict": {"q_L": 0.1},
    "a dict of texts": {"q_L": "x"},
    "a dict of two dimensions": {"q_L": np.zeros((2, 2)), "q_R": 0.1, "q_T": 0.2},
    "a dict of other names": {"nobody": 0.1},
    "a dict with none": {"q_L": None},
    "a type": Robot,
    "a function": abs,
    "an object": object(),
    "settings": Settings(),
    "true": True,
}


def machine() -> Robot:
    return robot(NAME)


def calls() -> dict[str, tuple[Callable[..., Any], dict[str, Any]]]:
    """Every public call, with good arguments by name."""
    m = machine()
    state = m.close(m.reference, [0.1, 0.2, 0.3])
    zero = np.zeros(3)
    batch = m.close(np.tile(m.reference, (40, 1)))
    given = dict(zip(m.active, m.reference.tolist(), strict=True))
    place = m.forward_kinematics(state)
    motion = random_motion(m, 30, seed=1)
    path = JointTrajectory.between(m.reference, m.reference + 0.01, 1.0)
    on_state = {"state": state}
    with_ddu = {"state": state, "ddu": zero}
    with_tau = {"state": state, "tau": zero}
    return {
        "close": (m.close, {"u": m.reference, "du": zero, "near": state}),
        "close on a branch": (m.close, {"u": m.reference, "branch": dict(state.branch)}),
        "close_path": (m.close_path, {"u": batch.u, "du": batch.du, "near": state}),
        "close_given": (
            m.close_given,
            {"values": given, "rates": given, "accelerations": given, "near": state},
        ),
        "follow_turns": (m.follow_turns, {**on_state, "before": state.s}),
        "assembly_modes": (m.assembly_modes, {"u": m.reference}),
        "certify_cells": (m.certify_cells, {"ranges": {"q_L": (1.5, 1.6)}, "depth": 1}),
        "certify": (m.certify, {**with_ddu, "radius": 1e-3}),
        "forward_kinematics": (m.forward_kinematics, {**on_state, "frame": None}),
        "jacobian": (m.jacobian, {**on_state, "frame": None}),
        "accelerations": (m.accelerations, with_ddu),
        "inverse_kinematics": (
            m.inverse_kinematics,
            {
                "target": place.position,
                "seed": m.reference,
                "mask": [True, False, True, False, False, False],
                "near": state,
                "tolerance": 1e-9,
            },
        ),
        "workspace": (m.workspace, {"count": 5, "frame": None, "ranges": None, "held": None}),
        "inverse_dynamics": (m.inverse_dynamics, {**with_ddu, "loads": m.loads}),
        "forward_dynamics": (m.forward_dynamics, {**with_tau, "loads": m.loads}),
        "derivatives": (m.inverse_dynamics_derivatives, {**with_ddu, "loads": m.loads}),
        "forward derivatives": (m.forward_dynamics_derivatives, {**with_tau, "loads": m.loads}),
        "minimal_form": (m.minimal_form, {**on_state, "loads": m.loads}),
        "passive_forces": (m.passive_forces, {**on_state, "loads": m.loads}),
        "regressor": (m.regressor, {**with_ddu, "parameters": None, "loads": m.loads}),
        "energy": (m.energy, {**on_state, "loads": m.loads}),
        "coriolis_matrix": (m.coriolis_matrix, {**on_state, "loads": m.loads}),
        "velocity_map_rate": (m.velocity_map_rate, on_state),
        "spanning_terms": (m.spanning_terms, with_ddu),
        "reactions": (m.reactions, with_ddu),
        "motion_near": (m.motion_near, {**on_state, "loads": m.loads}),
        "generalised_forces": (m.generalised_forces, {**on_state, "forces": {"q_L": 1.0}}),
        "drive_forces": (m.drive_forces, with_tau),
        "hydraulics": (m.hydraulics, with_tau),
        "with_wrench": (m.loads.with_wrench, {"wrench": np.zeros(6), "frame": "end_effector"}),
        "with_payload": (m.loads.with_payload, {"payload": Payload(1.0)}),
        "with_gravity": (m.loads.with_gravity, {"gravity": zero}),
        "with_effects": (m.loads.with_effects, {"viscous": np.zeros(len(m.coordinates))}),
        "Payload": (Payload, {"mass": 1.0, "com": zero, "inertia": np.eye(3)}),
        "Pose": (
            Pose.from_quaternion,
            {"position": zero, "quaternion": [0.0, 0.0, 0.0, 1.0]},
        ),
        "simulate": (
            simulate,
            {
                "robot": m,
                "u": m.reference,
                "du": zero,
                "tau": zero,
                "t_span": (0.0, 0.01),
                "settings": Settings(),
            },
        ),
        "JointTrajectory": (
            JointTrajectory,
            {"times": [0.0, 1.0], "positions": [m.reference, m.reference]},
        ),
        "GravityCompensation": (GravityCompensation, {"robot": m, "damping": zero}),
        "ComputedTorque": (ComputedTorque, {"robot": m, "trajectory": path, "kp": 1.0, "kd": 1.0}),
        "efforts_along": (efforts_along, {"robot": m, "trajectory": path, "times": [0.5]}),
        "base_parameters": (base_parameters, {"robot": m}),
        "random_motion": (random_motion, {"robot": m, "count": 5}),
        "identify": (
            identify,
            {
                "robot": m,
                "state": motion[0],
                "ddu": motion[1],
                "tau": m.inverse_dynamics(*motion),
                "loads": m.loads,
            },
        ),
        **{export.__name__: (export, {"robot": m}) for export in EXPORTS},
    }


CALLS = calls()
ARGUMENTS = [(label, name) for label, (_, good) in CALLS.items() for name in good]


@pytest.mark.parametrize("label", CALLS)
def test_the_good_arguments_are_good(label: str) -> None:
    call, good = CALLS[label]
    call(**good)


@pytest.mark.parametrize(("label", "name"), ARGUMENTS)
def test_junk_is_refused_with_an_error_of_the_library(label: str, name: str) -> None:
    """Or it is taken, where it means something: None and a number in place of a list at times."""
    call, good = CALLS[label]
    for junk in JUNK.values():
        if callable(junk) and name == "tau" and label == "simulate":
            continue  # a function of the user's, which may raise what it likes
        with suppress(HybridDynamicsError):
            call(**{**good, name: junk})


@pytest.mark.parametrize("export", EXPORTS)
def test_exports_take_a_robot_or_its_description(export: Callable[..., Any]) -> None:
    excavator = robot("excavator")
    assert export(excavator) == export(excavator.description)
    with pytest.raises(InputError, match=r"expected a Robot or its description; load\('x'\) gives"):
        export("x")


def test_functions_of_a_robot_take_its_description() -> None:
    """Where they are quick calls; what is called again and again wants a Robot."""
    m = machine()
    one, other = (simulate(r, m.reference, t_span=(0.0, 0.05)) for r in (m, m.description))
    assert np.array_equal(one.u, other.u)
    first, second = (random_motion(r, 5) for r in (m, m.description))
    assert np.array_equal(first[0].s, second[0].s)


MISPLACED = {
    "no rates": ((None, (0.0, 1.0), Settings()), "t_span is of type Settings; .*is `du` left out"),
    "efforts as rates": ((abs,), "du is of type builtin_function_or_method; the order is simulate"),
    "settings as rates": ((Settings(),), "du is of type Settings; the order is simulate"),
    "settings as efforts": ((None, Settings()), "tau is of type Settings; the order is simulate"),
    "one time": ((None, None, 3.0), r"t_span has shape \(\); expected start and end"),
    "a span as efforts": ((None, (0.0, 1.0)), r"tau has shape \(2,\); expected \(3,\)"),
}


@pytest.mark.parametrize(("given", "words"), MISPLACED.values(), ids=MISPLACED.keys())
def test_misplaced_arguments_of_simulate_are_told(given: tuple[Any, ...], words: str) -> None:
    m = machine()
    with pytest.raises(InputError, match=words):
        simulate(m, m.close(m.reference), *given)


def test_forces_by_name_are_numbers_or_one_a_state() -> None:
    m = machine()
    state = m.close(np.tile(m.reference, (2, 1)))
    assert m.generalised_forces(state, {"q_L": [1.0, 2.0]}).shape == (2, 3)
    with pytest.raises(InputError, match=r"the force on 'q_L' has shape \(2, 3\)"):
        m.generalised_forces(state, {"q_L": np.zeros((2, 3))})
    with pytest.raises(InputError, match="forces is of type list; expected values by name"):
        m.generalised_forces(state, [1.0])


def test_drawings_take_a_description_and_refuse_a_name() -> None:
    pytest.importorskip("matplotlib")
    from hybrid_dynamics_core.drawing import draw, draw_modes, draw_simulation

    m = machine()
    motion = simulate(m, m.reference, t_span=(0.0, 0.05))
    for drawing, others in ((draw, ()), (draw_modes, ()), (draw_simulation, (motion,))):
        assert drawing(m.description, *others).axes
        with pytest.raises(InputError, match="expected a Robot or its description"):
            drawing(NAME, *others)


@pytest.mark.parametrize("mode", [1, None, ["front"]])
def test_a_mode_that_is_no_name(mode: object) -> None:
    m = machine()
    (loop,) = m.loops
    with pytest.raises(InputError, match="expected the name of a mode of loop"):
        m.close(m.reference, branch={loop: mode})  # type: ignore[dict-item]


def test_numbers_of_samples_that_cannot_be() -> None:
    m = machine()
    with pytest.raises(InputError, match="rate is inf; expected a finite number"):
        Settings(rate=np.inf)
    with pytest.raises(InputError, match=r"1e\+10 samples in 10 s; expected at most 1e\+07"):
        simulate(m, m.reference, None, None, (0.0, 10.0), Settings(rate=1e9))


def test_a_function_of_efforts_that_takes_something_else() -> None:
    m = machine()
    with pytest.raises(InputError, match=r"tau: expected a function of \(t, state\)"):
        simulate(m, m.reference, None, lambda: np.zeros(3), (0.0, 0.1))  # type: ignore[misc]


@pytest.mark.parametrize(
    ("values", "finite"),
    [([1e308, 1e308], True), ([1.0, np.inf], False), ([np.inf, -np.inf], False), ([np.nan], False)],
)
def test_values_are_finite_each_by_itself(values: list[float], finite: bool) -> None:
    assert all_finite(np.array(values)) is finite
