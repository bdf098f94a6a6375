"""A load's centre of mass lies where a tool can carry one, or a sensor is off."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from hybrid_dynamics_core.estimation import SensorError
from hybrid_dynamics_core.estimation.misfit import check_place
from hybrid_dynamics_core.estimation.run import MeasuredRun

REACH = 1.6  # [m]
RUN = cast("MeasuredRun", SimpleNamespace(robot=SimpleNamespace(name="crane")))


def test_a_load_surely_beyond_reach_is_refused() -> None:
    with pytest.raises(SensorError, match=r"\(0.00, -1.00, 6.60\) m .* crane .* exchanged"):
        check_place(RUN, np.array([0.0, -1.0, 6.6]), np.full(3, 0.3), REACH)


@pytest.mark.parametrize("com", [[0.0, -1.0, 4.0], [6.6, 0.0, 0.0], [0.0, 0.0, -1.0]])
def test_a_load_within_reach_or_that_nothing_shows_is_not(com: list[float]) -> None:
    deviation = np.array([2.0, 0.3, 0.3])  # x is not seen well
    check_place(RUN, np.array(com), deviation, REACH)
