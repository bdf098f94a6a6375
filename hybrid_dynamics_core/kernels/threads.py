"""Many states in parts on several threads; compiled kernels let them run at the same time."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any

# parts for each thread, taken as it gets free: a core that is held up does not hold up the others
SHARES = 8
PART = 64  # a part is a multiple of this: what compiled kernels work on at a time


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
        function: takes inputs and outs; 0 where all is well.
        inputs: arrays of rows; those of `shared` dimensions go to all parts.
        outs: arrays of rows, filled.
        threads: how many threads work at a time.
        shared: dimensions of an input that all rows share.

    Returns:
        The first answer that is not 0, or 0.
    """
    n = len(outs[-1])
    if threads == 1 or n <= PART:
        return function(*inputs, *outs)
    size = PART * max(1, -(-n // (threads * SHARES * PART)))

    def part(start: int) -> int:
        rows = slice(start, start + size)
        parts = [_rows_of(array, rows, shared) for array in inputs]
        return function(*parts, *(out[rows] for out in outs))

    starts = iter(range(0, n, size))  # one next at a time, as the interpreter has it

    def work() -> int:
        return _first_failure(map(part, starts))

    others = [_pool(os.getpid(), threads - 1).submit(work) for _ in range(threads - 1)]
    answers = [work(), *(other.result() for other in others)]
    return _first_failure(answers)


def _rows_of(array: Any, rows: slice, shared: int) -> Any:
    return array if array.ndim == shared else array[rows]


def _first_failure(answers: Iterable[int]) -> int:
    return next(filter(None, answers), 0)
