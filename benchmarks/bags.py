"""A bag through the pipeline: bulk beside message by message, shares of the time, memory.

python -m benchmarks.bags [--seconds 300] [--rate 1000] [--robot forging_chu2020] [--singly 5000]

Makes a recording and processes it in a process of its own (so that its memory is its own). Before
and after, some of its messages are read one by one with rosbags, and the model is asked for each
what the node's topics hold: by the library's calls, as a script would, and by the node's pipeline;
the better time counts. Neither makes messages of it. `--seconds 3600` is the hour that the goals
are about; it needs 4 GB of disk for the result.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from itertools import islice
from pathlib import Path

import numpy as np
from rosbags.rosbag2 import Reader

from hybrid_dynamics_core import Robot, load
from hybrid_dynamics_ros.bags.decode import sample_of
from hybrid_dynamics_ros.bags.make import simulated, write_trajectory
from hybrid_dynamics_ros.bags.process import INPUT, Job, make_pipeline, process
from hybrid_dynamics_ros.bags.trajectory_file import Trajectory
from hybrid_dynamics_ros.messages.interfaces import typestore
from hybrid_dynamics_ros.messages.joint_samples import JointSample
from hybrid_dynamics_ros.parameters import BANDWIDTH, MAX_GAP, Settings
from hybrid_dynamics_ros.stream.filter.filter import FloatArray
from hybrid_dynamics_ros.stream.filter.rate_estimator import EstimatorState, MotionEstimator
from hybrid_dynamics_ros.stream.results import MotionResult

GOALS = {"singly": 20.0, "real time": 60.0, "memory": 1024.0}  # times, times, MB


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.bags", description=__doc__)
    parser.add_argument("--seconds", type=float, default=300.0, help="length of the recording")
    parser.add_argument("--rate", type=float, default=1000.0, help="messages a second")
    parser.add_argument("--robot", default="forging_chu2020")
    parser.add_argument(
        "--singly", type=int, default=5000, help="messages that are taken one by one"
    )
    parser.add_argument("--part", metavar="FOLDER", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.part:
        measured(Path(options.part), options.robot)
        return
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        count = record(place / "in", options.robot, options.seconds, options.rate)
        some, ways = min(options.singly, count), (by_model, by_node)
        before = [singly(place / "in", options.robot, some, way) for way in ways]
        told = bulk(place, options.robot)
        after = [singly(place / "in", options.robot, some, way) for way in ways]
        one, node = map(min, before, after)
        sizes = [
            sum(f.stat().st_size for f in (place / name).iterdir()) / 1e6 for name in ("in", "out")
        ]
    print(text(options, count, told, (one, node), sizes))


def record(path: Path, robot: str, seconds: float, rate: float) -> int:
    """A recording of a minute of motion, there and back again until the time is over."""
    motion = simulated(load(robot), min(seconds, 60.0), rate)
    count = round(seconds * rate)
    if count > len(motion.time):
        motion = repeated(motion, count, rate)
    return write_trajectory(path, motion, INPUT, {"robot": robot})


def repeated(motion: Trajectory, count: int, rate: float) -> Trajectory:
    """Forwards, backwards, forwards ...: positions go on without a jump."""
    length = len(motion.time)
    there = np.arange(count) % (2 * length)
    back = there >= length
    rows = np.where(back, 2 * length - 1 - there, there)
    sign = np.where(back, -1.0, 1.0)[:, None]

    def part(values: FloatArray | None, factor: FloatArray | float) -> FloatArray | None:
        return None if values is None else values[rows] * factor

    return Trajectory(
        motion.names,
        np.arange(count) / rate,
        motion.position[rows],
        part(motion.velocity, sign),
        part(motion.effort, 1.0),
    )


def bulk(place: Path, robot: str) -> dict[str, float]:
    """Seconds by share, and the largest memory [MB], of a process that does nothing else."""
    command = [sys.executable, "-m", "benchmarks.bags", "--robot", robot, "--part", str(place)]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    found: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return found


def measured(place: Path, robot: str) -> None:
    """Process, and print what it took."""
    start, cpu = time.perf_counter(), time.process_time()
    outcome = process(Job(place / "in", place / "out", robot), shown=False)
    spent = {
        **outcome.shares,
        "total": time.perf_counter() - start,
        "cpu": time.process_time() - cpu,
    }
    spent |= {"beside": outcome.beside, "duration": outcome.duration, "bulk": outcome.bulk}
    spent["memory"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    print(json.dumps(spent))


def singly(
    path: Path, name: str, count: int, answer: Callable[[Robot], Callable[[JointSample], object]]
) -> float:
    """Seconds a message: read and deserialise with rosbags, then what answers it."""
    respond = answer(load(name))
    with Reader(path) as reader:
        messages = iter(reader.messages())
        for connection, _, data in islice(messages, 200):  # what is compiled is not counted
            respond(sample_of(typestore().deserialize_cdr(data, connection.msgtype)))
        start = time.perf_counter()
        for connection, _, data in islice(messages, count - 200):
            respond(sample_of(typestore().deserialize_cdr(data, connection.msgtype)))
        return (time.perf_counter() - start) / (count - 200)


def by_model(robot: Robot) -> Callable[[JointSample], object]:
    """What a script would do: filter, closure, efforts and pose by the library's calls."""
    settings = Settings()
    estimator = MotionEstimator(settings[BANDWIDTH], settings[MAX_GAP])
    kept: list[EstimatorState | None] = [None]

    def respond(sample: JointSample) -> object:
        kept[0], rates = estimator.step(kept[0], sample.stamp_ns, sample.position, sample.velocity)
        state = robot.close(sample.position, rates.velocity)
        efforts = (
            None
            if rates.acceleration is None
            else robot.inverse_dynamics(state, rates.acceleration)
        )
        return state, efforts, robot.forward_kinematics(state)

    return respond


