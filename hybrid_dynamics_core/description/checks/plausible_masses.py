"""Warnings of masses in grams: one link outweighs all others by far."""

from __future__ import annotations

from statistics import median

from ..document import KeyPath
from ..entries import section_entries
from ..model import RobotDescription
from ..values import ValueReader

# A mass in grams is a thousand times too large.
MEDIAN_RATIO = 500.0  # of the heaviest link to the median of the others
# Even a platform on light rods is less than ten times as heavy as the next link.
NEXT_RATIO = 50.0  # of the heaviest link to the next heaviest
_MIN_OTHERS = 2  # least number of other links with a mass, to compare with


def warn_of_masses(values: ValueReader, robot: RobotDescription) -> None:
    """Warn of the heaviest moving link if it outweighs the others by far.

    Links fixed to the base are not compared, since a foundation may have any mass.
    """
    masses = _moving_masses(values, robot)
    masses.sort(key=lambda item: item[0])
    if len(masses) <= _MIN_OTHERS:
        return
    *others, (mass, path) = masses
    typical = median(other for other, _ in others)
    next_heaviest, _ = others[-1]
    if mass <= MEDIAN_RATIO * typical or mass <= NEXT_RATIO * next_heaviest:
        return
    values.document.warn(
        path,
        f"{mass:.4g} kg, and the median of the other links is {typical:.3g} kg: are these grams?"
        f" Masses are in kilograms: {mass:.4g} g are written {mass / 1000.0:.4g}",
    )


def _moving_masses(values: ValueReader, robot: RobotDescription) -> list[tuple[float, KeyPath]]:
    """Masses of links that move, and where they are written."""
    masses: list[tuple[float, KeyPath]] = []
    for name, link in section_entries(values, "links").items():
        mass = link.number("mass")
        body = name
        if name in robot.parts:
            body = robot.body_of(name)
        if mass > 0.0 and body != robot.base:
            masses.append((mass, link.key_path("mass")))
    return masses
