"""Joints that are drawn as one: universal and spherical joints, and coordinates that only carry a platform."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from .skeleton import PlacedJoint, Skeleton
from .view import ALIGNED

GroupKind = Literal["revolute", "prismatic", "universal", "spherical", "carrier"]


@dataclass(frozen=True, eq=False)
class Group:
    """One joint, or several with nothing between them; `inner`: the links without extent that join them.

    carrier: the coordinates of a platform (x, y, z, ...) that its legs hold: nothing that could be
    seen.
    """

    kind: GroupKind
    joints: tuple[PlacedJoint, ...]
    inner: tuple[str, ...] = ()

    @property
    def first(self) -> PlacedJoint:
        """The joint at the base's side."""
        return self.joints[0]

    @property
    def last(self) -> PlacedJoint:
        """The joint at the end effector's side."""
        return self.joints[-1]

    @property
    def names(self) -> str:
        """Names of all its joints, joined by +."""
        return "+".join(joint.name for joint in self.joints)


def group_joints(skeleton: Skeleton) -> tuple[Group, ...]:
    """Every joint of a skeleton in exactly one group, parents first."""
    groups: list[Group] = []
    done: set[str] = set()
    for joint in skeleton.joints:
        if joint.name not in done:
            groups += _groups(skeleton, _chain(skeleton, joint))
            done |= {j.name for group in groups for j in group.joints}
    return tuple(groups)


def _chain(skeleton: Skeleton, joint: PlacedJoint) -> list[PlacedJoint]:
    """The joint with those that follow it at the same place."""
    chain = [joint]
    for following in _followers(skeleton, joint):
        both_turn = chain[-1].type == following.type == "revolute"
        carries = (
            all(j.type == "prismatic" for j in chain[:2]) and chain[-1].child in skeleton.massless
        )
        if not both_turn and not (carries and (len(chain) > 1 or following.type == "prismatic")):
            break
        chain.append(following)
    return chain


def _followers(skeleton: Skeleton, joint: PlacedJoint) -> Iterator[PlacedJoint]:
    """Passive joints after this one, as long as the links between them hold nothing else and have no extent."""
    busy = {link for c in skeleton.closures for link in c.links} | {
        frame.link for frame in skeleton.frames
    }
    size = max(float(np.ptp(skeleton.points, axis=0).max()), ALIGNED)
    while joint.child not in busy and not joint.active:
        following = [j for j in skeleton.joints if j.parent == joint.child]
        if len(following) != 1 or following[0].active:
            return
        if np.linalg.norm(following[0].start - joint.point) > ALIGNED * size:
            return
        joint = following[0]
        yield joint


def _groups(skeleton: Skeleton, chain: list[PlacedJoint]) -> list[Group]:
    slides = sum(j.type == "prismatic" for j in chain)
    kind: GroupKind | None = None
    if slides >= 2 and skeleton.in_loops.issuperset(j.name for j in chain):
        kind = "carrier"
    elif slides == 0 and len(chain) == 3:
        kind = "spherical"
    elif slides == 0 and len(chain) == 2 and abs(chain[0].axis @ chain[1].axis) < 1.0 - ALIGNED:
        kind = "universal"
    if kind is None:
        return [Group(joint.type, (joint,)) for joint in chain]
    return [Group(kind, tuple(chain), tuple(joint.child for joint in chain[:-1]))]
