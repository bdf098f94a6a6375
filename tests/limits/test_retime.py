"""Motions as fast as limits allow: against closed forms, and never beyond a limit."""

from __future__ import annotations

import json
import textwrap

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import brentq

from benchmarks import retiming
from hybrid_dynamics_core import InputError, Robot, load
from hybrid_dynamics_core.control import JointTrajectory
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.retiming.ramps import ramp
from tests.cli.calling import call
from tests.limits.machines import CRANE, crane
from tests.sampling import examples, swept

WAY = 1.5  # [m]


def cart(limits: str) -> Robot:
    """A mass of 2 kg on a level slide."""
    text = """
        format: 1
        name: cart
        links: {cart: {mass: 2}}
        joints: {x: {type: prismatic, parent: base, child: cart, axis: x, LIMITS}}
        active: [x]
        end_effector: {link: cart}
    """
    return Robot(parse_description(textwrap.dedent(text).replace("LIMITS", limits)))


def with_power(force: float, power: float, mass: float = 2.0) -> float:
    """Shortest time with a force, above power / force with a power, both ways [s]."""
    slow = power / force
    half = WAY / 2.0 - slow**2 * mass / (2.0 * force)
    fast = (3.0 * power * half / mass + slow**3) ** (1.0 / 3.0)
    return 2.0 * (slow * mass / force + mass / (2.0 * power) * (fast**2 - slow**2))


def with_falling_force(mass: float = 2.0) -> float:
    """Shortest time with a force of 6 N that falls to nothing at 2 m/s [s]."""

    def acceleration(rate: float) -> float:
        return (6.0 - 3.0 * rate) / mass

    def way(rate: float) -> float:
        return quad(lambda v: v / acceleration(v), 0.0, rate)[0]

    fastest = brentq(lambda rate: way(rate) - WAY / 2.0, 0.0, 1.999)
    return 2.0 * quad(lambda v: 1.0 / acceleration(v), 0.0, fastest)[0]


BY_HAND = {
    "force": ("effort_limit: 6", 2.0 * (WAY / 3.0) ** 0.5, 1e-4),
    "acceleration": ("acceleration_limit: 3", 2.0 * (WAY / 3.0) ** 0.5, 1e-4),
    "rate": ("effort_limit: 6, velocity_limit: 1", WAY + 1.0 / 3.0, 1e-4),
    "power": ("effort_limit: 6, power_limit: 4", with_power(6.0, 4.0), 3e-3),
    "table": ("effort_table: {rate: [0, 2], effort: [6, 0]}", with_falling_force(), 5e-3),
}


@pytest.mark.parametrize("name", swept(BY_HAND, ["rate", "power"]))
def test_a_cart_is_as_fast_as_by_hand(name: str) -> None:
    limits, shortest, tolerance = BY_HAND[name]
    motion = cart(limits).retime([[0.0], [WAY]])
    assert shortest * (1.0 - 1e-9) < motion.duration < shortest * (1.0 + tolerance)


def assert_it_keeps_all(machine: Robot, motion, count: int = 4001) -> None:
    """On a grid that has nothing in common with that of the search."""
    times = np.linspace(0.0, motion.duration, count)
    u, du, ddu = motion(times)
    state = machine.close(u, du)
    assert machine.limit_margins(state, ddu).beyond == ()
    assert motion.margins.beyond == ()
    steps = np.diff(u, axis=0)
    mean_rates = 0.5 * (du[1:] + du[:-1])
    assert steps == pytest.approx(mean_rates * np.diff(times)[:, None], abs=1e-5)
    assert np.abs(du[[0, -1]]).max() < 1e-6


PATHS = {
    "straight": [[0.1, 0.1], [0.5, 0.45]],
    "bent": [[0.1, 0.1], [0.3, 0.4], [0.5, 0.2]],
}


@pytest.mark.parametrize("name", swept(PATHS, ["bent"]))
def test_a_crane_keeps_pressures_flows_and_the_power_of_its_pump(name: str) -> None:
    machine = crane()
    motion = machine.retime(PATHS[name], stations=100)
    assert_it_keeps_all(machine, motion)
    assert ("main", "pump_flow") in motion.limited_by
    assert motion(0.0).u == pytest.approx(PATHS[name][0])
    assert motion(motion.duration).u == pytest.approx(PATHS[name][-1])


