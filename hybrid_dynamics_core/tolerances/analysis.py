"""Errors of a robot's tool from the tolerances of its parts, through the closed loops."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..calibration.closed_rows import ClosedRows
from ..description.geometry import unit_axis
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arguments import integer, real_number
from ..ground.check_arrays import finite_vectors
from ..ground.file_options import PathText
from ..ground.suggestions import no_such_name
from ..kinematics.sampling import Ranges, halton_samples, sampled_ranges
from ..kinematics.workspace import margins_at
from ..library import load
from ..robot.robot import Robot
from .bounds import farthest, likely
from .entries import Play, Table
from .linear import POSITION, ROTATION, Contribution, LinearErrors
from .monte_carlo import SampledErrors, sampled_errors
from .sensitivity import sensitivities
from .varied import Variable, VariedRobot

POSES = 200
CONFIDENCE = 0.95
SAMPLES = 1000
NEARLY = 1e-12  # share of a direction across a pin below which it has no direction there


class ToleranceAnalysis:
    """What the tolerances of lengths and the play of pins do to the pose of the tool.

    Attributes:
        robot: the robot.
        frame: name of the frame whose errors are meant.
        variables: what varies; a list of numbers has one for each.
    """

    def __init__(
        self, robot: Robot | PathText, table: Table, frame: str | None = None, law: str = "normal"
    ) -> None:
        """Prepare the geometry.

        Args:
            robot: a robot that was read from a file, the name of a shipped one, or a path.
            table: tolerances by path [m or rad]: `L2`, `joints.q2.origin.xyz[0]`,
                `loops.lift.pin.rod`, `joints.q1.offset`; and plays of pins: `joints.q2.play`,
                `loops.lift.play`. Values are numbers, texts such as `0.1*mm uniform`, `Tolerance`
                or `Play`.
            frame: name in `frames`; the end effector if None.
            law: of numbers without one: `normal`, `uniform` or `truncated`.

        Raises:
            InputError: a path leads to nothing or may not vary, or a value is no tolerance.
            DescriptionError: the robot's file is wrong.
        """
        self.robot = robot if isinstance(robot, Robot) else load(robot)
        self.frame = self.robot.end_effector if frame is None else frame
        if self.frame not in self.robot.frames:
            raise InputError(no_such_name("frame", self.frame, self.robot.frames))
        self._varied = VariedRobot(self.robot, table, law)
        self.variables: tuple[Variable, ...] = tuple(self._varied.variables)

    # -- poses

    def poses(self, count: int = POSES, ranges: Ranges | None = None) -> Array:
        """Poses (N, n), evenly distributed over the workspace, that close within all limits.

        Args:
            count: how many are tried.
            ranges: narrower ranges of active coordinates, by name [rad, m].

        Raises:
            InputError: a range is wrong, or none of the poses can be reached.
        """
        box, _ = sampled_ranges(self.robot, ranges)
        u = halton_samples(box, integer("count", count), denser=0)
        reached = u[margins_at(self.robot, u).reachable]
        if not len(reached):
            raise InputError(f"{self.robot.name} reaches none of {count} poses in these ranges")
        return reached

    # -- errors

    def linear(self, u: ArrayLike | None = None, confidence: float = CONFIDENCE) -> LinearErrors:
        """Errors to first order: likely ones by root sum square, worst ones by their sum.

        Args:
            u: active coordinates (n,) or (N, n) [rad, m]; `poses()` if None.
            confidence: probability with which an error is below the likely one.

        Raises:
            InputError: an argument is wrong, or a variable opens an over-determined loop.
            StateError: a pose does not close.
        """
        confidence = _checked_confidence(confidence)
        u = self._rows(u)
        rows = self._varied.closed(u)
        slopes = sensitivities(self._varied, rows, self.frame)
        pressed = self._pressed(rows)
        contributions: dict[str, Contribution] = {}
        for variable in self.variables:
            contributions[variable.name] = _contribution(variable, slopes, pressed)
        covariance = np.zeros((len(u), 6, 6))
        shift = np.zeros((len(u), 6))
        for one in contributions.values():
            covariance += one.covariance
            shift += one.shift
        worst: list[Array] = []
        sizes: list[Array] = []
        for half in (POSITION, ROTATION):
            balls = [one.ball(half) for one in contributions.values() if not one.is_pressed]
            worst.append(farthest(balls, shift[:, half]))
            sizes.append(likely(covariance[:, half, half], shift[:, half], confidence))
        return LinearErrors(
            u=u,
            confidence=confidence,
            contributions=contributions,
            covariance=covariance,
            shift=shift,
            worst_errors=np.concatenate(worst, axis=1),
            normal_sizes=np.stack(sizes, axis=1),
        )

    def monte_carlo(
        self,
        u: ArrayLike | None = None,
        count: int = SAMPLES,
        seed: int = 0,
        confidence: float = CONFIDENCE,
    ) -> SampledErrors:
        """Errors of random robots, each with its loops closed: nothing is linear here.

        Args:
            u: active coordinates (n,) or (N, n) [rad, m]; the reference if None.
            count: number of robots.
            seed: seed of the random numbers.
            confidence: share of the robots whose error is below the likely one.

        Raises:
            InputError: an argument is wrong.
            StateError: a pose does not close with the described robot.
        """
        confidence = _checked_confidence(confidence)
        if u is None:
            u = self.robot.reference
        u = self._rows(u)
        rows = self._varied.closed(u)
        rng = np.random.default_rng(integer("seed", seed, least=0))
        drawn = np.zeros((integer("count", count, least=2), self._varied.count))
        for variable in self.variables:
            drawn[:, variable.columns] = variable.entry.drawn(rng, count, variable.size)
        changes = drawn[:, None] + self._pressed(rows)
        return sampled_errors(self._varied, rows, self.frame, changes, confidence)

    # -- parts

    def _rows(self, u: ArrayLike | None) -> Array:
        if u is None:
            return self.poses()
        rows = np.atleast_2d(finite_vectors("u", u, self.robot.active))
        if not len(rows):
            raise InputError("u has no rows; expected one pose or more")
        return rows

    def _pressed(self, rows: ClosedRows) -> Array:
        """Displacements (N, m) of the pins that are pressed to one side."""
        result = np.zeros((len(rows.s), self._varied.count))
        posed = rows.poses()
        for variable in self.variables:
            entry, pin = variable.entry, variable.pin
            if pin is None or not isinstance(entry, Play) or entry.towards is None:
                continue
            rotation = np.broadcast_to(np.eye(3), (len(rows.s), 3, 3))
            if pin.link != self.robot.description.base:
                rotation, _ = posed.frame(pin.link)
            across = np.asarray(rotation) @ pin.free_directions
            along = np.einsum("nid,i->nd", across, unit_axis(list(entry.towards)))
            lengths = np.linalg.norm(along, axis=1, keepdims=True)
            if (lengths < NEARLY).any():
                raise InputError(
                    f"tolerances: {variable.name}: towards {entry.towards} is along the pin's axis"
                )
            result[:, variable.columns] = entry.half * along / lengths
        return result


def _contribution(variable: Variable, slopes: Array, pressed: Array) -> Contribution:
    """What one variable does to the pose, from all sensitivities and displacements."""
    part = slopes[:, :, variable.columns]
    variance = variable.entry.variance(variable.size)
    covariance = variance * (part @ np.swapaxes(part, 1, 2))
    shift = np.einsum("ncd,nd->nc", part, pressed[:, variable.columns])
    return Contribution(variable.entry, part, covariance, shift)


def _checked_confidence(confidence: float) -> float:
    value = real_number("confidence", confidence)
    if not 0.5 <= value < 1.0:
        raise InputError(f"confidence is {value:g}; expected from 0.5 to below 1, such as 0.95")
    return value
