"""Names of elastic elements against those of a robot."""

from __future__ import annotations

from ..description.elasticity import Elasticity
from ..errors import InputError
from ..ground.suggestions import no_such_name
from .machine import Machine


def check_names(machine: Machine, elasticity: Elasticity) -> None:
    """Check that drives, pins and links exist.

    Raises:
        InputError: the first name that does not.
    """
    robot = machine.description
    drives = [*machine.all_drives, *robot.mimics]
    for name in elasticity.drives:
        if name in drives:
            continue
        if name in robot.joints:
            raise InputError(
                f"drives: joint '{name}' has no drive; known: {', '.join(drives)}. A spring on a"
                " joint is its `spring`"
            )
        raise InputError(f"drives: {no_such_name('drive', name, drives)}")
    pins = [*robot.joints, *(closure.name for closure in robot.closures)]
    for name in elasticity.pins:
        if name not in pins:
            raise InputError(f"pins: {no_such_name('joint or closure', name, pins)}")
    links = [robot.base, *robot.links]
    for name in elasticity.links:
        if name not in links:
            raise InputError(f"links: {no_such_name('link', name, links)}")
