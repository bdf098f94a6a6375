"""Kernels: programs of one robot as functions on arrays, in machine code or Python.

A kernel is traced, compiled and loaded at its first call. Code is cached on disk (`artifact`).
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from contextvars import ContextVar
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..ground.arrays import Array
from ..ground.lazy import lazy
from . import artifact, extension, generated, native
from .backend import Artifact, Backend
from .compile_notice import NOTICE
from .ir.module import Form
from .llvm import LoadedCode
from .rewrite import rewritten
from .status import NOT_TAKEN
from .threads import in_parts
from .trace import Trace, Traceable, trace

Codes = NDArray[np.int64]
_FORMS: tuple[Form, ...] = ("one", "rows", "path", "xla_one", "xla_rows", "xla_32", "steps")
VARIABLE = "HYBRID_DYNAMICS_KERNELS"  # "python": never compile
_MAY_MAKE: ContextVar[bool] = ContextVar("kernels may be made", default=True)


class NotStoredError(Exception):
    """Code is not in the cache, where only cached code is allowed."""


@contextmanager
def stored_only() -> Iterator[None]:
    """Allow only cached code, in this thread.

    Raises:
        NotStoredError: a kernel is called whose code is not in the cache.
    """
    token = _MAY_MAKE.set(False)
    try:
        yield
    finally:
        _MAY_MAKE.reset(token)


class Kernel:
    """A program with input vectors of given sizes.

    Attributes:
        backend: `native` or `python`.
    """

    def __init__(
        self,
        program: Traceable,
        sizes: Sequence[int],
        backend: str | None = None,
        label: str = "a program",
    ) -> None:
        """Store the arguments; nothing is traced yet.

        Args:
            program: function from scalars to named outputs and checks.
            sizes: lengths of the input vectors.
            backend: `native` or `python`; None for the default of this machine.
            label: its name in messages while it is compiled.
        """
        self._program, self._label = program, label
        self._sizes = tuple(sizes)
        self.backend = backend or default_backend()

    @lazy
    def trace(self) -> Trace:
        """The traced program."""
        return rewritten(trace(self._program, self._sizes))

    @lazy
    def one(self) -> Callable[..., int]:
        """The function of one state: inputs (size,), then outputs to fill; returns a status."""
        return self._load("one")

    def caller(
        self, held: Sequence[Array | None], fallback: Callable[..., Any]
    ) -> Callable[..., Any]:
        """A function of some inputs of one state, in compiled code where it can be.

        Args:
            held: vectors of all inputs, None for those that the caller gives.
            fallback: takes all calls that the code does not, or all without compiled code.
        """
        if self.backend != native.NAME:
            return fallback
        return extension.held_caller(self.one, held, fallback)

    @lazy
    def rows(self) -> Callable[..., int]:
        """The function of many states.

        It takes inputs (size,) or (N, size), and fills outputs (N, *shape) and the int64 status
        (N,). It returns 0 or `NOT_TAKEN`.
        """
        return self._load("rows")

    @lazy
    def path(self) -> Callable[..., int]:
        """Rows that each start from the previous one, as `fill_path` has it."""
        if self.backend == native.NAME:
            return self._load("path")
        return partial(generated.path, self.one, len(self.layout))

    @property
    def can_step(self) -> bool:
        """Whether there is compiled code of steps, see `ir.steps`."""
        return self.backend == native.NAME

    @lazy
    def steps(self) -> Callable[..., int]:
        """Steps of an integrator, as `ir.steps` has it; of machine code only."""
        return self._load("steps")

    def handler(self, form: Form) -> LoadedCode:
        """The code of a form for XLA, see `ir.xla_entry`; of machine code only."""
        return native.code(self._made(form))

    @lazy
    def facts(self) -> dict[str, Any]:
        """Facts of the program, see `artifact.facts_of`."""
        for form in _FORMS:
            stored = self._stored(form)
            if stored is not None:
                return stored.facts
        self._require_making()
        with self._waiting():
            return artifact.facts_of(self.trace)

    @lazy
    def layout(self) -> tuple[tuple[str, tuple[int, ...]], ...]:
        """Names and shapes of the outputs."""
        return tuple((name, tuple(shape)) for name, shape in self.facts["layout"])

    @lazy
    def names(self) -> tuple[str, ...]:
        """Names of the outputs, in order."""
        return tuple(name for name, _ in self.layout)

    @lazy
    def _shapes(self) -> tuple[tuple[int, ...], ...]:
        return tuple(shape for _, shape in self.layout)

    def __call__(self, *arguments: Array) -> tuple[dict[str, Array], Codes]:
        """Run the program.

        Args:
            *arguments: input vectors (size,) or (N, size), also mixed.

        Returns:
            Results by name (..., *shape), and the status (...,).
        """
        counts = [len(a) for a in arguments if a.ndim == 2]
        if counts:
            results = {name: np.empty((counts[0], *shape)) for name, shape in self.layout}
            codes = np.empty(counts[0], dtype=np.int64)
            self.fill_rows(arguments, [*results.values()], codes)
            return results, codes
        outs = self.new_outs()
        code = self.fill_one(arguments, outs)
        return dict(zip(self.names, outs, strict=True)), np.array(code)

    def new_outs(self) -> list[Array]:
        """New arrays for the outputs of one state."""
        return [np.empty(shape) for shape in self._shapes]

    def fill_one(self, arguments: Sequence[Array], outs: Sequence[Array]) -> int:
        """Fill the outputs of one state from any arrays of the right sizes; returns the status."""
        status = self.one(*arguments, *outs)
        if status != NOT_TAKEN:
            return status
        # arrays from another process have an equal dtype, but not the same dtype object
        status = self.one(*[a.astype(np.float64) for a in arguments], *outs)
        if status != NOT_TAKEN:
            return status
        codes = np.empty(1, dtype=np.int64)
        self.fill_rows(arguments, [out[None] for out in outs], codes)
        return int(codes[0])

    def fill_rows(
        self, arguments: Sequence[Array], outs: Sequence[Array], codes: Codes, threads: int = 1
    ) -> None:
        """Fill the outputs of many states from any arrays of the right sizes.

        Args:
            arguments: input vectors (size,) or (N, size).
            outs: (N, *shape) each, filled.
            codes: status (N,), filled.
            threads: number of threads.

        Raises:
            ValueError: a shape is wrong.
        """
        if in_parts(self.rows, arguments, [*outs, codes], threads) == NOT_TAKEN:
            plain = [np.require(a, np.float64, ["C", "A"]).view(np.ndarray) for a in arguments]
            if in_parts(self.rows, plain, [*outs, codes], threads) == NOT_TAKEN:
                shapes = [a.shape for a in (*arguments, *outs)]
                raise ValueError(
                    f"a kernel of {self._sizes} -> {self.layout} was given arrays of shapes"
                    f" {shapes}"
                )

    def fill_path(self, arguments: Sequence[Array], outs: Sequence[Array], codes: Codes) -> None:
        """Fill the outputs of states that each start from the previous one.

        Args:
            arguments: the first input has rows (N, size), all others are (size,). The last ones
                are for the first row: later rows get them from the outputs of the previous row.
            outs: (N, *shape) each, filled up to the first row without an answer.
            codes: status (N,), filled up to the same row.

        Raises:
            ValueError: the shapes are not those of the program.
        """
        plain = [np.require(a, np.float64, ["C", "A"]).view(np.ndarray) for a in arguments]
        if self.path(*plain, *outs, codes) == NOT_TAKEN:
            shapes = [a.shape for a in (*arguments, *outs)]
            raise ValueError(
                f"a kernel of {self._sizes} -> {self.layout} was given arrays of shapes {shapes}"
            )

    # -- making

    def _load(self, form: Form) -> Callable[..., int]:
        return self._maker.load(self._made(form))

    def _made(self, form: Form) -> Artifact:
        made = self._stored(form)
        if made is None:
            self._require_making()
            with self._waiting():
                made = artifact.make(self.trace, form, self._maker, self._key(form))
        return made

    @property
    def _maker(self) -> Backend:
        return native if self.backend == native.NAME else generated

    def _require_making(self) -> None:
        if not _MAY_MAKE.get():
            raise NotStoredError(self._label)

    def _waiting(self) -> AbstractContextManager[None]:
        where = "not kept: no cache" if self._identity is None else "once; kept in the cache"
        return NOTICE.during(f"{self._label} ({where})")

    def _stored(self, form: Form) -> Artifact | None:
        key = self._key(form)
        return None if key is None else artifact.find(key)

    def _key(self, form: Form) -> str | None:
        return None if self._identity is None else artifact.first_key(self._identity, form)

    @lazy
    def _identity(self) -> str | None:
        return artifact.identity_of((self._program, self._sizes), self._maker)


def is_native() -> bool:
    """Whether kernels are machine code by default."""
    return default_backend() == native.NAME


def default_backend() -> str:
    """`native` if machine code is available and not switched off, otherwise `python`."""
    setting = os.environ.get(VARIABLE, "").strip().lower()
    if setting == generated.NAME or native.reason_against():
        return generated.NAME
    return native.NAME
