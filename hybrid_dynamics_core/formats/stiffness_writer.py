"""The section `stiffness` of a description file, from what of a robot is elastic."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

from ..description.document import Data
from ..description.elasticity import Beam, Bearing, DriveStiffness, Elasticity, LinkMatrix
from ..description.elasticity.beams import Place
from ..description.elasticity.supports import DIRECTIONS

Rename = Callable[[str], str]


def stiffness_entry(elasticity: Elasticity, rename: Rename) -> Data:
    """The section with new names.

    Args:
        elasticity: what is elastic.
        rename: gives the new name of a joint, closure, link or frame.
    """
    drives: Data = {}
    for name in elasticity.drives:
        drive = elasticity.drive(name)
        if drive is not None:
            drives[rename(name)] = _drive(drive)
    pins: Data = {}
    for name, bearing in elasticity.pins.items():
        pins[rename(name)] = _bearing(bearing)
    links: Data = {}
    for name in elasticity.links:
        links[rename(name)] = _link(elasticity, name, rename)
    section: Data = {"drives": drives, "pins": pins, "links": links}
    return {key: entries for key, entries in section.items() if entries}


def _drive(drive: DriveStiffness) -> Any:
    if drive.oil is None and drive.belt is None:
        return drive.stiffness
    entry: Data = {}
    if drive.stiffness < math.inf:
        entry["stiffness"] = drive.stiffness
    if drive.oil is not None:
        entry["oil"] = {**asdict(drive.oil), "dead_volume": list(drive.oil.dead_volume)}
    if drive.belt is not None:
        belt = drive.belt
        entry["belt"] = {
            "tensile_stiffness": belt.tensile_stiffness,
            "spans": list(belt.spans),
        }
        if belt.radius is not None:
            entry["belt"]["radius"] = belt.radius
    return entry


def _bearing(bearing: Bearing) -> Data:
    if bearing.matrix is not None:
        return {"matrix": bearing.matrix.tolist()}
    entry: Data = {}
    for key in DIRECTIONS:
        value = getattr(bearing, key)
        if value is None:
            continue
        entry[key] = value
        if value == 0.0:
            entry[key] = "free"
        elif value == math.inf:
            entry[key] = "rigid"
    return entry


def _link(elasticity: Elasticity, name: str, rename: Rename) -> Data:
    link = elasticity.link(name)
    if isinstance(link, LinkMatrix):
        return {"matrix": link.matrix.tolist(), "at": _place(link.at, rename)}
    beams = [_beam(beam, rename) for beam in link or ()]
    return {"beams": beams}


def _beam(beam: Beam, rename: Rename) -> Data:
    section: Data = {}
    for key, value in asdict(beam.section).items():
        if value < math.inf:
            section[key] = value
    entry: Data = {"E": beam.E, "G": beam.G, "section": section}
    entry["to"] = _place(beam.to, rename)
    if beam.start is not None:
        entry["start"] = _place(beam.start, rename)
    entry["z"] = beam.z.tolist()
    return entry


def _place(place: Place, rename: Rename) -> Any:
    if isinstance(place, str):
        return rename(place)
    return place.tolist()
