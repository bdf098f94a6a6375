"""What every converted trajectory keeps, on robots and motions nobody has seen.

The motion between points is drawn by SciPy's piecewise polynomials from the derivatives at the
points, and searched densely: neither uses what is tested.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.interpolate import BPoly

from hybrid_dynamics_core import Robot, load
from hybrid_dynamics_core.errors import HybridDynamicsError
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_ros.messages.joint_samples import RejectedError, RejectionCode
from hybrid_dynamics_ros.services.trajectory_conversion import Conversion, convert
from hybrid_dynamics_ros.services.trajectory_fit import completed
from hybrid_dynamics_ros.services.trajectory_follower import (
    _PARABOLA_ERROR as PARABOLA_ERROR,
)
from hybrid_dynamics_ros.services.trajectory_follower import (
    ConversionSettings,
    Sample,
)
from hybrid_dynamics_ros.services.trajectory_follower import (
    _lowest as lowest,
)
from hybrid_dynamics_ros.services.trajectory_limits import MotionLimits
from hybrid_dynamics_ros.services.trajectory_motion import SampledTrajectory
from tests.generated.case import Case
from tests.generated.class_three import class_three
from tests.generated.robots import STATES, examples

DENSE = 241  # moments at which a motion is searched
ROBOTS = class_three(3, 2)  # small: most of the time goes into making them


def gentle(robot: Robot, start: np.ndarray, seed: int) -> SampledTrajectory:
    """A motion of the active joints through random points near a configuration."""
    rng = np.random.default_rng(seed)
    time = np.cumsum(rng.uniform(0.2, 0.6, 4))
    shape = len(time), len(robot.active)
    return SampledTrajectory(
        robot.active,
        time,
        start + 0.02 * rng.normal(size=shape),
        0.1 * rng.normal(size=shape),
        0.3 * rng.normal(size=shape),
    )


def drawn(trajectory: SampledTrajectory, moments: np.ndarray) -> list[np.ndarray]:
    """Positions, velocities and accelerations (k, n) at some moments."""
    parts = (trajectory.position, trajectory.velocity, trajectory.acceleration)
    curve = BPoly.from_derivatives(trajectory.time, np.stack(parts, axis=1))
    return [curve(moments, order) for order in range(3)]


def states_of(robot: Robot, trajectory: SampledTrajectory, moments: np.ndarray):
    """Closed states and efforts at some moments, or an assumption that does not hold."""
    u, du, ddu = drawn(trajectory, moments)
    try:
        state = robot.close_path(u, du)
        return state, robot.inverse_dynamics(state, ddu)
    except HybridDynamicsError:
        assume(False)


def limited(robot: Robot, name: str, **limits: object) -> Robot:
    description = robot.description
    joints = {**description.joints, name: replace(description.joints[name], **limits)}
    return Robot(replace(description, joints=joints))


@examples(8)
@given(ROBOTS, STATES, st.sampled_from([0.1, 0.02]))
def test_efforts_between_two_points_are_linear_within_the_tolerance(
    case: Case, seed: int, tolerance: float
) -> None:
    robot = case.robot
    trajectory = gentle(robot, case.somewhere(seed)[: case.n], seed)
    moments = np.linspace(trajectory.time[0], trajectory.time[-1], DENSE)
    _, efforts = states_of(robot, trajectory, moments)
    converted = convert(robot, trajectory, None, ConversionSettings(tolerance=tolerance))
    assume(converted.problem is None)
    assert set(trajectory.time) <= set(converted.time)
    largest = np.maximum(np.abs(efforts).max(axis=0), np.abs(converted.efforts).max(axis=0))
    for joint in range(case.n):
        line = np.interp(moments, converted.time, converted.efforts[:, joint])
        off = np.abs(line - efforts[:, joint])
        assert off.max() <= tolerance * largest[joint] + 1e-6 * largest.max()


def require_first(bad_time: float, values: np.ndarray, limit: float, moments: np.ndarray) -> None:
    """No moment of the search is beyond the limit earlier; an island between two of them may be."""
    beyond = moments[values > limit]
    assert beyond.size == 0 or bad_time <= beyond[0] + 1e-6


LIMITS = {
    "position": "limits",
    "rate": "velocity_limit",
    "effort": "effort_limit",
    "power": "power_limit",
}


def sizes(
    kind: str, robot: Robot, trajectory: SampledTrajectory, moments: np.ndarray, place: int
) -> np.ndarray:
    """What a limit of one active joint is about, at some moments."""
    state, efforts = states_of(robot, trajectory, moments)
    values = {
        "position": state.u,
        "rate": np.abs(state.du),
        "effort": np.abs(efforts),
        "power": np.abs(efforts * state.du),
    }
    return values[kind][:, place]


@pytest.mark.parametrize("kind", list(LIMITS))
@examples(8)
@given(ROBOTS, STATES, st.floats(0.3, 0.95))
def test_the_first_time_beyond_a_limit_is_told_between_points_too(
    kind: str, case: Case, seed: int, share: float
) -> None:
    robot = case.robot
    trajectory = gentle(robot, case.somewhere(seed)[: case.n], seed)
    moments = np.linspace(trajectory.time[0], trajectory.time[-1], DENSE)
    place = seed % case.n
    name = robot.active[place]
    values = sizes(kind, robot, trajectory, moments, place)
    limit = float(share * values.max())
    if kind == "position":
        limit = float(values[0] + share * (values.max() - values[0]))
        assume(robot.reference[place] < limit)
    if kind in ("effort", "power"):
        assume(name in robot.drives and set(robot.drives) == set(robot.active) - set(robot.idle))
    assume(values.max() > limit + 1e-6 and values[0] < limit)
    bound = (-np.inf, limit) if kind == "position" else limit
    other = limited(robot, name, **{LIMITS[kind]: bound})
    assume(other.active == robot.active)
    assume(convert(robot, trajectory).problem is None)
    converted = convert(other, trajectory)
    assert converted.problem is not None
    assert converted.problem.code is RejectionCode.LIMIT
    require_first(converted.bad_time, values, limit, moments)
    there = sizes(kind, robot, trajectory, np.array([converted.bad_time]), place)
    assert there[0] >= limit - 1e-9 * (1.0 + abs(limit))
    assert converted.bad_point == np.searchsorted(trajectory.time, converted.bad_time)
    assert name in converted.problem.text
    assert f"{converted.bad_time:.9g} s" in converted.problem.text
    assert converted.time.max(initial=-np.inf) < converted.bad_time
    # How far it goes beyond, up to the next point, is that of a moment, and of none much less.
    excess, worst = excess_of(converted.problem.text)
    following = trajectory.time[converted.bad_point]
    assert converted.bad_time - 1e-6 <= worst <= following + 1e-6
    beyond = sizes(kind, robot, trajectory, np.array([worst, following]), place) - limit
    rounding = 1e-5 * (np.abs(values).max() + abs(limit))
    assert excess == pytest.approx(beyond[0], abs=rounding)
    assert excess >= beyond[1] - rounding


def excess_of(text: str) -> tuple[float, float]:
    """How far a motion goes beyond a bound, and when [s]."""
    excess, moment = re.search(r"up to (\S+) .*beyond, at (\S+) s", text).groups()
    return float(excess), float(moment)


@examples(8)
@given(ROBOTS, STATES)
def test_the_first_time_near_a_singular_place_is_told(case: Case, seed: int) -> None:
    robot = case.robot
    trajectory = gentle(robot, case.somewhere(seed)[: case.n], seed)
    moments = np.linspace(trajectory.time[0], trajectory.time[-1], DENSE)
    state, _ = states_of(robot, trajectory, moments)
    distance = np.asarray(state.singularity)
    least = 0.5 * (distance[0] + distance.min())
    assume(distance[0] > 1.001 * least > 1.002 * distance.min())
    assume(convert(robot, trajectory).problem is None)
    converted = convert(robot, trajectory, None, ConversionSettings(least=float(least)))
    assert converted.problem is not None
    assert converted.problem.code is RejectionCode.SINGULAR
    require_first(converted.bad_time, -distance, -least, moments)
    state, _ = states_of(robot, trajectory, np.array([converted.bad_time]))
    assert state.rows(0).singularity <= least


def test_pressures_beyond_the_supply_are_told_between_points() -> None:
    robot = load("excavator")
    trajectory = gentle(robot, robot.reference, 3)
    moments = np.linspace(trajectory.time[0], trajectory.time[-1], DENSE)
    state, efforts = states_of(robot, trajectory, moments)
    cylinder = robot.hydraulics(state, efforts)["boom_cylinder"]
    pressures = np.maximum(cylinder.cap_pressure, cylinder.rod_pressure)
    supply = 0.5 * (pressures[0] + pressures.max())
    assert pressures[0] < supply < pressures.max()
    description = robot.description
    actuators = dict(description.actuators)
    weaker = replace(actuators["boom_cylinder"], supply_pressure=float(supply))
    other = Robot(replace(description, actuators={**actuators, "boom_cylinder": weaker}))
    converted = convert(other, trajectory)
    assert converted.problem is not None
    assert "boom_cylinder" in converted.problem.text
    assert "Pa" in converted.problem.text
    require_first(converted.bad_time, pressures, supply, moments)
    state, efforts = states_of(robot, trajectory, np.array([converted.bad_time]))
    cylinder = robot.hydraulics(state, efforts)["boom_cylinder"]
    assert max(cylinder.cap_pressure[0], cylinder.rod_pressure[0]) >= (1.0 - 1e-9) * supply


def test_a_limit_that_is_passed_only_between_two_points_is_told() -> None:
    """At rest at both ends below the limit, and beyond it for a twentieth of the way."""
    robot = load("five_bar")
    time = np.array([0.0, 2.0])
    zero = np.zeros((2, len(robot.active)))
    start = np.array([robot.reference, robot.reference])
    pushed = zero.copy()
    pushed[:, 0] = 0.2
    trajectory = SampledTrajectory(robot.active, time, start, zero, pushed)
    u, _, _ = drawn(trajectory, np.linspace(0.0, 2.0, 2001))
    peak = u[:, 0].max()
    limit = peak - 1e-5 * (peak - u[0, 0])
    name = robot.active[0]
    other = limited(robot, name, limits=(-np.inf, float(limit)))
    converted = convert(other, trajectory)
    assert converted.problem is not None
    assert converted.problem.code is RejectionCode.LIMIT
    assert converted.bad_point == 1
    assert 0.9 < converted.bad_time < 1.0
    assert convert(limited(robot, name, limits=(-np.inf, peak + 1e-6)), trajectory).problem is None


SLIDE = """
{format: 1, name: slide, links: {base: {}, car: {mass: 2}}, active: [q], end_effector: {link: car},
 joints: {q: {type: prismatic, parent: base, child: car, axis: x, limits: [-9, 9]}}}
