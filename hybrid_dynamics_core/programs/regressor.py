"""The regressor Y of  Y(u, u', u'') pi = tau  through the closed loops."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ..algebra.linear import transposed
from ..algebra.scalar import Scalar, Scalars
from ..algebra.vector import IDENTITY3, ZERO3, Rotation, Vector, add, cross, dot, matvec, scale
from ..dynamics.bilinear import Twist, body_twists
from ..dynamics.load_pattern import smooth_sign
from ..dynamics.parameters import Parameters
from ..dynamics.spanning import BodyMotion, TreeDynamics, Wrench
from ..kernels.trace import Results
from ..mechanism.joint_velocity import joint_accelerations, joint_velocities
from .dynamics import Dynamics, columns_of
from .model import AT_ACCELERATION, Inputs, Model, Program

# unit inertias: the matrix of each parameter Jxx, Jxy, Jxz, Jyy, Jyz, Jzz
_UNIT_INERTIAS: tuple[Rotation, ...] = (
    ((1.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
    ((0.0, 1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
    ((0.0, 0.0, 1.0), (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)),
    ((0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 0.0)),
    ((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)),
    ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
)


def regressor(parameters: Parameters) -> Program:
    """Program for Y (n, p).

    A body's wrench is linear in its ten parameters. Its power over the body's twist per unit rate
    of an active coordinate is a term of tau. These twists come from R.
    """

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x)
        tree = dynamics.tree
        ds = dynamics.ds
        dds = dynamics.motion.accelerations(x.ddu, ds)
        directions = columns_of(dynamics.motion)
        twists = [body_twists(tree, direction) for direction in directions]
        motions = _felt_motions(tree, dynamics.gravity, ds, dds)
        columns: list[list[Scalar]] = []
        for link in parameters.links:
            body = model.tree.body_index(link)
            twists_of_body = [twist[body] for twist in twists]
            wrenches = unit_wrenches(motions[body])
            columns += [_powers(twists_of_body, wrench) for wrench in wrenches]
        if parameters.joints:
            columns += _joint_columns(model, x, parameters, dynamics, dds)
        return Results({"Y": transposed(columns)}, dynamics.checks)

    return Program((*AT_ACCELERATION, "smoothing"), run)


def _felt_motions(
    tree: TreeDynamics, gravity: Vector, ds: Scalars, dds: Scalars
) -> list[BodyMotion]:
    """Motions of the bodies, with gravity subtracted for parameters with weight."""
    motions = tree.motions(gravity, ds, dds)
    for k, (body, local) in enumerate(
        zip(tree.tree.bodies, tree.in_link_axes(gravity), strict=True)
    ):
        if body.is_compensated and body.mass:
            omega, alpha, accel = motions[k]
            share = body.compensated_mass / body.mass
            motions[k] = omega, alpha, add(accel, scale(share, local))
    return motions


def _joint_columns(
    model: Model,
    x: Inputs,
    parameters: Parameters,
    dynamics: Dynamics,
    dds: list[Scalar],
) -> list[list[Scalar]]:
    """The columns of friction and rotors."""
    tree, configuration, ds = model.tree, dynamics.motion.configuration, dynamics.ds
    velocities = joint_velocities(tree, configuration, ds)
    accelerations = joint_accelerations(tree, configuration, dds, ds, ds)
    directions = [
        joint_velocities(tree, configuration, column) for column in columns_of(dynamics.motion)
    ]
    columns: list[list[Scalar]] = []
    for kind, joint in parameters.joints:
        k = tree.coordinates.index(joint)
        along = _UNIT_FORCES[kind](velocities[k], accelerations[k], x.smoothing[k])
        columns.append([direction[k] * along for direction in directions])
    return columns


# of a joint's rate, acceleration and smoothing
_UNIT_FORCES: dict[str, Callable[[Scalar, Scalar, Scalar], Scalar]] = {
    "viscous": lambda rate, _acceleration, _smoothing: rate,
    "coulomb": lambda rate, _acceleration, smoothing: smooth_sign(rate, smoothing),
    "armature": lambda _rate, acceleration, _smoothing: acceleration,
}


def unit_wrenches(motion: BodyMotion) -> list[Wrench]:
    """The wrench of a body for each of its ten parameters, set to one while the others are zero."""
    omega, alpha, accel = motion
    wrenches: list[Wrench] = [(accel, ZERO3)]
    for unit in IDENTITY3:
        centripetal = cross(omega, cross(omega, unit))
        force = add(cross(alpha, unit), centripetal)
        wrenches.append((force, cross(unit, accel)))
    for inertia in _UNIT_INERTIAS:
        gyroscopic = cross(omega, matvec(inertia, omega))
        moment = add(matvec(inertia, alpha), gyroscopic)
        wrenches.append((ZERO3, moment))
    return wrenches


def _powers(twists: Sequence[Twist], wrench: Wrench) -> list[Scalar]:
    """Power of a wrench over some motions."""
    return [_power(twist, wrench) for twist in twists]


def _power(twist: Twist, wrench: Wrench) -> Scalar:
    omega, v = twist
    force, moment = wrench
    return dot(omega, moment) + dot(v, force)
