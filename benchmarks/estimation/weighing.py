"""Errors and intervals of weighing over many simulated machines."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hybrid_dynamics_core.estimation import PayloadEstimate, estimate_payload
from hybrid_dynamics_core.ground.arrays import Array
from hybrid_dynamics_core.ground.progress import Progress

from .lifts import FULL_SCALE, machine, recorded

LEAST_LOAD = 200.0  # [kg]
CASES = ("with an empty run", "without")
HEAD = (
    "| | error of 95 % of lifts | rms error | intervals that hold | width, median | width, most |"
)


@dataclass(frozen=True, eq=False)
class Weighed:
    """Errors of one way to weigh.

    Attributes:
        error: (N,) estimate less truth [kg].
        interval: (N, 2) less truth [kg].
    """

    error: Array
    interval: Array

    @property
    def coverage(self) -> float:
        """Share of intervals that hold the truth."""
        low, high = self.interval.T
        return float(np.mean((low <= 0.0) & (high >= 0.0)))

    @property
    def width(self) -> Array:
        """Widths (N,) of the intervals [kg]."""
        return np.asarray(self.interval[:, 1] - self.interval[:, 0])

    def within(self, share: float) -> float:
        """The error [kg] that a share of the lifts keep."""
        return float(np.quantile(np.abs(self.error), share))


def weighed(count: int, seed: int = 0) -> dict[str, Weighed]:
    """Weigh a load on each of `count` machines, with an empty run and without."""
    rows: dict[str, list[tuple[float, float, float]]] = {case: [] for case in CASES}
    with Progress("lifts", count) as progress:
        for k in range(count):
            for case, (mass, estimate) in zip(CASES, lift(seed + k), strict=True):
                low, high = estimate.interval
                rows[case].append((estimate.mass - mass, low - mass, high - mass))
            progress.update(k + 1)
    results: dict[str, Weighed] = {}
    for case, values in rows.items():
        columns = np.array(values)
        results[case] = Weighed(columns[:, 0], columns[:, 1:])
    return results


def lift(seed: int) -> list[tuple[float, PayloadEstimate]]:
    """True mass and estimate of one machine, in the order of `CASES`."""
    rng = np.random.default_rng(seed)
    both = machine(rng)
    mass = float(rng.uniform(LEAST_LOAD, FULL_SCALE))
    loaded = recorded(both.true, rng, mass).run(both.model)
    empty = recorded(both.true, rng, 0.0).run(both.model)
    estimates = (estimate_payload(loaded, empty), estimate_payload(loaded))
    return [(mass, estimate) for estimate in estimates]


def weighing_table(results: dict[str, Weighed]) -> list[str]:
    """The table of all cases, in shares of the full scale."""
    lines = [HEAD, "|---|---|---|---|---|---|"]
    for case, result in results.items():
        rms = float(np.sqrt(np.mean(result.error**2)))
        cells = [
            _share(result.within(0.95)),
            _share(rms),
            f"{100.0 * result.coverage:.1f} %",
            _share(float(np.median(result.width))),
            _share(float(result.width.max())),
        ]
        lines.append(f"| {case} | {' | '.join(cells)} |")
    return lines


def _share(mass: float) -> str:
    return f"{mass:.1f} kg ({100.0 * mass / FULL_SCALE:.2f} %)"
