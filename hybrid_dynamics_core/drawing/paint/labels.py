"""Names beside what they name: each label takes the free place nearest to its anchor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.path import Path
from numpy.typing import NDArray

from ...ground.arrays import Array

_CELL = 3.0  # [px] of the grid that remembers what is covered
_DIRECTIONS = np.linspace(0.0, 2.0 * np.pi, 25)[:-1]
_DISTANCES = (2.0, 6.0, 12.0, 20.0, 30.0, 44.0, 60.0, 80.0, 110.0)  # [pt] beyond the symbol
_EDGE = 2.0  # weight of an outline: a line through a name is worse than a ground behind it
_UNDER = 0.5  # that of an outline under a name on a ground of its own, which hides it
_ABOVE = 0.2  # of the cost: what a place above is better than one beside
_PILL, _AIR = (
    2.5,
    2.0,
)  # [pt] around a name that stands on a ground of its own, and around one that does not
_CROSSED = 0.05  # weight of what lies between a name and what it names
_BODY = 3.0  # of that, more than of what is named itself: something stands between
_NEAR, _FAR = 0.05, 3e-4  # weights of the distance [1/pt, 1/pt^2]
_LINE = 10.0  # weight of a leader: names do not stand on it, and other leaders go another way
_NAME = 60.0  # weight of a name
_LEADER = 11.0  # [pt] a label farther away than this gets a line


@dataclass(frozen=True, eq=False)
class Label:
    """A text for a point (2,) of the drawing; `clear`: radius of the symbol around it, in data units."""

    text: str
    at: Array
    clear: float
    style: dict[str, Any]
    gid: str
    colour: str
    inside: bool = False  # may stand on the point itself


class Labeller:
    """Places labels on axes whose limits and size are final."""

    def __init__(self, axes: Axes, covered: Sequence[tuple[Array, float]]) -> None:
        self.axes = axes
        self.point = float(axes.figure.dpi) / 72.0  # [px]
        box = axes.bbox
        self.origin = np.array([box.x0, box.y0])
        shape = np.maximum(np.ceil(np.array([box.height, box.width]) / _CELL).astype(int), 1)
        self.grid = np.zeros(tuple(shape))
        for outline, weight in covered:
            self._cover(self._cells(outline), weight)

    def place(self, labels: Sequence[Label]) -> None:
        """Put labels one after another, the important ones first."""
        for label in labels:
            self._place(label)

    def _cells(self, points: Array) -> Array:
        return np.asarray((self.axes.transData.transform(points) - self.origin) / _CELL)

    def _cover(self, outline: Array, weight: float) -> None:
        if len(outline) > 2:
            low = np.maximum(np.floor(outline.min(axis=0)).astype(int), 0)
            high = np.maximum(np.ceil(outline.max(axis=0)).astype(int), low)
            cells = self.grid[low[1] : high[1], low[0] : high[0]]
            rows, columns = np.indices(cells.shape)
            centres = np.stack([columns.ravel() + 0.5, rows.ravel() + 0.5], axis=1) + low
            inside = Path(outline).contains_points(centres).reshape(cells.shape)
            cells[inside] = np.maximum(cells[inside], weight)
        for ends in zip(outline, np.roll(outline, -1, axis=0), strict=True):
            on = self._on(np.array(ends) * _CELL + self.origin)
            self.grid[on] = np.maximum(self.grid[on], _EDGE)

    def _place(self, label: Label) -> None:
        text = self.axes.annotate(
            label.text, (float(label.at[0]), float(label.at[1])), xytext=(0, 0), textcoords="offset points",
            ha="center", va="center", annotation_clip=False, zorder=20, **label.style,
        )  # fmt: skip
        text.set_gid(label.gid)
        box = text.get_window_extent()
        pill = "bbox" in label.style
        pad = (_PILL if pill else _AIR) * self.point
        half = np.array([box.width, box.height]) / 2.0 + pad
        anchor = self.axes.transData.transform(label.at)
        clear = float(
            np.linalg.norm(
                self.axes.transData.transform(label.at + np.array([label.clear, 0.0])) - anchor
            )
        )
        best, lead = self._best(anchor, half, clear, _UNDER if pill else _EDGE, label.inside)
        text.set_position((best - anchor) / self.point)
        if lead:
            self._lead(label, _between(anchor, best, half, clear))
        self._remember(best, half)

    def _best(
        self, anchor: Array, half: Array, clear: float, edge: float, inside: bool
    ) -> tuple[Array, bool]:
        """Centre of the free place nearest to an anchor, and whether a line leads there: far, or across a body.

        `edge`: weight of an outline under this name.
        """
        best, lead = anchor, False
        own = min(
            self._crossed(anchor, _beside(anchor, way, clear, half), half, clear)
            for way in _DIRECTIONS
        )
        least = self._cost(anchor, half, edge) - _ABOVE if inside else np.inf
        for distance in _DISTANCES:
            for direction in _DIRECTIONS:
                centre = _beside(anchor, direction, clear + distance * self.point, half)
                away = _NEAR * distance + _FAR * distance**2 - _ABOVE * np.sin(direction)
                cost = self._cost(centre, half, edge) + away
                if cost >= least:
                    continue
                crossed = self._crossed(anchor, centre, half, clear) - own
                cost += _CROSSED * crossed
                if cost < least:
                    best, least, lead = centre, cost, distance > _LEADER or crossed > _BODY
        return best, lead

    def _crossed(self, anchor: Array, centre: Array, half: Array, clear: float) -> float:
        """What lies between a symbol and a box; an outline counts once, however many cells of it are met."""
        values = self.grid[self._on(_between(anchor, centre, half, clear))]
        edge = values == _EDGE
        met = np.diff(edge.astype(int), prepend=0) > 0
        return float(values[~edge].sum() + _EDGE * met.sum())

    def _lead(self, label: Label, ends: Array) -> None:
        self.grid[self._on(ends)] = _LINE
        self.axes.plot(
            *self.axes.transData.inverted().transform(ends).T,
            color=label.colour,
            linewidth=0.7,
            zorder=19,
        )

    def _on(self, ends: Array) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Cells, rows and columns, on a line between two points [px], in its order."""
        count = 2 + int(np.linalg.norm(ends[1] - ends[0]) / (0.5 * _CELL))
        cells = np.floor((np.linspace(ends[0], ends[1], count) - self.origin) / _CELL).astype(
            np.int64
        )
        cells = cells[((cells >= 0) & (cells < self.grid.shape[::-1])).all(axis=1)]
        cells = cells[np.any(np.diff(cells, axis=0, prepend=-1) != 0, axis=1)]
        return cells[:, 1], cells[:, 0]

    def _cost(self, centre: Array, half: Array, edge: float) -> float:
        """What a box would cover, and how much of it would stand outside of the axes."""
        (x0, y0), (x1, y1) = self._box(centre, half)
        rows, columns = self.grid.shape
        outside = float(max(0, -x0) + max(0, -y0) + max(0, x1 - columns) + max(0, y1 - rows))
        inside = self.grid[max(y0, 0) : max(y1, 0), max(x0, 0) : max(x1, 0)]
        return 0.25 * float(np.where(inside == _EDGE, edge, inside).sum()) + 5.0 * outside

    def _remember(self, centre: Array, half: Array) -> None:
        (x0, y0), (x1, y1) = self._box(centre, half)
        self.grid[max(y0, 0) : max(y1, 0), max(x0, 0) : max(x1, 0)] = _NAME

    def _box(self, centre: Array, half: Array) -> tuple[tuple[int, int], tuple[int, int]]:
        low = np.floor((centre - half - self.origin) / _CELL).astype(int)
        high = np.ceil((centre + half - self.origin) / _CELL).astype(int)
        return (int(low[0]), int(low[1])), (int(high[0]), int(high[1]))


def _between(anchor: Array, centre: Array, half: Array, clear: float) -> Array:
    """Ends (2, 2) of a line from the symbol at an anchor to a box."""
    way = (centre - anchor) / np.linalg.norm(centre - anchor)
    reach = float(np.min(half / np.maximum(np.abs(way), 1e-9)))
    return np.array([anchor + 0.6 * clear * way, centre - reach * way])


def _beside(anchor: Array, direction: float, clear: float, half: Array) -> Array:
    """Centre of a box outside of the circle around an anchor, beside it in a direction; the box's edge slides along."""
    way = np.array([np.cos(direction), np.sin(direction)])
    return np.asarray(anchor + (clear + half) * way / np.abs(way).max())
