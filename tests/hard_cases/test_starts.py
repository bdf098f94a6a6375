"""Robots that name no reference: one is found near the zeros of the joints, closed and regular."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import DescriptionError, Robot
from hybrid_dynamics_core.formats.reader import parse_description
from tests.generated.case import Case
from tests.generated.class_three import class_three
from tests.generated.reframed import reframed
from tests.generated.robots import examples

CRANK, COUPLER, ROCKER, GROUND = 1.0, 0.5, 0.4, 1.2
LEG = """\
  crank{k}: {{type: revolute, parent: base, child: crank{k}, axis: z, origin: {{rpy: [0, 0, {a}]}}}}
  coupler{k}: {{type: revolute, parent: crank{k}, child: coupler{k}, axis: z,
                origin: {{xyz: [{crank}, 0, 0], rpy: [0, 0, {b}]}}}}
  rocker{k}: {{type: revolute, parent: base, child: rocker{k}, axis: z,
               origin: {{xyz: [{ground}, 0, 0], rpy: [0, 0, {c}]}}}}
"""
CLOSURE = (
    "  loop{k}: {{kind: {kind}, {mode}"
    " between: {{coupler{k}: [{coupler}, 0, 0], rocker{k}: [{rocker}, 0, 0]}}}}\n"
)
ANGLE = st.floats(-math.pi, math.pi)


def four_bars(count: int, zeros: tuple[float, float, float], kind: str, how: str) -> str:
    """Four-bars side by side, each with its joints' zeros turned by angles [rad]."""
    sizes = {"crank": CRANK, "coupler": COUPLER, "rocker": ROCKER, "ground": GROUND}
    mode = "assembly: clockwise," if how == "exact" else ""
    named = dict(zip("abc", zeros, strict=True), kind=kind, mode=mode, **sizes)
    bodies = [f"crank{k}: {{mass: 1}}, coupler{k}: {{}}, rocker{k}: {{}}" for k in range(count)]
    joints = "".join(LEG.format(k=k, **named) for k in range(count))
    closures = "".join(CLOSURE.format(k=k, **named) for k in range(count))
    active = ", ".join(f"crank{k}" for k in range(count))
    return (
        f"format: 1\nname: four_bars\nlinks: {{base: {{}}, {', '.join(bodies)}}}\n"
        f"joints:\n{joints}closures:\n{closures}active: [{active}]\nactive_set: {how}\n"
        "end_effector: {link: crank0}\n"
    )


def nearest_closing(zero: float) -> float:
    """How far the crank has to turn from its zero until the loop closes [rad], by hand."""

    def opening(distance: float) -> float:
        return math.acos((CRANK**2 + GROUND**2 - distance**2) / (2.0 * CRANK * GROUND))

    within, beyond = opening(COUPLER - ROCKER + (GROUND - CRANK)), opening(COUPLER + ROCKER)
    angle = abs(math.remainder(zero, math.tau))
    return max(angle - beyond, 0.0) if angle > within else 0.0


@examples(40)
@given(
    zeros=st.tuples(ANGLE, ANGLE, ANGLE),
    kind=st.sampled_from(["planar", "point"]),
    how=st.sampled_from(["motors", "exact"]),
)
def test_a_reference_near_zero_is_found_and_named(
    zeros: tuple[float, float, float], kind: str, how: str
) -> None:
    robot = Robot(parse_description(four_bars(1, zeros, kind, how), file="bars.yaml"))
    state = robot.close(robot.reference)
    assert state.residual < 1e-12
    assert state.singularity > 1e-3
    turned, least = abs(float(robot.reference[0])), nearest_closing(zeros[0])
    assert least <= turned + 1e-6
    assert turned <= least + 0.6
    if least > 0.1:
        named = f"crank0 = {robot.reference[0]:.4g}"
        assert any(named in note for note in robot.description.notes)
        assert robot.description.reference["crank0"] == robot.reference[0]


def test_loops_apart_are_searched_apart() -> None:
    zeros = (2.5, 1.0, -2.0)
    one = Robot(parse_description(four_bars(1, zeros, "planar", "motors"), file="one.yaml"))
    four = Robot(parse_description(four_bars(4, zeros, "planar", "motors"), file="four.yaml"))
    assert four.reference == pytest.approx(np.repeat(one.reference, 4), abs=1e-9)


@examples(12)
@given(case=class_three(), seed=st.integers(0, 10**6))
def test_random_robots_start_wherever_their_zeros_are(case: Case, seed: int) -> None:
    description, _ = reframed(case.description, seed, farthest=math.pi)
    robot = Robot(replace(description, reference={}, active_set="motors"))
    state = robot.close(robot.reference)
    assert state.residual < 1e-9
    assert state.singularity > 1e-6
    lower, upper = robot.limits.T
    assert np.all((lower <= robot.reference) & (robot.reference <= upper))


def test_what_closes_nowhere_is_refused_with_its_gap() -> None:
    text = four_bars(1, (0.0, 0.0, 0.0), "planar", "motors")
    far = text.replace(f"xyz: [{GROUND}, 0, 0]", "xyz: [3.2, 0, 0]")
    with pytest.raises(DescriptionError, match=r"does not close: .* stay 1\.3 m apart"):
        Robot(parse_description(far, file="far.yaml"))
