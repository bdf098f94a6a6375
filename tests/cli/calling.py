"""One call of the command in this process, alike with click 8.1 of Ubuntu 24.04 and what came after it."""

from __future__ import annotations

from dataclasses import dataclass
from inspect import signature

from click.testing import CliRunner

from hybrid_dynamics_cli.app import app

APART = (
    {"mix_stderr": False} if "mix_stderr" in signature(CliRunner).parameters else {}
)  # until 8.1 they are mixed


@dataclass(frozen=True)
class Answer:
    """What a call printed and how it ended."""

    stdout: str
    stderr: str
    exit_code: int

    @property
    def output(self) -> str:
        """All that was printed; what went to stderr is last."""
        return self.stdout + self.stderr


def call(*arguments: str) -> Answer:
    """Call `hybrid-dynamics` with these words; what it does not catch is not caught."""
    result = CliRunner(**APART).invoke(app, arguments, catch_exceptions=False)
    return Answer(result.stdout, result.stderr, result.exit_code)
