"""Friction, drives, springs, payloads and cylinders in a description file."""

from __future__ import annotations

from importlib import resources

import numpy as np
import pytest

from hybrid_dynamics_core import DescriptionError, Robot
from hybrid_dynamics_core.formats.reader import parse_description

FILE = (
    resources.files("hybrid_dynamics_core")
    .joinpath("robots/forging_chu2020.yaml")
    .read_text(encoding="utf-8")
)
Q2 = "  q2:  {type: revolute, parent: l1, child: l2,"
WITH_EFFECTS = f"{Q2} friction: {{viscous: 3, coulomb: 2*1.5, smoothing: 0.01}},"
ACTIVE = "active: [q1, q12, q22, q4]\n"
PARTS = """
payloads:
  tongs: {on: end_effector, mass: m4/2, com: [0.1, 0, 0], inertia: {rod: {axis: x, length: 0.3}}}
  ballast: {on: l3, mass: 80, com: [-0.3, 0, 0]}
actuators:
  q12: {kind: hydraulic_cylinder, bore: 0.08, rod: 0.05, stroke: [-0.05, 0.65], return_pressure: 2e5}
"""  # noqa: E501


def changed(*pairs: tuple[str, str]) -> Robot:
    text = FILE
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new, 1)
    return Robot(parse_description(text))


def test_effects_become_loads() -> None:
    robot = changed(
        (Q2, WITH_EFFECTS),
        (
            "  q1:  {type: revolute,",
            (
                "  q1:  {type: revolute, drive: {rotor_inertia: 2e-4, gear_ratio: 100}, spring:"
                " {stiffness: 7, rest: 0.1},"
            ),
        ),
    )
    effects = robot.loads.effects
    k, q1 = robot.coordinates.index("q2"), robot.coordinates.index("q1")
    assert (effects.viscous[k], effects.coulomb[k], effects.smoothing[k]) == (3.0, 3.0, 0.01)
    assert effects.armature[q1] == pytest.approx(2.0)
    assert (effects.stiffness[q1], effects.rest[q1], effects.preload[q1]) == (7.0, 0.1, 0.0)
    assert np.count_nonzero(effects.viscous) == 1
    state = robot.close([0.3, 0.1, 0.15, 0.0])
    plain = robot.loads.with_effects(
        **dict.fromkeys(("viscous", "coulomb", "armature"), 0 * effects.viscous)
    )
    assert robot.inverse_dynamics(state, [1, 0, 0, 0])[0] - robot.inverse_dynamics(
        state, [1, 0, 0, 0], plain
    )[0] == pytest.approx(2.0)


def test_payloads_and_cylinders() -> None:
    robot = changed((ACTIVE, ACTIVE + PARTS))
    (tongs,), (ballast,) = robot.loads.payloads["end_effector"], robot.loads.payloads["l3"]
    assert (tongs.mass, ballast.mass) == (73.1 / 2, 80.0)
    assert np.diag(tongs.inertia) == pytest.approx(
        [0.0, 73.1 / 2 * 0.09 / 12, 73.1 / 2 * 0.09 / 12]
    )
    cylinder = robot.description.actuators["q12"]
    assert cylinder.cap_area == pytest.approx(np.pi / 4 * 0.08**2)
    assert cylinder.rod_area == pytest.approx(np.pi / 4 * (0.08**2 - 0.05**2))
    assert cylinder.stroke == (-0.05, 0.65)


@pytest.mark.parametrize(
    ("old", "new", "key", "words"),
    [
        (
            Q2,
            f"{Q2} friction: {{viscous: -3}},",
            "joints.q2.friction.viscous",
            "is -3; expected zero or positive",
        ),
        (Q2, f"{Q2} friction: {{smoothing: 0}},", "joints.q2.friction.smoothing", "above zero"),
        (Q2, f"{Q2} friction: {{damping: 3}},", "joints.q2.friction.damping", "unknown key"),
        (Q2, f"{Q2} drive: {{gear_ratio: 3}},", "joints.q2.drive", "missing 'rotor_inertia'"),
        (
            Q2,
            f"{Q2} drive: {{rotor_inertia: -1}},",
            "joints.q2.drive.rotor_inertia",
            "zero or positive",
        ),
        (Q2, f"{Q2} spring: {{stiffness: soft}},", "joints.q2.spring.stiffness", "soft"),
        (
            ACTIVE,
            ACTIVE + PARTS.replace("on: l3", "on: l99"),
            "payloads.ballast.on",
            "no link or frame 'l99'",
        ),
        (
            ACTIVE,
            ACTIVE + PARTS.replace("mass: 80", "mass: -80"),
            "payloads.ballast",
            "not -80.0 kg",
        ),
        (
            ACTIVE,
            ACTIVE + PARTS.replace("  q12: {kind", "  q99: {kind"),
            "actuators.q99",
            "no joint 'q99'",
        ),
        (
            ACTIVE,
            ACTIVE + PARTS.replace("  q12: {kind", "  q2: {kind"),
            "actuators.q2",
            "is revolute",
        ),
        (
            ACTIVE,
            ACTIVE + PARTS.replace("rod: 0.05", "rod: 0.09"),
            "actuators.q12.rod",
            "less than the bore",
        ),
        (
            ACTIVE,
            ACTIVE + PARTS.replace("[-0.05, 0.65]", "[0.65, -0.05]"),
            "actuators.q12.stroke",
            r"is \[0.65, -0.05\] m; expected the lower end below",
        ),
        (
            ACTIVE,
            ACTIVE + PARTS.replace("2e5", "-1"),
            "actuators.q12.return_pressure",
            "is -1 Pa; expected zero or positive",
        ),
        (
            ACTIVE,
            ACTIVE + PARTS.replace("2e5", "9e9, supply_pressure: 2e7"),
            "actuators.q12.return_pressure",
            "is 9e.09 Pa; expected less than the supply pressure, 2e.07 Pa",
        ),
    ],
)
def test_wrong_entries_are_refused(old: str, new: str, key: str, words: str) -> None:
    with pytest.raises(DescriptionError, match=words) as caught:
        changed((old, new))
    assert caught.value.key == key
    assert caught.value.line is not None
