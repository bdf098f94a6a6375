"""Signatures of the C functions, the same in header, source and test."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from .calls import GUESS, TracedCall


@dataclass(frozen=True)
class Names:
    """Identifiers of a robot in C.

    Attributes:
        prefix: the robot's name.
        coordinates: of all coordinates, in order.
        n: number of active coordinates.
    """

    prefix: str
    coordinates: tuple[str, ...]
    n: int

    @property
    def nu(self) -> str:
        """Macro of the number of active coordinates."""
        return f"{self.prefix}_NU"

    @property
    def ns(self) -> str:
        """Macro of the number of all coordinates."""
        return f"{self.prefix}_NS"

    def length(self, input_name: str) -> str:
        """Length of an input vector in C."""
        if input_name == "gravity":
            return "3"
        return self.ns if input_name == GUESS else self.nu

    def count(self, input_name: str) -> int:
        """Length of an input vector."""
        if input_name == "gravity":
            return 3
        return len(self.coordinates) if input_name == GUESS else self.n


def signature(names: Names, traced: TracedCall) -> str:
    """The declaration of a function, without a semicolon."""
    call = traced.call
    arguments = [f"const double {name}[{names.length(name)}]" for name in call.inputs]
    arguments.append(f"double guess[{names.ns}]")
    for name, size in zip(call.results.values(), traced.sizes, strict=True):
        arguments.append(f"double {name}[{size}]")
    listed = ",\n    ".join(arguments)
    return f"int {names.prefix}_{call.name}(\n    {listed})"


def total(traced: TracedCall) -> int:
    """Number of results, those of the configuration not counted."""
    return sum(traced.sizes)


def rows(values: Sequence[str], width: int = 4) -> str:
    """Values of an initializer, some to a line."""
    lines = [", ".join(values[k : k + width]) for k in range(0, len(values), width)]
    return ",\n    ".join(lines)
