"""Options take units, and refuse those of another kind."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.calling import call_line, data_of

SAME = [
    (
        "fk excavator -u boom_cylinder=700*mm,slew=30*deg",
        "fk excavator -u boom_cylinder=0.7,slew=pi/6",
    ),
    (
        "fk excavator --du slew=15*rpm,stick_cylinder=6*m/min",
        "fk excavator --du slew=pi/2,stick_cylinder=0.1",
    ),
    ("id excavator --ddu slew=90*deg/s/s", "id excavator --ddu slew=pi/2"),
    (
        "fd excavator --tau slew=3*kN*m,boom_cylinder=0.2*MN",
        "fd excavator --tau slew=3000,boom_cylinder=200000",
    ),
    (
        "ik excavator --position 6000*mm 0 50*cm --tolerance 1*mm",
        "ik excavator --position 6 0 0.5 --tolerance 0.001",
    ),
    (
        "simulate five_bar --seconds 50*ms --rate 0.2*kHz",
        "simulate five_bar --seconds 0.05 --rate 200",
    ),
    ("branches excavator -u boom_cylinder=700*mm", "branches excavator -u boom_cylinder=0.7"),
    (
        "workspace excavator --samples 50 --range boom_cylinder=500*mm:70*cm",
        "workspace excavator --samples 50 --range boom_cylinder=0.5:0.7",
    ),
]


@pytest.mark.parametrize(("line", "plain"), SAME)
def test_units_are_worth_what_they_say(line: str, plain: str) -> None:
    assert str(data_of(*line.split())) == str(data_of(*plain.split()))


WRONG = {
    "fk excavator -u boom_cylinder=30*deg": "'30*deg' is an angle; expected a length [m]",
    "fk excavator -u slew=30*mm": "'30*mm' is a length; expected an angle [rad]",
    "fk excavator --du slew=5*Hz": "'5*Hz' is a frequency; expected an angular velocity [rad/s]",
    "id excavator --ddu slew=5*rpm": "an angular velocity; expected an angular acceleration",
    "fd excavator --tau slew=5*kN": "'5*kN' is a force; expected a torque [N m]",
    "simulate five_bar --seconds 5*mm": "'5*mm' is a length; expected a time [s]",
    "simulate five_bar --seconds 0*ms": "0.0 is not in the range x>0.0",
    "ik excavator --position 6*kg 0 0": "'6*kg' is a mass; expected a length [m]",
    "workspace excavator --range slew=0:5*mm": "'5*mm' is a length; expected an angle [rad]",
    "bag report some.mcap --from 3*m": "'3*m' is a length; expected a time [s]",
}


@pytest.mark.parametrize(("line", "words"), WRONG.items())
def test_units_of_another_kind_are_refused(line: str, words: str) -> None:
    answer = call_line(line)
    assert answer.exit_code == 2
    assert words in " ".join(answer.output.split())


def test_check_doubts_a_bore_in_millimetres_and_a_supply_in_bar(tmp_path: Path) -> None:
    from tests.description.test_units import ARM, VALUES

    numbers = {name: repr(value) for name, (value, _) in VALUES.items()}
    path = tmp_path / "arm.yaml"
    path.write_text(ARM.format(**{**numbers, "bore": "65", "supply": "200"}))
    data = data_of("check", str(path))
    assert len(data["warnings"]) == 2
    assert call_line(f"check {path}").stdout.rstrip().endswith("see the warnings above.")
