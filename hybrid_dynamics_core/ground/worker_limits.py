"""Limits and environment of isolated worker processes, as far as the system has them.

Workers load this file by its path, before they read anything. Linux has all limits. macOS refuses
those of memory, and Windows has none: there the parent's limit of time ends a worker.
"""

from __future__ import annotations

import contextlib
import importlib
import os
import signal
import threading
from collections.abc import Mapping
from typing import Any

resource: Any = None
with contextlib.suppress(ImportError):  # Windows has none
    resource = importlib.import_module("resource")

NEEDED = ("SYSTEMROOT",)  # without it Python does not start on Windows
OUT_OF_TIME = -24  # exit code of SIGXCPU
IDLE = 14  # exit code of a worker without requests where there is no SIGALRM


def environment(settings: Mapping[str, str] | None = None) -> dict[str, str]:
    """The environment of a worker: settings, and what the system itself needs."""
    needed = {name: os.environ[name] for name in NEEDED if name in os.environ}
    return {**needed, **(settings or {})}


def limit(name: str, soft: int, hard: int | None = None) -> None:
    """Bound a resource of this process, such as "AS"; without effect where there is no such limit.

    Args:
        name: of the resource, after RLIMIT_.
        soft: bound.
        hard: bound that it can be raised to; `soft` if None.
    """
    number = getattr(resource, f"RLIMIT_{name}", None)
    if number is None:
        return
    with contextlib.suppress(ValueError, OSError):
        resource.setrlimit(number, (soft, soft if hard is None else hard))


def limit_computing(seconds: int) -> None:
    """Bound the time of the processor from now on."""
    if resource is None:
        return
    usage = resource.getrusage(resource.RUSAGE_SELF)
    used = int(usage.ru_utime + usage.ru_stime) + 1
    limit("CPU", used + seconds, resource.RLIM_INFINITY)


def close_off(memory: int) -> None:
    """Bound the memory [bytes], and refuse files from now on."""
    limit("AS", memory)
    for name in ("FSIZE", "NOFILE", "CORE"):
        limit(name, 0)


class IdleAlarm:
    """Ends this process after a time without a request."""

    def __init__(self, seconds: int) -> None:
        self._seconds = seconds
        self._timer: threading.Timer | None = None

    def __enter__(self) -> None:
        if hasattr(signal, "alarm"):
            signal.alarm(self._seconds)
            return
        self._timer = threading.Timer(self._seconds, os._exit, (IDLE,))
        self._timer.daemon = True
        self._timer.start()

    def __exit__(self, *_: object) -> None:
        if self._timer is not None:
            self._timer.cancel()
        elif hasattr(signal, "alarm"):
            signal.alarm(0)