LIFT, BOOM = "lift_cylinder: {type: prismatic,", "boom_cylinder: {type: prismatic,"
TABLE = (
    f"{LIFT} effort_table: {{rate: [0, 0.3], position: [0, 0.6],"
    " effort: [[9000, 6000], [12000, 7000]]},"
)
NOT_LINEAR = {
    "friction": (
        (BOOM, f"{BOOM} friction: {{viscous: 3000, coulomb: 800, smoothing: 0.01}},"),
        "pressure",
    ),
    "power of a drive": ((LIFT, f"{LIFT} power_limit: 900,"), "power"),
    "a table over position": (
        (LIFT, TABLE),
        "effort",
    ),
    "a joint inside a loop": (
        (
            "boom_pitch: {type: revolute,",
            "boom_pitch: {type: revolute, acceleration_limit: 1, velocity_limit: 0.5,",
        ),
        "acceleration",
    ),
}


@pytest.mark.parametrize("name", swept(NOT_LINEAR, ["a table over position"]))
def test_limits_that_are_not_linear_are_kept_and_reached(name: str) -> None:
    change, kind = NOT_LINEAR[name]
    machine = crane(change)
    motion = machine.retime(PATHS["straight"], stations=60)
    assert_it_keeps_all(machine, motion, 2001)
    assert kind in [limited for _, limited in motion.limited_by]


def test_a_path_along_an_idle_joint_is_refused() -> None:
    text = """
        format: 1
        name: hook
        links: {cart: {mass: 2}, hook: {mass: 1, com: [0, 0, -1]}}
        joints:
          x: {type: prismatic, parent: base, child: cart, axis: x, effort_limit: 9}
          swing: {type: revolute, parent: cart, child: hook, axis: y}
        active: [x]
        idle: [swing]
        end_effector: {link: hook}
    """
    with pytest.raises(InputError, match=r"swing is idle: the path takes up to .* N m along it"):
        Robot(parse_description(textwrap.dedent(text))).retime([[0.0, 0.0], [1.0, 0.0]])


@pytest.mark.parametrize("seed", swept([5, 6, 7, 8], [6]))
def test_random_paths_keep_all_limits_and_stronger_pumps_are_faster(seed: int) -> None:
    rng = np.random.default_rng(seed)
    weak, strong = crane(), crane(("power_limit: 5*kW", "power_limit: 9*kW"))
    path = rng.uniform(0.08, 0.52, (3, 2))
    motions = [machine.retime(path, stations=40) for machine in (weak, strong)]
    assert_it_keeps_all(weak, motions[0])
    assert motions[1].duration < motions[0].duration * (1.0 + 1e-3)
    slower = weak.retime(path, stations=40, share=0.8)
    assert slower.duration > motions[0].duration


def test_a_trajectory_is_retimed_whatever_its_times() -> None:
    machine = crane()
    points = [[0.1, 0.1], [0.2, 0.3], [0.4, 0.4]]
    durations: list[float] = []
    for scale in (1.0, 10.0):
        trajectory = JointTrajectory(scale * np.arange(3.0), points)
        durations.append(machine.retime(trajectory, stations=60).duration)
    assert durations[0] == pytest.approx(durations[1], rel=1e-6)


