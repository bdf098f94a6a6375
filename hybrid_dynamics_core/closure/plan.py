"""The order in which loops close: equations and unknowns matched, grouped into blocks, blocks in order of dependence."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components, maximum_bipartite_matching

from ..description.model import Closure, RobotDescription
from ..errors import DescriptionError
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
    """Plan the closure of every loop for the active coordinates given."""
    loops = {c.name: _planar(tree, c) for c in robot.closures}
    closures = {c.name: c for c in robot.closures}
    posture = given_posture(tree, [robot.reference.get(name, 0.0) for name in tree.coordinates[: tree.n_active]])
    near = {k: robot.reference[name] for k, name in enumerate(tree.coordinates) if name in robot.reference}
    steps: list[Step] = []
    branch: list[float] = []
    for names, unknowns in _blocks(tree, loops):
        if len(names) > 1:
            raise DescriptionError(
                f"loops {', '.join(names)} can only be closed together, which format 1 does not cover", key="loops"
            )
        name = names[0]
        step = _step(tree, loops[name], closures[name], unknowns, near)
        steps.append(step)
        branch.append(_choose_branch(tree, step, closures[name], posture, near))
    return ClosurePlan(tuple(steps), tuple(branch), posture)


def given_posture(tree: Tree, u: list[float]) -> Posture:
    """A posture with the active coordinates set; any scalar type."""
    posture = Posture(len(tree.coordinates))
    for body in tree.bodies:
        if body.coordinate < tree.n_active:
            put = posture.set_angle if body.type == "revolute" else posture.set_length
            put(body.coordinate, u[body.coordinate])
    return posture


def _planar(tree: Tree, closure: Closure) -> PlanarLoop:
    try:
        return planar_loop(tree, closure)
    except ValueError as error:
        raise DescriptionError(str(error), key=f"loops.{closure.name}") from error


def _blocks(tree: Tree, loops: dict[str, PlanarLoop]) -> list[tuple[list[str], tuple[int, ...]]]:
    """(loops, unknown coordinates) of each block, in solving order."""
    n_z = len(tree.coordinates) - tree.n_active
    equations = [name for name in loops for _ in range(2)]
    pairs = [
        (row, joint.coordinate - tree.n_active)
        for row, name in enumerate(equations)
        for joint in loops[name].joints
        if joint.coordinate >= tree.n_active
    ]
    _check_count(tree, len(equations), n_z)
    if not equations:
        return []
    incidence = csr_array(coo_array((np.ones(len(pairs)), np.array(pairs).T), shape=(len(equations), n_z)))
    matched = maximum_bipartite_matching(incidence, perm_type="column")
    if np.any(matched < 0):
        free = sorted(set(range(n_z)) - set(matched.tolist()))
        names = ", ".join(tree.coordinates[tree.n_active + k] for k in free)
        raise DescriptionError(
            f"the loops do not determine {names}; choose other active joints or add a loop", key="active"
        )
    depends = csr_array(incidence[:, matched])
    _, label = connected_components(depends, directed=True, connection="strong")
    return _ordered(depends, label, equations, [tree.n_active + int(m) for m in matched])


def _check_count(tree: Tree, n_equations: int, n_z: int) -> None:
    if n_equations == n_z:
        return
    need = len(tree.coordinates) - n_equations
    raise DescriptionError(
        f"{tree.n_active} active joints of {len(tree.coordinates)} with {n_equations} loop equations: "
        f"the mechanism has {need} degrees of freedom, so name {need} active joints",
        key="active",
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


def _step(tree: Tree, loop: PlanarLoop, closure: Closure, unknowns: tuple[int, ...], near: dict[int, float]) -> Step:
    joints = [j for j in loop.joints if j.coordinate in unknowns]
    if closure.assembly == PARALLELOGRAM:
        try:
            return Parallelogram(loop, (joints[0], joints[1]))
        except ValueError as error:
            raise DescriptionError(f"is not a parallelogram: {error}", key=f"loops.{closure.name}.assembly") from error
    return dyad(loop, (joints[0], joints[1]), near)


def _choose_branch(tree: Tree, step: Step, closure: Closure, posture: Posture, near: dict[int, float]) -> float:
    """Solve the step at the reference, on the mode the file names or, without one, the mode nearest its reference."""
    key = f"loops.{closure.name}.assembly"
    if closure.assembly is not None and closure.assembly not in step.modes:
        raise DescriptionError(
            f"is '{closure.assembly}'; the assembly modes of this loop are {' and '.join(step.modes)}", key=key
        )
    signs = (
        [1.0, -1.0][: len(step.modes)]
        if closure.assembly is None
        else [1.0 - 2.0 * step.modes.index(str(closure.assembly))]
    )
    told = [k for k in step.unknowns if k in near]
    if len(signs) > 1 and not told:
        names = ", ".join(tree.coordinates[k] for k in step.unknowns)
        raise DescriptionError(
            f"missing: name the mode ({' or '.join(step.modes)}) or give {names} in reference", key=key
        )

    def distance(sign: float) -> float:
        margin = step.solve(posture, sign)
        return sum(abs(posture.q[k] - near[k]) for k in told) if margin > 0.0 else np.inf

    best = min(signs, key=distance)
    if not step.solve(posture, best) > 0.0:
        raise DescriptionError(
            "does not close at the reference configuration; mend the geometry or the reference",
            key=f"loops.{closure.name}",
        )
    if isinstance(step, Parallelogram):
        step.near(posture, near)
        step.solve(posture, best)
    return best
