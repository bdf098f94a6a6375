"""Our numbers beside published ones: python tools/reproduced.py [--publish].

Prints the table of docs/reproduced.md, and puts it there if asked.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
sys.path.insert(0, str(ROOT / "examples" / "papers"))

from benchmarks import publish  # noqa: E402
from benchmarks.problems.catalogue import ANDREWS, PROBLEMS, Problem  # noqa: E402
from benchmarks.problems.solve import Solver  # noqa: E402
from hybrid_dynamics_core import ClosedState, Robot, load  # noqa: E402
from hybrid_dynamics_core.simulation import Settings, simulate  # noqa: E402
from tests.certified.geometries import solved  # noqa: E402
from tests.hard_cases.test_platforms import FORTY  # noqa: E402

import chu2020_forms as chu  # type: ignore[import-not-found] # noqa: E402

PAGE = ROOT / "docs" / "reproduced.md"
HEAD = [
    "| paper | where | quantity | ours | theirs | difference | reason |",
    "|---|---|---|---:|---:|---:|---|",
]
CHU = "Chu et al. (2020)"
STAICU = "Staicu (2015)"
MISPRINT = "misprint: [Errata](errata.md)"
CURVE = "a curve without numbers"
HANDBOOK = "Mazzia, Magherini: test set"
LIBRARY = "IFToMM library, slider-crank"
START = np.array([0.0, 0.10, 0.15, 0.0])  # q1 [rad], q12 [m], q22 [m], q4 [rad]
RATES = np.array([math.radians(10.0), 0.01, 0.005, math.radians(5.0)])
END = {"x": 0.1, "y": 0.1, "z": 0.0, "alpha_1": math.pi / 6, "alpha_2": 0.0, "alpha_3": 0.0}
HANDED_IN = (("González", 0.211754668), ("Masarati", 0.2124956))  # slider's place at 1 s [m]


@dataclass(frozen=True)
class Row:
    """One number beside the published one.

    Attributes:
        paper: who published it.
        where: figure, table or equation.
        quantity: name and unit.
        ours: value by this library.
        theirs: published value, or words where none is printed.
        digits: decimals shown.
        reason: of the difference.
    """

    paper: str
    where: str
    quantity: str
    ours: float
    theirs: float | str
    digits: int
    reason: str = ""

    def line(self) -> str:
        """The row in Markdown."""
        ours = self._text(self.ours)
        theirs, difference = str(self.theirs), ""
        if isinstance(self.theirs, float):
            theirs = self._text(self.theirs)
            difference = self._text(self.ours - self.theirs)
        cells = [self.paper, self.where, self.quantity, ours, theirs, difference, self.reason]
        return f"| {' | '.join(cells)} |"

    def _text(self, value: float) -> str:
        text = f"{value:.{self.digits}f}"
        if float(text) == 0.0:
            return "0"
        return text


def forging() -> list[Row]:
    """The forging robot along the motion of Section 3."""
    robot = load("forging_chu2020")
    links = robot.description.links
    l41 = float(links["l41"].com[0])
    rows = [Row(CHU, "Table 2", "l41, centre of mass [m]", l41, 0.4, 2, MISPRINT)]
    state = robot.close(START + 5.0 * RATES, RATES)
    s = dict(zip(robot.coordinates, state.s.tolist(), strict=True))
    f8 = chu.value(chu.CLOSURES["f8"], s)
    printed = chu.value(chu.PRINTED_F8, s)
    rows.append(Row(CHU, "(33)", "f8 at 5 s [m]", f8, printed, 3, MISPRINT))
    tau = robot.inverse_dynamics(state, np.zeros(4))
    wrong = _efforts_with_the_printed_sign(robot, state)
    sign = "Appendix, sign of J_z"
    rows.append(Row(CHU, sign, "F12 at 5 s [N]", float(tau[1]), float(wrong[1]), 0, MISPRINT))
    for t in (0.0, 5.0, 10.0):
        state = robot.close(START + t * RATES, RATES)
        tau = robot.inverse_dynamics(state, np.zeros(4))
        reason = "[Figure 10](figure_10.md)"
        for k, name, digits in ((0, "tau_1", 4), (1, "F12", 2), (2, "F22", 2)):
            quantity = f"{name} at {t:g} s [N{' m' * (k == 0)}]"
            rows.append(Row(CHU, "Figure 10", quantity, float(tau[k]), CURVE, digits, reason))
    return rows


def _efforts_with_the_printed_sign(robot: Robot, state: ClosedState) -> np.ndarray:
    """Efforts with the passive rows of R of the wrong sign, as the Appendix has J_z."""
    terms = robot.spanning_terms(state)
    force = terms.M @ robot.accelerations(state, np.zeros(4)) + terms.C @ state.ds + terms.g
    signs = np.array([1.0] * 4 + [-1.0] * 8)
    return (signs[:, None] * state.R).T @ force


def two_modules() -> list[Row]:
    """Staicu's robot at the end of the example of Section 4."""
    robot = load("staicu2015")
    state = robot.close_given(END)
    reference = robot.close(robot.reference)
    foot = robot.forward_kinematics(reference, frame="upper_hook_E").position
    angle = math.atan2(foot[1], foot[0])
    rows = [Row(STAICU, "(2)", "alpha_E [rad]", angle, 0.0, 3, MISPRINT)]
    for leg in "ABCDEF":
        place = float(state.s[robot.coordinates.index(f"lambda_{leg}")])
        figure, reason = "Figure 5", ""
        theirs = CURVE
        if leg in "DEF":
            figure, reason = "Figure 6", "[Errata](errata.md#figures-6-8-and-10)"
            theirs = "two of three curves are the same"
        quantity = f"lambda_{leg} at 3 s [m]"
        rows.append(Row(STAICU, figure, quantity, place, theirs, 4, reason))
    return rows


