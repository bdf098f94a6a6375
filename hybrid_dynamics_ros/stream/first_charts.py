"""Ball and free joints on topics: their angles are those of the URDF, in one chart alone."""

from __future__ import annotations

import numpy as np

from hybrid_dynamics_core import ClosedState, InputError, Robot, SingularityError
from hybrid_dynamics_core.algebra.charts import FIRST


def require_first_reference(robot: Robot) -> None:
    """Raise InputError where a ball or free joint stands in its second chart at the reference."""
    for name, chart in robot.description.charts.items():
        if chart != FIRST:
            raise InputError(
                f"joint {name}: its second turn is beyond a radian at the reference, where topics"
                " and URDF have no good angles for it; turn the origin of the joint"
            )


def require_first_charts(robot: Robot, state: ClosedState) -> None:
    """Raise SingularityError where a ball joint in a loop went on in its second chart."""
    count = len(robot.middle_turns)
    if not count:
        return
    charts = state.signs[..., state.signs.shape[-1] - count :]
    if np.any(charts != FIRST):
        problem = (
            "a ball or free joint is so near a quarter turn of its second turn that it has no good"
            " angles on topics; turn the origin of the joint"
        )
        raise SingularityError(problem, loop="", distance=0.0)
