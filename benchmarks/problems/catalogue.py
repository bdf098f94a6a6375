"""The problems: description, motion, what is measured, and the accuracy asked."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core import Robot, load

from . import closed_references, references
from .observed import Observed

Array = NDArray[np.float64]
ROBOTS = Path(__file__).parent / "robots"
HIGH = 1e-3  # asked by the specification of A02, its high precision
DRIFT = 5e-7  # [J] a hundredth of what the library allows A01, as kept with Exudyn
THRESHOLD = 1e-3  # below it an error counts absolutely, as in that specification


@dataclass(frozen=True)
class Problem:
    """A problem and its reference.

    Attributes:
        name: file name of the description, without ending.
        title: in the table.
        rates: active rates at the start.
        end: duration [s].
        samples: output steps.
        observed: what is compared.
        reference: times to such rows.
        source: of the reference.
        asked: largest relative error allowed.
        tau: constant efforts; None for none.
    """

    name: str
    title: str
    rates: tuple[float, ...]
    end: float
    samples: int
    observed: Observed
    reference: Callable[[Array], Array]
    source: str
    asked: float = HIGH
    tau: tuple[float, ...] | None = None

    def robot(self) -> Robot:
        """The model."""
        return load(ROBOTS / f"{self.name}.yaml")


def error(values: Array, reference: Array) -> float:
    """Largest relative error of all samples and columns, which no mean of them exceeds."""
    scale = np.maximum(np.abs(reference), THRESHOLD)
    return float(np.max(np.abs(values - reference) / scale))


ANDREWS = {  # [rad] at 0.03 s
    "beta": 15.81077119629904,
    "theta": -15.75637105984298,
    "gamma": 0.04082224013073101,
    "phi": -0.5347301163226948,
    "delta": 0.5244099658805304,
    "Omega": 0.5347301163226948,
    "epsilon": 1.048080741042263,
}


def _andrews(_: Array) -> Array:
    return np.array([list(ANDREWS.values())])


def _four_bars(count: int) -> Problem:
    return Problem(
        name=f"four_bars_{count}",
        title=f"A02 {count} four-bars",
        rates=(-1.0,),
        end=20.0,
        samples=400,
        observed=Observed(),
        reference=partial(references.four_bars, count=count),
        source="elliptic functions",
    )


PROBLEMS = (
    Problem(
        name="pendulum",
        title="A01 pendulum",
        rates=(0.0,),
        end=10.0,
        samples=400,
        observed=Observed(),
        reference=references.pendulum,
        source="elliptic functions",
    ),
    _four_bars(1),
    _four_bars(2),
    _four_bars(10),
    _four_bars(40),
    Problem(
        name="andrews",
        title="A03 Andrews' squeezer",
        rates=(0.0,),
        end=0.03,
        samples=30,
        observed=Observed(tuple(ANDREWS), at_end=True),
        reference=_andrews,
        source="test set of Mazzia and Magherini",
        tau=(0.033,),
    ),
    Problem(
        name="bricard",
        title="A04 Bricard",
        rates=(0.0,),
        end=10.0,
        samples=400,
        observed=Observed(),
        reference=closed_references.bricard,
        source="equations by hand",
    ),
    Problem(
        name="rectangular_bricard",
        title="rectangular Bricard",
        rates=(0.0,),
        end=10.0,
        samples=400,
        observed=Observed(),
        reference=closed_references.rectangular_bricard,
        source="equations by hand",
    ),
    Problem(
        name="diagonal_spring",
        title="four-bar with a diagonal spring",
        rates=(0.0,),
        end=10.0,
        samples=400,
        observed=Observed(),
        reference=closed_references.diagonal_spring,
        source="equations by hand",
    ),
    Problem(
        name="flyball_governor",
        title="A05 flyball governor",
        rates=(2.0 * np.pi, 0.0, 0.0, 0.0),
        end=10.0,
        samples=400,
        observed=Observed(("s",)),
        reference=references.flyball_governor,
        source="equations by hand",
    ),
    Problem(
        name="slider_crank",
        title="spatial slider-crank",
        rates=(6.0,),
        end=5.0,
        samples=500,
        observed=Observed(axes=(0,)),
        reference=references.slider_crank,
        source="equations by hand",
    ),
)
