"""Painting of parts and lines as Matplotlib artists."""

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
from ...scene.part_style import BALL, WHITE, PartStyle, shaded, style_of
from ...scene.parts import Part
from ...scene.scene import Scene
from ...scene.style import PURPLE, QUIET, RED, SHADOW, mix
from ...scene.symbols import LineMark
from .labels import Label

_CAPPED = ("hinge", "barrel", "block", "collar", "pin", "weld", "rod")
_BROAD = ("plate", "base")  # roles that names may cover
_LINES = {"axis": (QUIET, (0, (7, 2, 1.2, 2)), 0.7), "carrier": (SHADOW, (0, (1, 2.2)), 1.2)}
_ARROWS = {
    "turn": (RED, 1.8),
    "travel": (RED, 1.8),
    "triad": (PURPLE, 1.5),
    "base axes": (QUIET, 1.0),
}
_SHEER = 0.2  # opacity of transparent plates
_HEAD = np.array([1.35, 0.55])  # length and half width of an arrow's head, in radii of a joint
_SMALLER = 0.75  # scale of the arrow head of a base axis
_HALVES = 0.45  # largest share of a double arrow for each head
_SHORT = 1.6  # [radii of a joint] a shorter projected axis counts as along the view
_FACING = 0.999  # cosine to the viewer's direction above which a cap is the outline

Colour = str | tuple[float, float, float, float]


class Painter:
    """Paints a scene.

    Args:
        axes: to be painted on.
        scene: to be painted.
        sheer: whether plates and base are transparent.

    Attributes:
        covered: polygons (m, 2) that were painted, each with a weight, for the labels.
        letters: the names of axes.
    """

    def __init__(self, axes: Axes, scene: Scene, *, sheer: bool = False) -> None:
        self.axes = axes
        self.scene = scene
        self.projection = scene.projection
        self.covered: list[tuple[Array, float]] = []
        self.letters: list[Label] = []
        self._sheer = sheer
        self._artists: Counter[str] = Counter()
        self._order = 2.0
        joints = scene.skeleton.joints
        self._active = {f"joint:{joint.name}" for joint in joints if joint.active}
        self._idle = {f"joint:{joint.name}" for joint in joints if joint.idle}

    def paint(self) -> None:
        """Paint the whole scene from back to front."""
        for line in self.scene.lines:
            if line.role in ("axis", "carrier", "dot"):
                self._line(line)
        for part in from_back(self.scene):
            self._part(part)
        for line in self.scene.lines:
            if line.role in _ARROWS:
                self.arrow(line)

    # -- parts

    def _part(self, part: Part) -> None:
        is_active, is_idle = part.owner in self._active, part.owner in self._idle
        style = style_of(part, self.scene.colours, is_active, is_idle)
        face = shaded(style.face, part, self.projection)
        style = style._replace(face=face)
        outline = part.outline(self.projection)
        self._body(part, outline, style)
        self.covered.append((outline, 0.02 if part.role in _BROAD else 1.0))
        if part.role == "ball":
            light = _shrunk(outline, 0.3, 0.28)
            self._add(f"{part.owner}.light", light, mix(face, WHITE, 0.75), "none")
        if part.role in _CAPPED:
            self._cap(part, style)

    def _body(self, part: Part, outline: Array, style: PartStyle) -> None:
        face: Colour = style.face
        if self._sheer and part.role in _BROAD:
            face = to_rgba(style.face, _SHEER)
        hatch = "//////" if part.role == "base" else None
        self._add(part.owner, outline, face, style.edge, style.width, hatch)

    def _cap(self, part: Part, style: PartStyle) -> None:
        """Paint the visible end of a part, and the dot of a joint."""
        cap = part.cap(self.projection)
        if cap is None:
            return
        owner = part.owner
        if part.axis is not None and abs(part.axis @ self.projection.toward) < _FACING:
            face = mix(style.face, WHITE, 0.35)
            self._add(f"{owner}.cap", cap, face, style.edge, 0.8 * style.width)
        if part.role == "pin":
            self._add(f"{owner}.dot", _shrunk(cap, 0.34, 0.0), style.edge, "none")
        elif part.role == "hinge" and owner in self._active:
            self._add(f"{owner}.dot", _shrunk(cap, 0.34, 0.0), WHITE, "none")

    def _add(
        self,
        owner: str,
        outline: Array,
        face: Colour,
        edge: str,
        width: float = 0.0,
        hatch: str | None = None,
    ) -> None:
        patch = Polygon(
            outline,
            closed=True,
            facecolor=face,
            edgecolor=edge,
            linewidth=width,
            hatch=hatch,
        )
        patch.set_joinstyle("round")
        self._register(patch, owner)
        self.axes.add_patch(patch)

    # -- lines

    def _line(self, line: LineMark) -> None:
        flat = self.projection.project(line.points)
        if line.role == "dot":
            (artist,) = self.axes.plot(*flat.T, "o", color=BALL, markersize=2.0)
        else:
            colour, style, width = _LINES[line.role]
            (artist,) = self.axes.plot(
                *flat.T,
                color=colour,
                linestyle=style,
                linewidth=width,
            )
            self.covered.append((flat, 0.0))
        self._register(artist, line.owner)

    def arrow(self, line: LineMark) -> None:
        """Paint an arrow along a line; a travel in both directions has a head at each end."""
        flat = self.projection.project(line.points)
        unit = self.scene.joint_radius
        colour, width = _ARROWS[line.role]
        has_letter = line.role in ("triad", "base axes")
        size = _SMALLER * unit if line.role == "base axes" else unit
        length = float(np.linalg.norm(flat[1] - flat[0]))
        if has_letter and length < _SHORT * unit:
            self._end_on(line, flat[0], colour)
            return
        if line.role == "travel":
            if length < _SHORT * unit:
                self._end_on(line, flat.mean(axis=0), colour)
                return
            size = min(size, _HALVES * length / _HEAD[0])  # room for a head at each end
        shaft, head = _headed(flat, size)
        heads = [head]
        if line.role == "travel":
            shaft, head = _headed(shaft[::-1], size)
            heads.append(head)
        (artist,) = self.axes.plot(
            *shaft.T,
            color=colour,
            linewidth=width,
            solid_capstyle="butt",
        )
        self._register(artist, line.owner)
        for head in heads:
            self._add(f"{line.owner}.head", head, colour, colour, 0.4)
            self.covered.append((head, 1.0))
        self.covered.append((flat, 1.0))
        if has_letter:
            self._add_letter(line.owner, flat, colour)

    def _add_letter(self, owner: str, flat: Array, colour: str) -> None:
        along = flat[1] - flat[0]
        at = flat[1] + 1.5 * self.scene.joint_radius * along / np.linalg.norm(along)
        letter = Label(
            text=owner[-1],
            at=at,
            clear=0.0,
            style={"color": colour, "fontsize": 7.5},
            gid=f"letter:{owner}",
            colour=colour,
            inside=True,
        )
        self.letters.append(letter)

    def _end_on(self, line: LineMark, at: Array, colour: str) -> None:
        """Paint an axis along the view: a circle with a dot (towards the viewer) or a cross (away).

        A travel in both directions has a dot.
        """
        along = line.points[1] - line.points[0]
        is_toward = float(along @ self.projection.toward) > 0.0
        marker = "." if is_toward or line.role == "travel" else "x"
        for symbol, size, face in (("o", 5.0, WHITE), (marker, 3.0, colour)):
            (artist,) = self.axes.plot(
                *at,
                symbol,
                markersize=size,
                color=colour,
                markerfacecolor=face,
            )
            self._register(artist, line.owner)

    def _register(self, artist: Artist, owner: str) -> None:
        """Number the artists of one owner, and stack them in the order of painting."""
        self._artists[owner] += 1
        count = self._artists[owner]
        artist.set_gid(owner if count == 1 else f"{owner}.{count}")
        artist.set_zorder(self._order)
        artist.set_clip_on(False)
        self._order += 0.001


