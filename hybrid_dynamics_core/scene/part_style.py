"""Colours and lines of parts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, NamedTuple

import numpy as np

from .parts import Part, PartRole
from .projection import Projection
from .style import GRID, INK, QUIET, RED, SHADOW, STEEL, deep, mix, pale

WHITE: Final = "#ffffff"
IDLE: Final = SHADOW
BALL: Final = "#8a97a5"
_GROUND: Final = "#eef1f4"
_BODIES: Final = ("plate", "bar", "rod", "barrel")  # in the colour of their link
_SHADE: Final = 0.10  # share of ink in the colour of a plate seen edge-on


class PartStyle(NamedTuple):
    """Colours of the face and the edge of a part, and the width of its line [pt]."""

    face: str
    edge: str
    width: float


def style_of(part: Part, colours: Mapping[str, str], active: bool, idle: bool = False) -> PartStyle:
    """Colours and line width of a part.

    Args:
        part: to be painted.
        colours: colours of links and closures.
        active: whether it belongs to a driven joint.
        idle: whether it belongs to an independent joint without a drive.

    Returns:
        Colours and line width.
    """
    if part.role in _BODIES:
        colour = colours.get(part.links[0], BALL)
        return _body_style(part.role, colour)
    colour = colours.get(part.owner, BALL)
    driven = WHITE
    if active:
        driven = RED
    elif idle:
        driven = IDLE
    symbols = {
        "block": PartStyle(RED if active else STEEL, INK, 1.1),
        "rail": PartStyle(GRID, QUIET, 0.8),
        "hinge": PartStyle(driven, INK, 1.1),
        "collar": PartStyle(driven, INK, 1.0),
        "ball": PartStyle(mix(colour, INK, 0.12), deep(colour), 0.9),
        "cross": PartStyle(BALL, INK, 0.8),
        "pin": PartStyle(WHITE, deep(colour), 1.9),
        "weld": PartStyle(deep(colour), deep(colour), 1.0),
        "base": PartStyle(_GROUND, SHADOW, 0.9),
    }
    return symbols[part.role]


def _body_style(role: PartRole, colour: str) -> PartStyle:
    """The style of a link's body; the arm is in the colour of steel."""
    body, edge = pale(colour), deep(colour)
    barrel = mix(colour, WHITE, 0.35)
    if colour == INK:
        body, edge = STEEL, INK
        barrel = mix(STEEL, INK, 0.35)
    if role == "rod":
        return PartStyle(mix(body, WHITE, 0.6), edge, 1.0)
    if role == "barrel":
        return PartStyle(barrel, edge, 1.1)
    return PartStyle(body, edge, 1.1)


def shaded(face: str, part: Part, projection: Projection) -> str:
    """The colour of a face, darker if a plate is turned away from the viewer."""
    if projection.planar or part.role != "plate":
        return face
    centred = part.points - part.points.mean(axis=0)
    _, _, axes = np.linalg.svd(centred)
    facing = abs(float(axes[-1] @ projection.toward))
    return mix(face, INK, _SHADE * (1.0 - facing))
