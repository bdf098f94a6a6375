"""Which names a picture shows, and how they look."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from ...ground.arrays import Array
from ...scene.scene import Scene
from ...scene.style import INK, PURPLE, QUIET, RED, deep, mix
from ..options import Names
from .backdrop import ground_outlines
from .labels import Label

_PILL: Final = mix(RED, INK, 0.12)
_BOX: Final = {
    "boxstyle": "round,pad=0.28,rounding_size=0.6",
    "facecolor": _PILL,
    "edgecolor": "none",
}
_DRIVEN: Final[dict[str, Any]] = {
    "color": "white",
    "fontsize": 8.5,
    "fontweight": "bold",
    "bbox": _BOX,
}
_QUIET: Final[dict[str, Any]] = {"color": QUIET, "fontsize": 7.5}


def name_labels(scene: Scene, names: Names) -> list[Label]:
    """Active joints, then the end effector, then what else is asked for: passive joints, links."""
    if names == "none":
        return []
    unit, labels = scene.unit, _active(scene)
    tip = scene.skeleton.tip
    own = {**_QUIET, "color": PURPLE}
    labels.append(
        Label(tip.name, scene.projection.project(tip.point), unit, own, f"name:{tip.name}", PURPLE)
    )
    if names in ("joints", "all"):
        labels += _passive(scene)
    return labels + (_links(scene) if names == "all" else [])


def _active(scene: Scene) -> list[Label]:
    """A label beside the arrow of every active joint."""
    labels = []
    for stroke in scene.lines:
        if stroke.role in ("turn", "travel"):
            flat, name = (
                scene.projection.project(stroke.points),
                stroke.owner.removeprefix("drive:"),
            )
            middle = 0.5 * (flat.min(axis=0) + flat.max(axis=0))
            clear = (
                1.3 * scene.unit
                if stroke.role == "travel"
                else 0.5 * float(np.ptp(flat, axis=0).max())
            )
            labels.append(Label(name, middle, clear, _DRIVEN, f"name:{name}", _PILL))
    return labels


def _passive(scene: Scene) -> list[Label]:
    labels = []
    for group in scene.groups:
        passive = [joint.name for joint in group.joints if not joint.active]
        if passive:
            at = scene.projection.project(group.last.point)
            labels.append(
                Label(
                    ", ".join(passive), at, 1.4 * scene.unit, _QUIET, f"name:{group.names}", QUIET
                )
            )
    return labels


def _links(scene: Scene) -> list[Label]:
    labels, named = _base(scene), {scene.skeleton.base}
    for part in scene.parts:
        link = part.owner.removeprefix("link:")
        if part.owner.startswith("link:") and link not in named:
            named.add(link)
            labels.append(
                _link(
                    scene,
                    link,
                    scene.projection.project(part.points.mean(axis=0)),
                    part.role == "plate",
                )
            )
    return labels


def _base(scene: Scene) -> list[Label]:
    """The base at the first ground that holds it, or on its plate; none where neither is painted."""
    base = scene.skeleton.base
    grounds = [outline.mean(axis=0) for outline in ground_outlines(scene)]
    plates = [
        scene.projection.project(part.points.mean(axis=0))
        for part in scene.parts
        if part.role == "base"
    ]
    return [_link(scene, base, at, bool(plates)) for at in (grounds + plates)[:1]]


def _link(scene: Scene, link: str, at: Array, inside: bool) -> Label:
    style = {"color": deep(scene.colours.get(link, INK)), "fontsize": 7.5, "fontstyle": "italic"}
    return Label(
        scene.skeleton.names_on(link), at, scene.unit, style, f"name:link:{link}", QUIET, inside
    )
