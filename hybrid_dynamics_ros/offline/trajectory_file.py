"""Joints over time from a file: CSV, .npz, what `simulate` saves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from hybrid_dynamics_core import Robot
from hybrid_dynamics_ros.offline.errors import BagError
from hybrid_dynamics_ros.samples import FloatArray


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Joints over time: names, time (N,) [s], and position, velocity, effort (N, n); None where not known."""

    names: tuple[str, ...]
    time: FloatArray
    position: FloatArray
    velocity: FloatArray | None = None
    effort: FloatArray | None = None

    def noisy(self, deviations: Mapping[str, float], seed: int = 0) -> Trajectory:
        """With white noise of these standard deviations by part."""
        rng, changed = np.random.default_rng(seed), {}
        for part, deviation in deviations.items():
            values = getattr(self, part)
            if values is not None:
                changed[part] = values + rng.normal(0.0, deviation, values.shape)
        return replace(self, **changed)


def read_trajectory(path: Path, robot: Robot) -> Trajectory:
    """From a CSV file with a header, or a .npz.

    Columns `time`, each joint by name, and optionally `JOINT.velocity` and `JOINT.effort`. A .npz may have the same
    names, or `time` with `position`, `velocity`, `effort` (N, n) in the order of the active joints. What `simulate`
    saves is taken too.

    Raises:
        BagError: a column is missing, or has values that are no numbers.
    """
    try:
        columns = _npz(path, robot) if path.suffix == ".npz" else _csv(path)
    except (OSError, ValueError, IndexError, KeyError) as error:
        raise BagError(f"{path}: expected a CSV file with a header, or a .npz ({error})") from error
    time_name = next((name for name in ("time", "t", "time [s]") if name in columns), None)
    missing = [name for name in robot.active if name not in columns]
    if time_name is None or missing:
        told = "time" if time_name is None else ", ".join(missing)
        raise BagError(
            f"{path}: no column {told}; expected time, {', '.join(robot.active)}; there are: {', '.join(columns)}"
        )
    time = columns[time_name]
    parts = [_part(columns, robot, suffix) for suffix in ("", ".velocity", ".effort")]
    for values in (time, *parts):
        if values is not None and (len(values) != len(time) or not np.isfinite(values).all()):
            raise BagError(f"{path}: expected {len(time)} finite numbers in each column")
    if not (np.diff(time) > 0.0).all():
        raise BagError(f"{path}: expected times that rise from row to row")
    if parts[0] is None:
        raise BagError(f"{path}: the positions are missing")
    return Trajectory(robot.active, time, parts[0], parts[1], parts[2])


def _part(columns: Mapping[str, FloatArray], robot: Robot, suffix: str) -> FloatArray | None:
    names = [f"{name}{suffix}" for name in robot.active]
    return np.stack([columns[name] for name in names], axis=-1) if all(n in columns for n in names) else None


def _csv(path: Path) -> dict[str, FloatArray]:
    with path.open(encoding="utf-8") as file:
        names = [name.strip().strip('"') for name in file.readline().split(",")]
    table = np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
    return {name: table[:, k] for k, name in enumerate(names)}


def _npz(path: Path, robot: Robot) -> dict[str, FloatArray]:
    with np.load(path, allow_pickle=False) as file:
        found: dict[str, Any] = dict(file)
    flat = [name for name, a in found.items() if a.ndim == 1 and a.dtype.kind in "fi"]
    columns = {name: np.asarray(found[name], dtype=np.float64) for name in flat}
    for part, key in (("position", "state_u"), ("velocity", "state_du")):  # as `Simulation.save` writes them
        if key in found:
            found[part] = found[key]
    for suffix, keys in (("", ("position", "u")), (".velocity", ("velocity", "du")), (".effort", ("effort", "tau"))):
        values = next((found[key] for key in keys if key in found), None)
        if values is not None and values.ndim == 2 and values.shape[1] == len(robot.active):
            columns |= {f"{name}{suffix}": values[:, k] for k, name in enumerate(robot.active)}
    return columns
