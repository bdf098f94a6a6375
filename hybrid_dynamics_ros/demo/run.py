"""A complete run: play, record, judge, draw, and report."""

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
from .expectation import Expectation, expect
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
_LABEL_WIDTH: Final = 21  # letters of a label
_NOTES: Final = {"source": SOURCE, "robot": ROBOT}
_LABELS: Final = {
    INPUT: "input",
    STATES: "joint states",
    EFFORTS: "required efforts",
    POSE: "end-effector poses",
}


@dataclass(frozen=True)
class Files:
    """Files of a run in its output folder."""

    bag: Path
    png: Path
    svg: Path


def run(output: Path, rate: float, live: bool, out: TextIO) -> bool:
    """Run the demo; returns whether no message was lost and the efforts equal the model's.

    Args:
        output: folder for the files; created if missing.
        rate: recorded time over real time.
        live: whether to show the live view.
        out: stream for the live view and the summary.

    Raises:
        DemoError: the node or the player failed, or the bag cannot be written.
        InterruptedDemoError: the run was interrupted by a signal.
    """
    robot = load(ROBOT)
    output.mkdir(parents=True, exist_ok=True)
    bag = output / f"{ROBOT}_results"
    try:
        expected = expect(shipped_messages(), float(BANDWIDTH.default), float(MAX_GAP.default))
        view = LiveView(out, expected, _prismatic(robot)) if live else None
        _record(expected, bag, rate, view, out)
        results = read_results(bag)
    except BagError as error:
        raise DemoError(str(error)) from error
    verdict = judge(expected, results, robot)
    png, svg = save_figure(results, robot, output / ROBOT, SUBTITLE)
    _say(out, summary(verdict, Files(bag, png, svg)))
    return verdict.good


def _record(
    expected: Expectation, bag: Path, rate: float, view: LiveView | None, out: TextIO
) -> None:
    """Play and record, with messages if there is a live view."""

    def say(text: str) -> None:
        if view is not None:
            _say(out, text)

    with stop_signals() as stop:
        with new_bag(bag, bag_topics(TYPES), _NOTES) as writer:
            Session(expected, bag.parent, say, view, stop).record(writer, rate)
        if stop.is_set():
            raise InterruptedDemoError("Stopped.")


def _say(out: TextIO, text: str) -> None:
    out.write(text + "\n")
    out.flush()


def summary(verdict: Verdict, files: Files) -> str:
    """The verdict and the paths of the files, for the terminal."""
    lines = ["", f"{verdict.expected[INPUT]} messages played, {verdict.lost} messages lost"]
    lines += [_topic_line(verdict, topic) for topic in _LABELS]
    median, late = (f"{1e3 * delay:.1f} ms" for delay in verdict.delay)
    delay = f"{median} median, {late} at 99 %, from sending the input to receiving efforts"
    lines.append(f"  {'delay':<19}{delay}")
    lines.append("Efforts of the node beside the model called directly")
    lines.append(f"  {'difference':<19}{_difference(verdict)}")
    lines.append("Files")
    lines.append(f"  {files.bag}/   rosbag2 (MCAP): input and results")
    content = "efforts and path, to lay beside Figures 10 and 8 of the paper"
    lines.append(f"  {files.png}, {files.svg.suffix}   {content}")
    if not verdict.good:
        lines.append(_complaint(verdict))
    return "\n".join(wrapped(line) for line in lines)


def wrapped(line: str) -> str:
    """A line of the summary, wrapped to the terminal's width and indented."""
    indent = " " * _LABEL_WIDTH
    return fill(
        line, _WIDTH, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
    )


def _topic_line(verdict: Verdict, topic: str) -> str:
    """Text on the number of received messages of a topic."""
    expected, received = verdict.expected[topic], verdict.received[topic]
    text = f"  {_LABELS[topic]:<19}{received:5d} of {expected:5d} received"
    skipped = verdict.expected[INPUT] - expected
    if topic == EFFORTS and skipped:
        text += f"  (the first {skipped} fill the acceleration filter)"
    return text


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
    """Coordinates that are lengths."""
    return frozenset(name for name, kind in robot.joint_types.items() if kind == "prismatic")
