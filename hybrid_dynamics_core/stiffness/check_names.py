"""Names of elastic elements against those of a robot."""

from __future__ import annotations

from ..description.elasticity import Elasticity
from ..errors import InputError
from ..ground.suggestions import no_such_name
from .robot_interface import ElasticRobot


def check_names(robot: ElasticRobot, elasticity: Elasticity) -> None:
    """Check that drives, pins and links exist.

    Raises:
        InputError: the first name that does not.
    """
    description = robot.description
    _check_drives(robot, elasticity)
    pins = [*description.joints, *(closure.name for closure in description.closures)]
    for name in elasticity.pins:
        if name not in pins:
            raise InputError(f"pins: {no_such_name('joint or closure', name, pins)}")
    links = [description.base, *description.links]
    for name in elasticity.links:
        if name not in links:
            raise InputError(f"links: {no_such_name('link', name, links)}")


def _check_drives(robot: ElasticRobot, elasticity: Elasticity) -> None:
    description = robot.description
    drives = [*robot.all_drives, *description.mimics]
    for name in elasticity.drives:
        if name in description.angles_in_rows:
            raise InputError(
                f"drives: '{name}' is an angle of a ball or free joint, which differs between its"
                " charts; a spring on the joint is its `spring`"
            )
        if name in drives:
            continue
        if name in description.joints:
            raise InputError(
                f"drives: joint '{name}' has no drive; known: {', '.join(drives)}. A spring on a"
                " joint is its `spring`"
            )
        raise InputError(f"drives: {no_such_name('drive', name, drives)}")
