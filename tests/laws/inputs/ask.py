"""Whether optional inputs of a call are heard: without one of them it answers otherwise.

A law asks through `Ask`. It cannot name an input without giving it, and not give one to no effect.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Any, NamedTuple

import numpy as np

from hybrid_dynamics_core.errors import HybridDynamicsError

SAME = 1e-10  # relative: rounding is no answer to an input
ROUNDING = 1e-9  # of numbers of their size, through solves of loops


class Ask:
    """Calls, and what they heard.

    Attributes:
        heard: inputs that changed an answer, as "call.input".
    """

    def __init__(self) -> None:
        self.heard: set[str] = set()

    def __call__(
        self,
        owner: object,
        name: str,
        *arguments: Any,
        of: Callable[[Any], Any] = lambda answer: answer,
        **optional: Any,
    ) -> Any:
        """The answer of a call with optional inputs; it is another one without any of them.

        Args:
            owner: what has the call.
            name: of the call.
            *arguments: that it always takes.
            of: the part of the answer that is compared.
            **optional: inputs that it may take.
        """
        call = getattr(owner, name)
        for one, parameter in inspect.signature(call).parameters.items():
            if parameter.kind is parameter.POSITIONAL_ONLY and one in optional:
                call = by_name(call, one)
        answer = call(*arguments, **optional)
        told = flat(of(answer))
        for one in optional:
            others = {key: value for key, value in optional.items() if key != one}
            try:
                without = flat(of(call(*arguments, **others)))
            except HybridDynamicsError:
                without = None
            assert without is None or not are_same(told, without), f"{name} is deaf to {one}"
            self.heard.add(f"{name}.{one}")
        return answer


class Law(NamedTuple):
    """A law of some optional inputs.

    Attributes:
        inputs: each "call.input".
        check: the law.
    """

    inputs: frozenset[str]
    check: Callable[[Ask], None]


LAWS: list[Law] = []


def law(*inputs: str) -> Callable[[Callable[[Ask], None]], Callable[[Ask], None]]:
    """Name the inputs of a law, each "call.input"."""

    def listed(check: Callable[[Ask], None]) -> Callable[[Ask], None]:
        LAWS.append(Law(frozenset(inputs), check))
        return check

    return listed


def optional_inputs(owner: type) -> set[str]:
    """All optional inputs of the public calls of a class, as "call.input"."""
    result: set[str] = set()
    for name, call in inspect.getmembers(owner, callable):
        if name.startswith("_"):
            continue
        for parameter in inspect.signature(call).parameters.values():
            if parameter.default is not parameter.empty:
                result.add(f"{name}.{parameter.name}")
    return result


def by_name(call: Callable[..., Any], name: str) -> Callable[..., Any]:
    """A call whose first argument has a name."""

    def named(*arguments: Any, **others: Any) -> Any:
        first = (others.pop(name),) if name in others else ()
        return call(*first, *arguments, **others)

    return named


def flat(value: Any) -> np.ndarray:
    """All numbers of an answer in a row."""
    return np.concatenate([np.zeros(0), *numbers(value)])


def numbers(value: Any) -> Iterator[np.ndarray]:
    """The numbers of an answer, part by part."""
    if value is None:
        return
    if isinstance(value, Enum):
        value = value.value
    if isinstance(value, str):
        yield np.frombuffer(value.encode(), dtype=np.uint8).astype(float)
    elif isinstance(value, (bool, int, float, np.ndarray, np.generic)):
        yield np.ravel(np.asarray(value, dtype=float))
    elif is_dataclass(value):
        for field in fields(value):
            yield from numbers(getattr(value, field.name))
    else:
        parts = value.values() if isinstance(value, Mapping) else value
        for part in parts:
            yield from numbers(part)


def are_same(first: np.ndarray, second: np.ndarray) -> bool:
    """Whether two answers differ by rounding alone."""
    if first.shape != second.shape:
        return False
    size = np.abs(first[np.isfinite(first)]).max(initial=0.0)
    return np.allclose(first, second, rtol=SAME, atol=SAME * size, equal_nan=True)


def near(first: Any, second: Any, rounding: float = ROUNDING) -> bool:
    """Whether two ways give the same, relative to the largest number."""
    one, two = flat(first), flat(second)
    size = 1.0 + np.abs(two[np.isfinite(two)]).max(initial=0.0)
    return np.allclose(one, two, rtol=0.0, atol=rounding * size, equal_nan=True)
