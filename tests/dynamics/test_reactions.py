"""Pin forces that can be told without computing.

Members that only two pins hold; and places where none can be told.
"""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pytest

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.description.model import Link
from tests.mechanisms import changed, mechanism


def massless(robot: Robot, *links: str) -> Robot:
    return changed(
        robot, links=MappingProxyType({**robot.description.links, **{n: Link(n) for n in links}})
    )


def along(robot: Robot, u: list[float], link: str, pin: str) -> tuple[np.ndarray, np.ndarray]:
    """Pin force, and the direction from the link's joint to the pin."""
    state = robot.close(u, np.ones(len(u)))
    reaction = robot.reactions(state, np.ones(len(u))).pins[pin]
    bar = reaction.place - robot.forward_kinematics(state, link).position
    return reaction.force, bar / np.linalg.norm(bar)


def test_massless_rod_of_a_slider_crank_pulls_along_itself() -> None:
    robot = massless(mechanism("slider_crank"), "rod")
    force, bar = along(robot, [0.2, 0.6], "rod", "pin")
    assert np.linalg.norm(force) > 1.0
    assert np.linalg.norm(np.cross(force, bar)) < 1e-12 * np.linalg.norm(force)


def test_massless_rocker_of_a_parallelogram_pulls_along_itself() -> None:
    """Its loop closes by relations between angles, whose multipliers are torques.

    The pin's force is this one.
    """
    robot = massless(mechanism("parallelogram"), "rocker")
    force, bar = along(robot, [1.0, 0.3], "rocker", "pin")
    in_plane = force - [0, 0, force[2]]
    assert np.linalg.norm(force) > 1.0
    assert np.linalg.norm(np.cross(in_plane, bar)) < 1e-12 * np.linalg.norm(force)


def test_pin_of_a_parallelogram_is_that_of_the_same_loop_as_a_general_four_bar() -> None:
    robot = mechanism("parallelogram")
    (pin,) = robot.description.closures
    general = changed(robot, closures=(replace(pin, assembly=None),))
    u, du, ddu = [1.1, 0.4], [0.7, -0.3], [0.5, 1.0]
    one, other = (r.reactions(r.close(u, du), ddu) for r in (robot, general))
    assert one.tau == pytest.approx(other.tau, rel=1e-11)
    assert one.pins["pin"].force == pytest.approx(other.pins["pin"].force, rel=1e-10)
    assert one.joints["c"].moment == pytest.approx(other.joints["c"].moment, rel=1e-10)


@pytest.mark.parametrize("crank", [0.0, np.pi])
def test_bars_in_line_leave_the_pin_force_undefined_and_say_so(crank: float) -> None:
    robot = mechanism("parallelogram")
    state = robot.close([crank, 0.2], [1.0, 0.0])
    reactions = robot.reactions(state)
    pin = reactions.pins["pin"]
    assert pin.share < 1e-10
    assert np.isnan(pin.force).all()
    assert np.isnan(reactions.joints["c"].force).all()
    assert np.isfinite(reactions.tau).all()  # which the relations between the angles settle
    assert np.isfinite(reactions.base).all()
    assert np.isfinite(reactions.joints["d"].force).all()  # beyond the loop
    near = robot.reactions(robot.close([crank + 1e-3, 0.2], [1.0, 0.0]))
    assert np.isfinite(near.pins["pin"].force).all()
    assert near.base == pytest.approx(reactions.base, rel=1e-2, abs=1e-2)


def test_forces_across_a_planar_loop_are_listed_as_silent(forging: Robot) -> None:
    reactions = forging.reactions(forging.close([0.3, 0.1, 0.15, 0.2], np.ones(4)), np.ones(4))
    for closure in reactions.pins.values():
        assert closure.silent == ("force along z", "moment about x", "moment about y")
        assert np.array_equal(closure.moment, np.zeros(3))


def test_still_forging_robot_stands_on_its_weight(forging: Robot) -> None:
    base = forging.reactions(forging.close([0.3, 0.1, 0.15, 0.2])).base
    mass = sum(link.mass for link in forging.description.links.values())
    assert base[:3] == pytest.approx([0, 0, 9.81 * mass], rel=1e-12, abs=1e-9)
    assert base[5] == pytest.approx(0.0, abs=1e-9)


def test_welded_loop_bears_a_moment() -> None:
    """A planar loop closed by a whole frame.

    Force in the plane, moment about its normal, the rest silent.
    """
    robot = mechanism("welded")
    axle = robot.reactions(robot.close(robot.reference, [1.0]), [2.0]).pins["axle"]
    assert axle.silent == ("force along z", "moment about x", "moment about y")
    assert axle.force[2] == pytest.approx(0.0, abs=1e-12)
    assert abs(axle.moment[2]) > 1e-3
    assert axle.moment[:2] == pytest.approx([0, 0], abs=1e-12)
