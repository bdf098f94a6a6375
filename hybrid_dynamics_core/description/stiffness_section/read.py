"""Reader of the section `stiffness` of a description file."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

from ...algebra.live import plain
from ...errors import InputError
from ...ground.arrays import Array
from ...ground.suggestions import no_such_name
from ..elasticity import (
    Beam,
    Bearing,
    Belt,
    DriveStiffness,
    Elasticity,
    LinkMatrix,
    OilColumn,
    Section,
    box_section,
    tube_section,
)
from ..elasticity.beams import Place
from ..elasticity.supports import CHAMBERS, DIRECTIONS
from ..entries import Entry, section_entry
from ..model import RobotDescription
from ..values import ValueReader, read_each

Made = TypeVar("Made")
WORDS = {"rigid": math.inf, "free": 0.0}
LINKS = ("E", "beams", "matrix")
SECTIONS = ("section", "tube", "box")


def read_stiffness(values: ValueReader, robot: RobotDescription) -> Elasticity:
    """What of a robot is elastic.

    Args:
        values: reader of the values of a validated document.
        robot: the robot without it.

    Raises:
        DescriptionError: a name is unknown, a number is not above zero, or a matrix is not
            symmetric or indefinite.
    """
    top = section_entry(values, "stiffness")
    drives, pins, links = (top.sub(key) for key in ("drives", "pins", "links"))
    closures = [closure.name for closure in robot.closures]
    _require(drives, "joint or transmission", [*robot.joints, *robot.transmissions])
    _require(pins, "joint or closure", [*robot.joints, *closures])
    _require(links, "link", [robot.base, *robot.links])
    return Elasticity(
        drives={name: _drive(drives, name) for name in drives},
        pins={name: _made(pins.sub(name), _bearing) for name in pins},
        links={name: _link(links.sub(name)) for name in links},
    )


def _require(section: Entry, kind: str, existing: list[str]) -> None:
    """Raise at the first name that is not there."""
    for name in section:
        if name not in existing:
            raise section.error(name, no_such_name(kind, name, existing))


def _made(entry: Entry, make: Callable[[Entry], Made]) -> Made:
    """What an entry makes; an error of its numbers is one of the file."""
    try:
        return make(entry)
    except InputError as error:
        raise entry.values.document.error(entry.path, str(error)) from error


def _number(entry: Entry, key: str) -> float:
    """A plain number of a key, of which no derivatives are taken."""
    return float(plain(np.array(entry.values.number_or_infinity(entry[key], entry.key_path(key)))))


def _numbers(entry: Entry, key: str) -> Array:
    return np.asarray(plain(entry.vector(key)), dtype=float)


# -- drives


def _drive(drives: Entry, name: str) -> DriveStiffness:
    if isinstance(drives[name], dict):
        return _made(drives.sub(name), _springs)
    return _made(drives, lambda entry: DriveStiffness(_number(entry, name)))


def _springs(entry: Entry) -> DriveStiffness:
    """Springs in series."""
    stiffness = math.inf
    if "stiffness" in entry:
        stiffness = _number(entry, "stiffness")
    oil = belt = None
    if "oil" in entry:
        oil = _made(entry.sub("oil"), _oil)
    if "belt" in entry:
        belt = _made(entry.sub("belt"), _belt)
    return DriveStiffness(stiffness, oil, belt)


def _oil(entry: Entry) -> OilColumn:
    cap, rod = 0.0, 0.0
    if "dead_volume" in entry:
        cap, rod = _numbers(entry, "dead_volume").tolist()
    chambers = entry.get("chambers", CHAMBERS[0])
    return OilColumn(_number(entry, "bulk_modulus"), (cap, rod), chambers)


def _belt(entry: Entry) -> Belt:
    radius = None
    if "radius" in entry:
        radius = _number(entry, "radius")
    spans = tuple(_numbers(entry, "spans").tolist())
    return Belt(_number(entry, "tensile_stiffness"), spans, radius)


# -- pins


def _bearing(entry: Entry) -> Bearing:
    numbers: dict[str, float] = {}
    for key in DIRECTIONS:
        if entry.get(key) in WORDS:
            numbers[key] = WORDS[entry[key]]
        elif key in entry:
            numbers[key] = _number(entry, key)
            if not numbers[key] > 0.0:
                problem = f"is {numbers[key]:g}; expected a stiffness above zero, `rigid` or `free`"
                raise entry.error(key, problem)
    matrix = None
    if "matrix" in entry:
        matrix = _matrix(entry)
    return Bearing(**numbers, matrix=matrix)


def _matrix(entry: Entry) -> Array:
    """A matrix (6, 6)."""
    rows = read_each(entry.values.vector, entry["matrix"], entry.key_path("matrix"))
    return np.asarray(plain(np.array(rows)), dtype=float)


# -- links


def _link(entry: Entry) -> LinkMatrix | tuple[Beam, ...]:
    given = [form for form in LINKS if form in entry]
    if len(given) != 1:
        raise entry.values.document.error(
            entry.path,
            f"gives {', '.join(given) or 'nothing'}; expected one beam with E, G and `to`, or"
            " `beams`, or `matrix`",
        )
    if given == ["matrix"]:
        return _made(entry, _link_matrix)
    if given == ["E"]:
        return (_made(entry, _beam),)
    rows = entry["beams"]
    path = entry.key_path("beams")
    beams = [Entry(entry.values, row, (*path, k)) for k, row in enumerate(rows)]
    return tuple(_made(beam, _beam) for beam in beams)


def _link_matrix(entry: Entry) -> LinkMatrix:
    if "at" not in entry:
        return LinkMatrix(_matrix(entry))
    return LinkMatrix(_matrix(entry), _place(entry, "at"))


def _beam(entry: Entry) -> Beam:
    fields: dict[str, Any] = {}
    if "start" in entry:
        fields["start"] = _place(entry, "start")
    if "z" in entry:
        fields["z"] = plain(entry.axis("z"))
    missing = [key for key in ("G", "to") if key not in entry]
    if missing:
        raise entry.values.document.error(
            entry.path, f"has no {missing[0]}; expected a beam with E, G and `to`"
        )
    return Beam(
        E=_number(entry, "E"),
        G=_number(entry, "G"),
        section=_section(entry),
        to=_place(entry, "to"),
        **fields,
    )


def _section(entry: Entry) -> Section:
    """The section of a beam, in one of three forms."""
    given = [form for form in SECTIONS if form in entry]
    if len(given) != 1:
        names = ", ".join(given) or "none"
        raise entry.values.document.error(
            entry.path, f"gives {names} of {', '.join(SECTIONS)}; expected one of them"
        )
    part = entry.sub(given[0])
    makers: dict[str, Callable[..., Section]] = {
        "section": Section,
        "tube": tube_section,
        "box": box_section,
    }
    numbers = {key: _number(part, key) for key in part}
    return _made(part, lambda _: makers[given[0]](**numbers))


def _place(entry: Entry, key: str) -> Place:
    """A name on the link, or a point (3,) [m]."""
    if isinstance(entry[key], str):
        return str(entry[key])
    return _numbers(entry, key)
