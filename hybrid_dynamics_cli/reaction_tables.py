"""Reactions in pins, joints and the foundation as tables and as data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

import click
import numpy as np

from hybrid_dynamics_core import Reactions
from hybrid_dynamics_core.dynamics.reactions import JointReaction, PinReaction
from hybrid_dynamics_core.ground.arrays import Array

from .output import table

Reaction = PinReaction | JointReaction
pins_option = click.option("--pins", is_flag=True, help="Also the forces in all pins of loops.")
_FORCE: Final = ["force N", "x", "y", "z"]
_MOMENT: Final = ["moment N m", "mx", "my", "mz"]
_SHARE: Final = 1e-12  # of the largest number of a table: below it a component is rounding


def pin_data(reactions: Reactions) -> dict[str, Any]:
    """The reactions of pins by name, for JSON."""
    data: dict[str, Any] = {}
    for name, pin in reactions.pins.items():
        data[name] = {**_wrench(pin), "silent": pin.silent, "share": pin.share}
    return data


def joint_data(reactions: Reactions) -> dict[str, Any]:
    """The reactions of joints by name, for JSON."""
    return {name: _wrench(joint) for name, joint in reactions.joints.items()}


def base_data(reactions: Reactions) -> dict[str, Any]:
    """The wrench of the foundation about the base's origin, for JSON."""
    return {"force": reactions.base[:3], "moment": reactions.base[3:]}


def _wrench(reaction: Reaction) -> dict[str, Any]:
    on, by = _links(reaction)
    return {
        "place": reaction.place,
        "force": reaction.force,
        "moment": reaction.moment,
        "on": on,
        "by": by,
    }


def _links(reaction: Reaction) -> tuple[str, str]:
    """The link on which a wrench acts, and the link that exerts it."""
    first, second = reaction.links
    if isinstance(reaction, PinReaction):
        return first, second
    return second, first


def pin_table(reactions: Reactions) -> str:
    """The reactions of pins, with a line for each that rigid links do not determine."""
    lines = [_table("pin", reactions.pins)]
    for name, pin in reactions.pins.items():
        if np.isnan(pin.force).any():
            lines.append(
                f"note: {name}: rigid links do not determine its force here, as with bars in line"
            )
    return "\n".join(lines)


def joint_table(reactions: Reactions) -> str:
    """The reactions of joints."""
    return _table("joint", reactions.joints)


def base_text(reactions: Reactions) -> str:
    """The wrench of the foundation on the robot."""
    largest = _largest([reactions.base])
    force = _numbers(reactions.base[:3], largest)
    moment = _numbers(reactions.base[3:], largest)
    return table(["foundation", *_FORCE, *_MOMENT], [["on the base", *force, *moment]])


def _table(kind: str, reactions: Mapping[str, PinReaction] | Mapping[str, JointReaction]) -> str:
    """Forces, then moments unless all are zero."""
    forces: list[list[object]] = []
    moments: list[list[object]] = []
    largest = _largest([part for one in reactions.values() for part in (one.force, one.moment)])
    for name, reaction in reactions.items():
        forces.append([name, *_links(reaction), *_numbers(reaction.force, largest)])
        moments.append([name, *_numbers(reaction.moment, largest)])
    texts = [table([kind, "on", "by", *_FORCE], forces)]
    if any(row[1] for row in moments):
        texts.append(table([kind, *_MOMENT], moments))
    return "\n\n".join(texts)


def _largest(vectors: Sequence[Array]) -> float:
    """The largest number, by magnitude."""
    numbers = np.concatenate([np.zeros(1), *vectors])
    return float(np.nanmax(np.abs(numbers)))


def _numbers(vector: Array, largest: float) -> list[float]:
    """Size and components, zero where they are rounding errors of the largest number."""
    is_rounding = np.abs(vector) < _SHARE * largest
    shown = np.where(is_rounding, 0.0, vector)
    return [float(np.linalg.norm(shown)), *shown.tolist()]
