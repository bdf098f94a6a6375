"""The program of this library run on other engines' symbols: they get the same straight line of operations."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from hybrid_dynamics_core import Robot, programs


class Value:
    """A scalar of another engine with the methods that `algebra.scalar` asks for."""

    __slots__ = ("of",)
    engine: Any  # has sin, cos, sqrt, fabs, atan2

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
        return (
            0.0 if isinstance(other, float) and other == 0.0 else type(self)(self.of * plain(other))
        )

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


def plain(x: Any) -> Any:
    """The engine's own scalar."""
    return x.of if isinstance(x, Value) else x


def inverse_dynamics(robot: Robot, engine: Any) -> Callable[..., list[Any]]:
    """(u, du, ddu), sequences of the engine's scalars -> tau; gravity is a constant, and nothing is checked."""
    model = robot._model  # noqa: SLF001  what programs run on
    kind = type("EngineValue", (Value,), {"engine": engine, "__slots__": ()})
    branch, guess = list(model.plan.branch), list(model.plan.reference.q)
    gravity = robot.description.gravity.tolist()

    def tau(u: Sequence[Any], du: Sequence[Any], ddu: Sequence[Any]) -> list[Any]:
        moving = [[kind(x) for x in vector] for vector in (u, du, ddu)]
        x = programs.Inputs(
            u=moving[0], du=moving[1], ddu=moving[2], branch=branch, guess=guess, gravity=gravity
        )
        return [plain(value) for value in programs.INVERSE_DYNAMICS.run(model, x).outputs["tau"]]

    return tau
