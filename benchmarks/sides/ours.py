"""The library itself: compiled, and without a compiler."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.kernels.run import VARIABLE, default_backend

from ..side import Side


def sides(robot: Robot) -> list[Side]:
    """As it is installed and, where that is compiled, as it is without a compiler."""
    if default_backend() == "python":
        return [Side("hybrid_dynamics, no compiler", calls(robot))]
    given = os.environ.get(VARIABLE)
    os.environ[VARIABLE] = "python"
    plain = calls(Robot(robot.description))
    if given is None:
        del os.environ[VARIABLE]
    else:
        os.environ[VARIABLE] = given
    return [Side("hybrid_dynamics", calls(robot)), Side("hybrid_dynamics, no compiler", plain)]


def calls(robot: Robot) -> dict[str, Callable[..., Any]]:
    """The compiled calls, which are made when first looked up."""
    kernels = robot.kernels
    return {
        "id": kernels.inverse_dynamics,
        "id_out": kernels.inverse_dynamics,
        "minimal": kernels.minimal_form,
        "close": kernels.close,
        "id_batch": kernels.inverse_dynamics,
        "fd": kernels.forward_dynamics,
    }
