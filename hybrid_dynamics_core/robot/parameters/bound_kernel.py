"""A kernel with one of its inputs held: the parameters of robots that share code."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from ...ground.arrays import Array
from ...ground.lazy import lazy
from ...kernels.run import Kernel
from ...kernels.trace import Trace

HELD = 1  # place of the held input


class BoundKernel(Kernel):
    """A kernel whose second input is held; its users do not see that input."""

    def __init__(self, shared: Kernel, vector: Array) -> None:
        """Hold the second input of a kernel.

        Args:
            shared: the kernel.
            vector: values of its second input.
        """
        self.backend = shared.backend
        self._shared = shared
        self._vector = vector
        self._sizes = ()

    @lazy
    def trace(self) -> Trace:
        """The traced program, with the held input."""
        return self._shared.trace

    @lazy
    def one(self) -> Callable[..., int]:
        """The function of one state."""
        return self._holding(self._shared.one)

    @lazy
    def rows(self) -> Callable[..., int]:
        """The function of many states."""
        return self._holding(self._shared.rows)

    @lazy
    def path(self) -> Callable[..., int]:
        """Rows that each start from the previous one."""
        return self._holding(self._shared.path)

    @property
    def can_step(self) -> bool:
        """Whether there is compiled code of steps: its arguments have no place for the input."""
        return False

    @lazy
    def facts(self) -> dict[str, Any]:
        """Facts of the program."""
        return self._shared.facts

    def caller(
        self, held: Sequence[Array | None], fallback: Callable[..., Any]
    ) -> Callable[..., Any]:
        """A function of some inputs of one state, as `Kernel.caller` has it."""
        return self._shared.caller([*held[:HELD], self._vector, *held[HELD:]], fallback)

    def _holding(self, function: Callable[..., int]) -> Callable[..., int]:
        vector = self._vector

        def call(first: Array, *others: Array) -> int:
            return function(first, vector, *others)

        return call
