"""Declaration, reading and watching of a node's parameters.

Undeclared names are refused.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Iterable, Sequence
from typing import Any, Final

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rcl_interfaces.msg import Parameter as ParameterMessage
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter

from hybrid_dynamics_core.ground.suggestions import did_you_mean

from ..parameters import (
    ROS_NAMES,
    SENSOR,
    TABLE,
    ChangeTime,
    NodeSettings,
    Parameter,
    ParameterError,
    checked,
    sensor_joint,
    sensor_rows,
)

# Sensors are declared when there is a robot.
_OTHER_NAMES: Final = re.compile(rf"{ROS_NAMES.pattern}|{SENSOR}\..+\.(offset|sign|scale)")
_TYPES: Final = {
    (str, False): RosParameter.Type.STRING,
    (int, False): RosParameter.Type.INTEGER,
    (float, False): RosParameter.Type.DOUBLE,
    (bool, False): RosParameter.Type.BOOL,
    (str, True): RosParameter.Type.STRING_ARRAY,
    (float, True): RosParameter.Type.DOUBLE_ARRAY,
}


def descriptor(parameter: Parameter[Any]) -> ParameterDescriptor:
    """The descriptor of a parameter, for ROS tools."""
    description = parameter.text
    if parameter.unit:
        description = f"{description} [{parameter.unit}]"
    message = ParameterDescriptor(
        name=parameter.name,
        type=_type(parameter).value,
        description=description,
        additional_constraints="; ".join(_constraints(parameter)),
        read_only=parameter.change is ChangeTime.NEVER,
    )
    if parameter.bounds is not None:
        low, high = parameter.bounds
        if parameter.kind is int:
            int_range = IntegerRange(from_value=int(low), to_value=int(high), step=0)
            message.integer_range = [int_range]
        else:
            float_range = FloatingPointRange(from_value=low, to_value=high, step=0.0)
            message.floating_point_range = [float_range]
    return message


def _constraints(parameter: Parameter[Any]) -> list[str]:
    constraints = []
    if parameter.choices:
        constraints.append(f"one of: {', '.join(parameter.choices)}")
    if parameter.length:
        constraints.append(f"{parameter.length} entries")
    if parameter.change is ChangeTime.UNCONFIGURED:
        constraints.append(parameter.change.value)
    return constraints


def declare(node: Node) -> NodeSettings:
    """Declare all parameters on a node, and read their values.

    Raises:
        ParameterError: a name is unknown, or a value has a wrong type or is out of range.
    """
    values = {parameter.name: _declare(node, parameter) for parameter in TABLE}
    for name in _overrides(node):
        if name not in values and not _OTHER_NAMES.fullmatch(name):
            raise ParameterError(f"there is no parameter {name}{_hint(name)}")
    return NodeSettings(values)


def _hint(name: str) -> str:
    """A suggestion of names."""
    names = [parameter.name for parameter in TABLE]
    # Users forget groups; of two names with the same last part the first is suggested.
    by_last_part = {entry.rpartition(".")[2]: entry for entry in reversed(names)}
    near = difflib.get_close_matches(name, [*names, *by_last_part], n=1)
    if near:
        return did_you_mean(by_last_part.get(near[0], near[0]))
    return f"; known: {', '.join(names)}"


def declare_sensors(node: Node, joints: Iterable[str]) -> dict[str, Any]:
    """Declare sensor parameters of the measured joints, and undeclare those of other joints.

    Returns:
        Values by name.

    Raises:
        ParameterError: a value is wrong, or a sensor is given for a joint that is not measured.
    """
    parameters = {row.name: row for joint in joints for row in sensor_rows(joint)}
    for suffix in list(node.get_parameters_by_prefix(SENSOR)):
        name = f"{SENSOR}.{suffix}"
        if name not in parameters:
            node.undeclare_parameter(name)
    for name in _overrides(node):
        if name.startswith(f"{SENSOR}.") and name not in parameters:
            raise ParameterError(f"parameter {name}: measured are {', '.join(joints)}")
    values = {}
    for name, parameter in parameters.items():
        if node.has_parameter(name):
            values[name] = checked(parameter, node.get_parameter(name).value)
        else:
            values[name] = _declare(node, parameter)
    return values


def is_given(node: Node, parameter: Parameter[Any]) -> bool:
    """Whether a value was given, and is not the default."""
    if parameter.name in _overrides(node):
        return True
    return bool(node.get_parameter(parameter.name).value != parameter.default)


class ParameterWatch:
    """Checks every change of a parameter before it is applied, and reports it afterwards."""

    def __init__(
        self,
        node: Node,
        settings: Callable[[], NodeSettings],
        why_not: Callable[[NodeSettings, Sequence[Parameter[Any]]], str],
        taken: Callable[[NodeSettings], None],
    ) -> None:
        """Watch the parameters of a node.

        Args:
            node: the node with declared parameters.
            settings: the present settings.
            why_not: called with the new settings and the changed parameters; returns why they
                cannot change, or "".
            taken: called with the applied settings.
        """
        self._node, self._settings, self._why_not, self._taken = node, settings, why_not, taken
        node.add_pre_set_parameters_callback(self._convert)
        node.add_on_set_parameters_callback(self._check)
        node.add_post_set_parameters_callback(self._take)

    def after(self, messages: Sequence[ParameterMessage]) -> NodeSettings:
        """The settings after a change.

        Raises:
            ParameterError: a value is wrong.
        """
        return self._changed(self._convert([*map(RosParameter.from_parameter_msg, messages)]))

    def _convert(self, given: list[RosParameter]) -> list[RosParameter]:
        return [_converted(_parameter(entry.name), entry) for entry in given]

    def _changed(self, given: Sequence[RosParameter]) -> NodeSettings:
        changes = {}
        for entry in given:
            parameter = _parameter(entry.name)
            if parameter is not None:
                changes[parameter.name] = checked(parameter, entry.value)
        return self._settings().replaced(changes)

    def _check(self, given: Sequence[RosParameter]) -> SetParametersResult:
        candidates = [_parameter(entry.name) for entry in given]
        parameters = [parameter for parameter in candidates if parameter is not None]
        reason = ""
        if parameters:
            try:
                reason = self._why_not(self._changed(given), parameters)
            except ParameterError as error:
                reason = str(error)
        return SetParametersResult(successful=not reason, reason=reason)

    def _take(self, given: Sequence[RosParameter]) -> None:
        self._taken(self._changed(given))


def _parameter(name: str) -> Parameter[Any] | None:
    """The parameter of a name, also of a joint's sensor; None if unknown."""
    table: Sequence[Parameter[Any]] = TABLE
    if name.startswith(f"{SENSOR}."):
        table = sensor_rows(sensor_joint(name))
    return next((parameter for parameter in table if parameter.name == name), None)


