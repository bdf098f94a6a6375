"""Natural frequencies and modes of an elastic structure with drives locked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from ..dynamics.loads import Loads
from ..errors import InputError
from ..ground.arrays import Array
from .equilibrium import RANK, Equilibrium
from .mass_matrix import mass_matrix
from .robot_interface import ElasticRobot
from .structure import Structure

MASSLESS = 1e-12  # 1 / omega^2 over the largest one, below which a mode has no mass
FREE_MASS = 1e-12  # share of the mass of free motions that counts
TINY = 1e-300


@dataclass(frozen=True, eq=False)
class Modes:
    """Natural modes, the lowest first; each has a modal mass of 1, phi^T M phi.

    Attributes:
        frequencies: (k,) [Hz]. Modes without mass, whose frequency is infinite, are left out.
        links: displacement (k, 6) of each link's origin and its turn, base axes.
        joints: (k, n_s) displacements of the joints, in the order of `robot.coordinates`.
        energy_by_element: (k,) share of each element in the energy of each mode.
    """

    frequencies: Array
    links: Mapping[str, Array]
    joints: Array
    energy_by_element: Mapping[str, Array]


def modes_of(robot: ElasticRobot, solved: Equilibrium, loads: Loads) -> Modes:
    """The modes of a structure.

    With q = B y on the equations, energy is y^T y / 2. So 1 / omega^2 are the eigenvalues of
    B^T M B. Free motions, which no spring holds, are eliminated: they follow without force.

    Args:
        robot: the robot.
        solved: its equilibrium.
        loads: only payloads count.

    Raises:
        InputError: nothing that moves has a mass.
    """
    structure = solved.structure
    mass = mass_matrix(robot, structure, loads)
    shapes = allowed_deformations(solved)
    moved = solved.joint_displacements(shapes)
    basis = _with_free(solved, mass, np.vstack([moved, shapes]))
    reduced = basis.T @ mass @ basis
    values, vectors = np.linalg.eigh(0.5 * (reduced + reduced.T))
    largest = max(values.max(initial=0.0), TINY)
    counts = values > MASSLESS * largest
    if not counts.any():
        raise InputError("nothing that moves has a mass; expected masses of links, or a payload")
    slowest_first = np.flatnonzero(counts)[::-1]
    omega = 1.0 / np.sqrt(values[slowest_first])
    chosen = vectors[:, slowest_first]
    motions = basis @ (chosen * omega)  # of modal mass 1
    size = len(solved.scale)
    return Modes(
        frequencies=omega / (2.0 * np.pi),
        links=MappingProxyType(_links(structure, motions)),
        joints=motions[:size].T,
        energy_by_element=MappingProxyType(_energies(structure, shapes @ chosen)),
    )


def allowed_deformations(solved: Equilibrium) -> Array:
    """An orthonormal basis (n_e, k) of the deformations that the equations allow."""
    count = len(solved.structure.springs)
    if not solved.stressed.size:
        return np.eye(count)
    left, values, _ = np.linalg.svd(solved.stressed)
    counts = values > RANK * values.max(initial=0.0)
    rank = int(counts.sum())
    return left[:, rank:].astype(np.float64)


def _with_free(solved: Equilibrium, mass: Array, basis: Array) -> Array:
    """The basis, with the free motions that follow each of its motions by inertia alone."""
    size, count = solved.free.shape
    free = np.zeros((len(basis), count))
    free[:size] = solved.free
    free_mass = free.T @ mass @ free
    inverse = np.linalg.pinv(free_mass, rcond=FREE_MASS, hermitian=True)
    follow = inverse @ (free.T @ mass @ basis)
    together: Array = basis - free @ follow
    return together


def _links(structure: Structure, motions: Array) -> dict[str, Array]:
    """Displacements (k, 6) of each link."""
    moved: dict[str, Array] = {}
    for link in structure.posed.description.links:
        pose, twists = structure.twists_of_link(link)
        displacements = pose.displacements(twists @ motions)
        moved[link] = displacements.T
    return moved


def _energies(structure: Structure, deformations: Array) -> dict[str, Array]:
    """Share (k,) of each element in the energy of each mode."""
    squares = deformations**2
    total = squares.sum(axis=0)
    shares: dict[str, Array] = {}
    for name, square in zip(structure.springs, squares, strict=True):
        before = shares.get(name, np.zeros(len(total)))
        shares[name] = before + square / total
    return shares
