"""The common ground of all programs: the model of a robot, and named input vectors."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from ..algebra.scalar import Scalars
from ..closure.plan import ClosurePlan
from ..description.model import Closure
from ..dynamics.load_pattern import FRICTION, SPRINGS, LoadPattern, LoadValues
from ..dynamics.parallel_axes import Layout, lay_out
from ..dynamics.pins import Pin, find_pins
from ..dynamics.regrouped import regrouped
from ..ground.lazy import lazy
from ..kernels.run import Kernel
from ..kernels.trace import Results
from ..mechanism.tree import Tree

ALONG_S = (
    "guess",
    "start",
    "predicted",
    "forces",
    "armature",
    *FRICTION,
    *SPRINGS,
)  # inputs with one entry a coordinate
GRAVITY = 3
SINGULAR = 1e-5  # of 64 bits


@dataclass(frozen=True)
class Model:
    """The constants of a robot that programs read.

    Attributes:
        tree: the spanning tree.
        plan: closure plan.
        idle: indices of the active coordinates that nobody drives.
        closures: closures of the description.
        singular: distance to a singularity below which rates would lose half their digits.
    """

    tree: Tree
    plan: ClosurePlan
    idle: tuple[int, ...] = ()
    closures: tuple[Closure, ...] = ()
    singular: float = SINGULAR

    @lazy
    def regrouped(self) -> Tree:
        """The tree with few inertial parameters, for forces along the given coordinates alone."""
        return regrouped(self.tree, self.plan, self.closures)

    @lazy
    def layout(self) -> Layout | None:
        """The axes that links with parallel joints have in common; None for those of links."""
        return lay_out(self.regrouped, self.plan)

    @property
    def measured(self) -> Tree:
        """The tree of floats from which scales of inertia are taken."""
        return self.tree

    def pins(self, closures: Sequence[Closure]) -> list[Pin]:
        """The pins of closures."""
        return find_pins(self.tree, self.plan, closures)

    def size(self, name: str) -> int:
        """Length of an input vector."""
        if name in ALONG_S:
            return len(self.tree.coordinates)
        if name == "branch":
            return len(self.plan.blocks) + len(self.tree.charts)
        if name == "start_map":
            return len(self.tree.coordinates) * len(self.plan.given)
        if name == "gravity":
            return GRAVITY
        return len(self.plan.given)


@dataclass(frozen=True)
class Inputs(LoadValues):
    """Input vectors; a program has only those that it names.

    Attributes:
        u: active coordinates (n,) [rad, m].
        du: their rates (n,).
        ddu: their accelerations (n,).
        tau: their efforts (n,) [N m, N].
        branch: branch sign of each block, then the chart of each ball or free joint.
        guess: start of the iterations, all coordinates (n_s,).
        start: a closed configuration to come from, all coordinates (n_s,), in place of a guess.
        start_map: R there, row by row (n_s * n,).
        predicted: change of all coordinates from the start (n_s,), in place of R there.
        move_after: change of the given coordinates (n,) to the next state [rad, m].
        gravity: (3,) [m/s^2], base axes.
        forces: along all coordinates (n_s,) [N m, N].
        position: target (3,) of an end effector [m].
        rotation: target (9,), row by row.
        weights: of the errors along and about x, y, z (6,).
        seed_u: change of u (n,) in a direction, and so on.
    """

    u: Scalars = ()
    du: Scalars = ()
    ddu: Scalars = ()
    tau: Scalars = ()
    branch: Scalars = ()
    guess: Scalars = ()
    start: Scalars = ()
    start_map: Scalars = ()
    predicted: Scalars = ()
    move_after: Scalars = ()
    gravity: Scalars = ()
    forces: Scalars = ()
    position: Scalars = ()
    rotation: Scalars = ()
    weights: Scalars = ()
    seed_u: Scalars = ()
    seed_du: Scalars = ()
    seed_ddu: Scalars = ()
    seed_tau: Scalars = ()


ProgramText = Callable[[Model, Inputs], Results]


@dataclass(frozen=True)
class Program:
    """A function that computes named outputs from named inputs.

    Attributes:
        inputs: names of its input vectors, in order.
        run: the function.
        sizes: lengths of the inputs that do not follow from the model.
    """

    inputs: tuple[str, ...]
    run: ProgramText
    sizes: Mapping[str, int] = field(default_factory=dict)

    def size(self, model: Model, name: str) -> int:
        """Length of an input vector."""
        return self.sizes.get(name) or model.size(name)

    def from_start(self) -> Program:
        """The same from a closed configuration nearby, in place of a guess.

        Its status is `JUMP` if the move from there is not smooth.
        """
        inputs: list[str] = []
        for name in self.inputs:
            inputs += FROM_START if name == "guess" else (name,)
        return Program(tuple(inputs), self.run, self.sizes)

    def from_prediction(self) -> Program:
        """The same from a closed configuration nearby, at which R has predicted this one.

        The guess remains. The status is `JUMP` if the move is not smooth.
        """
        return Program((*self.inputs, "start", "predicted"), self.run, self.sizes)

    def kernel(self, model: Model, label: str) -> Kernel:
        """The program on a model as functions of arrays, its inputs in order.

        Args:
            model: the robot.
            label: its name in messages while it is compiled.
        """

        def run(*vectors: Scalars) -> Results:
            named = dict(zip(self.inputs, vectors, strict=True))
            return self.run(model, Inputs(**named))

        sizes = [self.size(model, name) for name in self.inputs]
        return Kernel(run, sizes, label=label)


# inputs of programs, before those of the loads
FROM_START = ("start", "start_map")
AT_POSITION = ("u", "branch", "guess")
AT_STATE = ("u", "du", "branch", "guess")
UNDER_GRAVITY = (*AT_STATE, "gravity")
AT_ACCELERATION = ("u", "du", "ddu", "branch", "guess", "gravity")
AT_EFFORT = ("u", "du", "tau", "branch", "guess", "gravity")


def with_loads(inputs: tuple[str, ...], run: ProgramText, pattern: LoadPattern) -> Program:
    """A program that takes the values of a load pattern after its other inputs."""
    return Program((*inputs, *pattern.inputs), run, pattern.sizes)
