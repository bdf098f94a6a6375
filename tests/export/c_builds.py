"""C code of robots, built with the compiler of the machine and called through ctypes."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from hybrid_dynamics_core import ClosedState, Robot
from hybrid_dynamics_core.export import to_c
from hybrid_dynamics_core.formats.c.names import identifier

WARNINGS = ("-Wall", "-Wextra", "-Werror", "-pedantic", "-Wconversion")
needs_compiler = pytest.mark.skipif(shutil.which("gcc") is None, reason="there is no gcc")
Values = np.ndarray


def run(folder: Path, *words: str) -> str:
    """Run a command; its output."""
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{' '.join(words)}\n{done.stdout}{done.stderr}"
    return done.stdout


@dataclass
class Built:
    """A robot with its C code and a shared library of it."""

    robot: Robot
    folder: Path
    prefix: str
    library: ctypes.CDLL

    def call(self, name: str, inputs: Sequence[Values], sizes: Sequence[int]) -> Answer:
        """Call a function: inputs, the last one the guess, which is copied; sizes of outputs."""
        *given, guess = [np.array(x, dtype=float) for x in inputs]
        outs = [np.full(size, 7.0) for size in sizes]
        pointers = [x.ctypes.data_as(ctypes.c_void_p) for x in (*given, guess, *outs)]
        status = getattr(self.library, f"{self.prefix}_{name}")(*pointers)
        return Answer(status, guess, outs)

    def call_without_guess(
        self, name: str, inputs: Sequence[Values], sizes: Sequence[int]
    ) -> Answer:
        """Call a function with NULL as the guess."""
        given = [np.array(x, dtype=float) for x in inputs]
        outs = [np.full(size, 7.0) for size in sizes]
        pointers = [x.ctypes.data_as(ctypes.c_void_p) for x in (*given, *outs)]
        pointers.insert(len(given), ctypes.c_void_p(None))
        status = getattr(self.library, f"{self.prefix}_{name}")(*pointers)
        return Answer(status, np.zeros(0), outs)

    def may_lack_guess(self, name: str) -> bool:
        """Whether the header says that the guess of a function may be NULL."""
        header = (self.folder / f"{self.prefix}.h").read_text(encoding="utf-8")
        comment = header[: header.index(f"int {self.prefix}_{name}(")].rpartition("/*")[2]
        return "guess may be NULL" in comment


@dataclass
class Answer:
    """What a function did."""

    status: int
    guess: Values
    outs: list[Values]

    def is_untouched(self, guess: Values) -> bool:
        same = np.array_equal(self.guess, guess, equal_nan=True)
        return same and all((out == 7.0).all() for out in self.outs)


def build(
    robot: Robot,
    folder: Path,
    programs: Sequence[str] | None = None,
    *,
    fast: bool = False,
    **options: str,
) -> Built:
    """Write, compile without a warning, and load; fast: compile fast, without optimisation."""
    prefix = identifier(robot.name)
    for name, text in to_c(robot, programs, **options).items():
        (folder / name).write_text(text, encoding="utf-8")
    source = f"{prefix}.c"
    flags = ("-std=c99", *WARNINGS, "-O0" if fast else "-O1", "-fPIC")
    run(folder, "gcc", *flags, "-c", source, "-o", "model.o")
    run(folder, "gcc", *flags, "model.o", "test_vectors.c", "-lm", "-o", "test_vectors")
    run(folder, "gcc", "-shared", "model.o", "-lm", "-o", "model.so")
    return Built(robot, folder, prefix, ctypes.CDLL(str(folder / "model.so")))


def states(robot: Robot, count: int, seed: int = 0) -> tuple[ClosedState, ClosedState]:
    """Closed states, and regular ones a millisecond from them."""
    rng = np.random.default_rng(seed)
    n = len(robot.active)
    reach = 0.25
    for _ in range(20):
        lower = np.maximum(robot.limits[:, 0], robot.reference - reach)
        upper = np.minimum(robot.limits[:, 1], robot.reference + reach)
        u = lower + rng.uniform(0.05, 0.95, (2 * count, n)) * (upper - lower)
        near = robot.close(u, check=False)
        good = np.flatnonzero((near.status == 0) & (near.singularity > 0.05))[:count]
        if len(good) == count:
            near = robot.close(u[good])
            moved = u[good] + 1e-3 * rng.uniform(-1.0, 1.0, (count, n))
            return near, robot.close(moved, rng.uniform(-1.0, 1.0, (count, n)), near=near)
        reach *= 0.7
    raise AssertionError(f"{robot.name}: no {count} states close")


def results(
    robot: Robot, state: ClosedState, seed: int
) -> Mapping[str, tuple[list[Values], list[Values]]]:
    """Inputs (N, size) and outputs (N, ...) of every function, by the library."""
    rng = np.random.default_rng(seed)
    ddu, tau = rng.uniform(-1.0, 1.0, (2, *state.u.shape))
    gravity = rng.uniform(-10.0, 10.0, 3)
    loads = replace(robot.loads, gravity=gravity)
    u, du = state.u, state.du
    g = np.tile(gravity, (len(u), 1))
    pose = robot.forward_kinematics(state)
    answers = {
        "close": ([u, du], [state.s, state.ds]),
        "inverse_dynamics": ([u, du, ddu, g], [robot.inverse_dynamics(state, ddu, loads)]),
        "minimal_form": ([u, du, g], list(robot.minimal_form(state, loads))),
        "forward_kinematics": ([u], [pose.position, pose.rotation]),
        "jacobian": ([u], [robot.jacobian(state)]),
    }
    if any(link.mass for link in robot.description.links.values()):
        moved = robot.forward_dynamics(state, tau, loads)
        answers["forward_dynamics"] = ([u, du, tau, g], [moved])
    return answers
