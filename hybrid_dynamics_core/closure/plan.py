"""The order in which loops close: equations matched to unknowns, grouped into blocks, blocks ordered by need."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components, maximum_bipartite_matching

from ..description.model import Closure, RobotDescription
from ..mechanism.tree import Tree
from .dyad import dyad
from .parallelogram import PARALLELOGRAM, Parallelogram
from .planar import PlanarLoop, planar_loop
from .posture import Posture
from .step import Step


@dataclass(frozen=True)
class ClosurePlan:
    """Blocks in solving order, the branch sign of each (+1, -1), and the closed reference posture (floats)."""

    steps: tuple[Step, ...]
    branch: tuple[float, ...]
    reference: Posture


def build_plan(tree: Tree, robot: RobotDescription) -> ClosurePlan:
    """Plan the closure of every loop for the active coordinates given.

    Raises DescriptionError where the loops do not fit the active joints or do not close at the reference.
    """
    loops = {c.name: _planar(tree, robot, c) for c in robot.closures}
    posture = given_posture(tree, [robot.reference.get(name, 0.0) for name in tree.coordinates[: tree.n_active]])
    near = {k: robot.reference[name] for k, name in enumerate(tree.coordinates) if name in robot.reference}
    steps: list[Step] = []
    branch: list[float] = []
    for names, unknowns in _blocks(tree, robot, loops):
        if len(names) > 1:
            raise robot.error("loops", f"{', '.join(names)} only close together, which format 1 does not cover")
        closure = next(c for c in robot.closures if c.name == names[0])
        steps.append(_step(robot, loops[closure.name], closure, unknowns, near))
        branch.append(_Branch(robot, steps[-1], closure, near).choose(posture))
    return ClosurePlan(tuple(steps), tuple(branch), posture)


def given_posture(tree: Tree, u: list[float]) -> Posture:
    """A posture with the active coordinates set; any scalar type."""
    posture = Posture(len(tree.coordinates))
    for body in tree.bodies:
        if body.coordinate < tree.n_active:
            put = posture.set_angle if body.type == "revolute" else posture.set_length
            put(body.coordinate, u[body.coordinate])
    return posture


def _planar(tree: Tree, robot: RobotDescription, closure: Closure) -> PlanarLoop:
    try:
        return planar_loop(tree, closure)
    except ValueError as error:
        raise robot.error(f"loops.{closure.name}", str(error)) from error


def _blocks(
    tree: Tree, robot: RobotDescription, loops: dict[str, PlanarLoop]
) -> list[tuple[list[str], tuple[int, ...]]]:
    """(loops, unknown coordinates) of each block, in solving order."""
    n_z = len(tree.coordinates) - tree.n_active
    equations = [name for name in loops for _ in range(2)]
    pairs = [
        (row, joint.coordinate - tree.n_active)
        for row, name in enumerate(equations)
        for joint in loops[name].joints
        if joint.coordinate >= tree.n_active
    ]
    _check_count(tree, robot, len(equations))
    if not equations:
        return []
    incidence = csr_array(
        coo_array((np.ones(len(pairs)), np.array(pairs, dtype=np.int32).T), shape=(len(equations), n_z))
    )
    matched = maximum_bipartite_matching(incidence, perm_type="column")
    if np.any(matched < 0):
        free = sorted(set(range(n_z)) - set(matched.tolist()))
        names = ", ".join(tree.coordinates[tree.n_active + k] for k in free)
        raise robot.error("active", f"the loops do not determine {names}; choose other active joints or add a loop")
    depends = csr_array(incidence[:, matched])
    _, label = connected_components(depends, directed=True, connection="strong")
    return _ordered(depends, label, equations, [tree.n_active + int(m) for m in matched])


def _check_count(tree: Tree, robot: RobotDescription, n_equations: int) -> None:
    freedom = len(tree.coordinates) - n_equations
    if freedom != tree.n_active:
        raise robot.error(
            "active",
            f"{tree.n_active} joints are named, but {len(tree.coordinates)} joints with {n_equations} loop equations "
            f"have {freedom} degrees of freedom; name {freedom}",
        )


def _ordered(
    depends: csr_array, label: np.ndarray, equations: list[str], unknown: list[int]
) -> list[tuple[list[str], tuple[int, ...]]]:
    """Blocks such that each needs only earlier ones (file order among equals)."""
    waiting = list(dict.fromkeys(label.tolist()))
    rows = {block: np.flatnonzero(label == block) for block in waiting}
    needs = {
        block: {int(label[k]) for r in rows[block] for k in depends[[r], :].indices} - {block} for block in waiting
    }
    result = []
    while waiting:
        block = next(b for b in waiting if not needs[b] & set(waiting))
        waiting.remove(block)
        names = list(dict.fromkeys(equations[r] for r in rows[block]))
        result.append((names, tuple(unknown[r] for r in rows[block])))
    return result


def _step(
    robot: RobotDescription, loop: PlanarLoop, closure: Closure, unknowns: tuple[int, ...], near: dict[int, float]
) -> Step:
    first, second = (j for j in loop.joints if j.coordinate in unknowns)
    if closure.assembly != PARALLELOGRAM:
        return dyad(loop, (first, second), near)
    try:
        return Parallelogram(loop, (first, second))
    except ValueError as error:
        raise robot.error(f"loops.{closure.name}.assembly", f"is not a parallelogram: {error}") from error


class _Branch:
    """Choice of a step's assembly mode: the one the file names or, without a name, the one nearest its reference."""

    def __init__(self, robot: RobotDescription, step: Step, closure: Closure, near: dict[int, float]) -> None:
        self.robot, self.step, self.near = robot, step, near
        self.mode = closure.assembly
        self.key = f"loops.{closure.name}"
        self.told = [k for k in step.unknowns if k in near]

    def choose(self, posture: Posture) -> float:
        """The branch sign; leaves the step solved at the reference."""
        best = min(self._signs(), key=lambda sign: self._distance(posture, sign))
        if not self.step.solve(posture, best) > 0.0:
            problem = "does not close at the reference configuration; mend the geometry or give a reference that closes"
            raise self.robot.error(self.key, problem)
        if isinstance(self.step, Parallelogram):
            self.step.near(posture, self.near)
            self.step.solve(posture, best)
        return best

    def _signs(self) -> list[float]:
        modes = self.step.modes
        if self.mode is not None and self.mode not in modes:
            raise self.robot.error(f"{self.key}.assembly", f"is '{self.mode}'; this loop has {' and '.join(modes)}")
        if self.mode is not None:
            return [1.0, -1.0][modes.index(str(self.mode)) :][:1]
        if len(modes) > 1 and not self.told:
            raise self.robot.error(
                self.key,
                f"has the assembly modes {' and '.join(modes)}; name one as assembly, or give its joints in reference",
            )
        return [1.0, -1.0][: len(modes)]

    def _distance(self, posture: Posture, sign: float) -> float:
        if not self.step.solve(posture, sign) > 0.0:
            return np.inf
        return float(sum(abs(posture.q[k] - self.near[k]) for k in self.told))
