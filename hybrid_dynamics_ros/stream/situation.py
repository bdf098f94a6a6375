"""The situation of a robot at a service call."""

from __future__ import annotations

from dataclasses import dataclass, field

from ..messages.joint_samples import FloatArray
from ..parameters import NodeSettings
from .conditions import Conditions


@dataclass(frozen=True, eq=False)
class Situation:
    """The situation, as plain data for worker processes.

    Attributes:
        conditions: gravity, payloads, assembly modes.
        settings: the parameters.
        measured: names of the measured joints.
        newest: active joints at the newest input (n,) [rad or m], or None before the first.
        moving: whether they were moving then.
        weighed: length of the newest motion with measured forces [s].
    """

    conditions: Conditions = field(default_factory=Conditions)
    settings: NodeSettings = field(default_factory=NodeSettings)
    measured: tuple[str, ...] = ()
    newest: FloatArray | None = None
    moving: bool = False
    weighed: float = 0.0
