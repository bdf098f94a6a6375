"""unit_model.h: what ties the C code of a unit to that of the model."""

from __future__ import annotations

from collections.abc import Sequence

from ...robot.robot import Robot
from ..c.names import identifier, literal
from .limits import Limit, limits_of
from .variables import FORWARD_DYNAMICS, Variable

CONSTANTS = ("reference", "status_text")
FUNCTIONS = (
    "close",
    "inverse_dynamics",
    "forward_dynamics",
    "forward_kinematics",
    "directional",
)
STATUSES = ("OK", "JUMP", "NOT_FINITE", "SINGULAR_MASS")
# blocks that may have no variables, each before the one that would follow it
EMPTY = (("DISTANCE", "STOP"), ("DZ", "POSITION"), ("Z", "DZ"))
LOADS = "(v) + V_PAYLOAD, (v) + V_VISCOUS, (v) + V_COULOMB,"


def model_text(robot: Robot, program: str, variables: Sequence[Variable], token: str) -> str:
    """The functions of the robot under common names, value references and limits.

    Args:
        robot: the robot.
        program: of the unit.
        variables: in the order of their value references.
        token: marks the unit.
    """
    model = identifier(robot.name)
    firsts = _first_references(variables)
    limits = limits_of(robot) if program == FORWARD_DYNAMICS else []
    inputs = [k for k, variable in enumerate(variables) if variable.causality == "input"]
    lines = ["/* Generated: what ties the unit to the model. */", f'#include "{model}.h"', ""]
    lines += [f"#define UNIT_TOKEN {literal(token)}"]
    lines += [f"#define NU {model}_NU", f"#define NS {model}_NS"]
    lines += [f"#define FOLLOWS {int(robot.follows)} /* whether loops have no closed form */"]
    lines += [f"#define unit_{name} {model}_{name}" for name in (*CONSTANTS, *FUNCTIONS)]
    lines += [f"#define UNIT_{name} {model}_{name}" for name in STATUSES]
    lines += ["", "/* value references */"]
    lines += [f"#define V_{block} {number}u" for block, number in firsts.items()]
    lines += [f"#define V_INPUTS {inputs[0]}u", f"#define V_INPUTS_END {inputs[-1] + 1}u"]
    lines += [f"#define V_COUNT {firsts['STOP']}u", ""]
    lines += [f"#define LOADS(v) {LOADS if 'PAYLOAD' in firsts else ''}", ""]
    starts = [variable.start or 0.0 for variable in variables if variable.type == "Real"]
    values = ", ".join(map(repr, starts))
    lines += [f"static const double unit_starts[V_COUNT] = {{{values}}};"]
    return "\n".join([*lines, *_limit_lines(limits), ""])


def _first_references(variables: Sequence[Variable]) -> dict[str, int]:
    """The first value reference of each block."""
    firsts: dict[str, int] = {}
    for number, variable in enumerate(variables):
        firsts.setdefault(variable.block, number)
    firsts.setdefault("STOP", len(variables))
    for block, following in EMPTY:
        firsts.setdefault(block, firsts.get(following, firsts["STOP"]))
    return firsts


def _limit_lines(limits: Sequence[Limit]) -> list[str]:
    """The table of limits; with one entry where there are none, since C has no empty arrays."""
    rows = []
    for limit in limits:
        side = 1.0 if limit.is_upper else -1.0
        rows.append(f"    {{{limit.index}, {limit.value!r}, {side}, {literal(limit.text)}}}")
    table = ",\n".join(rows or ["    {0, 0.0, 0.0, NULL}"])
    return [
        "",
        f"#define N_LIMITS {len(limits)}",
        "typedef struct {",
        "    int index;",
        "    double value, side; /* side: 1 of an upper limit, -1 of a lower one */",
        "    const char *text;",
        "} unit_limit;",
        "static const unit_limit unit_limits[] = {",
        table,
        "};",
    ]
