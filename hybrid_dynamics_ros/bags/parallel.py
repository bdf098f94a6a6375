"""Many bags: one after the other, in processes of this machine, or on a Dask cluster; the results are the same."""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from typing import Final

from hybrid_dynamics_core.errors import HybridDynamicsError, InputError
from hybrid_dynamics_core.ground.progress import Progress

from ..parameters import ParameterError
from .errors import BagCallError, BagError
from .process import Job, Outcome, process

TRIES: Final = 2  # of each bag: a worker may be lost for reasons of its own


class WrongCall(str):
    """Why there is no outcome, where the fault is in what was asked for."""

    __slots__ = ()


def run_jobs(
    jobs: Sequence[Job], processes: int = 1, scheduler: str | None = None
) -> list[Outcome | str]:
    """Outcomes in the order of the jobs; a text where a bag failed, for the second time.

    Args:
        jobs: what is to be done.
        processes: how many bags at a time.
        scheduler: address of a Dask scheduler whose workers see the same files.

    Raises:
        BagError: dask is not installed.
        BagCallError: the scheduler is not there.
    """
    found: dict[int, Outcome | str] = {}
    if scheduler is None and (processes == 1 or len(jobs) == 1):
        for k, job in enumerate(jobs):
            found[k] = attempt(job, shown=None)
        return [found[k] for k in range(len(jobs))]
    left = list(range(len(jobs)))
    with Progress("bags", len(jobs)) as progress:
        for _ in range(TRIES):
            step = (
                _in_processes(jobs, left, processes)
                if scheduler is None
                else _on_cluster(jobs, left, scheduler)
            )
            for k, result in step:
                found[k] = result
                progress.update(sum(isinstance(entry, Outcome) for entry in found.values()))
            left = [k for k in left if not isinstance(found.get(k), Outcome)]
            if not left:
                break
    return [found[k] for k in range(len(jobs))]


def attempt(job: Job, shown: bool | None = False) -> Outcome | str:
    """The outcome of one job, or why there is none."""
    try:
        return process(job, shown)
    except InputError as error:
        return WrongCall(error)
    except (ParameterError, HybridDynamicsError, OSError) as error:
        return str(error) or type(error).__name__


def _in_processes(
    jobs: Sequence[Job], which: Sequence[int], count: int
) -> Iterator[tuple[int, Outcome | str]]:
    context = multiprocessing.get_context(
        "spawn"
    )  # compiled code and threads do not outlive a fork
    with ProcessPoolExecutor(min(count, len(which)), mp_context=context) as pool:
        waiting = {pool.submit(attempt, jobs[k]): k for k in which}
        for done in as_completed(waiting):
            try:
                yield waiting[done], done.result()
            except BrokenProcessPool:
                yield waiting[done], "its process ended"


def _on_cluster(
    jobs: Sequence[Job], which: Sequence[int], address: str
) -> Iterator[tuple[int, Outcome | str]]:
    try:
        import distributed  # noqa: PLC0415 - an extra
    except ImportError as error:
        raise BagError("--scheduler needs dask: pip install 'hybrid-dynamics-ros[dask]'") from error
    try:
        client = distributed.Client(address, timeout="10s")
    except (OSError, ValueError, TimeoutError) as error:
        raise BagCallError(f"scheduler {address}: {error}") from error
    with client:
        waiting = {client.submit(attempt, jobs[k], pure=False, retries=TRIES): k for k in which}
        for done in distributed.as_completed(waiting):
            if done.status == "finished":
                yield waiting[done], done.result()
            else:
                yield waiting[done], f"its worker failed: {done.exception()}"
