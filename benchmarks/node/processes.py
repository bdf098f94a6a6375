"""Processes: the actors, the node, and what the system says about them."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType
from typing import Any

NOTHING: Mapping[str, str] = MappingProxyType({})
START_TIME = 6.0  # [s] until a node is up, workers too


def start(
    part: str, settings: dict[str, Any], environment: Mapping[str, str] = NOTHING
) -> subprocess.Popen[str]:
    """Start an actor.

    Args:
        part: its name.
        settings: what it is called with.
        environment: variables beside those of this process.
    """
    words = ["-m", "benchmarks.node", "--part", part, "--settings", json.dumps(settings)]
    return subprocess.Popen(
        [sys.executable, *words],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, **environment},
    )


@contextmanager
def subject(
    what: str, robot: str, environment: Mapping[str, str] = NOTHING
) -> Iterator[subprocess.Popen[str]]:
    """The process that is measured, from when it is up.

    Args:
        what: `node` or `echo`.
        robot: of the node.
        environment: of the echo, variables beside those of this process.
    """
    if what == "echo":
        process = start("echo", {}, environment)
    else:
        words = ["--ros-args", "-p", f"robot:={robot}", "--log-level", "error"]
        command = [sys.executable, "-m", "hybrid_dynamics_ros.node", *words]
        process = subprocess.Popen(command, text=True)
    try:
        time.sleep(START_TIME)
        yield process
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(20.0)


@contextmanager
def caller() -> Iterator[None]:
    """Calls of a service all the while; their count is printed."""
    process = start("call", {})
    try:
        yield
    finally:
        process.send_signal(signal.SIGINT)
        words = process.communicate()[0].split() or ["none"]
        print(f"  calls answered meanwhile: {words[-1]}")


def memory(pid: int) -> float:
    """Resident memory of a process [MB]."""
    pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def cpu_time(pid: int) -> float:
    """Processor time of a process so far [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    ticks = int(fields[11]) + int(fields[12])
    return ticks / os.sysconf("SC_CLK_TCK")
