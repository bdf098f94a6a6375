"""The header: sizes, names, constants, status codes and functions."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence

from ...kernels.trace import Trace
from ...programs import OutcomeKind
from ...robot.robot import Robot
from .emit import count_operations
from .limit_notes import EFFORTS, RATES, TABLES, limits_not_exported
from .names import comment
from .signatures import Names, signature
from .tracer import TracedFunction

STATUS = {  # by kind of outcome: name after the prefix, text
    OutcomeKind.CLOSED: ("OK", "done"),
    OutcomeKind.UNREACHABLE: ("NOT_CLOSED", "a loop cannot close at u"),
    OutcomeKind.SINGULAR: ("SINGULAR", "a loop is singular at u"),
    OutcomeKind.JUMP: (
        "JUMP",
        "u is too far from the guess for one step, or the guess is not closed",
    ),
    OutcomeKind.NOT_FINITE: ("NOT_FINITE", "an argument or a result is not a finite number"),
    OutcomeKind.MASS_SINGULAR: (
        "SINGULAR_MASS",
        "the mass matrix is singular: a motion of the drives moves no mass",
    ),
}
CONSTANTS = (
    ("double {p}_reference[{p}_NS]", "the reference configuration s, closed: a first guess"),
    ("double {p}_gravity[3]", "gravity of the description, base axes [m/s^2]"),
    ("double {p}_limits[{p}_NU][2]", "lower and upper limits of u; infinite if there is none"),
    ("double {p}_velocity_limits[{p}_NU]", "largest rates; infinite if there is none"),
    ("double {p}_effort_limits[{p}_NU]", "largest efforts; infinite if there is none"),
    (
        "double {p}_effort_ranges[{p}_NU][2]",
        "least and largest efforts, by pressures of cylinders too; infinite if there is none",
    ),
    ("char *const {p}_coordinate_names[{p}_NS]", "names of the coordinates s in the description"),
)
INDENT = "   "  # of the lines of a comment after the first

_ARGUMENTS = """\
/* payload (10): mass, centre of mass (3), and Ixx, Ixy, Ixz, Iyy, Iyz, Izz about it, in axes of the
   end effector, from its origin. It comes on top of the payloads of the description.
   viscous, coulomb (NS): friction along the coordinates, in place of that of the description. */
"""


def header_text(
    robot: Robot, names: Names, traced: Sequence[TracedFunction], start: Trace | None
) -> str:
    """The text of ROBOT.h.

    Args:
        robot: the robot.
        names: its identifiers.
        traced: the functions.
        start: what followed functions start from; None where every loop has a closed form.
    """
    p = names.prefix
    before = 0 if start is None else count_operations(start)
    parts = [
        _opening(robot, names, start is not None),
        *([_ARGUMENTS] if any("payload" in one.inputs for one in traced) else []),
        f"#ifndef {p}_H\n#define {p}_H\n",
        '#ifdef __cplusplus\nextern "C" {\n#endif\n',
        f"#define {names.nu} {names.n} /* active coordinates u */",
        f"#define {names.ns} {len(names.coordinates)} /* all coordinates s = [u; z] */\n",
        _coordinates(robot, names),
        _status(p),
    ]
    for text, meaning in CONSTANTS:
        parts.append(f"/* {meaning} */\nextern const {text.format(p=p)};\n")
    note = limits_note(robot, p)
    if note:
        parts.append(f"/* {note} */\n")
    parts += [_name_lists(names, one) for one in traced if one.lists]
    for one in traced:
        operations = before + count_operations(one.trace)
        parts.append(
            f"/* {one.call.text}.\n   At most {operations} floating-point operations."
            f"{_without_guess(one)} */\n"
            f"{signature(names, one)};\n"
        )
    parts += ["#ifdef __cplusplus\n}\n#endif\n", f"#endif /* {p}_H */\n"]
    return "\n".join(parts)


def limits_note(robot: Robot, prefix: str) -> str:
    """What became of limits of drives; empty if the constants have all."""
    note = limits_not_exported(robot.description, exported=(RATES, EFFORTS))
    if TABLES in note:
        note += f" {prefix}_effort_ranges has the largest effort of a table; elsewhere it is less."
    return textwrap.fill(note, 90, subsequent_indent=INDENT, break_on_hyphens=False)


def _without_guess(traced: TracedFunction) -> str:
    """What a guess of NULL saves."""
    if traced.split is None:
        return ""
    fewer = len(traced.split.sometimes)
    return f" guess may be NULL:\n   then s is not computed, in {fewer} operations fewer."


def _opening(robot: Robot, names: Names, follows: bool) -> str:
    p = names.prefix
    if follows:
        way = (
            "   Loops without a closed form are followed from it, in one step: it must be closed,\n"
            f"   and near u, as the last call left it; {p}_JUMP otherwise.\n"
        )
    else:
        way = "   It decides the whole turns of passive angles; every loop has a closed form.\n"
    return (
        f"/* The robot {comment(robot.name)} in C99, written by hybrid_dynamics.\n"
        "\n"
        "   SI units, radians, base axes; matrices row by row. Functions return a status, and\n"
        "   leave all arrays alone unless it is 0. They keep nothing between calls, and take no\n"
        "   memory but the stack. guess (NS) goes in and out: after a call it holds s.\n"
        f"{way}"
        f"   Begin with {p}_reference. End effector: {comment(robot.end_effector)}. The loads and\n"
        "   assembly modes of the description are compiled in. */\n"
    )


def _name_lists(names: Names, traced: TracedFunction) -> str:
    """Numbers and names of what the results of a function belong to."""
    text = ""
    for kind, listed in traced.lists.items():
        macro = f"{names.prefix}_N_{kind.upper()}S"
        text += f"#define {macro} {len(listed)}\n"
        text += f"extern const char *const {names.prefix}_{kind}_names[{macro}];\n"
    return text


def _coordinates(robot: Robot, names: Names) -> str:
    lines = []
    types: Mapping[str, str] = robot.joint_types
    for k, (name, text) in enumerate(zip(robot.coordinates, names.coordinates, strict=True)):
        unit = "rad" if types[name] == "revolute" else "m"
        role = "u" if k < names.n else "z"
        lines.append(f"    {names.prefix}_Q_{text} = {k}, /* {role} [{unit}] {comment(name)} */")
    lines[-1] = lines[-1].replace(", /*", " /*", 1)
    listed = "\n".join(lines)
    return f"/* indices in s */\nenum {names.prefix}_coordinate {{\n{listed}\n}};\n"


def _status(prefix: str) -> str:
    lines = []
    for kind, (name, text) in STATUS.items():
        lines.append(f"    {prefix}_{name} = {int(kind)}, /* {text} */")
    lines[-1] = lines[-1].replace(", /*", " /*", 1)
    listed = "\n".join(lines)
    return (
        f"enum {prefix}_status {{\n{listed}\n}};\n\n"
        f"/* What a status means, one line. */\n"
        f"const char *{prefix}_status_text(int status);\n"
    )
