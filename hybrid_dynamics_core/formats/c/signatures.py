"""Signatures of the C functions, the same in header, source and test."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ...programs import TARGET
from .calls import FRICTION, GUESS
from .tracer import PAYLOAD, TracedFunction

FIXED = {"gravity": 3, "payload": PAYLOAD, **TARGET}
ALONG_S = (GUESS, "forces", *FRICTION)


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
        if input_name in FIXED:
            return str(FIXED[input_name])
        return self.ns if input_name in ALONG_S else self.nu

    def count(self, input_name: str) -> int:
        """Length of an input vector."""
        if input_name in FIXED:
            return FIXED[input_name]
        return len(self.coordinates) if input_name in ALONG_S else self.n


def signature(names: Names, traced: TracedFunction) -> str:
    """The declaration of a function, without a semicolon."""
    arguments = [f"const double {name}[{names.length(name)}]" for name in traced.inputs]
    arguments.append(f"double guess[{names.ns}]")
    for name, size in traced.results.items():
        arguments.append(f"double {name}[{size}]")
    listed = ",\n    ".join(arguments)
    return f"int {names.prefix}_{traced.call.name}(\n    {listed})"


def rows(values: Sequence[str], width: int = 4) -> str:
    """Values of an initializer, some to a line."""
    lines = [", ".join(values[k : k + width]) for k in range(0, len(values), width)]
    return ",\n    ".join(lines)
