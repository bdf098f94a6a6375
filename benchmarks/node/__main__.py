"""Latency and losses of the node, beside one that only echoes JointState on three topics.

python -m benchmarks.node [--rate 1000] [--seconds 10] [--rounds 3] [--robot forging_chu2020]
                          [--calls] [--flood] [--soak SECONDS]

Three processes take part: a sender, the node (or the echo), a receiver. Echo and node have the same
executor. Sender and receiver handle serialised messages, so that they cost little. The latency of
an input runs from before it is published until the last of its three answers is there.
  --alone  leaves the echo node out
  --calls  asks for inverse kinematics out of reach all the time, from a fourth process
  --flood  10000 messages a second for the time given, then 200 a second: how long until the latency
           is as it was before?
  --soak   one robot at 200 Hz for so long: latency and memory of the node by tenths of the time,
           and latency of an echo
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Callable
from typing import Any

from .actors import call, echo, receive, send
from .scenarios import compare, flood, soak

ACTORS: dict[str, Callable[[dict[str, Any]], None]] = {
    "echo": echo,
    "send": send,
    "receive": receive,
    "call": call,
}


def main() -> None:
    """Measure what is asked for; print it."""
    options = _options()
    if options.part:
        ACTORS[options.part](json.loads(options.settings))
        return
    machine = f"{os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}"
    print(f"{options.robot}, {options.seconds:g} s, {machine}")
    if options.soak:
        soak(options)
    elif options.flood:
        flood(options)
    else:
        compare(options)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.node",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--rate", type=float, default=1000.0)
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--robot", default="forging_chu2020")
    parser.add_argument("--calls", action="store_true")
    parser.add_argument("--alone", action="store_true", help="without the echo node")
    parser.add_argument("--flood", action="store_true")
    parser.add_argument("--soak", type=float)
    parser.add_argument("--part", help=argparse.SUPPRESS)
    parser.add_argument("--settings", default="{}", help=argparse.SUPPRESS)
    return parser.parse_args()


if __name__ == "__main__":
    main()
