"""Parameters: output topics."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from .profiles import PROFILES, RELIABLE
from .row import ChangeTime, Parameter

_RATE: Final = "by the stamps of the input. 0: one for every input. -1: none."


def _rate(topic: str, default: float) -> Parameter[float]:
    """The largest rate of an output topic."""
    text = f"Highest rate of messages on ~/{topic}, {_RATE}"
    return Parameter(
        f"rates.{topic}", default, text, unit="Hz", bounds=(-1.0, 1e5), change=ChangeTime.ANY_TIME
    )


OUTPUT_QOS: Final = Parameter[str](
    "qos.output", RELIABLE, "Quality of service of the publishers.", choices=PROFILES, kind=str
)
OUTPUT_DEPTH: Final = Parameter[int](
    "qos.output_depth",
    200,
    "Most messages that wait in each publisher (history depth).",
    bounds=(1, 100000),
    kind=int,
)
TOPIC_RATES: Final[Mapping[str, Parameter[float]]] = {
    "joint_states": _rate("joint_states", 0.0),
    "required_efforts": _rate("required_efforts", 0.0),
    "measured_efforts": _rate("measured_efforts", 0.0),
    "base_wrench": _rate("base_wrench", 0.0),
    "joint_poses": _rate("joint_poses", 0.0),
    "closed_state": _rate("closed_state", 0.0),
    "end_effector_pose": _rate("end_effector_pose", 0.0),
    "end_effector_twist": _rate("end_effector_twist", 100.0),
    "loop_reactions": _rate("loop_reactions", 20.0),
    "cylinder_states": _rate("cylinder_states", 20.0),
    "tool_wrench": _rate("tool_wrench", 50.0),
    "contact": _rate("contact", 50.0),
    "payload": _rate("payload", 1.0),
}
TF_RATE: Final = Parameter[float](
    "rates.tf",
    -1.0,
    f"Highest rate of the transforms of all links on /tf, {_RATE} Needs tf2_msgs. Do not use it"
    " beside robot_state_publisher.",
    unit="Hz",
    bounds=(-1.0, 1e5),
)

ROWS: Final[tuple[Parameter[Any], ...]] = (OUTPUT_QOS, OUTPUT_DEPTH, *TOPIC_RATES.values(), TF_RATE)
