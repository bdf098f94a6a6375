"""How things stand when a service call comes in."""

from __future__ import annotations

from dataclasses import dataclass, field

from ..messages.joint_samples import FloatArray
from ..parameters import NodeSettings
from .conditions import Conditions


@dataclass(frozen=True, eq=False)
class Situation:
    """How things stand. Plain values: they travel to the process that answers.

    Attributes:
        conditions: gravity, payloads, assembly modes.
        settings: the parameters.
        measured: joints that the stream gives.
        newest: active joints at the newest input (n,) [rad or m], or None before the first.
        moving: whether they moved then.
    """

    conditions: Conditions = field(default_factory=Conditions)
    settings: NodeSettings = field(default_factory=NodeSettings)
    measured: tuple[str, ...] = ()
    newest: FloatArray | None = None
    moving: bool = False