BAD = {
    "a loop that opens": ((), [[0.1, 0.1], [0.5, 0.9]], "%.*loop 'fold' cannot close"),
    "a limit": ((), [[0.1, 0.1], [0.61, 0.1]], "lift_cylinder is 0.6.*beyond"),
    "bar": (
        (("supply_pressure: 210*bar, flow", "supply_pressure: 210, flow"),),
        [[0.1, 0.1], [0.4, 0.4]],
        "cannot hold crane at rest: the cylinder of lift_cylinder needs .*are these bar",
    ),
    "too weak": (
        (("supply_pressure: 210*bar, flow", "supply_pressure: 10*bar, flow"),),
        [[0.1, 0.1], [0.4, 0.4]],
        "cannot hold crane at rest: .*beyond its supply of 1e.06 Pa",
    ),
    "one point": ((), [[0.1, 0.1], [0.1, 0.1]], "one point only"),
    "a shape": ((), [[0.1, 0.1, 0.1]], "expected two or more rows of 2"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_path_that_cannot_be_is_refused_in_one_line(name: str) -> None:
    changes, path, message = BAD[name]
    with pytest.raises(InputError, match=message) as caught:
        crane(*changes).retime(path, stations=40)
    assert "\n" not in str(caught.value)


def test_the_command_line_writes_a_motion_through_points(tmp_path) -> None:
    robot, points, saved = (tmp_path / name for name in ("crane.yaml", "points.csv", "motion.csv"))
    robot.write_text(CRANE)
    points.write_text("boom_cylinder,lift_cylinder\n0.1,0.1\n0.4,0.3\n")
    words = ("retime", str(robot), "--path", str(points), "--save", str(saved), "--json")
    data = json.loads(call(*words).stdout)
    machine = crane()
    motion = machine.retime([[0.1, 0.1], [0.3, 0.4]])
    assert data["duration"] == pytest.approx(motion.duration, rel=1e-6)
    assert {"name": "main", "kind": "pump_flow"} in data["limited_by"]
    rows = np.genfromtxt(saved, delimiter=",", names=True)
    assert rows["lift_cylinder"][[0, -1]] == pytest.approx([0.1, 0.3])
    points.write_text("boom_cylinder [cm],lift_cylinder [mm]\n10,100\n40,300\n")
    in_other_units = json.loads(call(*words, "--overwrite").stdout)
    assert in_other_units["duration"] == pytest.approx(data["duration"])
    points.write_text("boom_cylinder,lift\n0.1,0.1\n")
    assert "points.csv: the columns are boom_cylinder, lift; expected" in call(*words[:4]).stderr
    points.write_text("boom_cylinder,lift_cylinder\n0.1,0.1\n0.4,\n")
    assert "points.csv:3: lift_cylinder is empty; expected" in call(*words[:4]).stderr


@pytest.mark.parametrize("jerk", swept([50.0, 0.5], [0.5]))
def test_jerk_is_limited_between_two_points(jerk: float) -> None:
    machine = crane()
    motion = machine.point_to_point([0.1, 0.1], [0.4, 0.35], [jerk, jerk])
    assert_it_keeps_all(machine, motion, 2001)
    times = np.linspace(0.0, motion.duration, 2001)
    jerks = np.diff(motion(times).ddu, axis=0) / np.diff(times)[:, None]
    assert np.abs(jerks).max() == pytest.approx(jerk, rel=1e-6)
    assert np.abs(motion(times).ddu[[0, -1]]).max() < 1e-9
    fastest = machine.retime([[0.1, 0.1], [0.4, 0.35]], stations=50)
    assert motion.duration > fastest.duration


@examples(120)
@given(*[st.floats(1e-2, 1e2) for _ in range(4)])
def test_a_ramp_ends_at_rest_and_is_at_a_limit_everywhere(way, rate, acceleration, jerk) -> None:
    move = ramp(way, rate, acceleration, jerk)
    times = np.linspace(0.0, move.duration, 301)
    x, v, a = move.at(times)
    assert x[-1] == pytest.approx(way, rel=1e-9)
    assert abs(v[-1]) < 1e-9 * v.max()
    assert v.max() <= rate * (1.0 + 1e-9)
    assert np.abs(a).max() <= acceleration * (1.0 + 1e-9)
    assert np.abs(move.jerks).max() == jerk
    spans = np.diff(move.times)
    assert (spans >= 0.0).all()
    # what is not jerk is another limit: nothing is left to gain
    if spans[1] > 1e-9 * move.duration:
        assert move.states[1, 2] == pytest.approx(acceleration)
    if spans[3] > 1e-9 * move.duration:
        assert move.states[3, 1] == pytest.approx(rate)


def test_a_motion_that_nothing_limits_is_refused() -> None:
    with pytest.raises(InputError, match="nothing limits the motion"):
        cart("limits: [-5, 5]").retime([[0.0], [WAY]])


def test_within_pressures_the_time_is_that_of_toppra() -> None:
    """It has other stations, and does not look between them: 0.1 % of the time."""
    pytest.importorskip("toppra")
    robot = load("excavator")
    (path,) = retiming.excavator_paths(1, 0)
    assert robot.retime(path).duration == pytest.approx(retiming.toppra_time(robot, path), rel=2e-3)
