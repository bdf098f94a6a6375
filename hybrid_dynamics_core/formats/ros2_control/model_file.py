"""model.hpp: the C code under the names that the plugins use."""

from __future__ import annotations

from collections.abc import Sequence

from ..c.names import literal
from .sides import Sides

_TEXT = """\
// Generated for the package {package}: the model of {robot}.
#ifndef {package}__MODEL_HPP_
#define {package}__MODEL_HPP_

#include <array>
#include <cstddef>

#include "{drives}.h"
#include "{joints}.h"

namespace {package}
{{

constexpr std::size_t N = {n};    // drives, and joints
constexpr std::size_t NS = {n_s};  // all coordinates
constexpr bool FOLLOWS = {follows};  // whether loops are followed from a guess
constexpr int OK = {drives}_OK, JUMP = {drives}_JUMP;

using Vector = std::array<double, N>;
using Configuration = std::array<double, NS>;

/// The functions of the model for one choice of independent coordinates.
struct Model
{{
  int (*close)(const double *, const double *, double *, double *, double *);
  int (*generalised_forces)(const double *, const double *, double *, double *);
  int (*inverse_dynamics)(
    const double *, const double *, const double *, const double *, double *, double *);
  const double * reference_values;

  /// The reference configuration, closed.
  Configuration reference() const
  {{
    Configuration s{{}};
    for (std::size_t k = 0; k < NS; ++k) {{
      s[k] = reference_values[k];
    }}
    return s;
  }}
}};

inline const Model drives_model{{
  {drives}_close, {drives}_generalised_forces, {drives_dynamics}, {drives}_reference}};
inline const Model joints_model{{
  {joints}_close, {joints}_generalised_forces, {joints_dynamics}, {joints}_reference}};

inline const std::array<const char *, N> DRIVE_NAMES{{{{{drive_names}}}}};
inline const std::array<const char *, N> JOINT_NAMES{{{{{joint_names}}}}};

// joints among the coordinates of the drives' model, drives among those of the joints' model
constexpr std::array<std::size_t, N> JOINTS{{{{{joint_places}}}}};
constexpr std::array<std::size_t, N> DRIVES{{{{{drive_places}}}}};
// coordinates of the joints' model in that of the drives
constexpr std::array<std::size_t, NS> ORDER{{{{{order}}}}};

// of the drives
inline const auto & LIMITS = {drives}_limits;
inline const auto & VELOCITY_LIMITS = {drives}_velocity_limits;
inline const auto & EFFORT_RANGES = {drives}_effort_ranges;

inline std::array<double, 3> description_gravity()
{{
  return {{{{{drives}_gravity[0], {drives}_gravity[1], {drives}_gravity[2]}}}};
}}

inline const char * status_text(int status) {{ return {drives}_status_text(status); }}

}}  // namespace {package}

#endif  // {package}__MODEL_HPP_
"""


def model_text(sides: Sides, package: str, drives: str, joints: str, dynamics: bool) -> str:
    """The text of model.hpp.

    Args:
        sides: drives and joints.
        package: name of the package.
        drives: prefix of the C code with the drives as independent coordinates.
        joints: prefix of the code with the joints.
        dynamics: whether the code has inverse dynamics.
    """
    follows = sides.drives.follows or sides.joints.follows
    return _TEXT.format(
        package=package,
        robot=drives,
        drives=drives,
        joints=joints,
        n=len(sides.drives.active),
        n_s=len(sides.drives.coordinates),
        follows=str(follows).lower(),
        drives_dynamics=f"{drives}_inverse_dynamics" if dynamics else "nullptr",
        joints_dynamics=f"{joints}_inverse_dynamics" if dynamics else "nullptr",
        drive_names=", ".join(map(literal, sides.drives.active)),
        joint_names=", ".join(map(literal, sides.joints.active)),
        joint_places=_listed(sides.joints_in_drives),
        drive_places=_listed(sides.drives_in_joints),
        order=_listed(sides.order),
    )


def _listed(values: Sequence[int]) -> str:
    return ", ".join(map(str, values))
