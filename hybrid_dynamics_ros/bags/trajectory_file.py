"""Joints over time from a file: CSV, .npz, what `simulate` saves."""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final
from zipfile import BadZipFile

import numpy as np

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.ground.file_kinds import FileKind, classify_path
from hybrid_dynamics_core.ground.wording import counted

from ..messages.joint_samples import FloatArray
from .errors import BagError, wrong_kind

TRAJECTORY: Final = (
    "a trajectory (CSV with the columns time and JOINT, or .npz, as `simulate --save` writes them)"
)
# Each part by the names it may have: of a joint's column, and of an array (N, n) in a .npz; the
# first are written now, the others were by earlier versions.
_TIMES: Final = ("time", "t", "time [s]")
_SUFFIXES: Final = {
    "position": ("",),
    "velocity": (".velocity", ".rate"),
    "effort": (".effort",),
    "acceleration": (".acceleration",),
}
_ARRAYS: Final = {
    "position": ("position", "state_u", "u"),
    "velocity": ("velocity", "state_du", "du"),
    "effort": ("effort", "tau"),
    "acceleration": ("acceleration", "ddu"),
}


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Joints over time.

    Attributes:
        names: of the joints.
        time: (N,) [s], rising.
        position: (N, n) [rad or m]; velocity, effort, acceleration: (N, n), None where not known.
        unused: columns of the file that are none of these.
    """

    names: tuple[str, ...]
    time: FloatArray
    position: FloatArray
    velocity: FloatArray | None = None
    effort: FloatArray | None = None
    acceleration: FloatArray | None = None
    unused: tuple[str, ...] = ()

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

    Columns `time`, each joint by name, and optionally `JOINT.velocity`, `JOINT.acceleration` and
    `JOINT.effort`. A .npz may have the same names, or `time` with `position`, `velocity`,
    `acceleration`, `effort` (N, n) in the order of the active joints. What `simulate` saves is
    taken too, and what it saved under earlier names (`t`, `JOINT.rate`).

    Raises:
        BagCallError: there is no file, or one of another kind.
        BagError: a column is missing, has values that are no numbers, or is of an active joint and
        not known.
    """
    if classify_path(path).kind not in (FileKind.TRAJECTORY, FileKind.TEXT) and not (
        path.suffix == ".npz" and path.is_file()
    ):
        raise wrong_kind(path, TRAJECTORY)
    try:
        columns, spare = _npz(path, robot) if path.suffix == ".npz" else (_csv(path), [])
    except UnicodeDecodeError as error:
        raise BagError(f"{path}: is not in UTF-8; expected {TRAJECTORY}") from error
    except (OSError, ValueError, IndexError, KeyError) as error:
        raise BagError(f"{path}: expected a CSV file with a header, or a .npz ({error})") from error
    time_name = next(
        (name for name in _TIMES if name in columns and name not in robot.active), None
    )
    missing = [name for name in robot.active if name not in columns]
    if time_name is None or missing:
        told = "time" if time_name is None else ", ".join(missing)
        raise BagError(
            f"{path}: no column {told}; expected time, {', '.join(robot.active)}; there are:"
            f" {', '.join(columns)}"
        )
    named = {part: _names_of(path, columns, robot, part) for part in _SUFFIXES}
    used = {time_name, *(name for names in named.values() for name in names or ())}
    unused = [name for name in columns if name not in used]
    _require_known(path, unused, robot)
    time = columns[time_name]
    parts = {part: _table(columns, names) for part, names in named.items() if names is not None}
    for values in (time, *parts.values()):
        if len(values) != len(time) or not np.isfinite(values).all():
            raise BagError(f"{path}: expected {counted(len(time), 'finite number')} in each column")
    if not (np.diff(time) > 0.0).all():
        raise BagError(f"{path}: expected times that rise from row to row")
    return Trajectory(robot.active, time, **parts, unused=(*unused, *spare))


def _names_of(
    path: Path, columns: Mapping[str, FloatArray], robot: Robot, part: str
) -> list[str] | None:
    """The columns of a part, one for each active joint; None where there are none at all."""
    for suffix in _SUFFIXES[part]:
        names = [f"{name}{suffix}" for name in robot.active]
        missing = [name for name in names if name not in columns]
        if not missing:
            return names
        if len(missing) < len(names):
            raise BagError(
                f"{path}: no column {', '.join(missing)}; expected {part} of all active joints, or"
                " of none"
            )
    return None


def _require_known(path: Path, unused: list[str], robot: Robot) -> None:
    """What is said of an active joint in a word that is not known is a mistake rather than something besides."""
    stems = tuple(f"{name}." for name in robot.active)
    known = {
        f"{name}{suffix}"
        for name in robot.coordinates
        for suffixes in _SUFFIXES.values()
        for suffix in suffixes
    }
    strange = [name for name in unused if name not in known and name.startswith(stems)]
    if strange:
        told = ", ".join(f"JOINT{suffixes[0]}" for suffixes in _SUFFIXES.values())
        raise BagError(
            f"{path}: column {', '.join(strange)} is not known; of an active joint there may be"
            f" {told}"
        )


def _table(columns: Mapping[str, FloatArray], names: list[str]) -> FloatArray:
    return np.stack([columns[name] for name in names], axis=-1)


def _csv(path: Path) -> dict[str, FloatArray]:
    with path.open(encoding="utf-8-sig") as file:
        names = [name.strip().strip('"') for name in file.readline().split(",")]
    if len(set(names)) < len(names):
        raise ValueError("two columns have the same name")
    table = np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
    if table.shape[1] != len(names):
        raise ValueError(f"{counted(len(names), 'name')} above {counted(table.shape[1], 'column')}")
    return {name: table[:, k] for k, name in enumerate(names)}


def _npz(path: Path, robot: Robot) -> tuple[dict[str, FloatArray], list[str]]:
    """Columns by name, and the arrays that are none."""
    try:
        with np.load(path, allow_pickle=False) as file:
            found: dict[str, Any] = dict(file)
    except (BadZipFile, EOFError, TypeError, zlib.error) as error:
        raise ValueError(f"it is damaged, or no .npz file ({error})") from error
    for name, values in found.items():
        if values.ndim and values.dtype.kind not in "fiub" and name != "head":
            raise ValueError(f"{name} holds {values.dtype.name} values; expected real numbers")
    arrays = {
        part: next((key for key in keys if key in found and found[key].ndim == 2), None)
        for part, keys in _ARRAYS.items()
    }
    columns: dict[str, FloatArray] = {}
    for part, key in arrays.items():
        if key is None:
            continue
        values = found.pop(key)
        if values.shape[1] != len(robot.active):
            raise ValueError(f"{key} has shape {values.shape}; expected (N, {len(robot.active)})")
        columns |= {
            f"{name}{_SUFFIXES[part][0]}": values[:, k] for k, name in enumerate(robot.active)
        }
    flat = [
        name
        for name, a in found.items()
        if a.ndim == 1 and a.dtype.kind in "fi" and name not in columns
    ]
    columns |= {name: np.asarray(found.pop(name), dtype=np.float64) for name in flat}
    return columns, [name for name in found if name not in columns and name != "head"]
