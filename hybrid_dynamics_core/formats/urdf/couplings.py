"""Joints of a <coupling> of URDF+: ratio * sum of q_predecessor = sum of q_successor.

Each sum is over the joints from the last common link to the named link. If one of the two links
carries the other, one side has no joint. The sum of that side then starts at the base. An example
is a hand that stays level while the arm moves.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import permutations
from typing import NamedTuple


class Hung(NamedTuple):
    """The joint above a link.

    Attributes:
        joint: its name.
        parent: the link that carries it.
        moves: whether the joint is not of type fixed.
    """

    joint: str
    parent: str
    moves: bool = True


class Coupling(NamedTuple):
    """The joints on both sides of a coupling, nearest to the named link first."""

    predecessor: list[str]
    successor: list[str]


def coupled_joints(hung: Mapping[str, Hung], predecessor: str, successor: str) -> Coupling:
    """The joints of a coupling between two links.

    Args:
        hung: by link: its attachment to another link.
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
    """Predecessor, successor and ratio of a coupling that expresses a follower.

    Args:
        hung: by link: its attachment to another link.
        follower: the joint that follows.
        multipliers: multiplier of each followed joint, by name.

    Returns:
        Names and ratio; None if no coupling expresses it.
    """
    said: tuple[str, str, float] | None = None
    for predecessor, successor in permutations(hung, 2):
        tied = coupled_joints(hung, predecessor, successor)
        # the follower must be the joint nearest to the successor, as the reader assumes
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
            break  # other programs support only these
    return said


def _carries(hung: Mapping[str, Hung], link: str, other: str) -> bool:
    """Whether a link is on the path from another one to the base."""
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
