"""Conversion of tolerances from the joints of a goal to the active joints."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from ..messages.joint_samples import FloatArray
from ..services.trajectory_steps import JointMaps

_LEAST: Final = 1e-9  # least entry of a map that is not rounding
_PARTS: Final = ("position", "velocity", "acceleration")


def active_tolerances(tolerances: Sequence[Any], maps: JointMaps, entries: FloatArray) -> list[Any]:
    """Tolerances of active joints that keep the goal's joints within theirs, to first order.

    The tolerance of a joint is divided evenly among the active joints that move it. As in
    control_msgs, zero means the default tolerance, and a negative value means none.

    Args:
        tolerances: control_msgs/JointTolerance of the goal's joints.
        maps: maps from active rates to rates of these joints.
        entries: (k, n) absolute entries of the maps, without rounding.
    """
    kind = type(tolerances[0]) if tolerances else None
    if kind is None:
        return []
    allowed = {part: _allowed(part, tolerances, maps, entries) for part in _PARTS}
    made = []
    for place, name in enumerate(maps.active):
        values = {part: float(allowed[part][place]) for part in _PARTS}
        if any(values.values()):
            made.append(kind(name=name, **values))
    return made


def _allowed(
    part: str, tolerances: Sequence[Any], maps: JointMaps, entries: FloatArray
) -> FloatArray:
    """One kind of tolerance of each active joint (n,)."""
    least = np.full(len(maps.active), np.inf)
    is_free = np.zeros(len(maps.active), dtype=bool)
    for tolerance in tolerances:
        if tolerance.name not in maps.joints:
            continue
        row = entries[maps.joints.index(tolerance.name)]
        moving = row > _LEAST
        value = getattr(tolerance, part)
        if value > 0.0 and moving.any():
            share = value / np.count_nonzero(moving)
            least[moving] = np.minimum(least[moving], share / row[moving])
        elif value < 0.0:
            is_free |= moving
    erased = np.where(is_free, -1.0, 0.0)
    return np.where(np.isfinite(least), least, erased)
