"""Parallelograms and planes of loops whose geometry changes.

The loader makes bars that are drawn nearly equal exactly equal, and closes parallelograms by their
angles. A parameter that moves one bar alone would have no effect then, or be refused. Such loops
are closed as general four-bars here, from the states of the parallelogram.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace

import numpy as np

from ..closure.constraints.from_description import loop_equations
from ..closure.constraints.parallelogram import PARALLELOGRAM
from ..closure.constraints.plane import ROUNDED
from ..closure.printed.planar import snapped
from ..description.model import RobotDescription
from ..errors import DescriptionError
from ..mechanism.tree import build_tree
from ..robot.robot import Robot
from .adjustable import AdjustableRobot, FreeParameter

PROBE = 1e-3  # [m or rad] change of a parameter that shows whether bars stay equal
SAME = 1e-12  # [m] rounding of places of pins


class LoopChoices:
    """The loader's choices on loops, as far as they hold while parameters change.

    Attributes:
        general: names of the parallelograms that a parameter breaks.
    """

    def __init__(
        self,
        adjustable: AdjustableRobot,
        parameters: Sequence[FreeParameter],
        nominal: RobotDescription,
    ) -> None:
        """Find the parallelograms that a parameter breaks."""
        drawn = adjustable.described((), ())
        modes = [closure.assembly for closure in nominal.closures]
        broken: set[str] = set()
        if PARALLELOGRAM in modes:
            for parameter in parameters:
                values = [parameter.start + PROBE]
                try:
                    moved = adjustable.described([parameter], values)
                except DescriptionError:
                    continue  # the fit says more
                broken.update(broken_parallelograms(moved))
        self.general = frozenset(broken)
        self._equal_bars = 0.0 if _keeps_pins(drawn) else ROUNDED

    def applied(self, description: RobotDescription) -> RobotDescription:
        """The description that is closed.

        Raises:
            DescriptionError: a loop is not planar any more.
        """
        changed = with_four_bars(description, self.general)
        return snapped(changed, equal_bars=self._equal_bars)


def broken_parallelograms(description: RobotDescription) -> Iterator[str]:
    """Names of the loops that are declared parallelograms, and are none."""
    for closure in description.closures:
        if closure.assembly != PARALLELOGRAM:
            continue
        alone = replace(description, closures=(closure,), mimics={})
        try:
            flat = snapped(alone, equal_bars=0.0)
            loop_equations(build_tree(flat), flat, frozenset())
        except DescriptionError:
            yield closure.name


def with_general_bars(description: RobotDescription, robot: Robot) -> RobotDescription:
    """The description with parallelograms that are none closed as four-bars near the reference.

    Args:
        description: a description with other numbers than the robot.
        robot: the robot, whose loops close at its reference.
    """
    broken = set(broken_parallelograms(description))
    if not broken:
        return description
    general = with_four_bars(description, broken)
    state = robot.close(robot.reference)
    reference = dict(zip(robot.coordinates, state.s.tolist(), strict=True))
    return replace(general, reference=reference)


def with_four_bars(description: RobotDescription, loops: Collection[str]) -> RobotDescription:
    """The description with some parallelograms closed as general four-bars."""
    closures = []
    for closure in description.closures:
        is_general = closure.name in loops and closure.assembly == PARALLELOGRAM
        closures.append(replace(closure, assembly=None) if is_general else closure)
    return replace(description, closures=tuple(closures))


def _keeps_pins(drawn: RobotDescription) -> bool:
    """Whether the bars of the file are as the loader has them."""
    equal, plain = snapped(drawn), snapped(drawn, equal_bars=0.0)
    for one, other in zip(equal.closures, plain.closures, strict=True):
        apart = np.abs([one.point_a - other.point_a, one.point_b - other.point_b])
        if apart.max() > SAME:
            return False
    return True
