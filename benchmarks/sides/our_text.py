"""The program of this library run on other engines' symbols.

They get the same straight line of operations.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from hybrid_dynamics_core import Robot, programs


class Value:
    """A scalar of another engine with the methods that `algebra.scalar` asks for."""

    __slots__ = ("of",)
    engine: Any  # has sin, cos, sqrt, fabs, floor, atan2

    def __init__(self, of: Any) -> None:
        self.of = of

    def __add__(self, other: Any) -> Value:
        return type(self)(self.of + plain(other))

    def __radd__(self, other: Any) -> Value:
        return type(self)(plain(other) + self.of)

    def __sub__(self, other: Any) -> Value:
        return type(self)(self.of - plain(other))

    def __rsub__(self, other: Any) -> Value:
        return type(self)(plain(other) - self.of)

    def __mul__(self, other: Any) -> Any:
        if isinstance(other, float) and other == 0.0:
            return 0.0
        return type(self)(self.of * plain(other))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Value:
        return type(self)(self.of / plain(other))

    def __rtruediv__(self, other: Any) -> Value:
        return type(self)(plain(other) / self.of)

    def __neg__(self) -> Value:
        return type(self)(-self.of)

    def sin(self) -> Value:
        """Sine."""
        return type(self)(self.engine.sin(self.of))

    def cos(self) -> Value:
        """Cosine."""
        return type(self)(self.engine.cos(self.of))

    def sqrt(self) -> Value:
        """Square root."""
        return type(self)(self.engine.sqrt(self.of))

    def atan2(self, x: Any) -> Value:
        """Angle of (x, self)."""
        return type(self)(self.engine.atan2(self.of, plain(x)))

    def absolute(self) -> Value:
        """Absolute value."""
        return type(self)(self.engine.fabs(self.of))

    def rint(self) -> Value:
        """The nearest integer."""
        return type(self)(self.engine.floor(self.of + 0.5))


def plain(x: Any) -> Any:
    """The engine's own scalar."""
    if isinstance(x, Value):
        return x.of
    return x


def inverse_dynamics(robot: Robot, engine: Any) -> Callable[..., list[Any]]:
    """The function (u, du, ddu) -> tau, of sequences of the engine's scalars.

    Gravity is a constant, and nothing is checked.
    """
    model = robot._model.program_model  # noqa: SLF001  what programs run on
    kind = type("EngineValue", (Value,), {"engine": engine, "__slots__": ()})
    branch = list(model.plan.branch)
    guess = list(model.plan.reference.q)
    gravity = robot.description.gravity.tolist()

    def tau(u: Sequence[Any], du: Sequence[Any], ddu: Sequence[Any]) -> list[Any]:
        inputs = programs.Inputs(
            u=list(map(kind, u)),
            du=list(map(kind, du)),
            ddu=list(map(kind, ddu)),
            branch=branch,
            guess=guess,
            gravity=gravity,
        )
        outputs = programs.inverse_dynamics().run(model, inputs).outputs
        return list(map(plain, outputs["tau"]))

    return tau
