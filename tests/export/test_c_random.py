"""C code of random robots: the numbers of the library, on walks from the reference."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.formats.c.answers import answers, random_arguments
from hybrid_dynamics_core.formats.c.calls import CALLS
from hybrid_dynamics_core.formats.c.states import random_states
from hybrid_dynamics_core.formats.c.tracer import Tracer
from tests.generated.case import Case
from tests.generated.class_three import class_three
from tests.generated.over_determined import KINDS, over_determined
from tests.generated.robots import examples

from .c_builds import build, needs_compiler

COUNT = 5
REGULAR = 0.1  # distance to a singularity; rounding grows with its inverse
ERROR = 1e-12
LEFT_OUT = ("hydraulics", "ik_step", "forward_dynamics_derivatives")


@needs_compiler
@pytest.mark.timeout(900)
@examples(8)
@given(class_three(), st.sampled_from(["description", "arguments"]))
def test_random_robots_have_the_numbers_of_the_library(case: Case, loads: str) -> None:
    assert_has_the_numbers_of_the_library(case.robot, loads)


@needs_compiler
@pytest.mark.sweep(sample="test_random_robots_have_the_numbers_of_the_library")
@pytest.mark.parametrize("kind", KINDS)
def test_over_determined_loops_have_the_numbers_of_the_library(kind: str) -> None:
    """Their least squares are in the code too."""
    assert_has_the_numbers_of_the_library(Robot(over_determined(kind, 1)), "description")


def assert_has_the_numbers_of_the_library(robot: Robot, loads: str) -> None:
    rng = np.random.default_rng(1)
    found = list(random_states(robot, COUNT, rng))
    assert found
    loaded = loads == "arguments"
    tracer = Tracer(robot, with_loads=loaded)
    with tempfile.TemporaryDirectory() as folder:
        calls = [call for call in CALLS if call.name not in LEFT_OUT]
        names = [call.name for call in calls]
        here = build(robot, Path(folder), names, fast=True, loads=loads)
        for call in calls:
            traced = tracer.trace(call)
            for guess, state in found:
                arguments = random_arguments(robot, state, rng)
                inputs = [arguments[name] for name in traced.inputs]
                wanted = answers(robot, call.name, state, arguments, loaded)
                got = here.call(call.name, [*inputs, guess], list(traced.results.values()))
                assert got.status == 0, call.name
                error = ERROR / min(1.0, state.singularity / REGULAR) ** 2
                assert np.abs(got.guess - state.s).max() <= error
                for out, name in zip(got.outs, traced.results, strict=True):
                    value = np.ravel(wanted[name])
                    scale = np.abs(value).max(initial=1.0, where=np.isfinite(value))
                    is_close = np.abs(out - value) <= error * scale
                    assert (is_close | (np.isnan(out) & np.isnan(value))).all(), (call.name, name)
