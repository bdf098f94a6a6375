"""Standard deviations of measured quantities: given, or estimated from residuals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..description.expressions import evaluate
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arguments import real_number
from ..ground.suggestions import no_such_name
from .quantities import Quantity

Sigma = float | Mapping[str, float | str] | None
UNITS = ("m", "rad")
LEAST = 1e-10  # [m or rad] deviation below which residuals are rounding


@dataclass(frozen=True, eq=False)
class Noise:
    """The deviation of each component of the differences.

    Attributes:
        groups: group of each component (c,).
        names: names of the groups.
        deviations: of each group [m or rad].
        is_given: of each group, whether it is given.
    """

    groups: Array
    names: tuple[str, ...]
    deviations: Array
    is_given: tuple[bool, ...]

    @property
    def by_component(self) -> Array:
        """Deviation of each component (c,)."""
        return np.asarray(self.deviations[self.groups.astype(int)])

    def with_deviations(self, deviations: Array) -> Noise:
        """The same groups with other deviations; given ones stay."""
        is_given = np.array(self.is_given)
        merged = np.where(is_given, self.deviations, np.maximum(deviations, LEAST))
        return Noise(self.groups, self.names, merged, self.is_given)


def noise_of(quantities: Sequence[Quantity], sigma: Sigma, differences: Array) -> Noise:
    """The noise of some quantities.

    Args:
        quantities: what is measured.
        sigma: deviation of everything, or by unit (`m`, `rad`) or by quantity; None to estimate it.
        differences: model minus measurement (N, c), for a start of what is to be estimated.

    Raises:
        InputError: a deviation is not above zero, or of a quantity that is not measured.
    """
    given = _by_name(sigma, quantities)
    names: list[str] = []
    groups: list[int] = []
    units: dict[str, str] = {}
    for quantity in quantities:
        label = quantity.noise
        if quantity.name in given:
            label = quantity.name
        if label not in names:
            names.append(label)
            units[label] = quantity.unit
        groups += [names.index(label)] * quantity.size
    owners = np.array(groups)
    deviations: list[float] = []
    is_given: list[bool] = []
    for k, name in enumerate(names):
        value = given.get(name, given.get(units[name]))
        is_given.append(value is not None)
        if value is None:
            part = differences[:, owners == k]
            value = max(float(np.sqrt(np.nanmean(part * part))), LEAST)
        deviations.append(value)
    return Noise(owners, tuple(names), np.array(deviations), tuple(is_given))


def _by_name(sigma: Sigma, quantities: Sequence[Quantity]) -> dict[str, float]:
    """Deviations by unit or by quantity."""
    if sigma is None:
        return {}
    if not isinstance(sigma, Mapping):
        sigma = dict.fromkeys(UNITS, sigma)
    units = {unit: unit for unit in UNITS}
    units |= {quantity.name: quantity.unit for quantity in quantities}
    checked: dict[str, float] = {}
    for name, value in sigma.items():
        if name not in units:
            raise InputError(f"sigma: {no_such_name('quantity', name, list(units))}")
        number = _deviation(name, value, units[name])
        if not number > 0.0:
            raise InputError(f"sigma: is {number:g}; expected a deviation above zero")
        checked[name] = number
    return checked


def _deviation(name: str, value: float | str, unit: str) -> float:
    """A deviation in a unit; an expression with another unit is an InputError."""
    if not isinstance(value, str):
        return real_number(f"sigma {name}", value)
    try:
        return evaluate(value, {}, names_are="", units=(unit,))
    except (ValueError, ArithmeticError) as error:
        raise InputError(f"sigma: {name} is in {unit}: {error}") from error


def rms(values: Array) -> float:
    """Root mean square of what was measured; NaN of nothing."""
    measured = values[np.isfinite(values)]
    if not measured.size:
        return float("nan")
    squares = measured**2
    return float(np.sqrt(squares.mean()))
