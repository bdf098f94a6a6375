"""Modules from templates: geometry, names, stacks, templates of the user, and errors in them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hybrid_dynamics_core import DescriptionError, Robot, load
from hybrid_dynamics_core.description import RobotDescription
from hybrid_dynamics_core.description.expand.templates import shipped_templates
from hybrid_dynamics_core.formats import read_description
from tests.cli.calling import shipped_text
from tests.description.oracle import close, freedom, gaps, link_pose, turn
from tests.description.robots import HEAD, parse

UPU = "{base_radius: 0.5, platform_radius: 0.2, height: 0.7, twist: 0.4}"
GOUGH = (
    "{base_radius: 0.6, platform_radius: 0.35, height: 0.8, "
    "base_angle: [-0.2, 0.2, 1.9, 2.3, 4.0, 4.4], "
    "platform_angle: [-0.9, 0.9, 1.2, 3.0, 3.3, 5.1], platform_height: -0.05}"
)


def one(template: str, parameters: str, legs: str = "A, B, C", on: str = "base") -> str:
    active = ", ".join(f"lambda_{leg}" for leg in legs.split(", "))
    return (
        HEAD + f"modules:\n  m:\n    template: {template}\n    on: {on}\n    legs: [{legs}]\n   "
        f" parameters: {parameters}\n" + f"active: [{active}]\nend_effector: {{link: m_platform}}\n"
    )


KINDS = {
    "3-UPU": (one("3-UPU", UPU), 3, {"x": 0.1, "y": -0.05, "z": 0.07}),
    "3-UPS/S": (one("3-UPS/S", UPU), 3, {"alpha_1": 0.2, "alpha_2": -0.1, "alpha_3": 0.3}),
    "6-UPS": (
        one("6-UPS", GOUGH, "A, B, C, D, E, F"),
        6,
        {"x": 0.05, "y": 0.03, "z": -0.04, "alpha_1": 0.1, "alpha_2": -0.2, "alpha_3": 0.15},
    ),
}


@pytest.mark.parametrize(("text", "mobility", "pose"), KINDS.values(), ids=KINDS.keys())
def test_module_closes_centrally_and_at_a_pose(
    text: str, mobility: int, pose: dict[str, float]
) -> None:
    robot = parse(text)
    assert np.abs(gaps(robot, {})).max() < 1e-15
    assert set(robot.reference) == set(robot.joints)
    assert not any(robot.reference.values())
    s = close(robot, pose, {})
    assert np.abs(gaps(robot, s)).max() < 1e-13
    assert freedom(robot, s) == mobility
    rx, ry, rz = (turn(np.eye(3)[k], pose.get(f"alpha_{k + 1}", 0.0)) for k in range(3))
    assert link_pose(robot, "m_platform", s)[:3, :3] == pytest.approx(rx @ ry @ rz, abs=1e-14)


@pytest.mark.parametrize(("text", "mobility", "pose"), KINDS.values(), ids=KINDS.keys())
def test_extension_is_the_change_of_the_distance_between_the_joints(
    text: str, mobility: int, pose: dict[str, float]
) -> None:
    robot = parse(text)
    s = close(robot, pose, {})
    for closure in robot.closures[:mobility]:
        leg = closure.name.removeprefix("leg_")
        length = []
        for at in ({}, s):
            end = link_pose(robot, "m_platform", at) @ [*closure.point_b, 1.0]
            start = link_pose(robot, f"m_hook_{leg}", at)[:, 3]
            length.append(np.linalg.norm(end - start))
        assert length[1] - length[0] == pytest.approx(s[f"lambda_{leg}"], abs=1e-13)


def test_every_shipped_template_is_listed_under_the_name_it_gives() -> None:
    assert {"3-UPU", "3-UPS/S", "6-UPS"} <= set(shipped_templates())


def test_a_module_may_stand_anywhere() -> None:
    still = parse(one("3-UPU", UPU))
    moved = parse(one("3-UPU", UPU, on="{link: base, xyz: [1, 2, 3], rpy: [0, pi/2, 0]}"))
    s = close(moved, {"x": 0.1, "y": 0.0, "z": 0.05}, {})
    local = link_pose(still, "m_platform", s)[:3, 3]
    assert link_pose(moved, "m_platform", s)[:3, 3] == pytest.approx(
        [1 + local[2], 2 + local[1], 3 - local[0]]
    )


def test_masses_are_put_in() -> None:
    parameters = UPU.replace(
        "}",
        ", platform_mass: 10, barrel_mass: 2, barrel_length: 0.3, rod_mass: 1, rod_length: 0.4}",
    )
    for template, sign in (("3-UPU", 1), ("3-UPS/S", -1)):
        robot = parse(one(template, parameters))
        assert sum(link.mass for link in robot.links.values()) == 10 + 3 * (2 + 1)
        assert robot.links["m_barrel_B"].com == pytest.approx([sign * 0.15, 0, 0])
        assert robot.links["m_rod_B"].com == pytest.approx([-sign * 0.2, 0, 0])
        assert robot.links["m_rod_B"].inertia == pytest.approx(np.diag([0, 1, 1]) * 0.4**2 / 12)
        assert robot.links["m_platform"].inertia[2, 2] == pytest.approx(10 * 0.2**2 / 2)


def test_limits_of_the_legs() -> None:
    robot = parse(
        one(
            "3-UPU", UPU.replace("}", ", lambda_min: [-0.1, -0.2, -0.3], lambda_max: 0.4}")
        ).replace("[-0.1, -0.2, -0.3]", "-0.1")
    )
    assert robot.joints["lambda_A"].limits == (-0.1, 0.4)
    assert parse(one("3-UPU", UPU)).joints["lambda_A"].limits == (-np.inf, np.inf)


STACK = (
    HEAD
    + f"""\
