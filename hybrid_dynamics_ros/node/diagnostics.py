"""The monitor's report as diagnostic_msgs."""

from __future__ import annotations

from collections.abc import Sequence

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from std_msgs.msg import Header

from ..stream.monitor import Level, StatusEntry


def diagnostic_array(
    name: str, hardware: str, state: str, entries: Sequence[StatusEntry], stamp: Time
) -> DiagnosticArray:
    """One status: the worst of its entries, which its message names.

    Args:
        name: full name of the node.
        hardware: name of the robot, or "".
        state: lifecycle state of the node.
        entries: what was found.
        stamp: when.
    """
    worst = max((entry.level for entry in entries), default=Level.OK)
    texts = [state]
    if worst is not Level.OK:
        bad = [entry for entry in entries if entry.level == worst]
        texts += [f"{entry.name}: {entry.value}" for entry in bad]
    status = DiagnosticStatus(
        level=bytes([worst]),
        name=f"{name.lstrip('/')}: stream",
        message="; ".join(texts),
        hardware_id=hardware,
        values=[KeyValue(key=entry.name, value=entry.value) for entry in entries],
    )
    return DiagnosticArray(header=Header(stamp=stamp), status=[status])
