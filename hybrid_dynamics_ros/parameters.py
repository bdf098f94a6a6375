"""The parameters of the node: one table, and the settings read from it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.node import Node

from hybrid_dynamics_ros import qos

Value = str | int | float


class ParameterError(ValueError):
    """A parameter has a value that the node cannot use."""


@dataclass(frozen=True)
class Parameter:
    """One line of the table. The type is that of ``default``.

    Attributes:
        name: parameter name.
        default: value where none is given.
        text: what it is, one sentence.
        unit: unit of a number, or "".
        bounds: lowest and highest number, both allowed.
        choices: the words that are allowed; empty means any.
        read_only: whether it is fixed once the node runs.
    """

    name: str
    default: Value
    text: str
    unit: str = ""
    bounds: tuple[float, float] | None = None
    choices: tuple[str, ...] = ()
    read_only: bool = True


ROBOT: Final = Parameter(
    "robot", "forging_chu2020", "Robot of this node: name of a shipped robot, or path of a description file."
)
BANDWIDTH: Final = Parameter(
    "acceleration_filter.bandwidth",
    10.0,
    "Bandwidth of the estimated accelerations (3 dB down), and of the velocities where messages have none.",
    unit="Hz",
    bounds=(0.01, 1000.0),
)
MAX_GAP: Final = Parameter(
    "acceleration_filter.max_gap",
    0.5,
    "Stamps further apart than this restart the estimation of accelerations.",
    unit="s",
    bounds=(0.001, 3600.0),
)
INPUT_QOS: Final = Parameter("qos.input", qos.RELIABLE, "Reliability of the subscriptions.", choices=qos.NAMES)
INPUT_DEPTH: Final = Parameter(
    "qos.input_depth", 200, "Messages that wait at most in each subscription.", bounds=(1, 100000)
)
OUTPUT_QOS: Final = Parameter("qos.output", qos.RELIABLE, "Reliability of the publishers.", choices=qos.NAMES)
OUTPUT_DEPTH: Final = Parameter(
    "qos.output_depth", 200, "Messages that wait at most in each publisher.", bounds=(1, 100000)
)
LOG_PERIOD: Final = Parameter(
    "log_period",
    5.0,
    "Least time between two log lines of the same kind about bad input.",
    unit="s",
    bounds=(0.0, 3600.0),
)

TABLE: Final = (ROBOT, BANDWIDTH, MAX_GAP, INPUT_QOS, INPUT_DEPTH, OUTPUT_QOS, OUTPUT_DEPTH, LOG_PERIOD)


@dataclass(frozen=True)
class Settings:
    """Values of the parameters, checked. Units as in the table."""

    robot: str
    bandwidth: float
    max_gap: float
    input_qos: str
    input_depth: int
    output_qos: str
    output_depth: int
    log_period: float


def descriptor(parameter: Parameter) -> ParameterDescriptor:
    """The parameter as ROS tools see it."""
    message = ParameterDescriptor(
        name=parameter.name,
        description=parameter.text + (f" [{parameter.unit}]" if parameter.unit else ""),
        additional_constraints=f"one of: {', '.join(parameter.choices)}" if parameter.choices else "",
        read_only=parameter.read_only,
    )
    if parameter.bounds is not None:
        low, high = parameter.bounds
        if isinstance(parameter.default, int):
            message.integer_range = [IntegerRange(from_value=int(low), to_value=int(high), step=0)]
        else:
            message.floating_point_range = [FloatingPointRange(from_value=low, to_value=high, step=0.0)]
    return message


def declare(node: Node) -> Settings:
    """Declare the whole table on a node and read the values that were given.

    Raises:
        ParameterError: a word is none of the choices, or a text is empty.
        rclpy.exceptions.ParameterException: a value has the wrong type or is out of its range.
    """
    values: dict[str, Any] = {}
    for parameter in TABLE:
        given = node.declare_parameter(parameter.name, parameter.default, descriptor(parameter)).value
        _check(parameter, given)
        values[parameter.name] = given
    return Settings(
        robot=values[ROBOT.name],
        bandwidth=values[BANDWIDTH.name],
        max_gap=values[MAX_GAP.name],
        input_qos=values[INPUT_QOS.name],
        input_depth=values[INPUT_DEPTH.name],
        output_qos=values[OUTPUT_QOS.name],
        output_depth=values[OUTPUT_DEPTH.name],
        log_period=values[LOG_PERIOD.name],
    )


def _check(parameter: Parameter, value: Any) -> None:
    if parameter.choices and value not in parameter.choices:
        raise ParameterError(
            f"parameter {parameter.name} is '{value}', expected one of: {', '.join(parameter.choices)}"
        )
    if value == "":
        raise ParameterError(f"parameter {parameter.name} is empty: {parameter.text}")
