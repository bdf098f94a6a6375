"""The C export of a problem, in a loop of the classical Runge-Kutta method."""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
import time
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core import ClosedState
from hybrid_dynamics_core.export import to_c

from .solve import Solver

Array = NDArray[np.float64]
FLAGS = ("-std=c99", "-O3", "-march=native", "-fno-math-errno", "-fPIC", "-shared")
LOOP = Path(__file__).with_name("exported.c")


class Exported:
    """The forward dynamics of a problem as machine code.

    Raises:
        OSError: there is no C compiler, or it fails.
    """

    def __init__(self, solver: Solver) -> None:
        self.solver = solver
        with tempfile.TemporaryDirectory(prefix="exported") as folder:
            self._library = ctypes.CDLL(str(_compiled(solver, Path(folder))))

    @cached_property
    def _start(self) -> Array:
        start = self.solver.start
        return np.concatenate([start.u, start.du])

    def rows(self, inner: int) -> tuple[float, Array]:
        """CPU time [s] and rows (u, u') at the output steps.

        Args:
            inner: steps between two output steps.

        Raises:
            RuntimeError: the motion ends early.
        """
        problem = self.solver.problem
        rows = np.zeros((problem.samples + 1, len(self._start)))
        rows[0] = self._start
        guess = np.array(self.solver.start.s)
        tau = np.array(problem.tau or np.zeros(len(self._start) // 2))
        step = problem.end / problem.samples / inner
        arrays = [values.ctypes.data_as(ctypes.c_void_p) for values in (tau, guess, rows)]
        begin = time.process_time()
        status = self._library.run(
            arrays[0], problem.samples, inner, ctypes.c_double(step), *arrays[1:]
        )
        seconds = time.process_time() - begin
        if status:
            raise RuntimeError(f"{problem.title}: status {status}")
        return seconds, rows

    def states(self, rows: Array) -> ClosedState:
        """The closed states of such rows, each near the one before."""
        n = rows.shape[1] // 2
        return self.solver.robot.close_path(rows[:, :n], rows[:, n:], near=self.solver.start)


def _compiled(solver: Solver, folder: Path) -> Path:
    """The shared library."""
    robot = solver.robot
    for name, text in to_c(robot, ["forward_dynamics"]).items():
        (folder / name).write_text(text, encoding="utf-8")
    loop = folder / "loop.c"
    source = LOOP.read_text(encoding="utf-8")
    loop.write_text(f'#include "{robot.name}.h"\n{source}', encoding="utf-8")
    library = folder / "loop.so"
    words = ["cc", *FLAGS, f"-DROBOT={robot.name}", str(loop), str(folder / f"{robot.name}.c")]
    words += ["-lm", "-o", str(library)]
    done = subprocess.run(words, capture_output=True, text=True, check=False)  # noqa: S603
    if done.returncode:
        raise OSError(done.stderr)
    return library
