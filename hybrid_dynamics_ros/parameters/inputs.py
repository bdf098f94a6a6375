"""Parameters: input, sensors, and estimation of rates."""

from __future__ import annotations

from typing import Any, Final

from .profiles import PROFILES, RELIABLE
from .row import LARGE, ChangeTime, Parameter

POLYNOMIAL: Final = "polynomial"
KALMAN: Final = "kalman"

FILTER_TYPE: Final = Parameter[str](
    "acceleration_filter.type",
    POLYNOMIAL,
    "What estimates accelerations, and velocities where messages have none.",
    choices=(POLYNOMIAL, KALMAN),
    kind=str,
)
BANDWIDTH: Final = Parameter[float](
    "acceleration_filter.bandwidth",
    10.0,
    "Bandwidth of the estimated accelerations (3 dB down), and of the velocities where messages"
    " have none.",
    unit="Hz",
    bounds=(0.01, 1000.0),
    change=ChangeTime.ANY_TIME,
)
MAX_GAP: Final = Parameter[float](
    "acceleration_filter.max_gap",
    0.5,
    "Stamps further apart than this restart the estimation of accelerations.",
    unit="s",
    bounds=(0.001, 3600.0),
    change=ChangeTime.ANY_TIME,
)
KALMAN_BANDWIDTH: Final = Parameter[float](
    "acceleration_filter.kalman.bandwidth",
    15.0,
    "The same bandwidth where the type is kalman.",
    unit="Hz",
    bounds=(0.01, 1000.0),
    change=ChangeTime.ANY_TIME,
)
VELOCITY_NOISE: Final = Parameter[float](
    "acceleration_filter.kalman.velocity_noise",
    400.0,
    "Noise of measured velocities over that of positions, where the type is kalman. 30 for"
    " velocities of a good sensor, 1e9 to leave velocities out.",
    unit="1/s",
    bounds=(1e-3, LARGE),
    change=ChangeTime.ANY_TIME,
)
# A change of any of them restarts the estimates.
FILTER_ROWS: Final[tuple[Parameter[Any], ...]] = (
    FILTER_TYPE,
    BANDWIDTH,
    MAX_GAP,
    KALMAN_BANDWIDTH,
    VELOCITY_NOISE,
)

PARTIAL_AGE: Final = Parameter[float](
    "partial_messages.max_age",
    0.2,
    "Messages that have some of the measured joints are joined where their stamps are no further"
    " apart than this. Pressures are joined with joint states within the same time. 0: they are"
    " refused.",
    unit="s",
    bounds=(0.0, 3600.0),
    change=ChangeTime.ANY_TIME,
)
ODOMETRY: Final = Parameter[str](
    "odometry.topic",
    "",
    "Topic of nav_msgs/Odometry with pose and twist of a floating base, such as /odom. The newest"
    " message is joined with each joint state, as partial_messages.max_age says. Empty: the base"
    " stands at its reference.",
    kind=str,
)
ESTIMATION_SENSORS: Final = Parameter[str](
    "estimation.sensors",
    "",
    "YAML file of sensors, as of `hybrid-dynamics estimate`. Their readings give the joint states,"
    " which then go through the node as measured ones do. Empty: joints are measured.",
    kind=str,
)
ESTIMATION_RATE: Final = Parameter[float](
    "estimation.rate",
    100.0,
    "Most joint states a second that the readings of sensors give.",
    unit="Hz",
    bounds=(0.1, 10000.0),
)
ESTIMATION_DELAY: Final = Parameter[float](
    "estimation.max_delay",
    0.1,
    "Readings of sensors that come later than this after newer ones are left out.",
    unit="s",
    bounds=(0.0, 10.0),
)
PASS_THROUGH: Final = Parameter[bool](
    "pass_through",
    False,
    "Whether joints of the input that are no joints of the robot, such as a gripper, go out on"
    " ~/joint_states.",
    kind=bool,
)
INPUT_QOS: Final = Parameter[str](
    "qos.input", RELIABLE, "Quality of service of the subscriptions.", choices=PROFILES, kind=str
)
INPUT_DEPTH: Final = Parameter[int](
    "qos.input_depth",
    200,
    "Most messages that wait in each subscription (history depth).",
    bounds=(1, 100000),
    kind=int,
)

ROWS: Final[tuple[Parameter[Any], ...]] = (
    *FILTER_ROWS,
    *(PARTIAL_AGE, ODOMETRY),
    *(ESTIMATION_SENSORS, ESTIMATION_RATE, ESTIMATION_DELAY),
    PASS_THROUGH,
    *(INPUT_QOS, INPUT_DEPTH),
)

# sensors.J.NAME for every measured joint J: coordinate = sign * scale * (reading - offset).
SENSOR: Final = "sensors"


def sensor_joint(name: str) -> str:
    """The joint of `sensors.JOINT.NAME`, which may contain dots; empty for other names."""
    return name.removeprefix(f"{SENSOR}.").rpartition(".")[0]


def sensor_rows(joint: str) -> tuple[Parameter[float], Parameter[float], Parameter[float]]:
    """The rows of the table for the sensor of one joint: offset, sign and scale."""

    def row(
        name: str, default: float, text: str, unit: str, bounds: tuple[float, float]
    ) -> Parameter[float]:
        full_name = f"{SENSOR}.{joint}.{name}"
        return Parameter(full_name, default, text, unit, bounds, change=ChangeTime.ANY_TIME)

    signs = "1.0, or -1.0 where the reading falls while the joint rises."
    scales = "Change of the joint coordinate for one unit of the reading."
    offset = row(
        "offset", 0.0, "Reading where the joint is at zero.", "of the reading", (-LARGE, LARGE)
    )
    sign = row("sign", 1.0, signs, "1", (-1.0, 1.0))
    scale = row("scale", 1.0, scales, "rad or m", (1e-12, LARGE))
    return offset, sign, scale
