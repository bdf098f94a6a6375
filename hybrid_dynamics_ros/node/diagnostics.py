"""Diagnostics: a diagnostic_msgs status for each subject."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from std_msgs.msg import Header

from ..stream.monitor import Level, StatusEntry

Subjects = Mapping[str, Sequence[StatusEntry]]  # entries by subject


def diagnostic_array(
    name: str, hardware: str, state: str, subjects: Subjects, stamp: Time
) -> DiagnosticArray:
    """A status for each subject, with the level of its worst entry.

    Args:
        name: full name of the node.
        hardware: name of the robot, or "".
        state: lifecycle state of the node.
        subjects: entries by subject.
        stamp: time of the report.
    """
    array = DiagnosticArray(header=Header(stamp=stamp))
    for subject, entries in subjects.items():
        status = _status(state, entries)
        status.name = f"{name.lstrip('/')}: {subject}"
        status.hardware_id = hardware
        array.status.append(status)
    return array


def _status(state: str, entries: Sequence[StatusEntry]) -> DiagnosticStatus:
    """A status whose message has the node's state and the worst entries."""
    worst = max((entry.level for entry in entries), default=Level.OK)
    texts = [state]
    if worst is not Level.OK:
        bad = [entry for entry in entries if entry.level == worst]
        texts += [f"{entry.name}: {entry.value}" for entry in bad]
    values = [KeyValue(key=entry.name, value=entry.value) for entry in entries]
    return DiagnosticStatus(level=bytes([worst]), message="; ".join(texts), values=values)
