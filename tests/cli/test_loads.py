"""Payloads, wrenches and pressures on the command line are those of the library."""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core import Payload, cylinder_force, load
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


def test_reactions_are_those_of_the_library(excavator, loads):
    state = excavator.close(excavator.reference)
    expected = excavator.reactions(state, np.zeros(4), loads)
    data = data_of("reactions", "excavator", *WORDS)
    for name, pin in expected.pins.items():
        assert data["pins"][name]["force"] == pytest.approx(pin.force.tolist(), rel=1e-12)
        assert data["pins"][name]["on"] == pin.links[0]
    for name, joint in expected.joints.items():
        assert data["joints"][name]["moment"] == pytest.approx(joint.moment.tolist(), rel=1e-12)
        assert data["joints"][name]["on"] == joint.links[1]
    assert data["base"]["force"] == pytest.approx(expected.base[:3].tolist(), rel=1e-12)


def test_pins_stand_beside_efforts_and_accelerations(excavator):
    state = excavator.close(excavator.reference)
    pair = ("--pressures", "boom_cylinder=130*bar:5*bar", "--pins")
    moving = data_of("fd", "excavator", *pair)
    ddu = np.array(list(moving["ddu"].values()))
    pins = excavator.reactions(state, ddu).pins
    by_pressures = data_of("reactions", "excavator", *pair)
    assert "joints" not in by_pressures
    for data in (moving, by_pressures):
        for name, pin in pins.items():
            force = data["pins"][name]["force"]
            assert force == pytest.approx(pin.force.tolist(), rel=1e-9, abs=1e-6)
    held = data_of("id", "excavator", *pair)
    measured = held["measured"]["boom_cylinder"]
    cylinder = excavator.cylinders["boom_cylinder"]
    assert measured["measured"] == pytest.approx(float(cylinder_force(cylinder, 130e5, 5e5)))
    assert measured["required"] == pytest.approx(held["tau"]["boom_cylinder"])
    assert measured["difference"] == measured["measured"] - measured["required"]


def test_hinges_in_a_plane_have_no_moments_and_pressures_determine_accelerations():
    answer = call("reactions", "excavator", "--pins")
    assert "moment" not in answer.output  # hinges in a plane transmit none
    answer = call("reactions", "excavator", "--pressures", "boom_cylinder=1:2", "--ddu", "0,0,0,0")
    assert answer.exit_code == 2
    assert "leave out --ddu" in answer.output


@pytest.mark.parametrize(
    ("pressures", "words"),
    [
        (("130:5",), "130*bar"),
        (("-3*bar:5*bar",), "vacuum"),
        (("1e12:0",), "its supply has"),
        (("130*bar:5*bar", "120*bar:5*bar"), "given twice"),
    ],
)
@pytest.mark.parametrize("verb", ["id", "reactions", "fd"])
def test_pressures_that_no_cylinder_has_are_refused(verb, pressures, words):
    options = []
    for pair in pressures:
        options += ["--pressures", f"boom_cylinder={pair}"]
    answer = call(verb, "excavator", *options)
    assert answer.exit_code == 2
    assert words in answer.output


@pytest.mark.parametrize("verb", ["id", "reactions", "fd"])
def test_pressures_above_the_supply_are_told_by_name_and_margin(verb):
    line = "note: boom_cylinder: a measured pressure of 500 bar, 150 bar beyond its supply of 350"
    above, at = (
        call(verb, "excavator", "--pressures", f"boom_cylinder={cap}*bar:5*bar").output
        for cap in (500, 350)
    )
    assert line in above
    assert "a measured pressure" not in at


def test_exchanged_chambers_are_told_beside_the_required_force():
    words = "pressures fit the motion better with cap and rod side exchanged"
    notes = data_of("id", "excavator", "--pressures", "boom_cylinder=5*bar:130*bar")["notes"]
    assert notes == [f"note: boom_cylinder: {words}"]
    for pressures in ("130*bar:5*bar", "350*bar:0", "100*bar:100*bar", "0:0"):
        answer = call("id", "excavator", "--pressures", f"boom_cylinder={pressures}")
        assert words not in answer.output


@pytest.mark.parametrize("verb", ["id", "reactions"])
def test_zeros_of_a_robot_without_masses_have_a_note(verb):
    assert "no link has a mass" in call(verb, "staicu2015").output
    assert "no link has a mass" not in call(verb, "excavator").output


def test_cylinders_without_pressures_are_named():
    line = "no pressures of stick_cylinder, bucket_cylinder, so no force either"
    pair = ("--pressures", "boom_cylinder=130*bar:5*bar")
    for verb in ("fd", "reactions"):
        assert line in call(verb, "excavator", *pair).output
    given = call("fd", "excavator", *pair, "--tau", "stick_cylinder=-4e4,bucket_cylinder=-9e3")
    assert "no pressures" not in given.output
    assert "no pressures" not in call("fd", "excavator").output
