"""A Python function written for one kernel, so that nothing stands between a caller and the compiled code.

Its text holds names of a program's inputs, shapes and numbers; names of inputs come from this
package alone.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..ground.arrays import Array

Again = Callable[
    [dict[str, Any], Any, bool, int], Any
]  # (inputs by name, out, check, threads) -> results


@dataclass(frozen=True)
class Signature:
    """How a kernel is called: its inputs in order, those that the caller gives, values of the others, the outputs.

    `optional`: inputs that the caller may leave out although he gives them, with the value they
    then have; `follows`: an input whose own value is only a start, so that a call without another
    one is not for the compiled code alone.
    """

    inputs: Sequence[str]
    given: Sequence[str]
    values: Mapping[str, Array]
    shapes: Sequence[tuple[int, ...]]
    optional: Mapping[str, Array] = field(default_factory=dict)
    follows: str | None = None


def make_caller(signature: Signature, one: Callable[..., int], again: Again) -> Callable[..., Any]:
    """The function: given inputs, `out`, and the rest as keywords; what `one` does not settle goes to `again`."""
    defaults = {**signature.values, **signature.optional}
    scope: dict[str, Any] = {"empty": np.empty, "one": one, "again": again}
    scope.update({f"own_{name}": value for name, value in defaults.items()})
    exec(compile(_source(signature), "<caller>", "exec"), scope)  # noqa: S102  names of this package and numbers only
    function: Callable[..., Any] = scope["call"]
    return function


def _source(signature: Signature) -> str:
    if not all(name.isidentifier() for name in signature.inputs):
        raise ValueError(f"{list(signature.inputs)} are not all names")
    given = [f"{n}=own_{n}" if n in signature.optional else n for n in signature.given]
    others = [f"{n}=own_{n}" for n in signature.values]
    outs = [f"o{k}" for k in range(len(signature.shapes))]
    result = ", ".join(outs)
    rest = f"again(dict({', '.join(f'{n}={n}' for n in signature.inputs)}), out, check, threads)"
    unsettled = f"one({', '.join([*signature.inputs, *outs])})"
    if signature.follows is not None:
        unsettled = f"{signature.follows} is own_{signature.follows} or {unsettled}"
    shapes = [shape[0] if len(shape) == 1 else shape for shape in signature.shapes]
    lines = [
        f"def call({', '.join([*given, 'out=None', '*', 'check=True', 'threads=1', *others])}):",
        "    if out is None:",
        *(f"        {name} = empty({shape})" for name, shape in zip(outs, shapes, strict=True)),
        *(
            []
            if len(outs) == 1
            else ["    elif type(out) is not tuple or len(out) != " + f"{len(outs)}:"]
        ),
        *([] if len(outs) == 1 else [f"        return {rest}"]),
        "    else:",
        f"        {result} = out",
        f"    if {unsettled}:",
        f"        return {rest}",
        f"    return {result}",
    ]
    return "\n".join(lines) + "\n"
