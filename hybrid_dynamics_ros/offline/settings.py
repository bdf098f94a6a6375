"""The node's parameters from a parameter file, without ROS."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml

from hybrid_dynamics_ros.offline.errors import BagError
from hybrid_dynamics_ros.parameters import SENSOR, TABLE, ParameterError, Settings, checked, sensor_rows


def read_settings(path: Path | None) -> Settings:
    """Settings of a file as `ros2 run ... --params-file` takes it; defaults without one.

    Raises:
        BagError: it is no parameter file.
        ParameterError: a parameter is unknown, or has a value that cannot be used.
    """
    if path is None:
        return Settings()
    try:
        tree = yaml.safe_load(path.read_text(encoding="utf-8"))
        given = dict(_flat(next(iter(tree.values()))["ros__parameters"]))
    except (OSError, ValueError, yaml.YAMLError, AttributeError, KeyError, TypeError, StopIteration) as error:
        raise BagError(f"{path}: expected a parameter file, '/**:' above 'ros__parameters:' ({error})") from error
    rows = {row.name: row for row in TABLE}
    values = {}
    for name, value in given.items():
        if name.startswith(f"{SENSOR}.") and name.count(".") == 2:
            rows |= {row.name: row for row in sensor_rows(name.split(".")[1])}
        if name not in rows:
            raise ParameterError(f"{path}: there is no parameter {name}")
        values[name] = checked(rows[name], value)
    return Settings(values)


def _flat(tree: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in tree.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value
