"""How wrong a model may be: standard deviations before any measurement."""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import InputError
from ..ground.check_arguments import real_number


@dataclass(frozen=True)
class Tolerances:
    """Standard deviations of what the model does not know exactly.

    Attributes:
        links: of masses and first moments of links, as a share.
        friction: of the friction in the description, as a share.
        unlisted_friction: of the friction of a drive without any in the description, as a share of
            its mean effort.
        offset: of a constant error of each measured effort, as a share of its mean effort.
        scale: of the scale of each measured effort, as a share.
        noise: of a single measured effort, as a share of its mean effort; it counts where the
            samples are too few to show their noise.
        com: of the load's centre of mass along each axis of the frame [m]; 0 for a sixth of the
            frame's distance from the base.
        friction_share: of the share by which friction grows with the force of a drive, where the
            description has no friction of that drive.

    Raises:
        InputError: a value is negative or not finite.
    """

    links: float = 0.01
    friction: float = 0.05
    unlisted_friction: float = 0.03
    offset: float = 5e-4
    scale: float = 5e-4
    noise: float = 2e-3
    com: float = 0.0
    friction_share: float = 0.05

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            value = real_number(name, getattr(self, name))
            if not 0.0 <= value < float("inf"):
                raise InputError(f"{name} is {value:g}; expected a deviation of zero or more")
