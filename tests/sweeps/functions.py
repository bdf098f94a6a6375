"""Functions of designs, in a module that other processes find."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import numpy as np

from hybrid_dynamics_core.errors import StateError
from hybrid_dynamics_core.sweeps import Designs

MARK = "SWEEP_KILLED"  # variable with the path of a file that says that the process was killed


def ratio(designs: Designs) -> dict[str, np.ndarray]:
    """Upper arm over forearm."""
    return {"ratio": designs["L2"] / designs["L3"]}


def kills_its_process_once(designs: Designs) -> dict[str, np.ndarray]:
    """The ratio; the process that comes to the third chunk first is killed."""
    mark = Path(os.environ[MARK])
    if len(designs) > 1 and designs["L2"][0] > 0.7 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return ratio(designs)


def height_at_rest(robot) -> dict[str, float]:
    """Height of the tool at the reference."""
    state = robot.close(robot.reference)
    return {"height": float(robot.forward_kinematics(state).position[2])}


def refuses_all(robot) -> dict[str, float]:
    """Raises for every robot."""
    raise StateError(f"not {robot.name}", loop="none")


def fails(designs: Designs) -> dict[str, np.ndarray]:
    """Has a fault."""
    return {"x": designs["L9"]}


def short(designs: Designs) -> dict[str, np.ndarray]:
    """Gives too few numbers."""
    return {"x": designs["L2"][:1]}


def comma(designs):
    """A name that a table cannot have."""
    return {"a,b": designs["L2"]}


def imaginary(designs):
    """Numbers that are not real."""
    return {"x": 1j * designs["L2"]}


def bare(robot):
    """A number without a name."""
    return robot.reference[0]
