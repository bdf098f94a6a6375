"""The layout of a JointState."""

from __future__ import annotations

from collections.abc import Sequence

from .cdr import Template


def joint_state(names: Sequence[str], *, velocity: bool, effort: bool) -> Template:
    """A sensor_msgs/JointState: slots `position`, `velocity`, `effort`; the last two as far as they are known."""
    count = len(names)
    template = Template().header().strings(names).sequence("position", count)
    for name, known in (("velocity", velocity), ("effort", effort)):
        template = template.sequence(name, count) if known else template.length(0)
    return template
