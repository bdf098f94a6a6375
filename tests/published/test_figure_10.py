"""Chu et al. (2020), Figure 10: the four efforts along the paper's motion, and its assumptions.

The print shows curves without numbers. Compared are the reference values at full seconds, the
paper's full DAE with multipliers, and what docs/figure_10.md says of every assumption and misprint.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from importlib import resources
from pathlib import Path

import numpy as np
import pytest

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.control import JointTrajectory, efforts_along
from hybrid_dynamics_core.formats.reader import parse_description
from tests.published.test_forging_chu2020 import REFERENCE, close_to

ROBOTS = resources.files("hybrid_dynamics_core").joinpath("robots")
FILE = ROBOTS.joinpath("forging_chu2020.yaml").read_text(encoding="utf-8")
PAGE = (Path(__file__).parents[2] / "docs/figure_10.md").read_text(encoding="utf-8")
RATES = np.array([np.deg2rad(10), 0.01, 0.005, np.deg2rad(5)])
START = np.array([0.0, 0.1, 0.15, 0.0])
MOTION = JointTrajectory([0.0, 10.0], [START, START + 10.0 * RATES], [RATES, RATES])
T = np.linspace(0.0, 10.0, 101)


@pytest.fixture(scope="module")
def tau(forging: Robot) -> np.ndarray:
    return efforts_along(forging, MOTION, T)


def written(old: str, new: str) -> Robot:
    assert old in FILE
    return Robot(parse_description(FILE.replace(old, new)))


def change(robot: Robot, tau: np.ndarray) -> np.ndarray:
    """Largest change of tau_1, F12, F22 in parts of their largest values."""
    difference = np.abs(efforts_along(robot, MOTION, T) - tau).max(axis=0)
    return (difference / np.abs(tau).max(axis=0))[:3]


def test_motion_is_the_papers(tau: np.ndarray) -> None:
    for row in REFERENCE["trajectory"]:
        goal = MOTION(row["t"])
        assert goal.u == pytest.approx(row["u"], abs=1e-14)
        assert goal.du == pytest.approx(row["ud"], abs=1e-14)
        assert goal.ddu == pytest.approx(row["udd"], abs=1e-14)
        assert close_to(tau[round(10 * row["t"])], row["tau"])
    assert len(REFERENCE["trajectory"]) == 11


def test_curves_are_those_of_the_full_dae(forging: Robot, tau: np.ndarray) -> None:
    """tau and the multipliers of the DAE, Eq. 10, from the tree's terms and J_s, without R."""
    state = forging.close(MOTION(T).u, MOTION(T).du)
    terms = forging.spanning_terms(state)
    dds = forging.accelerations(state, np.zeros_like(state.u))
    for k in range(len(T)):
        force = terms.M[k] @ dds[k] + terms.C[k] @ state.ds[k] + terms.g[k]
        unknowns = np.hstack([np.eye(12)[:, :4], -terms.J[k].T])
        answer = np.linalg.solve(unknowns, force)
        assert answer[:4] == pytest.approx(tau[k], rel=1e-10, abs=1e-10 * np.abs(force).max())


def test_page_prints_the_curves(tau: np.ndarray) -> None:
    cell = r" ([-\d.]+) \|"
    rows = re.findall(rf"^\|{5 * cell}$", PAGE, re.MULTILINE)
    assert len(rows) == 5
    for row in rows:
        t, *printed = map(float, row)
        efforts = tau[round(10 * t)]
        rounded = [round(efforts[0], 4), *np.round(efforts[1:3], 2), 0.0]
        assert printed == pytest.approx(rounded, abs=1e-9)


def test_no_torque_turns_the_level_gripper(tau: np.ndarray) -> None:
    assert np.abs(tau[:, 3]).max() < 1e-12


def short_rods(_: Robot) -> Robot:
    text = FILE.replace("L12: 0.4", "L12: 0.2").replace("L22: 0.4", "L22: 0.2")
    return Robot(parse_description(text))


def point_masses(forging: Robot) -> Robot:
    links = {}
    for name, link in forging.description.links.items():
        links[name] = replace(link, inertia=np.zeros((3, 3)))
    return Robot(replace(forging.description, links=links))


