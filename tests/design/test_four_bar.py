"""Four-bars by Freudenstein's equation and Burmester's theory do what they were made for."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import InputError
from hybrid_dynamics_core.design import (
    FourBar,
    burmester,
    centre,
    chebyshev_lambda,
    freudenstein,
    straight_line,
    straightness,
    through_poses,
)
from hybrid_dynamics_core.kernels.run import VARIABLE
from tests.sampling import examples


@pytest.fixture(autouse=True)
def _without_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "python")


def rocker_angle(lengths: tuple[float, ...], crank: float, side: float = 1.0) -> float:
    """Angle of the rocker from the crank's, by the intersection of two circles."""
    ground, a, b, c = lengths
    start = a * np.array([np.cos(crank), np.sin(crank)])
    way = np.array([ground, 0.0]) - start
    size = np.hypot(*way)
    along = (b * b - c * c + size * size) / (2.0 * size)
    height = np.sqrt(b * b - along * along)
    normal = np.array([-way[1], way[0]]) / size
    pin = start + along * way / size + side * height * normal
    return float(np.arctan2(pin[1], pin[0] - ground))


def test_three_pairs_of_a_crank_rocker_give_its_lengths() -> None:
    lengths = (1.0, 0.3, 0.9, 0.7)
    crank = [0.4, 1.3, 2.5]
    bar = freudenstein(crank, [rocker_angle(lengths, angle) for angle in crank])
    assert np.allclose((bar.ground, bar.crank, bar.coupler, bar.rocker), lengths)


def test_function_points_of_a_logarithm() -> None:
    """Freudenstein's example: y = log10 x from 1 to 2 at Chebyshev's points."""
    x = 1.5 - 0.5 * np.cos(np.pi * np.array([1.0, 3.0, 5.0]) / 6.0)
    crank = np.deg2rad(45.0 + 60.0 * (x - 1.0))
    rocker = np.deg2rad(90.0 * np.log10(x) / np.log10(2.0))
    bar = freudenstein(crank, rocker)
    start = bar.crank * np.exp(1j * (bar.crank_angle + crank - crank[0]))
    pin = bar.ground + bar.rocker * np.exp(1j * (bar.rocker_angle + rocker - rocker[0]))
    assert np.allclose(np.abs(pin - start), bar.coupler, rtol=1e-9)
    robot = bar.robot()
    state = robot.close(robot.reference)
    assert state.s[robot.coordinates.index("rocker")] == pytest.approx(bar.rocker_angle)


@examples(24)
@given(seed=st.integers(0, 10_000))
def test_a_four_bar_closes_at_its_pairs(seed: int) -> None:
    rng = np.random.default_rng(seed)
    crank = np.sort(rng.uniform(0.3, 2.8, 3))
    rocker = np.sort(rng.uniform(0.3, 2.8, 3))
    try:
        bar = freudenstein(crank, rocker)
    except InputError:
        return
    a = bar.crank * np.exp(1j * (bar.crank_angle + crank - crank[0]))
    c = bar.ground + bar.rocker * np.exp(1j * (bar.rocker_angle + rocker - rocker[0]))
    assert np.allclose(np.abs(c - a), bar.coupler, rtol=1e-7)


def poses_of(lengths: tuple[float, ...], cranks: list[float]) -> np.ndarray:
    """Poses (N, 3) of the coupler of a four-bar."""
    ground, a, _, c = lengths
    poses = []
    for crank in cranks:
        rocker = rocker_angle(lengths, crank)
        start = a * np.array([np.cos(crank), np.sin(crank)])
        pin = np.array([ground, 0.0]) + c * np.array([np.cos(rocker), np.sin(rocker)])
        way = pin - start
        poses.append([*start, np.arctan2(way[1], way[0])])
    return np.array(poses)


