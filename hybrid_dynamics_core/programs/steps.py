"""One step of inverse kinematics: damped least squares over the active coordinates."""

from __future__ import annotations

from ..algebra.definite import Definite
from ..algebra.linear import Rows
from ..algebra.scalar import Scalar, Scalars, atan2, larger, sqrt
from ..algebra.vector import Rotation, dot, matmul, scale, sub, trace, transpose
from ..description.model import Frame
from ..kernels.trace import Results
from .closure import closed_motion
from .kinematics import pose_of
from .model import AT_POSITION, Inputs, Model, Program

TARGET = {"position": 3, "rotation": 9, "weights": 6}
DAMPING = 1e-4  # share of the mean diagonal entry of J^T J
LONGEST = 0.2  # [rad or m] length of a step
TINY = 1e-15


def ik_step(frame: Frame) -> Program:
    """Program for a step of u toward a target pose of a frame.

    Inputs are the position (3,), the rotation (9,) row by row, and weights (6,) of the errors
    along and about x, y, z; a zero leaves an error out. Outputs are `next`, u after the step (n,),
    and `error` (6,) before it: the way to the target, then the rotation vector in base axes.
    Targets are within half a turn.
    """

    def run(model: Model, x: Inputs) -> Results:
        motion, checks, _ = closed_motion(model, x)
        rotation, position, rows = pose_of(model, motion, frame)
        target = _matrix(x.rotation)
        turn = rotation_vector(matmul(target, transpose(rotation)))
        error = [*sub(x.position, position), *turn]
        move = _damped(rows, error, x.weights)
        following = [a + b for a, b in zip(x.u, move, strict=True)]
        return Results({"next": following, "error": error}, checks)

    return Program((*AT_POSITION, *TARGET), run, TARGET)


def rotation_vector(r: Rotation) -> list[Scalar]:
    """The rotation vector of a rotation; below half a turn."""
    (_, xy, xz), (yx, _, yz), (zx, zy, _) = r
    sines = scale(0.5, (zy - yz, xz - zx, yx - xy))
    sine = sqrt(dot(sines, sines) + TINY * TINY)
    angle = atan2(sine, 0.5 * (trace(r) - 1.0))
    return list(scale(angle / sine, sines))


def _matrix(flat: Scalars) -> Rotation:
    return tuple(flat[:3]), tuple(flat[3:6]), tuple(flat[6:])


def _damped(jacobian: Rows, error: Scalars, weights: Scalars) -> list[Scalar]:
    """The step (n,) that minimises the weighted error, damped and of limited length."""
    weighted: Rows = []
    wanted: list[Scalar] = []
    for row, value, weight in zip(jacobian, error, weights, strict=True):
        weighted.append([weight * entry for entry in row])
        wanted.append(weight * value)
    columns = [tuple(column) for column in zip(*weighted, strict=True)]
    normal = [[dot(a, b) for b in columns] for a in columns]
    total: Scalar = TINY
    for k in range(len(columns)):
        total = total + normal[k][k]
    for k in range(len(columns)):
        normal[k][k] = normal[k][k] + DAMPING / len(columns) * total
    move = Definite(normal).solve([dot(column, tuple(wanted)) for column in columns])
    length = sqrt(dot(tuple(move), tuple(move)))
    return list(scale(1.0 / larger(length / LONGEST, 1.0), move))
