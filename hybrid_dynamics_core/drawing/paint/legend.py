"""The legend of a picture: its loops with colours and types, and its symbols."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.legend_handler import HandlerTuple
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from ...description.model import Closure, RobotDescription
from ...scene.part_style import BALL, IDLE
from ...scene.parts import PartRole
from ...scene.projection import ALIGNED
from ...scene.scene import Scene
from ...scene.style import INK, PURPLE, RED, SHADOW, STEEL, deep, mix, pale

KINDS: Final = {"planar": "pin", "point": "spherical joint", "axis": "hinge", "frame": "weld"}
_VISIBLE: Final = 2.0  # [radii of a joint] shorter coordinates of a platform are hidden
Entry = tuple[Any, str]  # a handle of Matplotlib, and what it means


def loop_type(description: RobotDescription, closure: Closure) -> str:
    """Text for a loop: its type letter, or the joint that closes it."""
    loop = description.loops.get(closure.name)
    kind = f"Type {loop.type}" if loop else KINDS[closure.kind]
    if closure.assembly == "parallelogram":
        return f"{kind}, parallelogram"
    return kind


def add_legends(figure: Figure, scenes: Sequence[Scene], description: RobotDescription) -> float:
    """Draw the legend of one robot's scenes at the bottom of a figure; returns its height [in]."""
    height = 0.05
    for entries in (_symbols(scenes), _loops(scenes[0], description)):
        if entries:
            legend = _rows(figure, entries, height / figure.get_figheight())
            height += float(legend.get_window_extent().height) / figure.dpi
    return height


def _rows(figure: Figure, entries: Sequence[Entry], bottom: float) -> Legend:
    """A legend in as few rows as fit."""
    count, rows = len(entries), 1
    widest = 0.98 * figure.bbox.width
    legend = _legend(figure, entries, bottom, count)
    while rows < count and legend.get_window_extent().width >= widest:
        legend.remove()
        rows += 1
        legend = _legend(figure, entries, bottom, math.ceil(count / rows))
    return legend


def _legend(
    figure: Figure,
    entries: Sequence[Entry],
    bottom: float,
    columns: int,
) -> Legend:
    handles, texts = zip(*entries, strict=True)
    return figure.legend(
        handles,
        texts,
        loc="lower left",
        bbox_to_anchor=(0.012, bottom),
        ncols=columns,
        frameon=False,
        fontsize=8,
        handler_map={tuple: HandlerTuple(ndivide=1)},
        borderpad=0.25,
        borderaxespad=0.0,
        columnspacing=1.4,
        handletextpad=0.6,
        handlelength=1.7,
    )


def _loops(scene: Scene, description: RobotDescription) -> list[Entry]:
    entries = []
    for closure in description.closures:
        colour = scene.colours[f"closure:{closure.name}"]
        patch = Patch(
            facecolor=pale(colour),
            edgecolor=deep(colour),
            linewidth=1.1,
        )
        entries.append((patch, f"{closure.name}: {loop_type(description, closure)}"))
    return entries


# -- symbols


def _symbols(scenes: Sequence[Scene]) -> list[Entry]:
    """Every symbol that occurs, once."""
    scene = scenes[0]  # all have the same joints
    kinds = {group.kind for group in scene.groups}
    roles = {part.role for part in scene.parts}
    ball, _ = _closing(scene, "ball")
    pin, pin_loop = _closing(scene, "pin")
    weld, weld_loop = _closing(scene, "weld")
    symbols = [
        (_disc(RED, INK), "active joint", _has_active(scene)),
        (_disc(IDLE, INK), "idle joint", _has_idle(scene)),
        (_disc("white", INK), "passive joint", _has_passive(scene)),
        (_cross(), "universal joint", "universal" in kinds),
        (_sphere(ball), "spherical joint", "ball" in roles),
        (_pin(deep(pin)), f"pin that closes {pin_loop} loop", "pin" in roles),
        (_disc(deep(weld), deep(weld)), f"weld that closes {weld_loop} loop", "weld" in roles),
        (_cylinder(), "cylinder", "barrel" in roles),
        (_carrier(), "coordinates of a platform", _shows_carrier(scenes)),
        (Line2D([], [], color=PURPLE, linewidth=1.6), "end-effector frame", True),
    ]
    return [(handle, text) for handle, text, occurs in symbols if occurs]


def _has_active(scene: Scene) -> bool:
    return any(joint.active for joint in scene.skeleton.joints)


