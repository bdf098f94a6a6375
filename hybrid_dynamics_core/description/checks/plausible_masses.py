"""Masses that are hardly kilograms: one link that outweighs all others by far is written in grams."""

from __future__ import annotations

from statistics import median

from ..document import Document, Path_
from ..places import Places
from ..values import Numbers

MANY_TIMES = (
    500.0  # of the median of the others: grams make a link a thousand times as heavy as it is
)
# of the next heaviest: a platform on light rods and crosses is not ten times as heavy as the next
# link
NEXT = 50.0
OTHERS = 2  # links with a mass that there have to be beside it


def doubt_masses(document: Document, numbers: Numbers, places: Places, base: str) -> None:
    """Note the heaviest moving link where it has more than `MANY_TIMES` the median mass of the others, and `NEXT`.

    What is fixed to the base is left out: foundations are as heavy as they like.
    """
    found: list[tuple[float, Path_]] = []
    for name, entry in document.data["links"].items():
        path: Path_ = ("links", name, "mass")
        mass = numbers.number((entry or {}).get("mass", 0), path)
        if mass > 0.0 and places.place(name)[0] != base:
            found.append((mass, path))
    if len(found) <= OTHERS:
        return
    *others, (mass, path) = sorted(found, key=lambda part: part[0])
    usual = median(other for other, _ in others)
    if mass > MANY_TIMES * usual and mass > NEXT * others[-1][0]:
        told = (
            f"{mass:.4g} kg, and the median of the other links is {usual:.3g} kg: are these grams?"
        )
        document.doubt(
            path, f"{told} Masses are in kilograms: {mass:.4g} g are written {mass / 1000.0:.4g}"
        )
