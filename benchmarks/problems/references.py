"""Reference motions that owe nothing to this library.

Each is written out by hand, in coordinates of its own, or is a closed form.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.special import ellipj, ellipk

Array = NDArray[np.float64]
AnyArray = NDArray[Any]  # real or complex
GRAVITY = 9.81  # [m/s^2]
STEP = 1e-30  # of complex differentiation: no difference is taken


def pendulum(t: Array) -> Array:
    """Rows (x, y, x', y') of a pendulum of 1 m that was let go level, at (-1, 0)."""
    rate = math.sqrt(GRAVITY)
    modulus = math.sin(math.pi / 4)
    quarter = ellipk(modulus**2)
    sn, cn, dn, _ = ellipj(quarter - rate * t, modulus**2)
    # phi from straight down: sin(phi / 2) = k sn
    sine = 2.0 * modulus * sn * dn
    cosine = 1.0 - 2.0 * (modulus * sn) ** 2
    turning = -2.0 * modulus * rate * cn
    return np.column_stack([-sine, -cosine, -turning * cosine, turning * sine])


def four_bars(t: Array, count: int) -> Array:
    """Rows (x, y, x', y') of the first crank's tip in a row of `count` four-bars.

    Cranks and couplers stay parallel: a pendulum, which starts upright with 1 rad/s and goes round.
    """
    cranks = count + 1
    weight = GRAVITY * (cranks / 2 + count)
    inertia = cranks / 3 + count
    square = weight / inertia
    fastest = math.sqrt(1.0 + 4.0 * square)  # at the bottom
    m = 4.0 * square / fastest**2
    from_bottom = fastest / 2.0 * t + ellipk(m)
    sn, cn, dn, _ = ellipj(from_bottom, m)
    # phi from straight down: phi / 2 = am
    sine = 2.0 * sn * cn
    cosine = cn**2 - sn**2
    turning = fastest * dn
    return np.column_stack([-sine, -cosine, -turning * cosine, turning * sine])


def slider_crank(t: Array) -> Array:
    """Rows (x, x') of the slider of the spatial slider-crank, the crank upright with 6 rad/s."""
    angle, rate = one_freedom(_slider_energies, t, (0.0, 6.0), 1e-13)
    turned = angle + 1j * STEP
    place = _slider(turned)[2]
    return np.column_stack([place.real, place.imag / STEP * rate])


def _slider(angle: AnyArray) -> tuple[AnyArray, AnyArray, AnyArray]:
    """The crank's end in y and z, and the slider's place."""
    y = 0.1 - 0.08 * np.sin(angle)
    z = 0.12 + 0.08 * np.cos(angle)
    return y, z, np.sqrt(0.09 - y**2 - z**2)


def _slider_energies(angle: AnyArray) -> tuple[AnyArray, AnyArray]:
    """Inertia as the crank feels it, and the potential energy."""
    y, z, x = _slider(angle)
    dy = -0.08 * np.cos(angle)
    dz = -0.08 * np.sin(angle)
    dx = -(y * dy + z * dz) / x
    rod = np.array([x, -y, -z]) / 0.3
    change = np.array([dx, -dy, -dz]) / 0.3
    across = np.cross(rod, change, axis=0)
    spin = rod[0] * across[0] / (1.0 - rod[0] ** 2)  # by the universal joint
    crank = 0.0001 + 0.12 * 0.04**2
    middle = (dx**2 + dy**2 + dz**2) / 4.0
    turning = 0.004 * (across**2).sum(axis=0) + 0.0004 * spin**2
    inertia = crank + 2.0 * dx**2 + 0.5 * middle + turning
    height = 0.12 * (0.12 + 0.04 * np.cos(angle)) + 0.5 * z / 2.0
    return inertia, GRAVITY * height


def one_freedom(
    energies: Callable[[Any], tuple[Any, Any]],
    t: Array,
    start: tuple[float, float],
    tolerance: float,
) -> tuple[Array, Array]:
    """Angle and rate under (inertia, potential) of the angle, by Lagrange's equation.

    Args:
        energies: of a complex angle, analytic.
        t: (N,) [s].
        start: angle and rate.
        tolerance: of DOP853, relative and absolute.
    """

    def slope(_: float, y: Array) -> list[float]:
        inertia, potential = energies(y[0] + 1j * STEP)
        push = 0.5 * inertia.imag * y[1] ** 2 + potential.imag
        return [y[1], -push / STEP / inertia.real]

    span = (t[0], t[-1])
    answer = solve_ivp(slope, span, start, "DOP853", t_eval=t, rtol=tolerance, atol=tolerance)
    return answer.y[0], answer.y[1]


def flyball_governor(t: Array) -> Array:
    """Rows (s, s') of the governor's slider; both rods fall alike."""
    start = [math.pi / 6, 0.5, 0.0, 0.0]
    momentum = 2.0 * math.pi * _turning(math.pi / 6)[0]
    answer = solve_ivp(
        _governor_slope,
        (t[0], t[-1]),
        start,
        "Radau",
        t_eval=t,
        rtol=1e-9,
        atol=1e-11,
        args=(momentum,),
    )
    return np.column_stack([answer.y[1], answer.y[3]])


ROD, BALL, BOX = 0.3, 5.0, 3.0  # masses [kg]
ALONG, ACROSS = ROD * 0.0002 / 12, ROD * 1.0001 / 12  # of a rod about its middle [kg m^2]


def _turning(fall: float) -> tuple[float, float]:
    """Inertia about the shaft, and its derivative by the angle of fall."""
    cosine = math.cos(fall)
    sine = math.sin(fall)
    ball = 0.05 + cosine
    middle = 0.05 + 0.5 * cosine
    arm = BALL * ball**2 + ROD * middle**2 + ACROSS * cosine**2 + ALONG * sine**2
    change = -2.0 * BALL * ball * sine - ROD * middle * sine
    change += 2.0 * (ALONG - ACROSS) * sine * cosine
    return ALONG + BOX * 0.02 / 12 + 2.0 * arm, 2.0 * change


def _governor_slope(_: float, y: Array, momentum: float) -> list[float]:
    """Rates of (fall, s, fall', s'): the momentum about the shaft is kept."""
    fall, s, dfall, ds = y
    sine = math.sin(fall)
    cosine = math.cos(fall)
    out = 0.5 * cosine
    up = 1.0 - 0.5 * sine - s
    length = math.hypot(out, up)
    by_fall = (-out * 0.5 * sine - up * 0.5 * cosine) / length
    by_s = -up / length
    force = 8e5 * (length - 0.5) + 4e4 * (by_fall * dfall + by_s * ds)
    inertia, change = _turning(fall)
    arm = BALL + ROD / 4 + ACROSS
    whirl = 0.5 * change * (momentum / inertia) ** 2
    weight = 2.0 * GRAVITY * (BALL + ROD / 2) * cosine
    ddfall = (whirl + weight - 2.0 * force * by_fall) / (2.0 * arm)
    dds = -GRAVITY - 2.0 * force * by_s / BOX
    return [dfall, ds, ddfall, dds]
