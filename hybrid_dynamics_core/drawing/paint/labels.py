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
        on_square = way / np.abs(way).max()
        room = self.clear + distance + self.half
        return np.asarray(self.anchor + room * on_square)

    def distance(self, centre: Array, point: Array) -> float:
        """Distance of a text with a given centre from a point (2,) [px]."""
        between = np.abs(centre - point)
        outside = np.maximum(between - self.half, 0.0)
        return float(np.linalg.norm(outside))

    def leader(self, centre: Array) -> Array:
        """(2, 2) ends of a leader from the symbol to a text with a given centre [px]."""
        to_centre = centre - self.anchor
        way = to_centre / np.linalg.norm(to_centre)
        sides = self.half / np.maximum(np.abs(way), 1e-9)
        reach = float(np.min(sides))
        start = self.anchor + 0.6 * self.clear * way
        end = centre - reach * way
        return np.array([start, end])


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
        size = np.array([box.height, box.width])
        cells = np.ceil(size / _CELL).astype(int)
        self.grid = np.zeros(tuple(np.maximum(cells, 1)))
        for outline, weight in covered:
            self._cover(self._cells(outline), weight)

    def place(self, labels: Sequence[Label]) -> None:
        """Place labels in order; pass the important ones first."""
        if not labels:
            return
        anchors = self.axes.transData.transform([label.at for label in labels])
        for k, label in enumerate(labels):
            others = np.delete(anchors, k, axis=0)
            self._place(label, others)

    def _cells(self, points: Array) -> Array:
        pixels = self.axes.transData.transform(points)
        return np.asarray((pixels - self.origin) / _CELL)

    def _cover(self, outline: Array, weight: float) -> None:
        """Mark the cells on an outline (m, 2) [cells] as covered."""
        if len(outline) > 2:
            self._cover_inside(outline, weight)
        cells = np.floor(_points_along(outline)).astype(np.int64)
        within = cells[self._is_on_grid(cells)]
        columns, rows = within.T
        before = self.grid[rows, columns]
        self.grid[rows, columns] = np.maximum(before, _EDGE)

    def _cover_inside(self, outline: Array, weight: float) -> None:
        low = np.floor(outline.min(axis=0)).astype(int)
        low = np.maximum(low, 0)
        high = np.ceil(outline.max(axis=0)).astype(int)
        high = np.maximum(high, low)
        cells = self.grid[low[1] : high[1], low[0] : high[0]]
        rows, columns = np.indices(cells.shape)
        corners = np.stack([columns.ravel(), rows.ravel()], axis=1)
        centres = corners + 0.5 + low
        inside = Path(outline).contains_points(centres)
        inside = inside.reshape(cells.shape)
        cells[inside] = np.maximum(cells[inside], weight)

    def _place(self, label: Label, others: Array) -> None:
        """Place one label nearer to its point than to other points (k, 2) [px]."""
        point = (float(label.at[0]), float(label.at[1]))
        text = self.axes.annotate(
            label.text,
            point,
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
        offset = (centre - box.anchor) / self.point
        x, y = offset.tolist()
        text.set_position((x, y))
        if needs_leader:
            self._draw_leader(label, box.leader(centre))
        self._cover_text(centre, box.half)

    def _box_of(self, label: Label, text: Annotation) -> TextBox:
        extent = text.get_window_extent()
        has_ground = "bbox" in label.style
        pad = _PILL if has_ground else _AIR
        edge = _UNDER if has_ground else _EDGE
        size = np.array([extent.width, extent.height])
        half = 0.5 * size + pad * self.point
        transform = self.axes.transData.transform
        anchor = transform(label.at)
        rim = transform(label.at + np.array([label.clear, 0.0]))
        clear = float(np.linalg.norm(rim - anchor))
        return TextBox(anchor, half, clear, edge)

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
                away = _NEAR * distance + _FAR * distance**2
                above = _ABOVE * np.sin(direction)
                cost = self._cost(box, centre) + away - above
                if cost >= least:
                    continue
                crossed = self._crossed(box, centre) - symbol
                is_parted = crossed > _BODY
                astray = self._astray(box, centre, others)
                cost += _CROSSED * crossed
                cost += _PARTED * is_parted
                cost += _ASTRAY * astray
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
        cells = self._cells_on(box.leader(centre))
        values = self.grid[cells]
        is_edge = values == _EDGE
        begins = np.diff(is_edge.astype(int), prepend=0) > 0
        areas = values[~is_edge].sum()
        outlines = _EDGE * begins.sum()
        return float(areas + outlines)

    def _draw_leader(self, label: Label, ends: Array) -> None:
        self.grid[self._cells_on(ends)] = _LINE
        to_data = self.axes.transData.inverted()
        x, y = to_data.transform(ends).T
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
        outside = max(0, -x0) + max(0, x1 - columns)
        outside += max(0, -y0) + max(0, y1 - rows)
        values = self._grid_under(centre, box.half)
        covered = np.where(values == _EDGE, box.edge, values).sum()
        return 0.25 * float(covered) + 5.0 * float(outside)

    def _cover_text(self, centre: Array, half: Array) -> None:
        self._grid_under(centre, half)[...] = _NAME

    def _grid_under(self, centre: Array, half: Array) -> Array:
        """View of the cells under a text."""
        (x0, y0), (x1, y1) = self._text_cells(centre, half)
        rows = slice(max(y0, 0), max(y1, 0))
        columns = slice(max(x0, 0), max(x1, 0))
        return np.asarray(self.grid[rows, columns])

    def _text_cells(self, centre: Array, half: Array) -> tuple[tuple[int, int], tuple[int, int]]:
        """First and last cell of a text, as (column, row)."""
        middle = centre - self.origin
        low = np.floor((middle - half) / _CELL).astype(int)
        high = np.ceil((middle + half) / _CELL).astype(int)
        first = (int(low[0]), int(low[1]))
        last = (int(high[0]), int(high[1]))
        return first, last


def _points_along(outline: Array) -> Array:
    """Points (n, 2) on the sides of an outline (m, 2), half a unit apart at most."""
    sides = np.roll(outline, -1, axis=0) - outline
    lengths = np.linalg.norm(sides, axis=1)
    counts = 2 + (lengths / 0.5).astype(int)
    starts = np.cumsum(counts) - counts
    numbers = np.repeat(np.arange(len(counts)), counts)
    steps = np.arange(counts.sum()) - starts[numbers]
    shares = steps / (counts[numbers] - 1)
    along = shares[:, None] * sides[numbers]
    return np.asarray(outline[numbers] + along)
