"""Chi-squared, coverage of intervals and errors of the tool, over many simulated machines."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hybrid_dynamics_core.calibration import Calibration, calibrate
from hybrid_dynamics_core.ground.arrays import Array
from hybrid_dynamics_core.ground.progress import Progress
from hybrid_dynamics_core.robot.robot import Robot

from .simulated import FREE, NOISE, TURN, measured, poses

ROWS = 40  # measured poses of each machine
CHECKED = 50  # further poses, at which the tool is compared
MILLI = 1e3
HEAD = (
    "| robot | parameters | reduced chi-squared | intervals that hold | tool before | tool after |"
)


@dataclass(frozen=True, eq=False)
class Accuracy:
    """Results of many machines of one robot.

    Attributes:
        robot: its name.
        parameters: number of parameters.
        chi2: reduced chi-squared of each machine.
        holds: whether each interval holds the truth, of all machines and parameters.
        before: error of the tool [m] with the file, rms over poses, of each machine.
        after: the same with the estimates.
    """

    robot: str
    parameters: int
    chi2: Array
    holds: Array
    before: Array
    after: Array


def accuracy(name: str, machines: int, seed: int = 0) -> Accuracy:
    """Calibrate many simulated machines of a shipped robot."""
    chi2: list[float] = []
    holds: list[bool] = []
    before: list[float] = []
    after: list[float] = []
    with Progress(name, machines) as progress:
        for k in range(machines):
            rng = np.random.default_rng(seed + k)
            data = measured(name, rng, ROWS)
            sigma = {"m": NOISE, "rad": TURN}
            result = calibrate(name, data.columns, FREE[name], sigma)
            chi2.append(result.chi2)
            holds += held(result, data.truth)
            u = poses(data.nominal, rng, CHECKED)
            before.append(apart(data.nominal, data.true, u))
            after.append(apart(Robot(result.description), data.true, u))
            progress.update(k + 1)
    sizes = np.array(chi2), np.array(holds), np.array(before), np.array(after)
    return Accuracy(name, len(FREE[name].split(",")), *sizes)


def held(result: Calibration, truth: Array) -> list[bool]:
    """Whether each interval holds the truth."""
    checks: list[bool] = []
    for one, value in zip(result.parameters.values(), truth.tolist(), strict=True):
        low, high = one.interval
        checks.append(low <= value <= high)
    return checks


def apart(one: Robot, other: Robot, u: Array) -> float:
    """Distance of two robots' tools [m], rms over poses."""
    place = one.forward_kinematics(one.close(u)).position
    true_place = other.forward_kinematics(other.close(u)).position
    squares = np.sum((place - true_place) ** 2, axis=1)
    return float(np.sqrt(squares.mean()))


def accuracy_table(results: list[Accuracy]) -> list[str]:
    """The table of all robots."""
    lines = [HEAD, "|---|---|---|---|---|---|"]
    for one in results:
        cells = [
            f"`{one.robot}`",
            f"{one.parameters}",
            f"{one.chi2.mean():.3f}",
            f"{100.0 * one.holds.mean():.1f} %",
            f"{MILLI * _rms(one.before):.2f} mm",
            f"{MILLI * _rms(one.after):.3f} mm",
        ]
        lines.append(f"| {' | '.join(cells)} |")
    chi2 = np.concatenate([one.chi2 for one in results]).mean()
    holds = np.concatenate([one.holds for one in results]).mean()
    lines.append(f"| all | | {chi2:.3f} | {100.0 * holds:.1f} % | | |")
    return lines


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
