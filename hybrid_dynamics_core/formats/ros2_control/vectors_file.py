"""test_core.cpp: a program that checks the numbers of the plugins against the library."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...ground.arrays import Array
from ..c.emit import constant
from ..c.states import REGULAR, random_states
from .sides import Sides

COUNT = 10  # states
SAME = 1e-6  # [rad or m] configurations of one assembly mode
WORST = 1e4  # condition of the rates of joints, beyond which digits are lost

_HEAD = """\
// Generated for the package {package}: checks its numbers against those of the library. It ends
// with 0 if all hold.
#include <cmath>
#include <cstdio>
#include <vector>

#include "{package}/core.hpp"

namespace
{{

using {package}::N;
using {package}::Vector;

struct Row
{{
  // along the drives, then the same along the joints
  Vector u, du, tau, q, dq, forces;
  // accelerations of drives and joints, and efforts for them
  Vector ddu, ddq, drive_efforts, joint_efforts;
}};

const std::vector<Row> rows = {{
{rows}}};

bool differ(const char * what, const Vector & got, const Vector & wanted)
{{
  double largest = 1.0;
  for (std::size_t k = 0; k < N; ++k) {{
    largest = std::fmax(largest, std::fabs(wanted[k]));
  }}
  for (std::size_t k = 0; k < N; ++k) {{
    if (!(std::fabs(got[k] - wanted[k]) <= 1e-8 * largest)) {{
      std::printf("%s: %.17g, by the library %.17g\\n", what, got[k], wanted[k]);
      return true;
    }}
  }}
  return false;
}}

{package}::Values values(const Vector & position, const Vector & velocity, const Vector & effort)
{{
  {package}::Values result;
  result.position = position;
  result.velocity = velocity;
  result.effort = effort;
  result.has_position = result.has_velocity = result.has_effort = true;
  return result;
}}

}}  // namespace

int main()
{{
  {package}::TransmissionCore transmission(false);
{cores}  int failed = 0;
  for (const Row & row : rows) {{
    {package}::Values joints, drives;
    bool wrong = transmission.to_joints(values(row.u, row.du, row.tau), joints) != {package}::OK;
    wrong = wrong || differ("joint positions", joints.position, row.q) ||
            differ("joint velocities", joints.velocity, row.dq) ||
            differ("joint efforts", joints.effort, row.forces);
    const auto commands = values(row.q, row.dq, row.forces);
    wrong = wrong || transmission.to_drives(commands, drives) != {package}::OK;
    wrong = wrong || differ("drive positions", drives.position, row.u) ||
            differ("drive velocities", drives.velocity, row.du) ||
            differ("drive efforts", drives.effort, row.tau);
{checks}    failed += wrong ? 1 : 0;
  }}
  const int count = static_cast<int>(rows.size());
  std::printf("%d of %d as the library\\n", count - failed, count);
  return failed == 0 ? 0 : 1;
}}
"""
_CORES = """\
  {package}::FeedForwardCore along_drives(false, false), along_joints(true, false);
"""
_CHECKS = """\
    Vector efforts{{}};
    wrong = wrong || along_drives.compute(row.u, row.du, row.ddu, efforts) != {package}::OK ||
            differ("efforts of the drives", efforts, row.drive_efforts);
    wrong = wrong || along_joints.compute(row.q, row.dq, row.ddq, efforts) != {package}::OK ||
            differ("efforts along the joints", efforts, row.joint_efforts);
"""


def vectors_text(sides: Sides, package: str, dynamics: bool) -> str:
    """The text of test_core.cpp.

    Args:
        sides: drives and joints.
        package: name of the package.
        dynamics: whether the code has inverse dynamics.
    """
    rows = "".join(f"  {{{_row(row)}}},\n" for row in _rows(sides))
    cores, checks = "", ""
    if dynamics:
        cores = _CORES.format(package=package)
        checks = _CHECKS.format(package=package)
    return _HEAD.format(package=package, rows=rows, cores=cores, checks=checks)


def _row(vectors: Sequence[Array]) -> str:
    texts = []
    for vector in vectors:
        numbers = ", ".join(map(constant, vector.tolist()))
        texts.append(f"{{{{{numbers}}}}}")
    return ",\n    ".join(texts)


def _rows(sides: Sides) -> list[list[Array]]:
    """Ten vectors for each state: by the library, without the code of the joints' model."""
    robot = sides.drives
    rng = np.random.default_rng(0)
    states = [state for _, state in random_states(robot, COUNT, rng)]
    if not states:
        states = [robot.close(robot.reference)]
    places = sides.joints_in_drives
    rows = []
    for state in states:
        rates = state.R[places]
        if np.linalg.cond(rates) > WORST or not _is_regular(sides, state.s):
            continue
        tau, ddu = rng.uniform(-1.0, 1.0, (2, state.n))
        efforts = robot.inverse_dynamics(state, ddu)
        along_drives = [state.u, state.du, tau]
        # the same power: tau u' = forces q' for all u', with q' = rates u'
        along_joints = [state.s[places], state.ds[places], np.linalg.solve(rates.T, tau)]
        ddq = robot.accelerations(state, ddu)[places]
        dynamics = [ddu, ddq, efforts, np.linalg.solve(rates.T, efforts)]
        rows.append([*along_drives, *along_joints, *dynamics])
    return rows


def _is_regular(sides: Sides, s: Array) -> bool:
    """Whether the joints determine a configuration (n_s,) of the drives' model.

    At a toggle two assembly modes meet, and behind it the configuration is on the other one.
    """
    back = sides.joints.close(s[sides.joints_in_drives], check=False)
    if back.status or not back.singularity > REGULAR:
        return False
    return bool(np.abs(back.s - s[sides.order]).max() < SAME)
