"""Many states in equal parts on several threads; compiled kernels let them run at the same time."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
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
    """Call a function of rows with (inputs, outs), on parts of them; inputs of `shared` dimensions go to all.

    The first answer that is not 0, or 0.
    """
    n = len(outs[-1])
    if threads == 1 or n <= PART:
        return function(*inputs, *outs)
    size = PART * max(1, -(-n // (threads * SHARES * PART)))

    def part(start: int) -> int:
        rows = slice(start, start + size)
        return function(
            *(a if a.ndim == shared else a[rows] for a in inputs), *(out[rows] for out in outs)
        )

    starts = iter(range(0, n, size))  # one next at a time, as the interpreter has it

    def work() -> int:
        return next((answer for answer in map(part, starts) if answer), 0)

    others = [_pool(os.getpid(), threads - 1).submit(work) for _ in range(threads - 1)]
    answers = [work(), *(other.result() for other in others)]
    return next((answer for answer in answers if answer), 0)