def _headed(line: Array, unit: float) -> tuple[Array, Array]:
    """A line shortened for its arrow head, and the head.

    Args:
        line: (k, 2).
        unit: radius of a joint.

    Returns:
        The line (m, 2), and the head (3, 2) along the line's direction at its end.
    """
    length, half = _HEAD * unit
    tip = line[-1]
    base = _before_head(line, length)
    way = (tip - base) / max(float(np.linalg.norm(tip - base)), 1e-12)
    across = half * np.array([-way[1], way[0]])
    head = np.array([tip, base + across, base - across])
    outside = line[np.linalg.norm(line - tip, axis=1) > length]
    shaft = np.vstack([outside, base + 0.3 * (tip - base)])
    return shaft, head


def _before_head(line: Array, length: float) -> Array:
    """(2,) the last point of a line at more than a given distance from its end."""
    fine = np.concatenate([np.linspace(a, b, 25) for a, b in pairwise(line)])
    before = np.flatnonzero(np.linalg.norm(fine - line[-1], axis=1) > length)
    if not len(before):
        return np.asarray(fine[0])
    return np.asarray(fine[int(before[-1])])


def _shrunk(outline: Array, share: float, shift: float) -> Array:
    """An outline scaled about its middle, and shifted up and left by a share of its size."""
    middle = 0.5 * (outline.min(axis=0) + outline.max(axis=0))
    half = 0.5 * np.ptp(outline, axis=0)
    moved = middle + share * (outline - middle)
    return np.asarray(moved + shift * half * (-1.0, 1.0))
