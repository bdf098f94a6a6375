"""The load at the tool over a stream, weighed over the newest motion.

The input stores positions and measured forces. A window of them is weighed where a message needs
it, which takes a tenth of a second. This module does not depend on ROS.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core import Loads, Robot
from hybrid_dynamics_core.errors import HybridDynamicsError
from hybrid_dynamics_core.estimation import MeasuredRun, PayloadEstimate, estimate_payload
from hybrid_dynamics_core.estimation.sensors import check_changing
from hybrid_dynamics_core.ground.wording import one_line

from ...messages.joint_samples import FloatArray

LENGTH: Final = 20.0  # [s] of a window
LEAST: Final = 3.0  # [s] that are weighed
SPACING: Final = 0.02  # [s] least distance of stored samples
GAP: Final = 0.5  # [s] beyond which a window starts anew
Rows = NDArray[np.intp]
Stamps = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Window:
    """Positions and forces of M samples without a gap.

    Attributes:
        robot: the robot.
        loads: loads besides the actuators and the one that is weighed.
        stamp_ns: (M,) [ns], rising.
        position: (M, n) active coordinates [rad, m].
        forces: (M, d) measured forces of `robot.drives` [N m, N]; NaN for drives without.
        empty: a window of the empty tool; None before it was weighed.
        in_file_modes: whether the assembly modes are those of the robot file.
    """

    robot: Robot
    loads: Loads
    stamp_ns: Stamps
    position: FloatArray
    forces: FloatArray
    empty: Window | None
    in_file_modes: bool

    @property
    def duration(self) -> float:
        """Time from the first to the last sample [s]."""
        if not len(self.stamp_ns):
            return 0.0
        return float(self.stamp_ns[-1] - self.stamp_ns[0]) * 1e-9

    def reading(self) -> Reading:
        """The load, or why there is none."""
        try:
            estimate = self._estimate()
        except HybridDynamicsError as error:
            return Reading(None, one_line(error), self.duration, self.empty is not None)
        except np.linalg.LinAlgError as error:
            text = f"the samples cannot be weighed: {error}"
            return Reading(None, text, self.duration, self.empty is not None)
        return Reading(estimate, "", self.duration, self.empty is not None)

    def _estimate(self) -> PayloadEstimate:
        """The load; raises InputError."""
        run = self.run()
        empty = None
        if self.empty is not None:
            empty = self.empty.run().of_drives(run.drives)
        return estimate_payload(run, empty, loads=self.loads)

    def run(self) -> MeasuredRun:
        """The measured run; raises InputError."""
        if self.duration < LEAST:
            raise HybridDynamicsError(
                f"{self.duration:.1f} s of motion; expected {LEAST:g} or more"
            )
        if not self.in_file_modes:
            raise HybridDynamicsError("only assembly modes of the robot file are weighed")
        time = (self.stamp_ns - self.stamp_ns[0]) * 1e-9
        active = self.robot.active
        positions = dict(zip(active, self.position.T, strict=True))
        columns = dict(zip(self.robot.drives, self.forces.T, strict=True))
        efforts = {name: column for name, column in columns.items() if np.isfinite(column).all()}
        run = MeasuredRun.from_samples(self.robot, time, positions, efforts)
        required = self.robot.inverse_dynamics(run.state, run.ddu, self.loads)
        along = self.robot.drive_forces(run.state, required)
        for name, column in efforts.items():
            check_changing(time, {f"{name}: the force": column}, 0.0, along[name])
        return run


@dataclass(frozen=True, eq=False)
class Reading:
    """What a window shows.

    Attributes:
        estimate: the load, or None.
        problem: why there is none; empty if there is one.
        duration: of the motion [s].
        zeroed: whether the empty tool was weighed before.
    """

    estimate: PayloadEstimate | None
    problem: str
    duration: float
    zeroed: bool


@dataclass(frozen=True, eq=False)
class Windows:
    """The windows at one sample, or at N rows.

    Attributes:
        stored: all stored samples, of which each window is a part.
        start: (N,) first sample of each window.
        end: (N,) sample after the last one of each window.
    """

    stored: Window
    start: Rows
    end: Rows

    def rows(self, which: Rows) -> Windows:
        """Some of the rows."""
        return Windows(self.stored, self.start[which], self.end[which])

    def window(self, row: int) -> Window:
        """The window of a row."""
        return _part(self.stored, slice(int(self.start[row]), int(self.end[row])))


class PayloadInput:
    """Stores positions and measured forces of the newest motion."""

    def __init__(self, robot: Robot) -> None:
        """Start without samples."""
        n, d = len(robot.active), len(robot.drives)
        stamps = np.zeros(0, dtype=np.int64)
        tables = (np.zeros((0, n)), np.zeros((0, d)))
        self._stored = Window(robot, robot.loads, stamps, *tables, None, in_file_modes=True)

    @property
    def duration(self) -> float:
        """Length of the present motion [s]."""
        return self._stored.duration

    def reset(self) -> None:
        """Discard the samples so far; the empty tool stays."""
        self._stored = _part(self._stored, slice(0, 0))

    def zero(self) -> None:
        """Take the present motion as one of the empty tool."""
        self._stored = replace(self._stored, empty=replace(self._stored, empty=None))
        self.reset()

    def clear(self) -> None:
        """Forget the empty tool."""
        self._stored = replace(self._stored, empty=None)

    def take(
        self,
        stamp_ns: Stamps,
        position: FloatArray,
        forces: FloatArray,
        loads: Loads,
        *,
        in_file_modes: bool,
    ) -> Windows:
        """Take N samples.

        Args:
            stamp_ns: their stamps (N,) [ns].
            position: (N, n) active coordinates [rad, m].
            forces: (N, d) measured forces of the drives [N m, N]; NaN for drives without.
            loads: loads that the model assumes.
            in_file_modes: whether the assembly modes are those of the robot file.
        """
        if loads is not self._stored.loads or in_file_modes != self._stored.in_file_modes:
            self.reset()
            self._stored = replace(self._stored, loads=loads, in_file_modes=in_file_modes)
        before = self._stored
        kept, start, end = self._places(stamp_ns)
        stored = replace(
            before,
            stamp_ns=np.concatenate([before.stamp_ns, stamp_ns[kept]]),
            position=np.concatenate([before.position, position[kept]]),
            forces=np.concatenate([before.forces, forces[kept]]),
        )
        self._stored = _part(stored, slice(int(start[-1]), int(end[-1])))
        return Windows(stored, start, end)

    def _places(self, stamp_ns: Stamps) -> tuple[Rows, Rows, Rows]:
        """Rows that are stored, and start and end (N,) of the window at each row."""
        stamps = self._stored.stamp_ns.tolist()
        first = 0  # of the samples since the last gap
        kept: list[int] = []
        starts: list[int] = []
        for row, stamp in enumerate(stamp_ns.tolist()):
            last = stamps[-1] if len(stamps) > first else stamp
            if stamp < last or stamp > last + GAP * 1e9:
                first = len(stamps)
            if len(stamps) == first or stamp >= last + SPACING * 1e9:
                stamps.append(stamp)
                kept.append(row)
            while stamps[first] < stamp - LENGTH * 1e9:
                first += 1
            starts.append(first)
        stored = np.zeros(len(stamp_ns), dtype=np.intp)
        stored[kept] = 1
        end = len(self._stored.stamp_ns) + np.cumsum(stored)
        return np.array(kept, dtype=np.intp), np.array(starts, dtype=np.intp), end


def _part(window: Window, rows: slice) -> Window:
    """Some samples of a window."""
    return replace(
        window,
        stamp_ns=window.stamp_ns[rows],
        position=window.position[rows],
        forces=window.forces[rows],
    )
