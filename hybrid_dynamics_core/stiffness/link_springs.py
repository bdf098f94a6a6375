"""Springs within a link, and which of them each place of the link moves with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..algebra.independence import norm
from ..description.elasticity import Beam, LinkMatrix
from ..description.elasticity.data import LinkElasticity
from ..description.model import RobotDescription
from ..errors import InputError
from ..ground.arrays import Array
from .attachments import Key, places_on, point_on
from .beam_matrix import beam_axes, beam_compliance, factor, factor_of_stiffness

SAME_PLACE = 1e-9  # of a beam's length, between two ends of beams that meet

Chain = tuple[int, ...]  # indices of springs, the one nearest the link's own joint first


class LinkSpring(NamedTuple):
    """A spring of six freedoms within a link.

    Attributes:
        point: (3,) where its deformation is taken, in the link frame [m].
        deformations: (6, 6) displacement there per coordinate of unit stiffness, in link axes.
    """

    point: Array
    deformations: Array


class LinkFlex(NamedTuple):
    """The springs of a link.

    Attributes:
        springs: the springs.
        chains: the springs between the link's own joint and each place.
    """

    springs: tuple[LinkSpring, ...]
    chains: Mapping[Key, Chain]


class _Foot(NamedTuple):
    """The point of a beam that is nearest to a place.

    Attributes:
        distance: from the place [m].
        beam: index of the beam.
        share: of the beam's length before it.
    """

    distance: float
    beam: int
    share: float


class _Line(NamedTuple):
    """A beam from start to end (3,), in the link frame [m]."""

    beam: Beam
    start: Array
    end: Array

    @property
    def length(self) -> float:
        return norm(self.end - self.start)

    def foot(self, point: Array, number: int) -> _Foot:
        """The nearest point."""
        along = self.end - self.start
        reached = (point - self.start) @ along
        share = float(np.clip(reached / (along @ along), 0.0, 1.0))
        if min(share, 1.0 - share) <= SAME_PLACE:
            share = round(share)
        nearest = self.start + share * along
        return _Foot(norm(nearest - point), number, share)

    def piece(self, low: float, high: float) -> LinkSpring:
        """The spring of the piece between two shares of the length."""
        along = self.end - self.start
        axes = beam_axes(self.beam, along / self.length)
        compliance = beam_compliance(self.beam, (high - low) * self.length)
        local = factor(compliance)
        linear = axes @ local[:3]
        angular = axes @ local[3:]
        return LinkSpring(self.start + high * along, np.vstack([linear, angular]))


def link_flex(description: RobotDescription, link: str, elasticity: LinkElasticity) -> LinkFlex:
    """The springs of an elastic link.

    Args:
        description: the robot.
        link: name of the link.
        elasticity: its beams or matrix.

    Raises:
        InputError: a place is not on the link, a beam has no length, or it begins where no beam
            before it ends.
    """
    places = places_on(description, link)
    if isinstance(elasticity, LinkMatrix):
        at = point_on(places, elasticity.at, link)
        spring = LinkSpring(at, factor_of_stiffness(elasticity.matrix))
        return LinkFlex((spring,), dict.fromkeys(places, (0,)))
    lines: list[_Line] = []
    for k, beam in enumerate(elasticity):
        lines.append(_line(beam, places, f"links.{link}: beam {k + 1}", link))
    return _cut(lines, places, link)


def _line(beam: Beam, places: Mapping[Key, Array], what: str, link: str) -> _Line:
    start = np.zeros(3)
    if beam.start is not None:
        start = point_on(places, beam.start, link)
    end = point_on(places, beam.to, link)
    size = max(norm(start), norm(end))
    if not norm(end - start) > SAME_PLACE * size:
        raise InputError(
            f"{what} begins and ends at {_text(end)}; expected two places, with `start` and `to`"
        )
    return _Line(beam, start, end)


def _cut(lines: Sequence[_Line], places: Mapping[Key, Array], link: str) -> LinkFlex:
    """Beams cut where something is attached, each place at the nearest point."""
    feet = {key: _nearest(lines, point) for key, point in places.items()}
    springs: list[LinkSpring] = []
    chains: dict[Key, Chain] = {}
    ends: list[Chain] = []
    for k, line in enumerate(lines):
        here = {key: foot.share for key, foot in feet.items() if foot.beam == k}
        shares = sorted({0.0, 1.0, *here.values()})
        at = {0.0: _before(lines, k, ends, link)}
        for low, high in pairwise(shares):
            springs.append(line.piece(low, high))
            at[high] = (*at[low], len(springs) - 1)
        ends.append(at[1.0])
        for key, share in here.items():
            chains[key] = at[share]
    return LinkFlex(tuple(springs), chains)


def _before(lines: Sequence[_Line], k: int, ends: Sequence[Chain], link: str) -> Chain:
    """Springs before the start of a beam: none at the origin, else those of the beam there."""
    line = lines[k]
    near = SAME_PLACE * line.length
    for other, chain in zip(lines, ends, strict=False):
        if norm(other.end - line.start) <= near:
            return chain
    if norm(line.start) <= near:
        return ()
    raise InputError(
        f"links.{link}: beam {k + 1} begins at {_text(line.start)}; expected the origin of the"
        " link, or the end of a beam before it"
    )


def _nearest(lines: Sequence[_Line], point: Array) -> _Foot:
    """The nearest point of all beams; of equal ones, that of the first."""
    feet = [line.foot(point, k) for k, line in enumerate(lines)]
    slack = SAME_PLACE * max(line.length for line in lines)
    nearest = min(foot.distance for foot in feet)
    return next(foot for foot in feet if foot.distance <= nearest + slack)


def _text(point: Array) -> str:
    numbers = ", ".join(f"{x:g}" for x in point)
    return f"[{numbers}] m"
