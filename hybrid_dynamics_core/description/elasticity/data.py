"""What of a robot is elastic, by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

from ...errors import InputError
from ...ground.arrays import Picklable
from .beams import Beam, LinkMatrix
from .supports import Bearing, DriveStiffness

LinkElasticity = LinkMatrix | tuple[Beam, ...]


@dataclass(frozen=True, eq=False)
class Elasticity(Picklable):
    """Compliance of drives, pins and links; all that is not named is rigid.

    Attributes:
        drives: by joint or transmission, or by joint that follows others. A number is a stiffness
            [N m/rad, N/m].
        pins: bearings of joints, and pins of closures.
        links: by link, the base included.

    Raises:
        InputError: an entry is of another type.
    """

    drives: Mapping[str, DriveStiffness | float] = field(default_factory=dict)
    pins: Mapping[str, Bearing] = field(default_factory=dict)
    links: Mapping[str, LinkMatrix | Beam | Sequence[Beam]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, drive in self.drives.items():
            _drive(name, drive)
        for name, bearing in self.pins.items():
            if not isinstance(bearing, Bearing):
                raise InputError(f"pins: '{name}' is {bearing!r}; expected a Bearing")
        for name, link in self.links.items():
            _link(name, link)
        for section in ("drives", "pins", "links"):
            entries = MappingProxyType(dict(getattr(self, section)))
            object.__setattr__(self, section, entries)

    def __bool__(self) -> bool:
        sections = (self.drives, self.pins, self.links)
        return any(sections)

    def drive(self, name: str) -> DriveStiffness | None:
        """The stiffness of a drive; None for a rigid one."""
        if name not in self.drives:
            return None
        return _drive(name, self.drives[name])

    def link(self, name: str) -> LinkElasticity | None:
        """The elasticity of a link; None for a rigid one."""
        if name not in self.links:
            return None
        return _link(name, self.links[name])


def _drive(name: str, value: DriveStiffness | float) -> DriveStiffness:
    if isinstance(value, DriveStiffness):
        return value
    try:
        return DriveStiffness(value)
    except InputError as error:
        raise InputError(f"drives: {name}: {error}") from error


def _link(name: str, value: LinkMatrix | Beam | Sequence[Beam]) -> LinkElasticity:
    if isinstance(value, LinkMatrix):
        return value
    beams: tuple[Beam, ...] = ()
    if isinstance(value, Beam):
        beams = (value,)
    elif isinstance(value, Sequence):
        beams = tuple(value)
    if not beams or not all(isinstance(beam, Beam) for beam in beams):
        raise InputError(f"links: '{name}' is {value!r}; expected a LinkMatrix, or Beams")
    return beams
