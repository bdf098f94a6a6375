"""A weld at the end of a chain that has a ball joint last, whose three axes meet in a point O.

The place of O does not depend on the three angles. So the weld splits into a point closure in O,
without the angles, and three equations of orientation. The loop is solved first, then the joint.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...algebra.independence import norm
from ...algebra.scalar import Scalar, Scalars
from ...algebra.vector import IDENTITY3, Vector, add, dot, matmul, matvec, sub, transpose
from ...mechanism.configuration import Configuration
from ...mechanism.tree import Body
from .equations import Linearised, LoopEquations, Row
from .leg import MEET, meeting_point
from .spatial import Chain, rotation_between


@dataclass(frozen=True)
class Ball:
    """The ball joint at the end of a chain: three revolute joints whose axes meet.

    Attributes:
        before: the chain up to the meeting point O of the axes, in the frame of the link before.
        joints: the bodies of the joints.
        centre: O in the frame of the last body (3,) [m].
    """

    before: Chain
    joints: tuple[Body, Body, Body]
    centre: Vector

    @property
    def coordinates(self) -> tuple[int, int, int]:
        """The coordinates of its three joints."""
        first, second, third = self.joints
        return first.coordinate, second.coordinate, third.coordinate


@dataclass(frozen=True)
class BallCut:
    """A weld as a point closure and equations of orientation.

    Attributes:
        ends: chains of the point closure.
        orientation: the equations of orientation.
    """

    ends: tuple[Chain, Chain]
    orientation: Orientation


def cut_at_ball(name: str, chains: tuple[Chain, Chain], only: frozenset[int]) -> BallCut | None:
    """Cut a weld at a ball joint whose three coordinates are in `only`; None if there is none."""
    for chain, other in (chains, chains[::-1]):
        ball = find_ball(chain, only)
        if ball is None:
            continue
        turn = matmul(other.rotation, transpose(chain.rotation))
        centre = add(other.point, matvec(turn, sub(ball.centre, chain.point)))
        ends = (ball.before, Chain(other.bodies, centre))
        return BallCut(ends, Orientation(name, ball, chain, other))
    return None


def find_ball(chain: Chain, only: frozenset[int]) -> Ball | None:
    """The ball joint at the end of a chain; None if there is none."""
    joints = chain.bodies[-3:]
    plain = [joint for joint in joints if joint.is_revolute and joint.coordinate in only]
    if len(plain) < 3 or any(joint.chart is not None for joint in joints[1:]):
        return None
    first, second, third = joints
    inner = meeting_point(first, second)
    outer = meeting_point(second, third)
    if inner is None or outer is None:
        return None
    in_parent, in_second = inner
    in_first, in_third = outer
    # both meeting points are on the second axis, which stays in the frame of the first body
    placed = np.array(second.rotation) @ np.array(in_second) + np.array(second.translation)
    if norm(placed - np.array(in_first)) > MEET:
        return None
    return Ball(Chain(chain.bodies[:-3], in_parent), (first, second, third), in_third)


class Orientation(LoopEquations):
    """The rotation vector between the frames at the ends of two chains is zero."""

    length = 1.0
    has_length = False

    def __init__(self, name: str, ball: Ball, chain: Chain, other: Chain) -> None:
        self.name = name
        self.ball = ball
        self.chain = chain
        self.other = other
        self.involved = (chain.coordinates | other.coordinates,) * 3

    def linearise(self, configuration: Configuration) -> Linearised:
        """The rotation vector and the differences of angular velocities."""
        a = self.chain.at(configuration)
        b = self.other.at(configuration)
        jacobian: list[Row] = [{}, {}, {}]
        for sign, state in ((1.0, a), (-1.0, b)):
            for k, (_, angular) in state.columns().items():
                for row, entry in zip(jacobian, angular, strict=True):
                    row[k] = sign * entry
        return Linearised(jacobian, list(rotation_between(a.rotation, b.rotation)))

    def bias(self, configuration: Configuration, rates: Scalars) -> list[Scalar]:
        """The difference of the angular accelerations with joint accelerations zero."""
        _, of_chain = self.chain.at(configuration).bias(rates)
        _, of_other = self.other.at(configuration).bias(rates)
        return list(sub(of_chain, of_other))

    def marks(self, configuration: Configuration) -> list[Scalar]:
        """The orientations of the ends."""
        marks: list[Scalar] = []
        for chain in (self.chain, self.other):
            for row in chain.at(configuration).rotation:
                marks += row
        return marks

    def guards(self, configuration: Configuration) -> list[Scalar]:
        """Cosines between axes of the frames that must be parallel; negative if opposed."""
        a = transpose(self.chain.at(configuration).rotation)
        b = transpose(self.other.at(configuration).rotation)
        return [dot(a[k], b[k]) for k in range(len(IDENTITY3))]