def squeezer() -> list[Row]:
    """Andrews' squeezing mechanism, at the start and at 0.03 s."""
    solver = Solver(_problem("andrews"))
    robot = solver.robot
    ddu = robot.forward_dynamics(solver.start, [0.033])
    start = dict(zip(robot.coordinates, robot.accelerations(solver.start, ddu), strict=True))
    rows = []
    for name, theirs in (("beta", 14222.443919954), ("theta", -10666.832939966)):
        quantity = f"{name}'' at 0 s [rad/s^2]"
        rows.append(Row(HANDBOOK, "Andrews", quantity, float(start[name]), theirs, 5))
    end = solver.run(1e-10).state.s[-1]
    for name, theirs in ANDREWS.items():
        ours = float(end[robot.coordinates.index(name)])
        rows.append(Row(HANDBOOK, "Andrews", f"{name} at 0.03 s [rad]", ours, theirs, 6))
    return rows


def slider_crank() -> list[Row]:
    """The spatial slider-crank of the IFToMM library, beside what others handed in."""
    solver = Solver(_problem("slider_crank"))
    robot = solver.robot
    settings = Settings(rtol=1e-10, rate=1.0)
    motion = simulate(robot, solver.start, None, None, (0.0, 1.0), settings)
    place = float(motion.state.s[-1][robot.coordinates.index("x")])
    reason = "tolerances not given; ours agrees with equations by hand"
    rows = []
    for name, theirs in HANDED_IN:
        rows.append(Row(LIBRARY, name, "x at 1 s [m]", place, theirs, 5, reason))
    return rows


def _problem(name: str) -> Problem:
    return next(problem for problem in PROBLEMS if problem.name == name)


def forty() -> list[Row]:
    """Dietmaier's platform on six legs: its real poses, proved to be all."""
    feet, tips, lengths = (np.array(part) for part in FORTY)
    poses = solved(feet, tips, lengths)
    count = float(len(poses.origins))
    return [Row("Dietmaier (1998)", "the example", "real poses", count, 40.0, 0)]


def table() -> list[str]:
    """All rows in Markdown."""
    parts = (forging(), two_modules(), squeezer(), slider_crank(), forty())
    return HEAD + [row.line() for part in parts for row in part]


def main() -> None:
    """Print the table, and publish it if asked."""
    lines = table()
    print("\n".join(lines))
    if "--publish" in sys.argv[1:]:
        publish.put(PAGE, "reproduced", lines)


if __name__ == "__main__":
    main()
