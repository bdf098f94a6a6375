"""Programs of inputs that are rounded to 32 bits."""

from __future__ import annotations

from dataclasses import replace

from ..kernels.trace import Check, Results
from .model import Inputs, Model, Program
from .outcome import Outcome, OutcomeKind

# by how much the value of a check may be below its threshold: nearly closed counts as closed,
# nearly singular as singular
SLACK_32 = {
    OutcomeKind.UNREACHABLE: 2e-5,
    OutcomeKind.JUMP: 2e-5,
    OutcomeKind.MASS_SINGULAR: -1e-6,
}


def of_rounded(program: Program) -> Program:
    """The same program, with checks that allow for the rounding of its inputs."""

    def run(model: Model, x: Inputs) -> Results:
        results = program.run(model, x)
        return replace(results, checks=[_allowing(check) for check in results.checks])

    return Program(program.inputs, run, program.sizes)


def _allowing(check: Check) -> Check:
    slack = SLACK_32.get(Outcome.decode(check.code).kind, 0.0)
    return replace(check, threshold=check.threshold - slack)
