"""What is measured: node beside echo, a flood, a long time."""

from __future__ import annotations

import argparse
import json
import os
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass

import numpy as np

from .processes import NOTHING, caller, cpu_time, memory, start, subject
from .topics import ANSWERS

WARM_UP = 1.0  # [s] that is not counted
WATCH_INTERVAL = 0.25  # [s] between two looks at the memory

Plan = list[tuple[float, float]]  # rate [Hz] and time [s], one after the other


@dataclass(frozen=True)
class Recording:
    """What was sent, and what came back.

    Attributes:
        begin: when the first message was sent [s].
        sent: stamps of the messages that count [ns].
        answered: stamps of those that all answers came to [ns].
        latency: of each of these [s].
    """

    begin: float
    sent: list[int]
    answered: list[int]
    latency: list[float]

    @property
    def lost(self) -> int:
        """How many messages were not answered."""
        return len(self.sent) - len(self.latency)

    def describe(self, wanted: float) -> str:
        """One line; `wanted` is how many messages were to be sent."""
        median, late, most = 1e3 * np.percentile(self.latency, (50.0, 99.0, 100.0))
        sent = len(self.sent)
        times = f"median {median:.3f} ms  99 % {late:.3f} ms  most {most:.1f} ms"
        text = f"{times}  lost {self.lost} of {sent}"
        if sent <= 0.9 * wanted:
            text += " (the sender was too slow)"
        return text


def compare(options: argparse.Namespace) -> None:
    """Measure echo and node, round after round, and the ratio of their latencies."""
    subjects = ["echo", "node"]
    if options.alone:
        subjects = ["node"]
    ratios = []
    for _ in range(options.rounds):
        latency = {what: _compare_one(what, options) for what in subjects}
        if not options.alone:
            ratios.append(latency["node"] / latency["echo"])
    if ratios:
        median, late = np.median(ratios, axis=0)
        title = f"node in times of echo, median of {len(ratios)} rounds"
        print(f"{title}: {median:.2f} (median), {late:.2f} (99 %)")


def _compare_one(what: str, options: argparse.Namespace) -> np.ndarray:
    """Measure echo or node; (2,) the latency's median and 99 % quantile [s]."""
    calls: AbstractContextManager[None] = nullcontext()
    if options.calls and what == "node":
        calls = caller()
    with subject(what, options.robot) as process, calls:
        before = cpu_time(process.pid)
        plan = [(options.rate, options.seconds)]
        recording = _measure(options.robot, plan, echoed=what == "echo")
        busy = (cpu_time(process.pid) - before) / options.seconds
    line = recording.describe(options.rate * (options.seconds - WARM_UP))
    print(f"{what:5s} {line}  processor {100 * busy:.0f} %", flush=True)
    return np.percentile(recording.latency, (50.0, 99.0))


def flood(options: argparse.Namespace) -> None:
    """Latency before, memory during and latency after a flood."""
    plan = [(200.0, 5.0), (10000.0, options.seconds), (200.0, 5.0)]
    with subject("node", options.robot) as process, _memory_of(process.pid) as sizes:
        recording = _measure(options.robot, plan)
    latency = np.array(recording.latency)
    stamp = np.array(recording.answered) * 1e-9
    begin, end = recording.begin + np.cumsum([seconds for _, seconds in plan])[:2]
    usual = np.percentile(latency[stamp < begin], 99)
    late = stamp[(stamp > end) & (latency > 2.0 * usual)]
    recovery = 0.0
    if late.size:
        recovery = max(0.0, float(late.max() - end))
    during = stamp[(stamp > begin) & (stamp < end)]
    sent = len(recording.sent)
    newest = "lost"
    if recording.sent[-1] in recording.answered:
        newest = "answered"
    print(f"sent {sent}, answered {latency.size}, of them in the flood {during.size}")
    print(f"the last message of all: {newest}")
    latency_text = f"usual latency, 99 %: {1e3 * usual:.2f} ms"
    print(f"{latency_text}; as usual again {1e3 * recovery:.0f} ms after the flood")
    before = f"{sizes[0][1]:.1f} MB before"
    early = f"{_size_at(sizes, begin + 2.0):.1f} MB 2 s into the flood"
    print(f"memory of the node {before}, {early}, {_size_at(sizes, end):.1f} MB at its end")


@contextmanager
def _memory_of(pid: int) -> Iterator[list[tuple[float, float]]]:
    """A list of times [s] and memory of a process [MB], which grows until the end."""
    sizes = [(time.time(), memory(pid))]
    stop = threading.Event()

    def watch() -> None:
        while not stop.wait(WATCH_INTERVAL):
            sizes.append((time.time(), memory(pid)))

    watcher = threading.Thread(target=watch)
    watcher.start()
    try:
        yield sizes
    finally:
        stop.set()
        watcher.join()


def _size_at(sizes: Sequence[tuple[float, float]], at: float) -> float:
    """The first memory that was noted from a time [s] on [MB]."""
    return next(size for when, size in sizes if when >= at)


def soak(options: argparse.Namespace) -> None:
    """Latency and memory over a long time; for a tenth of it latency of an echo too.

    The echo has a graph of its own.
    """
    print("  part   median ms   99 % ms   lost   memory MB   echo's median ms   times")
    aside = {"ROS_DOMAIN_ID": str(int(os.environ["ROS_DOMAIN_ID"]) + 1)}
    seconds = options.soak / 10.0
    plan = [(200.0, 0.9 * seconds)]
    echo_plan = [(200.0, max(0.1 * seconds, 2.0 * WARM_UP))]
    with subject("node", options.robot) as process, subject("echo", options.robot, aside):
        for part in range(1, 11):
            recording = _measure(options.robot, plan)
            echo = _measure(options.robot, echo_plan, echoed=True, environment=aside)
            median, late = 1e3 * np.percentile(recording.latency, (50.0, 99.0))
            echo_median = 1e3 * float(np.median(echo.latency))
            times = f"{part:4d}   {median:9.3f}   {late:7.3f}   {recording.lost:4d}"
            ratio = f"{echo_median:16.3f}   {median / echo_median:5.2f}"
            print(f"  {times}   {memory(process.pid):9.1f}   {ratio}", flush=True)


def _measure(
    robot: str, plan: Plan, *, echoed: bool = False, environment: Mapping[str, str] = NOTHING
) -> Recording:
    """Send by a plan, and note what comes back."""
    settings = {"robot": robot, "plan": plan, "echoed": echoed}
    receiver = start("receive", settings, environment)
    sender = start("send", settings, environment)
    stamps = json.loads(sender.communicate()[0].splitlines()[-1])["stamps"]
    received = json.loads(receiver.communicate()[0].splitlines()[-1])
    first = stamps[0] + WARM_UP * 1e9
    answered = []
    latency = []
    for text, times in received.items():
        stamp = int(text)
        if stamp >= first and len(times) == len(ANSWERS):
            answered.append(stamp)
            latency.append((times[-1] - stamp) * 1e-9)
    sent = [stamp for stamp in stamps if stamp >= first]
    return Recording(stamps[0] * 1e-9, sent, answered, latency)
