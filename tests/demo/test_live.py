"""The live view."""

import io

import pytest

from hybrid_dynamics_ros.demo.play.live import LiveView
from hybrid_dynamics_ros.demo.play.recording import START_NS
from hybrid_dynamics_ros.demo.play.snapshot import take_snapshot
from hybrid_dynamics_ros.demo.play.table import Progress, table
from hybrid_dynamics_ros.demo.topics import EFFORTS, INPUT, POSE, STATES, TYPES
from hybrid_dynamics_ros.messages.interfaces import typestore

COUNTS = {INPUT: 501, STATES: 501, EFFORTS: 498, POSE: 501}
PRISMATIC = frozenset({"q12", "q22"})


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    encoding = "utf-8"

    def isatty(self):
        return True


def encode(kind, **fields):
    types = typestore().types
    time = types["builtin_interfaces/msg/Time"](sec=START_NS // 10**9 + 5, nanosec=0)
    header = types["std_msgs/msg/Header"](stamp=time, frame_id="base")
    return bytes(typestore().serialize_cdr(types[kind](header=header, **fields), kind))


@pytest.fixture
def latest(results):
    """The messages at t = 5 s."""
    states, efforts, pose = results.states, results.efforts, results.pose
    types = typestore().types
    point = types["geometry_msgs/msg/Point"](
        **dict(zip("xyz", pose.position[500].tolist(), strict=True))
    )
    turn = types["geometry_msgs/msg/Quaternion"](
        **dict(zip("xyzw", pose.quaternion[500].tolist(), strict=True))
    )
    none = states.effort[0, :0]
    return {
        STATES: encode(
            TYPES[STATES],
            name=list(states.names),
            position=states.position[500],
            velocity=states.velocity[500],
            effort=none,
        ),
        EFFORTS: encode(
            TYPES[EFFORTS],
            name=list(efforts.names),
            position=none,
            velocity=none,
            effort=efforts.effort[497],
        ),
        POSE: encode(
            TYPES[POSE], pose=types["geometry_msgs/msg/Pose"](position=point, orientation=turn)
        ),
    }


def test_the_table_shows_all_coordinates_efforts_and_the_tool(latest, robot, results):
    rows = [
        row.text
        for row in table(take_snapshot(latest), Progress(5.0, 10.0, COUNTS), PRISMATIC, "#-")
    ]
    text = "\n".join(rows)
    first_words = [row.split()[0] for row in rows if row]
    assert [word for word in first_words if word.startswith("q")] == list(robot.coordinates)
    assert "150.000 mm        10.000 mm/s" in text
    assert "50.000 deg       10.000 deg/s" in text
    assert f"{results.efforts.effort[497, 1]:.3f} N" in text
    assert f"z {results.pose.position[500, 2]:7.4f}" in text
    assert "50 %" in text
    assert all(len(row) < 80 for row in rows)
    assert len(rows) < 24


def test_without_a_terminal_it_writes_plain_lines_at_a_slow_rate(latest, expected):
    stream = io.StringIO()
    view = LiveView(stream, expected, PRISMATIC)
    for _ in range(100):
        view.update(latest, COUNTS)
    assert stream.getvalue().count("\n") == 2
    assert max(map(len, stream.getvalue().splitlines())) <= 80
    assert stream.getvalue().startswith("t  5.00 s | q1 50.000 deg")
    assert "\x1b" not in stream.getvalue()


def test_in_a_terminal_it_draws_over_itself_and_gives_the_cursor_back(
    latest, expected, monkeypatch
):
    for name, value in {"TERM": "xterm", "LINES": "40", "COLUMNS": "100"}.items():
        monkeypatch.setenv(name, value)
    stream = Terminal()
    view = LiveView(stream, expected, PRISMATIC)
    view.update(latest, COUNTS)
    first = stream.getvalue()
    view.close(latest, COUNTS)
    second = stream.getvalue()[len(first) :]
    assert f"\x1b[{first.count(chr(10))}A" in second
    assert first.startswith("\r\x1b[?25l")
    assert second.endswith("\x1b[?25h")


def test_a_terminal_too_small_for_the_table_gets_lines(latest, expected, monkeypatch):
    for name, value in {"TERM": "xterm", "LINES": "10", "COLUMNS": "80"}.items():
        monkeypatch.setenv(name, value)
    stream = Terminal()
    LiveView(stream, expected, PRISMATIC).update(latest, COUNTS)
    assert stream.getvalue().count("\n") == 2
    assert "\x1b" not in stream.getvalue()


def test_before_the_first_efforts_it_shows_nothing(latest, expected):
    stream = io.StringIO()
    view = LiveView(stream, expected, PRISMATIC)
    view.update({}, COUNTS)
    view.update({topic: latest[topic] for topic in (STATES, POSE)}, COUNTS)
    assert stream.getvalue() == ""
