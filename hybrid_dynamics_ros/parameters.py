"""The parameters of the node: one table, the values read from it, and the check of every value.

Knows no rclpy: `node/declare_parameters.py` puts the table onto a node.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType
from typing import Any, Final, Generic, TypeVar, cast

RELIABLE: Final = "reliable"
BEST_EFFORT: Final = "best_effort"
SENSOR_DATA: Final = "sensor_data"
LATEST: Final = "latest"
PROFILES: Final = (RELIABLE, BEST_EFFORT, SENSOR_DATA, LATEST)

Value = str | int | float | bool | tuple[float, ...] | tuple[str, ...] | None
T = TypeVar("T", bound=Value)
OptionalFloats = tuple[float, ...] | None
OptionalNames = tuple[str, ...] | None


class ParameterError(ValueError):
    """A parameter has a value that the node cannot use, or a name that it does not know."""


class ChangeTime(Enum):
    """When a parameter may change."""

    NEVER = "it is fixed once the node runs; start the node with another value"
    UNCONFIGURED = (
        "it changes only while the node is unconfigured; call the transition cleanup first"
    )
    ANY_TIME = "at any time"


@dataclass(frozen=True)
class Parameter(Generic[T]):
    """One line of the table.

    Attributes:
        name: parameter name.
        default: value where none is given; None where the parameter is then not set.
        text: what it is, for people.
        unit: of a number; "" for other values.
        bounds: lowest and highest number, both allowed; None where there are no bounds.
        choices: the words that are allowed; () where any word is.
        kind: type of the value, or of the entries where it is an array.
        length: number of entries of an array; None for an array of any length, 0 for no array.
        change: when it may change.
    """

    name: str
    default: T
    text: str
    unit: str = ""
    bounds: tuple[float, float] | None = None
    choices: tuple[str, ...] = ()
    kind: type[Any] = float
    length: int | None = 0
    change: ChangeTime = ChangeTime.UNCONFIGURED


_LARGE: Final = 1e9
_RATE: Final = "by the stamps of the input. 0: one for every input. -1: none."


def _rate(topic: str, default: float) -> Parameter[float]:
    """The highest rate of an output topic."""
    text = f"Highest rate of messages on ~/{topic}, {_RATE}"
    return Parameter(
        f"rates.{topic}", default, text, unit="Hz", bounds=(-1.0, 1e5), change=ChangeTime.ANY_TIME
    )


def _threshold(name: str, default: float, text: str, unit: str) -> Parameter[float]:
    """A value from which on diagnostics warn or report an error."""
    return Parameter(
        f"diagnostics.{name}", default, text, unit, (0.0, _LARGE), change=ChangeTime.ANY_TIME
    )


ROBOT: Final = Parameter[str](
    "robot",
    "forging_chu2020",
    "Robot of this node: name of a shipped robot, or path of a description file.",
    kind=str,
)
AUTOSTART: Final = Parameter[bool](
    "autostart",
    True,
    "Whether the node configures and activates itself when it starts.",
    kind=bool,
    change=ChangeTime.NEVER,
)
MEASURED: Final = Parameter[OptionalNames](
    "measured",
    None,
    "Joints that the input measures: any independent set. Not set: the active joints of the robot.",
    kind=str,
    length=None,
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
GRAVITY: Final = Parameter[OptionalFloats](
    "gravity",
    None,
    "Gravity in the axes of the base frame. Not set: that of the robot file.",
    unit="m/s^2",
    bounds=(-1000.0, 1000.0),
    length=3,
    change=ChangeTime.ANY_TIME,
)
PAYLOAD_FRAME: Final = Parameter[str](
    "payload.frame",
    "",
    "Frame that carries the payload. Empty: the end effector.",
    kind=str,
    change=ChangeTime.ANY_TIME,
)
PAYLOAD_MASS: Final = Parameter[float](
    "payload.mass",
    0.0,
    "Mass of the payload.",
    unit="kg",
    bounds=(0.0, _LARGE),
    change=ChangeTime.ANY_TIME,
)
PAYLOAD_COM: Final = Parameter[tuple[float, ...]](
    "payload.com",
    (0.0, 0.0, 0.0),
    "Centre of mass of the payload, in the axes of its frame.",
    unit="m",
    bounds=(-_LARGE, _LARGE),
    length=3,
    change=ChangeTime.ANY_TIME,
)
PAYLOAD_INERTIA: Final = Parameter[tuple[float, ...]](
    "payload.inertia",
    (0.0,) * 6,
    "Inertia of the payload about its centre of mass, in the axes of its frame: xx, xy, xz, yy,"
    " yz, zz.",
    unit="kg m^2",
    bounds=(-_LARGE, _LARGE),
    length=6,
    change=ChangeTime.ANY_TIME,
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
    "closed_state": _rate("closed_state", 0.0),
    "end_effector_pose": _rate("end_effector_pose", 0.0),
    "end_effector_twist": _rate("end_effector_twist", 100.0),
    "loop_reactions": _rate("loop_reactions", 20.0),
    "cylinder_states": _rate("cylinder_states", 20.0),
}
TF_RATE: Final = Parameter[float](
    "rates.tf",
    -1.0,
    f"Highest rate of the transforms of all links on /tf, {_RATE} Needs tf2_msgs. Do not use it"
    " beside robot_state_publisher.",
    unit="Hz",
    bounds=(-1.0, 1e5),
)
STILL: Final = Parameter[float](
    "assembly.still_below",
    1e-3,
    "Assembly modes are switched only while no measured joint is faster than this.",
    unit="rad/s or m/s",
    bounds=(0.0, 1000.0),
    change=ChangeTime.ANY_TIME,
)
TIMEOUT: Final = Parameter[float](
    "services.timeout",
    60.0,
    "A service call that takes longer than this is answered with TIMEOUT.",
    unit="s",
    bounds=(0.01, 86400.0),
    change=ChangeTime.ANY_TIME,
)
QUEUE: Final = Parameter[int](
    "services.queue",
    64,
    "Most calls that wait for each of the two processes; further ones are answered with BUSY.",
    bounds=(1, 100000),
    kind=int,
    change=ChangeTime.ANY_TIME,
)
LEAST_SINGULARITY: Final = Parameter[float](
    "trajectory.least_singularity",
    0.02,
    "A trajectory ends before a point nearer to a singularity than this: 0 singular, 1 best.",
    bounds=(0.0, 1.0),
    change=ChangeTime.ANY_TIME,
)
DIAGNOSTICS_PERIOD: Final = Parameter[float](
    "diagnostics.period",
    1.0,
    "Time between two messages on /diagnostics.",
    unit="s",
    bounds=(0.05, 3600.0),
    change=ChangeTime.NEVER,
)
LEAST_RATE: Final = _threshold(
    "least_rate", 0.0, "Warn where the rate of the input is lower than this.", "Hz"
)
LATEST_AGE: Final = _threshold(
    "latest_age", 1.0, "Warn where the newest stamp is off the node's clock by more than this.", "s"
)
LATENCY: Final = _threshold(
    "latency", 0.02, "Warn where more than 1 % of the inputs take the node longer than this.", "s"
)
RESIDUAL: Final = _threshold(
    "residual", 1e-6, "Error where the residual of the loops is larger than this.", "1"
)
SINGULARITY_WARN: Final = _threshold(
    "singularity_warn", 0.1, "Warn nearer to a singularity than this: 0 singular, 1 best.", "1"
)
SINGULARITY_ERROR: Final = _threshold(
    "singularity_error", 0.02, "Error nearer to a singularity than this: 0 singular, 1 best.", "1"
)
STROKE_WARN: Final = _threshold(
    "stroke_warn", 0.01, "Warn nearer to the end of a stroke than this.", "rad or m"
)
STROKE_ERROR: Final = _threshold(
    "stroke_error", 0.0, "Error nearer to the end of a stroke than this; 0: beyond it.", "rad or m"
)
LOG_PERIOD: Final = Parameter[float](
    "log_period",
    5.0,
    "Least time between two log lines of the same kind about bad input.",
    unit="s",
    bounds=(0.0, 3600.0),
    change=ChangeTime.ANY_TIME,
)

# In the order of the parameter file, several on a line; of Any, since types of rows differ.
_ROWS: Final[list[Any]] = [
    *(ROBOT, AUTOSTART, MEASURED, BANDWIDTH, MAX_GAP, GRAVITY),
    *(PAYLOAD_FRAME, PAYLOAD_MASS, PAYLOAD_COM, PAYLOAD_INERTIA),
    *(INPUT_QOS, INPUT_DEPTH, OUTPUT_QOS, OUTPUT_DEPTH),
    *(*TOPIC_RATES.values(), TF_RATE, STILL, TIMEOUT, QUEUE, LEAST_SINGULARITY),
    *(DIAGNOSTICS_PERIOD, LEAST_RATE, LATEST_AGE, LATENCY, RESIDUAL),
    *(SINGULARITY_WARN, SINGULARITY_ERROR, STROKE_WARN, STROKE_ERROR, LOG_PERIOD),
]
TABLE: Final[tuple[Parameter[Any], ...]] = tuple(_ROWS)

# For every measured joint J, as sensors.J.NAME: coordinate = sign * scale * (reading - offset).
SENSOR: Final = "sensors"


def sensor_joint(name: str) -> str:
    """The joint of `sensors.JOINT.NAME`, which may have points itself; empty for other names."""
    return name.removeprefix(f"{SENSOR}.").rpartition(".")[0]


def sensor_rows(joint: str) -> tuple[Parameter[float], Parameter[float], Parameter[float]]:
    """The lines of the table for the sensor of one joint: offset, sign and scale."""

    def row(
        name: str, default: float, text: str, unit: str, bounds: tuple[float, float]
    ) -> Parameter[float]:
        full_name = f"{SENSOR}.{joint}.{name}"
        return Parameter(full_name, default, text, unit, bounds, change=ChangeTime.ANY_TIME)

    signs = "1.0, or -1.0 where the reading falls while the joint rises."
    scales = "Change of the joint coordinate for one unit of the reading."
    offset = row(
        "offset", 0.0, "Reading where the joint is at zero.", "of the reading", (-_LARGE, _LARGE)
    )
    sign = row("sign", 1.0, signs, "1", (-1.0, 1.0))
    scale = row("scale", 1.0, scales, "rad or m", (1e-12, _LARGE))
    return offset, sign, scale


class NodeSettings:
    """Checked values of the table: settings[BANDWIDTH] is a float [Hz].

    Never changes; `replaced` makes another.
    """

    def __init__(self, values: Mapping[str, Value] = MappingProxyType({})) -> None:
        """Values by name; defaults where none is given."""
        self._values = {**{row.name: row.default for row in TABLE}, **values}

    def __getitem__(self, row: Parameter[T]) -> T:
        return cast(T, self._values.get(row.name, row.default))

    @property
    def sensors(self) -> list[str]:
        """Joints of whose sensors something is said."""
        start = f"{SENSOR}."
        names = [name for name in self._values if name.startswith(start)]
        return list(dict.fromkeys(map(sensor_joint, names)))

    def replaced(self, changes: Mapping[str, Value]) -> NodeSettings:
        """The settings with other values by name."""
        return NodeSettings({**self._values, **changes})


def checked(row: Parameter[Any], value: Any) -> Value:
    """The value of a parameter, checked against its row of the table.

    A whole number is taken for a real one. An array becomes a tuple. None becomes the default.

    Raises:
        ParameterError: the value has the wrong type or length, is empty, out of bounds or none of
            the choices. The text says what is expected.
    """
    if value is None:
        return cast(Value, row.default)
    if row.length != 0:
        return _checked_array(row, value)
    entry = _entry(row, value)
    if entry == "" and row.default != "":
        raise _wrong(row, value, row.text)
    _check_sign(row, entry)
    return cast(Value, entry)


def _check_sign(row: Parameter[Any], entry: Any) -> None:
    """Raise where the sign of a sensor is neither 1 nor -1, which bounds cannot say."""
    is_sign = row.name.startswith(f"{SENSOR}.") and row.name.endswith(".sign")
    if is_sign and abs(entry) != 1.0:
        raise _wrong(row, entry, "expected 1.0 or -1.0")


def _checked_array(row: Parameter[Any], value: Any) -> Value:
    """An array as a tuple, its length and entries checked."""
    if isinstance(value, str | bytes) or not isinstance(value, Sequence):
        raise _wrong(row, value, "expected an array")
    if row.length is not None and len(value) != row.length:
        raise _wrong(row, list(value), f"expected {row.length} entries")
    return cast(Value, tuple(_entry(row, entry) for entry in value))


def _entry(row: Parameter[Any], value: Any) -> Any:
    """A value that is no array, or one entry of an array, checked."""
    if row.kind is float and type(value) is int:
        value = float(value)
    if type(value) is not row.kind:
        raise _wrong(row, value, f"expected {_KINDS[row.kind]}")
    if row.choices and value not in row.choices:
        raise _wrong(row, value, f"expected one of: {', '.join(row.choices)}")
    if row.bounds is not None:
        low, high = row.bounds
        if not (math.isfinite(value) and low <= value <= high):
            unit = f" {row.unit}" if row.unit else ""
            raise _wrong(row, value, f"expected a number from {low:g} to {high:g}{unit}")
    return value


_KINDS: Final = {str: "a word", int: "a whole number", float: "a number", bool: "true or false"}


def _wrong(row: Parameter[Any], value: object, expected: str) -> ParameterError:
    shown = f"'{value}'" if isinstance(value, str) else value
    return ParameterError(f"parameter {row.name} is {shown}: {expected}")
