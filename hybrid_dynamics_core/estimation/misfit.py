"""Efforts that no load explains: another unit, exchanged chambers, a wrong machine."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from ..dynamics.pressure_check import exchanged_text, fits_exchanged
from ..ground.arrays import Array
from .equations import Blocks, Equations
from .fit import System, solved
from .run import MeasuredRun
from .sensors import SensorError
from .unknowns import Unknowns

FAINT = 2e-3  # measured over required efforts, below which the unit is another
COARSE = 0.02  # noise of this comparison, as a share of the efforts
UNITS = {1e-5: "bar", 1e-6: "MPa", 1e-3: "kPa or kN"}  # by their numbers over those in SI units
GOOD_FIT = 0.2  # share of the squares that this noise leaves: a fit below it is not doubted
BAD = 0.1  # share of a drive's efforts: if the fit leaves more, there is another fault
SURE = 2.0  # deviations by which a place is surely outside
FARTHEST = 3.0  # expected deviations, beyond which no load is
LEAST_SHARE = 1e-2  # of the largest effort, as which the efforts of a weak drive count


def check_fit(
    runs: Sequence[MeasuredRun],
    equations: Sequence[Equations],
    blocks: Sequence[Blocks],
    unknowns: Unknowns,
) -> None:
    """Raise SensorError for efforts in another unit, or exchanged chambers.

    Args:
        runs: runs with measured efforts; the first one may carry the load.
        equations: equations of each run.
        blocks: their means.
        unknowns: the unknowns, with their deviations.
    """
    for run, equation, means in zip(runs, equations, blocks, strict=True):
        check_units(run, equation)
        _check_chambers(run, means, unknowns)


def check_units(run: MeasuredRun, equation: Equations) -> None:
    """Raise SensorError if a cylinder's efforts are far below those of the model without load."""
    measured = np.sqrt(np.mean(run.efforts**2, axis=0))
    required = np.sqrt(np.mean(equation.required**2, axis=0))
    for name, effort, needed in zip(run.drives, measured.tolist(), required.tolist(), strict=True):
        if name not in run.robot.cylinders or effort > FAINT * needed:
            continue
        ratio = max(effort / max(needed, 1e-300), 1e-300)
        nearest = min(UNITS, key=lambda factor: abs(np.log10(ratio / factor)))
        raise SensorError(
            f"{name}: its pressures or effort give {effort:.3g} N, where the model without load"
            f" needs {needed:.3g} N; they seem to be in {UNITS[nearest]}: name the unit, as"
            f" `{name}.cap_pressure [bar]`"
        )


def _check_chambers(run: MeasuredRun, blocks: Blocks, unknowns: Unknowns) -> None:
    """Raise SensorError if efforts fit better with exchanged chambers."""
    names = [name for name in run.drives if name in run.exchanged]
    size = np.sqrt(np.mean(run.efforts**2, axis=0))
    noise = COARSE * np.maximum(size, 1e-3 * size.max()) + 1e-12
    changes = {}  # (B,) of the target by cylinder
    for name in names:
        k = run.drives.index(name)
        changes[name] = blocks.means(run.exchanged[name] - run.efforts[:, k])

    def cost(exchanged: tuple[str, ...]) -> float:
        """What a fit leaves if the chambers of some cylinders are exchanged."""
        target = blocks.target.copy()
        for name in exchanged:
            target[:, run.drives.index(name)] += changes[name]
        return solved(_system(blocks.matrix, target, unknowns, noise), noise).cost

    as_given = cost(())
    if as_given < blocks.target.size * GOOD_FIT:
        return
    costs: dict[tuple[str, ...], float] = {}
    for count in range(1, len(names) + 1):
        for exchanged in combinations(names, count):
            costs[exchanged] = cost(exchanged)
    best = min(costs, key=lambda exchanged: costs[exchanged], default=())
    if best and fits_exchanged(as_given, costs[best]):
        raise exchanged_chambers(best)


def exchanged_chambers(cylinders: tuple[str, ...]) -> SensorError:
    """The error for cylinders whose cap and rod pressures are exchanged."""
    return SensorError(
        f"{exchanged_text(cylinders)}; exchange the columns cap_pressure and rod_pressure"
    )


def _system(matrix: Array, target: Array, unknowns: Unknowns, noise: Array) -> System:
    """The system of one run (B, k, p), (B, k) with a noise (k,); all unknowns are expected zero."""
    mean = np.zeros(len(unknowns.deviation))
    run = np.zeros(len(target))
    return System(matrix, target, mean, unknowns.deviation, noise, run)


def check_result(
    run: MeasuredRun, noise: Array, mass: float, deviation: float, limit: float
) -> None:
    """Raise SensorError if the fit leaves too much, or the mass is below zero.

    Args:
        run: the run with the load.
        noise: (k,) what the fit leaves of each effort [N m, N].
        mass: estimated mass [kg].
        deviation: its standard deviation [kg].
        limit: how many deviations below zero are no chance.
    """
    size = np.sqrt(np.mean(run.efforts**2, axis=0))
    compared = np.maximum(size, LEAST_SHARE * size.max())
    worst = int(np.argmax(noise / compared))
    if noise[worst] > BAD * compared[worst]:
        raise SensorError(
            f"{run.drives[worst]}: no load explains its efforts: {noise[worst]:.3g} of"
            f" {size[worst]:.3g} are left; is a sensor stuck, or is this another machine than"
            f" {run.robot.name}?"
        )
    if mass < -limit * deviation:
        raise SensorError(
            f"the efforts give a load of {mass:.4g} kg, below zero: the tool is lighter than in the"
            " description, or a sensor is off; a run of the empty tool shows by how much"
        )


def check_place(run: MeasuredRun, com: Array, deviation: Array, reach: float) -> None:
    """Raise SensorError for a centre of mass where no tool carries a load.

    A cylinder with exchanged chambers may be explained by such a place, and by nothing else.

    Args:
        run: the run with the load.
        com: (3,) estimated centre of mass in the frame of the load [m].
        deviation: (3,) its standard deviation [m].
        reach: deviation that was expected before the measurement [m].
    """
    outside = np.abs(com) - SURE * deviation
    if outside.max() > FARTHEST * reach:
        place = ", ".join(f"{value:.2f}" for value in com.tolist())
        raise SensorError(
            f"the efforts put the load's centre of mass at ({place}) m in its frame, where"
            f" {run.robot.name} carries none; are the chambers of one cylinder exchanged?"
        )
