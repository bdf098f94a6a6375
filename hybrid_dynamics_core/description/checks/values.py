"""Checks for values that contradict each other."""

from __future__ import annotations

from ...ground.units import coordinate_unit
from ..document import Document
from ..model import RobotDescription


def check_values(document: Document, robot: RobotDescription) -> None:
    """Check that the reference is within the limits, and that closures tie two links.

    Raises:
        DescriptionError: the first value that contradicts another one.
    """
    if robot.active_set == "exact":  # with motors, a reference is searched later
        _check_reference(document, robot)
    for closure in robot.closures:
        if closure.link_a == closure.link_b:
            raise document.error(
                ("closures", closure.name),
                f"both ends are on the link '{closure.link_a}', which cannot move in itself",
            )


def _check_reference(document: Document, robot: RobotDescription) -> None:
    for name, value in robot.reference.items():
        lower, upper = robot.joints[name].limits
        if not lower <= value <= upper:
            unit = coordinate_unit(robot.joints[name].type)
            raise document.error(
                ("reference", name),
                f"is {value:g} {unit}, outside the limits [{lower:g}, {upper:g}] {unit} of the"
                " joint",
            )
