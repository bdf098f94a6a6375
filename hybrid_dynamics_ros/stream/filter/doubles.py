"""Traced doubles: each operator writes one instruction of a function.

Operations are neither fused nor reordered, so that the function and Python give the same bits.
"""

from __future__ import annotations

from hybrid_dynamics_core.kernels.ir.text import Function, constant

DECLARATIONS = """declare double @exp(double)
declare double @expm1(double)
"""


class Double:
    """A double in a function, with the name of its value."""

    __slots__ = ("function", "name")

    def __init__(self, function: Function, name: str) -> None:
        self.function, self.name = function, name

    def _let(self, instruction: str) -> Double:
        return Double(self.function, self.function.let(instruction))

    def __add__(self, other: Double | float) -> Double:
        return self._let(f"fadd double {self.name}, {name_of(other)}")

    def __radd__(self, other: float) -> Double:
        return self._let(f"fadd double {name_of(other)}, {self.name}")

    def __sub__(self, other: Double | float) -> Double:
        return self._let(f"fsub double {self.name}, {name_of(other)}")

    def __rsub__(self, other: float) -> Double:
        return self._let(f"fsub double {name_of(other)}, {self.name}")

    def __mul__(self, other: Double | float) -> Double:
        return self._let(f"fmul double {self.name}, {name_of(other)}")

    def __rmul__(self, other: float) -> Double:
        return self._let(f"fmul double {name_of(other)}, {self.name}")

    def __truediv__(self, other: Double | float) -> Double:
        return self._let(f"fdiv double {self.name}, {name_of(other)}")

    def __rtruediv__(self, other: float) -> Double:
        return self._let(f"fdiv double {name_of(other)}, {self.name}")

    def __neg__(self) -> Double:
        return self._let(f"fneg double {self.name}")

    def exp(self) -> Double:
        """The C library's, which Python calls too."""
        return self._let(f"call double @exp(double {self.name})")

    def expm1(self) -> Double:
        """The C library's, which Python calls too."""
        return self._let(f"call double @expm1(double {self.name})")

    def choose(self, other: Double | float, yes: Double | float, no: Double | float) -> Double:
        """`yes` if this is larger than `other`, otherwise `no`."""
        is_larger = self.function.let(f"fcmp ogt double {self.name}, {name_of(other)}")
        return self._let(f"select i1 {is_larger}, double {name_of(yes)}, double {name_of(no)}")


def name_of(value: Double | float) -> str:
    """The name of a double's value, or a constant."""
    return value.name if isinstance(value, Double) else constant(value)
