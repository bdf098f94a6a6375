"""A program of one robot as functions on arrays: compiled where that is possible, generated Python elsewhere.

Traced, compiled and loaded when first called; what was made is kept on disk (`cache`).
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..ground.arrays import Array
from ..ground.lazy import lazy
from . import cache, generated, native
from .cache import Artifact
from .compile_notice import WAITING
from .digest import NoDigestError, code_digest, digest
from .ir.module import Form
from .status import NOT_TAKEN
from .threads import in_parts
from .trace import Trace, Traceable, trace

Codes = NDArray[np.int64]
_FORMS: tuple[Form, ...] = ("one", "rows")
VARIABLE = "HYBRID_DYNAMICS_KERNELS"  # "python": never compile


class Kernel:
    """A program whose arguments are vectors of the given sizes; it works as `backend` says.

    `label`: what people are told while they wait for it to be compiled.
    """

    def __init__(
        self,
        program: Traceable,
        sizes: Sequence[int],
        backend: str | None = None,
        label: str = "a program",
    ) -> None:
        self._program, self._label = program, label
        self._sizes = tuple(sizes)
        self.backend = backend or default_backend()

    @lazy
    def trace(self) -> Trace:
        """The traced program."""
        return trace(self._program, self._sizes)

    @lazy
    def one(self) -> Callable[..., int]:
        """One state: inputs (size,), then named outputs, which are filled; a status code."""
        return self._made("one")

    @lazy
    def rows(self) -> Callable[..., int]:
        """Many states: inputs (size,) or (N, size), outputs (N, *shape) and status (N,) int64, which are filled."""
        return self._made("rows")

    @lazy
    def facts(self) -> dict[str, Any]:
        """What is to be known of the program without running it: see `facts_of`."""
        for form in _FORMS:
            artifact = self._stored(form)
            if artifact is not None:
                return artifact.facts
        with self._waiting():
            return facts_of(self.trace)

    @lazy
    def layout(self) -> tuple[tuple[str, tuple[int, ...]], ...]:
        """Names and shapes of the outputs."""
        return tuple((name, tuple(shape)) for name, shape in self.facts["layout"])

    def __call__(self, *arguments: Array) -> tuple[dict[str, Array], Codes]:
        """Results by name and status; arguments (size,) or (N, size), mixed as they come; results (..., *shape)."""
        many = [len(a) for a in arguments if a.ndim == 2]
        if many:
            results = {name: np.empty((many[0], *shape)) for name, shape in self.layout}
            codes = np.empty(many[0], dtype=np.int64)
            self.fill_rows(arguments, [*results.values()], codes)
            return results, codes
        results = {name: np.empty(shape) for name, shape in self.layout}
        return results, np.array(self.fill_one(arguments, [*results.values()]))

    def fill_one(self, arguments: Sequence[Array], outs: Sequence[Array]) -> int:
        """Fill the outputs of one state from any arrays of the right sizes; the status."""
        status = self.one(*arguments, *outs)
        if status != NOT_TAKEN:
            return status
        codes = np.empty(1, dtype=np.int64)
        self.fill_rows(arguments, [out[None] for out in outs], codes)
        return int(codes[0])

    def fill_rows(
        self, arguments: Sequence[Array], outs: Sequence[Array], codes: Codes, threads: int = 1
    ) -> None:
        """Fill the outputs (N, *shape) and status (N,) of many states from any arrays of the right sizes."""
        if in_parts(self.rows, arguments, [*outs, codes], threads) == NOT_TAKEN:
            plain = [np.require(a, np.float64, ["C", "A"]).view(np.ndarray) for a in arguments]
            if in_parts(self.rows, plain, [*outs, codes], threads) == NOT_TAKEN:
                shapes = [a.shape for a in (*arguments, *outs)]
                raise ValueError(
                    f"a kernel of {self._sizes} -> {self.layout} was given arrays of shapes"
                    f" {shapes}"
                )

    # -- making

    def _made(self, form: Form) -> Callable[..., int]:
        artifact = self._stored(form)
        if artifact is None:
            make = native.make if self.backend == native.NAME else generated.make
            with self._waiting():
                artifact = Artifact(facts_of(self.trace), make(self.trace, form))
            if self._identity is not None:
                cache.write(self._key(form), artifact)
        return (
            native.load(artifact) if self.backend == native.NAME else generated.load(artifact, form)
        )

    def _waiting(self) -> AbstractContextManager[None]:
        kept = "once; kept in the cache" if self._identity is not None else "not kept: no cache"
        return WAITING.during(f"{self._label} ({kept})")

    def _stored(self, form: Form) -> Artifact | None:
        return None if self._identity is None else cache.read(self._key(form))

    def _key(self, form: Form) -> str:
        return hashlib.sha256(f"{self._identity} {form}".encode()).hexdigest()

    @lazy
    def _identity(self) -> str | None:
        """Digest of everything that the code depends on; None where that cannot be told."""
        if cache.folder() is None:
            return None
        try:
            program = digest((self._program, self._sizes))
        except NoDigestError:
            return None
        environment = native.identity() if self.backend == native.NAME else generated.identity()
        return hashlib.sha256(
            json.dumps([program, code_digest(), environment]).encode()
        ).hexdigest()


def facts_of(traced: Trace) -> dict[str, Any]:
    """Sizes of the inputs, names and shapes of the outputs, which inputs are read, whether anything is iterated."""
    return {
        "inputs": list(traced.inputs),
        "layout": [[name, list(shape)] for name, shape in traced.layout],
        "read": sorted({v for v, _ in traced.used_inputs()}),
        "iterates": any(
            traced.graph.blocks[number].body is not None for number in traced.live_blocks()
        ),
    }


def default_backend() -> str:
    """`native` where machine code can be made and is not switched off, otherwise `python`."""
    told = os.environ.get(VARIABLE, "").strip().lower()
    return generated.NAME if told == generated.NAME or native.reason_against() else native.NAME
