"""Errors of the force at the tool over many simulated machines."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hybrid_dynamics_core import Loads, Robot
from hybrid_dynamics_core.estimation import ToolForce, tool_force
from hybrid_dynamics_core.ground.arrays import Array
from hybrid_dynamics_core.ground.progress import Progress

from .lifts import Motion, machine, measured, moved, recorded

CASES = ("with an empty run", "without")
SIZES = {"2 kN": (2e3, 2e3), "10 kN": (1e4, 1e4), "20 to 80 kN": (2e4, 8e4)}  # [N]
TIMES = (3.5, 4.5, 9.5, 10.5)  # [s] at which the force rises, is full, falls, ends
WAVE = 0.2  # share of the force that varies
FREQUENCY = 0.4  # [Hz] of this variation
SETTLED = 0.3  # [s] around changes in which contact is not judged
HEAD = (
    "| force | | size, 95 % of samples | direction, 95 % | error, rms | contact found"
    " | false contact |"
)


@dataclass(frozen=True, eq=False)
class Judged:
    """Errors of one run, while the force is full.

    Attributes:
        size: errors (N,) of the size, as a share.
        angle: errors (N,) of the direction [rad].
        error: sizes (N,) of the error [N].
        detected: share of samples with contact, of those with full force.
        alarmed: likewise of those without force.
    """

    size: Array
    angle: Array
    error: Array
    detected: float
    alarmed: float


def pushed(count: int, seed: int = 0) -> dict[tuple[str, str], list[Judged]]:
    """Forces on `count` machines, of each size, with an empty run and without."""
    results: dict[tuple[str, str], list[Judged]] = {}
    with Progress("forces", count) as progress:
        for k in range(count):
            for name, judged in push(seed + k).items():
                results.setdefault(name, []).append(judged)
            progress.update(k + 1)
    return results


def push(seed: int) -> dict[tuple[str, str], Judged]:
    """Errors on one machine, by size and case."""
    rng = np.random.default_rng(seed)
    both = machine(rng)
    empty = recorded(both.true, rng, 0.0).run(both.model)
    judged: dict[tuple[str, str], Judged] = {}
    for name, (least, most) in SIZES.items():
        motion = moved(both.true, rng)
        force = _force(rng, motion.time, float(rng.uniform(least, most)))
        while not _is_held(both.true, motion, force):
            force = _force(rng, motion.time, float(rng.uniform(least, most)))
        loads = _with(both.true, force)
        run = measured(both.true, rng, motion, loads).run(both.model)
        for case, zero in zip(CASES, (empty, None), strict=True):
            judged[name, case] = _judged(motion, force, tool_force(run, zero))
    return judged


def _with(robot: Robot, force: Array) -> Loads:
    """Loads with a force (N, 3) on the tool, in its axes."""
    wrench = np.concatenate([force, np.zeros_like(force)], axis=1)
    return robot.loads.with_wrench(wrench, axes="frame")


def _is_held(robot: Robot, motion: Motion, force: Array) -> bool:
    """Whether the cylinders can push so hard."""
    tau = robot.inverse_dynamics(motion.state, motion.goal.ddu, _with(robot, force))
    forces = robot.drive_forces(motion.state, tau)
    for name in robot.cylinders:
        lower, upper = robot.effort_ranges[name]
        if forces[name].min() < lower or forces[name].max() > upper:
            return False
    return True


def _force(rng: np.random.Generator, time: Array, size: float) -> Array:
    """A force (N, 3) in the plane of the arm, of a size that rises, varies and falls."""
    share = np.interp(time, TIMES, [0.0, 1.0, 1.0, 0.0])
    share = share * share * (3.0 - 2.0 * share)
    phase = rng.uniform(0.0, 2.0 * np.pi)
    share = share * (1.0 + WAVE * np.sin(2.0 * np.pi * FREQUENCY * time + phase))
    angle = rng.uniform(0.0, 2.0 * np.pi) + 0.3 * np.sin(0.5 * time)
    direction = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1)
    return np.asarray(size * share[:, None] * direction)


def _judged(motion: Motion, force: Array, answer: ToolForce) -> Judged:
    """Errors of an answer, against the true force (N, 3)."""
    time = motion.time
    rise, full, fall, end = TIMES
    is_full = (time >= full) & (time <= fall)
    is_free = (time < rise - SETTLED) | (time > end + SETTLED)
    is_free = is_free & answer.is_ready
    wanted, got = force[is_full], answer.visible_part[is_full, :3]
    length, answered = np.linalg.norm(wanted, axis=1), np.linalg.norm(got, axis=1)
    cosine = (wanted * got).sum(axis=1) / (length * answered)
    return Judged(
        size=np.abs(answered / length - 1.0),
        angle=np.arccos(np.clip(cosine, -1.0, 1.0)),
        error=np.linalg.norm(got - wanted, axis=1),
        detected=float(answer.contact[is_full].mean()),
        alarmed=float(answer.contact[is_free].mean()),
    )


def force_table(results: dict[tuple[str, str], list[Judged]]) -> list[str]:
    """The table of all cases."""
    lines = [HEAD, "|---|---|---|---|---|---|---|"]
    for (name, case), runs in results.items():
        size = np.concatenate([run.size for run in runs])
        angle = np.concatenate([run.angle for run in runs])
        error = np.concatenate([run.error for run in runs])
        detected = float(np.mean([run.detected for run in runs]))
        alarmed = float(np.mean([run.alarmed for run in runs]))
        cells = [
            f"{100.0 * float(np.quantile(size, 0.95)):.1f} %",
            f"{np.rad2deg(float(np.quantile(angle, 0.95))):.1f} deg",
            f"{float(np.sqrt(np.mean(error**2))):.0f} N",
            f"{100.0 * detected:.1f} %",
            f"{100.0 * alarmed:.2f} %",
        ]
        lines.append(f"| {name} | {case} | {' | '.join(cells)} |")
    return lines
