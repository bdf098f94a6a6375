"""Staicu (2015): what docs/errata.md says of its misprints is so."""

from __future__ import annotations

import math
import re
from importlib import resources
from pathlib import Path

import numpy as np
import pytest

from hybrid_dynamics_core import Robot, load
from hybrid_dynamics_core.formats.reader import parse_description
from tests.published.test_staicu2015 import REFERENCE, law

ROBOTS = resources.files("hybrid_dynamics_core").joinpath("robots")
FILE = ROBOTS.joinpath("staicu2015.yaml").read_text(encoding="utf-8")
PAGE = (Path(__file__).parents[2] / "docs/errata.md").read_text(encoding="utf-8")
UPPER = [f"lambda_{leg}" for leg in "DEF"]


def upper_legs(robot: Robot, t: float) -> np.ndarray:
    """Extensions of legs D, E and F (3,) [m]."""
    state = robot.close_given(*law(t))
    return state.s[[robot.coordinates.index(name) for name in UPPER]]


def signed(values: np.ndarray) -> list[str]:
    return [re.sub(r"^\+0\.000$", "0", f"{value:+.3f}") for value in values]


def test_errata_no_two_upper_legs_move_alike() -> None:
    """ERRATA: Figures 6, 8 and 10 show two curves for three legs."""
    robot = load("staicu2015")
    ends = upper_legs(robot, 3.0)
    assert "legs D, E, F end at {}, {}, {} m".format(*signed(ends)) in PAGE
    for t in (0.5, 1.5, 3.0):
        d, e, f = upper_legs(robot, t)
        assert e == pytest.approx(0.0, abs=1e-12)
        assert d > 0.01
        assert f < -0.01


def test_errata_a_smaller_twist_would_nearly_give_the_figures() -> None:
    assert "nu_2: pi/3" in FILE
    robot = Robot(parse_description(FILE.replace("nu_2: pi/3", "nu_2: pi/6")))
    d, e, f = upper_legs(robot, 3.0)
    assert f"end at {d:+.3f} and {e:+.3f} m, and F at {f:.3f} m" in PAGE.replace("\n", " ")
    for t in (0.5, 1.5, 3.0):
        d, e, f = upper_legs(robot, t)
        assert abs(d - e) < 0.1 * abs(d)  # two curves nearly one
        assert abs(d - f) > abs(d)


def test_errata_second_line_of_9() -> None:
    """ERRATA: (9) prints sin where cos belongs in its second line, the radial part of a leg."""
    geometry = REFERENCE["geometry"]
    length = geometry["L10"]
    across = geometry["delta1"]  # phi10 and phi21 are zero in the central configuration
    up = geometry["beta1"]
    radial = geometry["r1"] * math.cos(math.pi / 6.0) - geometry["R1"]
    assert -length * math.cos(across) * math.cos(up) == pytest.approx(radial, abs=1e-12)
    for printed in (math.sin(across) * math.cos(up), math.cos(across) * math.sin(up)):
        assert abs(-length * printed - radial) == pytest.approx(1.0 / 3.0, abs=0.03)
