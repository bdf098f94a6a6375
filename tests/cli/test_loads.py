"""Payloads, wrenches and pressures on the command line are those of the library."""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core import Payload, load
from tests.cli.calling import call, data_of

COM = [-0.6, 0.3, 0.0]


@pytest.fixture(scope="module")
def excavator():
    return load("excavator")


@pytest.fixture(scope="module")
def loads(excavator):
    with_body = excavator.loads.with_payload(Payload(900.0, COM))
    return with_body.with_wrench([0.0, 0.0, -2e3, 0.0, 50.0, 0.0])


WORDS = ("--payload", "0.9*t", "--com=-0.6,0.3,0", "--wrench", "0,0,-2*kN,0,50,0")


def test_efforts_of_a_load_are_those_of_the_library(excavator, loads):
    state = excavator.close(excavator.reference)
    tau = excavator.inverse_dynamics(state, np.zeros(4), loads)
    data = data_of("id", "excavator", *WORDS)
    assert list(data["tau"].values()) == pytest.approx(tau.tolist(), rel=1e-12, abs=1e-6)
    parts = [np.array(list(data[part].values())) for part in ("M_ddu", "C_du", "G", "passive")]
    assert sum(parts) == pytest.approx(tau, rel=1e-9, abs=1e-6)


def test_pressures_that_hold_a_load_give_no_acceleration(excavator, loads):
    state = excavator.close(excavator.reference)
    tau = excavator.inverse_dynamics(state, np.zeros(4), loads)
    data = data_of("hydraulics", "excavator", *WORDS)["cylinders"]
    pairs = []
    for name, cylinder in data.items():
        pairs += [
            "--pressures",
            f"{name}={cylinder['cap_pressure']!r}:{cylinder['rod_pressure']!r}",
        ]
        expected = excavator.hydraulics(state, tau)[name].cap_pressure
        assert cylinder["cap_pressure"] == pytest.approx(float(expected), rel=1e-12)
    still = data_of("fd", "excavator", *pairs, *WORDS)
    assert list(still["ddu"].values()) == pytest.approx([0.0] * 4, abs=1e-9)


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        ("id excavator --com 0,0,0", "--com is of the payload"),
        ("id excavator --frame bucket", "--frame is of a load"),
        ("id excavator --payload 5 --frame tip", "--frame: there is no frame 'tip'"),
        ("fd excavator --wrench 1,2", "expected 3 or 6 numbers"),
        ("fd excavator --pressures boom=1:2", "no cylinder 'boom'"),
        ("fd excavator --pressures boom_cylinder=1", "expected 2 numbers"),
        ("hydraulics five_bar", "has no hydraulic cylinder"),
    ],
)
def test_wrong_loads_are_refused(words, problem):
    answer = call(*words.split())
    assert answer.exit_code == 2
    assert problem in " ".join(answer.output.split())
