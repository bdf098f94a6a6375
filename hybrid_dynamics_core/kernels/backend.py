"""What makes code of a trace: text first, whose digest says whether the code is there already."""

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
        level: how well a compiler optimises it.
    """

    text: str
    level: int = 0


@dataclass(frozen=True)
class Artifact:
    """Code of one form of a program, and what is known of the program.

    Attributes:
        facts: plain data, see `artifact.facts_of`.
        code: what `Backend.build` gave.
    """

    facts: dict[str, Any]
    code: bytes


class Backend(Protocol):
    """A module that makes functions of traces."""

    NAME: str

    def identity(self) -> list[str]:
        """Everything outside program and package that facts and text depend on."""
        ...

    def conditions(self) -> list[str]:
        """Everything beside the source that decides the code which `build` makes."""
        ...

    def source(self, trace: Trace, form: Form) -> Source:
        """The text of one form of a trace."""
        ...

    def build(self, source: Source) -> bytes:
        """The code of a text."""
        ...

    def load(self, artifact: Artifact) -> Callable[..., int]:
        """The function: inputs, outputs that are filled, and for rows their status; a status."""
        ...
