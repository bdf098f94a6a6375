"""Planar four-bars from what they have to do: pairs of angles, or poses of the coupler.

Freudenstein (1955), "Approximate synthesis of four-bar linkages"; Burmester's theory as in McCarthy
and Soh (2011), Geometric Design of Linkages, Chapter 5.
"""

from __future__ import annotations

import math
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
        start = self.crank * _direction(self.crank_angle)
        end = self.rocker * _direction(self.rocker_angle)
        end[0] += self.ground
        coupler_angle = _angle(end - start) - self.crank_angle
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

    def coupler_path(self, point: ArrayLike, crank: ArrayLike) -> Array:
        """Places of a point of the coupler (N, 2) [m], on the assembly mode of the configuration.

        Args:
            point: from the pin of the crank, along the coupler and across (2,) [m].
            crank: angles of the crank (N,) [rad].

        Raises:
            InputError: the four-bar does not close at an angle.
        """
        along, across = real_array("point", point).tolist()
        angles = real_array("crank", crank)
        starts = self.crank * np.exp(1j * angles)  # in the complex plane
        turns = self._coupler_turns(starts)
        if not np.isfinite(turns).all():
            worst = float(angles[np.argmin(np.isfinite(turns))])
            raise InputError(f"the four-bar does not close where its crank is at {worst:g} rad")
        places = starts + turns * complex(along, across)
        return np.column_stack([places.real, places.imag])

    def _coupler_turns(self, starts: np.ndarray) -> np.ndarray:
        """Directions of the coupler as complex numbers (N,); NaN where it does not close."""
        first = self.crank * np.exp(1j * self.crank_angle)
        end = self.ground + self.rocker * np.exp(1j * self.rocker_angle)
        product = (self.ground - first) * np.conj(end - first)
        side = -np.sign(product.imag)
        lines = self.ground - starts
        sizes = np.abs(lines)
        squares = sizes**2 + self.coupler**2 - self.rocker**2
        cosines = squares / (2.0 * self.coupler * sizes)
        with np.errstate(invalid="ignore"):
            bends = np.arccos(cosines)
        return np.asarray(lines / sizes * np.exp(1j * side * bends))


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
    ones = np.ones(len(phi))
    matrix = np.column_stack([np.cos(psi), -np.cos(phi), ones])
    rhs = np.cos(phi - psi)
    factors, _, rank, _ = np.linalg.lstsq(matrix, rhs, rcond=None)
    k1, k2, k3 = factors.tolist()
    if rank < 3 or not k1 or not k2:
        raise InputError("these pairs of angles do not determine a four-bar")
    a = ground / k1
    c = ground / k2
    squares = a * a + c * c + ground * ground
    coupler = squares - 2.0 * a * c * k3
    if coupler <= 0.0:
        raise InputError("no four-bar has these pairs of angles: its coupler would have no length")
    return FourBar(
        ground=ground,
        crank=abs(a),
        coupler=math.sqrt(coupler),
        rocker=abs(c),
        crank_angle=_turned_round(phi[0], a),
        rocker_angle=_turned_round(psi[0], c),
    )


def _turned_round(angle: float, length: float) -> float:
    """The angle of a bar; one of negative length points the other way."""
    if length < 0.0:
        return float(angle) + math.pi
    return float(angle)


def _direction(angle: float) -> Array:
    return np.array([math.cos(angle), math.sin(angle)])


def _angle(vector: Array) -> float:
    x, y = vector.tolist()
    return math.atan2(y, x)


def _length(vector: Array) -> float:
    return float(np.linalg.norm(vector))


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
    steps = places[1:] - places[0]
    squares = (steps**2).sum(axis=1)
    area = abs(np.linalg.det(steps))
    if area <= _CLOSED * squares.max():
        raise InputError("the point's three places are on a line: no circle goes through them")
    arm = np.linalg.solve(2.0 * steps, squares)
    return Dyad(places[0] + arm, point, _length(arm))


