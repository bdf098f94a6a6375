"""Numbers with units: worth what they say, and refused where another kind of quantity belongs."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import DescriptionError, load, shipped_robots
from hybrid_dynamics_core.description import RobotDescription
from hybrid_dynamics_core.description.expressions import evaluate
from hybrid_dynamics_core.ground import quantities
from hybrid_dynamics_core.ground.quantities import UNITS
from tests.description.robots import parse
from tests.sampling import examples

# By hand, for every unit: its value in SI units, and what it measures.
BY_HAND: dict[str, tuple[float, str]] = {
    "km": (1000, "length"),
    "m": (1, "length"),
    "dm": (0.1, "length"),
    "cm": (0.01, "length"),
    "mm": (0.001, "length"),
    "um": (0.000001, "length"),
    "l": (0.001, "volume"),
    "rad": (1, "angle"),
    "mrad": (0.001, "angle"),
    "deg": (math.tau / 360, "angle"),
    "t": (1000, "mass"),
    "kg": (1, "mass"),
    "g": (0.001, "mass"),
    "h": (3600, "time"),
    "min": (60, "time"),
    "s": (1, "time"),
    "ms": (0.001, "time"),
    "us": (0.000001, "time"),
    "Hz": (1, "frequency"),
    "kHz": (1000, "frequency"),
    "N": (1, "force"),
    "kN": (1000, "force"),
    "MN": (1e6, "force"),
    "Nm": (1, "torque"),
    "kNm": (1000, "torque"),
    "J": (1, "torque"),
    "kJ": (1000, "torque"),
    "Pa": (1, "pressure"),
    "kPa": (1000, "pressure"),
    "MPa": (1e6, "pressure"),
    "bar": (100000, "pressure"),
    "mbar": (100, "pressure"),
    "W": (1, "power"),
    "kW": (1000, "power"),
    "MW": (1e6, "power"),
    "rpm": (math.tau / 60, "angular velocity"),
}
WORDS = {"length": "a length", "angle": "an angle", "angular velocity": "an angular velocity"}
ARM = """\
format: 1
name: arm
gravity: [0, 0, {gravity}]
links:
  base: {{}}
  crank: {{mass: {mass}, com: [{com}, 0, 0], inertia: {{xx: 0.1, yy: {moment}, zz: 0.6}}}}
  barrel: {{mass: 4, com: [0.2, 0, 0], inertia: {{rod: {{axis: x, length: {length}}}}}}}
  rod: {{mass: 2, com: [-0.2, 0, 0],
    inertia: {{cylinder: {{axis: x, radius: {radius}, length: 0.4}}}}}}
joints:
  q1: {{type: revolute, parent: base, child: crank, origin: {{rpy: [{rpy}, 0, 0]}}, axis: z,
    limits: [{angle}, 3], velocity_limit: {turning}, effort_limit: {torque},
    friction: {{viscous: {damping}, coulomb: {drag}}}, spring: {{stiffness: {twist}, rest: 0.1}}}}
  q2: {{type: revolute, parent: base, child: barrel, axis: z,
    origin: {{xyz: [{xyz}, 0, -0.5], rpy: [pi/2, 0, 0]}}}}
  stroke: {{type: prismatic, parent: barrel, child: rod, origin: {{xyz: [0.4, 0, 0]}}, axis: x,
    limits: [0, {upper}], velocity_limit: {sliding}, effort_limit: {force},
    friction: {{viscous: {flow}}}, spring: {{stiffness: {rate}, preload: {preload}}}}}
loops:
  lift: {{type: A, base: base, arm: crank, k1: barrel, k2: rod, assembly: clockwise,
    pin: {{rod: [0, 0, 0], crank: [{pin}, 0, 0]}}}}
active: [stroke]
actuators:
  stroke: {{kind: hydraulic_cylinder, bore: {bore}, rod: 0.04, stroke: [0, {travel}],
    supply_pressure: {supply}}}
