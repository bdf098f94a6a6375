"""Worker processes that answer service calls, so that the stream never waits.

Each lane has one process and one thread of the node. The thread sends a job, waits without the GIL,
and passes the response on. A process that dies or takes too long is replaced. This module does not
depend on rclpy.
"""

from __future__ import annotations

import queue
import subprocess
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any, Final

from hybrid_dynamics_core.description.model import RobotDescription

from ..messages.joint_samples import Rejection, RejectionCode
from ..stream.conditions import ConditionChange
from ..stream.monitor import Level, StatusEntry
from ..stream.situation import Situation
from .answers import refused
from .processes import Child, Process, start, start_alike
from .table import BY_NAME, Lane

Done = Callable[[Any, ConditionChange | None], None]
_PROGRAM: Final = f"{__package__}.worker"
_START_TIMEOUT: Final = 60.0  # [s] for a process to start
_ATTEMPTS: Final = 2  # for a call whose process ends
_EARLY: Final = 5.0  # [s] a process that ends earlier failed at its start
_MOST_EARLY: Final = 10  # consecutive early failures after which a process is not replaced at once
_END_TIMEOUT: Final = 5.0  # [s] for a thread to end


@dataclass(frozen=True)
class ServiceCall:
    """A service call.

    Attributes:
        service: name of the service.
        request: the request message.
        situation: situation of the robot.
        timeout: longest time [s].
        done: called with the response, and a change of conditions or None.
    """

    service: str
    request: Any
    situation: Situation
    timeout: float
    done: Done = field(compare=False)

    def refuse(self, code: RejectionCode, text: str) -> None:
        """Answer with an error."""
        self.done(refused(BY_NAME[self.service].kind.Response(), Rejection(code, text)), None)


class WorkerPool:
    """The processes of one robot."""

    def __init__(self, description: RobotDescription) -> None:
        """Start the processes; the first calls wait until they are ready."""
        lanes = (Lane.SHORT, Lane.SEARCH, Lane.LONG)
        gives_way = [lane is Lane.LONG for lane in lanes]
        children = start_alike(_PROGRAM, gives_way)
        self._lanes = {}
        for lane, child, gives in zip(lanes, children, gives_way, strict=True):
            self._lanes[lane] = _Worker(lane.name.lower(), description, child, gives_way=gives)

    def submit(self, lane: Lane, job: ServiceCall, most: int) -> None:
        """Submit a job; it is refused at once if `most` jobs are pending."""
        self._lanes[lane].submit(job, most)

    def report(self) -> list[StatusEntry]:
        """Diagnostics of the processes by lane, with warnings of replaced ones."""
        return [worker.report() for worker in self._lanes.values()]

    def close(self) -> None:
        """End the processes; pending jobs are refused."""
        for worker in self._lanes.values():
            worker.stop()
        for worker in self._lanes.values():
            worker.join()


class _Worker:
    """One process and its thread."""

    def __init__(
        self, name: str, description: RobotDescription, child: Child, *, gives_way: bool
    ) -> None:
        self._name, self._description, self._gives_way = name, description, gives_way
        # Jobs and ended processes; None: end of the queue.
        self._jobs: queue.SimpleQueue[ServiceCall | Process | None]
        self._jobs = queue.SimpleQueue()
        self._ends = 0  # number of ended processes, by death or timeout
        self._reported_ends = 0
        self._early_ends = 0  # consecutive early failures
        self._stopping = False
        self._begin(child)
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
        words = f"process {self._process.pid or 'not there yet'}, {self._jobs.qsize()} calls wait"
        if self._ends:
            words = f"{words}, ended {self._ends} times and was replaced"
        return StatusEntry(self._name, words, level)

    def stop(self) -> None:
        self._stopping = True
        self._jobs.put(None)
        self._process.kill()  # it has no data to save

    def join(self) -> None:
        self._thread.join(_END_TIMEOUT)
        with suppress(subprocess.TimeoutExpired):  # it ends with the node at the latest
            self._process.wait(_END_TIMEOUT)
        self._connection.close()

    def _begin(self, child: Child) -> None:
        self._process, self._connection = child
        self._fresh = True
        self._started = time.monotonic()
        watch = threading.Thread(target=self._await_end, args=(self._process,), daemon=True)
        watch.start()

    def _await_end(self, process: Process) -> None:
        process.wait()
        self._jobs.put(process)

    def _replace(self, ended: Process) -> None:
        """Replace an ended process, unless it was replaced already.

        After too many early failures it is replaced only at the next call.
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
        with suppress(subprocess.TimeoutExpired):  # a fork that is not there yet is killed later
            self._process.wait(_END_TIMEOUT)
        self._connection.close()
        if not self._stopping:
            self._begin(start(_PROGRAM, gives_way=self._gives_way))

    def _run(self) -> None:
        while (job := self._jobs.get()) is not None:
            if isinstance(job, ServiceCall):
                self._answer(job)
            else:
                self._replace(job)

    def _answer(self, job: ServiceCall) -> None:
        """Answer a call; it is repeated if the process ends, since calls have no side effects."""
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
