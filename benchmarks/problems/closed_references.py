"""Reference motions of loops with one degree of freedom, closed by formulas of their own.

Nothing of this library is used. Everything is analytic in the angle, so that complex steps give
derivatives to the last digit.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .references import GRAVITY, STEP, one_freedom

Array = NDArray[np.float64]
AnyArray = NDArray[Any]  # real or complex
MOST = 50  # iterations of Newton's method
WIDTH = 0.1  # [m] of the square rods of Bricard's mechanism


class Bricard:
    """Six hinges at right angles along the edges of a box, five rods of 1 kg/m.

    All six angles are coordinates; that of one hinge is given, the others follow.

    Args:
        edges: (3,) [m] of the box along x, y and z.
        given: which hinge, from 0.
        down: (3,) direction of gravity.
    """

    def __init__(self, edges: tuple[float, float, float], given: int, down: list[int]) -> None:
        x, y, z = edges
        self.axes = np.eye(3)[[1, 2, 0, 1, 2, 0]]
        self.rods = np.array([[x, 0, 0], [0, -y, 0], [0, 0, z], [-x, 0, 0], [0, y, 0], [0, 0, -z]])
        self.given = given
        self.down = np.array(down)
        self.others = [k for k in range(6) if k != given]
        self._forget()

    def _forget(self) -> None:
        """Begin in the box again."""
        self.near = np.zeros(6)
        self.slope = np.zeros(6)

    def closed(self, angle: complex) -> tuple[AnyArray, AnyArray]:
        """Angles (6,) and their derivatives by the given one."""
        ahead = complex(angle) - self.near[self.given]
        q = self.near + self.slope * ahead
        q[self.given] = angle
        for _ in range(MOST):
            turned, places = self._chain(q)
            jacobian = self._jacobian(turned, places)
            R = turned[-1]
            skew = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
            gap = np.concatenate([places[-1], skew])
            free = jacobian[:, self.others]
            square = free.T @ free
            change = np.linalg.solve(square, free.T @ gap)
            q[self.others] -= change
            if np.abs(change).max() < 1e-12:
                break
        else:
            raise RuntimeError(f"the loop does not close at {angle}")
        slope = np.ones(6, dtype=complex)
        slope[self.others] = -np.linalg.solve(square, free.T @ jacobian[:, self.given])
        self.near, self.slope = q.real, slope.real
        return q, slope

    def _chain(self, q: AnyArray) -> tuple[list[AnyArray], list[AnyArray]]:
        """Rotations after each hinge, and the places of all hinges and of the end."""
        R = np.eye(3, dtype=complex)
        p = np.zeros(3, dtype=complex)
        turned, places = [], [p]
        for axis, rod, angle in zip(self.axes, self.rods, q, strict=True):
            R = R @ _turn(axis, angle)
            p = p + R @ rod
            turned.append(R)
            places.append(p)
        return turned, places

    def _jacobian(self, turned: list[AnyArray], places: list[AnyArray]) -> AnyArray:
        """(6, 6) of the end's place and rotation by the angles."""
        columns = []
        for axis, R, place in zip(self.axes, turned, places[:-1], strict=True):
            along = R @ axis
            columns.append(np.concatenate([np.cross(along, places[-1] - place), along]))
        return np.array(columns).T

    def energies(self, angle: complex) -> tuple[complex, complex]:
        """Inertia as the given hinge feels it, and the potential energy."""
        q, slope = self.closed(angle)
        turned, places = self._chain(q)
        omega = v = np.zeros(3, dtype=complex)
        inertia = potential = 0.0j
        for k in range(5):
            R, rod = turned[k], self.rods[k]
            omega = omega + R @ self.axes[k] * slope[k]
            length = float(np.abs(rod).sum())
            middle = v + np.cross(omega, R @ rod / 2)
            own = R.T @ omega
            along = rod / length
            across = length * (length**2 + WIDTH**2) / 12
            moments = across + (length * WIDTH**2 / 6 - across) * along**2
            inertia += length * (middle @ middle) + own @ (moments * own)
            potential -= length * GRAVITY * (places[k] + R @ rod / 2) @ self.down
            v = v + np.cross(omega, R @ rod)
        return inertia, potential

    def motion(self, t: Array) -> Array:
        """Rows (x, y, x', y') of the second rod's end; at rest at first, in the box."""
        self._forget()
        angles, rates = one_freedom(self.energies, t, (0.0, 0.0), 1e-11)
        self._forget()
        rows = []
        for angle, rate in zip(angles, rates, strict=True):
            place = self._chain(self.closed(angle + 1j * STEP)[0])[1][2]
            rows.append([*place.real[:2], *(place.imag[:2] / STEP * rate)])
        return np.array(rows)


def _turn(axis: Array, angle: complex) -> AnyArray:
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turned: AnyArray = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
    return turned


def bricard(t: Array) -> Array:
    """Rows (x, y, x', y') of Bricard's mechanism along the edges of a cube of 1 m."""
    return Bricard((1.0, 1.0, 1.0), 0, [0, -1, 0]).motion(t)


def rectangular_bricard(t: Array) -> Array:
    """The same along the edges of a box."""
    return Bricard((1.0, 0.8, 0.6), 1, [0, 0, 1]).motion(t)


CRANK, COUPLER, ROCKER, GROUND = 0.4, 0.9, 0.7, 1.0  # [m]
MASSES = (1.0, 2.0, 1.5)  # [kg] of crank, coupler and rocker, thin rods
STIFFNESS, REST = 200.0, 0.6  # [N/m], [m]


def diagonal_energies(angle: complex) -> tuple[complex, complex]:
    """Inertia as the crank feels it, and the potential energy, of the four-bar with a spring."""
    a = np.array([CRANK * np.cos(angle), CRANK * np.sin(angle)])
    da = np.array([-a[1], a[0]])
    diagonal = np.array([GROUND, 0.0]) - a
    square = diagonal @ diagonal
    length = np.sqrt(square)
    along = (COUPLER**2 - ROCKER**2 + square) / (2.0 * length)
    across = np.sqrt(COUPLER**2 - along**2)
    side = np.array([-diagonal[1], diagonal[0]])
    b = a + (along * diagonal + across * side) / length
    coupler, rocker = b - a, b - np.array([GROUND, 0.0])
    # B moves at right angles to the rocker, and as A does along the coupler
    turned = np.array([-rocker[1], rocker[0]])
    db = turned * (coupler @ da) / (coupler @ turned)
    inertia = MASSES[0] * CRANK**2 / 3.0
    inertia += MASSES[1] / 3.0 * (da @ da + da @ db + db @ db)
    inertia += MASSES[2] / 3.0 * (db @ db)
    heights = (a[1] / 2.0, (a[1] + b[1]) / 2.0, b[1] / 2.0)
    potential = GRAVITY * sum(m * h for m, h in zip(MASSES, heights, strict=True))
    return inertia, potential + 0.5 * STIFFNESS * (length - REST) ** 2


def diagonal_spring(t: Array) -> Array:
    """Rows (x, y, x', y') of the crank's end, let go upright."""
    angle, rate = one_freedom(diagonal_energies, t, (np.pi / 2, 0.0), 1e-13)
    cosine, sine = CRANK * np.cos(angle), CRANK * np.sin(angle)
    return np.column_stack([cosine, sine, -sine * rate, cosine * rate])
