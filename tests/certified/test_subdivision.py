"""Lists of modes that are proved by subdivision, against searches from many starts."""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core import InputError, Robot, load
from hybrid_dynamics_core.closed_state import mode_search
from hybrid_dynamics_core.closed_state.assembly_modes import SAME, mode_of
from tests.hard_cases.linkages import robot
from tests.sampling import swept

# two links with three pivots each, joined by two bars: a group of two loops that no dyad opens
GROUP = """
format: 1
name: group
links: {{base: {{}}, crank: {{mass: 1}}, one: {{mass: 1}}, two: {{mass: 1}}, bar: {{mass: 1}},
  part: {{mass: 1}}}}
joints:
  q: {{type: revolute, parent: base, child: crank, axis: z}}
  a: {{type: revolute, parent: crank, child: one, axis: z, origin: {{xyz: [{crank}, 0, 0]}}}}
  b: {{type: revolute, parent: one, child: bar, axis: z, origin: {{xyz: [{left}, 0]}}}}
  e: {{{joint}, parent: one, child: part, origin: {{xyz: [{right}, 0]}}}}
  d: {{type: revolute, parent: base, child: two, axis: z, origin: {{xyz: [{foot}, 0]}}}}
closures:
  first: {{kind: planar, between: {{bar: [{length}, 0, 0], two: [{near}, 0]}}}}
  second: {{kind: planar, between: {{part: [{span}, 0, 0], two: [{far}, 0]}}}}
active: [q]
end_effector: {{link: one}}
reference: {{q: 0.7}}
"""
JOINTS = ("type: revolute, axis: z", "type: prismatic, axis: x")


def group(seed: int) -> Robot:
    """A random group; a bar or a slide joins its second pair of pivots."""
    rng = np.random.default_rng(seed)

    def pair(low: tuple[float, float], high: tuple[float, float]) -> str:
        x, y = rng.uniform(low, high)
        return f"{x!s}, {y!s}"

    return robot(
        GROUP.format(
            joint=JOINTS[seed % 2],
            crank=rng.uniform(0.3, 0.5),
            left=pair((0.5, -0.3), (0.8, 0.3)),
            right=pair((0.1, -0.5), (0.5, 0.5)),
            foot=pair((0.9, -0.2), (1.2, 0.2)),
            length=rng.uniform(0.5, 0.9),
            near=pair((0.3, -0.2), (0.6, 0.4)),
            span=rng.uniform(0.5, 0.9),
            far=pair((-0.3, 0.1), (0.3, 0.5)),
        )
    )


@pytest.mark.parametrize("seed", swept(range(2), range(40)))
def test_modes_of_two_planar_loops_are_proved_and_the_search_finds_no_other(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    try:
        machine = group(seed)
    except InputError:
        pytest.skip("does not close at its reference")
    proved = machine.assembly_modes(machine.reference)
    monkeypatch.setattr(mode_search, "certified_modes", lambda *_: None)
    searched = machine.assembly_modes(machine.reference)
    assert proved.complete
    assert "by subdivision" in proved.reason
    assert all(mode.state.residual < 1e-12 for mode in proved)
    assert all(mode_of(proved, mode.state) is not None for mode in searched)


def test_modes_of_the_ankle_are_four_and_proved() -> None:
    """The rods end on two circles about the cross's axes: as many as HyRoDyn's 2-SPU+1U has."""
    ankle = load("ankle")
    modes = ankle.assembly_modes(ankle.reference)
    assert modes.complete
    assert len(modes) == 4
    places = np.array([mode.state.s for mode in modes])
    apart = np.abs(np.sin(0.5 * (places[:, None] - places))).max(axis=2)
    assert (apart + np.eye(4) > SAME).all()


# a rod as long as the platform's arms, whose foot lies on the line from the pivot through its tip
TOUCHING = """
format: 1
name: touching
links: {base: {}, cross: {}, foot: {mass: 1, inertia: {sphere: {radius: 0.1}}}}
joints:
  pitch: {type: revolute, parent: base, child: cross, axis: y}
  roll: {type: revolute, parent: cross, child: foot, axis: x}
legs:
  L:
    joints:
      - {name: aL, type: revolute, axis: y, origin: {xyz: [0, 0.6, -0.8]}}
      - {name: bL, type: revolute, axis: x}
      - {name: L, type: prismatic, axis: z, link: rod_L, body: {mass: 1}}
    to: {foot: [0, 0.3, -0.4]}
  R:
    joints:
      - {name: aR, type: revolute, axis: y, origin: {xyz: [0, -0.6, -0.8]}}
      - {name: bR, type: revolute, axis: x}
      - {name: R, type: prismatic, axis: z, link: rod_R, body: {mass: 1}}
    to: {foot: [0, -0.3, -0.4]}
active: [L, R]
end_effector: {link: foot}
reference: {L: 0.6, R: 0.61, pitch: 0.6}
"""


def test_solutions_that_meet_are_not_called_all() -> None:
    """Double roots: no box holds just one of them."""
    machine = robot(TOUCHING)
    assert machine.assembly_modes([0.6, 0.61]).complete
    for length in (0.6, 0.5):  # equal rods: stretched in the middle plane, or at the least length
        assert not machine.assembly_modes([length, length]).complete
    shorter = machine.assembly_modes([0.49, 0.49])
    assert (len(shorter), shorter.complete) == (0, True)
