"""Whoever waits for a compiler is told so; whoever does not wait hears nothing."""

from __future__ import annotations

import io
import logging
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import pytest

from hybrid_dynamics_core import Robot, load
from hybrid_dynamics_core.kernels import compile_notice, run

DEADLINE = 60.0  # [s] for a thread to have its turn; nothing waits for this where all is well


class Terminal(io.StringIO):
    """Stderr as a person sees it; `written` is set with the first word."""

    def __init__(self) -> None:
        super().__init__()
        self.written = threading.Event()

    def isatty(self) -> bool:
        return True

    def flush(self) -> None:
        self.written.set()


@pytest.fixture
def terminal(monkeypatch: pytest.MonkeyPatch) -> Terminal:
    made = Terminal()
    monkeypatch.setattr(
        compile_notice, "sys", SimpleNamespace(stderr=made)
    )  # pytest puts its own sys.stderr into its place
    return made


def test_long_compiling_is_told_on_a_terminal(
    terminal: Terminal, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(compile_notice, "PATIENCE", 0.0)
    with compile_notice.CompileNotice().during("motion of arm (once; kept in the cache)"):
        assert terminal.written.wait(DEADLINE)
    assert terminal.getvalue() == "compiling motion of arm (once; kept in the cache) ...\n"


def test_parts_of_one_thing_are_told_once(
    terminal: Terminal, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(compile_notice, "PATIENCE", 0.0)
    word = compile_notice.CompileNotice()
    for label in ("reactions of arm", "reactions of arm", "motion of arm"):
        told_before = label in terminal.getvalue()
        terminal.written.clear()
        with word.during(label):
            assert terminal.written.wait(0.1 if told_before else DEADLINE) is not told_before
    assert terminal.getvalue() == "compiling reactions of arm ...\ncompiling motion of arm ...\n"


def test_short_compiling_is_not_told(terminal: Terminal, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compile_notice, "PATIENCE", DEADLINE)
    before = threading.active_count()
    with compile_notice.CompileNotice().during("motion of arm"):
        pass
    assert terminal.getvalue() == ""
    for thread in threading.enumerate():
        if isinstance(thread, threading.Timer):
            thread.join(DEADLINE)
    assert threading.active_count() <= before  # nobody waits on


def test_many_short_ones_are_told_together_and_then_not_for_a_while(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of programs of 0.4 s every third is told: in its time the second runs out."""
    delays: list[float] = []
    clock = iter([x for k in range(9) for x in (10.0 * k, 10.0 * k + 0.4)])

    class Timer:
        daemon = False

        def __init__(self, delay: float, _act: object, words: tuple[str, threading.Event]) -> None:
            delays.append(delay)
            self.told = words[1]

        def start(self) -> None:
            if delays[-1] < 0.4:
                self.told.set()

        def cancel(self) -> None:
            pass

    monkeypatch.setattr(
        compile_notice, "threading", SimpleNamespace(Timer=Timer, Event=threading.Event)
    )
    monkeypatch.setattr(compile_notice, "time", SimpleNamespace(monotonic=lambda: next(clock)))
    together = compile_notice.CompileNotice()
    for k in range(6):
        with together.during(f"part {k} of arm"):
            pass
    assert delays == pytest.approx([1.0, 0.6, 0.2] * 2)


def test_whoever_listens_to_the_log_gets_it_there(
    terminal: Terminal, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(compile_notice, "PATIENCE", 0.0)
    heard = threading.Event()
    caplog.set_level(logging.INFO, compile_notice.__name__)
    monkeypatch.setattr(
        caplog.handler, "emit", lambda record: (caplog.records.append(record), heard.set())
    )
    with compile_notice.CompileNotice().during("motion of arm"):
        assert heard.wait(DEADLINE)
    assert [record.getMessage() for record in caplog.records] == ["compiling motion of arm"]
    assert terminal.getvalue() == ""


def test_a_pipe_and_a_process_without_stderr_get_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    for stream in (io.StringIO(), None):
        monkeypatch.setattr(compile_notice, "sys", SimpleNamespace(stderr=stream))
        compile_notice._write("motion of arm", threading.Event())
        assert stream is None or stream.getvalue() == ""


@pytest.fixture
def labels(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What would be told if it took long."""
    heard: list[str] = []

    @contextmanager
    def during(label: str) -> Iterator[None]:
        heard.append(label)
        yield

    monkeypatch.setattr(run.NOTICE, "during", during)
    return heard


def torques(robot: Robot) -> None:
    robot.inverse_dynamics(robot.close(robot.reference), [0.0] * len(robot.active))


def test_only_what_is_compiled_is_told(
    labels: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With robot and program; nothing from the cache; without one, that it will come once more."""
    monkeypatch.setenv("HYBRID_DYNAMICS_CACHE", str(tmp_path))
    torques(load("five_bar"))
    assert set(labels) == {
        f"{what} of five_bar (once; kept in the cache)" for what in ("close", "inverse_dynamics")
    }
    labels.clear()
    torques(load("five_bar"))
    assert labels == []
    monkeypatch.setenv("HYBRID_DYNAMICS_CACHE", "off")
    torques(load("five_bar"))
    assert set(labels) == {
        f"{what} of five_bar (not kept: no cache)" for what in ("close", "inverse_dynamics")
    }