modules:
  low: {{template: 3-UPU, on: base, parameters: {UPU}}}
  high: {{template: 3-UPU, on: low_platform, prefix: high_, parameters: {UPU}}}
links: {{tool: {{mass: 1}}}}
joints: {{q: {{type: revolute, parent: high_platform, child: tool, axis: z}}}}
active: [lambda_A, lambda_B, lambda_C, high_lambda_A, high_lambda_B, high_lambda_C, q]
end_effector: {{link: tool}}
"""
)


def test_modules_stack_and_carry_an_arm() -> None:
    robot = parse(STACK)
    assert np.abs(gaps(robot, {})).max() < 1e-15
    assert freedom(robot, {}) == 7
    assert link_pose(robot, "tool", {"x": 0.1, "high_x": 0.2})[:3, 3] == pytest.approx(
        [0.3, 0, 1.4]
    )


def test_same_names_in_two_modules() -> None:
    with pytest.raises(DescriptionError) as caught:
        parse(STACK.replace(", prefix: high_", ""))
    assert caught.value.key == "modules.high"
    assert caught.value.line == 6
    words = (
        "the name 'x' is given twice in joints (first in line 5); give this module other leg names"
        " (legs) or a prefix"
    )
    assert words in str(caught.value)
    assert "(template 3-UPU: joints.x)" in str(caught.value)


SLIDER = """\
template: slider
about: one slide, and a strut to it from the side
parameters:
  reach: {about: "of the strut [m]", above: 0}
values:
  low: reach/2
links: {car: {mass: 1}}
joints:
  s: {type: prismatic, parent: on, child: car, axis: z, origin: {xyz: [0, 0, low]}}
reference: {s: 0.1}
legs:
  labels: [L, R]
  parameters:
    side: {about: "where the strut stands [m]"}
  links: {strut_<leg>: {}, tube_<leg>: {}}
  joints:
    t_<leg>: {type: revolute, parent: on, child: strut_<leg>, axis: z,
              origin: {xyz: [side, 0, 0], rpy: [pi/2, 0, 0]}}
    e_<leg>: {type: prismatic, parent: strut_<leg>, child: tube_<leg>, axis: y}
  closures:
    c_<leg>: {kind: planar, between: {tube_<leg>: [0, reach, 0], car: [0, 0, 0]}}
