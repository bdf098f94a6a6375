"""The key to a picture: loops with their colours and types, and the symbols that occur in it."""

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
from ...scene.part_style import BALL
from ...scene.parts import PartRole
from ...scene.projection import ALIGNED
from ...scene.scene import Scene
from ...scene.style import INK, PURPLE, RED, SHADOW, STEEL, deep, mix, pale

KINDS: Final = {"planar": "pin", "point": "spherical joint", "axis": "hinge", "frame": "weld"}
Entry = tuple[Any, str]


def loop_type(description: RobotDescription, closure: Closure) -> str:
    """What a loop is: its type letter, or what closes it."""
    loop = description.loops.get(closure.name)
    kind = f"Type {loop.type}" if loop else KINDS[closure.kind]
    return f"{kind}, parallelogram" if closure.assembly == "parallelogram" else kind


def add_legends(figure: Figure, scenes: Sequence[Scene], description: RobotDescription) -> float:
    """Write the key to one robot's scenes at the bottom of a figure; its height [in]."""
    height = 0.05
    for entries in (_symbols(scenes), _loops(scenes[0], description)):
        if entries:
            legend = _rows(figure, entries, height / figure.get_figheight())
            height += float(legend.get_window_extent().height) / figure.dpi
    return height


def _rows(figure: Figure, entries: Sequence[Entry], bottom: float) -> Legend:
    """A legend in as few rows as fit."""
    handles, texts = zip(*entries, strict=True)
    rows = 1
    while True:
        legend = figure.legend(
            handles, texts, loc="lower left", bbox_to_anchor=(0.012, bottom), ncols=math.ceil(len(entries) / rows),
            frameon=False, fontsize=8, handler_map={tuple: HandlerTuple(ndivide=1)}, borderpad=0.25, borderaxespad=0.0,
            columnspacing=1.4, handletextpad=0.6, handlelength=1.7,
        )  # fmt: skip
        if rows >= len(entries) or legend.get_window_extent().width < 0.98 * figure.bbox.width:
            return legend
        legend.remove()
        rows += 1


def _loops(scene: Scene, description: RobotDescription) -> list[Entry]:
    entries = []
    for closure in description.closures:
        colour = scene.colours[f"closure:{closure.name}"]
        patch = Patch(facecolor=pale(colour), edgecolor=deep(colour), linewidth=1.1)
        entries.append((patch, f"{closure.name}: {loop_type(description, closure)}"))
    return entries


def _disc(face: str, edge: str, size: float = 8.0, width: float = 1.1) -> Line2D:
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
    return Line2D([], [], marker=".", linestyle="", color=colour, markersize=6, mew=0)


def _symbols(scenes: Sequence[Scene]) -> list[Entry]:
    """Every symbol that occurs, once."""
    scene = scenes[0]  # all have the same joints
    kinds = {group.kind for group in scene.groups}
    roles = {part.role for part in scene.parts}
    passive = any(g.kind in ("revolute", "prismatic") and not g.first.active for g in scene.groups)
    carriers = [group for each in scenes for group in each.groups if group.kind == "carrier"]
    seen = any(np.linalg.norm(g.last.point - g.first.start) > 2.0 * scene.unit for g in carriers)
    pin, which = _closing(scene, "pin")
    weld, other = _closing(scene, "weld")
    ball, _ = _closing(scene, "ball")
    cross = Line2D(
        [], [], marker="P", linestyle="", markersize=8, color=INK, markerfacecolor="white", mew=1.0
    )
    tube = (
        Line2D([], [], color=mix(STEEL, INK, 0.35), linewidth=6.0, solid_capstyle="butt"),
        Line2D([], [], color=INK, linewidth=1.2, solid_capstyle="butt"),
    )
    carrier = Line2D([], [], color=SHADOW, linestyle=(0, (1, 2.2)), linewidth=1.4)
    told = [
        (_disc(RED, INK), "active joint", any(j.active for j in scene.skeleton.joints)),
        (_disc("white", INK), "passive joint", passive),
        (cross, "universal joint", "universal" in kinds),
        ((_disc(ball, deep(ball), 8.5), _dot(pale(ball))), "spherical joint", "ball" in roles),
        (
            (_disc("white", deep(pin), 8.0, 2.0), _dot(deep(pin))),
            f"pin that closes {which} loop",
            "pin" in roles,
        ),
        (_disc(deep(weld), deep(weld)), f"weld that closes {other} loop", "weld" in roles),
        (tube, "cylinder", "barrel" in roles),
        (carrier, "coordinates of a platform", seen),
        (Line2D([], [], color=PURPLE, linewidth=1.6), "end-effector frame", True),
    ]
    return [(handle, text) for handle, text, occurs in told if occurs]


def _closing(scene: Scene, role: PartRole) -> tuple[str, str]:
    """The colour of what closes loops in one way, as that of the first loop, and how to speak of these loops."""
    owners = [part.owner for part in scene.parts if part.role == role]
    colours = [scene.colours[owner] for owner in owners if owner in scene.colours]
    return (colours[0] if colours else BALL), ("the" if len(colours) == 1 else "each")


def subtitle(scene: Scene) -> str:
    """One line: how many joints of which kind, how many loops, and of a planar mechanism the plane."""
    active = sum(j.active for j in scene.skeleton.joints)
    passive, loops = len(scene.skeleton.joints) - active, len(scene.skeleton.closures)
    plane = f"; {plane_of(scene)}" if plane_of(scene) else ""
    if not passive:
        return f"{active} active joint{'s' * (active != 1)}{plane}"
    return (
        f"{active} active and {passive} passive joint{'s' * (passive != 1)}, {loops}"
        f" loop{'s' * (loops != 1)}{plane}"
    )


def plane_of(scene: Scene) -> str:
    """The plane in which a mechanism moves, or is drawn where it leaves it too; empty for others."""
    letters = [name.removesuffix(" [m]") for name in scene.projection.names]
    if not scene.projection.planar or any(len(letter) > 1 for letter in letters):
        return ""
    hinges = [joint.axis for joint in scene.skeleton.joints if joint.type == "revolute"]
    leaves = any(abs(float(axis @ scene.projection.toward)) < 1.0 - ALIGNED for axis in hinges)
    return f"{'drawn' if leaves else 'moves'} in the {'-'.join(sorted(letters))} plane"
