"""Samples of whole sets: what `make test` runs of them, and `make test-all` runs whole.

A case that is not in the sample carries the mark `sweep`. Random searches draw fewer examples.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterable, Sequence
from typing import Any, TypeVar

import pytest
from hypothesis import settings

Test = TypeVar("Test", bound=Callable[..., Any])

# Every kind of block and of closure, as tests/core/test_sampling.py shows.
SAMPLE = ("delta", "forging_chu2020", "rssr", "slider_crank", "welded")
# The shipped ones among them, and one whose loops Newton closes.
SHIPPED_SAMPLE = ("ankle", "delta", "forging_chu2020")

# Whole sets of random examples where it is set; so many times as many, others at each run, above 1.
MORE_EXAMPLES = os.environ.get("MORE_EXAMPLES")
SHARE = 12  # the sample of random examples is a twelfth


def swept(cases: Iterable[Any], sample: Collection[Any] | None = None) -> list[Any]:
    """Parameters of a test of a whole set.

    Args:
        cases: names, or tuples of a name and further parameters.
        sample: names that `make test` runs; SAMPLE where the set has all of it, else SHIPPED_SAMPLE
            too.

    Returns:
        For `pytest.mark.parametrize`, those outside the sample marked `sweep`.
    """
    rows = [case if isinstance(case, tuple) else (case,) for case in cases]
    if sample is None:
        is_whole = {values[0] for values in rows}.issuperset(SAMPLE)
        sample = SAMPLE if is_whole else (*SAMPLE, *SHIPPED_SAMPLE)
    return [pytest.param(*values, marks=sweep_unless(values[0] in sample)) for values in rows]


def sweep_unless(is_sample: bool) -> Sequence[pytest.MarkDecorator]:
    """The marks of a case."""
    return () if is_sample else (pytest.mark.sweep,)


def examples(number: int, **others: Any) -> Callable[[Test], Test]:
    """So many random examples of a law, or a sample of them.

    Args:
        number: of the whole set.
        **others: further settings of Hypothesis.

    Returns:
        A decorator.
    """
    count = max(1, number // SHARE) if MORE_EXAMPLES is None else number * int(MORE_EXAMPLES)
    is_same_each_time = MORE_EXAMPLES in (None, "1")
    chosen = settings(max_examples=count, derandomize=is_same_each_time, **others)

    def decorate(test: Test) -> Test:
        marked: Test = pytest.mark.examples(chosen(test))
        return marked

    return decorate
