"""The equations and tables of both papers with their numbers, beside what the library computes.

python examples/papers/line_by_line.py [PART ...]

Parts: classes, tables, closures, jacobians, lemma, graph, legs; all of them without a name. Numbers
of the forging robot are those at 5 s of the motion in the paper's Section 3, those of Staicu's
robot at the end of the example in its Section 4.
"""

from __future__ import annotations

import argparse
import math

import numpy as np

from hybrid_dynamics_core import ClosedState, Robot, load

import chu2020_forms as chu
import staicu2015_forms as staicu

TIME = 5.0  # [s]
START = np.array([0.0, 0.10, 0.15, 0.0])  # q1 [rad], q12 [m], q22 [m], q4 [rad]
RATES = np.array([math.radians(10.0), 0.01, 0.005, math.radians(5.0)])
END = {"x": 0.1, "y": 0.1, "z": 0.0, "alpha_1": math.pi / 6, "alpha_2": 0.0, "alpha_3": 0.0}
ERRATA = {"l32": "printed: c2/2", "l41": "printed: L3/2"}  # Table 2
CLASSES = """
Class I    parallel modules in series                    staicu2015
Class II   a parallel module under a serial arm          tripod (docs/own_robot.md)
Class III  m local closed loops appended to a serial     forging_chu2020 (types A, A, B, B),
           arm of n links, each of Type A, B, C or D     type_c, type_d, excavator, palletizer
"""
LEMMA = """
The DAE (10) in all coordinates s = [u; z], with the forces lambda in the cut pins,

    M(s) s'' + C(s, s') s' + g(s) + J_s^T lambda = [tau; 0],    J_s = [J_u, J_z]  (16),

has, wherever J_z is regular, the same motions u(t) as the minimal form (17) in u alone,

    M-bar u'' + C-bar u' + G-bar = tau_q,

    M-bar = R^T M R,    C-bar = R^T (M R' + C R),    G-bar = R^T g,    tau_q = R^T [tau; 0],

    R = [E; T]  (25),    T = -J_z^-1 J_u  (24),    s'' = R u'' + R' u'  (15).

J_s R = 0 removes lambda.
"""


def state_of(robot: Robot) -> ClosedState:
    """The forging robot at TIME, closed."""
    return robot.close(START + TIME * RATES, RATES)


def by_name(robot: Robot, state: ClosedState) -> dict[str, float]:
    """Coordinates [rad, m] by joint."""
    return dict(zip(robot.coordinates, state.s.tolist(), strict=True))


def below(difference: float) -> str:
    """The power of ten that a difference is below."""
    for power in (-12, -9, -6, -3):
        if difference < 10.0**power:
            return f"1e{power}"
    return "1"


def print_matrix(rows: np.ndarray, names: list[str], columns: tuple[str, ...]) -> None:
    """A matrix with names of rows and columns, three decimals."""
    print("      " + "".join(f"{column:>9}" for column in columns))
    rounded = np.round(rows, 3) + 0.0  # no negative zero
    for name, row in zip(names, rounded, strict=True):
        print(f"{name:6}" + "".join(f"{number:9.3f}" for number in row))


def classes() -> None:
    """Class I, II and III."""
    print(CLASSES.strip())


def tables() -> None:
    """Table 1 and Table 2."""
    print("Table 1 and Figure 6: lengths [m]")
    names = list(chu.LENGTHS)
    for start in range(0, len(names), 6):
        part = names[start : start + 6]
        print("  " + "   ".join(f"{name:3} {chu.LENGTHS[name]:.1f}" for name in part))
    print("Table 2: masses [kg] and centres of mass [m], each in the frame of its link")
    for name, link in load("forging_chu2020").description.links.items():
        if not link.mass:  # the base
            continue
        place = ", ".join(f"{number:5.2f}" for number in link.com + 0.0)
        note = ERRATA.get(name, "")
        print(f"  {name:4} {link.mass:5.1f}   ({place})   {note}".rstrip())
    print("Not printed, assumed: rods L12 = L22 = 0.4, links slender rods, radius of l4 0.1")


def closures() -> None:
    """f1 to f8, with their values."""
    robot = load("forging_chu2020")
    s = by_name(robot, state_of(robot))
    for (name, formula), number in zip(chu.CLOSURES.items(), chu.closures(s), strict=True):
        print(f"{name} = {formula}")
        print(f"   = 0 to {below(abs(number))} m")
    print(f"f8 as printed, - c1*sin(q3 + q42): {chu.value(chu.PRINTED_F8, s):.3f} m")


