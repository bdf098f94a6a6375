"""The parameters of the node: a table, the values read from it, and the check of every value.

Each subject has a module with its lines of the table. Knows no rclpy:
`node/declare_parameters.py` puts the table onto a node.
"""

from .check import checked
from .diagnostics import (
    DIAGNOSTICS_PERIOD,
    LATENCY,
    LATEST_AGE,
    LEAST_RATE,
    LOG_PERIOD,
    RESIDUAL,
    SINGULARITY_ERROR,
    SINGULARITY_WARN,
    STROKE_ERROR,
    STROKE_WARN,
)
from .frames import BASE_FRAME, FRAME_PREFIX, TF_TARGETS
from .inputs import (
    BANDWIDTH,
    FILTER_ROWS,
    FILTER_TYPE,
    INPUT_DEPTH,
    INPUT_QOS,
    KALMAN,
    KALMAN_BANDWIDTH,
    MAX_GAP,
    PARTIAL_AGE,
    PASS_THROUGH,
    POLYNOMIAL,
    SENSOR,
    VELOCITY_NOISE,
    sensor_joint,
    sensor_rows,
)
from .outputs import OUTPUT_DEPTH, OUTPUT_QOS, TF_RATE, TOPIC_RATES
from .profiles import BEST_EFFORT, LATEST, PROFILES, RELIABLE, SENSOR_DATA
from .robot import (
    AUTOSTART,
    GRAVITY,
    MEASURED,
    PAYLOAD_COM,
    PAYLOAD_FRAME,
    PAYLOAD_INERTIA,
    PAYLOAD_MASS,
    ROBOT,
    STILL,
)
from .row import ChangeTime, OptionalFloats, OptionalNames, Parameter, ParameterError, Value
from .services import EFFORT_TOLERANCE, FOLLOW_ACTION, LEAST_SINGULARITY, QUEUE, TIMEOUT
from .settings import NodeSettings
from .table import ROS_NAMES, TABLE

__all__ = [
    "AUTOSTART",
    "BANDWIDTH",
    "BASE_FRAME",
    "BEST_EFFORT",
    "DIAGNOSTICS_PERIOD",
    "EFFORT_TOLERANCE",
    "FILTER_ROWS",
    "FILTER_TYPE",
    "FOLLOW_ACTION",
    "FRAME_PREFIX",
    "GRAVITY",
    "INPUT_DEPTH",
    "INPUT_QOS",
    "KALMAN",
    "KALMAN_BANDWIDTH",
    "LATENCY",
    "LATEST",
    "LATEST_AGE",
    "LEAST_RATE",
    "LEAST_SINGULARITY",
    "LOG_PERIOD",
    "MAX_GAP",
    "MEASURED",
    "OUTPUT_DEPTH",
    "OUTPUT_QOS",
    "PARTIAL_AGE",
    "PASS_THROUGH",
    "PAYLOAD_COM",
    "PAYLOAD_FRAME",
    "PAYLOAD_INERTIA",
    "PAYLOAD_MASS",
    "POLYNOMIAL",
    "PROFILES",
    "QUEUE",
    "RELIABLE",
    "RESIDUAL",
    "ROBOT",
    "ROS_NAMES",
    "SENSOR",
    "SENSOR_DATA",
    "SINGULARITY_ERROR",
    "SINGULARITY_WARN",
    "STILL",
    "STROKE_ERROR",
    "STROKE_WARN",
    "TABLE",
    "TF_RATE",
    "TF_TARGETS",
    "TIMEOUT",
    "TOPIC_RATES",
    "VELOCITY_NOISE",
    "ChangeTime",
    "NodeSettings",
    "OptionalFloats",
    "OptionalNames",
    "Parameter",
    "ParameterError",
    "Value",
    "checked",
    "sensor_joint",
    "sensor_rows",
]
