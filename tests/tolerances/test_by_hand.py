"""Errors of a two-bar and of a slider-crank, whose formulas are short."""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core.tolerances import Play, Tolerance, ToleranceAnalysis
from tests.tolerances.linkages import SLIDER_CRANK, TWO_BAR, robot

DIFFERENCES = 1e-8  # relative: central differences over 1e-5 of the reach leave 1e-10 and rounding
CHI_95 = {1: 1.959963985, 2: 2.447746831, 3: 2.795483483}  # quantiles of chi's distribution
TURN = 0.8


@pytest.fixture(name="crank", scope="module")
def slider_crank():
    return robot(SLIDER_CRANK)


def angle_of_rod(turn: float) -> float:
    """Angle of the connecting rod below the slide."""
    return np.arcsin(0.1 * np.sin(turn) / 0.3)


def test_two_bar_has_the_columns_of_its_geometry():
    analysis = ToleranceAnalysis(
        robot(TWO_BAR),
        {"L1": 1e-4, "L2": 2e-4, "joints.q1.offset": 1e-3, "joints.q2.play": 5e-5},
    )
    linear = analysis.linear([0.4, 0.9])
    along_1 = np.array([np.cos(0.4), np.sin(0.4), 0.0])
    along_2 = np.array([np.cos(1.3), np.sin(1.3), 0.0])
    tip = 0.5 * along_1 + 0.3 * along_2
    expected = {"L1": along_1, "L2": along_2, "joints.q1.offset": np.cross([0.0, 0.0, 1.0], tip)}
    for name, column in expected.items():
        measured = linear.contributions[name].sensitivity[0, :3, 0]
        np.testing.assert_allclose(measured, column, atol=DIFFERENCES)
    turn = linear.contributions["joints.q1.offset"].sensitivity[0, 3:, 0]
    np.testing.assert_allclose(turn, [0.0, 0.0, 1.0], atol=DIFFERENCES)
    play = linear.contributions["joints.q2.play"].sensitivity[0, :3]
    np.testing.assert_allclose(play @ play.T, np.diag([1.0, 1.0, 0.0]), atol=DIFFERENCES)


def test_two_bar_adds_variances_and_sizes():
    pair = {"L1": Tolerance(3e-4), "L2": Tolerance(6e-4)}
    linear = ToleranceAnalysis(robot(TWO_BAR), pair).linear([0.0, np.pi / 2])
    np.testing.assert_allclose(linear.deviation[0, :3], [1e-4, 2e-4, 0.0], atol=1e-12)
    np.testing.assert_allclose(linear.worst, np.hypot(3e-4, 6e-4), rtol=DIFFERENCES)
    assert linear.shares["L2"] == pytest.approx(0.8, rel=DIFFERENCES)
    stretched = ToleranceAnalysis(robot(TWO_BAR), pair).linear([0.3, 0.0])
    np.testing.assert_allclose(stretched.worst, 9e-4, rtol=DIFFERENCES)
    # one direction only: the normal law in one dimension
    np.testing.assert_allclose(stretched.likely, CHI_95[1] * np.hypot(1e-4, 2e-4), rtol=1e-6)


def test_slider_crank_follows_its_closed_form(crank):
    u = np.linspace(0.1, 6.0, 7)[:, None]
    linear = ToleranceAnalysis(crank, {"crank": 1e-5, "rod": 1e-5, "height": 1e-5}).linear(u)
    beta = angle_of_rod(u[:, 0])
    expected = {
        "crank": np.cos(u[:, 0]) - np.tan(beta) * np.sin(u[:, 0]),
        "rod": 1.0 / np.cos(beta),
        "height": np.tan(beta),
    }
    for name, column in expected.items():
        measured = linear.contributions[name].sensitivity[:, 0, 0]
        np.testing.assert_allclose(measured, column, atol=DIFFERENCES)


def test_play_of_the_small_end_moves_the_piston_along_the_rod(crank):
    beta = angle_of_rod(TURN)
    free = ToleranceAnalysis(crank, {"closures.small_end.play": 4e-5}).linear([TURN])
    np.testing.assert_allclose(free.worst, 4e-5 / np.cos(beta), rtol=DIFFERENCES)
    # uniform within a circle: a quarter of the radius squared in each direction
    np.testing.assert_allclose(free.deviation[0, 0], 2e-5 / np.cos(beta), rtol=DIFFERENCES)


