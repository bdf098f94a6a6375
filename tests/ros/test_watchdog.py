"""A loop that stands still, in a process of its own: what ends it, and what it says."""

import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest

from hybrid_dynamics_ros.node.process.watchdog import LIMIT, PATIENCE

ROOT = Path(__file__).resolve().parents[2]
# The second mutex is waited for with the interpreter held, as the middleware does it.
HANGS = {
    "a lock": "import threading; lock = threading.Lock(); lock.acquire(); lock.acquire()",
    "the interpreter held": (
        "import ctypes; mutex = ctypes.create_string_buffer(64); c = ctypes.PyDLL(None);"
        " c.pthread_mutex_lock(mutex); c.pthread_mutex_lock(mutex)"
    ),
}
WATCHED = (
    "from hybrid_dynamics_ros.node.process.watchdog import Watchdog; watchdog = Watchdog(1.0);"
    " watchdog.beat(); print('hangs', flush=True)"
)
STOPPED = (
    "from hybrid_dynamics_ros.node.process.stop_signals import StopSignals; stop = StopSignals();"
    " print('hangs', flush=True)"
)


def test_the_page_tells_how_long_a_loop_may_stand_still():
    page = (ROOT / "docs" / "node_reference.md").read_text(encoding="utf-8")
    assert f"blocked for {LIMIT:g} s ({PATIENCE:g} s while it configures)" in page


@pytest.fixture
def start():
    started = []

    def run(code):
        process = subprocess.Popen(
            [sys.executable, "-c", code],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        started.append(process)
        assert process.stdout.readline() == "hangs\n"
        return process

    yield run
    for process in started:
        process.kill()
        process.communicate()


def test_a_loop_that_waits_for_a_lock_is_ended_with_the_reason(start):
    process = start(f"{WATCHED}; {HANGS['a lock']}")
    assert process.wait(60.0) == 1
    said = process.stderr.read()
    assert "[FATAL]" in said
    assert "the loop of the node has stood still for 1 s: the process ends" in said
    assert '"<string>", line 1' in said  # where it stood


def test_a_loop_that_holds_the_interpreter_is_ended_with_where_it_stood(start):
    process = start(f"{WATCHED}; {HANGS['the interpreter held']}")
    assert process.wait(60.0) == -signal.SIGALRM
    said = process.stderr.read()
    assert "_end_process_where_loop_stands_still" in said
    assert '"<string>", line 1' in said


LOOP = (
    "import select, sys, time\n"
    "while not select.select([sys.stdin], [], [], 0.05)[0]:\n"
    "    watchdog.beat()\n"
)


@pytest.mark.sweep(sample="test_a_loop_that_waits_for_a_lock_is_ended_with_the_reason")
def test_a_process_that_was_suspended_goes_on(start):
    process = start(f"{WATCHED}\n{LOOP}watchdog.stop()\nprint('ended', flush=True)")
    process.send_signal(signal.SIGSTOP)
    time.sleep(1.5)  # longer than the loop may stand still
    process.send_signal(signal.SIGCONT)
    time.sleep(0.3)
    process.stdin.write("\n")
    process.stdin.flush()
    assert process.stdout.readline() == "ended\n"
    assert process.wait(60.0) == 0


@pytest.mark.sweep(sample="test_a_loop_that_waits_for_a_lock_is_ended_with_the_reason")
def test_long_work_that_was_announced_goes_on(start):
    process = start(
        f"{WATCHED}\nimport time\nwith watchdog.patient():\n    time.sleep(1.5)\n"
        "watchdog.stop()\nprint('ended', flush=True)"
    )
    assert process.stdout.readline() == "ended\n"
    assert process.wait(60.0) == 0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("hang", HANGS)
def test_a_second_signal_ends_a_process_that_hangs(start, hang, number):
    process = start(f"{STOPPED}; {HANGS[hang]}")
    process.send_signal(number)
    time.sleep(0.2)
    assert process.poll() is None
    code = end_by_signals(process, number)
    said = process.stderr.read()
    if hang == "a lock":
        assert (code, "stopped: by a second signal" in said) == (0, True)
    else:
        assert code == -number


def end_by_signals(process, number):
    """The exit code after one signal more, or two where the first came before the hang began."""
    for _ in range(2):
        process.send_signal(number)
        with suppress(subprocess.TimeoutExpired):
            return process.wait(5.0)
    return process.wait(60.0)
