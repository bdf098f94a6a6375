"""Every optional input of every call of a robot is heard, and its answer is found another way."""

from __future__ import annotations

import pytest

from hybrid_dynamics_core import Robot
from tests.laws.inputs import of_motion, of_tasks  # noqa: F401  they list their laws
from tests.laws.inputs.ask import LAWS, Ask, Law, optional_inputs

# What no number tells: a display, and programs that only parts of a robot ask for; and what needs
# compiled code, which tests/simulation/test_compiled_steps.py holds.
OTHERS = {"workspace.shown", "kernel.model", "motion_steps.loads"}


def test_every_optional_input_has_its_law() -> None:
    named = [one for each in LAWS for one in each.inputs]
    assert set(named) | OTHERS == optional_inputs(Robot)
    assert len(named) == len(set(named))


@pytest.mark.parametrize("one", LAWS, ids=lambda one: one.check.__name__)
def test_inputs_are_heard_and_right(one: Law) -> None:
    ask = Ask()
    one.check(ask)
    assert ask.heard >= one.inputs