def test_a_pressed_pin_moves_to_one_side(crank):
    beta = angle_of_rod(TURN)
    pressed = ToleranceAnalysis(crank, {"closures.small_end.play": Play(4e-5, (1.0, 0.0, 0.0))})
    linear = pressed.linear([TURN])
    np.testing.assert_allclose(linear.shift[0, 0], 4e-5, rtol=DIFFERENCES)
    np.testing.assert_allclose(linear.worst, 4e-5, rtol=DIFFERENCES)
    np.testing.assert_allclose(linear.likely, 4e-5, rtol=DIFFERENCES)
    assert not any(linear.shares.values())
    across = ToleranceAnalysis(crank, {"closures.small_end.play": "0.04*mm towards 0 -1 0"}).linear(
        [TURN]
    )
    np.testing.assert_allclose(across.shift[0, 0], 4e-5 * np.tan(beta), rtol=1e-6)
    exact = pressed.monte_carlo([TURN], count=2)
    np.testing.assert_allclose(exact.errors[:, 0, 0], 4e-5, rtol=1e-3)  # second order: 4e-5 / 0.1


@pytest.mark.parametrize(("axes", "dimensions"), [("x", 1), ("xy", 2), ("xyz", 3)])
def test_likely_error_of_equal_axes_is_chi(axes, dimensions):
    table = {f"end_effector.xyz[{k}]": 3e-5 for k in range(len(axes))}
    linear = ToleranceAnalysis(robot(TWO_BAR), table).linear([0.2, 0.3])
    # 24 nodes of the quadrature: two axes leave 2e-6
    np.testing.assert_allclose(linear.likely, CHI_95[dimensions] * 1e-5, rtol=1e-5)


def test_halving_the_largest_share_brings_most():
    table = {"L1": 1e-4, "L2": 3e-4}
    analysis = ToleranceAnalysis(robot(TWO_BAR), table)
    linear = analysis.linear([0.0, 0.0])
    expected = {"L1": np.hypot(0.5, 3.0), "L2": np.hypot(1.0, 1.5)}
    for name, size in expected.items():
        assert linear.halved[name] == pytest.approx(CHI_95[1] * size * 1e-4 / 3.0, rel=1e-6)


def test_a_single_play_is_not_likely_beyond_its_hole():
    """The normal law of a disc has 95 % within 1.22 of its radius."""
    table = {"joints.q2.play": 1e-5, "L1": Tolerance(1e-9)}
    linear = ToleranceAnalysis(robot(TWO_BAR), table).linear([0.2, 0.3])
    assert linear.normal_sizes[0, 0] > 1.2e-5
    np.testing.assert_allclose(linear.likely, linear.worst)
    rare = ToleranceAnalysis(robot(TWO_BAR), {"L1": Tolerance(1e-5, sigmas=1.0)})
    outside = rare.linear([0.2, 0.3])  # a third of all lengths is outside
    np.testing.assert_allclose(outside.likely, CHI_95[1] * 1e-5, rtol=1e-5)


def test_the_tool_of_a_bare_arm_moves_with_its_length():
    """The only joint is at the base, so only the tool gives the robot its reach."""
    arm = robot(
        """
format: 1
name: arm
parameters: {L: 2.5}
links: {bar: {mass: 1, com: [0.5, 0, 0]}}
joints: {q1: {type: revolute, parent: base, child: bar, axis: z, limits: [-1, 1]}}
active: [q1]
end_effector: {link: bar, xyz: [L, 0, 0]}
"""
    )
    linear = ToleranceAnalysis(arm, {"L": 3e-4, "joints.q1.offset": 1e-4}).linear([0.6])
    along = [np.cos(0.6), np.sin(0.6), 0.0]
    across = [-2.5 * np.sin(0.6), 2.5 * np.cos(0.6), 0.0]
    columns = {"L": along, "joints.q1.offset": across}
    for name, column in columns.items():
        measured = linear.contributions[name].sensitivity[0, :3, 0]
        np.testing.assert_allclose(measured, column, atol=DIFFERENCES)