def _has_passive(scene: Scene) -> bool:
    """Whether a passive joint is drawn by itself."""
    single = [group for group in scene.groups if group.kind in ("revolute", "prismatic")]
    return not all(group.first.active or group.first.idle for group in single)


def _has_idle(scene: Scene) -> bool:
    """Whether an idle joint is drawn by itself."""
    single = [group for group in scene.groups if group.kind in ("revolute", "prismatic")]
    return any(group.first.idle for group in single)


def _shows_carrier(scenes: Sequence[Scene]) -> bool:
    """Whether coordinates of a platform are long enough to be visible in a scene."""
    least = _VISIBLE * scenes[0].joint_radius
    for scene in scenes:
        for group in scene.groups:
            length = np.linalg.norm(group.last.point - group.first.start)
            if group.kind == "carrier" and length > least:
                return True
    return False


def _closing(scene: Scene, role: PartRole) -> tuple[str, str]:
    """Colour of a closure symbol, from the first loop of this kind, and the article of its text."""
    owners = [part.owner for part in scene.parts if part.role == role]
    colours = [scene.colours[owner] for owner in owners if owner in scene.colours]
    article = "the" if len(colours) == 1 else "each"
    return (colours[0] if colours else BALL), article


def _disc(
    face: str,
    edge: str,
    size: float = 8.0,
    width: float = 1.1,
) -> Line2D:
    return Line2D(
        [],
        [],
        marker="o",
        linestyle="",
        markersize=size,
        color=edge,
        markerfacecolor=face,
        mew=width,
    )


def _dot(colour: str) -> Line2D:
    return Line2D(
        [],
        [],
        marker=".",
        linestyle="",
        color=colour,
        markersize=6,
        mew=0,
    )


def _sphere(colour: str) -> tuple[Line2D, Line2D]:
    return _disc(colour, deep(colour), 8.5), _dot(pale(colour))


def _pin(colour: str) -> tuple[Line2D, Line2D]:
    return _disc("white", colour, 8.0, 2.0), _dot(colour)


def _cross() -> Line2D:
    return Line2D(
        [],
        [],
        marker="P",
        linestyle="",
        markersize=8,
        color=INK,
        markerfacecolor="white",
        mew=1.0,
    )


def _cylinder() -> tuple[Line2D, Line2D]:
    barrel = mix(STEEL, INK, 0.35)
    return (
        Line2D(
            [],
            [],
            color=barrel,
            linewidth=6.0,
            solid_capstyle="butt",
        ),
        Line2D(
            [],
            [],
            color=INK,
            linewidth=1.2,
            solid_capstyle="butt",
        ),
    )


def _carrier() -> Line2D:
    return Line2D(
        [],
        [],
        color=SHADOW,
        linestyle=(0, (1, 2.2)),
        linewidth=1.4,
    )


# -- words


def subtitle(scene: Scene) -> str:
    """The subtitle: numbers of joints and loops and, of a planar mechanism, the plane."""
    active = len([joint for joint in scene.skeleton.joints if joint.active])
    idle = len([joint for joint in scene.skeleton.joints if joint.idle])
    passive = len(scene.skeleton.joints) - active - idle
    loops = len(scene.skeleton.closures)
    plane = plane_of(scene)
    if plane:
        plane = f"; {plane}"
    counts = [f"{active} active"]
    if idle:
        counts.append(f"{idle} idle")
    if not passive:
        return f"{' and '.join(counts)} {_plural('joint', idle or active)}{plane}"
    return (
        f"{', '.join(counts)} and {passive} passive {_plural('joint', passive)}, {loops}"
        f" {_plural('loop', loops)}{plane}"
    )


def _plural(word: str, count: int) -> str:
    return word if count == 1 else f"{word}s"


def plane_of(scene: Scene) -> str:
    """Text for the plane of a mechanism's motion, or of its drawing; empty for spatial ones."""
    letters = [name.removesuffix(" [m]") for name in scene.projection.names]
    if not scene.projection.planar or max(map(len, letters)) > 1:
        return ""
    verb = "drawn" if _leaves_plane(scene) else "moves"
    return f"{verb} in the {'-'.join(sorted(letters))} plane"


def _leaves_plane(scene: Scene) -> bool:
    """Whether a hinge turns about an axis that is not normal to the picture."""
    toward = scene.projection.toward
    cosines = [abs(float(joint.axis @ toward)) for joint in scene.skeleton.hinges]
    return min(cosines, default=1.0) < 1.0 - ALIGNED