end_effector: {{link: crank, xyz: [0.8, 0, 0]}}
reference: {{stroke: {reference}, q1: {guess}}}
"""
# Each value of the file in SI units, and ways to write the unit it is in.
LENGTHS = ["m", "mm", "cm", "km"]
VALUES: dict[str, tuple[float, list[str]]] = {
    "gravity": (-9.81, ["m/s/s", "cm/s/s", "N/kg"]),
    "mass": (10.0, ["kg", "g", "t"]),
    "com": (0.4, LENGTHS),
    "moment": (0.55, ["kg*m*m", "g*m*m", "kg*cm*cm"]),
    "length": (0.4, LENGTHS),
    "radius": (0.02, LENGTHS),
    "rpy": (math.pi / 2, ["rad", "deg", "mrad"]),
    "angle": (-2.0, ["rad", "deg"]),
    "turning": (1.5, ["rad/s", "rpm", "deg/s"]),
    "torque": (3000.0, ["N*m", "kN*m", "Nm", "kNm"]),
    "damping": (3.0, ["N*m*s", "N*m*s/rad", "N*m/rpm"]),
    "drag": (2.0, ["N*m", "Nm"]),
    "twist": (40.0, ["N*m", "N*m/rad", "N*m/deg"]),
    "xyz": (0.3, LENGTHS),
    "upper": (0.35, LENGTHS),
    "sliding": (0.2, ["m/s", "mm/s", "m/min"]),
    "force": (9000.0, ["N", "kN", "MN"]),
    "flow": (50.0, ["N*s/m", "N*s/mm"]),
    "rate": (700.0, ["N/m", "N/mm", "kN/m"]),
    "preload": (90.0, ["N", "kN"]),
    "pin": (0.6, LENGTHS),
    "bore": (0.065, LENGTHS),
    "travel": (0.35, LENGTHS),
    "supply": (2e7, ["Pa", "bar", "MPa", "kPa", "mbar"]),
    "reference": (0.1, LENGTHS),
    "guess": (-0.15, ["rad", "deg"]),
}


def described(**written: str) -> RobotDescription:
    numbers = {name: repr(value) for name, (value, _) in VALUES.items()}
    return parse(ARM.format(**{**numbers, **written}))


def factor_of(unit: str) -> float:
    """The value of a unit by the table made by hand, which knows nothing of dimensions."""
    names = {name: value for name, (value, _) in BY_HAND.items()}
    value: float = eval(unit, {"__builtins__": {}}, names)  # noqa: S307 - of this file's own units
    return value


def numbers_of(robot: RobotDescription) -> np.ndarray:
    """All that the values of the file become."""
    values: list[Any] = [robot.gravity]
    for link in robot.links.values():
        values += [link.mass, link.com, link.inertia]
    for joint in robot.joints.values():
        values += [joint.rotation, joint.translation, joint.limits]
        values += [joint.velocity_limit or 0.0, joint.effort_limit or 0.0]
    for effect in robot.effects.values():
        values += [effect.viscous, effect.coulomb, effect.stiffness, effect.preload]
    for closure in robot.closures:
        values += [closure.point_a, closure.point_b]
    cylinder = robot.actuators["stroke"]
    values += [cylinder.bore, cylinder.stroke, cylinder.supply_pressure]
    values += list(robot.reference.values())
    flat = np.concatenate([np.ravel(value) for value in values])
    return np.nan_to_num(flat, posinf=0.0, neginf=0.0)


def test_the_table_by_hand_has_every_unit() -> None:
    assert set(BY_HAND) == set(UNITS)
    for name, (value, _) in BY_HAND.items():
        assert evaluate(f"1*{name}", {}) == pytest.approx(value, rel=1e-15)


@examples(200)
@given(st.sampled_from(sorted(VALUES)), st.data())
def test_a_value_is_the_same_in_every_unit(name: str, data: st.DataObject) -> None:
    value, units = VALUES[name]
    unit = data.draw(st.sampled_from(units))
    robot = described(**{name: f"{value / factor_of(unit)!r}*{unit}"})
    assert numbers_of(robot) == pytest.approx(numbers_of(described()), rel=1e-12, abs=1e-15)


@examples(200)
@given(st.sampled_from(sorted(VALUES)), st.data())
def test_a_unit_of_another_kind_is_refused(name: str, data: st.DataObject) -> None:
    """It may be as plausible a number as it likes."""
    value, units = VALUES[name]
    kinds = {kind for unit, (_, kind) in BY_HAND.items() if unit in units}
    if "N*m" in units:
        kinds.add("torque")
    others = [unit for unit, (_, kind) in BY_HAND.items() if kind not in kinds]
    others += ["kg*m", "N/s", "m*m"]
    unit = data.draw(st.sampled_from(others))
    with pytest.raises(DescriptionError, match=re.escape(f"*{unit}' is ")) as caught:
        described(**{name: f"{value!r}*{unit}"})
    assert "; expected a" in str(caught.value)
    assert caught.value.line is not None


def test_what_is_wrong_is_told_in_words() -> None:
    with pytest.raises(DescriptionError) as caught:
        described(bore="65*bar")
    assert str(caught.value) == (
        "small.yaml:24: actuators.stroke.bore: '65*bar' is a pressure; expected a length [m]"
    )
    with pytest.raises(DescriptionError, match=r"'5\*Hz' is a frequency; expected an angular vel"):
        described(turning="5*Hz")


EXPRESSIONS = {
    "65*mm + 1*cm": 0.075,
    "2*(3*mm + 0.1)": 0.206,
    "sqrt(4*mm*mm)": 0.002,
    "1/(4*kHz)": 0.00025,
    "abs(-3*kN)": 3000.0,
    "100*mm/(2*cm)": 5.0,
    "atan2(3*mm, 3*mm)": math.pi / 4,
    "sin(30*deg)": 0.5,
    "7.85*t/m/m/m": 7850.0,
    "reach*mm": 0.6,
    "reach + 1*mm": 600.001,
    "mm*600": 0.6,
}


@pytest.mark.parametrize(("text", "value"), EXPRESSIONS.items())
def test_units_in_expressions(text: str, value: float) -> None:
    assert evaluate(text, {"reach": 600.0}) == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize(
    ("unit", "text"),
    [("rad", "an angle"), ("m rad", "of the unit m rad"), ("kg^2/s", "of the unit kg^2 s^-1")],
)
def test_units_without_a_word_are_told_by_their_powers(unit: str, text: str) -> None:
    assert quantities.described(quantities.dimension_of(unit)) == text


WRONG = {
    "2*mm + 3*N": "puts a force and a length together",
    "reach - t": "'t' is a unit without a number, and none of the parameters (reach); write 1*t",
    "m*g": "'m*g' is a unit without a number",
    "mm": "'mm' is a unit without a number",
    "sin(3*mm)": "is of a length; expected an angle or a number without a unit",
    "sqrt(2*kg)": "is of a mass, no square",
    "atan2(1*mm, 1*N)": "puts a force and a length together",
    "3*MM": "'MM' is not one of the parameters (reach) and no unit (did you mean 'mm'?)",
    "3*lb": "'lb' is not one of the parameters (reach) and no unit",
    "3*rad/s^2": "(did you mean '3*rad/s/s'?)",
    "3*kg*mm**2": "(did you mean '3*kg*mm*mm'?)",
}


@pytest.mark.parametrize(("text", "words"), WRONG.items())
def test_units_that_do_not_go_together(text: str, words: str) -> None:
    with pytest.raises(ValueError, match=re.escape(words)):
        evaluate(text, {"reach": 600.0})


def test_a_parameter_goes_before_the_unit_of_its_name() -> None:
    assert evaluate("m*2", {"m": 7.0}, units=("N",)) == 14.0


# -- cylinders

DOUBTED = {
    "bore in mm": (
        {"bore": "65"},
        "actuators.stroke.bore: 65 m, .*are these mill.* 65[*]mm or 0.065",
    ),
    "bore in cm": ({"bore": "6.5"}, "actuators.stroke.bore: 6.5 m"),
    "supply in bar": ({"supply": "200"}, "supply_pressure: 200 Pa, .* 200[*]bar or 2e[+]07"),
    "supply in MPa": ({"supply": "20"}, "supply_pressure: 20 Pa"),
    "supply of bar twice": ({"supply": "2e5*bar"}, "supply_pressure: 2e[+]10 Pa"),
    "travel in mm": ({"travel": "350"}, "actuators.stroke.stroke: 350 m, .* 350[*]mm or 0.35"),
}


@pytest.mark.parametrize(("written", "words"), DOUBTED.values(), ids=DOUBTED.keys())
def test_cylinders_in_other_units_are_doubted(written: dict[str, str], words: str) -> None:
    (warning,) = described(**written).warnings
    assert warning.startswith("small.yaml:")
    assert re.search(words, warning)


def test_cylinders_as_they_are_built_are_not_doubted() -> None:
    assert not described().warnings
    assert not described(bore="500*mm", supply="6*bar").warnings
    for name in shipped_robots():
        assert not load(name).description.warnings
