"""What the numbered equations of both papers are, as far as this project has them on record.

One table for every citation: tests/published/test_citations.py reads all `Chu (2020), Eq. N` and
`Staicu (2015), Eq. N` of the repository, and docs/papers.md shows the same rows. The sources are
docs/errata.md and the reading of both papers that the project began with. Every number up to the
highest one there has a row, figures and tables too. Where both are silent the row says so, and the
number cannot be cited.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Equation:
    """An equation of a paper.

    Attributes:
        what: it is, in a few words.
        beside: pattern of the words or symbols that stand before a citation of it.
    """

    what: str
    beside: str


NOWHERE = r"(?!)"  # no words stand before a citation of what is not on record
NOT_ON_RECORD = "not on record here"

LOOP_TYPE = r"Type [A-D]|each type"
MINIMAL = r"M-bar u''|\\bar M \\ddot u|[Mm]inimal form|M-bar \(n, n\)|G-bar = tau"
VELOCITY_MAP = r"\bR = \[E|\bR \(n_s, n\)|columns of R,|s' = R u'|\\dot s = R|\ball by \$R\$"

CHU: dict[str, Equation] = {
    "1 to 9": Equation("loops of Type A to D appended to an arm: frames and closures", LOOP_TYPE),
    "4 to 8": Equation("transforms and closures of Type A to D", LOOP_TYPE),
    "4": Equation("the frame of link i+1, past a loop: a product of transforms", "transform"),
    "5": Equation("transforms along a branch of a loop", "branch"),
    "6": Equation("with (5), the frame of link i+1 past a loop of Type D", "Type D"),
    "7": Equation("the closure of a loop", "closure of a loop"),
    "8": Equation("(7) with l_i and l_k2 exchanged", "exchanged"),
    "10": Equation("the DAE of the tree with its loops", r"\bDAE\b"),
    "11": Equation("where the inertias I_j of the bodies enter", r"\bI_j\b"),
    "12 to 14": Equation(f"{NOT_ON_RECORD}; they stand between (11) and (15)", NOWHERE),
    "15": Equation("s'' = R u'' + R' u'", r"s'' = R u''|\\ddot s = R"),
    "16": Equation("J_s = [J_u, J_z]", r"J_s\b(?! s'|\^T|')"),
    "17": Equation("the minimal form, M-bar u'' + C-bar u' + G-bar = tau_q", MINIMAL),
    "below 17": Equation("M-bar, C-bar, G-bar and tau_q", r"C-bar\b|tau_q"),
    "18 to 23": Equation(f"{NOT_ON_RECORD}; they stand between (17) and (24)", NOWHERE),
    "24": Equation("T = -J_z^-1 J_u", r"\bT = -J_z\^"),
    "25": Equation("R = [E; T]", VELOCITY_MAP),
    "26 to 33": Equation("f1 to f8, the closures of the forging robot", "f1 to f8"),
    "33": Equation("f8, the second closure of loop 4", r"\bf8\b"),
    "34 to 36": Equation(f"{NOT_ON_RECORD}; they stand between (33) and (37)", NOWHERE),
    "37 to 39": Equation("consistent as printed; not on record here", "consistent as printed"),
}
STAICU: dict[str, Equation] = {
    "1": Equation(f"{NOT_ON_RECORD}; it stands before (2)", NOWHERE),
    "2": Equation("the angles of the base joints, alpha_D to alpha_F among them", r"\balpha_E\b"),
    "3 to 7": Equation(f"{NOT_ON_RECORD}; they stand between (2) and (8)", NOWHERE),
    "8 to 17": Equation("all 18 leg variables with rates and accelerations", "leg variables"),
    "9": Equation("the angles of the lower legs", r"second line|lower legs"),
    "13 to 17": Equation("rates and accelerations of the leg variables", "rates of the leg"),
}
PAPERS = {"Chu": CHU, "Staicu": STAICU}
LAST = {"Chu": 39, "Staicu": 17}  # the highest numbers on record

# figures and tables by number, as the page has them
FIGURES = {
    "Chu": {
        "1, 2, 4, 5, 7": NOT_ON_RECORD,
        "3": "loops of Type A to D",
        "6": "the forging robot and its lengths",
        "8": "where the end effector goes",
        "9": "inverse kinematics of that path",
        "10": "efforts of the drives",
    },
    "Staicu": {
        "1 to 4": NOT_ON_RECORD,
        "5, 7, 9": "displacements, velocities, accelerations of legs A, B, C",
        "6, 8, 10": "the same of legs D, E, F",
    },
}
LAST_FIGURE = 10  # of both
