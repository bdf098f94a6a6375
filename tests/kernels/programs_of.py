"""Kernels of every program of every robot on both backends, and the programs run on floats."""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import numpy as np

from hybrid_dynamics_core import ClosedState, programs
from hybrid_dynamics_core.kernels import native
from hybrid_dynamics_core.kernels.run import Kernel
from hybrid_dynamics_core.kernels.trace import flatten
from hybrid_dynamics_core.programs import Program
from tests.robots import robot

BACKENDS = ("python",) if native.reason_against() else ("python", "native")
PROGRAMS = (
    "close",
    "motion",
    "accelerations",
    "pose",
    "jacobian",
    "both",
    "inverse",
    "closed",
    "minimal",
    "forward",
)


@cache
def program(name: str, which: str) -> Program:
    frame = robot(name)._model.frame(None)
    return {
        "close": programs.CLOSE,
        "motion": programs.MOTION,
        "accelerations": programs.ACCELERATIONS,
        "pose": programs.forward_kinematics(frame),
        "jacobian": programs.jacobian(frame),
        "both": programs.pose_and_jacobian(frame),
        "inverse": programs.inverse_dynamics(),
        "closed": programs.closed_inverse_dynamics(),
        "minimal": programs.minimal_form(),
        "forward": programs.forward_dynamics(),
    }[which]


@cache
def kernel(name: str, which: str, backend: str) -> Kernel:
    made = robot(name).kernel(f"test {which}", program(name, which))
    return Kernel(made._program, made._sizes, backend)


def inputs(name: str, which: str, state: ClosedState, seed: int) -> list[np.ndarray]:
    """Inputs of a program at a state; accelerations and efforts at random."""
    machine = robot(name)
    rng = np.random.default_rng(seed)
    n = len(machine.active)
    values = {
        "u": state.u,
        "du": state.du,
        "ddu": rng.uniform(-1.0, 1.0, n),
        "tau": rng.uniform(-50.0, 50.0, n),
        "branch": state.signs,
        "guess": state.s,
        "gravity": machine.description.gravity,
    }
    return [np.array(values[key]) for key in program(name, which).inputs]


def plain(name: str, which: str, arguments: list[np.ndarray]) -> tuple[list[float], int]:
    """Flat outputs and status of the program run on floats, no graph between."""
    results = kernel(name, which, BACKENDS[0])._program(*(a.tolist() for a in arguments))
    values = [float(v) for output in results.outputs.values() for v in flatten(output)]
    failed = (check.code for check in results.checks if not check.value > check.threshold)
    return values, next(failed, 0)


def split(
    flat: list[float], layout: tuple[tuple[str, tuple[int, ...]], ...]
) -> dict[str, np.ndarray]:
    sizes = [int(np.prod(shape)) for _, shape in layout]
    places = pairwise(np.cumsum([0, *sizes]))
    return {
        n: np.reshape(flat[a:b], shape) for (n, shape), (a, b) in zip(layout, places, strict=True)
    }


def worst(found: dict[str, np.ndarray], expected: dict[str, np.ndarray]) -> float:
    """Largest error relative to the largest value of its kind; iterations do not count."""
    errors = [0.0]
    for key, value in expected.items():
        if key != "iterations" and value.size:
            errors.append(float(np.abs(found[key] - value).max() / max(np.abs(value).max(), 1.0)))
    return max(errors)