def burmester(poses: ArrayLike) -> tuple[Dyad, ...]:
    """All dyads that guide a body through five poses: none, two or four.

    Args:
        poses: x, y [m] and angle [rad] of the body (5, 3).

    Returns:
        The dyads, the shortest first. Any two of them make a four-bar.
    """
    checked = _checked(poses, 5)
    middle = checked[:, :2].mean(axis=0)
    scaled = checked.copy()
    scaled[:, :2] -= middle
    size = float(np.abs(scaled[:, :2]).max()) or 1.0
    scaled[:, :2] /= size
    dyads: list[Dyad] = []
    for x in _solutions(scaled):
        moving = size * x[:2]
        fixed = size * x[2:] + middle
        place = _places(checked, moving)[0]
        dyads.append(Dyad(fixed, moving, _length(place - fixed)))
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
    """Rotations (., 2, 2)."""
    c = np.cos(angles)
    s = np.sin(angles)
    rotations = np.array([[c, -s], [s, c]])
    return np.moveaxis(rotations, -1, 0)


def _solutions(poses: Array) -> list[Array]:
    """Real (moving, fixed) (4,) with the same length at all poses, by Newton from many starts."""
    from scipy.stats import qmc  # noqa: PLC0415  slow to import

    starts = qmc.Halton(4, seed=0).random(_STARTS)
    x = np.tan(np.pi * (starts - 0.5) * 0.95)  # near and far
    with np.errstate(all="ignore"):
        for _ in range(_ROUNDS):
            x = x - _newton_steps(poses, x)
        residual, _ = _equations(poses, x)
    near = np.abs(x).max(axis=1) < _FAR
    sizes = 1.0 + (x**2).sum(axis=1)
    gaps = np.abs(residual).max(axis=1)
    solutions: list[Array] = []
    for candidate in x[near & (gaps < _CLOSED * sizes)]:
        if not any(_is_same(candidate, other) for other in solutions):
            solutions.append(candidate)
    return solutions


def _newton_steps(poses: Array, x: Array) -> Array:
    """Steps (N, 4) of Newton's method; zero where the equations are singular."""
    residual, jacobian = _equations(poses, x)
    regular = np.abs(np.linalg.det(jacobian)) > 0.0
    columns = residual[regular, :, None]
    solved = np.linalg.solve(jacobian[regular], columns)
    steps = np.zeros_like(x)
    steps[regular] = solved[..., 0]
    return steps


def _is_same(one: Array, other: Array) -> bool:
    return bool(np.abs(one - other).max() <= _SAME)


def _equations(poses: Array, x: Array) -> tuple[Array, Array]:
    """Differences of half the squared lengths to the first pose (N, 4), and the Jacobian."""
    moving = x[:, :2]
    fixed = x[:, None, 2:]
    turns = _turns(poses[:, 2])
    turned = np.einsum("pij,nj->npi", turns, moving)
    arms = turned + poses[:, :2] - fixed
    squares = 0.5 * (arms**2).sum(axis=2)
    by_moving = np.einsum("npi,pij->npj", arms, turns)
    slopes = np.concatenate([by_moving, -arms], axis=2)
    return _beyond_first(squares), _beyond_first(slopes)


def _beyond_first(values: Array) -> Array:
    """Values (N, poses, ...) less those of the first pose."""
    first = values[:, :1]
    return np.asarray(values[:, 1:] - first)


def through_poses(dyads: Sequence[Dyad], poses: ArrayLike) -> FourBar:
    """The four-bar of two dyads at the first of its poses, in axes of its own ground line.

    Args:
        dyads: two dyads.
        poses: the poses that they guide through (N, 3).
    """
    first, second = dyads
    pose = real_array("poses", poses)[:1]
    start = _places(pose, first.moving)[0]
    end = _places(pose, second.moving)[0]
    ground = second.fixed - first.fixed
    direction = _angle(ground)
    return FourBar(
        ground=_length(ground),
        crank=first.length,
        coupler=_length(end - start),
        rocker=second.length,
        crank_angle=_angle(start - first.fixed) - direction,
        rocker_angle=_angle(end - second.fixed) - direction,
    )
