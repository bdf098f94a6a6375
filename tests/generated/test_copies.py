"""Random robots and their copies are one robot.

Mounted elsewhere, told in another order, cut open at other joints.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

from hybrid_dynamics_core import Robot
from tests.generated.case import Case
from tests.generated.class_three import class_three
from tests.generated.rerooted import other_cuts, rerooted
from tests.generated.robots import STATES, examples, robots, shuffled
from tests.laws.test_copies import alike, mounted, retold

NAMED = ("counterclockwise", "clockwise", "extended", "retracted")


def generated_alike(case: Case, other: Robot, seed: int) -> None:
    s, du = case.somewhere(seed), case.rates(seed)
    state, anchor = case.robot.close(s[: case.n], du), other.close(case.start[: case.n])
    alike(case.robot, state, other, other.close(s[: case.n], du, near=anchor), seed)


@examples(4)
@given(robots(), STATES, st.sampled_from([mounted, retold]))
def test_copies_of_random_robots(case: Case, seed: int, copy: object) -> None:
    generated_alike(case, copy(case.robot, seed), seed)  # type: ignore[operator]


@examples(6)
@given(robots(), STATES)
def test_random_robots_cut_open_elsewhere(case: Case, seed: int) -> None:
    cuts = other_cuts(case.description)
    assume(cuts)
    closure, joint = cuts[seed % len(cuts)]
    generated_alike(
        case,
        Robot(rerooted(case.description, case.start, case.robot.coordinates, closure, joint)),
        seed,
    )


@examples(8)
@given(class_three(max_links=4, max_loops=4), STATES)
def test_names_of_modes_mean_the_same_in_another_order(case: Case, seed: int) -> None:
    """The modes at a random state, written into the description by name, are found again from a
    shuffled one.
    """
    s = case.somewhere(seed)
    branch = case.robot.close(s[: case.n]).branch
    named = {loop: mode for loop, mode in branch.items() if mode in NAMED}
    assume(named)
    closures = [
        replace(c, assembly=named.get(c.name, c.assembly)) for c in case.description.closures
    ]
    other = Robot(shuffled(replace(case.description, closures=tuple(closures)), seed))
    twin = other.close(s[: case.n])
    apart = twin.s[[other.coordinates.index(name) for name in case.robot.coordinates]] - s
    assert np.abs(np.sin(0.5 * apart)).max() < 1e-9  # up to whole turns
