"""The C function of a unit for derivatives in one direction."""

from __future__ import annotations

from ... import programs
from ...programs import Program
from ..c.calls import ALL_LOADS, AT_ACCELERATION, AT_EFFORT, CFunction, Setting, same_names
from .variables import FORWARD_DYNAMICS, INVERSE_DYNAMICS

NAME = "directional"


def _of_motion(setting: Setting) -> Program:
    parts = (
        programs.forward_dynamics(setting.pattern),
        programs.MOTION,
        programs.forward_kinematics(setting.frame),
    )
    return programs.directional(parts, ("u", "du", "tau"))


def _of_efforts(setting: Setting) -> Program:
    parts = (programs.inverse_dynamics(setting.pattern),)
    return programs.directional(parts, ("u", "du", "ddu"))


DIRECTIONAL = {
    FORWARD_DYNAMICS: CFunction(
        NAME,
        (*AT_EFFORT, "seed_u", "seed_du", "seed_tau"),
        same_names("d_ddu", "d_s", "d_ds", "d_position", "d_rotation"),
        _of_motion,
        "changes of all results for changes of u, u' and tau, to first order",
        ALL_LOADS,
    ),
    INVERSE_DYNAMICS: CFunction(
        NAME,
        (*AT_ACCELERATION, "seed_u", "seed_du", "seed_ddu"),
        same_names("d_tau"),
        _of_efforts,
        "changes of tau for changes of u, u' and u'', to first order",
        ALL_LOADS,
    ),
}
