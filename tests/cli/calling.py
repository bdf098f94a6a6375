"""Calls of the command in this process."""

from __future__ import annotations

import json
from dataclasses import dataclass
from importlib import resources
from inspect import signature
from typing import Any

from click.testing import CliRunner

from hybrid_dynamics_cli.app import app

SEPARATE_STDERR: dict[str, Any] = {}
if "mix_stderr" in signature(CliRunner).parameters:  # click 8.1, of Ubuntu 24.04, mixes them
    SEPARATE_STDERR = {"mix_stderr": False}


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
    result = CliRunner(**SEPARATE_STDERR).invoke(app, arguments, catch_exceptions=False)
    return Answer(result.stdout, result.stderr, result.exit_code)


def call_line(line: str) -> Answer:
    """Call `hybrid-dynamics` with the words of a line."""
    return call(*line.split())


def data_of(*arguments: str) -> dict[str, Any]:
    """What a verb prints with --json."""
    result = call(*arguments, "--json")
    assert result.exit_code == 0, result.output
    answer: dict[str, Any] = json.loads(result.stdout)
    return answer


def shipped_text(name: str) -> str:
    """The text of a shipped robot's file."""
    robots = resources.files("hybrid_dynamics_core").joinpath("robots")
    return robots.joinpath(f"{name}.yaml").read_text(encoding="utf-8")
