"""Grams in place of kilograms are reported; heavy tools, foundations, shipped robots are not."""

from __future__ import annotations

import pytest

from hybrid_dynamics_core import load, shipped_robots
from hybrid_dynamics_core.description.checks.plausible_masses import MEDIAN_RATIO, NEXT_RATIO
from hybrid_dynamics_core.description.model import Link
from tests.description.robots import HEAD, parse

ARM = (
    HEAD
    + """\
links:
  base: {mass: BASE}
  pillar: {mass: BASE}
  upper: {mass: UPPER}
  fore: {mass: FORE}
  hand: {mass: HAND}
  bare: {}
joints:
  stands: {type: fixed, parent: base, child: pillar}
  shoulder: {type: revolute, parent: base, child: upper, axis: z}
  elbow: {type: revolute, parent: upper, child: fore, origin: {xyz: [0.5, 0, 0]}, axis: z}
  wrist: {type: revolute, parent: fore, child: hand, origin: {xyz: [0.5, 0, 0]}, axis: z}
  nothing: {type: revolute, parent: hand, child: bare, axis: z}
active: [shoulder, elbow, wrist, nothing]
end_effector: {link: hand}
"""
)


def warnings(upper: float, fore: float, hand: float, base: float = 0.0) -> tuple[str, ...]:
    text = ARM
    for name, mass in (("BASE", base), ("UPPER", upper), ("FORE", fore), ("HAND", hand)):
        text = text.replace(name, str(mass))
    return parse(text).warnings


def test_grams_are_reported_where_they_stand() -> None:
    (warning,) = warnings(2.4, 1600.0, 0.7)
    line = 1 + (HEAD + ARM.removeprefix(HEAD)).split("fore:")[0].count("\n")
    assert (
        warning
        == f"small.yaml:{line}: links.fore.mass: 1600 kg, and the median of the other links is 1.55"
        " kg: are these grams? Masses are in kilograms: 1600 g are written 1.6"
    )


@pytest.mark.parametrize(
    ("masses", "base"),
    [
        ((2.4, 1.6, 0.7), 5000.0),  # a foundation
        ((1.0, 1.0, MEDIAN_RATIO), 0.0),
        (
            (0.001, 4.0, 4.0 * NEXT_RATIO),
            0.0,
        ),  # a cross that has hardly a mass, beside a heavy tool
        ((0.0, 1.0, 2400.0), 0.0),  # one link alone is no measure
        ((0.0, 0.0, 0.0), 0.0),
    ],
)
def test_what_may_be_meant_is_accepted(masses: tuple[float, float, float], base: float) -> None:
    assert not warnings(*masses, base)


@pytest.mark.parametrize("name", shipped_robots())
def test_shipped_robots_stay_far_from_the_rule(name: str) -> None:
    assert not any("grams" in doubt for doubt in load(name).description.warnings)


@pytest.mark.parametrize("unit", [1e4, 1e6, 1e9])
def test_inertias_in_other_units_are_reported(unit: float) -> None:
    """In kg m^2 0.03, 0.04, 0.05: the hand reaches 0.1 m about its centre of mass, the arm 1 m."""
    moments = ", ".join(
        f"{key}: {unit * value}" for key, value in (("xx", 0.03), ("yy", 0.04), ("zz", 0.05))
    )
    text = ARM.replace("{mass: HAND}", f"{{mass: 5, inertia: {{{moments}}}}}")
    for name in ("BASE", "UPPER", "FORE"):
        text = text.replace(name, "5")
    (doubt,) = parse(text).warnings
    assert ": links.hand.inertia: its 5 kg would have to be" in doubt
    assert "1 g mm^2 is 1e-9" in doubt
    assert not parse(text.replace(moments, "xx: 0.03, yy: 0.04, zz: 0.05")).warnings


def test_a_link_of_which_nothing_is_said_has_no_mass_and_no_weight_taken_off() -> None:
    link = Link("a")
    assert (link.mass, link.compensated_mass, link.gravity_compensation) == (0.0, 0.0, 0.0)
    for part in (link.com, link.inertia, link.compensated_com):
        assert not part.any()
