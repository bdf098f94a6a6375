"""A Python function written for one kernel: nothing stands between a caller and compiled code.

Its text holds names of inputs, shapes and numbers alone. The names come from this package.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..ground.arrays import Array

# (inputs by name, out, check, threads) -> results
Fallback = Callable[[dict[str, Any], Any, bool, int], Any]


@dataclass(frozen=True)
class Signature:
    """How a kernel is called.

    Attributes:
        inputs: names of all inputs, in order.
        given: names of those that the caller gives.
        values: values of the others.
        shapes: shapes of the outputs, in order.
        optional: inputs of `given` that may be left out, with the value that they then have.
        follows: an input whose own value is only a start: a call without another value is not for
            the compiled code alone.
    """

    inputs: Sequence[str]
    given: Sequence[str]
    values: Mapping[str, Array]
    shapes: Sequence[tuple[int, ...]]
    optional: Mapping[str, Array] = field(default_factory=dict)
    follows: str | None = None


def make_caller(
    signature: Signature, one: Callable[..., int], fallback: Fallback
) -> Callable[..., Any]:
    """Write the function of a kernel.

    Args:
        signature: how the function is called.
        one: the compiled code for one state.
        fallback: takes what `one` does not settle.

    Returns:
        The function: given inputs and `out`, then `check`, `threads` and other inputs as keywords.

    Raises:
        ValueError: an input has a name that Python does not take.
    """
    defaults = {**signature.values, **signature.optional}
    scope: dict[str, Any] = {"empty": np.empty, "one": one, "fallback": fallback}
    for name, value in defaults.items():
        scope[_default(name)] = value
    exec(compile(_source(signature), "<caller>", "exec"), scope)  # noqa: S102  names and numbers only
    function: Callable[..., Any] = scope["call"]
    return function


def _default(name: str) -> str:
    return f"default_{name}"


def _source(signature: Signature) -> str:
    if not all(name.isidentifier() for name in signature.inputs):
        raise ValueError(f"{list(signature.inputs)} are not all names")
    outs = [f"o{k}" for k in range(len(signature.shapes))]
    by_name = ", ".join(f"{name}={name}" for name in signature.inputs)
    settle = f"return fallback(dict({by_name}), out, check, threads)"
    is_unsettled = f"one({', '.join([*signature.inputs, *outs])})"
    if signature.follows is not None:
        start = _default(signature.follows)
        is_unsettled = f"{signature.follows} is {start} or {is_unsettled}"
    result = ", ".join(outs)
    lines = [
        f"def call({', '.join(_parameters(signature))}):",
        "    if out is None:",
        *_allocations(signature, outs),
    ]
    if len(outs) > 1:
        lines += [
            f"    elif type(out) is not tuple or len(out) != {len(outs)}:",
            f"        {settle}",
        ]
    lines += [
        "    else:",
        f"        {result} = out",
        f"    if {is_unsettled}:",
        f"        {settle}",
        f"    return {result}",
    ]
    return "\n".join(lines) + "\n"


def _parameters(signature: Signature) -> list[str]:
    given = []
    for name in signature.given:
        default = f"={_default(name)}" if name in signature.optional else ""
        given.append(name + default)
    others = [f"{name}={_default(name)}" for name in signature.values]
    return [*given, "out=None", "*", "check=True", "threads=1", *others]


def _allocations(signature: Signature, outs: Sequence[str]) -> list[str]:
    lines = []
    for name, shape in zip(outs, signature.shapes, strict=True):
        size = shape[0] if len(shape) == 1 else shape
        lines.append(f"        {name} = empty({size})")
    return lines