def test_five_poses_of_a_four_bar_give_its_dyads() -> None:
    lengths = (1.0, 0.4, 0.9, 0.8)
    dyads = burmester(poses_of(lengths, [0.3, 0.9, 1.6, 2.2, 2.9]))
    assert len(dyads) in (2, 4)
    crank = min(dyads, key=lambda dyad: np.abs(dyad.fixed).max())
    rocker = min(dyads, key=lambda dyad: np.abs(dyad.fixed - (1.0, 0.0)).max())
    assert np.allclose(crank.fixed, 0.0, atol=1e-8)
    assert np.allclose(crank.moving, 0.0, atol=1e-8)
    assert crank.length == pytest.approx(0.4)
    assert np.allclose(rocker.fixed, (1.0, 0.0), atol=1e-8)
    assert np.allclose(rocker.moving, (0.9, 0.0), atol=1e-8)
    assert rocker.length == pytest.approx(0.8)
    bar = through_poses((crank, rocker), poses_of(lengths, [0.3]))
    assert np.allclose((bar.ground, bar.crank, bar.coupler, bar.rocker), lengths)
    assert bar.robot().close([bar.crank_angle]).s[0] == pytest.approx(0.3)


@examples(12)
@given(seed=st.integers(0, 10_000))
def test_every_dyad_keeps_its_length_at_all_five_poses(seed: int) -> None:
    rng = np.random.default_rng(seed)
    poses = np.column_stack([rng.uniform(-1.0, 1.0, (5, 2)), rng.uniform(-1.0, 1.0, 5)])
    dyads = burmester(poses)
    assert len(dyads) in (0, 2, 4)
    for dyad in dyads:
        c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
        x, y = dyad.moving
        places = poses[:, :2] + np.column_stack([c * x - s * y, s * x + c * y])
        lengths = np.linalg.norm(places - dyad.fixed, axis=1)
        assert np.allclose(lengths, dyad.length, rtol=1e-6)


def test_three_poses_and_a_point_give_its_circle() -> None:
    dyad = centre(poses_of((1.0, 0.4, 0.9, 0.8), [0.3, 1.6, 2.9]), [0.9, 0.0])
    assert np.allclose(dyad.fixed, (1.0, 0.0))
    assert dyad.length == pytest.approx(0.8)


def test_wrong_arguments_get_one_line() -> None:
    with pytest.raises(InputError, match="equally many angles"):
        freudenstein([0.1, 0.2], [0.1, 0.2])
    with pytest.raises(InputError, match="do not determine"):
        freudenstein([0.1, 0.1, 0.1], [0.2, 0.2, 0.2])
    with pytest.raises(InputError, match=r"expected \(5, 3\)"):
        burmester(np.zeros((4, 3)))
    with pytest.raises(InputError, match="on a line"):
        centre([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], [0.0, 0.0])


def test_chebyshevs_straight_line() -> None:
    """Ground 4, crank and rocker 5, coupler 2: its middle stays at height 4 from x = 0 to 4."""
    bar = FourBar(4.0, 5.0, 2.0, 5.0, float(np.arctan2(4.0, 3.0)), float(np.arctan2(4.0, -3.0)))
    robot = bar.robot()
    assert np.allclose(robot.forward_kinematics(robot.close(robot.reference)).position, (2, 4, 0))
    ends = np.arctan2(3.0, 4.0) + 1e-6, np.pi / 2.0 - 1e-6  # where the coupler stands upright
    for angle, x in zip(ends, (4.0, 0.0), strict=True):
        path = robot.close_path(np.linspace(bar.crank_angle, angle, 40)[:, None])
        places = robot.forward_kinematics(path).position
        assert np.allclose(places[-1, :2], (x, 4.0), atol=0.01)
        assert np.abs(places[:, 1] - 4.0).max() < 0.02


@pytest.mark.parametrize("away", [0.0, 10.0, 1e3])
def test_a_circle_does_not_depend_on_the_origin(away: float) -> None:
    poses = poses_of((0.01, 0.004, 0.009, 0.008), [0.3, 1.6, 2.9])
    poses[:, :2] += away
    dyad = centre(poses, [0.009, 0.0])
    assert np.allclose(dyad.fixed, (0.01 + away, away), atol=1e-8)
    assert dyad.length == pytest.approx(0.008, rel=1e-6)


