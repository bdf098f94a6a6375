"""Computation of many states on several threads; compiled kernels release the GIL."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any

# parts per thread, taken as threads become free, so that a slow core does not delay the others
SHARES = 8
PART = 64  # sizes of parts are multiples of this, which is a multiple of all vector widths


@cache
def _pool(process: int, threads: int) -> ThreadPoolExecutor:  # noqa: ARG001  a forked process needs its own
    return ThreadPoolExecutor(threads, thread_name_prefix="hybrid_dynamics")


def in_parts(
    function: Callable[..., int],
    inputs: Sequence[Any],
    outs: Sequence[Any],
    threads: int,
    shared: int = 1,
) -> int:
    """Call a function of rows on parts of them.

    Args:
        function: called with inputs and outs; it returns 0 on success.
        inputs: arrays of rows; those with `shared` dimensions are passed to all parts.
        outs: arrays of rows, filled.
        threads: number of threads.
        shared: number of dimensions of an input that all rows share.

    Returns:
        The first result that is not 0, or 0.
    """
    n = len(outs[-1])
    if threads == 1 or n <= PART:
        return function(*inputs, *outs)
    size = PART * max(1, -(-n // (threads * SHARES * PART)))

    def part(start: int) -> int:
        rows = slice(start, start + size)
        parts = [_rows_of(array, rows, shared) for array in inputs]
        return function(*parts, *(out[rows] for out in outs))

    starts = iter(range(0, n, size))  # `next` is atomic in the interpreter

    def work() -> int:
        return _first_failure(map(part, starts))

    others = [_pool(os.getpid(), threads - 1).submit(work) for _ in range(threads - 1)]
    answers = [work(), *(other.result() for other in others)]
    return _first_failure(answers)


def _rows_of(array: Any, rows: slice, shared: int) -> Any:
    return array if array.ndim == shared else array[rows]


def _first_failure(answers: Iterable[int]) -> int:
    return next(filter(None, answers), 0)
