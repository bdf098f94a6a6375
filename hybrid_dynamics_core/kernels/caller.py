"""Generated Python functions that call one kernel with the least overhead.

Their text has only names of inputs, shapes and numbers. The names come from this package.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..ground.arrays import Array

Code = Callable[..., int]
Load = Callable[[], Code]
# (inputs by name, out, check, threads, start) -> results
Fallback = Callable[[dict[str, Any], Any, bool, int, Any], Any]


@dataclass(frozen=True)
class Signature:
    """Signature of a kernel.

    Attributes:
        inputs: names of all inputs, in order, with `branch` and `guess` among them.
        given: names of the inputs that are parameters of the caller.
        values: default values of the other inputs.
        shapes: shapes of the outputs, in order.
        optional: default values of inputs in `given` that may be left out.
        is_followed: whether the default of `guess` is only the start of a motion. A call without
            `guess` then uses `from_start` of the code, with `reference`.
        reference: the two vectors of that start.
        start_type: type of the argument `start`.
        fixed: names of inputs whose default is part of the code; others go to the fallback.
    """

    inputs: Sequence[str]
    given: Sequence[str]
    values: Mapping[str, Array]
    shapes: Sequence[tuple[int, ...]]
    optional: Mapping[str, Array] = field(default_factory=dict)
    is_followed: bool = False
    reference: tuple[Array, Array] = (np.empty(0), np.empty(0))
    start_type: type = object
    fixed: Sequence[str] = ()


@dataclass(frozen=True)
class Loaders:
    """Functions that load the compiled code for one state at its first use.

    Attributes:
        at_guess: code that takes all inputs of the signature and the outputs; returns a status.
        from_start: the same with two vectors of a start in place of the guess.
        along_motion: the same as `from_start`, with the two vectors of the next start as further
            outputs.
    """

    at_guess: Load
    from_start: Load
    along_motion: Load


def make_caller(signature: Signature, loaders: Loaders, fallback: Fallback) -> Callable[..., Any]:
    """Generate the caller of a kernel.

    Args:
        signature: the signature.
        loaders: load the compiled code for one state.
        fallback: called if the code does not return 0.

    Returns:
        The function. It takes the given inputs and `out`, and as keywords `check`, `threads`,
        `start` and other inputs.

    Raises:
        ValueError: the name of an input is no Python identifier.
    """
    defaults = {**signature.values, **signature.optional}
    scope: dict[str, Any] = {"empty": np.empty, "fallback": fallback}
    scope["start_type"] = signature.start_type
    scope["reference_s"], scope["reference_map"] = signature.reference
    for name, value in defaults.items():
        scope[_default(name)] = value
    for name, load in vars(loaders).items():
        scope[name] = _on_first_call(scope, name, load)
    usual = "from_start" if signature.is_followed else "at_guess"
    scope[usual] = getattr(loaders, usual)()
    exec(compile(_source(signature), "<caller>", "exec"), scope)  # noqa: S102  names and numbers only
    function: Callable[..., Any] = scope["call"]
    return function


def _on_first_call(scope: dict[str, Any], name: str, load: Load) -> Code:
    """Code that takes its place in a scope when it is first called."""

    def first_call(*arguments: Array) -> int:
        code = scope[name] = load()
        return code(*arguments)

    return first_call


def _default(name: str) -> str:
    return f"default_{name}"


def _source(signature: Signature) -> str:
    if not all(name.isidentifier() for name in signature.inputs):
        raise ValueError(f"{list(signature.inputs)} are not all names")
    outs = [f"o{k}" for k in range(len(signature.shapes))]
    by_name = ", ".join(f"{name}={name}" for name in signature.inputs)
    settle = f"return fallback(dict({by_name}), out, check, threads, start)"
    result = ", ".join(outs)
    lines = [
        f"def call({', '.join(_parameters(signature))}):",
        *_other_defaults(signature, settle),
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
        "    if start is not None:",
        *_along_motion(signature, outs, settle),
        f"        return {result}",
        f"    if {_is_unsettled(signature, outs)}:",
        f"        {settle}",
        f"    return {result}",
    ]
    return "\n".join(lines) + "\n"


def _other_defaults(signature: Signature, settle: str) -> list[str]:
    """The way out for inputs that the code does not take."""
    lines: list[str] = []
    for name in signature.fixed:
        lines += [f"    if {name} is not {_default(name)}:", f"        {settle}"]
    return lines


def _is_unsettled(signature: Signature, outs: Sequence[str]) -> str:
    """The call without a start."""
    at_guess = f"at_guess({', '.join([*signature.inputs, *outs])})"
    if not signature.is_followed:
        return at_guess
    inputs = _with_start(signature, {"guess": "reference_s, reference_map"})
    from_start = f"from_start({', '.join([*inputs, *outs])})"
    return f"({from_start} if guess is {_default('guess')} else {at_guess})"


def _along_motion(signature: Signature, outs: Sequence[str], settle: str) -> list[str]:
    """The call with a start, which is replaced."""
    start = {"branch": "start.signs", "guess": "start.s, start.start_map"}
    inputs = _with_start(signature, start)
    sizes = [len(vector) for vector in signature.reference]
    call = f"along_motion({', '.join([*inputs, *outs, 's', 'start_map'])})"
    is_wrong = (
        f"type(start) is not start_type or guess is not {_default('guess')}"
        f" or branch is not {_default('branch')}"
    )
    return [
        f"        if {is_wrong}:",
        f"            {settle}",
        f"        s, start_map = empty({sizes[0]}), empty({sizes[1]})",
        f"        if {call}:",
        f"            {settle}",
        "        start.s, start.start_map = s, start_map",
    ]


def _with_start(signature: Signature, replaced: Mapping[str, str]) -> list[str]:
    return [replaced.get(name, name) for name in signature.inputs]


def _parameters(signature: Signature) -> list[str]:
    given = []
    for name in signature.given:
        default = f"={_default(name)}" if name in signature.optional else ""
        given.append(name + default)
    others = [f"{name}={_default(name)}" for name in signature.values]
    return [*given, "out=None", "*", "check=True", "threads=1", "start=None", *others]


def _allocations(signature: Signature, outs: Sequence[str]) -> list[str]:
    lines = []
    for name, shape in zip(outs, signature.shapes, strict=True):
        size = shape[0] if len(shape) == 1 else shape
        lines.append(f"        {name} = empty({size})")
    return lines
