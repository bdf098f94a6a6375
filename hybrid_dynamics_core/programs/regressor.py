"""The regressor Y of  Y(u, u', u'') pi = tau  through the closed loops."""

from __future__ import annotations

from collections.abc import Callable

from ..algebra.scalar import Scalar
from ..algebra.vector import IDENTITY3, ZERO3, Vector, add, cross, dot, matvec
from ..dynamics.bilinear import Twist, body_twists
from ..dynamics.load_pattern import smooth_sign
from ..dynamics.parameters import JOINT_KINDS, Parameters
from ..dynamics.spanning import BodyMotion, Wrench
from ..kernels.trace import Results
from .dynamics import Dynamics, columns_of
from .model import Inputs, Model, Program

_PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


def regressor(parameters: Parameters) -> Program:
    """Program for Y (n, p).

    A body's wrench is linear in its ten parameters; tau is its work over the body's motions per
    unit rate of each active coordinate, for which R carries the loops.
    """

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x)
        motion, tree, ds = dynamics.motion, dynamics.tree, dynamics.ds
        dds = motion.accelerations(x.ddu, ds)
        directions = columns_of(motion)
        twists = [body_twists(tree, direction) for direction in directions]
        motions = tree.motions(dynamics.gravity, ds, dds)
        columns: list[list[Scalar]] = []
        for link in parameters.links:
            body = model.tree.body_index(link)
            columns += [
                [_power(t[body], wrench) for t in twists] for wrench in unit_wrenches(motions[body])
            ]
        for kind in JOINT_KINDS:
            for joint in getattr(parameters, kind):
                k = model.tree.coordinates.index(joint)
                along = _UNIT_FORCES[kind](ds[k], dds[k], x.smoothing[k])
                columns.append([direction[k] * along for direction in directions])
        return Results({"Y": [list(row) for row in zip(*columns, strict=True)]}, dynamics.checks)

    return Program(("u", "du", "ddu", "branch", "guess", "gravity", "smoothing"), run)


_UNIT_FORCES: dict[str, Callable[[Scalar, Scalar, Scalar], Scalar]] = {
    "viscous": lambda rate, _acceleration, _smoothing: rate,
    "coulomb": lambda rate, _acceleration, smoothing: smooth_sign(rate, smoothing),
    "armature": lambda _rate, acceleration, _smoothing: acceleration,
}


def unit_wrenches(motion: BodyMotion) -> list[Wrench]:
    """The wrench of a body for each of its ten parameters at one, the others zero."""
    omega, alpha, accel = motion
    wrenches: list[Wrench] = [(accel, ZERO3)]
    wrenches += [
        (add(cross(alpha, e), cross(omega, cross(omega, e))), cross(e, accel)) for e in IDENTITY3
    ]
    for i, j in _PAIRS:
        unit = tuple(
            tuple(1.0 if (r, c) in ((i, j), (j, i)) else 0.0 for c in range(3)) for r in range(3)
        )
        moment: Vector = add(matvec(unit, alpha), cross(omega, matvec(unit, omega)))  # type: ignore[arg-type]
        wrenches.append((ZERO3, moment))
    return wrenches


def _power(twist: Twist, wrench: Wrench) -> Scalar:
    return dot(twist[0], wrench[1]) + dot(twist[1], wrench[0])
