"""Colours and lines of parts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np

from .parts import Part
from .style import GRID, INK, QUIET, RED, SHADOW, STEEL, deep, mix, pale
from .view import View

WHITE: Final = "#ffffff"
BALL: Final = "#8a97a5"


def look(part: Part, colours: Mapping[str, str], active: bool) -> tuple[str, str, float]:
    """Face, edge and line width [pt] of a part, from the colours of links and closures."""
    owner = part.links[0] if part.role in ("plate", "bar", "rod", "barrel") else part.owner
    colour = colours.get(owner, BALL)
    ink = colour == INK
    body, edge = (STEEL, INK) if ink else (pale(colour), deep(colour))
    driven = RED if active else WHITE
    looks = {
        "plate": (body, edge, 1.1),
        "bar": (body, edge, 1.1),
        "rod": (mix(body, WHITE, 0.6), edge, 1.0),
        "barrel": (mix(body, edge, 0.35) if ink else mix(colour, WHITE, 0.35), edge, 1.1),
        "block": (STEEL if not active else RED, INK, 1.1),
        "rail": (GRID, QUIET, 0.8),
        "hinge": (driven, INK, 1.1),
        "collar": (driven, INK, 1.0),
        "ball": (mix(colour, INK, 0.12), deep(colour), 0.9),
        "cross": (BALL, INK, 0.8),
        "pin": (WHITE, deep(colour), 1.9),
        "weld": (deep(colour), deep(colour), 1.0),
        "base": ("#eef1f4", SHADOW, 0.9),
    }
    return looks[part.role]


def shaded(face: str, part: Part, view: View) -> str:
    """A face a little darker where a plate is turned away from the viewer."""
    if view.planar or part.role != "plate":
        return face
    values = np.linalg.svd(part.points - part.points.mean(axis=0))[2]
    return mix(face, INK, 0.10 * (1.0 - abs(float(values[-1] @ view.toward))))