CHANGES: dict[str, tuple[Callable[[Robot], Robot], list[float]]] = {
    "l41 at L3/2": (
        lambda _: written("com: [(L3 - b3)/2, 0, 0]", "com: [L3/2, 0, 0]"),
        [0.019, 0.010, 0.008],
    ),
    "rods of 0.2 m": (short_rods, [0.007, 0.010, 0.0012]),
    "point masses": (point_masses, [0.080, 0.0000353, 0.0000558]),
}


@pytest.mark.parametrize("name", CHANGES)
def test_assumptions_are_worth_what_the_page_says(
    name: str, forging: Robot, tau: np.ndarray
) -> None:
    robot, parts = CHANGES[name]
    assert change(robot(forging), tau) == pytest.approx(parts, rel=0.07)  # the page's two digits


def test_axial_inertia_of_the_gripper_plays_no_part(tau: np.ndarray) -> None:
    assert change(written("{xx: m4*r4*r4/2, yy:", "{xx: 0, yy:"), tau).max() < 1e-12


def test_curves_are_weight(forging: Robot, tau: np.ndarray) -> None:
    inertia = efforts_along(forging, MOTION, T, forging.loads.with_gravity([0, 0, 0]))
    assert np.abs(inertia[:, 1:3]).max(axis=0) == pytest.approx([1.67, 1.46], abs=0.005)
    assert np.abs(inertia[:, 0] - tau[:, 0]).max() < 1e-11  # the column turns about the vertical


def test_errata_sign_of_j_z(forging: Robot, tau: np.ndarray) -> None:
    """ERRATA: with the Appendix's -df beside J_u = df/du, passive rows of R have the wrong sign."""
    state = forging.close(MOTION(5.0).u, MOTION(5.0).du)
    terms = forging.spanning_terms(state)
    force = terms.M @ forging.accelerations(state, np.zeros(4)) + terms.C @ state.ds + terms.g
    signs = np.array([1.0] * 4 + [-1.0] * 8)
    assert (state.R.T @ force)[1] == pytest.approx(tau[50, 1], rel=1e-10)
    assert ((signs[:, None] * state.R).T @ force)[1] == pytest.approx(-783.0, abs=0.5)


def test_errata_centre_of_mass_of_the_upper_arm(forging: Robot, tau: np.ndarray) -> None:
    """ERRATA: r_C2 is printed with S1 S2 for S1 C2 in y.

    Compared is R^T of m2 r'' . dr/d(q1, q2) of the one with that of the other.
    """
    mass = 50.6
    half = 0.35
    h = 1e-3  # [s] of second differences: 1e-6 of r'', rounding 1e-10

    def angles(t: np.ndarray) -> np.ndarray:
        """q1 and q2 (2, N)."""
        return forging.close(START + np.multiply.outer(t, RATES)).s[:, [0, 4]].T

    def place(printed: bool, q: np.ndarray) -> np.ndarray:
        q1, q2 = q
        y = np.sin(q1) * np.cos(q2)
        if printed:
            y = np.sin(q1) * np.sin(q2)
        return half * np.stack([np.cos(q1) * np.cos(q2), y, np.sin(q2)], axis=-1)

    before = angles(T - h)
    now = angles(T)
    after = angles(T + h)
    R = forging.close(MOTION(T).u).R[:, [0, 4], :]

    def efforts(printed: bool) -> np.ndarray:
        differences = place(printed, after) - 2.0 * place(printed, now) + place(printed, before)
        push = mass * differences / h**2
        along = []
        for step in 1e-5 * np.eye(2)[:, :, None]:
            slope = (place(printed, now + step) - place(printed, now - step)) / 2e-5
            along.append(np.einsum("ki,ki->k", push, slope))
        return np.einsum("kij,ki->kj", R, np.stack(along, axis=-1))

    change = efforts(printed=True) - efforts(printed=False)
    assert change[[0, 50, 100], 0] == pytest.approx([0.055, -0.0001, 0.017], abs=5e-4)  # errata.md
    assert change[np.abs(change[:, 1]).argmax(), 1] == pytest.approx(-0.44, abs=5e-3)
    worst = np.abs(change).max(axis=0)
    assert (worst / np.abs(tau).max(axis=0))[:2] == pytest.approx([0.24, 0.00028], rel=0.03)
    assert worst[2] < 1e-6
