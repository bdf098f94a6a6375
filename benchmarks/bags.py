"""A bag through the pipeline: bulk beside message by message, shares of the time, memory.

python -m benchmarks.bags [--seconds 300] [--rate 1000] [--robot forging_chu2020] [--singly 5000]

Makes a recording, and processes it in another process, whose memory is measured. Before and after,
some of its messages are read one by one with rosbags. For each the model computes what the node's
topics hold, by the library's calls as a script would, and by the node's pipeline. The better time
counts. Neither makes messages of it. `--seconds 3600` is the hour that the goals are about. It
needs 4 GB of disk for the result.
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
from hybrid_dynamics_ros.bags.decode import sample_of_state
from hybrid_dynamics_ros.bags.input_topic import INPUT
from hybrid_dynamics_ros.bags.job import Job
from hybrid_dynamics_ros.bags.make import simulated, write_trajectory
from hybrid_dynamics_ros.bags.process import process
from hybrid_dynamics_ros.bags.settings import make_pipeline
from hybrid_dynamics_ros.bags.trajectory_file import Trajectory
from hybrid_dynamics_ros.messages.interfaces import typestore
from hybrid_dynamics_ros.messages.joint_samples import JointSample
from hybrid_dynamics_ros.parameters import BANDWIDTH, MAX_GAP, NodeSettings
from hybrid_dynamics_ros.stream.filter.rate_estimator import EstimatorState, MotionEstimator
from hybrid_dynamics_ros.stream.results import MotionResult

GOALS = {"singly": 20.0, "real time": 60.0, "memory": 1024.0}  # times, times, MB
SHARES = ("start", "reading", "decoding", "model", "encoding", "writing")
WARM_UP = 200  # messages that are not counted: kernels are compiled


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
        singly_count = min(options.singly, count)
        before = _singly(place / "in", options.robot, singly_count)
        bulk_times = bulk(place, options.robot)
        after = _singly(place / "in", options.robot, singly_count)
        sizes = [_size(place / "in"), _size(place / "out")]
    by_model_time, by_node_time = map(min, before, after)
    print(report(options, count, bulk_times, by_model_time, by_node_time, sizes))


def _singly(path: Path, robot: str, count: int) -> tuple[float, float]:
    """Seconds a message, taken one by one: by the library's calls, and by the node's pipeline."""
    return singly(path, robot, count, by_model), singly(path, robot, count, by_node)


def _size(folder: Path) -> float:
    """Size of the files in a folder [MB]."""
    return sum(file.stat().st_size for file in folder.iterdir()) / 1e6


def record(path: Path, robot: str, seconds: float, rate: float) -> int:
    """Write a recording of a minute of motion, forwards and backwards until the time is over.

    Args:
        path: of the recording.
        robot: name or file of the robot.
        seconds: length of the recording.
        rate: messages a second.

    Returns:
        How many messages it holds.
    """
    motion = simulated(load(robot), min(seconds, 60.0), rate)
    count = round(seconds * rate)
    if count > len(motion.time):
        motion = repeated(motion, count, rate)
    return write_trajectory(path, motion, INPUT, {"robot": robot})


def repeated(motion: Trajectory, count: int, rate: float) -> Trajectory:
    """Forwards, backwards, forwards ...: positions go on without a jump."""
    length = len(motion.time)
    phase = np.arange(count) % (2 * length)
    is_backward = phase >= length
    rows = np.where(is_backward, 2 * length - 1 - phase, phase)
    sign = np.where(is_backward, -1.0, 1.0)[:, None]
    velocity = None
    if motion.velocity is not None:
        velocity = motion.velocity[rows] * sign
    effort = None
    if motion.effort is not None:
        effort = motion.effort[rows]
    time = np.arange(count) / rate
    return Trajectory(motion.names, time, motion.position[rows], velocity, effort)


def bulk(place: Path, robot: str) -> dict[str, float]:
    """Seconds by share, and the largest memory [MB], of a process that does nothing else."""
    command = [sys.executable, "-m", "benchmarks.bags", "--robot", robot, "--part", str(place)]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    times: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return times


def measured(place: Path, robot: str) -> None:
    """Process, and print what it took."""
    start = time.perf_counter()
    cpu_start = time.process_time()
    outcome = process(Job(place / "in", place / "out", robot), shown=False)
    spent = {
        **outcome.shares,
        "total": time.perf_counter() - start,
        "cpu": time.process_time() - cpu_start,
        "beside": outcome.beside,
        "duration": outcome.duration,
        "bulk": outcome.bulk,
        "memory": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
    }
    print(json.dumps(spent))


def singly(
    path: Path, name: str, count: int, answer: Callable[[Robot], Callable[[JointSample], object]]
) -> float:
    """Seconds a message: read and deserialise with rosbags, then answer it."""
    respond = answer(load(name))
    with Reader(path) as reader:
        messages = iter(reader.messages())
        for connection, _, data in islice(messages, WARM_UP):
            respond(sample_of_state(typestore().deserialize_cdr(data, connection.msgtype)))
        start = time.perf_counter()
        for connection, _, data in islice(messages, count - WARM_UP):
            respond(sample_of_state(typestore().deserialize_cdr(data, connection.msgtype)))
        return (time.perf_counter() - start) / (count - WARM_UP)


def by_model(robot: Robot) -> Callable[[JointSample], object]:
    """What a script would do: filter, closure, efforts and pose by the library's calls."""
    settings = NodeSettings()
    estimator = MotionEstimator(settings[BANDWIDTH], settings[MAX_GAP])
    memory: EstimatorState | None = None

    def respond(sample: JointSample) -> object:
        nonlocal memory
        memory, rates = estimator.step(memory, sample.stamp_ns, sample.position, sample.velocity)
        state = robot.close(sample.position, rates.velocity)
        efforts = None
        if rates.acceleration is not None:
            efforts = robot.inverse_dynamics(state, rates.acceleration)
        return state, efforts, robot.forward_kinematics(state)

    return respond


