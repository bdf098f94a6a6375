"""A singular place on a straight motion of the given coordinates, and the smooth way through it.

At a change point u = u* + x way with x from below to above zero, and all coordinates s are smooth
in x. At a toggle u turns: u = u* - x^2 way, and s is smooth in x again. In both cases the distance
to the singularity has a simple zero at x = 0 if it is counted negative beyond it.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...ground.arrays import Array
from ...kernels.status import GOOD
from ...mechanism.configuration import configuration_at
from ...programs import Model
from ..assembly_modes import matching_signs
from ..closure_solver import ClosureSolver
from ..continuation import Start
from .interpolation import root, slope_weights, weights

SPACING = np.array([1.0, 1.3, 1.7, 2.2, 2.8])  # places of one side, in units of the nearest one
DISTANCES = (0.02, 0.045)  # to the singularity, of the nearest place: R keeps 12 digits there
HALVINGS = 3  # most times that all places are moved nearer
MISFIT = 1e-6  # [rad or m] largest disagreement of interpolations by all places and by fewer
ENOUGH = 1e-11  # disagreement at which the places need not be nearer
CLOSED = 1e-9  # residual of the loops, in their lengths, up to which the place is singular
ROUNDS = 24  # trials to find a fitting width


class PassageKind(Enum):
    """What kind of singular place a motion passes.

    At a change point two motions cross, and J_s loses rank. At a toggle there is one motion, and
    the given coordinates turn back.
    """

    CHANGE_POINT = "change point"
    TOGGLE = "toggle"

    @property
    def power(self) -> int:
        """Power of x in the given coordinates."""
        return 1 if self is PassageKind.CHANGE_POINT else 2


class Line(NamedTuple):
    """A straight motion of the given coordinates, from 0 to 1.

    Attributes:
        origin: given coordinates (n,) at 0 [rad, m].
        way: their change (n,) to 1.
    """

    origin: Array
    way: Array

    def at(self, share: float) -> Array:
        """The given coordinates (n,)."""
        return self.origin + share * self.way


class Places(NamedTuple):
    """Closed configurations on a way through a singular place.

    Attributes:
        x: (m,) places, ascending; negative before the singular place.
        s: all coordinates (m, n_s) [rad, m].
        maps: R (m, n_s, n).
        distances: distances of the blocks to a singularity (m, blocks), negative beyond theirs.
        signs: branch signs (m, blocks).
    """

    x: Array
    s: Array
    maps: Array
    distances: Array
    signs: Array

    def joined(self, other: Places) -> Places:
        """These places and others after them."""
        pairs = zip(self, other, strict=True)
        return Places(*[np.concatenate(pair) for pair in pairs])

    def rows(self, which: slice) -> Places:
        """Some of the places."""
        return Places(*[part[which] for part in self])


@dataclass(frozen=True, eq=False)
class Crossing:
    """A singular place on a line, and the smooth way through it.

    Attributes:
        kind: change point or toggle.
        line: the straight motion of the given coordinates.
        share: where on the line the singular place is.
        places: closed configurations before it and beyond it.
        blocks: indices of the blocks of the closure plan that are singular there.
    """

    kind: PassageKind
    line: Line
    share: float
    places: Places
    blocks: NDArray[np.intp]

    @property
    def before(self) -> Array:
        """Branch signs (blocks,) before the place."""
        return np.asarray(self.places.signs[0])

    @property
    def beyond(self) -> Array:
        """Branch signs (blocks,) beyond the place."""
        return np.asarray(self.places.signs[-1])

    @property
    def room(self) -> float:
        """Least x of a place beyond the singular one."""
        return float(self.places.x[len(SPACING)])

    def x_of(self, share: float) -> float:
        """The x of a point of the line; at a toggle that before the place."""
        if self.kind is PassageKind.CHANGE_POINT:
            return share - self.share
        return -float(np.sqrt(max(self.share - share, 0.0)))

    def s_at(self, x: float) -> Array:
        """All coordinates (n_s,) [rad, m]."""
        return np.asarray(weights(self.places.x, x) @ self.places.s)

    def map_at(self, x: float) -> Array:
        """R (n_s, n) on this branch of a change point."""
        return np.asarray(np.tensordot(weights(self.places.x, x), self.places.maps, 1))

    def tangent(self) -> Array:
        """ds/dx (n_s,) at the place."""
        return np.asarray(slope_weights(self.places.x, 0.0) @ self.places.s)

    def exit(self) -> Start:
        """The nearest closed configuration beyond the place."""
        nearest = len(SPACING)
        return Start(self.places.s[nearest], self.places.maps[nearest])


def find_crossing(
    solver: ClosureSolver, model: Model, start: Start, signs: Array, line: Line
) -> Crossing | None:
    """The first singular place on a line, and the way through it.

    Args:
        solver: closes the loops from the given coordinates.
        model: tree and closure plan.
        start: closed configuration at the start of the line.
        signs: branch signs (blocks,) there.
        line: straight motion of the given coordinates.

    Returns:
        The crossing; None if the motion meets no singular place, or none with a smooth way through.
    """
    share = solver.share_reached(line.at(1.0), signs, start)
    if share == 0.0:
        return None
    return _Search(solver, model, start, signs, line).crossing(share)


class _Search:
    """The search for one crossing."""

    def __init__(
        self, solver: ClosureSolver, model: Model, start: Start, signs: Array, line: Line
    ) -> None:
        self._solver = solver
        self._model = model
        self._start = start
        self._signs = signs
        self._line = line

    def crossing(self, share: float) -> Crossing | None:
        """The crossing near a share of the line."""
        width = self._width(share)
        if width is None:
            return None
        kind = self._kind(share, width)
        best: Crossing | None = None
        least = MISFIT
        for halving in range(HALVINGS + 1):
            x = width ** (1.0 / kind.power) / 2.0**halving
            crossing = self._through(kind, share, x)
            if crossing is None:
                continue
            misfit = _misfit(crossing)
            if misfit < ENOUGH:
                return crossing
            if misfit < least:
                best, least = crossing, misfit
            elif best is not None:
                break
        return best

    def _distance(self, share: float) -> float | None:
        """Distance of the nearest block at a share of the line; None if it does not close."""
        values, code = self._close(self._line.at(share))
        if code != GOOD:
            return None
        return float(values["distances"].min())

    def _close(self, u: Array) -> tuple[dict[str, Array], int]:
        values, code = self._solver.close(u, np.zeros_like(u), self._signs, self._start)
        return values, int(code)

    def _width(self, share: float) -> float | None:
        """How far before the place, as a share of the line, its distance is in `DISTANCES`."""
        least, most = DISTANCES
        width = min(0.05 / float(np.abs(self._line.way).max()), 1e3)
        for _ in range(ROUNDS):
            distance = self._distance(share - width)
            if distance is None:
                width *= 0.25
            elif distance > most:
                width *= 0.5
            elif distance < least:
                width *= 1.7
            else:
                return width
        return None

    def _kind(
        self,
        share: float,
        width: float,
    ) -> PassageKind:
        """By how the distance grows: as the way from a change point, as its root from a toggle."""
        far = self._distance(share - width)
        near = self._distance(share - 0.25 * width)
        if far is None or near is None or far > 2.83 * near:
            return PassageKind.CHANGE_POINT
        return PassageKind.TOGGLE

    def _through(
        self,
        kind: PassageKind,
        share: float,
        x: float,
    ) -> Crossing | None:
        """The crossing, from places whose nearest ones are x from the singular place."""
        for _ in range(3):
            before = self._before(kind, share, x)
            if before is None:
                return None
            block = int(before.distances[-1].argmin())
            powers = before.distances[:, block] ** kind.power
            shares = share - np.abs(before.x) ** kind.power
            share = root(shares, powers, share)
        before = self._before(kind, share, x)
        if before is None:
            return None
        beyond = self._beyond(kind, share, before)
        if beyond is None:
            return None
        crossed = beyond.distances[0] < 0.0
        both = before.joined(beyond)
        if kind is PassageKind.CHANGE_POINT:
            block = int(before.distances[-1].argmin())
            off = root(both.x, both.distances[:, block], 0.0)
            both = both._replace(x=both.x - off)
            share += off
        crossing = Crossing(kind, self._line, share, both, np.flatnonzero(crossed))
        if not crossed.any() or self._gap(crossing.s_at(0.0)) > CLOSED:
            return None
        return crossing

    def _before(
        self,
        kind: PassageKind,
        share: float,
        x: float,
    ) -> Places | None:
        """The places before the singular one."""
        offsets = -x * SPACING[::-1]
        rows = []
        for offset in offsets:
            values, code = self._close(self._line.at(share - abs(offset) ** kind.power))
            if code != GOOD:
                return None
            rows.append((values["s"], values["R"], values["distances"], self._signs))
        return Places(offsets, *[np.array(part) for part in zip(*rows, strict=True)])

    def _beyond(
        self,
        kind: PassageKind,
        share: float,
        before: Places,
    ) -> Places | None:
        """The places beyond the singular one: each is extrapolated, then closed."""
        blocks = len(self._model.plan.blocks)
        places = before
        signs = self._signs
        nearest = -before.x[-1]
        for offset in nearest * SPACING:
            ratios = weights(places.x, offset)
            guess = ratios @ places.s
            if places is before:
                signs = matching_signs(self._model, guess, self._signs[blocks:])
            sign_of_x = 1.0 if kind is PassageKind.CHANGE_POINT else -1.0
            u = self._line.at(share + sign_of_x * offset**kind.power)
            values, code = self._solver.from_guess(u, signs, guess)
            if code != GOOD:
                return None
            foretold = ratios @ places.distances
            distances = np.where(foretold < 0.0, -values["distances"], values["distances"])
            row = (np.array([offset]), values["s"], values["R"], distances, signs)
            places = places.joined(
                Places(
                    *[
                        np.reshape(part, (1, *np.shape(part))) if k else part
                        for k, part in enumerate(row)
                    ]
                )
            )
        return places.rows(slice(len(SPACING), None))

    def _gap(self, s: Array) -> float:
        """The largest residual of the loops at s, in their lengths."""
        blocks = len(self._model.plan.blocks)
        configuration = configuration_at(self._model.tree, s, self._signs[blocks:])
        gaps: list[float] = []
        for loop in self._model.plan.loops:
            residual = loop.linearise(configuration).residual
            gaps += [abs(float(value)) for value in residual]
        return max(gaps)


def _misfit(crossing: Crossing) -> float:
    """How much the configuration at the place, and the tangent, depend on the outermost places."""
    places = crossing.places
    fewer = places.rows(slice(1, -1))
    s = weights(fewer.x, 0.0) @ fewer.s
    off = np.abs(s - crossing.s_at(0.0)).max()
    tangent = slope_weights(fewer.x, 0.0) @ fewer.s
    scale = np.abs(places.x).max()
    turned = np.abs(tangent - crossing.tangent()).max() * scale
    return float(max(off, turned))
