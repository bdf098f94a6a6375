"""From marks to artists of Matplotlib."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.patches import Polygon

from ...ground.arrays import Array
from ...scene.depth import from_back
from ...scene.part_style import BALL, WHITE, shaded, style_of
from ...scene.parts import Part
from ...scene.scene import Scene
from ...scene.style import PURPLE, QUIET, RED, SHADOW, mix
from ...scene.symbols import LineMark
from .labels import Label

_CAPPED = ("hinge", "barrel", "block", "collar", "pin", "weld", "rod")
_LINES = {"axis": (QUIET, (0, (7, 2, 1.2, 2)), 0.7), "carrier": (SHADOW, (0, (1, 2.2)), 1.2)}
_ARROWS = {
    "turn": (RED, 1.8),
    "travel": (RED, 1.8),
    "triad": (PURPLE, 1.5),
    "base axes": (QUIET, 1.0),
}
_SHEER = 0.2  # how much of a sheer plate is seen
_HEAD = np.array([1.35, 0.55])  # length and half width of an arrow's head, in radii of a joint


class Painter:
    """Paints a scene; `sheer`: plates and base let through what is behind them.

    For the labels `covered` collects what was painted, (m, 2) polygons with a weight, and `letters`
    the names of axes.
    """

    def __init__(self, axes: Axes, scene: Scene, *, sheer: bool = False) -> None:
        self.axes, self.scene, self.projection = axes, scene, scene.projection
        self._sheer = sheer
        self.covered: list[tuple[Array, float]] = []
        self.letters: list[Label] = []
        self._names: Counter[str] = Counter()
        self._order = 2.0
        self._active = {f"joint:{joint.name}" for joint in scene.skeleton.joints if joint.active}

    def paint(self) -> None:
        """Everything, from back to front."""
        for stroke in self.scene.lines:
            if stroke.role in ("axis", "carrier", "dot"):
                self._line(stroke)
        for part in from_back(self.scene):
            self._part(part)
        for stroke in self.scene.lines:
            if stroke.role in _ARROWS:
                self.arrow(stroke)

    # -- parts

    def _part(self, part: Part) -> None:
        active = part.owner in self._active
        face, edge, width = style_of(part, self.scene.colours, active)
        face = shaded(face, part, self.projection)
        outline, cap = part.outline(self.projection), part.cap(self.projection)
        broad = part.role in ("plate", "base")
        body = to_rgba(face, _SHEER) if broad and self._sheer else face
        self._add(part.owner, outline, body, edge, width, "//////" if part.role == "base" else None)
        self.covered.append((outline, 0.02 if broad else 1.0))
        if part.role == "ball":
            self._add(
                f"{part.owner}.light", _shrunk(outline, 0.3, 0.28), mix(face, WHITE, 0.75), "none"
            )
        if cap is None or part.role not in _CAPPED:
            return
        if (
            part.axis is not None and abs(part.axis @ self.projection.toward) < 0.999
        ):  # otherwise it is the outline
            self._add(f"{part.owner}.cap", cap, mix(face, WHITE, 0.35), edge, 0.8 * width)
        if part.role == "pin" or (part.role == "hinge" and active):
            self._add(
                f"{part.owner}.dot",
                _shrunk(cap, 0.34, 0.0),
                edge if part.role == "pin" else WHITE,
                "none",
            )

    def _add(
        self,
        owner: str,
        outline: Array,
        face: str | tuple[float, float, float, float],
        edge: str,
        width: float = 0.0,
        hatch: str | None = None,
    ) -> None:
        patch = Polygon(
            outline, closed=True, facecolor=face, edgecolor=edge, linewidth=width, hatch=hatch
        )
        patch.set_joinstyle("round")
        self._keep(patch, owner)
        self.axes.add_patch(patch)

    # -- strokes

    def _line(self, stroke: LineMark) -> None:
        flat = self.projection.project(stroke.points)
        if stroke.role == "dot":
            (line,) = self.axes.plot(*flat.T, "o", color=BALL, markersize=2.0)
        else:
            colour, style, width = _LINES[stroke.role]
            (line,) = self.axes.plot(*flat.T, color=colour, linestyle=style, linewidth=width)
            self.covered.append((flat, 0.0))
        self._keep(line, stroke.owner)

    def arrow(self, stroke: LineMark) -> None:
        """An arrow along a line, with a second head at its start for what travels both ways."""
        flat, unit = self.projection.project(stroke.points), self.scene.unit
        named = stroke.role in ("triad", "base axes")
        if named and np.linalg.norm(flat[1] - flat[0]) < 1.6 * unit:
            self._end_on(stroke, flat[0], _ARROWS[stroke.role][0])
            return
        colour, width = _ARROWS[stroke.role]
        size = unit if stroke.role != "base axes" else 0.75 * unit
        line, head = _headed(flat, size)
        heads = [head]
        if stroke.role == "travel":
            line, head = _headed(line[::-1], size)
            heads.append(head)
        (shaft,) = self.axes.plot(*line.T, color=colour, linewidth=width, solid_capstyle="butt")
        self._keep(shaft, stroke.owner)
        for head in heads:
            self._add(f"{stroke.owner}.head", head, colour, colour, 0.4)
            self.covered.append((head, 1.0))
        self.covered.append((flat, 1.0))
        if named:
            self._name_axis(stroke.owner, flat, colour)

    def _name_axis(self, owner: str, flat: Array, colour: str) -> None:
        at = flat[1] + 1.5 * self.scene.unit * (flat[1] - flat[0]) / np.linalg.norm(
            flat[1] - flat[0]
        )
        style = {"color": colour, "fontsize": 7.5}
        self.letters.append(
            Label(owner[-1], at, 0.0, style, f"letter:{owner}", colour, inside=True)
        )

    def _end_on(self, stroke: LineMark, at: Array, colour: str) -> None:
        """An axis along the view: a circle with a dot (toward the viewer) or a cross (away)."""
        toward = float((stroke.points[1] - stroke.points[0]) @ self.projection.toward) > 0.0
        for marker, size, face in (("o", 5.0, WHITE), ("." if toward else "x", 3.0, colour)):
            (line,) = self.axes.plot(
                *at, marker, markersize=size, color=colour, markerfacecolor=face
            )
            self._keep(line, stroke.owner)

    def _keep(self, artist: Artist, owner: str) -> None:
        """Number artists of one owner, and stack them in the order in which they come."""
        self._names[owner] += 1
        artist.set_gid(owner if self._names[owner] == 1 else f"{owner}.{self._names[owner]}")
        artist.set_zorder(self._order)
        artist.set_clip_on(False)
        self._order += 0.001


def _headed(line: Array, unit: float) -> tuple[Array, Array]:
    """A line (k, 2) cut short for its head, and the head (3, 2) at its end, turned as the line is there."""
    length, half = _HEAD * unit
    tip = line[-1]
    fine = np.concatenate([np.linspace(a, b, 25) for a, b in pairwise(line)])
    before = np.flatnonzero(np.linalg.norm(fine - tip, axis=1) > length)
    last = int(before[-1]) if len(before) else 0
    base = fine[last]
    way = (tip - base) / max(float(np.linalg.norm(tip - base)), 1e-12)
    across = half * np.array([-way[1], way[0]])
    kept = np.vstack([line[np.linalg.norm(line - tip, axis=1) > length], base + 0.3 * (tip - base)])
    return kept, np.array([tip, base + across, base - across])


def _shrunk(outline: Array, share: float, shift: float) -> Array:
    """An outline made smaller about its middle, moved up and to the left by a share of its size."""
    middle = 0.5 * (outline.min(axis=0) + outline.max(axis=0))
    half = 0.5 * np.ptp(outline, axis=0)
    return np.asarray(middle + share * (outline - middle) + shift * half * (-1.0, 1.0))
