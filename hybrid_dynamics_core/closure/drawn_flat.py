"""Parallelograms that a file draws with all pivots in line, at their change point."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..description.model import Closure, RobotDescription
from ..ground.arrays import Array
from ..mechanism.configuration import Configuration, configuration_at
from ..mechanism.tree import Tree
from .constraints.equations import coefficients
from .constraints.parallelogram import PARALLELOGRAM, parallelogram_equations
from .constraints.planar import PlanarPin
from .constraints.planar_loops import planar_equations

FLAT = 1e-6  # share of the larger motion of a pin below which it moves along one line only


def with_parallelograms(tree: Tree, robot: RobotDescription, s: Array) -> RobotDescription:
    """The description with `assembly: parallelogram` for each parallelogram that is drawn flat.

    Flat means that all pivots are in one line. This is a change point, from which the loop may also
    go over into an antiparallelogram. A file that names no assembly mode means the parallelogram.

    Args:
        tree: the spanning tree.
        robot: its description.
        s: the drawn pose, closed (n_s,) [rad or m].
    """
    configuration = configuration_at(tree, s)
    closures = list(robot.closures)
    notes = list(robot.notes)
    for k, closure in enumerate(closures):
        if closure.assembly is not None or not _is_flat(tree, closure, configuration):
            continue
        closures[k] = replace(closure, assembly=PARALLELOGRAM)
        text = "drawn flat, where it could fold either way; taken as a parallelogram"
        located = replace(robot, warnings=()).error(robot.closure_key(closure.name), text)
        notes.append(str(located))
    return replace(robot, closures=tuple(closures), notes=tuple(notes))


def _is_flat(tree: Tree, closure: Closure, configuration: Configuration) -> bool:
    """Whether a closure makes a parallelogram that is flat at a configuration."""
    try:
        pin, *others = planar_equations(tree, closure)
    except ValueError:
        return False
    if others or not isinstance(pin, PlanarPin):
        return False
    try:
        angles = parallelogram_equations(pin)
    except ValueError:
        return False
    residuals = [float(angle.linearise(configuration).residual[0]) for angle in angles]
    if max(map(abs, residuals)) > FLAT:
        return False
    rows = pin.linearise(configuration).rows
    matrix = np.array([coefficients(row, pin.coordinates) for row in rows], dtype=float)
    sizes = np.linalg.svd(matrix, compute_uv=False)
    return bool(sizes[1] < FLAT * sizes[0])
