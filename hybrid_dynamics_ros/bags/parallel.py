"""Processing of several bags: in order, in processes of this machine, or on a Dask cluster.

The results are the same in all cases.
"""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from functools import partial
from typing import Final

from hybrid_dynamics_core.errors import HybridDynamicsError, InputError, MissingPackageError
from hybrid_dynamics_core.ground.cluster import on_cluster
from hybrid_dynamics_core.ground.progress import Progress

from ..parameters import ParameterError
from .errors import BagCallError, BagError
from .job import Job, Outcome
from .process import process

TRIES: Final = 2  # attempts for each bag, since a worker may be lost


class WrongCall(str):
    """The text of a failure that is caused by wrong arguments."""

    __slots__ = ()


Result = Outcome | str  # an outcome, or the text of a failure
_Runner = Callable[[Sequence[Job], Sequence[int]], Iterator[tuple[int, Result]]]


def run_jobs(jobs: Sequence[Job], processes: int = 1, scheduler: str | None = None) -> list[Result]:
    """Run jobs; returns outcomes in their order, or the text of a repeated failure.

    Args:
        jobs: the jobs.
        processes: number of parallel processes.
        scheduler: address of a Dask scheduler whose workers have access to the same files.

    Raises:
        BagError: dask is not installed.
        BagCallError: the scheduler does not respond.
    """
    if scheduler is not None:
        return _run_beside(jobs, partial(_on_cluster, scheduler))
    if processes == 1 or len(jobs) == 1:
        return [attempt(job, shown=None) for job in jobs]
    return _run_beside(jobs, partial(_in_processes, processes))


def attempt(job: Job, shown: bool | None = False) -> Result:
    """Run one job; returns its outcome or the text of its failure.

    Args:
        job: the job.
        shown: whether to show progress; None: on terminals.
    """
    try:
        return process(job, shown)
    except InputError as error:
        return WrongCall(error)
    except (ParameterError, HybridDynamicsError, OSError) as error:
        return str(error) or type(error).__name__


def _run_beside(jobs: Sequence[Job], run: _Runner) -> list[Result]:
    """Run jobs in other processes; failed ones are run once more."""
    results: dict[int, Result] = {}
    remaining = list(range(len(jobs)))
    with Progress("bags", len(jobs)) as progress:
        for _ in range(TRIES):
            for k, result in run(jobs, remaining):
                results[k] = result
                progress.update(sum(isinstance(entry, Outcome) for entry in results.values()))
            remaining = [k for k in remaining if not isinstance(results.get(k), Outcome)]
            if not remaining:
                break
    return [results[k] for k in range(len(jobs))]


def _in_processes(
    count: int, jobs: Sequence[Job], numbers: Sequence[int]
) -> Iterator[tuple[int, Result]]:
    """Results of some jobs by index, from processes of this machine."""
    context = multiprocessing.get_context("spawn")  # code and threads do not survive a fork
    with ProcessPoolExecutor(min(count, len(numbers)), mp_context=context) as pool:
        waiting = {pool.submit(attempt, jobs[k]): k for k in numbers}
        for done in as_completed(waiting):
            try:
                yield waiting[done], done.result()
            except BrokenProcessPool:
                yield waiting[done], "its process ended"


def _on_cluster(
    address: str, jobs: Sequence[Job], numbers: Sequence[int]
) -> Iterator[tuple[int, Result]]:
    """Results of some jobs by index, from a Dask cluster."""
    pieces = [(k, jobs[k]) for k in numbers]
    try:
        for k, result in on_cluster(address, attempt, pieces, TRIES):
            if isinstance(result, Exception):
                yield k, f"its worker failed: {result}"
            else:
                yield k, result
    except MissingPackageError as error:
        raise BagError("--scheduler needs dask: pip install 'hybrid-dynamics-ros[dask]'") from error
    except InputError as error:
        raise BagCallError(str(error)) from error
