"""The pendulum and the rows of four-bars with MuJoCo."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence

import mujoco
import numpy as np

from benchmarks.table import time_text

from .catalogue import Problem, error

STEPS = (5e-3, 2.5e-3, 1e-3, 5e-4, 2.5e-4)  # [s] of RK4
LONGEST = 10.0  # [s] that a run may take
COUNTS = {"four_bars_1": 1, "four_bars_2": 2, "four_bars_10": 10, "four_bars_40": 40}
HEAD = """\
<mujoco>
  <option gravity="0 -9.81 0" integrator="RK4" timestep="{step}">
    <flag contact="disable"/>
  </option>
  <worldbody>
"""
ROD = '<inertial pos="{pos}" mass="1" diaginertia="{inertia}"/>'
PENDULUM = """\
<body><joint name="a0" axis="0 0 1"/>
<inertial pos="-1 0 0" mass="1" diaginertia="1e-9 1e-9 1e-9"/><site name="tip" pos="-1 0 0"/></body>
"""


def lines(problems: Sequence[Problem]) -> list[str]:
    """One line a problem that is modelled here: the longest step that reaches what is asked.

    Args:
        problems: of the catalogue.
    """
    table = [
        "| problem | step | reached | time | |",
        "|---|---:|---:|---:|---|",
    ]
    modelled = {"pendulum", *COUNTS}
    return table + [_line(problem) for problem in problems if problem.name in modelled]


def _line(problem: Problem) -> str:
    """The line of one problem; the nearest run where none reaches what is asked."""
    reference = references_of(problem)
    best = (math.inf, 0.0, 0.0)  # error, time, step
    verdict = "not reached"
    for step in STEPS:
        seconds, rows = _run(problem, step)
        best = min(best, (error(rows, reference), seconds, step))
        if best[0] <= problem.asked:
            verdict = ""
            break
        if seconds > LONGEST:
            break
    reached, seconds, step = best
    cells = [problem.title, f"{step * 1e3:g} ms", f"{reached:.1e}", time_text(seconds), verdict]
    return f"| {' | '.join(cells)} |"


def references_of(problem: Problem) -> np.ndarray:
    """The reference at the output steps.

    Raises:
        ValueError: the problem has none.
    """
    if problem.reference is None:
        raise ValueError(f"{problem.title}: there is no reference motion")
    return problem.reference(np.linspace(0.0, problem.end, problem.samples + 1))


def _run(problem: Problem, step: float) -> tuple[float, np.ndarray]:
    """The run's time [s], and rows (x, y, x', y') of the tip."""
    text = HEAD.format(step=step) + _bodies(problem.name)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    count = COUNTS.get(problem.name, 0)
    data.qvel[:] = _rates(count)
    inner = round(problem.end / problem.samples / step)
    jacobian = np.zeros((3, model.nv))
    rows = []
    begin = time.perf_counter()
    for _ in range(problem.samples + 1):
        mujoco.mj_forward(model, data)
        mujoco.mj_jacSite(model, data, jacobian, None, 0)
        rate = jacobian @ data.qvel
        rows.append(np.concatenate([data.site_xpos[0, :2], rate[:2]]))
        mujoco.mj_step(model, data, inner)
    return time.perf_counter() - begin, np.array(rows)


def _rates(count: int) -> Sequence[float]:
    """Rates at the start: crank and coupler in turn, then the last crank."""
    if count == 0:
        return [0.0]
    return [-1.0, 1.0] * count + [-1.0]


def _bodies(name: str) -> str:
    """What follows the world's start: bodies and ties."""
    if name == "pendulum":
        return PENDULUM + "</worldbody></mujoco>"
    count = COUNTS[name]
    crank = ROD.format(pos="0 0.5 0", inertia="0.08333333333 1e-9 0.08333333333")
    coupler = ROD.format(pos="0.5 0 0", inertia="1e-9 0.08333333333 0.08333333333")
    bodies = []
    for k in range(count + 1):
        bodies.append(f'<body name="crank{k}" pos="{k} 0 0"><joint axis="0 0 1"/>{crank}')
        if k == 0:
            bodies.append('<site name="tip" pos="0 1 0"/>')
        if k < count:
            place = f'<body name="coupler{k}" pos="0 1 0">'
            bodies.append(f'{place}<joint axis="0 0 1"/>{coupler}</body>')
        bodies.append("</body>")
    bodies.append("</worldbody><equality>")
    for k in range(count):
        ends = f'body1="coupler{k}" body2="crank{k + 1}" anchor="1 0 0"'
        bodies.append(f'<connect {ends} solref="0.004 1" solimp="0.9999 0.9999 0.001"/>')
    bodies.append("</equality></mujoco>")
    return "\n".join(bodies)
