"""A robot and its copies are one robot.

Mounted elsewhere, told in another order, cut open at other joints.

The copies share no number of the spanning tree: other axes, other link frames, other order of
coordinates, other equations of the loops. What the actuators feel is the same.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from hybrid_dynamics_core import ClosedState, Robot
from tests.generated.assembly import turn, unit
from tests.generated.rerooted import other_cuts, rerooted
from tests.generated.robots import moved, shuffled, swapped
from tests.robots import ROBOTS, random_states, random_vector, robot, scaled
from tests.sampling import SAMPLE, sweep_unless, swept

# Both robots round each coordinate to about 1e-15 over the distance to a singularity, R to that
# over its square, and R' u', which goes into tau, to that over its cube: with random_states above
# 0.02 they reach a few parts in 1e9 there.
ROUNDING = 1e-13


def alike(one: Robot, state: ClosedState, other: Robot, twin: ClosedState, seed: int) -> None:
    """tau, M-bar, the bias and gravity, and u'' of both."""
    bound = max(1e-11, ROUNDING / min(1.0, float(state.singularity)) ** 3)
    ddu, tau = random_vector(one, seed), random_vector(one, seed + 1, 30.0)
    ours, theirs = one.minimal_form(state), other.minimal_form(twin)
    size = [np.abs(part).max() for part in ours]
    for a, b in zip(ours, theirs, strict=True):
        assert scaled(a - b, *size) < bound
    efforts = one.inverse_dynamics(state, ddu)
    assert scaled(efforts - other.inverse_dynamics(twin, ddu), efforts, *size) < bound
    here, there = one.forward_dynamics(state, tau), other.forward_dynamics(twin, tau)
    # u'' = M-bar^-1 (...): what was rounded before grows by as much as the force of u'' exceeds
    # what is left of it
    assert scaled(ours[0] @ (here - there), tau, *size) < bound


def mounted(machine: Robot, seed: int) -> Robot:
    """The base elsewhere and turned, gravity with it."""
    rng = np.random.default_rng(seed)
    description = moved(
        machine.description,
        turn(unit(rng.normal(size=3)), rng.uniform(1.0, 3.0)),
        rng.normal(size=3),
    )
    assert np.abs(description.gravity - machine.description.gravity).max() > 0.1
    return Robot(description)


def retold(machine: Robot, seed: int) -> Robot:
    """Links, joints and loops in another order, closures told from the other end."""
    other = Robot(shuffled(machine.description, seed))
    assert other.active == machine.active
    return other


@pytest.mark.parametrize("copy", [mounted, retold])
@pytest.mark.parametrize("name", swept(ROBOTS))
def test_copy_needs_the_same_efforts(name: str, copy: object) -> None:
    machine = robot(name)
    other = copy(machine, len(name))  # type: ignore[operator]
    for k, state in enumerate(random_states(name)):
        twin = other.close(
            state.u, state.du
        )  # without help: the modes that the description names are the same
        alike(machine, state, other, twin, k)


@pytest.mark.parametrize("told", [0, 1])
def test_names_of_modes_do_not_depend_on_the_end_told_first(forging: Robot, told: int) -> None:
    """counterclockwise is the same configuration whichever link of the pin a file names first.

    Keys have no order.
    """
    closures = list(forging.description.closures)
    assert closures[told].assembly == "counterclockwise"
    closures[told] = swapped(closures[told])
    other = Robot(replace(forging.description, closures=tuple(closures)))
    u = [0.2, 0.1, 0.15, 0.3]
    for mode in ("counterclockwise", "clockwise"):
        branch = {closures[told].name: mode}
        assert other.close(u, branch=branch).s == pytest.approx(
            forging.close(u, branch=branch).s, abs=1e-12
        )


def cut_elsewhere() -> Iterator[object]:
    """At most three other spanning trees of each robot, spread over those there are."""
    for name in ROBOTS:
        cuts = other_cuts(robot(name).description)
        for closure, joint in cuts[:: max(1, -(-len(cuts) // 3))]:
            yield pytest.param(
                name, closure, joint, id=f"{name}-{joint}", marks=sweep_unless(name in SAMPLE)
            )


@pytest.mark.parametrize(("name", "closure", "joint"), [*cut_elsewhere()])
def test_robot_cut_open_at_another_joint_needs_the_same_efforts(
    name: str, closure: str, joint: str
) -> None:
    """A joint of the loop becomes its closure and the closure a joint.

    The links between hang the other way round.
    """
    machine = robot(name)
    start = machine.close(machine.reference)
    other = Robot(rerooted(machine.description, start.s, machine.coordinates, closure, joint))
    assert joint not in other.coordinates
    anchor = other.close(machine.reference)
    for k, state in enumerate(random_states(name)):
        twin = other.close(state.u, state.du, near=anchor)
        shared = [n for n in machine.coordinates if n != joint]
        ours, theirs = (r.coordinates for r in (machine, other))
        apart = state.s[[ours.index(n) for n in shared]] - twin.s[[theirs.index(n) for n in shared]]
        assert np.abs(np.sin(0.5 * apart)).max() < 1e-10 / float(
            state.singularity
        )  # up to whole turns
        alike(machine, state, other, twin, k)