def test_chebyshevs_lambda_goes_four_cranks_on_a_half_turn() -> None:
    """Its point goes 4 cranks in half a turn of the crank, straight to 0.25 % of that."""
    found = chebyshev_lambda(crank=0.2).straightness()
    assert found.length == pytest.approx(0.8, rel=1e-5)
    assert 0.0024 < found.ratio < 0.0025


def test_a_coupler_point_is_where_the_robot_has_it() -> None:
    line = chebyshev_lambda()
    robot = line.bar.robot()
    middle = np.array([0.5 * line.bar.coupler, 0.0])  # the end effector
    cranks = np.pi + np.array([-0.8, 0.0, 0.9])
    places = line.bar.coupler_path(middle, cranks)
    state = robot.close(cranks[:, None])
    assert np.allclose(robot.forward_kinematics(state).position[:, :2], places, atol=1e-9)


def test_chebyshevs_two_straight_lines_are_cognates() -> None:
    """Roberts and Chebyshev: the lambda mechanism and the crossed bars 4, 5, 2, 5 draw one curve.

    The middle of the crossed coupler has the height 4 at its ends and in the middle of the line.
    Both curves are sampled, which leaves 1e-4 of their deviations.
    """
    half = np.arctan2(4.0, 3.0)
    crossed = FourBar(4.0, 5.0, 2.0, 5.0, half, np.pi - half)
    three = crossed.coupler_path([1.0, 0.0], [np.arctan2(3.0, 4.0), half, np.pi / 2.0])
    assert np.allclose(three[:, 1], 4.0)
    cranks = np.linspace(np.arctan2(3.0, 4.0), np.pi / 2.0, 2000)
    found = straightness(crossed.coupler_path([1.0, 0.0], cranks))
    other = chebyshev_lambda().straightness()
    assert found.length == pytest.approx(other.length, rel=1e-5)
    assert found.deviation == pytest.approx(other.deviation, rel=1e-3)


@pytest.mark.parametrize(
    ("span", "ground", "coupler"), [(60.0, 2.900, 3.850), (100.0, 2.725, 3.588)]
)
def test_nortons_table_of_straight_lines(span: float, ground: float, coupler: float) -> None:
    """Proportions in cranks; the table's are rounded to steps of 1/40."""
    found = straight_line(np.deg2rad(span))
    assert found.bar.ground == pytest.approx(ground, abs=0.0125)
    assert found.bar.coupler == pytest.approx(coupler, abs=0.0125)
    assert (
        found.straightness().ratio
        < 0.5 * chebyshev_lambda(span=np.deg2rad(span)).straightness().ratio
    )


@examples(24)
@given(seed=st.integers(0, 10_000))
def test_straightness_turns_and_grows_with_the_points(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(20, 2)) * [3.0, 0.1]
    found = straightness(points)
    turn = np.exp(1j * rng.uniform(0.0, 6.0)) * rng.uniform(0.5, 2.0)
    other = (points @ [1.0, 1j]) * turn + complex(3.0, -1.0)
    moved = straightness(np.column_stack([other.real, other.imag]))
    assert moved.deviation == pytest.approx(abs(turn) * found.deviation, rel=1e-9)
    assert moved.ratio == pytest.approx(found.ratio, rel=1e-9)
    directions = np.linspace(0.0, np.pi, 2000)
    normals = np.array([np.cos(directions), np.sin(directions)])
    assert found.deviation <= np.ptp(points @ normals, axis=0).min() + 1e-12


def test_wrong_lines_get_one_line() -> None:
    with pytest.raises(InputError, match="span is 4 rad; expected more than 0"):
        straight_line(4.0)
    with pytest.raises(InputError, match="not all the same"):
        straightness([[1.0, 1.0]])
    with pytest.raises(InputError, match="does not close where its crank is at 3"):
        FourBar(1.0, 1.0, 0.3, 0.5, 0.5, 1.0).coupler_path([1.0, 0.0], [0.5, 3.0])
    assert straightness([[0.0, 0.0], [1.0, 1.0]]).deviation == pytest.approx(0.0, abs=1e-12)
