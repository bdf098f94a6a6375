"""Designs: gradients, constraints, sensitivities, several starts, and textbook answers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hybrid_dynamics_core import InputError, Robot, load
from hybrid_dynamics_core.design import Cycle, Design, Duty, FourBar, Quantity, joined, size_bores
from hybrid_dynamics_core.dynamics.hydraulics import chamber_pressures
from hybrid_dynamics_core.kernels.run import VARIABLE

PINS = {
    "loops.boom_loop.pin.boom[0]": (1.6, 3.2),
    "loops.boom_loop.pin.boom[1]": (0.1, 1.0),
    "joints.boom_barrel_pitch.origin.xyz[2]": (0.9, 1.6),
}
GIVEN = ("slew", "boom_pitch", "stick_cylinder", "bucket_cylinder")
SWING = [Duty({"boom_pitch": angle}) for angle in np.linspace(-0.3, 0.8, 5)]


@pytest.fixture(autouse=True, scope="module")
def _without_compiler() -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(VARIABLE, "python")
        yield


@pytest.fixture(name="boom", scope="module")
def boom_design() -> Design:
    return Design(load("excavator"), PINS, SWING, given=GIVEN)


def force(cycle: Cycle) -> Quantity:
    return cycle.effort("boom_cylinder")


def spread(cycle: Cycle) -> Quantity:
    """How far the force is from level, smooth."""
    apart = force(cycle) - force(cycle).mean()
    return (apart * apart).mean().sqrt() / force(cycle).mean()


def retracted(cycle: Cycle) -> Quantity:
    return cycle.coordinate("boom_cylinder") - 0.05


def extended(cycle: Cycle) -> Quantity:
    return 1.15 - cycle.coordinate("boom_cylinder")


@pytest.mark.parametrize(
    "function",
    [
        spread,
        lambda cycle: force(cycle).max() * 2.0 / abs(-cycle.distance().min()),
        lambda cycle: (1.0 - cycle.position()[:, 2] ** 2).sum() * cycle.variable(next(iter(PINS))),
        lambda cycle: 1.0 / retracted(cycle).mean() - cycle.mass(),
        lambda cycle: cycle.pin_force("boom_loop").mean() * 1e-5 + cycle.distance().sum(),
        lambda cycle: joined(cycle.lifted("boom_cylinder"), cycle.lifted("stick_cylinder")).min(),
        lambda cycle: (
            cycle.pressure("boom_cylinder").max() * 1e-6 + cycle.margin("boom_cylinder").min()
        ),
    ],
)
def test_gradients_are_those_of_differences(boom: Design, function: object) -> None:
    step = 1e-5
    exact = function(boom.cycle()).slope
    for k in range(len(boom.names)):
        moved = step * np.eye(len(boom.names))[k]
        above = function(boom.cycle(boom.start + moved)).value
        below = function(boom.cycle(boom.start - moved)).value
        assert exact[k] == pytest.approx((above - below) / (2.0 * step), rel=1e-6, abs=1e-6)


def test_forces_at_given_angles_are_those_of_the_robot(boom: Design) -> None:
    robot = load("excavator")
    forces = force(boom.cycle()).value
    for point, expected in zip(SWING, forces, strict=True):
        others = {"slew": 0.0, "stick_cylinder": 0.7, "bucket_cylinder": 0.6}
        state = robot.close_given({**others, **point.at})
        tau = robot.inverse_dynamics(state, np.zeros(4))
        assert tau[1] == pytest.approx(expected, rel=1e-9)


def test_pressures_and_margins_are_those_of_the_robot(boom: Design) -> None:
    robot = load("excavator")
    cylinder = robot.cylinders["boom_cylinder"]
    cycle = boom.cycle()
    pressures = cycle.pressure("boom_cylinder").value
    assert np.allclose(pressures, force(cycle).value / cylinder.cap_area)
    lower, upper = robot.description.joints["boom_cylinder"].limits
    strokes = cycle.coordinate("boom_cylinder").value
    assert np.allclose(
        cycle.margin("boom_cylinder").value, np.minimum(strokes - lower, upper - strokes)
    )
    with pytest.raises(InputError, match="has no limits"):
        cycle.margin("boom_pitch")
    with pytest.raises(InputError, match="there is no cylinder 'slew'"):
        cycle.pressure("slew")


def test_distances_pins_and_lifted_masses_are_those_of_the_robot(boom: Design) -> None:
    robot = load("excavator")
    cycle = boom.cycle()
    others = {"slew": 0.0, "stick_cylinder": 0.7, "bucket_cylinder": 0.6}
    for k, point in enumerate(SWING):
        state = robot.close(robot.close_given({**others, **point.at}).u)
        assert np.allclose(cycle.distance().value[k], state.distances, rtol=1e-9)
        pin = robot.reactions(state, np.zeros(4)).pins["stick_loop"]
        force_there = cycle.pin_force("stick_loop").value[k]
        assert force_there == pytest.approx(np.linalg.norm(pin.force), rel=1e-9)
        masses = [cycle.lifted(name).value[k] for name in ("boom_cylinder", "stick_cylinder")]
        largest = robot.capability(state).lifted_mass()
        if largest.limited_by[0] in ("boom_cylinder", "stick_cylinder"):
            assert min(masses) == pytest.approx(largest.value, rel=1e-6)
    with pytest.raises(InputError, match="there is no pin 'slew'"):
        cycle.pin_force("slew")


def test_forces_in_pins_of_moving_points_need_active_coordinates() -> None:
    robot = load("excavator")
    moving = [Duty({"boom_pitch": 0.1}, rates={"boom_pitch": 0.2})]
    with pytest.raises(InputError, match="are of points at rest"):
        Design(robot, PINS, moving, given=GIVEN).cycle().pin_force("boom_loop")
    active = [Duty({"boom_cylinder": 0.7}, rates={"boom_cylinder": 0.2})]
    cycle = Design(robot, PINS, active).cycle()
    state = robot.close([0.0, 0.7, 0.7, 0.6], [0.0, 0.2, 0.0, 0.0])
    pin = robot.reactions(state, np.zeros(4)).pins["boom_loop"]
    assert cycle.pin_force("boom_loop").value[0] == pytest.approx(np.linalg.norm(pin.force))


def test_a_cylinder_is_placed_so_that_its_force_is_level(boom: Design) -> None:
    limits = {"retracted": retracted, "extended": extended}
    result = boom.minimise(spread, limits, starts=2)
    assert result.feasible
    assert result.objective < 0.3 * float(spread(boom.cycle()).value)
    assert result.objectives[0] == pytest.approx(result.objectives[1], rel=1e-3)
    assert min(result.constraints.values()) > -1e-6
    robot = result.robot
    others = {"slew": 0.0, "stick_cylinder": 0.7, "bucket_cylinder": 0.6, "boom_pitch": 0.8}
    state = robot.close_given(others)
    tau = robot.inverse_dynamics(state, np.zeros(4))[1]
    values = list(result.values.values())
    assert tau == pytest.approx(force(boom.cycle(values)).value[-1], rel=1e-8)


def test_a_sensitivity_is_what_more_room_gives(boom: Design) -> None:
    def shortest(cycle: Cycle) -> Quantity:
        return cycle.coordinate("boom_cylinder").max()

    def strong(newtons: float) -> object:
        return lambda cycle: newtons - force(cycle)[-1]

    result = boom.minimise(shortest, {"force": strong(230e3)})
    assert "force" in result.active
    more = boom.minimise(shortest, {"force": strong(230e3 + 100.0)})
    gain = (result.objective - more.objective) / 100.0
    assert result.sensitivities["force"] == pytest.approx(gain, rel=0.02)


def test_both_solvers_agree(boom: Design) -> None:
    limits = {"retracted": retracted, "extended": extended}
    first = boom.minimise(spread, limits)
    second = boom.minimise(spread, limits, method="trust-constr")
    assert second.feasible
    assert second.objective == pytest.approx(first.objective, rel=0.05)


def test_ipopt_agrees(boom: Design) -> None:
    pytest.importorskip("casadi")
    limits = {"retracted": retracted, "extended": extended}
    first = boom.minimise(spread, limits)
    second = boom.minimise(spread, limits, method="ipopt")
    assert second.feasible
    assert second.objective == pytest.approx(first.objective, rel=0.01)


def test_the_largest_force_is_made_least(boom: Design) -> None:
    """No further step lowers it: several points of duty meet the bound, or limits are met."""
    limits = {"retracted": retracted, "extended": extended}
    largest = boom.minimise_largest(force, limits)
    assert largest.feasible
    assert largest.objective == pytest.approx(
        float(force(boom.cycle(list(largest.values.values()))).value.max())
    )
    by_mean = boom.minimise(lambda cycle: force(cycle).mean(), limits)
    values = list(by_mean.values.values())
    assert largest.objective <= float(force(boom.cycle(values)).value.max()) * (1.0 + 1e-6)
    assert largest.sensitivities["largest"] == pytest.approx(1.0, abs=1e-6)
    assert largest.at_limit["largest"]
    rng = np.random.default_rng(0)
    best = np.array(list(largest.values.values()))
    for _ in range(30):
        near = np.clip(best + rng.normal(size=3) * 1e-3, boom.lower, boom.upper)
        cycle = boom.cycle(near)
        is_within = min(retracted(cycle).value.min(), extended(cycle).value.min()) >= 0.0
        if is_within:
            assert force(cycle).value.max() >= largest.objective * (1.0 - 1e-7)


def test_chebyshevs_proportions_are_found() -> None:
    """Ground 4, coupler 2: its middle has one height at three angles of the crank for bars of 5."""
    start = FourBar(4.0, 4.8, 2.0, 4.8, 0.9, 2.2)
    text = start.description().replace("c: 4.8", "c: a")
    from hybrid_dynamics_core import Robot
    from hybrid_dynamics_core.formats.reader import parse_description

    robot = Robot(parse_description(text))
    angles = (np.arctan2(3.0, 4.0), np.arctan2(4.0, 3.0), np.pi / 2.0)
    design = Design(robot, {"a": (4.5, 5.5)}, [Duty({"crank": angle}) for angle in angles])

    def bent(cycle: Cycle) -> Quantity:
        height = cycle.position()[:, 1]
        apart = height - height.mean()
        return (apart * apart).sum()

    result = design.minimise(bent)
    assert result.values["a"] == pytest.approx(5.0, abs=1e-4)


def test_bores_of_a_lifting_chart() -> None:
    robot = load("excavator")
    states = [robot.close(robot.reference + step) for step in (0.0, 0.05)]
    sized = size_bores(robot, [(state, None) for state in states], {"boom_cylinder": 20e6})
    bore = sized["boom_cylinder"]
    assert bore.bore >= bore.needed
    assert bore.pressure <= 20e6
    forces = [robot.inverse_dynamics(state, np.zeros(4))[1] for state in states]
    assert bore.push == pytest.approx(max(forces) / 2.0)  # two cylinders
    area = np.pi / 4.0 * bore.needed**2
    assert area * 20e6 == pytest.approx(bore.push)
    with pytest.raises(InputError, match="there is no cylinder 'slew'"):
        size_bores(robot, [], {"slew": 1.0})
    with pytest.raises(InputError, match="above all of the series"):
        size_bores(robot, [(states[0], None)], {"boom_cylinder": 1.0})


def test_wrong_designs_get_one_line(boom: Design) -> None:
    robot = load("excavator")
    with pytest.raises(InputError, match=r"boom: bounds \[5.8, 6\] do not contain its value 5.7"):
        Design(robot, {"boom": (5.8, 6.0)}, SWING, given=GIVEN)
    with pytest.raises(InputError, match="leave no room"):
        Design(robot, {"boom": (5.7, 5.7)}, SWING, given=GIVEN)
    with pytest.raises(InputError, match="at least one point"):
        Design(robot, {"boom": (5.0, 6.0)}, [])
    with pytest.raises(InputError, match="there is no given coordinate 'boom_pitch'"):
        Design(robot, {"boom": (5.0, 6.0)}, SWING)
    with pytest.raises(InputError, match="the objective has 5 entries"):
        boom.minimise(force)
    with pytest.raises(InputError, match="expected a Quantity"):
        boom.minimise(lambda cycle: float(cycle.mass().value))
    with pytest.raises(InputError, match="there is no method 'newton'"):
        boom.minimise(spread, method="newton")
    with pytest.raises(InputError, match="starts is 0"):
        boom.minimise(spread, starts=0)
    with pytest.raises(InputError, match="there is no active joint 'boom_pitch'"):
        boom.cycle().effort("boom_pitch")


def test_a_cylinder_that_shrinks_its_coordinate_pulls_where_another_pushes(boom: Design) -> None:
    robot = load("excavator")
    cylinder = robot.cylinders["boom_cylinder"]
    turned = replace(cylinder, sign=-1.0)
    mounted = replace(
        robot.description, actuators={**robot.description.actuators, "boom_cylinder": turned}
    )
    other = Robot(mounted)
    state = other.close(other.reference)
    push = -other.inverse_dynamics(state, np.zeros(4))[1]
    sized = size_bores(other, [(state, None)], {"boom_cylinder": 40e6})["boom_cylinder"]
    assert sized.push == pytest.approx(max(push, 0.0) / 2.0)
    assert sized.pull == pytest.approx(max(-push, 0.0) / 2.0)
    family = boom.cycle()._family
    cycle = Cycle(family, SWING, family.reference, other, family.values)
    forces = cycle.effort("boom_cylinder").value
    cap, rod = chamber_pressures(turned, forces)
    assert np.allclose(cycle.pressure("boom_cylinder").value, np.maximum(cap, rod))
