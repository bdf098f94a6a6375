"""Laws of tolerances, on shipped and on random robots."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import InputError, Robot, load, shipped_robots
from hybrid_dynamics_core.calibration.loop_choices import with_general_bars
from hybrid_dynamics_core.description.geometry import rotation_from_rpy
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.kernels.run import VARIABLE
from hybrid_dynamics_core.tolerances import ToleranceAnalysis
from hybrid_dynamics_core.tolerances.bounds import SPACING, farthest, likely
from tests.generated.class_three import class_three
from tests.generated.robots import as_text, examples, moved
from tests.robots import robot as shipped
from tests.sampling import swept
from tests.tolerances.chosen import random_table

DIFFERENCES = 1e-7  # relative: central differences near dead centres, where slopes are steep
SEEDS = st.integers(0, 999)


@pytest.fixture(autouse=True)
def _without_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "python")


def laws(robot: Robot, seed: int) -> None:
    """What holds for every table."""
    rng = np.random.default_rng(seed)
    table = random_table(robot, rng)
    if not table:
        return
    u = robot.reference + 0.01 * rng.standard_normal((2, len(robot.reference)))
    linear = ToleranceAnalysis(robot, table).linear(u)
    size = linear.worst
    assert (linear.likely <= size * (1.0 + 1e-9)).all()
    assert (linear.likely_rotation <= linear.worst_rotation * (1.0 + 1e-9)).all()
    assert sum(linear.shares.values()) == pytest.approx(
        1.0 if size.max() > 1e-12 else 0.0, abs=1e-9
    )
    doubled = ToleranceAnalysis(robot, {name: 2.0 * half for name, half in table.items()}).linear(u)
    for one, other in ((linear.likely, doubled.likely), (linear.worst, doubled.worst)):
        np.testing.assert_allclose(other, 2.0 * one, rtol=1e-9, atol=1e-15)
    backward = ToleranceAnalysis(robot, dict(reversed(table.items()))).linear(u)
    np.testing.assert_allclose(backward.worst, size, rtol=1e-9, atol=1e-15)
    for name, share in linear.shares.items():
        assert backward.shares[name] == pytest.approx(share, abs=1e-9)
        assert linear.halved[name] <= linear.likely.max() * (1.0 + 1e-9)


@pytest.mark.parametrize("name", swept(shipped_robots(), ("palletizer",)))
def test_laws_of_shipped_robots(name: str) -> None:
    laws(load(name), 3)


@examples(24)
@given(case=class_three(4, 2), seed=SEEDS)
def test_laws_of_random_robots(case, seed: int) -> None:
    laws(Robot(parse_description(as_text(case.description))), seed)


@examples(24)
@given(case=class_three(4, 2), seed=SEEDS)
def test_errors_are_those_of_the_robot_mounted_elsewhere(case, seed: int) -> None:
    robot = Robot(parse_description(as_text(case.description)))
    rng = np.random.default_rng(seed)
    rotation = rotation_from_rpy(*rng.uniform(-3.0, 3.0, 3))
    description = moved(case.description, rotation, rng.uniform(-1.0, 1.0, 3))
    other = Robot(parse_description(as_text(description)))
    plays: dict[str, float] = {}
    for joint in robot.description.joints:
        plays[f"joints.{joint}.play"] = float(rng.uniform(1e-5, 1e-4))
    plays["end_effector.xyz"] = 5e-5
    here = ToleranceAnalysis(robot, plays).linear(robot.reference)
    there = ToleranceAnalysis(other, plays).linear(robot.reference)
    np.testing.assert_allclose(there.likely, here.likely, rtol=1e-5)  # nodes of the quadrature
    np.testing.assert_allclose(there.worst, here.worst, rtol=1.0 - np.cos(SPACING))
    turned = rotation @ here.covariance[0, :3, :3] @ rotation.T
    size = np.abs(turned).max()
    np.testing.assert_allclose(there.covariance[0, :3, :3], turned, atol=DIFFERENCES * size)


# -- sensitivities

FAMILIES = {
    "delta": ("modules.delta.parameters.arm", "modules.delta.parameters.rod"),
    "excavator": ("boom", "loops.bucket_bars.pin.bucket[0]", "joints.slew.offset"),
    "five_bar": ("crank", "joints.q_L.offset"),
    "forging_chu2020": ("L2", "L3", "b3"),
    "palletizer": ("L2", "rear", "bx"),
}


@pytest.mark.parametrize("name", swept(FAMILIES, ("forging_chu2020",)))
def test_sensitivities_are_the_derivatives_of_the_compiled_formulas(name: str) -> None:
    robot = shipped(name)
    u = robot.reference + 0.02
    exact = robot.free(*FAMILIES[name]).forward_kinematics(u).by_parameters["position"]
    table = dict.fromkeys(FAMILIES[name], 1e-4)
    linear = ToleranceAnalysis(robot, table).linear(u)
    measured = [linear.contributions[path].sensitivity[0, :3, 0] for path in FAMILIES[name]]
    size = np.abs(exact).max()
    np.testing.assert_allclose(np.transpose(measured), exact, atol=1e-8 * size)


def test_a_bar_of_a_parallelogram_varies_alone() -> None:
    """The robot with that bar is no palletizer any more, and is built again as four-bars."""
    robot = shipped("palletizer")
    path = "joints.p5.origin.xyz[0]"
    start = 0.06
    step = 1e-5
    u = robot.reference
    linear = ToleranceAnalysis(robot, {path: 1e-4}).linear(u)
    ends = []
    for value in (start + step, start - step):
        key = ("joints", "p5", "origin", "xyz", 0)
        written = robot.description.written.changed({key: value})
        other = Robot(with_general_bars(written.described(), robot))
        ends.append(other.forward_kinematics(other.close(u)).position)
    expected = (ends[0] - ends[1]) / (2.0 * step)
    measured = linear.contributions[path].sensitivity[0, :3, 0]
    np.testing.assert_allclose(measured, expected, atol=1e-6)  # differences of the closed loops


# -- worst and likely sizes


@examples(120)
@given(seed=SEEDS, count=st.integers(1, 7), flat=st.booleans())
def test_the_worst_error_is_that_of_the_worst_corner(seed: int, count: int, flat: bool) -> None:
    rng = np.random.default_rng(seed)
    columns = rng.standard_normal((count, 3))
    if flat:
        columns[:, 2] = 0.0
    radii = rng.uniform(0.1, 2.0, count)
    shift = rng.standard_normal(3) * (seed % 2)
    corners = np.array(list(product((-1.0, 1.0), repeat=count)))
    truth = np.linalg.norm(shift + (corners * radii) @ columns, axis=1).max()
    balls = [(columns[k][None, :, None], radii[k]) for k in range(count)]
    found = float(np.linalg.norm(farthest(balls, shift[None])))
    assert found <= truth * (1.0 + 1e-12)
    assert found >= truth * np.cos(SPACING)  # what the start of the search warrants


@examples(60)
@given(seed=SEEDS, rank=st.integers(1, 3))
def test_the_likely_error_is_the_quantile_of_normal_errors(seed: int, rank: int) -> None:
    rng = np.random.default_rng(seed)
    root = rng.standard_normal((3, rank))
    shift = rng.standard_normal(3) * (seed % 2)
    count = 40_000
    drawn = shift + rng.standard_normal((count, rank)) @ root.T
    confidence = float(rng.uniform(0.5, 0.99))
    size = likely((root @ root.T)[None], shift[None], confidence)[0]
    share = (np.linalg.norm(drawn, axis=1) <= size).mean()
    deviation = np.sqrt(confidence * (1.0 - confidence) / count)
    assert abs(share - confidence) < 5.0 * deviation  # one example in two million is outside


# -- random robots


@pytest.mark.parametrize("law", ["normal", "uniform", "truncated"])
def test_random_robots_have_the_covariance_of_small_tolerances(law: str) -> None:
    robot = shipped("palletizer")
    table = {"L2": 1e-5, "joints.p5.origin.xyz[0]": 1e-5, "loops.drive.play": 1e-5}
    analysis = ToleranceAnalysis(robot, table, law=law)
    linear = analysis.linear(robot.reference)
    count = 4000
    sampled = analysis.monte_carlo(robot.reference, count, seed=5)
    size = np.trace(linear.covariance[0, :3, :3])
    apart = np.abs(sampled.covariance - linear.covariance)[0, :3, :3]
    # the kurtosis of these laws is at most 3: the deviation of a variance is sqrt(2 / count) of it
    assert apart.max() < 5.0 * np.sqrt(2.0 / count) * size
    assert np.abs(sampled.mean[0, :3]).max() < 5.0 * np.sqrt(size / count) + 1e-8
    assert not sampled.open_share.any()
    low, high = sampled.likely_interval[0]
    assert low <= sampled.likely[0] <= high
    assert sampled.largest[0] <= linear.worst[0] * (1.0 + 1e-3) or law == "normal"


def test_random_robots_approach_the_linear_ones() -> None:
    """What is left beside the linear part is of second order: a tenth gives a hundredth."""
    robot = shipped("excavator")
    u = robot.reference
    table = {"boom": 1e-3, "loops.boom_loop.pin.boom[0]": 1e-3, "joints.slew.offset": 1e-3}
    rests = []
    for factor in (1.0, 0.1):
        scaled = {name: factor * half for name, half in table.items()}
        analysis = ToleranceAnalysis(robot, scaled)
        errors = analysis.monte_carlo(u, 200, seed=1).errors[:, 0, :3]
        linear = analysis.linear(u)
        slopes = [linear.contributions[name].sensitivity[0, :3, 0] for name in table]
        rng = np.random.default_rng(1)
        drawn = [one.entry.drawn(rng, 200, 1)[:, 0] for one in analysis.variables]
        rest = errors - np.transpose(drawn) @ np.array(slopes)
        rests.append(np.abs(rest).max())
    assert rests[1] < 0.02 * rests[0]


def test_a_robot_that_does_not_close_is_no_number() -> None:
    analysis = ToleranceAnalysis(shipped("five_bar"), {"bar": "80*mm uniform", "crank": "80*mm"})
    sampled = analysis.monte_carlo(count=300)
    assert 0.0 < sampled.open_share[0] < 1.0
    is_open = np.isnan(sampled.errors).any(axis=2)[:, 0]
    assert np.isnan(sampled.errors[is_open]).all()
    assert is_open.mean() == sampled.open_share[0]


# -- mistakes

WRONG = {
    "L9": "no parameter 'L9'",
    "joints.q9.play": "no pin 'joints.q9.play'",
    "joints.q1.gain": "no part of the robot's geometry",
    "joints.p3.origin.rpy[0]": "cannot change",
    "links.column.mass": "no effect",
}


@pytest.mark.parametrize("path", WRONG)
def test_a_path_that_cannot_vary_is_named(path: str) -> None:
    with pytest.raises(InputError, match="tolerances: ") as caught:
        ToleranceAnalysis(shipped("palletizer"), {path: 1e-4}).linear()
    assert WRONG[path] in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("table", "part"),
    [
        ({}, "expected a table"),
        ({"L2": -1e-4}, "zero or more"),
        ({"L2": float("nan")}, "zero or more"),
        ({"L2": True}, "expected as"),
        ({"L2": "0.1*mm unifrom"}, "did you mean 'uniform'"),
        ({"L2": "0.1*mm towards 0 0 1"}, "only a play"),
        ({"joints.q2.play": "0.1*mm uniform"}, "no law"),
        ({"joints.q2.play": "0.1*mm towards 0 0 0"}, "expected a direction"),
        ({"joints.q2.play": "0.1*mm towards 1e-300 0 0"}, "expected a direction"),
        ({"L2": "0.1*kg"}, "kg"),
        ({"L2": "0.1*deg"}, "expected a length"),
        ({"joints.q2.play": "0.1*mrad"}, "expected a length"),
        ({"joints.p2.origin.xyz[0]": "0.1*deg"}, "expected a length"),
        ({"joints.q1.offset": "0.1*mm"}, "expected an angle"),
        ({"L2": 1e-4, " L2": 1e-4}, "given twice"),
    ],
)
def test_a_wrong_table_gets_one_line(table: dict, part: str) -> None:
    with pytest.raises(InputError) as caught:
        ToleranceAnalysis(shipped("palletizer"), table)
    assert part in str(caught.value)
    assert "\n" not in str(caught.value)


def test_arguments_are_checked() -> None:
    analysis = ToleranceAnalysis(shipped("palletizer"), {"L2": 1e-4})
    with pytest.raises(InputError, match="confidence is 1"):
        analysis.linear(confidence=1.0)
    with pytest.raises(InputError, match="u has no rows"):
        analysis.linear(np.zeros((0, 4)))
    with pytest.raises(InputError, match="seed is -1"):
        analysis.monte_carlo(seed=-1)
    with pytest.raises(InputError, match="range"):
        analysis.poses(ranges={"q2": (2.0, 1.0)})
    with pytest.raises(InputError, match="no frame 'hnad'"):
        ToleranceAnalysis(shipped("palletizer"), {"L2": 1e-4}, frame="hnad")
