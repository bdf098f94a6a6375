"""Studies over many designs of a robot, in threads or on a cluster, that go on after a stop."""

from .designs import Designs, EachRobot
from .folder import read_results
from .run import StoppedStudyError, Swept, sweep, sweep_into
from .spaces import Grid, Listed, Random, grid, listed, random
from .study import Study

__all__ = [
    "Designs",
    "EachRobot",
    "Grid",
    "Listed",
    "Random",
    "StoppedStudyError",
    "Study",
    "Swept",
    "grid",
    "listed",
    "random",
    "read_results",
    "sweep",
    "sweep_into",
]
