"""A log line without the middleware or a lock."""

from __future__ import annotations

import os
import time


def say(severity: str, text: str) -> None:
    """Write a line of the log to standard error, in the format of ROS.

    Args:
        severity: name of the severity in ROS.
        text: the line.
    """
    line = f"[{severity}] [{time.time():.9f}] [hybrid_dynamics]: {text}\n"
    os.write(2, line.encode())
