"""The separate process in which MuJoCo runs, so that a crash there does no harm here."""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import subprocess
import sys
import threading
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import IO, Any

from ....ground.worker_limits import IDLE, OUT_OF_TIME, environment

_WORKER = Path(__file__).with_name("worker.py")
_MAX_SECONDS = 60.0  # [s] timeout of an answer
_PATIENCE = 5  # [s] an idle process ends itself after this time
_MAX_ANSWERS = 200  # per process, since its memory only grows
_BEFORE_IT_WAS_ASKED = (-14, IDLE, -15, -9)  # its own alarm; SIGTERM or SIGKILL from outside
_ENVIRONMENT = {"MUJOCO_GL": "disable", "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}

Answer = dict[str, Any]


def is_installed() -> bool:
    """Whether MuJoCo is installed."""
    return find_spec("mujoco") is not None


class Worker:
    """A process that compiles models one after the other."""

    def __init__(self) -> None:
        self.owner = os.getpid()
        self.answers = 0
        command = [sys.executable, "-I", "-S", "-B", str(_WORKER)]
        self.process = subprocess.Popen(  # noqa: S603 - this Python, on a file of this package
            command,
            cwd="/",
            env=environment(_ENVIRONMENT),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        self.send(_line({"path": sys.path, "patience": _PATIENCE}))

    def ask(self, text: str, assets: Mapping[str, bytes], seconds: int) -> Answer | None:
        """The answer of the process to a model; None if the process ends first."""
        body = text.encode()
        sizes = {name: len(data) for name, data in assets.items()}
        request = {"size": len(body), "assets": sizes, "seconds": seconds}
        timer = threading.Timer(_MAX_SECONDS, self.process.kill)
        timer.daemon = True
        timer.start()
        try:
            self.send(_line(request), *assets.values(), body)
            line = _pipe(self.process.stdout).readline()
        finally:
            timer.cancel()
        if not line.endswith(b"\n"):
            return None
        self.answers += 1
        answer: Answer = json.loads(line)
        return answer

    def send(self, *parts: bytes) -> None:
        """Write to the process; if it has ended, there will be no answer."""
        pipe = _pipe(self.process.stdin)
        with contextlib.suppress(OSError):
            for part in parts:
                pipe.write(part)
            pipe.flush()

    def close(self) -> int:
        """End the process and return its exit code."""
        for pipe in (self.process.stdin, self.process.stdout):
            with contextlib.suppress(OSError):
                _pipe(pipe).close()
        try:
            return self.process.wait(timeout=1.0)
        except subprocess.TimeoutExpired:
            self.process.kill()
            return self.process.wait()


class Workers:
    """The current worker process; replaced if it has ended, or after a fork."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.worker: Worker | None = None

    def ask(self, text: str, assets: Mapping[str, bytes], seconds: int) -> Answer:
        """Compile a model with MuJoCo.

        Args:
            text: the model, without includes.
            assets: contents of files, by the names in the text.
            seconds: limit of processor time [s].
        """
        with self.lock:
            worker = self.current()
            is_new = not worker.answers
            answer = worker.ask(text, assets, seconds)
            if answer is not None:
                return answer
            code = self.end()
            if is_new or code not in _BEFORE_IT_WAS_ASKED:
                return {"error": _ended(code, seconds)}
            answer = self.current().ask(text, assets, seconds)
            return answer or {"error": _ended(self.end(), seconds)}

    def current(self) -> Worker:
        """The worker of this process; started if needed."""
        worker = self.worker
        if worker is not None and worker.owner != os.getpid():
            self.worker = None
        elif worker is not None and worker.answers >= _MAX_ANSWERS:
            self.end()
        if self.worker is None:
            self.worker = Worker()
        return self.worker

    def end(self) -> int:
        """End the process and return its exit code."""
        worker = self.worker
        self.worker = None
        if worker is None or worker.owner != os.getpid():
            return 0
        return worker.close()


WORKERS = Workers()
atexit.register(WORKERS.end)


def _line(data: Mapping[str, Any]) -> bytes:
    return json.dumps(data).encode() + b"\n"


def _pipe(pipe: IO[bytes] | None) -> IO[bytes]:
    """A pipe of a process, which must exist."""
    assert pipe is not None  # noqa: S101
    return pipe


def _ended(code: int, seconds: int) -> str:
    """The reason why a process gave no answer."""
    if code == OUT_OF_TIME:
        return f"takes more than {seconds} s of computing"
    return f"cannot be compiled: the process of MuJoCo ended with {code}, out of memory or time"
