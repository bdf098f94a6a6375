"""Drives as programs: generalised forces of forces along joints, and hydraulic cylinders."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields

from ..algebra.linear import Inverse, Rows
from ..algebra.scalar import Scalar, absolute, larger, sqrt
from ..closure.closed_motion import ClosedMotion
from ..description.actuators import HydraulicCylinder
from ..dynamics.hydraulics import CylinderState, cylinder_terms
from ..kernels.trace import Check, Results
from .closure import closed_motion
from .model import AT_POSITION, Inputs, Model, Program
from .outcome import Outcome, OutcomeKind

# least conditioning of the rates of the drives; below it they cannot give every tau
INDEPENDENT = 1e-9
SINGULAR = Outcome(OutcomeKind.SINGULAR, 0).encode()
HYDRAULICS = tuple(field.name for field in fields(CylinderState) if field.name != "overloaded")


def generalised_forces() -> Program:
    """Program for tau = R^T f (n,) from forces f along all coordinates (n_s,)."""

    def run(model: Model, x: Inputs) -> Results:
        motion, checks, _ = closed_motion(model, x)
        tau, _ = motion.project(x.forces)
        return Results({"tau": tau}, checks)

    return Program((*AT_POSITION, "forces"), run)


def hydraulics(cylinders: Mapping[str, HydraulicCylinder], drives: Sequence[int]) -> Program:
    """Program for pressures, flows and strokes of the cylinders, one entry for each.

    Args:
        cylinders: by coordinate.
        drives: indices in s of the n coordinates whose forces give tau.
    """

    def run(model: Model, x: Inputs) -> Results:
        motion, checks, _ = closed_motion(model, x)
        ds = motion.rates(x.du)
        forces, regular = _forces_along(motion, drives, list(x.tau))
        columns: dict[str, list[Scalar]] = {name: [] for name in HYDRAULICS}
        for name, cylinder in cylinders.items():
            k = model.tree.coordinates.index(name)
            position = motion.configuration.q[k]
            terms = cylinder_terms(cylinder, position, ds[k], forces.get(k, 0.0))
            for column, values in columns.items():
                values.append(terms[column])
        return Results(columns, [*checks, regular])

    return Program(("u", "du", "tau", "branch", "guess"), run)


def _forces_along(
    motion: ClosedMotion, drives: Sequence[int], tau: list[Scalar]
) -> tuple[dict[int, Scalar], Check]:
    """Forces of the drives by index in s, and the check that they can give every tau."""
    velocity_map = motion.velocity_map()
    rows = [velocity_map[k] for k in drives]
    scaled: Rows = []
    for row in rows:
        square: Scalar = 0.0
        for rate in row:
            square = square + rate * rate
        size = larger(sqrt(square), 1.0)
        scaled.append([rate / size for rate in row])
    units = [1.0] * len(drives)
    conditioning = absolute(Inverse(scaled).conditioning(scaled, units))
    forces = Inverse(rows).solve_transposed(tau)
    return dict(zip(drives, forces, strict=True)), Check(conditioning, INDEPENDENT, SINGULAR)
