"""Degrees where radians are meant are told with their place; what may be meant is left alone."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from click.testing import CliRunner

from hybrid_dynamics_core import DescriptionError
from hybrid_dynamics_core.description import RobotDescription
from hybrid_dynamics_core.formats.reader import read_description
from tests.description.robots import HEAD, parse

ARM = (
    HEAD
    + """\
links:
  base: {}
  arm: {mass: 1, com: [0.5, 0, 0], inertia: {rod: {axis: x, length: 1}}}
  slide: {mass: 1, inertia: {xx: 0}}
joints:
  motor: {type: revolute, parent: base, child: arm, axis: z}
  out: {type: prismatic, parent: arm, child: slide, axis: x, limits: [-30, 30]}
active: [motor, out]
end_effector: {link: slide}
reference: {motor: 0, out: 20}
"""
)
LINE = {"limits": 9, "rpy": 9, "offset": 9, "reference": 13}


def arm(key: str, value: str) -> RobotDescription:
    """The arm with an entry of its joint, or another reference."""
    if key == "reference":
        return parse(ARM.replace("motor: 0", f"motor: {value}"))
    entry = f"origin: {{rpy: {value}}}" if key == "rpy" else f"{key}: {value}"
    return parse(ARM.replace("child: arm, axis: z", f"child: arm, axis: z, {entry}"))


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        (
            "limits",
            "[-180, 180]",
            (
                "joints.motor.limits: -180 to 180 rad are 57.3 turns (did you mean '[-180*deg,"
                " 180*deg]'?)"
            ),
        ),
        (
            "limits",
            "[0, 3*30]",
            "joints.motor.limits: 0 to 90 rad are 14.3 turns (did you mean '[0, (3*30)*deg]'?)",
        ),
        (
            "rpy",
            "[90, 0, 0]",
            "joints.motor.origin.rpy[0]: 90 rad is 14.3 turns (did you mean '90*deg'?)",
        ),
        ("offset", "-45", "joints.motor.offset: -45 rad is 7.16 turns (did you mean '-45*deg'?)"),
        ("reference", "60", "reference.motor: 60 rad is 9.55 turns (did you mean '60*deg'?)"),
    ],
)
def test_degrees_are_reported_with_file_and_line(key: str, value: str, message: str) -> None:
    robot = arm(key, value)
    assert robot.warnings == (f"small.yaml:{LINE[key]}: {message}",)
    assert set(robot.warnings) <= set(robot.notes)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("limits", "[-4*pi, 4*pi]"),
        ("limits", "[-12.56637, 12.56637]"),  # the same, printed
        ("limits", "[-7.853982, 10.99557]"),  # five and seven quarters of a turn, printed
        ("limits", "[-6.3, 6.3]"),  # a turn, rounded
        ("limits", "[-1e16, 1e16]"),  # none
        ("limits", "[-180*deg, 180*deg]"),
        ("limits", "[-.inf, 3]"),
        ("rpy", "[90*deg, 0, 0]"),
        ("reference", "60*deg"),
    ],
)
def test_what_may_be_meant_is_not_doubted(key: str, value: str) -> None:
    assert arm(key, value).warnings == ()


def test_lengths_are_not_doubted() -> None:
    robot = parse(ARM)
    assert robot.warnings == ()
    assert robot.joints["out"].limits == (-30.0, 30.0)


def test_degrees_are_worth_what_they_say() -> None:
    assert arm("limits", "[-180*deg, 2*deg]").joints["motor"].limits == (
        -math.pi,
        2 * (math.pi / 180),
    )
    with_parameter = ARM.replace("links:", "parameters: {deg: 2}\nlinks:", 1).replace(
        "motor: 0", "motor: 0.5*deg"
    )
    assert parse(with_parameter).reference["motor"] == 1.0  # a parameter of that name comes first


def test_rows_of_a_chain_are_read_too(tmp_path: Path) -> None:
    path = tmp_path / "rows.yaml"
    path.write_text(
        HEAD + "links: {base: {}, a: {mass: 1}}\n"
        "chain:\n  convention: standard\n  rows:\n    - {joint: q, child: a, d: 0.5, alpha: 90}\n"
        "active: [q]\nend_effector: {link: a}\n",
        encoding="utf-8",
    )
    (doubt,) = read_description(path).warnings
    assert doubt.startswith(f"{path}:8: chain.rows[0].alpha: 90 rad is 14.3 turns")


def test_check_does_not_call_it_right(tmp_path: Path) -> None:
    from hybrid_dynamics_cli.app import app

    path = tmp_path / "arm.yaml"
    path.write_text(ARM.replace("motor: 0", "motor: 60"), encoding="utf-8")
    done = CliRunner().invoke(app, ["check", str(path)])
    assert done.exit_code == 0
    assert f"warning: {path}:13: reference.motor: 60 rad is 9.55 turns" in done.output
    assert done.output.endswith("It has no loops, but see the warning above.\n")
    assert "The description is right" not in done.output
    message = json.loads(CliRunner().invoke(app, ["check", str(path), "--json"]).stdout)
    assert len(message["warnings"]) == 1
    path.write_text(ARM, encoding="utf-8")
    assert (
        CliRunner()
        .invoke(app, ["check", str(path)])
        .output.endswith("The description is right; it has no loops.\n")
    )


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "motor: 0,",
            "motor: 45,",
            "reference.motor: 45 rad is 7.16 turns (did you mean '45*deg'?)",
        ),
        (
            "axis: z}",
            "axis: z, origin: {rpy: [90, 0, 0]}}",
            "joints.motor.origin.rpy[0]: 90 rad is 14.3 turns (did you",
        ),
    ],
)
def test_an_error_tells_of_degrees_that_may_be_its_reason(old: str, new: str, message: str) -> None:
    """The slide's reference is beyond its limit: both problems are reported, each with its line."""
    text = ARM.replace(old, new, 1).replace("limits: [-30, 30]", "limits: [-1, 1]")
    with pytest.raises(
        DescriptionError, match=r"reference\.out: is 20 m, outside the limits \[-1, 1\] m"
    ) as caught:
        parse(text)
    assert "perhaps for this reason: small.yaml:" in str(caught.value)
    assert message in str(caught.value)
