"""The joints that a <coupling> of URDF+ ties: ratio * sum of q_predecessor = sum of q_successor.

Either sum goes over the joints from the last link that both have in common to the named link. If
one of the two links carries the other, this leaves no joint on one side. The sum of that side then
starts at the base, as for a hand that stays level whatever the arm does.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import permutations
from typing import NamedTuple


class Hung(NamedTuple):
    """How a link hangs on another.

    Attributes:
        joint: the joint between them.
        parent: the link that carries it.
        moves: whether the joint is no fixed one.
    """

    joint: str
    parent: str
    moves: bool = True


class Coupling(NamedTuple):
    """The joints on both sides of a coupling, nearest to the named link first."""

    predecessor: list[str]
    successor: list[str]


def coupled_joints(hung: Mapping[str, Hung], predecessor: str, successor: str) -> Coupling:
    """The joints that a coupling between two links ties.

    Args:
        hung: how each link hangs on another, by its name.
        predecessor: name of a link.
        successor: name of the other link.
    """
    path_a = _joints_to_base(hung, predecessor)
    path_b = _joints_to_base(hung, successor)
    only_a = [joint for joint in path_a if joint not in path_b]
    only_b = [joint for joint in path_b if joint not in path_a]
    return Coupling(only_a or path_a, only_b or path_b)


def coupling_links(
    hung: Mapping[str, Hung], follower: str, multipliers: Mapping[str, float]
) -> tuple[str, str, float] | None:
    """The predecessor, successor and ratio of the coupling that says what a joint follows.

    Args:
        hung: how each link hangs on another, by its name.
        follower: the joint that follows.
        multipliers: of each joint that it follows.

    Returns:
        None where no coupling says it.
    """
    said: tuple[str, str, float] | None = None
    for predecessor, successor in permutations(hung, 2):
        tied = coupled_joints(hung, predecessor, successor)
        # the reader takes the joint nearest to the successor for the follower
        if tied.successor[:1] != [follower] or follower in tied.predecessor:
            continue
        ratios = {multipliers.get(joint, 0.0) for joint in tied.predecessor}
        _, *others = tied.successor
        if len(ratios) != 1 or {*tied.predecessor, *others} != set(multipliers):
            continue
        if any(multipliers[joint] != -1.0 for joint in others):
            continue
        said = (predecessor, successor, ratios.pop())
        if not _carries(hung, predecessor, successor):
            break  # other programs know the rule for these alone
    return said


def _carries(hung: Mapping[str, Hung], link: str, other: str) -> bool:
    """Whether all joints below a link are below another one too."""
    return set(_joints_to_base(hung, link)) <= set(_joints_to_base(hung, other))


def _joints_to_base(hung: Mapping[str, Hung], link: str) -> list[str]:
    """Moving joints from a link to the base."""
    path: list[str] = []
    for _ in range(len(hung)):
        if link not in hung:
            break
        joint, link, moves = hung[link]
        if moves:
            path.append(joint)
    return path
