"""Placement of labels: each takes the free place nearest to its anchor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.path import Path
from matplotlib.text import Annotation
from numpy.typing import NDArray

from ...ground.arrays import Array

_CELL = 3.0  # [px] cell of the occupancy grid
_DIRECTIONS = np.linspace(0.0, 2.0 * np.pi, 25)[:-1]
_DISTANCES = (2.0, 6.0, 12.0, 20.0, 30.0, 44.0, 60.0, 80.0, 110.0)  # [pt] from the symbol
_EDGE = 2.0  # weight of an outline; a line through a name is worse than a filled area behind it
_UNDER = 0.5  # weight of an outline under a name with a background of its own
_ABOVE = 0.2  # discount of the cost of a place above the anchor
# [pt] padding of a name with a background of its own, and of one without
_PILL, _AIR = 2.5, 2.0
_CROSSED = 0.05  # weight of objects between a name and its anchor
_BODY = 3.0  # threshold of this cost above which a body is in between
_PARTED = 6.0  # weight of a body between a name and its anchor
_ASTRAY = 0.3  # [1/pt] weight of the distance by which a name is nearer to another anchor
_NEAR, _FAR = 0.05, 3e-4  # weights of the distance [1/pt, 1/pt^2]
_LINE = 10.0  # weight of a leader line, which names and other leaders avoid
_NAME = 60.0  # weight of a name
_LEADER = 11.0  # [pt] a label farther away than this gets a leader line

CellIndex = tuple[NDArray[np.int64], NDArray[np.int64]]  # rows and columns


@dataclass(frozen=True, eq=False)
class Label:
    """A text for a point of the drawing.

    Attributes:
        text: the text.
        at: (2,) the point, in data units.
        clear: radius of the symbol around the point, in data units.
        style: keywords of Matplotlib's annotation.
        gid: id of the text in the file.
        colour: colour of the leader line.
        inside: whether the text may cover the point itself.
    """

    text: str
    at: Array
    clear: float
    style: dict[str, Any]
    gid: str
    colour: str
    inside: bool = False


@dataclass(frozen=True, eq=False)
class TextBox:
    """Anchor and size of a label to place.

    Attributes:
        anchor: (2,) the point [px].
        half: (2,) half of the text's width and height, with padding [px].
        clear: radius of the symbol around the point [px].
        edge: weight of an outline under the text.
    """

    anchor: Array
    half: Array
    clear: float
    edge: float

    def beside(self, direction: float, distance: float) -> Array:
        """(2,) centre [px] of a text at a distance [px] from the symbol, in a direction [rad].

        The text's box touches a circle around the symbol.
        """
        way = np.array([np.cos(direction), np.sin(direction)])
        room = self.clear + distance + self.half
        return np.asarray(self.anchor + room * way / np.abs(way).max())

    def distance(self, centre: Array, point: Array) -> float:
        """Distance of a text with a given centre from a point (2,) [px]."""
        outside = np.maximum(np.abs(centre - point) - self.half, 0.0)
        return float(np.linalg.norm(outside))

    def leader(self, centre: Array) -> Array:
        """(2, 2) ends of a leader from the symbol to a text with a given centre [px]."""
        way = (centre - self.anchor) / np.linalg.norm(centre - self.anchor)
        reach = float(np.min(self.half / np.maximum(np.abs(way), 1e-9)))
        return np.array([self.anchor + 0.6 * self.clear * way, centre - reach * way])


class Labeller:
    """Places labels on axes whose limits and size are final.

    Args:
        axes: to be labelled.
        covered: outlines (m, 2) of painted objects in data units, each with a weight.
    """

    def __init__(self, axes: Axes, covered: Sequence[tuple[Array, float]]) -> None:
        self.axes = axes
        self.point = float(axes.figure.dpi) / 72.0  # [px]
        box = axes.bbox
        self.origin = np.array([box.x0, box.y0])
        cells = np.ceil(np.array([box.height, box.width]) / _CELL)
        self.grid = np.zeros(tuple(np.maximum(cells.astype(int), 1)))
        for outline, weight in covered:
            self._cover(self._cells(outline), weight)

    def place(self, labels: Sequence[Label]) -> None:
        """Place labels in order; pass the important ones first."""
        if not labels:
            return
        anchors = self.axes.transData.transform([label.at for label in labels])
        for k, label in enumerate(labels):
            self._place(label, np.delete(anchors, k, axis=0))

    def _cells(self, points: Array) -> Array:
        pixels = self.axes.transData.transform(points)
        return np.asarray((pixels - self.origin) / _CELL)

    def _cover(self, outline: Array, weight: float) -> None:
        """Mark the cells on an outline (m, 2) [cells] as covered."""
        if len(outline) > 2:
            self._cover_inside(outline, weight)
        cells = np.floor(_points_along(outline)).astype(np.int64)
        columns, rows = cells[self._is_on_grid(cells)].T
        self.grid[rows, columns] = np.maximum(self.grid[rows, columns], _EDGE)

    def _cover_inside(self, outline: Array, weight: float) -> None:
        low = np.maximum(np.floor(outline.min(axis=0)).astype(int), 0)
        high = np.maximum(np.ceil(outline.max(axis=0)).astype(int), low)
        cells = self.grid[low[1] : high[1], low[0] : high[0]]
        rows, columns = np.indices(cells.shape)
        centres = np.stack([columns.ravel() + 0.5, rows.ravel() + 0.5], axis=1) + low
        inside = Path(outline).contains_points(centres).reshape(cells.shape)
        cells[inside] = np.maximum(cells[inside], weight)

    def _place(self, label: Label, others: Array) -> None:
        """Place one label nearer to its point than to other points (k, 2) [px]."""
        text = self.axes.annotate(
            label.text,
            (float(label.at[0]), float(label.at[1])),
            xytext=(0, 0),
            textcoords="offset points",
            ha="center",
            va="center",
            annotation_clip=False,
            zorder=20,
            **label.style,
        )
        text.set_gid(label.gid)
        box = self._box_of(label, text)
        centre, needs_leader = self._best_place(box, label.inside, others)
        x, y = ((centre - box.anchor) / self.point).tolist()
        text.set_position((x, y))
        if needs_leader:
            self._draw_leader(label, box.leader(centre))
        self._cover_text(centre, box.half)

    def _box_of(self, label: Label, text: Annotation) -> TextBox:
        extent = text.get_window_extent()
        has_ground = "bbox" in label.style
        pad = _PILL if has_ground else _AIR
        edge = _UNDER if has_ground else _EDGE
        half = np.array([extent.width, extent.height]) / 2.0 + pad * self.point
        transform = self.axes.transData.transform
        anchor = transform(label.at)
        rim = transform(label.at + np.array([label.clear, 0.0]))
        return TextBox(anchor, half, float(np.linalg.norm(rim - anchor)), edge)

    def _best_place(self, box: TextBox, inside: bool, others: Array) -> tuple[Array, bool]:
        """Centre of the free place nearest to the anchor, and whether it needs a leader.

        Places that are far away, or behind a body, need one.
        """
        best, needs_leader = box.anchor, False
        least = self._cost(box, box.anchor) - _ABOVE if inside else np.inf
        symbol = min(self._crossed(box, box.beside(way, 0.0)) for way in _DIRECTIONS)
        for distance in _DISTANCES:
            for direction in _DIRECTIONS:
                centre = box.beside(direction, distance * self.point)
                away = _NEAR * distance + _FAR * distance**2 - _ABOVE * np.sin(direction)
                cost = self._cost(box, centre) + away
                if cost >= least:
                    continue
                crossed = self._crossed(box, centre) - symbol
                is_parted = crossed > _BODY
                astray = self._astray(box, centre, others)
                cost += _CROSSED * crossed + _PARTED * is_parted + _ASTRAY * astray
                if cost < least:
                    best, least = centre, cost
                    needs_leader = distance > _LEADER or is_parted or astray > 0.0
        return best, needs_leader

    def _astray(self, box: TextBox, centre: Array, others: Array) -> float:
        """By how much a text is nearer to another point than to its own [pt]."""
        if not len(others):
            return 0.0
        nearest = min(box.distance(centre, other) for other in others)
        distance = box.distance(centre, box.anchor)
        return max(distance - nearest, 0.0) / self.point

    def _crossed(self, box: TextBox, centre: Array) -> float:
        """Cost of objects between a symbol and its text; each outline counts once."""
        values = self.grid[self._cells_on(box.leader(centre))]
        is_edge = values == _EDGE
        begins = np.diff(is_edge.astype(int), prepend=0) > 0
        return float(values[~is_edge].sum() + _EDGE * begins.sum())

    def _draw_leader(self, label: Label, ends: Array) -> None:
        self.grid[self._cells_on(ends)] = _LINE
        x, y = self.axes.transData.inverted().transform(ends).T
        self.axes.plot(
            x,
            y,
            color=label.colour,
            linewidth=0.7,
            zorder=19,
            gid=f"leader:{label.gid}",
        )

    def _cells_on(self, ends: Array) -> CellIndex:
        """Cells on a line between two points (2, 2) [px], in order."""
        length = np.linalg.norm(ends[1] - ends[0])
        count = 2 + int(length / (0.5 * _CELL))
        points = np.linspace(ends[0], ends[1], count)
        cells = np.floor((points - self.origin) / _CELL).astype(np.int64)
        cells = cells[self._is_on_grid(cells)]
        changes = np.diff(cells, axis=0, prepend=-1) != 0
        cells = cells[np.any(changes, axis=1)]
        return cells[:, 1], cells[:, 0]

    def _is_on_grid(self, cells: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Mask (n,) of cells (n, 2), as (column, row), that the grid has."""
        within = (cells >= 0) & (cells < self.grid.shape[::-1])
        return np.asarray(within.all(axis=1))

    def _cost(self, box: TextBox, centre: Array) -> float:
        """Cost of objects under a text, and of its part outside of the axes."""
        (x0, y0), (x1, y1) = self._text_cells(centre, box.half)
        rows, columns = self.grid.shape
        outside = max(0, -x0) + max(0, -y0) + max(0, x1 - columns) + max(0, y1 - rows)
        values = self.grid[max(y0, 0) : max(y1, 0), max(x0, 0) : max(x1, 0)]
        covered = np.where(values == _EDGE, box.edge, values).sum()
        return 0.25 * float(covered) + 5.0 * float(outside)

    def _cover_text(self, centre: Array, half: Array) -> None:
        (x0, y0), (x1, y1) = self._text_cells(centre, half)
        self.grid[max(y0, 0) : max(y1, 0), max(x0, 0) : max(x1, 0)] = _NAME

    def _text_cells(self, centre: Array, half: Array) -> tuple[tuple[int, int], tuple[int, int]]:
        """First and last cell of a text, as (column, row)."""
        low = np.floor((centre - half - self.origin) / _CELL).astype(int)
        high = np.ceil((centre + half - self.origin) / _CELL).astype(int)
        return (int(low[0]), int(low[1])), (int(high[0]), int(high[1]))


def _points_along(outline: Array) -> Array:
    """Points (n, 2) on the sides of an outline (m, 2), half a unit apart at most."""
    sides = np.roll(outline, -1, axis=0) - outline
    counts = 2 + (np.linalg.norm(sides, axis=1) / 0.5).astype(int)
    starts = np.cumsum(counts) - counts
    numbers = np.repeat(np.arange(len(counts)), counts)
    shares = (np.arange(counts.sum()) - starts[numbers]) / (counts[numbers] - 1)
    return np.asarray(outline[numbers] + shares[:, None] * sides[numbers])
