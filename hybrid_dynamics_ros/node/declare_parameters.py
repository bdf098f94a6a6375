"""The table of parameters on a node: declared, read, watched; names that nobody declared are refused."""

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
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter

from hybrid_dynamics_core.ground.suggestions import did_you_mean

from ..parameters import (
    SENSOR,
    TABLE,
    Change,
    Parameter,
    ParameterError,
    Settings,
    checked,
    sensor_rows,
)

# Parameters that rclpy itself reads, and the sensors, which are known once there is a robot.
_OTHERS: Final = re.compile(
    rf"use_sim_time|start_type_description_service|qos_overrides\..+|{SENSOR}\.[^.]+\.(offset|sign|scale)"
)
_TYPES: Final = {
    (str, False): RosParameter.Type.STRING,
    (int, False): RosParameter.Type.INTEGER,
    (float, False): RosParameter.Type.DOUBLE,
    (bool, False): RosParameter.Type.BOOL,
    (str, True): RosParameter.Type.STRING_ARRAY,
    (float, True): RosParameter.Type.DOUBLE_ARRAY,
}


def descriptor(row: Parameter[Any]) -> ParameterDescriptor:
    """The line of the table as ROS tools see it."""
    constraints = [f"one of: {', '.join(row.choices)}"] if row.choices else []
    constraints += [f"{row.length} entries"] if row.length else []
    constraints += [row.change.value] if row.change is Change.UNCONFIGURED else []
    message = ParameterDescriptor(
        name=row.name,
        type=_type(row).value,
        description=row.text + (f" [{row.unit}]" if row.unit else ""),
        additional_constraints="; ".join(constraints),
        read_only=row.change is Change.NEVER,
    )
    if row.bounds is not None:
        low, high = row.bounds
        if row.kind is int:
            message.integer_range = [IntegerRange(from_value=int(low), to_value=int(high), step=0)]
        else:
            message.floating_point_range = [
                FloatingPointRange(from_value=low, to_value=high, step=0.0)
            ]
    return message


def declare(node: Node) -> Settings:
    """Declare the whole table on a node and read the values that were given.

    Raises:
        ParameterError: a name is unknown, or a value has the wrong type or is out of its range.
    """
    values = {row.name: _declare(node, row) for row in TABLE}
    known = [row.name for row in TABLE]
    for name in _overrides(node):
        if name not in known and not _OTHERS.fullmatch(name):
            last = {
                row.rpartition(".")[2]: row for row in known
            }  # people forget the group a parameter is in
            near = difflib.get_close_matches(name, [*known, *last], n=1)
            hint = (
                did_you_mean(last.get(near[0], near[0])) if near else f"; known: {', '.join(known)}"
            )
            raise ParameterError(f"there is no parameter {name}{hint}")
    return Settings(values)


def declare_sensors(node: Node, joints: Iterable[str]) -> dict[str, Any]:
    """Declare the sensors of the measured joints, take those of other joints away; values by name.

    Raises:
        ParameterError: a value cannot be used, or a sensor was given for a joint that is not
        measured.
    """
    rows = {row.name: row for joint in joints for row in sensor_rows(joint)}
    there = list(node.get_parameters_by_prefix(SENSOR))
    for name in (f"{SENSOR}.{rest}" for rest in there):
        if name not in rows:
            node.undeclare_parameter(name)
    strange = [n for n in _overrides(node) if n.startswith(f"{SENSOR}.") and n not in rows]
    if strange:
        raise ParameterError(f"parameter {strange[0]}: measured are {', '.join(joints)}")
    return {
        name: (
            checked(row, node.get_parameter(name).value)
            if node.has_parameter(name)
            else _declare(node, row)
        )
        for name, row in rows.items()
    }


def is_given(node: Node, row: Parameter[Any]) -> bool:
    """Whether somebody chose a value, or the node has the default."""
    return row.name in _overrides(node) or node.get_parameter(row.name).value != row.default


class Watch:
    """Checks every change of a parameter before it is taken, and tells of it after."""

    def __init__(
        self,
        node: Node,
        settings: Callable[[], Settings],
        allowed: Callable[[Settings, Sequence[Parameter[Any]]], str],
        taken: Callable[[Settings], None],
    ) -> None:
        """Watch the parameters of a node.

        Args:
            node: has the table declared.
            settings: the settings now.
            allowed: with the settings as they would be, and the lines that change: why not, or "".
            taken: told of settings that were taken.
        """
        self._node, self._settings, self._allowed, self._taken = node, settings, allowed, taken
        node.add_pre_set_parameters_callback(self._convert)
        node.add_on_set_parameters_callback(self._check)
        node.add_post_set_parameters_callback(self._take)

    def _row(self, name: str) -> Parameter[Any] | None:
        rows = TABLE if not name.startswith(f"{SENSOR}.") else sensor_rows(name.split(".")[1])
        return next((row for row in rows if row.name == name), None)

    def _convert(self, given: list[RosParameter]) -> list[RosParameter]:
        return [_converted(self._row(p.name), p) for p in given]

    def _changed(self, given: Sequence[RosParameter]) -> Settings:
        rows = [(self._row(p.name), p) for p in given]
        return self._settings().replaced(
            {row.name: checked(row, p.value) for row, p in rows if row is not None}
        )

    def _check(self, given: Sequence[RosParameter]) -> SetParametersResult:
        rows = [row for p in given if (row := self._row(p.name)) is not None]
        try:
            reason = self._allowed(self._changed(given), rows) if rows else ""
        except ParameterError as error:
            reason = str(error)
        return SetParametersResult(successful=not reason, reason=reason)

    def _take(self, given: Sequence[RosParameter]) -> None:
        self._taken(self._changed(given))


def _type(row: Parameter[Any]) -> RosParameter.Type:
    return _TYPES[row.kind, row.length != 0]


def _overrides(node: Node) -> dict[str, RosParameter]:
    """What the command line and parameter files gave to this node. rclpy has no public way to ask."""
    overrides: dict[str, RosParameter] = node._parameter_overrides  # noqa: SLF001
    return overrides


def _converted(row: Parameter[Any] | None, given: RosParameter) -> RosParameter:
    """Whole numbers where the table has real ones."""
    if row is None or row.kind is not float:
        return given
    if given.type_ is RosParameter.Type.INTEGER and row.length == 0:
        return RosParameter(given.name, RosParameter.Type.DOUBLE, float(given.value))
    if given.type_ is RosParameter.Type.INTEGER_ARRAY and row.length != 0:
        return RosParameter(
            given.name, RosParameter.Type.DOUBLE_ARRAY, [float(value) for value in given.value]
        )
    return given


def _declare(node: Node, row: Parameter[Any]) -> Any:
    overrides = _overrides(node)
    if row.name in overrides:
        overrides[row.name] = _converted(row, overrides[row.name])
        checked(
            row, overrides[row.name].value
        )  # before rclpy does, whose texts do not say what is expected
    default = _type(row) if row.default is None else row.default
    declared = node.declare_parameter(row.name, default, descriptor(row))
    return checked(row, declared.value)
