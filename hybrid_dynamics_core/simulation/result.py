"""What a simulation recorded."""

from __future__ import annotations

import json
import os
import zlib
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from types import MappingProxyType
from typing import Any, BinaryIO
from zipfile import BadZipFile

import numpy as np

from ..closed_state.state import ClosedState
from ..dynamics.energy import Energy
from ..errors import InputError
from ..ground.arrays import Array
from .events import Event

FORMAT = 3
_FORMER = {"t": "time", "ddu": "acceleration", "tau": "effort"}  # names of arrays in format 2


@dataclass(frozen=True, eq=False)
class Simulation:
    """A recorded motion of N samples.

    Attributes:
        robot, names: name of the robot and of its active coordinates; coordinates: names of all,
        the order of state.s.
        t: (N,) [s]; the last sample is where the simulation ended.
        state: ClosedState of all samples: s, ds, R, residuals, distances to singularities.
        ddu, tau: (N, n) active accelerations and efforts.
        energy: Energy of all samples [J]; work: (N,) [J] brought in by tau and wrenches less
        friction, since the start.
        events: what was met; completed: whether the end of the time span was reached; message: why
        it ended.
        steps, evaluations: of the integrator.
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
        """(N, n) active coordinates."""
        return self.state.u

    @property
    def du(self) -> Array:
        """(N, n) active rates."""
        return self.state.du

    @property
    def energy_error(self) -> Array:
        """(N,) energy less what was brought in, since the start [J]: zero but for the integrator's error."""
        total = self.energy.total
        return np.asarray(total - total[0] - self.work)

    @property
    def relative_energy_error(self) -> float:
        """Largest energy error in parts of the energy that was exchanged (range of kinetic or potential energy)."""
        exchanged = max(float(np.ptp(part)) for part in (*self.energy, self.work))
        worst = float(np.abs(self.energy_error).max())
        return worst / exchanged if worst else 0.0

    @property
    def residual(self) -> float:
        """Largest error of the loop equations over all samples."""
        return float(np.max(self.state.residual))

    def table(self) -> tuple[tuple[str, ...], Array]:
        """Names of the columns, and (N, columns).

        `time`, each coordinate by name and its `.velocity`, `.acceleration` and `.effort` of active
        joints, energies.
        """
        head = ["time", *self.coordinates, *(f"{name}.velocity" for name in self.coordinates)]
        head += [f"{name}.{what}" for what in ("acceleration", "effort") for name in self.names]
        head += [*(f"energy.{part}" for part in self.energy._fields), "work"]
        parts = (self.t, self.state.s, self.state.ds, self.ddu, self.tau, *self.energy, self.work)
        return tuple(head), np.column_stack(parts)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write to a file, which appears when it is complete.

        .csv: the `table`, its names in the first line, SI units; .npz: everything, which
        `load_simulation` reads. Raises InputError for another ending.
        """
        target = Path(path)
        writers = {".npz": self._write_npz, ".csv": self._write_csv}
        if target.suffix not in writers:
            raise InputError(
                f"{target.name} ends in '{target.suffix}'; expected {' or '.join(writers)}"
            )
        aside = target.with_name(f".{target.name}.part")
        with aside.open("wb") as file:
            writers[target.suffix](file)
        aside.replace(target)

    def _write_csv(self, file: BinaryIO) -> None:
        head, rows = self.table()
        np.savetxt(file, rows, fmt="%.17g", delimiter=",", header=",".join(head), comments="")

    def _write_npz(self, file: BinaryIO) -> None:
        told = ("robot", "names", "coordinates", "message", "completed", "steps", "evaluations")
        head = {
            "format": FORMAT,
            **{k: getattr(self, k) for k in told},
            "events": [asdict(event) for event in self.events],
            "branch": dict(self.state.branch),
            "loops": self.state.loops,
        }
        arrays: dict[str, Any] = {
            "time": self.t,
            "acceleration": self.ddu,
            "effort": self.tau,
            "work": self.work,
        }
        arrays |= {f"energy_{k}": v for k, v in self.energy._asdict().items()}
        arrays |= {
            f"state_{k}": getattr(self.state, k)
            for k in _state_arrays()
            if getattr(self.state, k) is not None
        }
        np.savez_compressed(file, head=np.array(json.dumps(head)), **arrays)


def load_simulation(path: str | os.PathLike[str]) -> Simulation:
    """Read what `Simulation.save` wrote. Raises InputError for another file."""
    try:
        with np.load(path, allow_pickle=False) as file:
            head = json.loads(str(file["head"]))
            arrays = {k: file[k] for k in file.files if k != "head"}
    except (OSError, KeyError, ValueError, TypeError, EOFError, BadZipFile, zlib.error) as error:
        raise InputError(f"{path} is not a saved simulation: {error}") from error
    if head.get("format") == 2:
        arrays = {_FORMER.get(k, k): v for k, v in arrays.items()}
    elif head.get("format") != FORMAT:
        raise InputError(
            f"{path} has format {head.get('format')}; this version reads 2 and {FORMAT}"
        )
    states = {k.removeprefix("state_"): v for k, v in arrays.items() if k.startswith("state_")}
    state = ClosedState(
        **states, branch=MappingProxyType(head["branch"]), loops=tuple(head["loops"])
    )
    return Simulation(
        robot=head["robot"],
        names=tuple(head["names"]),
        coordinates=tuple(head["coordinates"]),
        state=state,
        energy=Energy(*(arrays[f"energy_{k}"] for k in Energy._fields)),
        events=tuple(Event(**event) for event in head["events"]),
        t=arrays["time"],
        ddu=arrays["acceleration"],
        tau=arrays["effort"],
        work=arrays["work"],
        **{k: head[k] for k in ("message", "completed", "steps", "evaluations")},
    )


def _state_arrays() -> list[str]:
    return [f.name for f in fields(ClosedState) if f.name not in ("branch", "loops")]
