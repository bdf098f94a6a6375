"""Status codes and outcomes are the same thing, written as a number and by name."""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core.closed_state.state import ClosureStatus, closure_statuses
from hybrid_dynamics_core.kernels import status
from hybrid_dynamics_core.programs import Outcome, OutcomeKind, kinds

OUTCOMES = [
    Outcome(OutcomeKind.CLOSED),
    *(Outcome(OutcomeKind.UNREACHABLE, block) for block in range(4)),
    *(Outcome(OutcomeKind.SINGULAR, block) for block in range(4)),
    Outcome(OutcomeKind.JUMP),
    Outcome(OutcomeKind.NOT_FINITE),
    Outcome(OutcomeKind.MASS_SINGULAR),
]


@pytest.mark.parametrize("outcome", OUTCOMES, ids=str)
def test_a_code_stands_for_the_outcome_it_was_made_from(outcome: Outcome) -> None:
    assert Outcome.decode(outcome.encode()) == outcome


def test_no_two_outcomes_share_a_code() -> None:
    codes = [outcome.encode() for outcome in OUTCOMES]
    assert len(set(codes)) == len(codes)
    assert status.NOT_TAKEN not in codes


def test_kinds_of_many_codes_are_those_of_each() -> None:
    codes = np.array([outcome.encode() for outcome in OUTCOMES])
    assert kinds(codes).tolist() == [outcome.kind for outcome in OUTCOMES]
    assert kinds(codes[3]) == OUTCOMES[3].kind


def test_statuses_of_a_closure_are_closed_out_of_reach_or_singular() -> None:
    codes = np.array([outcome.encode() for outcome in OUTCOMES])
    expected = [min(outcome.kind, ClosureStatus.SINGULAR) for outcome in OUTCOMES]
    assert closure_statuses(codes).tolist() == expected
