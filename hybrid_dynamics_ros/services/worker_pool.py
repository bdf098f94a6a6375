"""Processes beside the node that answer service calls, so that the stream never waits for one.

One process and one thread of the node for each lane: the thread hands over a job, waits without
holding the interpreter, and passes on what comes back. A process that dies or takes too long is
replaced. Knows no rclpy.
"""

from __future__ import annotations

import queue
import subprocess
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final

from hybrid_dynamics_core.description.model import RobotDescription

from ..messages.joint_samples import Rejection, RejectionCode
from ..stream.conditions import ConditionChange
from ..stream.monitor import Level, StatusEntry
from ..stream.situation import Situation
from .answers import refused
from .processes import start
from .table import BY_NAME, Lane

Done = Callable[[Any, ConditionChange | None], None]
_START_TIMEOUT: Final = 60.0  # [s] for a process to import all it needs
_ATTEMPTS: Final = 2  # to answer a call whose process ends
_EARLY: Final = 5.0  # [s] within which a process is young
_MOST_EARLY: Final = 10  # young processes that are replaced, one after the other
_END_TIMEOUT: Final = 5.0  # [s] for a thread to see that it is over


@dataclass(frozen=True)
class ServiceCall:
    """A call to answer.

    Attributes:
        service: its name.
        request: the request message.
        situation: how things stand.
        timeout: how long it may take [s].
        done: is given the response, and the change that the call makes.
    """

    service: str
    request: Any
    situation: Situation
    timeout: float
    done: Done = field(compare=False)

    def refuse(self, code: RejectionCode, text: str) -> None:
        """Answer it with a reason instead."""
        self.done(refused(BY_NAME[self.service].kind.Response(), Rejection(code, text)), None)


class WorkerPool:
    """The processes of one robot."""

    def __init__(self, description: RobotDescription) -> None:
        """Start them; a first call waits until its process is up."""
        self._lanes = {
            lane: _Worker(lane.name.lower(), description, gives_way=lane is Lane.LONG)
            for lane in (Lane.SHORT, Lane.SEARCH, Lane.LONG)
        }

    def submit(self, lane: Lane, job: ServiceCall, most: int) -> None:
        """Have a job done; with ``most`` jobs waiting already it is refused at once."""
        self._lanes[lane].submit(job, most)

    def report(self) -> list[StatusEntry]:
        """How the processes are, each by its lane; it warns of those that were replaced."""
        return [worker.report() for worker in self._lanes.values()]

    def close(self) -> None:
        """End the processes; jobs that wait are refused."""
        for worker in self._lanes.values():
            worker.stop()
        for worker in self._lanes.values():
            worker.join()


class _Worker:
    """One process, and the thread that talks to it."""

    def __init__(self, name: str, description: RobotDescription, *, gives_way: bool) -> None:
        self._name, self._description, self._gives_way = name, description, gives_way
        # Calls, and processes that ended; None: there will be no more.
        self._jobs: queue.SimpleQueue[ServiceCall | subprocess.Popen[bytes] | None]
        self._jobs = queue.SimpleQueue()
        self._ends = 0  # of its processes so far, killed ones and those that took too long
        self._reported_ends = 0
        self._early_ends = 0  # one after the other, of processes that were young
        self._stopping = False
        self._start()
        self._thread = threading.Thread(target=self._run, name=f"{name} services", daemon=True)
        self._thread.start()

    def submit(self, job: ServiceCall, most: int) -> None:
        if self._stopping:
            job.refuse(RejectionCode.NOT_READY, "the node is being cleaned up")
        elif self._jobs.qsize() >= most:
            job.refuse(RejectionCode.BUSY, f"{most} calls wait already; call again later")
        else:
            self._jobs.put(job)

    def report(self) -> StatusEntry:
        replaced, self._reported_ends = self._ends - self._reported_ends, self._ends
        level = Level.WARN if replaced else Level.OK
        words = f"process {self._process.pid}, {self._jobs.qsize()} calls wait"
        if self._ends:
            words = f"{words}, ended {self._ends} times and was replaced"
        return StatusEntry(self._name, words, level)

    def stop(self) -> None:
        self._stopping = True
        self._jobs.put(None)
        self._process.kill()  # it holds nothing that would have to be saved

    def join(self) -> None:
        self._thread.join(_END_TIMEOUT)
        self._process.wait(_END_TIMEOUT)
        self._connection.close()

    def _start(self) -> None:
        self._process, self._connection = start(f"{__package__}.worker", gives_way=self._gives_way)
        self._fresh = True
        self._started = time.monotonic()
        watch = threading.Thread(target=self._await_end, args=(self._process,), daemon=True)
        watch.start()

    def _await_end(self, process: subprocess.Popen[bytes]) -> None:
        process.wait()
        self._jobs.put(process)

    def _replace(self, ended: subprocess.Popen[bytes]) -> None:
        """Replace a process that ended, unless that is done already.

        Where all end early, a call has to come first.
        """
        if ended is not self._process:
            return
        is_early = time.monotonic() < self._started + _EARLY
        self._early_ends = self._early_ends + 1 if is_early else 0
        if self._early_ends <= _MOST_EARLY:
            self._restart()

    def _restart(self) -> None:
        self._ends += 1
        self._process.kill()
        self._process.wait()
        self._connection.close()
        if not self._stopping:
            self._start()

    def _run(self) -> None:
        while (job := self._jobs.get()) is not None:
            if isinstance(job, ServiceCall):
                self._answer(job)
            else:
                self._replace(job)

    def _answer(self, job: ServiceCall) -> None:
        """Answer a call; once more where its process ends, since no answer changes anything."""
        for _ in range(_ATTEMPTS):
            if self._stopping:
                job.refuse(RejectionCode.NOT_READY, "the node is being cleaned up")
                return
            try:
                self._work(job)
            except (EOFError, OSError):
                self._restart()
            except Exception as error:  # noqa: BLE001 - this thread answers all later calls
                self._restart()
                job.refuse(RejectionCode.INTERNAL, f"fault of the node: {error!r}")
                return
            else:
                return
        text = f"the process that worked on this call ended, {_ATTEMPTS} times; call again"
        job.refuse(RejectionCode.INTERNAL, text)

    def _work(self, job: ServiceCall) -> None:
        if self._fresh:
            self._connection.send(self._description)
            if not self._connection.poll(_START_TIMEOUT):
                raise EOFError
            self._connection.recv()
            self._fresh = False
        self._connection.send((job.service, job.request, job.situation))
        if not self._connection.poll(job.timeout):
            self._restart()
            job.refuse(
                RejectionCode.TIMEOUT,
                f"not done within {job.timeout:g} s (parameter services.timeout)",
            )
            return
        response, change = self._connection.recv()
        job.done(response, change)