def jacobians() -> None:
    """J_z in the order of z and of the Appendix, J_u, and R against the library's."""
    robot = load("forging_chu2020")
    state = state_of(robot)
    s = by_name(robot, state)
    names = list(chu.CLOSURES)
    print("J_z, columns in the order of z")
    print_matrix(chu.jacobian(s, chu.Z), names, chu.Z)
    print("J_z, columns in the order of the Appendix")
    print_matrix(chu.jacobian(s, chu.APPENDIX), names, chu.APPENDIX)
    print("J_u")
    print_matrix(chu.jacobian(s, chu.U), names, chu.U)
    print("T = -J_z^-1 J_u")
    print_matrix(chu.passive_map(s), list(chu.Z), chu.U)
    difference = np.abs(chu.velocity_map(s) - state.R).max()
    print(f"R = [E; T] against state.R: equal to {below(difference)}")


def lemma() -> None:
    """The Lemma, and both sides of it in numbers."""
    print(LEMMA.strip())
    robot = load("forging_chu2020")
    state = state_of(robot)
    ddu = np.array([0.1, 0.2, -0.1, 0.3])
    terms = robot.spanning_terms(state, ddu)
    R = chu.velocity_map(by_name(robot, state))
    dR = robot.velocity_map_rate(state)
    mass = R.T @ terms.M @ R
    coriolis = R.T @ (terms.M @ dR + terms.C @ R)
    gravity = R.T @ terms.g
    print("\nM-bar")
    print_matrix(mass, list(chu.U), chu.U)
    ours = robot.minimal_form(state)
    theirs = (mass, coriolis @ state.du, gravity)
    words = ("M-bar", "C-bar u'", "G-bar")
    for word, a, b in zip(words, theirs, ours, strict=True):
        difference = np.abs(a - b).max() / np.abs(b).max()
        print(f"{word} against robot.minimal_form: equal to {below(difference)} of the largest")
    tau = mass @ ddu + coriolis @ state.du + gravity
    efforts = robot.inverse_dynamics(state, ddu)
    difference = np.abs(tau - efforts).max() / np.abs(efforts).max()
    print(f"tau_q against robot.inverse_dynamics: equal to {below(difference)} of the largest")


def graph() -> None:
    """Staicu's mechanism as a graph."""
    description = load("staicu2015").description
    print("\n".join(staicu.graph(description)))
    joints = len(description.joints)
    equations = 3 * len(description.closures)
    print(f"{joints} joints less {equations} equations: {joints - equations} degrees of freedom")


def legs() -> None:
    """Staicu's leg variables at the end of the example, against the library's."""
    robot = load("staicu2015")
    state = robot.close_given(END)
    s = by_name(robot, state)
    variables = staicu.leg_variables(END)
    print(f"{'leg':6}{'lambda [m]':>12}{'phi10 [rad]':>13}{'phi21 [rad]':>13}")
    for leg in "ABCDEF":
        numbers = [variables[f"{name}_{leg}"] for name in ("lambda", "phi10", "phi21")]
        length, phi10, phi21 = np.round(numbers, 4) + 0.0  # no negative zero
        print(f"{leg:6}{length:12.4f}{phi10:13.4f}{phi21:13.4f}")
    difference = max(abs(s[name] - number) for name, number in variables.items())
    print(f"against robot.close_given: equal to {below(difference)}")


PARTS = {
    "classes": classes,
    "tables": tables,
    "closures": closures,
    "jacobians": jacobians,
    "lemma": lemma,
    "graph": graph,
    "legs": legs,
}


def main() -> None:
    """Print the parts that are asked for."""
    parser = argparse.ArgumentParser(description="Both papers, line by line.")
    parser.add_argument("parts", nargs="*", metavar="PART", help=", ".join(PARTS))
    wanted = parser.parse_args().parts
    for name in wanted:
        if name not in PARTS:
            parser.error(f"there is no part '{name}': {', '.join(PARTS)}")
    for name in wanted or PARTS:
        if len(wanted) != 1:
            print(f"\n== {name}")
        PARTS[name]()


if __name__ == "__main__":
    main()
