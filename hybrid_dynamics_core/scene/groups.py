"""Joints drawn as one: universal and spherical joints, and coordinates of a platform."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from .projection import ALIGNED
from .skeleton import PlacedJoint, Skeleton

GroupKind = Literal["revolute", "prismatic", "universal", "spherical", "carrier"]


@dataclass(frozen=True, eq=False)
class JointGroup:
    """One joint, or several joints at one place.

    Attributes:
        kind: the symbol. `carrier` stands for coordinates of a platform (x, y, z, ...), which have
            no bodies.
        joints: the joints, from the base outward.
        inner: the links without extent between them.
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


def group_joints(skeleton: Skeleton) -> tuple[JointGroup, ...]:
    """Every joint of a skeleton in exactly one group, parents first."""
    groups: list[JointGroup] = []
    grouped: set[str] = set()
    for joint in skeleton.joints:
        if joint.name not in grouped:
            chain = _coincident_chain(skeleton, joint)
            groups += _groups(skeleton, chain)
            grouped |= _names(chain)
    return tuple(groups)


def _coincident_chain(skeleton: Skeleton, joint: PlacedJoint) -> list[PlacedJoint]:
    """A joint, and those after it at the same place."""
    chain = [joint]
    for following in _followers(skeleton, joint):
        both_turn = chain[-1].type == following.type == "revolute"
        if not both_turn and not _carries(skeleton, chain, following):
            break
        chain.append(following)
    return chain


def _carries(skeleton: Skeleton, chain: Sequence[PlacedJoint], following: PlacedJoint) -> bool:
    """Whether a chain that begins with prismatic joints continues as coordinates of a platform."""
    if chain[-1].child not in skeleton.massless:
        return False
    slides = all(joint.type == "prismatic" for joint in chain[:2])
    return slides and (len(chain) > 1 or following.type == "prismatic")


def _followers(skeleton: Skeleton, joint: PlacedJoint) -> Iterator[PlacedJoint]:
    """Passive joints after a joint, as long as the links between have no extent and no closures."""
    busy = set()
    for frame in skeleton.frames:
        busy.add(frame.link)
    for closure in skeleton.closures:
        busy.update(closure.links)
    extent = np.ptp(skeleton.points, axis=0).max()
    size = max(float(extent), ALIGNED)
    while joint.child not in busy and not joint.active:
        children = [other for other in skeleton.joints if other.parent == joint.child]
        if len(children) != 1 or children[0].active:
            return
        following = children[0]
        if np.linalg.norm(following.start - joint.point) > ALIGNED * size:
            return
        joint = following
        yield joint


def _groups(skeleton: Skeleton, chain: list[PlacedJoint]) -> list[JointGroup]:
    """A chain as one group if it has a symbol, otherwise one group for each joint."""
    kind = _chain_kind(skeleton, chain)
    if kind is None:
        return [JointGroup(joint.type, (joint,)) for joint in chain]
    inner = tuple(joint.child for joint in chain[:-1])
    return [JointGroup(kind, tuple(chain), inner)]


def _chain_kind(skeleton: Skeleton, chain: list[PlacedJoint]) -> GroupKind | None:
    slides = [joint for joint in chain if joint.type == "prismatic"]
    if len(slides) >= 2 and _names(chain) <= skeleton.in_loops:
        return "carrier"
    if slides:
        return None
    if len(chain) == 3:
        return "spherical"
    if len(chain) == 2 and not _are_parallel(*chain):
        return "universal"
    return None


def _names(chain: Sequence[PlacedJoint]) -> set[str]:
    return {joint.name for joint in chain}


def _are_parallel(first: PlacedJoint, second: PlacedJoint) -> bool:
    return bool(abs(first.axis @ second.axis) >= 1.0 - ALIGNED)