"""
USER = (
    HEAD + "modules: {m: {template: %s, on: base, legs: [1, 2], parameters: {reach: 1, side: [-0.3,"
    " 0.4]}}}\nactive: [s]\nend_effector: {link: m_car}\n"
)


def check_slider(robot: RobotDescription) -> None:
    assert list(robot.joints) == ["s", "t_1", "e_1", "t_2", "e_2"]
    assert robot.joints["t_1"].translation == pytest.approx([-0.3, 0, 0])
    assert robot.joints["t_2"].translation == pytest.approx([0.4, 0, 0])
    assert robot.reference == {"s": 0.1, "t_1": 0, "e_1": 0, "t_2": 0, "e_2": 0}
    assert [c.name for c in robot.closures] == ["c_1", "c_2"]
    s = close(robot, {"s": 0.2}, {})
    assert np.abs(gaps(robot, s)).max() < 1e-13


def test_template_of_the_user_beside_the_robot(tmp_path: Path) -> None:
    (tmp_path / "slider.yaml").write_text(SLIDER, encoding="utf-8")
    (tmp_path / "robot.yaml").write_text(USER % "slider.yaml", encoding="utf-8")
    check_slider(read_description(tmp_path / "robot.yaml"))


def test_template_of_the_user_in_the_robot() -> None:
    inside = "templates:\n  slider:\n" + "".join(f"    {line}\n" for line in SLIDER.splitlines())
    check_slider(parse(USER % "slider" + inside))


def test_a_reference_of_the_robot_goes_before_the_templates() -> None:
    inside = "templates:\n  slider:\n" + "".join(f"    {line}\n" for line in SLIDER.splitlines())
    assert parse(USER % "slider" + inside + "reference: {s: 0.3}\n").reference["s"] == 0.3


WRONG = {
    "no such template": (
        "template: 3-UPU",
        "template: 3-UPV",
        "modules.m.template",
        "no template '3-UPV' (did you mean",
    ),
    "no such file": (
        "template: 3-UPU",
        "template: ./mine.yaml",
        "modules.m.template",
        "there is no file mine.yaml",
    ),
    "no such link": ("on: base", "on: bass", "modules.m.on", "no link 'bass'"),
    "unknown parameter": (
        "twist: 0.4",
        "twits: 0.4",
        "modules.m.parameters.twits",
        "did you mean 'twist'",
    ),
    "missing parameter": (
        "height: 0.7, ",
        "",
        "modules.m.parameters",
        (
            "missing 'height', platform above the base in the central configuration [m]; the"
            " template 3-UPU needs it"
        ),
    ),
    "negative radius": (
        "platform_radius: 0.2",
        "platform_radius: -0.2",
        "modules.m.parameters.platform_radius",
        "is -0.2; expected a number above 0 (circle of the platform joints [m])",
    ),
    "negative mass": (
        "twist: 0.4",
        "rod_mass: -1",
        "modules.m.parameters.rod_mass",
        "expected a number of at least 0",
    ),
    "list for one": (
        "height: 0.7",
        "height: [0.7, 0.8, 0.9]",
        "modules.m.parameters.height",
        "is one number for the",
    ),
    "list too short": (
        "twist: 0.4",
        "angle: [0, 2]",
        "modules.m.parameters.angle",
        "2 entries; expected one number, or 3",
    ),
    "slip in a list": (
        "twist: 0.4",
        "angle: [0, 2, thr]",
        "modules.m.parameters.angle[2]",
        "'thr' is not one of the",
    ),
    "text": (
        "twist: 0.4",
        "twist: a bit",
        "modules.m.parameters.twist",
        "neither a number nor an expression",
    ),
    "nothing at all": (
        "twist: 0.4",
        "twist: ",
        "modules.m.parameters.twist",
        "is nothing; expected a number",
    ),
    "two legs": (
        "legs: [A, B, C]",
        "legs: [A, B]",
        "modules.m.legs",
        "has 2 names; the template 3-UPU has 3 legs",
    ),
    "legs of one name": (
        "legs: [A, B, C]",
        "legs: [A, B, A]",
        "modules.m.legs",
        "names one entry twice",
    ),
    "limits": (
        "twist: 0.4",
        "lambda_min: 1, lambda_max: 0",
        "modules.m",
        "joints.lambda_<leg>.limits)",
    ),
    "unknown key": ("on: base", "onto: base", "modules.m.onto", "did you mean 'on'"),
}


@pytest.mark.parametrize(("old", "new", "key", "words"), WRONG.values(), ids=WRONG.keys())
def test_wrong_modules(old: str, new: str, key: str, words: str) -> None:
    text = one("3-UPU", UPU)
    changed = text.replace(old, new, 1)
    assert changed != text
    with pytest.raises(DescriptionError) as caught:
        parse(changed)
    assert words in str(caught.value)
    assert caught.value.key == key
    assert caught.value.line is not None
    assert (
        changed.splitlines()[caught.value.line - 1]
        .strip()
        .startswith(key.split(".", 2)[-1].split(".", maxsplit=1)[0].split("[", maxsplit=1)[0])
    )


def test_parameters_that_do_not_fit_together() -> None:
    wrong = SLIDER.replace("low: reach/2", "low: sqrt(1 - reach*reach)")
    inside = "templates:\n  slider:\n" + "".join(f"    {line}\n" for line in wrong.splitlines())
    with pytest.raises(
        DescriptionError,
        match=r"modules\.m\.parameters: these parameters do not fit: sqrt\(-3\) has no value",
    ):
        parse((USER % "slider").replace("reach: 1", "reach: 2") + inside)


def test_slips_in_a_template_name_its_file(tmp_path: Path) -> None:
    (tmp_path / "robot.yaml").write_text(USER % "slider.yaml", encoding="utf-8")

    def error_of(old: str, new: str) -> str:
        assert old in SLIDER
        (tmp_path / "slider.yaml").write_text(SLIDER.replace(old, new, 1), encoding="utf-8")
        with pytest.raises(DescriptionError) as caught:
            read_description(tmp_path / "robot.yaml")
        return str(caught.value)

    assert "slider.yaml:9: joints.s.kind: unknown key" in error_of("s: {type:", "s: {kind:")
    assert "slider.yaml:1: missing 'template'" in error_of("template: slider\n", "")
    assert (
        "robot.yaml:4: modules.m: the template has no link 'cat' (did you mean 'car'?)"
        in error_of("car: [0", "cat: [0")
    )
    assert "(template slider: closures.c_<leg>); known: on, car, strut_<leg>" in error_of(
        "car: [0", "cat: [0"
    )
    assert "'rech' is not one of the parameters" in error_of("[0, reach, 0]", "[0, rech, 0]")
    assert "(template slider: closures.c_<leg>.between.m_tube_1[1])" in error_of(
        "[0, reach, 0]", "[0, rech, 0]"
    )


def test_names_of_modules_prefixes_and_legs_as_ros_has_them() -> None:
    """The robot is the one with plain names."""
    text = shipped_text("delta")
    named = text.replace("  delta:\n", "  left/delta-1:\n", 1)
    named = named.replace("delta_platform", "left/delta-1_platform")
    template = "    template: delta\n"
    named = named.replace(template, f"{template}    prefix: 2nd/\n    legs: [front-left, 3, _x]\n")
    active = ["2nd/theta_front-left", "2nd/theta_3", "2nd/theta__x", "q4"]
    named = named.replace("[theta_A, theta_B, theta_C, q4]", f"[{', '.join(active)}]")
    robot = Robot(parse(named))
    assert list(robot.active) == active
    states = [m.close([0.2, 0.3, 0.4, 0.5], [1, 2, 3, 4]) for m in (robot, load("delta"))]
    assert np.array_equal(states[0].s, states[1].s)
