"""The equations of Chu et al. (2020) for the forging robot, as they are written by hand.

Formulas stand here as texts, once: what is printed is what is computed. They are the consistent
reading of docs/errata.md, in the paper's coordinates and lengths. On record of the paper's own
terms is the third of f8, in sign and form; other signs, and the order of terms, are chosen here. A
sign changes a row of J_z and of J_u alike, and neither T nor R.

Loops 1 and 3 are written in the plane of link l1, loops 2 and 4 in that of l2: x along the arm's
side, y upward at q2 = 0. Each f is the pin as link l_k1 carries it, less the pin as l_i does.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from hybrid_dynamics_core.description.expressions import evaluate

# Table 1 and Figure 6 [m].
LENGTHS = {
    "L1": 0.7,
    "L2": 0.7,
    "L3": 0.8,
    "L4": 0.2,
    "L11": 0.4,
    "L21": 0.4,
    "L42": 0.2,
    "b1": 0.3,
    "b2": 0.3,
    "b3": 0.2,
    "c1": 0.2,
    "c2": 0.2,
}
U = ("q1", "q12", "q22", "q4")
Z = ("q2", "q3", "q11", "q21", "q31", "q32", "q41", "q42")
APPENDIX = ("q2", "q11", "q3", "q21", "q42", "q31", "q32", "q41")  # columns of the printed J_z

# Chu (2020): f1 to f8, Eq. 26 to 33. Two of each loop.
CLOSURES = {
    "f1": "(L11 + q12)*cos(q11) - L1 - (L2 - b2)*cos(q2)",
    "f2": "(L11 + q12)*sin(q11) - (L2 - b2)*sin(q2)",
    "f3": "(L21 + q22)*cos(q21) - (L2 - c2) + b3*cos(q3)",
    "f4": "(L21 + q22)*sin(q21) + b3*sin(q3)",
    "f5": "L2*cos(q31) - c1 - L2*cos(q2) + c1*sin(q2 + q32)",
    "f6": "L2*sin(q31) - L2*sin(q2) - c1*cos(q2 + q32)",
    "f7": "c1*cos(q32) - (L3 - b3)*cos(q32 + q41) + c1*sin(q3 + q42) - (L3 - b3)*cos(q3)",
    "f8": "c1*sin(q32) - (L3 - b3)*sin(q32 + q41) - c1*cos(q3 + q42) - (L3 - b3)*sin(q3)",
}
PRINTED_F8 = CLOSURES["f8"].replace("- c1*cos(q3 + q42)", "- c1*sin(q3 + q42)")

# Entries of J_z and J_u that are not zero: +df.
JACOBIAN = {
    "f1": {"q2": "(L2 - b2)*sin(q2)", "q11": "-(L11 + q12)*sin(q11)", "q12": "cos(q11)"},
    "f2": {"q2": "-(L2 - b2)*cos(q2)", "q11": "(L11 + q12)*cos(q11)", "q12": "sin(q11)"},
    "f3": {"q3": "-b3*sin(q3)", "q21": "-(L21 + q22)*sin(q21)", "q22": "cos(q21)"},
    "f4": {"q3": "b3*cos(q3)", "q21": "(L21 + q22)*cos(q21)", "q22": "sin(q21)"},
    "f5": {
        "q2": "L2*sin(q2) + c1*cos(q2 + q32)",
        "q31": "-L2*sin(q31)",
        "q32": "c1*cos(q2 + q32)",
    },
    "f6": {
        "q2": "-L2*cos(q2) + c1*sin(q2 + q32)",
        "q31": "L2*cos(q31)",
        "q32": "c1*sin(q2 + q32)",
    },
    "f7": {
        "q3": "(L3 - b3)*sin(q3) + c1*cos(q3 + q42)",
        "q32": "-c1*sin(q32) + (L3 - b3)*sin(q32 + q41)",
        "q41": "(L3 - b3)*sin(q32 + q41)",
        "q42": "c1*cos(q3 + q42)",
    },
    "f8": {
        "q3": "-(L3 - b3)*cos(q3) + c1*sin(q3 + q42)",
        "q32": "c1*cos(q32) - (L3 - b3)*cos(q32 + q41)",
        "q41": "-(L3 - b3)*cos(q32 + q41)",
        "q42": "c1*sin(q3 + q42)",
    },
}


def value(formula: str, s: Mapping[str, float]) -> float:
    """A formula at coordinates by name [rad, m]."""
    return evaluate(formula, {**LENGTHS, **s})


def closures(s: Mapping[str, float]) -> np.ndarray:
    """f1 to f8 (8,) [m] at any coordinates, closed or not."""
    return np.array([value(formula, s) for formula in CLOSURES.values()])


def jacobian(s: Mapping[str, float], columns: Sequence[str]) -> np.ndarray:
    """Columns of J_s (8, columns) [m, 1] by joint: J_u of U, J_z of Z."""
    result = np.zeros((len(JACOBIAN), len(columns)))
    for row, entries in zip(result, JACOBIAN.values(), strict=True):
        for k, column in enumerate(columns):
            row[k] = value(entries.get(column, "0"), s)
    return result


def passive_map(s: Mapping[str, float]) -> np.ndarray:
    """T = -J_z^-1 J_u, Chu (2020), Eq. 24, (8, 4)."""
    return -np.linalg.solve(jacobian(s, Z), jacobian(s, U))


def velocity_map(s: Mapping[str, float]) -> np.ndarray:
    """R = [E; T], Chu (2020), Eq. 25, (12, 4)."""
    return np.vstack([np.eye(len(U)), passive_map(s)])
