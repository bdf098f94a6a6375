"""The model's answers as programs over scalars: the one text of closure, kinematics and minimal-form dynamics.

Each program takes vectors of scalars and returns named outputs with the checks that guard them. It runs on floats
as it stands, on arrays (one array a scalar), or traced into a kernel. Chu (2020) gives the equations.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from .algebra.scalar import Scalar, absolute
from .algebra.vector import Rotation, Vector, add, matmul, matvec
from .closure.passive import ClosedMotion
from .closure.plan import ClosurePlan
from .description.model import Frame
from .dynamics.spanning import TreeKinematics
from .kernels.trace import Check, Results
from .mechanism.tree import Tree, frame_offset

SINGULAR = 1e-5  # reciprocal condition below which rates would lose half their digits
Scalars = Sequence[Scalar]
Program = Callable[..., Results]


@dataclass(frozen=True)
class Model:
    """What the programs compute with: the tree and the plan that closes its loops."""

    tree: Tree
    plan: ClosurePlan


def closure_code(step: int) -> int:
    """Status of a state in which the step cannot close."""
    return 2 * step + 1


def singular_code(step: int) -> int:
    """Status of a state in which the step is singular."""
    return 2 * step + 2


def _motion(model: Model, u: Scalars, branch: Scalars) -> tuple[ClosedMotion, list[Check], list[Scalar]]:
    """The closed motion, its checks, and each block's distance to a singularity |det| / ||J_z||_F^2 * 2, in [0, 1]."""
    motion = ClosedMotion(model.tree, model.plan, u, branch)
    checks, distances = [], []
    for k, (margin, (determinant, squares)) in enumerate(zip(motion.margins, motion.determinants(), strict=True)):
        distance = 2.0 * absolute(determinant) / squares
        distances.append(distance)
        checks += [Check(margin, 0.0, closure_code(k)), Check(distance, SINGULAR, singular_code(k))]
    return motion, checks, distances


def close(model: Model, u: Scalars, du: Scalars, branch: Scalars) -> Results:
    """All coordinates, their rates, R, R' u', and the evidence."""
    motion, checks, distances = _motion(model, u, branch)
    ds = motion.rates(du)
    residuals: list[Scalar] = [r for block in motion.blocks for r in block.residual]
    outputs = {
        "s": motion.posture.q,
        "ds": ds,
        "R": motion.velocity_map(),
        "bias": motion.accelerations([0.0] * motion.n, ds),
        "residuals": residuals,
        "distances": distances,
    }
    return Results(outputs, checks)


def accelerations(model: Model, u: Scalars, du: Scalars, ddu: Scalars, branch: Scalars) -> Results:
    """s'' of all coordinates."""
    motion, checks, _ = _motion(model, u, branch)
    return Results({"dds": motion.accelerations(ddu, motion.rates(du))}, checks)


def frame_pose(tree: TreeKinematics, frame: Frame) -> tuple[Rotation, Vector]:
    """Rotation and origin of a named frame in the base frame."""
    rotation, origin = tree.pose(tree.tree.body_index(frame.link))
    own_rotation, own_origin = frame_offset(frame)
    return matmul(rotation, own_rotation), add(origin, matvec(rotation, own_origin))


def forward_kinematics(frame: Frame) -> Callable[..., Results]:
    """Program for the pose of one frame."""

    def program(model: Model, u: Scalars, branch: Scalars) -> Results:
        motion, checks, _ = _motion(model, u, branch)
        rotation, position = frame_pose(TreeKinematics(model.tree, motion.posture), frame)
        return Results({"position": position, "rotation": rotation}, checks)

    return program


def jacobian(frame: Frame) -> Callable[..., Results]:
    """Program for the (6, n) Jacobian of one frame's origin with respect to u: J = J_tree R."""

    def program(model: Model, u: Scalars, branch: Scalars) -> Results:
        motion, checks, _ = _motion(model, u, branch)
        tree = TreeKinematics(model.tree, motion.posture)
        _, position = frame_pose(tree, frame)
        columns = tree.jacobian(model.tree.body_index(frame.link), position)
        velocity_map = motion.velocity_map()
        rows: list[list[Scalar]] = [[0.0] * motion.n for _ in range(6)]
        for k, (linear, angular) in columns.items():
            for i, part in enumerate((*linear, *angular)):
                for j, factor in enumerate(velocity_map[k]):
                    rows[i][j] = rows[i][j] + part * factor
        return Results({"jacobian": rows}, checks)

    return program


def inverse_dynamics(model: Model, u: Scalars, du: Scalars, ddu: Scalars, branch: Scalars, gravity: Scalars) -> Results:
    """tau = R^T (M s'' + C s' + g), Chu (2020), Eq. 22 to 25."""
    motion, checks, _ = _motion(model, u, branch)
    ds = motion.rates(du)
    tree = TreeKinematics(model.tree, motion.posture)
    forces = tree.inverse_dynamics(tuple(gravity), ds, motion.accelerations(ddu, ds))
    return Results({"tau": motion.project(forces)[0]}, checks)


def minimal_form(model: Model, u: Scalars, du: Scalars, branch: Scalars, gravity: Scalars) -> Results:
    """M-bar, C-bar u' and G-bar of  M-bar u'' + C-bar u' + G-bar = tau, Chu (2020), Eq. 25."""
    motion, checks, _ = _motion(model, u, branch)
    tree = TreeKinematics(model.tree, motion.posture)
    still: list[Scalar] = [0.0] * motion.size
    ds = motion.rates(du)
    no_gravity: Vector = (0.0, 0.0, 0.0)

    def tau(g: Vector, rates: list[Scalar], dds: list[Scalar]) -> list[Scalar]:
        return motion.project(tree.inverse_dynamics(g, rates, dds))[0]

    columns = [tau(no_gravity, still, list(column)) for column in zip(*motion.velocity_map(), strict=True)]
    mass = [[columns[min(i, j)][max(i, j)] for j in range(motion.n)] for i in range(motion.n)]
    bias = tau(no_gravity, ds, motion.accelerations([0.0] * motion.n, ds))
    return Results({"M": mass, "h": bias, "g": tau(tuple(gravity), still, still)}, checks)