def _type(parameter: Parameter[Any]) -> RosParameter.Type:
    return _TYPES[parameter.kind, parameter.length != 0]


def _overrides(node: Node) -> dict[str, RosParameter]:
    """Values given to this node by command line and parameter files."""
    # rclpy has no public access to them.
    overrides: dict[str, RosParameter] = node._parameter_overrides  # noqa: SLF001
    return overrides


def _converted(parameter: Parameter[Any] | None, given: RosParameter) -> RosParameter:
    """Convert integers to floats if needed, and replace an unset value by the default."""
    if parameter is None:
        return given
    kinds = RosParameter.Type
    if given.type_ is kinds.NOT_SET or _is_empty_array(parameter, given):
        return _unset(parameter)
    if parameter.kind is not float:
        return given
    if given.type_ is kinds.INTEGER and parameter.length == 0:
        return RosParameter(given.name, kinds.DOUBLE, float(given.value))
    if given.type_ is kinds.INTEGER_ARRAY and parameter.length != 0:
        return RosParameter(given.name, kinds.DOUBLE_ARRAY, list(map(float, given.value)))
    return given


def _is_empty_array(parameter: Parameter[Any], given: RosParameter) -> bool:
    """Whether an array is empty, so that its type is unknown."""
    return parameter.length != 0 and isinstance(given.value, Sequence) and len(given.value) == 0


def _unset(parameter: Parameter[Any]) -> RosParameter:
    """The parameter with its default value."""
    value = parameter.default
    if parameter.length != 0:
        value = list(value or ())
    return RosParameter(parameter.name, _type(parameter), value)


def _declare(node: Node, parameter: Parameter[Any]) -> Any:
    unset = _unset(parameter)
    given = _converted(parameter, _overrides(node).get(parameter.name, unset))
    value = checked(parameter, given.value)  # before rclpy, for a better text
    # rclpy treats an empty array as bytes, so it is declared by type and set afterwards.
    is_empty = _is_empty_array(parameter, given)
    start = _type(parameter) if is_empty else given.value
    node.declare_parameter(parameter.name, start, descriptor(parameter), ignore_override=True)
    if is_empty:
        node.set_parameters([unset])
    return value