def by_node(robot: Robot) -> Callable[[JointSample], object]:
    """What the node does, by shorter ways."""
    pipeline = make_pipeline(robot, NodeSettings())

    def respond(sample: JointSample) -> object:
        result = pipeline.process(sample)
        if isinstance(result, MotionResult):
            return result.pose
        return result

    return respond


def report(
    options: argparse.Namespace,
    count: int,
    times: dict[str, float],
    by_model_time: float,
    by_node_time: float,
    sizes: list[float],
) -> str:
    """The results in lines.

    Args:
        options: of the command.
        count: messages of the recording.
        times: from `bulk`.
        by_model_time: seconds a message, taken one by one, by the library's calls.
        by_node_time: the same, by the node's pipeline.
        sizes: of the recording and of the result [MB].
    """
    total = times["total"]
    duration = times["duration"]
    bulk_time = total / count
    recording = f"{count} messages, {duration:.0f} s at {options.rate:g} Hz"
    files = f"{sizes[0]:.0f} MB in, {sizes[1]:.0f} MB out"
    machine = f"{os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}"
    singly = (
        f"one by one {1e6 * by_model_time:.0f} us, as the node does {1e6 * by_node_time:.0f} us"
    )
    gain = f"{by_model_time / bulk_time:.1f} times faster than one by one"
    lines = [
        f"{options.robot}: {recording}, {files}, {machine}",
        *_share_lines(times),
        f"  total     {total:8.2f} s  ({times['cpu']:.2f} s of processor time)",
        f"  beside    {times['beside']:8.2f} s  by the thread that fills, packs and writes chunks",
        f"in bulk {1e6 * bulk_time:.2f} us a message; {singly}",
        f"{gain} (goal {GOALS['singly']:g}), {by_node_time / bulk_time:.1f} than the node",
        f"{duration / total:.1f} times real time (goal {GOALS['real time']:g})",
        f"{times['memory']:.0f} MB of memory at most (goal: below {GOALS['memory']:g})",
        f"{100.0 * times['bulk']:.1f} % decoded in bulk",
    ]
    return "\n".join(lines)


def _share_lines(times: dict[str, float]) -> list[str]:
    lines = []
    for name in SHARES:
        if name in times:
            share = 100.0 * times[name] / times["total"]
            lines.append(f"  {name:9} {times[name]:8.2f} s  {share:5.1f} %")
    return lines


if __name__ == "__main__":
    main()
