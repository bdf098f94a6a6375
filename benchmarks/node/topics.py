"""The graph of the benchmark, and the topics of the node."""

from __future__ import annotations

import os
import sys

# Before ROS is imported: a graph of its own.
os.environ.setdefault("ROS_DOMAIN_ID", "93")
os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
os.environ.setdefault("AMENT_PREFIX_PATH", sys.prefix)

NAMESPACE = "/hybrid_dynamics"
INPUT = f"{NAMESPACE}/active_joint_states"
CLOSED_STATE = f"{NAMESPACE}/closed_state"
ANSWERS = (f"{NAMESPACE}/joint_states", f"{NAMESPACE}/required_efforts", CLOSED_STATE)
