"""Times of several sides in interleaved rounds: a machine that slows down slows all of them."""

from __future__ import annotations

import gc
import statistics
import time
import timeit
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

Clock = Callable[[], float]


@dataclass(frozen=True)
class Timing:
    """Seconds a call: the median and the smallest over the rounds."""

    median: float
    least: float


class _Repeated:
    """A call written out in a loop, as often as fills a share of a second."""

    def __init__(
        self, function: Callable[..., Any], arguments: Sequence[Any], seconds: float, clock: Clock
    ) -> None:
        names = {f"a{k}": argument for k, argument in enumerate(arguments)}
        statement = f"f({', '.join(names)})"
        self._timer = timeit.Timer(statement, timer=clock, globals={"f": function, **names})
        self._timer.timeit(1)
        self._count = 1
        while True:
            spent = self._timer.timeit(self._count)
            if spent >= seconds / 3.0:
                break
            half = int(self._count * seconds / max(spent, 1e-9) / 2.0)
            self._count = max(2 * self._count, half)

    def once(self) -> float:
        return self._timer.timeit(self._count) / self._count


def measure(
    calls: Mapping[str, tuple[Callable[..., Any], Sequence[Any]]],
    rounds: int = 9,
    seconds: float = 0.02,
    clock: Clock = time.process_time,
) -> dict[str, Timing]:
    """Time functions in interleaved rounds.

    Args:
        calls: function and arguments, by name.
        rounds: how often each is timed.
        seconds: about how long a round of one function takes.
        clock: by default CPU time of this process.

    Returns:
        Seconds a call, by name.
    """
    repeated = {}
    for name, (function, arguments) in calls.items():
        repeated[name] = _Repeated(function, arguments, seconds, clock)
    times: dict[str, list[float]] = {name: [] for name in calls}
    gc.collect()
    for _ in range(rounds):
        for name, call in repeated.items():
            times[name].append(call.once())
    return {name: Timing(statistics.median(values), min(values)) for name, values in times.items()}
