"""Random robots go out in every format and come back the same."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest
from hypothesis import given

from hybrid_dynamics_core import load
from tests.export.test_round_trip import FORMS, write
from tests.generated.case import Case
from tests.generated.robots import STATES, examples, robots
from tests.generated.test_closure_laws import close_to, margin


@pytest.mark.parametrize("form", FORMS)
@examples(4)
@given(robots(), STATES)
def test_a_robot_comes_back(form: str, case: Case, seed: int) -> None:
    with tempfile.TemporaryDirectory() as folder:
        back = load(write(case.robot, form, Path(folder)))
    s, du, ddu = case.somewhere(seed), case.rates(seed), case.rates(seed + 1)
    assert back.active == case.robot.active
    one, two = case.robot.close(s[: case.n], du), back.close(s[: case.n], du)
    order = [back.coordinates.index(name) for name in case.robot.coordinates]
    m = margin(case, s)
    assert close_to(
        one.s, two.s[order], 1e-9 / m
    )  # angles of rotations are written with 1e-16, near +-90 degrees less
    a, b = (robot.inverse_dynamics(state, ddu) for robot, state in ((case.robot, one), (back, two)))
    assert close_to(a, b, 1e-9 / m**3 * max(1.0, abs(a).max()))
