"""Planar four-bars from what they have to do: pairs of angles, or poses of the coupler.

Freudenstein (1955), "Approximate synthesis of four-bar linkages"; Burmester's theory as in McCarthy
and Soh (2011), Geometric Design of Linkages, Chapter 5.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError
from ..formats.reader import parse_description
from ..ground.arrays import Array
from ..ground.check_arrays import real_array
from ..robot.robot import Robot

_STARTS = 4096  # of the search for dyads; at most four of them are real
_ROUNDS = 60
_CLOSED = 1e-9  # residual of a dyad, in squares of the size of the poses
_SAME = 1e-5  # distance of two dyads that count as one, in sizes of the poses
_FAR = 50.0  # sizes of the poses beyond which a pivot is none


@dataclass(frozen=True)
class FourBar:
    """A planar four-bar with the ground along x, its first pivot at the origin.

    Attributes:
        ground: distance of its fixed pivots [m].
        crank: length of the bar at the origin [m].
        coupler: length of the bar between the moving pivots [m].
        rocker: length of the bar at the other fixed pivot [m].
        crank_angle: angle of the crank from x in one configuration [rad].
        rocker_angle: angle of the rocker from x there [rad].
    """

    ground: float
    crank: float
    coupler: float
    rocker: float
    crank_angle: float
    rocker_angle: float

    def description(self) -> str:
        """A description file: joints `crank`, `rocker` and `coupler`, and the pin between them."""
        start = np.array([np.cos(self.crank_angle), np.sin(self.crank_angle)]) * self.crank
        end = np.array([np.cos(self.rocker_angle), np.sin(self.rocker_angle)]) * self.rocker
        way = end - start + np.array([self.ground, 0.0])
        coupler_angle = float(np.arctan2(way[1], way[0])) - self.crank_angle
        return f"""\
format: 1
name: four_bar
parameters: {{ground: {self.ground!r}, a: {self.crank!r}, b: {self.coupler!r}, c: {self.rocker!r}}}
links: {{base: {{}}, crank: {{}}, coupler: {{}}, rocker: {{}}}}
joints:
  crank: {{type: revolute, parent: base, child: crank, axis: z}}
  rocker: {{type: revolute, parent: base, child: rocker, axis: z, origin: {{xyz: [ground, 0, 0]}}}}
  coupler: {{type: revolute, parent: crank, child: coupler, axis: z, origin: {{xyz: [a, 0, 0]}}}}
closures:
  pin: {{kind: planar, between: {{coupler: [b, 0, 0], rocker: [c, 0, 0]}}}}
active: [crank]
end_effector: {{link: coupler, xyz: [b/2, 0, 0]}}
reference:
  {{crank: {self.crank_angle!r}, rocker: {self.rocker_angle!r}, coupler: {coupler_angle!r}}}
