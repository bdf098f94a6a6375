"""The record of a simulation."""

from __future__ import annotations

import json
import os
import zlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from types import MappingProxyType
from typing import Any, BinaryIO
from zipfile import BadZipFile

import numpy as np

from ..closed_state.passages.record import passage_from
from ..closed_state.state import ClosedState
from ..dynamics.energy import Energy
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.atomic_files import atomic_file
from .events import Event

FORMAT = 3
LEAST_SHARE = 1e-6  # least share of the potential energy as scale: far above rounding
_FORMER = {"t": "time", "ddu": "acceleration", "tau": "effort"}  # names of arrays in format 2
_IN_HEAD = ("branch", "loops", "passive_angles", "passages")  # fields of states without arrays
_HEAD_FIELDS = (
    "robot",
    "names",
    "coordinates",
    "message",
    "completed",
    "steps",
    "evaluations",
)


@dataclass(frozen=True, eq=False)
class Simulation:
    """A recorded motion of N samples.

    Attributes:
        robot: name of the robot.
        names: names of the active coordinates.
        coordinates: names of all coordinates, in the order of state.s.
        t: (N,) times [s]; the last one is the end of the simulation.
        state: ClosedState of all samples: s, ds, R, residuals, distances to singularities.
        ddu: (N, n) active accelerations [rad/s^2 or m/s^2].
        tau: (N, n) active efforts [N m or N].
        energy: energies of all samples [J].
        work: (N,) work of tau and wrenches minus losses by friction, since the start [J].
        events: limits and singularities that were reached.
        message: why the simulation ended.
        completed: whether the end of the time span was reached.
        steps: number of steps of the integrator.
        evaluations: number of evaluations of the equations of motion.
    """

    robot: str
    names: tuple[str, ...]
    coordinates: tuple[str, ...]
    t: Array
    state: ClosedState
    ddu: Array
    tau: Array
    energy: Energy
    work: Array
    events: tuple[Event, ...]
    message: str
    completed: bool
    steps: int
    evaluations: int

    @property
    def u(self) -> Array:
        """(N, n) active coordinates [rad or m]."""
        return self.state.u

    @property
    def du(self) -> Array:
        """(N, n) active rates [rad/s or m/s]."""
        return self.state.du

    @property
    def energy_error(self) -> Array:
        """Change of energy minus work since the start (N,) [J], which is the integrator's error."""
        total = self.energy.total
        return np.asarray(total - total[0] - self.work)

    @property
    def relative_energy_error(self) -> float:
        """Largest energy error, relative to the energies in the motion.

        The scale is the sum of the largest kinetic energy, spring energy, change of potential
        energy and work. It is at least a millionth of the potential energy about the base origin.
        """
        worst = float(np.abs(self.energy_error).max())
        if not worst:
            return 0.0
        energy = self.energy
        lifted = energy.potential - energy.potential[0]
        parts = (energy.kinetic, energy.springs, lifted, self.work)
        scale = sum(float(np.abs(part).max()) for part in parts)
        least = LEAST_SHARE * float(np.abs(energy.potential).max())
        return worst / max(scale, least)

    @property
    def residual(self) -> float:
        """Largest error of the loop equations over all samples."""
        return float(np.max(self.state.residual))

    def table(self) -> tuple[tuple[str, ...], Array]:
        """All numbers as a table.

        Returns:
            Names of the columns, and (N, columns). The columns are `time`, each coordinate by name,
            its `.velocity`, then `.acceleration` and `.effort` of the active joints, and energies.
        """
        state = self.state
        columns = ["time", *self.coordinates]
        columns += [f"{name}.velocity" for name in self.coordinates]
        columns += [f"{name}.acceleration" for name in self.names]
        columns += [f"{name}.effort" for name in self.names]
        columns += [f"energy.{part}" for part in self.energy._fields]
        columns.append("work")
        motion = (self.t, state.s, state.ds, self.ddu, self.tau)
        rows = np.column_stack([*motion, *self.energy, self.work])
        return tuple(columns), rows

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write to a file; it appears only when it is complete.

        Args:
            path: .csv for the `table` in SI units, with names in the first line; .npz for all data,
                as read by `load_simulation`.

        Raises:
            InputError: the suffix is neither .csv nor .npz.
        """
        target = Path(path)
        writers = {".npz": self._write_npz, ".csv": self._write_csv}
        if target.suffix not in writers:
            raise InputError(
                f"{target.name} ends in '{target.suffix}'; expected {' or '.join(writers)}"
            )
        with atomic_file(target) as new, new.open("wb") as file:
            writers[target.suffix](file)

    def _write_csv(self, file: BinaryIO) -> None:
        columns, rows = self.table()
        header = ",".join(columns)
        np.savetxt(
            file,
            rows,
            fmt="%.17g",
            delimiter=",",
            header=header,
            comments="",
        )

    def _write_npz(self, file: BinaryIO) -> None:
        head: dict[str, Any] = {"format": FORMAT}
        for name in _HEAD_FIELDS:
            head[name] = getattr(self, name)
        head["events"] = [asdict(event) for event in self.events]
        head["branch"] = dict(self.state.branch)
        head["loops"] = self.state.loops
        head["passive_angles"] = dict(self.state.passive_angles)
        arrays: dict[str, Any] = {
            "time": self.t,
            "acceleration": self.ddu,
            "effort": self.tau,
            "work": self.work,
        }
        for name, values in self.energy._asdict().items():
            arrays[f"energy_{name}"] = values
        for name in _state_arrays():
            values = getattr(self.state, name)
            if values is not None:
                arrays[f"state_{name}"] = values
        text = np.array(json.dumps(head))
        np.savez_compressed(file, head=text, **arrays)


def load_simulation(path: str | os.PathLike[str]) -> Simulation:
    """Read an .npz file of `Simulation.save`.

    Args:
        path: path of the file.

    Returns:
        The simulation.

    Raises:
        InputError: the file is no such file.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            head = json.loads(str(file["head"]))
            arrays = {name: file[name] for name in file.files if name != "head"}
    except (OSError, KeyError, ValueError, TypeError, EOFError, BadZipFile, zlib.error) as error:
        raise InputError(f"{path} is not a saved simulation: {error}") from error
    if head.get("format") == 2:
        arrays = {_FORMER.get(name, name): values for name, values in arrays.items()}
    elif head.get("format") != FORMAT:
        raise InputError(
            f"{path} has format {head.get('format')}; this version reads 2 and {FORMAT}"
        )
    return _simulation(head, arrays)


