"""The model's answers as programs over scalars: the one text of closure, kinematics and minimal-form dynamics.

A program takes named vectors of scalars and returns named outputs with the checks that guard them. It runs on floats
as it stands, on arrays (one array a scalar), or traced into a kernel. Chu (2020) gives the equations.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from .algebra.scalar import Scalar
from .algebra.vector import Rotation, Vector, add, matmul, matvec
from .closure.passive import ClosedMotion
from .closure.plan import ClosurePlan
from .description.model import Frame
from .dynamics.spanning import TreeKinematics
from .kernels.trace import Check, Results
from .mechanism.tree import Tree, frame_offset

SINGULAR = 1e-5  # reciprocal condition below which rates would lose half their digits
Scalars = Sequence[Scalar]


@dataclass(frozen=True)
class Model:
    """What the programs compute with: the tree and the plan that closes its loops."""

    tree: Tree
    plan: ClosurePlan

    def size(self, name: str) -> int:
        """Length of an input vector."""
        n = len(self.plan.given)
        sizes = {"branch": len(self.plan.steps), "guess": len(self.tree.coordinates), "gravity": 3}
        return sizes.get(name, n)


@dataclass(frozen=True)
class Inputs:
    """Input vectors; a program has those that it names.

    Active coordinates, rates, accelerations; branch sign of each step; s where iterations start; gravity [m/s^2].
    """

    u: Scalars = ()
    du: Scalars = ()
    ddu: Scalars = ()
    branch: Scalars = ()
    guess: Scalars = ()
    gravity: Scalars = ()


@dataclass(frozen=True)
class Program:
    """The names of the input vectors it needs, in order, and the text."""

    inputs: tuple[str, ...]
    run: Callable[[Model, Inputs], Results]


def closure_code(step: int) -> int:
    """Status of a state in which the step cannot close."""
    return 2 * step + 1


def singular_code(step: int) -> int:
    """Status of a state in which the step is singular."""
    return 2 * step + 2


def _motion(model: Model, x: Inputs) -> tuple[ClosedMotion, list[Check], list[Scalar]]:
    """The closed motion, its checks, and each step's distance to a singularity."""
    motion = ClosedMotion(model.tree, model.plan, x.u, x.branch, x.guess)
    distances = motion.distances()
    checks = []
    for k, (margin, distance) in enumerate(zip(motion.margins, distances, strict=True)):
        checks += [Check(margin, 0.0, closure_code(k)), Check(distance, SINGULAR, singular_code(k))]
    checks += [Check(guard, 0.0, closure_code(len(distances))) for guard in motion.guards]
    return motion, checks, distances


def _close(model: Model, x: Inputs) -> Results:
    """All coordinates, their rates, R, R' u', and the evidence."""
    motion, checks, distances = _motion(model, x)
    ds = motion.rates(x.du)
    outputs = {
        "s": motion.posture.q,
        "ds": ds,
        "R": motion.velocity_map(),
        "bias": motion.accelerations([0.0] * len(x.u), ds),
        "residuals": motion.residuals,
        "distances": distances,
    }
    return Results(outputs, checks)


def _accelerations(model: Model, x: Inputs) -> Results:
    """s'' of all coordinates."""
    motion, checks, _ = _motion(model, x)
    return Results({"dds": motion.accelerations(x.ddu, motion.rates(x.du))}, checks)


def frame_pose(tree: TreeKinematics, frame: Frame) -> tuple[Rotation, Vector]:
    """Rotation and origin of a named frame in the base frame."""
    rotation, origin = tree.pose(tree.tree.body_index(frame.link))
    own_rotation, own_origin = frame_offset(frame)
    return matmul(rotation, own_rotation), add(origin, matvec(rotation, own_origin))


def forward_kinematics(frame: Frame) -> Program:
    """Program for the pose of one frame."""

    def run(model: Model, x: Inputs) -> Results:
        motion, checks, _ = _motion(model, x)
        rotation, position = frame_pose(TreeKinematics(model.tree, motion.posture), frame)
        return Results({"position": position, "rotation": rotation}, checks)

    return Program(("u", "branch", "guess"), run)


def jacobian(frame: Frame) -> Program:
    """Program for the (6, n) Jacobian of one frame's origin with respect to u: J = J_tree R."""

    def run(model: Model, x: Inputs) -> Results:
        motion, checks, _ = _motion(model, x)
        tree = TreeKinematics(model.tree, motion.posture)
        _, position = frame_pose(tree, frame)
        columns = tree.jacobian(model.tree.body_index(frame.link), position)
        velocity_map = motion.velocity_map()
        rows: list[list[Scalar]] = [[0.0] * len(x.u) for _ in range(6)]
        for k, (linear, angular) in columns.items():
            for i, part in enumerate((*linear, *angular)):
                for j, factor in enumerate(velocity_map[k]):
                    rows[i][j] = rows[i][j] + part * factor
        return Results({"jacobian": rows}, checks)

    return Program(("u", "branch", "guess"), run)


def _inverse_dynamics(model: Model, x: Inputs) -> Results:
    """tau = R^T (M s'' + C s' + g), Chu (2020), Eq. 22 to 25."""
    motion, checks, _ = _motion(model, x)
    ds = motion.rates(x.du)
    tree = TreeKinematics(model.tree, motion.posture)
    forces = tree.inverse_dynamics(tuple(x.gravity), ds, motion.accelerations(x.ddu, ds))
    return Results({"tau": motion.project(forces)[0]}, checks)


def _minimal_form(model: Model, x: Inputs) -> Results:
    """M-bar, C-bar u' and G-bar of  M-bar u'' + C-bar u' + G-bar = tau, Chu (2020), Eq. 25."""
    motion, checks, _ = _motion(model, x)
    tree = TreeKinematics(model.tree, motion.posture)
    still: list[Scalar] = [0.0] * motion.size
    ds = motion.rates(x.du)
    no_gravity: Vector = (0.0, 0.0, 0.0)
    n = len(x.u)

    def tau(g: Vector, rates: list[Scalar], dds: list[Scalar]) -> list[Scalar]:
        return motion.project(tree.inverse_dynamics(g, rates, dds))[0]

    columns = [tau(no_gravity, still, list(column)) for column in zip(*motion.velocity_map(), strict=True)]
    mass = [[columns[min(i, j)][max(i, j)] for j in range(n)] for i in range(n)]
    bias = tau(no_gravity, ds, motion.accelerations([0.0] * n, ds))
    return Results({"M": mass, "h": bias, "g": tau(tuple(x.gravity), still, still)}, checks)


CLOSE = Program(("u", "du", "branch", "guess"), _close)
ACCELERATIONS = Program(("u", "du", "ddu", "branch", "guess"), _accelerations)
INVERSE_DYNAMICS = Program(("u", "du", "ddu", "branch", "guess", "gravity"), _inverse_dynamics)
MINIMAL_FORM = Program(("u", "du", "branch", "guess", "gravity"), _minimal_form)
