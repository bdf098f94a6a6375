"""Single precision: its tolerances, and C of double rewritten as C of float."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from typing import Literal

from ... import programs
from ...algebra.numerics import SMALL_STEP
from ...kernels.trace import Check
from ...programs import Outcome, OutcomeKind
from .solvers import newton_text

Real = Literal["double", "float"]
REALS = ("double", "float")


@dataclass(frozen=True)
class Precision:
    """Tolerances of generated code.

    Attributes:
        near: [rad or m] a guess farther from closed belongs to another assembly mode, or to none.
        agreement: with the library, as a share of the largest result.
        singular: distance to a singularity below which rates would lose half their digits.
    """

    near: float
    agreement: float
    singular: float


SINGULAR = 3e-4  # distance to a singularity, of 32 bits
PRECISIONS = {
    "double": Precision(1e-4, 1e-10, programs.SINGULAR),
    "float": Precision(1e-3, 2e-3, SINGULAR),
}
OPEN = 1e-4  # residual of a redundant equation, in lengths of its loop
SLACK = 2e-5  # [rad or m] of a move, for rounding
SINGULAR_MASS = 1e-5  # share of the robot's scale of inertia
SINGLE_STEP = 5e-4  # [rad or m] after such a step of Newton only rounding is left
SMALLEST, LARGEST = 1.2e-38, 3.4e38  # of normal numbers
_TOKEN = re.compile(
    r"/\*.*?\*/|\"(?:\\.|[^\"\\])*\""
    r"|(?P<number>\b(?:\d+\.\d*(?:e[+-]?\d+)?|\d+e[+-]?\d+)(?!\w))"
    r"|(?P<type>\bdouble\b)"
    r"|(?P<epsilon>\bDBL_EPSILON\b)"
    r"|(?P<call>\b(?:sin|cos|sqrt|fabs|rint|copysign|fmax)(?=\())",
    re.DOTALL,
)


def loosened(check: Check, blocks: int) -> Check:
    """A check with the threshold of single precision.

    Args:
        check: of a traced program.
        blocks: number of blocks of the closure plan.
    """
    kind, block = Outcome.decode(check.code)
    threshold = check.threshold
    if kind is OutcomeKind.JUMP:
        threshold -= SLACK
    elif kind is OutcomeKind.SINGULAR and threshold:
        threshold = max(threshold, SINGULAR)
    elif kind is OutcomeKind.UNREACHABLE and block > blocks:
        threshold -= OPEN
    elif kind is OutcomeKind.MASS_SINGULAR and threshold:
        threshold = math.copysign(SINGULAR_MASS, threshold)
    return replace(check, threshold=threshold)


def in_single_precision(text: str) -> str:
    """The C text with float in place of double; comments and strings stay."""
    text = text.replace(newton_text(SMALL_STEP), newton_text(SINGLE_STEP))
    return _TOKEN.sub(_single, text)


def _single(match: re.Match[str]) -> str:
    if match["type"]:
        return "float"
    if match["epsilon"]:
        return "FLT_EPSILON"
    if match["call"]:
        return f"{match['call']}f"
    if match["number"]:
        return _number(match["number"])
    return match[0]


def _number(text: str) -> str:
    value = float(text)
    if value > LARGEST:
        return "(float)INFINITY"
    if 0.0 < value < SMALLEST:
        return f"{SMALLEST!r}f"
    return f"{text}f"
