"""The names shown in a picture, as labels."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from ...ground.arrays import Array
from ...scene.part_style import IDLE
from ...scene.parts import Part
from ...scene.scene import Scene
from ...scene.style import INK, PURPLE, QUIET, RED, deep, mix
from ...scene.visuals.surfaces import Surface
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
_IDLE: Final[dict[str, Any]] = {
    **_DRIVEN,
    "color": INK,
    "bbox": {**_BOX, "facecolor": IDLE},
}
_SMALL: Final[dict[str, Any]] = {"color": QUIET, "fontsize": 7.5}


def name_labels(scene: Scene, names: Names) -> list[Label]:
    """Labels of active and idle joints and end effector; optionally of passive joints and links."""
    if names == "none":
        return []
    labels = [*_active(scene), *_idle(scene), _tip(scene)]
    if names in ("joints", "all"):
        labels += _passive(scene)
    if names == "all":
        labels += _links(scene)
    return labels


def _active(scene: Scene) -> list[Label]:
    """A label next to the arrow of every active joint."""
    labels = []
    for line in scene.lines:
        if line.role not in ("turn", "travel"):
            continue
        name = line.owner.removeprefix("drive:")
        flat = scene.projection.project(line.points)
        middle = 0.5 * (flat.min(axis=0) + flat.max(axis=0))
        if line.role == "travel":
            clear = 1.3 * scene.joint_radius
        else:
            clear = 0.5 * float(np.ptp(flat, axis=0).max())
        labels.append(Label(name, middle, clear, _DRIVEN, f"name:{name}", _PILL))
    return labels


def _idle(scene: Scene) -> list[Label]:
    """A label next to every idle joint."""
    labels: list[Label] = []
    for group in scene.groups:
        idle = [joint.name for joint in group.joints if joint.idle]
        if idle:
            at = scene.projection.project(group.last.point)
            clear = 1.4 * scene.joint_radius
            name = ", ".join(idle)
            labels.append(Label(name, at, clear, _IDLE, f"name:{name}", QUIET))
    return labels


def _tip(scene: Scene) -> Label:
    tip = scene.skeleton.tip
    at = scene.projection.project(tip.point)
    style = {**_SMALL, "color": PURPLE}
    return Label(tip.name, at, scene.joint_radius, style, f"name:{tip.name}", PURPLE)


def _passive(scene: Scene) -> list[Label]:
    labels = []
    for group in scene.groups:
        passive = [joint.name for joint in group.joints if not joint.active and not joint.idle]
        if passive:
            label = Label(
                text=", ".join(passive),
                at=scene.projection.project(group.last.point),
                clear=1.4 * scene.joint_radius,
                style=_SMALL,
                gid=f"name:{group.names}",
                colour=QUIET,
            )
            labels.append(label)
    return labels


def _links(scene: Scene) -> list[Label]:
    labels = _base(scene)
    named = {scene.skeleton.base, *scene.skeleton.in_rows}
    for part in scene.parts:
        link = part.owner.removeprefix("link:")
        if part.owner.startswith("link:") and link not in named:
            named.add(link)
            labels.append(_link(scene, link, _middle(scene, part), part.role == "plate"))
    for surface in scene.surfaces:
        if surface.link not in named:
            named.add(surface.link)
            labels.append(_link(scene, surface.link, _middle_of(scene, surface), True))
    return labels


def _base(scene: Scene) -> list[Label]:
    """A label of the base at its first ground, its plate or a visual; empty without any."""
    base = scene.skeleton.base
    plates = [_middle(scene, part) for part in scene.parts if part.role == "base"]
    places = [outline.mean(axis=0) for outline in ground_outlines(scene)] + plates
    visuals = [surface for surface in scene.surfaces if surface.link == base]
    places += [_middle_of(scene, surface) for surface in visuals]
    inside = bool(plates or visuals)
    return [_link(scene, base, place, inside) for place in places[:1]]


def _middle(scene: Scene, part: Part) -> Array:
    """(2,) the middle of a part in the picture."""
    return scene.projection.project(part.points.mean(axis=0))


def _middle_of(scene: Scene, surface: Surface) -> Array:
    """(2,) the middle of the box around a surface in the picture."""
    return scene.projection.project(surface.box().mean(axis=0))


def _link(
    scene: Scene,
    link: str,
    at: Array,
    inside: bool,
) -> Label:
    colour = deep(scene.colours.get(link, INK))
    return Label(
        text=scene.skeleton.names_on(link),
        at=at,
        clear=scene.joint_radius,
        style={"color": colour, "fontsize": 7.5, "fontstyle": "italic"},
        gid=f"name:link:{link}",
        colour=QUIET,
        inside=inside,
    )