def by_node(robot: Robot) -> Callable[[JointSample], object]:
    """What the node does, by shorter ways."""
    pipeline = make_pipeline(robot, Settings())

    def respond(sample: JointSample) -> object:
        result = pipeline.process(sample)
        return result.pose if isinstance(result, MotionResult) else result

    return respond


def text(
    options: argparse.Namespace,
    count: int,
    told: dict[str, float],
    singly: tuple[float, float],
    sizes: list[float],
) -> str:
    """The report."""
    total, duration = told["total"], told["duration"]
    (one, node), own = singly, total / count
    shares = [
        f"  {name:9} {told[name]:8.2f} s  {100.0 * told[name] / total:5.1f} %"
        for name in SHARES
        if name in told
    ]
    lines = [
        (
            f"{options.robot}: {count} messages, {duration:.0f} s at {options.rate:g} Hz,"
            f" {sizes[0]:.0f} MB in, {sizes[1]:.0f} MB out, {os.cpu_count()} processors, load"
            f" {os.getloadavg()[0]:.1f}"
        ),
        *shares,
        f"  total     {total:8.2f} s  ({told['cpu']:.2f} s of processor time)",
        f"  beside    {told['beside']:8.2f} s  by the thread that fills, packs and writes chunks",
        (
            f"in bulk {1e6 * own:.2f} us a message; one by one {1e6 * one:.0f} us, as the node does"
            f" {1e6 * node:.0f} us"
        ),
        (
            f"{one / own:.1f} times faster than one by one (goal {GOALS['singly']:g}),"
            f" {node / own:.1f} than the node"
        ),
        f"{duration / total:.1f} times real time (goal {GOALS['real time']:g})",
        f"{told['memory']:.0f} MB of memory at most (goal: below {GOALS['memory']:g})",
        f"{100.0 * told['bulk']:.1f} % decoded in bulk",
    ]
    return "\n".join(lines)


SHARES = ("start", "reading", "decoding", "model", "encoding", "writing")

if __name__ == "__main__":
    main()
