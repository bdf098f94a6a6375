"""Blocks of the closure plan that are a planar platform on three legs.

Each leg turns about a foot and is pinned to the platform. The platform is carried by two slides and
a pivot, or by one of its legs. So the modes of the block are the poses of the platform.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...algebra.vector import Vector, dot, sub
from ...closure.blocks.block_solver import BlockSolver
from ...closure.constraints.equations import loops_of
from ...closure.constraints.planar import PlanarJoint, PlanarPin, planar_chain
from ...ground.arrays import Array
from ...mechanism.configuration import Configuration
from ...mechanism.tree import Tree
from ..enclosed import enclosed, in_plane, on_axis
from .planar_poses import PlanarLegs

LEGS = 3
SLIDES_AND_PIVOT = [False, False, True]  # which of the joints turn
TWO_PIVOTS = [True, True]
CLEAR = 1e-9  # area between the directions of two slides below which they are parallel

Joints = tuple[PlanarJoint, ...]


class PlanarLeg(NamedTuple):
    """A leg that turns about a foot.

    Attributes:
        joints: its joints.
        pivot: the one that is unknown.
        end: its end point (2,) at zero [m].
    """

    joints: Joints
    pivot: PlanarJoint
    end: Vector


@dataclass(frozen=True)
class PlanarPlatform:
    """A planar platform on three legs.

    Attributes:
        carrier: joints of the chain that carries the platform.
        unknown: the unknown ones among them.
        tips: points (2,) of the platform at zero [m], one a leg.
        legs: the legs to these points.
        on_leg: whether the carrier is the first leg, and not two slides and a pivot.
    """

    carrier: Joints
    unknown: Joints
    tips: tuple[Vector, ...]
    legs: tuple[PlanarLeg, ...]
    on_leg: bool

    def balls(
        self,
        tree: Tree,
        configuration: Configuration,
        given: Sequence[int],
    ) -> PlanarLegs:
        """The geometry of the legs with outward rounding, in the platform's place at zero.

        Args:
            tree: the spanning tree.
            configuration: values of all coordinates but the unknowns.
            given: coordinates whose values are exact.
        """
        here = enclosed(tree, configuration, given)
        feet, squares = [], []
        for joints, pivot, end in self.legs:
            turned = here.with_zeros([pivot.coordinate])
            state = planar_chain(joints, end, turned)
            foot = state.places[joints.index(pivot)]
            bar = sub(state.end, foot)
            feet.append(foot)
            squares.append(dot(bar, bar))
        return PlanarLegs(
            in_plane(feet),
            in_plane(self.tips),
            on_axis(squares),
        )

    def placed(
        self, turn: complex, place: complex, configuration: Configuration, guess: Sequence[float]
    ) -> Configuration | None:
        """A configuration in which the platform has a pose; None if slides are parallel.

        Args:
            turn: exp(i theta), where theta is measured from all joints at zero.
            place: where the origin of the plane goes with the platform [m].
            configuration: values of all coordinates but the unknowns.
            guess: all coordinates nearby [rad, m].
        """
        trial = configuration.with_zeros(k.coordinate for k in self.unknown)
        goals = [place + turn * complex(*tip) for tip in self.tips]
        aimed = list(zip(self.legs, goals, strict=True))
        pivot = self.unknown[-1]
        if self.on_leg:
            _aim(*aimed.pop(0), trial, guess)
        rotation = _turn_of(self.carrier, trial)
        _turn_to(trial, pivot, turn / rotation, guess)
        if not self.on_leg and not self._slide(place, trial):
            return None
        for leg, goal in aimed:
            _aim(leg, goal, trial, guess)
        return trial

    def _slide(self, place: complex, configuration: Configuration) -> bool:
        """Set both slides, which are at zero; False if they are parallel."""
        slides = self.unknown[:-1]
        state = planar_chain(self.carrier, (0.0, 0.0), configuration)
        columns = [_direction(self.carrier, state.places, joint) for joint in slides]
        directions = np.array(columns).T
        goal = np.array([place.real, place.imag])
        gap = goal - np.array(state.end, dtype=float)
        if abs(float(np.linalg.det(directions))) < CLEAR:
            return False
        strokes = np.linalg.solve(directions, gap)
        for joint, stroke in zip(
            slides,
            strokes.tolist(),
            strict=True,
        ):
            configuration.set_length(joint.coordinate, stroke)
        return True


def planar_platform(block: BlockSolver) -> PlanarPlatform | None:
    """A block as a planar platform on three legs; None if it is none."""
    pins = [loop for loop in loops_of(block.equations) if isinstance(loop, PlanarPin)]
    if not 2 * len(pins) == len(block.equations) == len(block.unknowns):
        return None
    unknown = frozenset(block.unknowns)
    shared = _shared(pins)
    parts = [_parts(pin, unknown, shared) for pin in pins]
    usable = [part for part in parts if part is not None]
    if len(usable) < len(pins):
        return None
    legs = [leg for leg, _, _ in usable]
    tips = [tip for _, _, tip in usable]
    carriers = [carrier for _, carrier, _ in usable]
    if any(carrier != carriers[0] for carrier in carriers):
        return None
    return _on_carrier(carriers[0], unknown, legs, tips)


def _on_carrier(
    carrier: Joints,
    unknown: frozenset[int],
    legs: Sequence[PlanarLeg],
    tips: Sequence[Vector],
) -> PlanarPlatform | None:
    """The platform at the end of a chain; None if it is not on three legs."""
    moving = tuple(joint for joint in carrier if joint.coordinate in unknown)
    kinds = [joint.revolute for joint in moving]
    if kinds == SLIDES_AND_PIVOT and len(legs) == LEGS:
        return PlanarPlatform(carrier, moving, tuple(tips), tuple(legs), on_leg=False)
    if kinds != TWO_PIVOTS or moving[-1] is not carrier[-1] or len(legs) != LEGS - 1:
        return None
    first = PlanarLeg(carrier[:-1], moving[0], moving[1].place)
    all_tips = (moving[1].place, *tips)
    return PlanarPlatform(carrier, moving, all_tips, (first, *legs), on_leg=True)


def _aim(
    leg: PlanarLeg, goal: complex, configuration: Configuration, guess: Sequence[float]
) -> None:
    """Turn a leg so that it ends at a place [m]."""
    configuration.set_angle(leg.pivot.coordinate, 0.0)
    state = planar_chain(leg.joints, leg.end, configuration)
    foot = state.places[leg.joints.index(leg.pivot)]
    bar = complex(*sub(state.end, foot))
    wanted = goal - complex(*foot)
    _turn_to(configuration, leg.pivot, wanted / bar, guess)


def _shared(pins: Sequence[PlanarPin]) -> frozenset[int]:
    """Coordinates that belong to all loops."""
    sets = [frozenset(joint.coordinate for joint in pin.geometry.joints) for pin in pins]
    return frozenset.intersection(*sets)


def _parts(
    pin: PlanarPin, unknown: frozenset[int], shared: frozenset[int]
) -> tuple[PlanarLeg, Joints, Vector] | None:
    """The leg of a loop, its other chain and the tip; None if it is no leg."""
    g = pin.geometry
    ends = (
        (g.chain_a, g.point_a),
        (g.chain_b, g.point_b),
    )
    for one, other in zip(ends, reversed(ends), strict=True):
        joints, end = one
        moving = [joint for joint in joints if joint.coordinate in unknown]
        if len(moving) == 1 and moving[0].revolute and moving[0].coordinate not in shared:
            carrier, tip = other
            return PlanarLeg(joints, moving[0], end), carrier, tip
    return None


def _turn_of(joints: Joints, configuration: Configuration) -> complex:
    """exp(i theta) of the last link of a chain."""
    total = 1.0 + 0.0j
    for joint in joints:
        if joint.revolute:
            k = joint.coordinate
            total *= complex(
                configuration.c[k],
                joint.sign * configuration.s[k],
            )
    return total


def _turn_to(
    configuration: Configuration, joint: PlanarJoint, turn: complex, guess: Sequence[float]
) -> None:
    """Set a joint so that it turns its link by theta; `turn` is a multiple of exp(i theta)."""
    size = abs(turn)
    k = joint.coordinate
    configuration.set_direction(
        k,
        turn.real / size,
        joint.sign * turn.imag / size,
        guess[k],
    )


def _direction(
    joints: Joints,
    places: Sequence[Vector],
    joint: PlanarJoint,
) -> Array:
    """Direction (2,) in which a slide moves the chain."""
    direction = np.array(
        places[joints.index(joint)],
        dtype=float,
    )
    return joint.sign * direction
