"""Doubles of a function that is being written: each operator on them is one instruction of it.

Nothing is fused and nothing reordered, so the function gives the bits that Python gives.
"""

from __future__ import annotations

from hybrid_dynamics_core.kernels.ir.text import Function, constant

DECLARATIONS = """declare double @exp(double)
declare double @expm1(double)
declare double @llvm.maxnum.f64(double, double)
declare double @llvm.minnum.f64(double, double)
"""


class Double:
    """A double, by the name of its value in the function."""

    __slots__ = ("function", "name")

    def __init__(self, function: Function, name: str) -> None:
        self.function, self.name = function, name

    def _let(self, instruction: str) -> Double:
        return Double(self.function, self.function.let(instruction))

    def __add__(self, other: Double | float) -> Double:
        return self._let(f"fadd double {self.name}, {_name(other)}")

    def __sub__(self, other: Double | float) -> Double:
        return self._let(f"fsub double {self.name}, {_name(other)}")

    def __mul__(self, other: Double | float) -> Double:
        return self._let(f"fmul double {self.name}, {_name(other)}")

    def __rmul__(self, other: float) -> Double:
        return self._let(f"fmul double {_name(other)}, {self.name}")

    def __truediv__(self, other: Double) -> Double:
        return self._let(f"fdiv double {self.name}, {other.name}")

    def __neg__(self) -> Double:
        return self._let(f"fneg double {self.name}")

    def exp(self) -> Double:
        """The C library's, which Python calls too."""
        return self._let(f"call double @exp(double {self.name})")

    def expm1(self) -> Double:
        """The C library's, which Python calls too."""
        return self._let(f"call double @expm1(double {self.name})")

    def at_least(self, least: float) -> Double:
        """The larger of both."""
        return self._let(
            f"call double @llvm.maxnum.f64(double {self.name}, double {constant(least)})"
        )

    def at_most(self, most: float) -> Double:
        """The smaller of both."""
        return self._let(
            f"call double @llvm.minnum.f64(double {self.name}, double {constant(most)})"
        )

    def exceeds(self, other: Double) -> str:
        """Name of the condition that this is the larger one."""
        return self.function.let(f"fcmp ogt double {self.name}, {other.name}")


def _name(value: Double | float) -> str:
    return value.name if isinstance(value, Double) else constant(value)
