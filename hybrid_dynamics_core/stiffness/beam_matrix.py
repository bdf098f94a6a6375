"""Compliance of a straight beam at its end."""

from __future__ import annotations

import numpy as np

from ..algebra.independence import norm
from ..description.elasticity import Beam
from ..ground.arrays import Array

ALONG = 1e-6  # sine of the angle up to which the beam runs along its section's z direction


def beam_axes(beam: Beam, along: Array) -> Array:
    """Axes of a beam as columns (3, 3) in link axes: x along it, z towards `beam.z`.

    Args:
        beam: the beam.
        along: unit vector (3,) from its start to its end.
    """
    towards = beam.z / norm(beam.z)
    across = np.cross(towards, along)
    if norm(across) <= ALONG:
        farthest = int(np.argmin(np.abs(along)))
        towards = np.eye(3)[farthest]
        across = np.cross(towards, along)
    y = across / norm(across)
    z = np.cross(along, y)
    return np.column_stack([along, y, z])


def beam_compliance(beam: Beam, length: float) -> Array:
    """Displacement of a beam's end per wrench there, with its start held.

    Timoshenko's beam; without shear areas it is that of Euler and Bernoulli. Przemieniecki (1968),
    Theory of Matrix Structural Analysis, Section 5.6, inverted.

    Args:
        beam: the beam.
        length: its length [m].

    Returns:
        (6, 6) in beam axes, linear before angular [m/N, rad/N, rad/(N m)].
    """
    section = beam.section
    stretch = length / (beam.E * section.A)
    twist = length / (beam.G * section.J)
    about_y = length / (beam.E * section.Iy)
    about_z = length / (beam.E * section.Iz)
    shear_y = length / (beam.G * section.Ay)
    shear_z = length / (beam.G * section.Az)
    third = length**2 / 3.0
    half = length / 2.0
    along_y = about_z * third + shear_y
    along_z = about_y * third + shear_z
    compliance = np.diag([stretch, along_y, along_z, twist, about_y, about_z])
    compliance[1, 5] = about_z * half
    compliance[5, 1] = about_z * half
    compliance[2, 4] = -about_y * half
    compliance[4, 2] = -about_y * half
    return compliance


def factor(compliance: Array) -> Array:
    """L (6, 6) with L L^T = compliance: deformations per coordinate of unit stiffness."""
    lower = np.linalg.cholesky(compliance)
    return lower.astype(np.float64)


def factor_of_stiffness(stiffness: Array) -> Array:
    """L (6, 6) with L L^T = stiffness^-1."""
    lower = np.linalg.cholesky(stiffness)
    inverse: Array = np.linalg.inv(lower).T
    return inverse
