"""The interface of backends: from a trace to a text, whose digest is a cache key, and to code."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from .ir.module import Form
from .trace import Trace


@dataclass(frozen=True)
class Source:
    """Generated text of a program.

    Attributes:
        text: the text.
        level: optimisation level.
    """

    text: str
    level: int = 0


@dataclass(frozen=True)
class Artifact:
    """Code of one form of a program, and facts of the program.

    Attributes:
        facts: plain data, see `artifact.facts_of`.
        code: result of `Backend.build`.
    """

    facts: dict[str, Any]
    code: bytes


class Backend(Protocol):
    """A module that turns traces into functions."""

    NAME: str

    def identity(self) -> list[str]:
        """All conditions outside of program and package that facts and text depend on."""
        ...

    def conditions(self) -> list[str]:
        """All conditions besides the source that the result of `build` depends on."""
        ...

    def source(self, trace: Trace, form: Form) -> Source:
        """The text of one form of a trace."""
        ...

    def build(self, source: Source) -> bytes:
        """The code of a text."""
        ...

    def load(self, artifact: Artifact) -> Callable[..., int]:
        """The function of inputs, outputs to fill and, for rows, their status; returns a status."""
        ...
