"""A whole run: play and record, judge, draw, and say what there is."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from textwrap import fill
from typing import Final, TextIO

from hybrid_dynamics_core import Robot, load

from ..bags.errors import BagError
from ..bags.storage.bag_writer import new_bag
from ..parameters import BANDWIDTH, MAX_GAP
from .errors import DemoError, InterruptedDemoError
from .expectation import expect
from .judge.plot import save_figure
from .judge.results import read_results
from .judge.verdict import Verdict, judge
from .play.live import LiveView
from .play.recording import shipped_messages
from .session import Session, stop_signals
from .topics import EFFORTS, INPUT, POSE, STATES, TYPES, bag_topics
from .trajectory import ROBOT, SOURCE

SUBTITLE: Final = f"Trajectory of {SOURCE}; efforts and poses as received from the running node"
_WIDTH: Final = 80  # letters of a terminal
_LABEL: Final = 21  # of them for a label
_LABELS: Final = {
    INPUT: "input",
    STATES: "joint states",
    EFFORTS: "required efforts",
    POSE: "end-effector poses",
}


@dataclass(frozen=True)
class Files:
    """What a run leaves in its output folder."""

    bag: Path
    png: Path
    svg: Path


def run(output: Path, rate: float, live: bool, out: TextIO) -> bool:
    """Run the demo. Whether all went well: nothing lost, efforts as the model gives them.

    Args:
        output: folder for the files; made where it is missing.
        rate: recorded time over real time.
        live: whether to show what comes as it comes.
        out: where the live view and the summary go.

    Raises:
        DemoError: the node or the player failed.
        InterruptedDemoError: a signal asked to stop.
    """
    try:
        return _run(output, rate, live, out)
    except BagError as error:
        raise DemoError(str(error)) from error


def _run(output: Path, rate: float, live: bool, out: TextIO) -> bool:
    def say(text: str) -> None:
        out.write(text + "\n")
        out.flush()

    robot = load(ROBOT)
    messages = shipped_messages()
    expected = expect(messages, float(BANDWIDTH.default), float(MAX_GAP.default))
    view = LiveView(out, expected, _prismatic(robot)) if live else None
    output.mkdir(parents=True, exist_ok=True)
    bag = output / f"{ROBOT}_results"
    with stop_signals() as stop:
        with new_bag(bag, bag_topics(TYPES), {"source": SOURCE, "robot": ROBOT}) as writer:
            Session(expected, output, say if live else _be_quiet, view, stop).record(writer, rate)
        if stop.is_set():
            raise InterruptedDemoError("Stopped.")
    results = read_results(bag)
    verdict = judge(expected, results, robot)
    png, svg = save_figure(results, robot, output / ROBOT, SUBTITLE)
    say(summary(verdict, Files(bag, png, svg)))
    return verdict.good


def summary(verdict: Verdict, files: Files) -> str:
    """The findings and where the files are, for the terminal."""
    median, late = (f"{1e3 * delay:.1f} ms" for delay in verdict.delay)
    skipped = verdict.expected[INPUT] - verdict.expected[EFFORTS]
    lines = ["", f"{verdict.expected[INPUT]} messages played, {verdict.lost} messages lost"]
    for topic, label in _LABELS.items():
        note = (
            f"  (the first {skipped} fill the acceleration filter)"
            if topic == EFFORTS and skipped
            else ""
        )
        lines.append(
            f"  {label:<19}{verdict.received[topic]:5d} of {verdict.expected[topic]:5d}"
            f" received{note}"
        )
    lines += [
        (
            f"  {'delay':<19}{median} median, {late} at 99 %, from sending the input to receiving"
            " efforts"
        ),
        "Efforts of the node beside the model called directly",
        f"  {'difference':<19}{_difference(verdict)}",
        "Files",
        f"  {files.bag}/   rosbag2 (MCAP): input and results",
        (
            f"  {files.png}, {files.svg.suffix}   efforts and path, to lay beside Figures 10 and 8"
            " of the paper"
        ),
    ]
    if not verdict.good:
        lines.append(_complaint(verdict))
    return "\n".join(wrapped(line) for line in lines)


def wrapped(line: str) -> str:
    """A line of the summary on as many as a terminal needs.

    What goes on stands below what it tells of the label.
    """
    return fill(
        line, _WIDTH, subsequent_indent=" " * _LABEL, break_long_words=False, break_on_hyphens=False
    )


def _difference(verdict: Verdict) -> str:
    if verdict.difference == 0.0:
        return "none, to the last bit"
    return (
        f"{verdict.difference:.1e} N or N m at most, {verdict.relative:.1e} of the largest effort"
        " at that time"
    )


def _complaint(verdict: Verdict) -> str:
    if verdict.lost:
        return (
            f"FAILED: {verdict.lost} messages were lost; what the node said is beside the result"
            " bag, in node.log"
        )
    return "FAILED: the efforts of the node are not those of the model"


def _prismatic(robot: Robot) -> frozenset[str]:
    return frozenset(name for name, kind in robot.joint_types.items() if kind == "prismatic")


def _be_quiet(_text: str) -> None:
    pass