def _simulation(head: Mapping[str, Any], arrays: Mapping[str, Array]) -> Simulation:
    """A simulation from the head and the arrays of a file."""
    energies = [arrays[f"energy_{name}"] for name in Energy._fields]
    events = [_event(event) for event in head["events"]]
    return Simulation(
        robot=head["robot"],
        names=tuple(head["names"]),
        coordinates=tuple(head["coordinates"]),
        t=arrays["time"],
        state=_state(head, arrays),
        ddu=arrays["acceleration"],
        tau=arrays["effort"],
        energy=Energy(*energies),
        work=arrays["work"],
        events=tuple(events),
        message=head["message"],
        completed=head["completed"],
        steps=head["steps"],
        evaluations=head["evaluations"],
    )


def _event(entry: Mapping[str, Any]) -> Event:
    """An event from its entry in a file."""
    passage = entry.get("passage")
    if passage is not None:
        passage = passage_from(passage)
    return Event(entry["time"], entry["kind"], entry["name"], entry["message"], passage)


def _state(head: Mapping[str, Any], arrays: Mapping[str, Array]) -> ClosedState:
    """The states from the head and the arrays of a file."""
    states: dict[str, Any] = {}
    for name, values in arrays.items():
        if name.startswith("state_"):
            states[name.removeprefix("state_")] = values
    branch = MappingProxyType(head["branch"])
    angles = {}
    for name, (k, start) in head.get("passive_angles", {}).items():
        angles[name] = (int(k), float(start))
    return ClosedState(**states, branch=branch, loops=tuple(head["loops"]), passive_angles=angles)


def _state_arrays() -> list[str]:
    names = [field.name for field in fields(ClosedState)]
    return [name for name in names if name not in _IN_HEAD]