"""

    def robot(self) -> Robot:
        """The four-bar as a robot, driven at its crank."""
        return Robot(parse_description(self.description()))


class Dyad(NamedTuple):
    """A bar between the ground and a moving body.

    Attributes:
        fixed: its pivot on the ground (2,) [m].
        moving: its pivot on the body, in the body's frame (2,) [m].
        length: distance of the two [m].
    """

    fixed: Array
    moving: Array
    length: float


def freudenstein(crank: ArrayLike, rocker: ArrayLike, ground: float = 1.0) -> FourBar:
    """The four-bar that turns its rocker with its crank as given.

    Freudenstein's equation K1 cos(rocker) - K2 cos(crank) + K3 = cos(crank - rocker) is linear in
    K1 = ground/crank, K2 = ground/rocker and K3. Three pairs determine it; more are fitted.

    Args:
        crank: angles of the crank from the ground line (3,) or more [rad].
        rocker: angles of the rocker (3,) or more [rad].
        ground: length of the ground [m].

    Raises:
        InputError: no four-bar has these pairs.
    """
    phi, psi = real_array("crank", crank), real_array("rocker", rocker)
    if phi.shape != psi.shape or phi.ndim != 1 or len(phi) < 3:
        raise InputError("crank and rocker need equally many angles, three or more")
    matrix = np.column_stack([np.cos(psi), -np.cos(phi), np.ones(len(phi))])
    (k1, k2, k3), _, rank, _ = np.linalg.lstsq(matrix, np.cos(phi - psi), rcond=None)
    if rank < 3 or k1 == 0.0 or k2 == 0.0:
        raise InputError("these pairs of angles do not determine a four-bar")
    a, c = ground / k1, ground / k2
    square = a * a + c * c + ground * ground - 2.0 * a * c * k3
    if square <= 0.0:
        raise InputError("no four-bar has these pairs of angles: its coupler would have no length")
    # a bar of negative length points the other way
    crank_angle = float(phi[0]) + (np.pi if a < 0.0 else 0.0)
    rocker_angle = float(psi[0]) + (np.pi if c < 0.0 else 0.0)
    lengths = ground, abs(float(a)), float(np.sqrt(square)), abs(float(c))
    return FourBar(*lengths, float(crank_angle), float(rocker_angle))


def centre(poses: ArrayLike, moving: ArrayLike) -> Dyad:
    """The dyad of a point of the body that takes three poses: the circle through its places.

    Args:
        poses: x, y [m] and angle [rad] of the body (3, 3).
        moving: the point in the body's frame (2,) [m].

    Raises:
        InputError: the three places are on a line.
    """
    point = real_array("moving", moving)
    places = _places(_checked(poses, 3), point)
    matrix = 2.0 * (places[1:] - places[0])
    squares = (places**2).sum(axis=1)
    if abs(np.linalg.det(matrix)) < _CLOSED * max(squares.max(), 1e-300):
        raise InputError("the point's three places are on a line: no circle goes through them")
    fixed = np.linalg.solve(matrix, squares[1:] - squares[0])
    return Dyad(fixed, point, float(np.linalg.norm(places[0] - fixed)))


def burmester(poses: ArrayLike) -> tuple[Dyad, ...]:
    """All dyads that guide a body through five poses: none, two or four.

    Args:
        poses: x, y [m] and angle [rad] of the body (5, 3).

    Returns:
        The dyads, the shortest first. Any two of them make a four-bar.
    """
    checked = _checked(poses, 5)
    middle = checked[:, :2].mean(axis=0)
    size = float(np.abs(checked[:, :2] - middle).max()) or 1.0
    scaled = checked.copy()
    scaled[:, :2] = (scaled[:, :2] - middle) / size
    dyads: list[Dyad] = []
    for x in _solutions(scaled):
        fixed, moving = size * x[2:] + middle, size * x[:2]
        place = _places(checked, moving)[0]
        dyads.append(Dyad(fixed, moving, float(np.linalg.norm(place - fixed))))
    return tuple(sorted(dyads, key=lambda dyad: dyad.length))


def _checked(poses: ArrayLike, count: int) -> Array:
    array = real_array("poses", poses)
    if array.shape != (count, 3) or not np.isfinite(array).all():
        raise InputError(f"poses have shape {array.shape}; expected ({count}, 3): x, y, angle")
    return array


def _places(poses: Array, point: Array) -> Array:
    """Places (., 2) of a point of the body."""
    turned = _turns(poses[:, 2]) @ point
    return np.asarray(poses[:, :2] + turned)


def _turns(angles: Array) -> Array:
    c, s = np.cos(angles), np.sin(angles)
    return np.moveaxis(np.array([[c, -s], [s, c]]), -1, 0)


def _solutions(poses: Array) -> list[Array]:
    """Real (moving, fixed) (4,) with the same length at all poses, by Newton from many starts."""
    from scipy.stats import qmc  # noqa: PLC0415  slow to import

    starts = qmc.Halton(4, seed=0).random(_STARTS)
    x = np.tan(np.pi * (starts - 0.5) * 0.95)  # near and far
    with np.errstate(all="ignore"):
        for _ in range(_ROUNDS):
            residual, jacobian = _equations(poses, x)
            regular = np.abs(np.linalg.det(jacobian)) > 0.0
            steps = np.zeros_like(x)
            steps[regular] = np.linalg.solve(jacobian[regular], residual[regular, :, None])[..., 0]
            x = x - steps
        residual, _ = _equations(poses, x)
    near = np.abs(x).max(axis=1) < _FAR
    closed = np.abs(residual).max(axis=1) < _CLOSED * (1.0 + (x**2).sum(axis=1))
    solutions: list[Array] = []
    for candidate in x[near & closed]:
        if all(np.abs(candidate - other).max() > _SAME for other in solutions):
            solutions.append(candidate)
    return solutions


def _equations(poses: Array, x: Array) -> tuple[Array, Array]:
    """Differences of half the squared lengths to the first pose (N, 4), and the Jacobian."""
    moving, fixed = x[:, :2], x[:, 2:]
    turns = _turns(poses[:, 2])
    arms = np.einsum("pij,nj->npi", turns, moving) + poses[None, :, :2] - fixed[:, None]
    squares = 0.5 * (arms**2).sum(axis=2)
    by_moving = np.einsum("npi,pij->npj", arms, turns)
    slopes = np.concatenate([by_moving, -arms], axis=2)
    return squares[:, 1:] - squares[:, :1], slopes[:, 1:] - slopes[:, :1]


def through_poses(dyads: Sequence[Dyad], poses: ArrayLike) -> FourBar:
    """The four-bar of two dyads at the first of its poses, in axes of its own ground line.

    Args:
        dyads: two dyads.
        poses: the poses that they guide through (N, 3).
    """
    first, second = dyads
    pose = real_array("poses", poses)[:1]
    a, b = (_places(pose, dyad.moving)[0] for dyad in dyads)
    ground = second.fixed - first.fixed
    direction = float(np.arctan2(ground[1], ground[0]))
    arms = (a - first.fixed, b - second.fixed)
    angles = [float(np.arctan2(arm[1], arm[0])) - direction for arm in arms]
    coupler = float(np.linalg.norm(b - a))
    length = float(np.linalg.norm(ground))
    return FourBar(length, first.length, coupler, second.length, *angles)
