"""Trajectories from files: CSV, .npz, and results of `simulate`."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from typing import Any, Final
from zipfile import BadZipFile

import numpy as np

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.ground.file_kinds import FileKind, classify_path
from hybrid_dynamics_core.ground.wording import counted

from ..messages.joint_samples import FloatArray, resting_joints
from .column_units import Columns, in_si_units
from .errors import BagError, wrong_kind

TRAJECTORY: Final = (
    "a trajectory (CSV with the columns time and JOINT, or .npz, as `simulate --save` writes them)"
)
# Names of each part: the first is current, the others are of earlier versions.
_TIMES: Final = ("time", "t", "time [s]")
# suffixes of a joint's name in names of columns
_SUFFIXES: Final = {
    "position": ("",),
    "velocity": (".velocity", ".rate"),
    "effort": (".effort",),
    "acceleration": (".acceleration",),
}
# names of arrays (N, n) of a .npz
_ARRAYS: Final = {
    "position": ("position", "state_u", "u"),
    "velocity": ("velocity", "state_du", "du"),
    "effort": ("effort", "tau"),
    "acceleration": ("acceleration", "ddu"),
}
_EFFORT: Final = "effort"  # the part that may be missing for some joints
_HEAD: Final = "head"  # array of a .npz with the names of its columns
# NumPy's codes of dtype kinds
_REAL_KINDS: Final = "fiub"  # real numbers
_COLUMN_KINDS: Final = "fi"  # floats and integers: booleans are flags, not columns


@dataclass(frozen=True, eq=False)
class Trajectory:
    """A trajectory of joints.

    Attributes:
        names: names of the joints.
        time: (N,) [s], ascending.
        position: (N, n) [rad or m].
        velocity: (N, n) [rad/s or m/s]; None if unknown.
        effort: (N, n) [N m or N], NaN where unknown; None if all are unknown.
        acceleration: (N, n) [rad/s^2 or m/s^2]; None if unknown.
        unused: names of other columns of the file.
    """

    names: tuple[str, ...]
    time: FloatArray
    position: FloatArray
    velocity: FloatArray | None = None
    effort: FloatArray | None = None
    acceleration: FloatArray | None = None
    unused: tuple[str, ...] = ()

    def noisy(self, deviations: Mapping[str, float], seed: int = 0) -> Trajectory:
        """The trajectory with added white noise.

        Args:
            deviations: standard deviations by part, in its unit.
            seed: seed of the random numbers.
        """
        rng = np.random.default_rng(seed)
        changed = {}
        for part, deviation in deviations.items():
            values = getattr(self, part)
            if values is not None:
                changed[part] = values + rng.normal(0.0, deviation, values.shape)
        return replace(self, **changed)


def read_trajectory(path: Path, robot: Robot) -> Trajectory:
    """Read a CSV file with a header, or a .npz.

    Columns are `time`, each joint by name, and optionally `JOINT.velocity`, `JOINT.acceleration`
    and `JOINT.effort`. Efforts may be given for some joints only. A name may have a unit, as in
    `time [ms]` or `JOINT.velocity [deg/s]`; the default is SI. A .npz may have the same names. It
    may also have `time` with `position`, `velocity`, `acceleration` and `effort` (N, n) in the
    order of the active joints. Files of `simulate` are accepted, also with its earlier names (`t`,
    `JOINT.rate`).

    Raises:
        BagCallError: the file is missing, or of another kind.
        BagError: a column is missing, a value is no number, or an active joint's name has an
            unknown suffix.
    """
    require_trajectory(path)
    columns, unused_arrays = read_columns(path, robot)
    columns = in_si_units(path, columns, robot)
    _add_resting(columns, robot)
    time_name = _time_column(path, columns, robot)
    names_by_part = {}
    for part in _SUFFIXES:
        names = _columns_of(path, columns, robot, part)
        if names is not None:
            names_by_part[part] = names
    used = {time_name}.union(*names_by_part.values())
    unused = [name for name in columns if name not in used]
    _require_meaning(path, unused, robot)
    time = columns[time_name]
    parts = {part: _table(columns, names) for part, names in names_by_part.items()}
    for part, values in {"time": time, **parts}.items():
        is_good = np.isfinite(values)
        if part == _EFFORT:
            is_good |= np.isnan(values)  # unknown
        if len(values) != len(time) or not is_good.all():
            raise BagError(f"{path}: expected {counted(len(time), 'finite number')} in each column")
    if not (np.diff(time) > 0.0).all():
        raise BagError(f"{path}: expected times that rise from row to row")
    return Trajectory(robot.active, time, **parts, unused=(*unused, *unused_arrays))


def _add_resting(columns: Columns, robot: Robot) -> None:
    """Add columns of missing idle joints, at their reference."""
    motor = next((name for name in robot.description.motors if name in columns), None)
    if motor is None:
        return
    for joint, position in resting_joints(robot).items():
        if joint in columns:
            continue
        columns[joint] = np.full_like(columns[motor], position)
        for suffix in chain.from_iterable(_SUFFIXES.values()):
            if f"{motor}{suffix}" in columns:
                columns.setdefault(f"{joint}{suffix}", np.zeros_like(columns[motor]))


def require_trajectory(path: Path) -> None:
    """Check that a path may be a trajectory; raises BagCallError."""
    if path.suffix == ".npz" and path.is_file():
        return
    if classify_path(path).kind not in (FileKind.TRAJECTORY, FileKind.TEXT):
        raise wrong_kind(path, TRAJECTORY)


def read_columns(path: Path, robot: Robot) -> tuple[Columns, list[str]]:
    """Columns by name, and names of other arrays; raises BagError."""
    try:
        if path.suffix == ".npz":
            return _read_npz(path, robot)
        return csv_columns(path), []
    except UnicodeDecodeError as error:
        raise BagError(f"{path}: is not in UTF-8; expected {TRAJECTORY}") from error
    except (OSError, ValueError, IndexError, KeyError) as error:
        raise BagError(f"{path}: expected a CSV file with a header, or a .npz ({error})") from error


def _time_column(path: Path, columns: Columns, robot: Robot) -> str:
    """The name of the column of times.

    Raises:
        BagError: there is none, or no column of an active joint.
    """
    candidates = [name for name in _TIMES if name in columns and name not in robot.active]
    missing = [name for name in robot.active if name not in columns]
    if not candidates:
        missing = ["time"]
    if missing:
        raise BagError(
            f"{path}: no column {', '.join(missing)}; expected time, {', '.join(robot.active)};"
            f" there are: {', '.join(columns)}"
        )
    return candidates[0]


def _columns_of(path: Path, columns: Columns, robot: Robot, part: str) -> list[str] | None:
    """The columns of a part, one for each active joint; None if all are missing.

    If only some joints have efforts, columns of NaN are added for the others.
    """
    for suffix in _SUFFIXES[part]:
        names = [f"{name}{suffix}" for name in robot.active]
        missing = [name for name in names if name not in columns]
        if not missing:
            return names
        if len(missing) < len(names) and part == _EFFORT:
            length = len(next(iter(columns.values())))
            columns |= {name: np.full(length, np.nan) for name in missing}
            return names
        if len(missing) < len(names):
            raise BagError(
                f"{path}: no column {', '.join(missing)}; expected {part} of all active joints, or"
                " of none"
            )
    return None


def _require_meaning(path: Path, unused: Sequence[str], robot: Robot) -> None:
    """Check for columns of an active joint with an unknown suffix; raises BagError."""
    stems = tuple(f"{name}." for name in robot.active)
    meaningful: set[str] = set()
    for suffix in chain.from_iterable(_SUFFIXES.values()):
        meaningful |= {f"{name}{suffix}" for name in robot.coordinates}
    unknown = [name for name in unused if name not in meaningful and name.startswith(stems)]
    if unknown:
        allowed = [f"JOINT{suffixes[0]}" for suffixes in _SUFFIXES.values()]
        raise BagError(
            f"{path}: column {', '.join(unknown)} is not known; expected for an active joint"
            f" {', '.join(allowed)}"
        )


def _table(columns: Columns, names: Sequence[str]) -> FloatArray:
    return np.stack([columns[name] for name in names], axis=-1)


def csv_columns(path: Path, number: Callable[[str], float] | None = None) -> Columns:
    """The columns of a CSV file with a header.

    Args:
        path: the file.
        number: the number in a cell; if None, every cell has one.

    Raises:
        ValueError: a cell is no number, two names are the same, or there are no such rows.
    """
    with path.open(encoding="utf-8-sig") as file:
        head = file.readline().split(",")
    names = [name.strip().strip('"') for name in head]
    if len(set(names)) < len(names):
        raise ValueError("two columns have the same name")
    rows = np.loadtxt(
        path, delimiter=",", skiprows=1, ndmin=2, converters=number, encoding="utf-8-sig"
    )
    if not len(rows):
        raise ValueError("there are no rows")
    if rows.shape[1] != len(names):
        raise ValueError(f"{counted(len(names), 'name')} above {counted(rows.shape[1], 'column')}")
    return dict(zip(names, rows.T, strict=True))


def _read_npz(path: Path, robot: Robot) -> tuple[Columns, list[str]]:
    """Columns by name, and names of other arrays."""
    arrays = _load_npz(path)
    columns: Columns = {}
    for part, keys in _ARRAYS.items():
        for key in keys:
            if key in arrays and arrays[key].ndim == 2:
                columns |= _split_table(key, arrays.pop(key), part, robot)
                break
    for name, values in list(arrays.items()):
        is_column = values.ndim == 1 and values.dtype.kind in _COLUMN_KINDS
        if is_column and name not in columns:
            columns[name] = np.asarray(arrays.pop(name), dtype=np.float64)
    return columns, [name for name in arrays if name not in columns and name != _HEAD]


def _load_npz(path: Path) -> dict[str, Any]:
    """The arrays of a .npz. Raises ValueError."""
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays: dict[str, Any] = dict(file)
    except (BadZipFile, EOFError, TypeError, zlib.error) as error:
        raise ValueError(f"it is damaged, or no .npz file ({error})") from error
    for name, values in arrays.items():
        is_real = values.dtype.kind in _REAL_KINDS
        if values.ndim and not is_real and name != _HEAD:
            raise ValueError(f"{name} holds {values.dtype.name} values; expected real numbers")
    return arrays


def _split_table(key: str, values: FloatArray, part: str, robot: Robot) -> Columns:
    """The columns of an array (N, n) of a .npz. Raises ValueError."""
    if values.shape[1] != len(robot.active):
        raise ValueError(f"{key} has shape {values.shape}; expected (N, {len(robot.active)})")
    suffix = _SUFFIXES[part][0]
    return {f"{name}{suffix}": values[:, k] for k, name in enumerate(robot.active)}
