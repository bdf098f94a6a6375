"""Calls of `robot.jax`: time to compile, a state of a batch, a step of a motion.

python -m benchmarks.jax_calls [--traced] [robot ...]     (in the root of the repository)

compile      inverse dynamics of one state by `jax.jit`, with an empty cache of kernels
derivatives  its Jacobian by u, u' and u'', likewise
batch        a state of 100,000 near the reference
scan         a step of `lax.scan`: a closed configuration from the one before, and inverse dynamics
Times are CPU time of a process for each robot, the least of some for batch and scan. With
--traced, the programs are compiled by XLA, as on a GPU.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.table import time_text
from hybrid_dynamics_core import load, shipped_robots

ROWS = 100_000
STEPS = 10_000
ROUNDS = 5
COLUMNS = ("compile", "derivatives", "batch", "scan")


def timed(call: Callable[[], Any]) -> float:
    """CPU seconds until a result of JAX is there."""
    import jax  # noqa: PLC0415  an extra

    begin = time.process_time()
    jax.block_until_ready(call())
    return time.process_time() - begin


def times(name: str, traced: bool) -> dict[str, float]:
    """Seconds by column."""
    import jax  # noqa: PLC0415  an extra

    jax.config.update("jax_enable_x64", True)
    robot = load(name)
    calls = robot.jax.traced if traced else robot.jax
    n = len(robot.active)
    u, du, ddu = robot.reference, np.full(n, 0.1), np.full(n, 0.2)

    def tau(u: Any, du: Any, ddu: Any) -> Any:
        return calls.inverse_dynamics(u, du, ddu)[0]

    def step(start: Any, u: Any) -> tuple[Any, Any]:
        efforts, _ = calls.inverse_dynamics(u, du, ddu, start=start)
        following, _ = calls.step(u, start=start)
        return following, efforts

    single = jax.jit(tau)
    slopes = jax.jit(jax.jacfwd(tau, argnums=(0, 1, 2)))
    mapped = jax.jit(jax.vmap(tau, in_axes=(0, None, None)))
    scanned = jax.jit(lambda rows: jax.lax.scan(step, calls.start, rows)[1])
    phase = np.linspace(0.0, 2.0 * np.pi, STEPS)[:, None]
    path = u + 1e-3 * np.sin(phase + np.arange(n)) - 1e-3 * np.sin(np.arange(n))
    rows = np.repeat(path, ROWS // STEPS, axis=0)
    found = {"compile": timed(lambda: single(u, du, ddu))}
    found["derivatives"] = timed(lambda: slopes(u, du, ddu))
    for column, call, count in (
        ("batch", lambda: mapped(rows, du, ddu), ROWS),
        ("scan", lambda: scanned(path), STEPS),
    ):
        timed(call)  # compiles
        found[column] = min(timed(call) for _ in range(ROUNDS)) / count
    return found


def in_own_process(name: str, traced: bool) -> dict[str, float]:
    """The same with nothing compiled before."""
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "HYBRID_DYNAMICS_CACHE": folder}
        options = ["--child", name, *(["--traced"] if traced else [])]
        command = [sys.executable, "-m", "benchmarks.jax_calls", *options]
        done = subprocess.run(  # noqa: S603  the arguments are ours
            command, env=environment, check=True, stdout=subprocess.PIPE
        )
    found: dict[str, float] = json.loads(done.stdout)
    return found


def main() -> None:
    """The table."""
    parser = argparse.ArgumentParser(description="Times of robot.jax.")
    parser.add_argument("robots", nargs="*", help="all shipped robots by default")
    parser.add_argument("--traced", action="store_true", help="programs compiled by XLA")
    parser.add_argument("--child", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.child:
        sys.stdout.write(json.dumps(times(options.child, options.traced)))
        return
    sys.stdout.write(f"| robot | {' | '.join(COLUMNS)} |\n|---|{'---:|' * len(COLUMNS)}\n")
    for name in options.robots or shipped_robots():
        found = in_own_process(name, options.traced)
        row = " | ".join(time_text(found[column]) for column in COLUMNS)
        sys.stdout.write(f"| `{name}` | {row} |\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
