"""Random robots of Chu's class III.

A serial arm with local loops of every type, in planes tilted in space.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from hypothesis import reject
from hypothesis import strategies as st

from tests.generated.assembly import BASE, Assembly
from tests.generated.case import Case, complete
from tests.generated.loops import (
    GOES_ON,
    KIND,
    MIXES,
    FourBar,
    added_four_bar,
    framed_loop,
    hung_four_bars,
    joint_point,
    leg_anywhere,
    new_four_bar,
    spanning_cylinder,
)

TRIES = 12  # geometries tried for one plan: a random one may be next to singular
LEG_KINDS = {"leg": "UPS", "rod": "RUS"}
EXTRA = ("pair", "pair", "pair", "span", "leg", "rod", "frame")  # what an additional loop may be


@dataclass(frozen=True)
class Plan:
    """What a robot is made of; the geometry follows from the seed.

    arm: per joint of the arm 'R', 'P', a FourBar, or the letter of the second of two loops, one
    hung on the other. extra: additional loops: (kind, place, FourBar), the place a number that
    picks a pair of links.
    """

    arm: tuple[str | FourBar, ...]
    extra: tuple[tuple[str, int, FourBar], ...]
    tidy: bool
    seed: int

    @property
    def loops(self) -> int:
        """Number of loops."""
        return len(self.extra) + sum(map(_loops_of, self.arm))


def _loops_of(joint: str | FourBar) -> int:
    """Number of loops that come with a joint of an arm."""
    if isinstance(joint, FourBar):
        return 1
    if joint in ("A", "B"):
        return 2
    return 0


@lru_cache(maxsize=64)
def build(plan: Plan) -> Case | None:
    """The robot of a plan; None if every geometry tried is next to singular."""
    for k in range(TRIES):
        a = Assembly(np.random.default_rng([plan.seed, k]), plan.tidy)
        tool = build_arm(a, plan.arm, BASE)
        for kind, place, bar in plan.extra:
            add_loop(a, tool, kind, place, bar)
        case = complete(a, tool, repr(plan), plan.seed + k)
        if case is not None:
            return case
    return None


def build_arm(a: Assembly, joints: tuple[str | FourBar, ...], link: str) -> str:
    """An arm on a link, with the loops that carry it; returns its last link."""
    at = joint_point(a, link)
    for joint in joints:
        normal = a.direction()
        at = at + 0.4 * a.rng.normal(size=3)
        if isinstance(joint, FourBar):
            link = new_four_bar(a, link, at, normal, joint)[GOES_ON[joint.letter]]
        elif joint in ("A", "B"):
            link = hung_four_bars(a, link, at, normal, joint)
        else:
            link = a.hang(link, KIND[joint], normal, at)
        at = joint_point(a, link)
    return link


def add_loop(a: Assembly, tool: str, kind: str, place: int, bar: FourBar) -> None:
    """One more loop where it fits; a pair of links if there is no place of the kind asked for."""
    spans = _spans(a)
    if kind == "span" and spans:
        base, link = spans[place % len(spans)]
        pin = ("planar", "point", "axis")[place % 3]
        spanning_cylinder(a, base, link, bar.mix[1:], pin)
        return
    joints = list(a.joints.values())
    joint = joints[place % len(joints)]
    base, stub = joint.parent, joint.child
    if kind in LEG_KINDS:
        tips = [link for link in a.poses if link != base]
        leg_anywhere(a, base, tips[(7 * place) % len(tips)], LEG_KINDS[kind])
    elif kind == "frame" and joint.type == "revolute":
        framed_loop(a, base, stub)
    else:
        added_four_bar(a, base, stub, _fitting(a, tool, stub, bar))


def _spans(a: Assembly) -> list[tuple[str, str]]:
    """Pairs of links that are two joints apart and move in one plane."""
    spans: list[tuple[str, str]] = []
    for first in a.joints.values():
        after = [joint.child for joint in a.joints.values() if joint.parent == first.child]
        spans += [(first.parent, link) for link in after if _parallel(a, first.child, link)]
    return spans


def _fitting(a: Assembly, tool: str, stub: str, bar: FourBar) -> FourBar:
    """The four-bar as it fits a link that has a joint already."""
    mix = a.joint_of(stub).type[0].upper() + bar.mix[1:]
    if mix == "PPP":
        mix = "PPR"
    letter = bar.letter
    if letter not in "AD" and stub in _way(a, tool):
        letter = "A"
    return FourBar(letter, mix, bar.parallelogram and mix == "RRR")


def _parallel(a: Assembly, one: str, two: str) -> bool:
    """Whether two joints move their links in one plane."""
    types = {a.joint_of(one).type, a.joint_of(two).type}
    cosine = abs(a.axes[f"q_{one}"] @ a.axes[f"q_{two}"])
    if types == {"revolute"}:
        return bool(cosine > 1.0 - 1e-12)
    if types == {"prismatic"}:
        return False
    return bool(cosine < 1e-12)


def _way(a: Assembly, link: str) -> list[str]:
    """Links from one back to the base."""
    way = [link]
    while way[-1] != BASE:
        way.append(a.joint_of(way[-1]).parent)
    return way


SEEDS = st.integers(0, 9999)
FOUR_BARS = st.builds(FourBar, st.sampled_from("ABCD"), st.sampled_from(MIXES)) | st.builds(
    FourBar, st.sampled_from("ABCD"), st.just("RRR"), st.booleans()
)
JOINTS = st.sampled_from("RP") | FOUR_BARS | FOUR_BARS | st.sampled_from("AB")
EXTRAS = st.tuples(st.sampled_from(EXTRA), st.integers(0, 99), FOUR_BARS)


@st.composite
def class_three(draw: st.DrawFn, max_links: int = 6, max_loops: int = 5) -> Case:
    """Arms of 1 to 6 joints with 0 to 5 loops."""
    arm = tuple(draw(st.lists(JOINTS, min_size=1, max_size=max_links)))
    extra = tuple(draw(st.lists(EXTRAS, max_size=2)))
    plan = Plan(arm, extra, draw(st.booleans()), draw(SEEDS))
    while plan.loops > max_loops:
        plan = Plan(_thinned(plan.arm), plan.extra[:-1], plan.tidy, plan.seed)
    return built(build(plan))


def built(case: Case | None) -> Case:
    """The case, or the next example where there is none."""
    if case is None:
        reject()
    return case


def _thinned(arm: tuple[str | FourBar, ...]) -> tuple[str | FourBar, ...]:
    """The arm with its first loop replaced by a joint."""
    loops = [k for k, joint in enumerate(arm) if joint not in ("R", "P")]
    first = loops[0] if loops else 0
    return (*arm[:first], "R", *arm[first + 1 :])
