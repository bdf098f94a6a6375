"""Closure along a motion that passes change points, and toggles that it touches."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...ground.arrays import Array
from ...kernels.status import GOOD
from ...programs import Model
from ..closure_solver import ClosureSolver
from ..continuation import Start
from .crossing import Crossing, Line, PassageKind, find_crossing
from .record import Passage
from .recorded import Passed, recorded

TOUCHED = 1e-9  # [rad or m] a path this near a turning value touches it
MOST = 32  # passages between two rows


@dataclass(frozen=True, eq=False)
class ThroughPath:
    """A motion that was followed through singular places.

    Attributes:
        s: all coordinates (N, n_s) [rad, m].
        signs: branch signs (N, blocks).
        code: status code of the first row that was not reached; `GOOD` if all were.
        reached: number of rows that were reached.
        at_places: R (n_s, n) of rows at a singular place, by row; NaN at a toggle.
        passages: the singular places, in order.
    """

    s: Array
    signs: Array
    code: int
    reached: int
    at_places: Mapping[int, Array]
    passages: tuple[Passage, ...]


def follow_through(
    solver: ClosureSolver, model: Model, u: Array, signs: Array, start: Start | None
) -> ThroughPath:
    """Close along a motion, each row followed from the previous one, through singular places.

    Args:
        solver: closes the loops from the given coordinates.
        model: tree and closure plan.
        u: given coordinates (N, n) [rad, m].
        signs: branch signs (blocks,) at the start.
        start: the configuration before the first row; the reference if None.
    """
    path = _Path(solver, model, u, signs)
    path.follow(start)
    return path.result()


class _Path:
    """A motion on its way through singular places."""

    def __init__(
        self,
        solver: ClosureSolver,
        model: Model,
        u: Array,
        signs: Array,
    ) -> None:
        self._solver = solver
        self._model = model
        self._u = u
        self._signs = signs
        self._done = 0
        self._code = GOOD
        self._s: list[Array] = []
        self._rows_of_signs: list[Array] = []
        self._at_places: dict[int, Array] = {}
        self._passages: list[Passage] = []
        # branches on from a place at which a row is: on the branch beyond it, or back
        self._branches: list[tuple[Start, Array]] = []

    def result(self) -> ThroughPath:
        """The motion as far as it was followed."""
        rows = [*self._s]
        signs = [*self._rows_of_signs]
        for _ in range(len(self._u) - self._done):
            rows.append(np.full(self._model_size, np.nan))
            signs.append(self._signs)
        return ThroughPath(
            s=np.reshape(rows, (len(self._u), -1)),
            signs=np.reshape(signs, (len(self._u), -1)),
            code=self._code,
            reached=self._done,
            at_places=self._at_places,
            passages=tuple(self._passages),
        )

    @property
    def _model_size(self) -> int:
        return len(self._model.tree.coordinates)

    def follow(self, start: Start | None) -> None:
        """Follow all rows, or as many as are reached."""
        passed = 0
        while self._done < len(self._u):
            before = self._done
            start = self._regular(start)
            if self._done > before:
                passed = 0
            if self._done == len(self._u):
                return
            if start is None or passed == MOST:
                return
            passed += 1
            beyond = self._pass(start)
            if beyond is None:
                return
            start = beyond
        self._code = GOOD

    def _regular(self, start: Start | None) -> Start | None:
        """Follow rows until one fails; returns the last configuration."""
        if self._branches:
            start = self._leave()
        u = self._u[self._done :]
        values, codes = self._solver.path(u, np.zeros_like(u), self._signs, start)
        failures = np.flatnonzero(codes)
        good = int(failures[0]) if len(failures) else len(u)
        for row in range(good):
            self._add(values["s"][row], self._signs)
        self._code = int(codes[good]) if good < len(u) else GOOD
        if good:
            return Start(values["s"][good - 1], values["R"][good - 1])
        return start

    def _leave(self) -> Start:
        """The side of the place on which the next row is: beyond it, if that can be reached."""
        u = self._u[self._done]
        branches, self._branches = self._branches, []
        for start, signs in branches:
            _, code = self._solver.close(u, np.zeros_like(u), signs, start)
            if code == GOOD:
                self._signs = signs
                return start
        start, self._signs = branches[0]
        return start

    def _add(
        self,
        s: Array,
        signs: Array,
    ) -> None:
        self._s.append(s)
        self._rows_of_signs.append(signs)
        self._done += 1

    def _pass(self, start: Start) -> Start | None:
        """Pass the singular place before the next row; returns where the motion goes on."""
        origin = start.s[self._solver.given]
        line = Line(origin, self._u[self._done] - origin)
        if not line.way.any():
            return None
        crossing = find_crossing(self._solver, self._model, start, self._signs, line)
        if crossing is None:
            return None
        off = (1.0 - crossing.share) * float(np.abs(line.way).max())
        if crossing.kind is PassageKind.TOGGLE and abs(off) > TOUCHED:
            return None
        if crossing.share > 1.0 and abs(off) > TOUCHED:
            return None
        self._passages.append(self._record(crossing))
        before, self._signs = self._signs, crossing.beyond
        if not self._stop_at(crossing):
            return crossing.exit()
        entry = len(crossing.places.x) // 2 - 1
        back = Start(crossing.places.s[entry], crossing.places.maps[entry])
        self._branches = [(crossing.exit(), crossing.beyond), (back, before)]
        if crossing.kind is PassageKind.TOGGLE:
            self._branches.pop()
        return crossing.exit()

    def _stop_at(self, crossing: Crossing) -> bool:
        """Add the rows that are at the place, or too near to it to close; whether there are any."""
        begin = self._done
        while self._done < len(self._u):
            u = self._u[self._done]
            share = _share_of(crossing.line, u)
            if share is None:
                break
            x = crossing.x_of(share)
            if abs(x) >= crossing.room and crossing.kind is PassageKind.CHANGE_POINT:
                break
            if crossing.kind is PassageKind.TOGGLE:
                if np.abs(u - crossing.line.at(crossing.share)).max() > TOUCHED:
                    break
                self._at_places[self._done] = np.full_like(crossing.places.maps[0], np.nan)
                self._add(crossing.s_at(0.0), crossing.beyond)
                continue
            signs = crossing.beyond if x > 0.0 else crossing.before
            s = crossing.s_at(x)
            _, code = self._solver.from_guess(u, signs, s)
            if code != GOOD:
                self._at_places[self._done] = crossing.map_at(x)
            self._add(s, signs)
        return self._done > begin

    def _record(self, crossing: Crossing) -> Passage:
        """The record of a passage."""
        rates = crossing.tangent()
        if crossing.kind is PassageKind.TOGGLE:
            rates = rates / np.linalg.norm(rates)
        passed = Passed(
            crossing.kind,
            crossing.blocks.tolist(),
            crossing.s_at(0.0),
            rates,
            crossing.before,
            crossing.beyond,
        )
        return recorded(self._model, passed, self._done)


def _share_of(line: Line, u: Array) -> float | None:
    """Where u (n,) is on a line; None if it is beside it."""
    share = float((u - line.origin) @ line.way / (line.way @ line.way))
    if np.abs(line.at(share) - u).max() > TOUCHED:
        return None
    return share
