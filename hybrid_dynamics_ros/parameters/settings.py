"""The values of the parameters."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import cast

from .inputs import SENSOR, sensor_joint
from .robot import XACRO_ARGS
from .row import Parameter, T, Value
from .table import TABLE


class NodeSettings:
    """Checked parameter values: settings[BANDWIDTH] is a float [Hz].

    It is immutable; `replaced` returns a changed copy.
    """

    def __init__(self, values: Mapping[str, Value] = MappingProxyType({})) -> None:
        """Set values by name, with defaults for all others."""
        self._values = {**{row.name: row.default for row in TABLE}, **values}

    def __getitem__(self, row: Parameter[T]) -> T:
        return cast(T, self._values.get(row.name, row.default))

    @property
    def sensors(self) -> list[str]:
        """Joints with sensor settings."""
        start = f"{SENSOR}."
        names = [name for name in self._values if name.startswith(start)]
        return list(dict.fromkeys(map(sensor_joint, names)))

    @property
    def xacro_args(self) -> dict[str, str]:
        """Arguments of a xacro file, by name."""
        pairs = [text.split(":=", 1) for text in self[XACRO_ARGS] or ()]
        return {name.strip(): value.strip() for name, value in pairs}

    def replaced(self, changes: Mapping[str, Value]) -> NodeSettings:
        """The settings with some values replaced, by name."""
        return NodeSettings({**self._values, **changes})
