"""Transforms of all links in the one before, for /tf where robot_state_publisher does not send them. Knows no rclpy."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from hybrid_dynamics_core import Robot

from ..messages import layouts
from ..messages.link_transforms import LinkTransforms
from ..parameters import TF_RATE, ParameterError
from .outputs import Fill
from .results import MotionResult


def tf_output() -> tuple[type, Callable[[Robot], Fill]]:
    """Type of /tf and what makes its filler.

    Raises:
        ParameterError: tf2_msgs is not installed.
    """
    try:
        from tf2_msgs.msg import TFMessage  # noqa: PLC0415 - not among the wheels of PyPI
    except ImportError as error:
        text = (
            f"parameter {TF_RATE.name}: tf2_msgs is not installed; use robot_state_publisher, or"
            " set it to -1"
        )
        raise ParameterError(text) from error
    return TFMessage, tf_filler


def tf_filler(robot: Robot) -> Fill:
    """What fills a TFMessage."""
    layout, transforms = layouts.transforms(robot), LinkTransforms(robot)

    def fill(result: MotionResult) -> Any:
        return layout.message(result.stamp_ns, transforms.values(result.position[None]).values())

    return fill
