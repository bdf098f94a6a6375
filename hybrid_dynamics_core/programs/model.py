"""What every program works on: the model of a robot, its named input vectors."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from ..algebra.scalar import Scalar
from ..closure.plan import ClosurePlan
from ..dynamics.load_pattern import FRICTION, SPRINGS, LoadValues
from ..kernels.run import Kernel
from ..kernels.trace import Results
from ..mechanism.tree import Tree

Scalars = Sequence[Scalar]

ALONG_S = ("guess", "armature", *FRICTION, *SPRINGS)  # inputs with one entry a coordinate


@dataclass(frozen=True)
class Model:
    """What the programs compute with: the tree and the plan that closes its loops."""

    tree: Tree
    plan: ClosurePlan

    def size(self, name: str) -> int:
        """Length of an input vector."""
        if name in ALONG_S:
            return len(self.tree.coordinates)
        return {"branch": len(self.plan.blocks), "gravity": 3}.get(name, len(self.plan.given))


@dataclass(frozen=True)
class Inputs(LoadValues):
    """Input vectors; a program has those that it names.

    Active coordinates, rates, accelerations and efforts; branch sign of each step; s where
    iterations start; gravity [m/s^2]; values of the loads.
    """

    u: Scalars = ()
    du: Scalars = ()
    ddu: Scalars = ()
    tau: Scalars = ()
    branch: Scalars = ()
    guess: Scalars = ()
    gravity: Scalars = ()


@dataclass(frozen=True)
class Program:
    """The names of its input vectors, in order, and the text; `sizes` of those that the model does not know."""

    inputs: tuple[str, ...]
    run: Callable[[Model, Inputs], Results]
    sizes: Mapping[str, int] = field(default_factory=dict)

    def size(self, model: Model, name: str) -> int:
        """Length of an input vector."""
        return self.sizes.get(name) or model.size(name)

    def kernel(self, model: Model, label: str) -> Kernel:
        """The program on a model as functions of arrays, its inputs in order; `label`: what it is called by people."""

        def run(*vectors: Scalars) -> Results:
            return self.run(model, Inputs(**dict(zip(self.inputs, vectors, strict=True))))

        return Kernel(run, [self.size(model, name) for name in self.inputs], label=label)
