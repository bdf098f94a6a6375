"""General legs: any row of revolute and prismatic joints to a platform."""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core import DescriptionError
from tests.description.oracle import close, freedom, gaps, link_pose
from tests.description.robots import HEAD, parse

PLATFORM = """\
links:
  sx: {}
  sy: {}
  platform: {mass: 2, inertia: {cylinder: {axis: z, radius: 0.2, length: 0.02}}}
joints:
  x: {type: prismatic, parent: base, child: sx, origin: {xyz: [0, 0, 0.7]}, axis: x}
  y: {type: prismatic, parent: sx, child: sy, axis: y}
  z: {type: prismatic, parent: sy, child: platform, axis: z}
"""


def leg(name: str, angle: float) -> str:
    """The leg of the 3-UPU module, joint by joint."""
    return f"""\
  leg_{name}:
    on: base
    joints:
      - name: phi10_{name}
        type: revolute
        axis: z
        offset: d
        origin: [{{rpy: [0, 0, {angle}]}}, {{xyz: [0.5, 0, 0], rpy: [0, pi, 0]}}]
      - {{name: phi21_{name}, type: revolute, axis: y, offset: b, link: barrel_{name},
         body: {{mass: 1, com: [0.1, 0, 0]}}}}
      - {{name: lambda_{name}, type: prismatic, axis: x, offset: l, limits: [-0.2, 0.3]}}
    to: {{platform: [0.2*cos({angle} + 0.4), 0.2*sin({angle} + 0.4), 0]}}
"""


NUMBERS = """\
parameters:
  a: 0.2*sin(0.4)
  i: 0.5 - 0.2*cos(0.4)
  f: sqrt(a*a + i*i)
  d: atan2(a, i)
  b: atan2(0.7, f)
  l: sqrt(f*f + 0.7*0.7)
"""
ANGLES = ["0", "2*pi/3", "4*pi/3"]
LEGS = "legs:\n" + "".join(leg(name, angle) for name, angle in zip("ABC", ANGLES, strict=True))  # type: ignore[arg-type]
TAIL = "active: [lambda_A, lambda_B, lambda_C]\nend_effector: {link: platform}\n"
TEXT = HEAD + NUMBERS + PLATFORM + LEGS + TAIL


def test_legs_written_out_are_those_of_the_template() -> None:
    ours = parse(TEXT)
    parameters = "{base_radius: 0.5, platform_radius: 0.2, height: 0.7, twist: 0.4}"
    theirs = parse(
        HEAD
        + f"modules: {{m: {{template: 3-UPU, on: base, parameters: {parameters}}}}}\n"
        + TAIL.replace("platform", "m_platform")
    )
    pose = {"x": 0.1, "y": -0.05, "z": 0.07}
    a, b = close(ours, pose, {}), close(theirs, pose, {})
    assert a == pytest.approx(b, abs=1e-13)
    assert freedom(ours, a) == 3


def test_names_bodies_and_limits() -> None:
    robot = parse(TEXT)
    assert [n for n in robot.links if n.endswith("_A") or "_A_" in n] == [
        "leg_A_1",
        "barrel_A",
        "leg_A_3",
    ]
    assert robot.links["barrel_A"].mass == 1
    assert robot.links["leg_A_1"].mass == 0
    assert robot.joints["lambda_A"].limits == (-0.2, 0.3)
    assert [c.name for c in robot.closures] == ["leg_A", "leg_B", "leg_C"]
    assert np.abs(gaps(robot, {})).max() < 1e-15


def test_end_kind_and_assembly() -> None:
    text = TEXT.replace(
        "    to: {platform: [0.2*cos(0 ",
        "    end: {xyz: [0.05, 0, 0], axis: y}\n    kind: axis\n    assembly: up\n    to:"
        " {platform: [0.2*cos(0 ",
    )
    closure = parse(text).closures[0]
    assert (closure.kind, closure.assembly) == ("axis", "up")
    assert closure.point_a == pytest.approx([0.05, 0, 0])
    assert closure.rotation_a[:, 2] == pytest.approx([0, 1, 0])
    assert closure.link_b == "platform"


def test_a_leg_of_five_joints() -> None:
    """Revolute, prismatic and a spherical wrist: a leg that leaves its platform all freedoms."""
    text = (
        HEAD
        + PLATFORM
        + """\
legs:
  L:
    joints:
      - {name: a, type: revolute, axis: z, origin: {xyz: [0.3, 0, 0]}}
      - {name: b, type: prismatic, axis: z, offset: 0.6}
      - {name: c, type: prismatic, axis: x, offset: 0.2}
      - {name: d, type: revolute, axis: x}
    kind: point
    end: [0, 0, 0.1]
    to: {platform: [0.5, 0, 0]}
active: [x, y, z, d]
end_effector: {link: platform}
"""
    )
    robot = parse(text)
    s = close(robot, {"x": 0.1, "y": 0.05, "z": 0.02, "d": 0.0}, {})
    assert np.abs(gaps(robot, s)).max() < 1e-13
    assert freedom(robot, s) == 4
    assert link_pose(robot, "L_4", s)[2, 3] == pytest.approx(0.62)


WRONG = {
    "no such link": (
        "to: {platform:",
        "to: {platfrom:",
        "legs.leg_A.to.platfrom",
        "did you mean 'platform'",
    ),
    "no such ground": ("on: base", "on: floor", "legs.leg_A.on", "no link 'floor'"),
    "no joints": (
        "axis: z\n        offset",
        "axsi: z\n        offset",
        "legs.leg_A.joints[0].axsi",
        "did you mean 'axis'",
    ),
    "name used twice": (
        "phi10_B",
        "phi10_A",
        "legs.leg_B.joints[0]",
        "given twice in joints (first in line",
    ),
    "link used twice": (
        "link: barrel_B",
        "link: barrel_A",
        "legs.leg_B.joints[1]",
        "given twice in links (first in line",
    ),
    "slip in a pose": (
        "xyz: [0.5, 0, 0]",
        "xyz: [r, 0, 0]",
        "legs.leg_A.joints[0].origin[1].xyz[0]",
        "'r' is not one of",
    ),
    "negative mass": ("mass: 1", "mass: -1", "legs.leg_A.joints[1].body.mass", "zero or positive"),
    "limits": ("[-0.2, 0.3]", "[0.3, -0.2]", "legs.leg_A.joints[2].limits", "not below"),
    "two platforms": (
        "to: {platform:",
        "to: {base: [0, 0, 0], platform:",
        "legs.leg_A.to",
        "2 entries; expected 1",
    ),
    "kind": (
        "    to:",
        "    kind: ball\n    to:",
        "legs.leg_A.kind",
        "expected one of planar, point",
    ),
}


@pytest.mark.parametrize(("old", "new", "key", "words"), WRONG.values(), ids=WRONG.keys())
def test_wrong_legs(old: str, new: str, key: str, words: str) -> None:
    changed = TEXT.replace(old, new, 1)
    assert changed != TEXT
    with pytest.raises(DescriptionError) as caught:
        parse(changed)
    assert words in str(caught.value)
    assert caught.value.key == key
    line = TEXT[: TEXT.index(old)].count("\n") + 1
    assert caught.value.line in (line, line + 1)