"""


@pytest.mark.parametrize("seed", range(10))
def test_a_power_that_turns_several_times_between_two_points_is_met(seed: int) -> None:
    """Of a mass on a slide: mass times acceleration times velocity."""
    robot = Robot(parse_description(SLIDE))
    trajectory = gentle(robot, np.zeros(1), seed)
    moments = np.linspace(trajectory.time[0], trajectory.time[-1], 2001)
    _, rate, acceleration = drawn(trajectory, moments)
    power = 2.0 * np.abs(rate * acceleration)[:, 0]
    limit = float(np.random.default_rng(seed).uniform(0.4, 0.9) * power.max())
    converted = convert(limited(robot, "q", power_limit=limit), trajectory)
    assert converted.problem is not None
    require_first(converted.bad_time, power, limit, moments)


@examples(40)
@given(st.floats(0.1, 0.9), st.floats(-0.4, 0.4), st.sampled_from([1e-5, 1e-4, 3e-3]))
def test_a_peak_anywhere_between_two_points_is_met(peak: float, lean: float, share: float) -> None:
    """A cubic of a second, whose top is beyond the limit by a share of its rise."""
    robot = load("five_bar")
    name, rise = robot.active[0], 0.05
    cubic = np.polynomial.Polynomial([0.0, 0.0, -rise, -rise * lean])(
        np.polynomial.Polynomial([-peak, 1.0])
    )
    time = np.array([0.0, 1.0])
    position = np.tile(robot.reference, (2, 1))
    velocity, acceleration = np.zeros_like(position), np.zeros_like(position)
    position[:, 0] += rise + cubic(time)
    velocity[:, 0] = cubic.deriv()(time)
    acceleration[:, 0] = cubic.deriv(2)(time)
    trajectory = SampledTrajectory(robot.active, time, position, velocity, acceleration)
    top = float(robot.reference[0] + rise)
    assert convert(limited(robot, name, limits=(-np.inf, top + 1e-9)), trajectory).problem is None
    limit = top - share * rise
    converted = convert(limited(robot, name, limits=(-np.inf, limit)), trajectory)
    assert converted.problem is not None
    assert converted.bad_point == 1
    assert converted.bad_time < peak
    assert top + cubic(converted.bad_time) == pytest.approx(limit, abs=1e-7)
    assert excess_of(converted.problem.text)[0] == pytest.approx(top - limit, rel=0.1)


def test_the_drive_that_is_too_weak_is_named_with_what_it_needs() -> None:
    """Beside others that are just strong enough."""
    robot = load("ankle")
    state, ddu = robot.close(robot.reference), np.full(len(robot.active), 0.1)
    efforts = robot.inverse_dynamics(state, ddu)
    for weak, name in enumerate(robot.drives):
        most = np.abs(efforts) * np.where(np.arange(len(efforts)) == weak, 0.99, 1.0)
        other = robot
        for joint, limit in zip(robot.drives, most.tolist(), strict=True):
            other = limited(other, joint, effort_limit=limit)
        problem = MotionLimits(other, 0.0).problem(state, efforts)
        assert problem is not None
        assert problem.code is RejectionCode.LIMIT
        needed, allowed = f"{efforts[weak]:.6g}", f"{most[weak]:.6g}"
        unit = "N m" if robot.joint_types[name] == "revolute" else "N"
        expected = f"expected no more than {allowed} {unit}"
        assert problem.text == f"{name} needs {needed} {unit}, {expected}"


@pytest.mark.parametrize("begin", [4.0, 2.0**30, 2.0**31 - 1.0])
@pytest.mark.parametrize("share", [0.3, 0.5, 0.8])
def test_late_motions_are_those_that_begin_at_once(begin: float, share: float) -> None:
    """However late they are: far from zero, floats are further apart than the first bad time."""
    robot = load("five_bar")
    name, start = robot.active[0], robot.reference
    position = np.array([start, start + 0.05 * np.eye(len(start))[0]])
    zero = np.zeros_like(position)
    bound = limited(robot, name, limits=(-np.inf, float(start[0] + 0.05 * share)))
    time = np.array([0.0, 0.125])
    early = convert(bound, SampledTrajectory(robot.active, time, position, zero, zero))
    late = convert(bound, SampledTrajectory(robot.active, begin + time, position, zero, zero))
    assert early.problem is not None
    assert late.problem is not None
    assert late.problem.code is early.problem.code
    resolution = np.spacing(begin) + 1e-6 * time[1]
    assert abs(late.bad_time - begin - early.bad_time) <= resolution
    assert np.array_equal(late.time - begin, early.time)


def test_motions_of_light_robots_have_as_many_points() -> None:
    """Efforts are as exact where links weigh ten thousand times less."""
    robot, share = load("five_bar"), 1e-4
    trajectory = gentle(robot, robot.reference, 2)
    settings = ConversionSettings(tolerance=0.01)
    whole = convert(robot, trajectory, None, settings)
    links = {
        name: replace(link, mass=share * link.mass, inertia=share * link.inertia)
        for name, link in robot.description.links.items()
    }
    light = convert(Robot(replace(robot.description, links=links)), trajectory, None, settings)
    assert len(whole.time) > len(trajectory.time)
    assert np.array_equal(light.time, whole.time)
    np.testing.assert_allclose(light.efforts, share * whole.efforts, rtol=1e-9, atol=1e-18)


Mask = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
LEFT_OUT: dict[str, Mask] = {
    "no velocities": lambda k: (k < 0, k >= 0),
    "no accelerations": lambda k: (k >= 0, k < 0),
    "first velocity": lambda k: (k > 0, k >= 0),
    "first velocity, no accelerations": lambda k: (k > 0, k < 0),
    "first velocity and acceleration": lambda k: (k > 0, k > 0),
    "last velocity": lambda k: (k < k[-1], k >= 0),
    "one of three": lambda k: (k % 3 > 0, k % 3 != 1),
}


@pytest.mark.parametrize("kind", LEFT_OUT)
@examples(32)
@given(st.integers(0, 999))
def test_what_points_leave_out_is_that_of_the_motion(kind: str, seed: int) -> None:
    """Sums of sines, sampled about 30 times a period of the fastest, at uneven times."""
    rng = np.random.default_rng(seed)
    time = np.cumsum(rng.uniform(0.6, 1.4, 30)) / 30.0
    rate, phase = rng.uniform(2.0, 2.0 * np.pi, 3), rng.uniform(0.0, 2.0 * np.pi, 3)
    angle = time[:, None] * rate + phase
    position, velocity = np.sin(angle), rate * np.cos(angle)
    acceleration = -(rate**2) * position
    rates, accelerations = LEFT_OUT[kind](np.arange(time.size))
    given_velocity = np.where(rates[:, None], velocity, np.nan)
    given_acceleration = np.where(accelerations[:, None], acceleration, np.nan)
    fitted = completed(time, position, given_velocity, given_acceleration)
    assert np.array_equal(fitted[0][rates], velocity[rates])
    assert np.array_equal(fitted[1][accelerations], acceleration[accelerations])
    assert np.abs(fitted[0] - velocity).max() < 0.02 * np.abs(velocity).max()
    assert np.abs(fitted[1] - acceleration).max() < 0.05 * np.abs(acceleration).max()


@pytest.mark.parametrize(
    ("time", "text"),
    [
        ([-0.1, 1.0], "point 0 is at -0.1 s, expected no negative time"),
        ([0.0, 1.0, 1.0], "point 2 is at 1 s, expected later than 1 s"),
        ([0.0, 1.0, 0.5], "point 2 is at 0.5 s, expected later than 1 s"),
        ([0.0], "1 points, expected 2 or more"),
    ],
)
def test_times_that_no_motion_has_are_refused(time: list[float], text: str) -> None:
    trajectory = SampledTrajectory(("x",), np.array(time), np.zeros((len(time), 1)))
    with pytest.raises(RejectedError) as refused:
        trajectory.motion()
    assert refused.value.rejection.text == text


def test_a_conversion_in_pieces_is_that_in_one() -> None:
    import pickle

    robot = load("five_bar")
    trajectory = gentle(robot, robot.reference, 1)
    settings = ConversionSettings(tolerance=0.01)
    whole = convert(robot, trajectory, None, settings)
    conversion, count = Conversion(trajectory.motion(), None), 0
    while not conversion.is_done:
        conversion = pickle.loads(pickle.dumps(conversion))  # noqa: S301 - our own
        conversion.advance(robot, settings, budget=0.0)
        count += 1
    pieces = conversion.result()
    assert count == trajectory.time.size - 1
    assert np.array_equal(pieces.time, whole.time)
    np.testing.assert_allclose(pieces.efforts, whole.efforts, rtol=1e-12, atol=1e-12)


@examples(120)
@given(st.floats(0.1, 0.9), st.floats(0.2, 1.8), st.floats(0.5, 20.0), st.floats(-1.0, 1.0))
def test_dips_between_samples_are_found_where_they_are(
    second: float, bottom: float, bend: float, depth: float
) -> None:
    """Of parabolas, whatever the distances of samples: those that fall below zero, and no others.

    What is within the assumed error of zero may be told or not.
    """
    times = np.array([0.0, 2.0 * second, 2.0])
    heights = bend * (times - bottom) ** 2 + depth
    error = np.ptp(heights) * PARABOLA_ERROR
    assume(not 0.0 <= depth < 1.01 * error)
    triple = [
        Sample(float(t), None, margins=np.array([g])) for t, g in zip(times, heights, strict=True)
    ]
    dips = lowest(triple)
    assert dips == pytest.approx([bottom] if depth < 0.0 else [])
