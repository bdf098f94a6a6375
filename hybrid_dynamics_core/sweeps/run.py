"""Computation of a study: in threads here, or on a Dask cluster; it goes on where it stopped."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Final

import numpy as np

from ..errors import HybridDynamicsError
from ..ground.arrays import Array
from ..ground.check_arguments import integer
from ..ground.cluster import on_cluster
from ..ground.progress import Progress
from .folder import StudyFolder
from .study import Column, Study, Work, computed

TRIES: Final = 2  # attempts for each chunk on a cluster
AHEAD: Final = 2  # chunks that wait for each thread

Piece = tuple[Work, Array]
Results = dict[str, Column]


class StoppedStudyError(HybridDynamicsError):
    """A chunk could not be computed; the others are kept."""


@dataclass(frozen=True)
class Swept:
    """A study that is done.

    Attributes:
        folder: the folder of its results.
        designs: number of designs.
        computed: number of those that this call computed; the others were there.
    """

    folder: Path
    designs: int
    computed: int


def sweep(study: Study, threads: int = 1, shown: bool | None = None) -> Results:
    """The columns (N,) of all designs, in memory.

    Args:
        study: the study.
        threads: number of threads.
        shown: whether to show progress; None: on terminals, for long runs.
    """
    parts: dict[int, Results] = {}
    with Progress(f"designs of {study.robot.name}", study.chunks, shown) as progress:
        pieces = _pieces(study, range(study.chunks))
        for chunk, columns in _in_threads(integer("threads", threads), computed, pieces):
            parts[chunk] = _numbered(study, chunk, columns)
            progress.update(len(parts))
    ordered = [parts[chunk] for chunk in range(study.chunks)]
    return {name: np.concatenate([part[name] for part in ordered]) for name in ordered[0]}


def sweep_into(  # noqa: PLR0913 - where and how to compute
    study: Study,
    folder: str | Path,
    *,
    threads: int = 1,
    scheduler: str | None = None,
    file_format: str = "csv",
    overwrite: bool = False,
    shown: bool | None = None,
) -> Swept:
    """Compute what a folder does not have yet of a study.

    A call that was stopped goes on where it was, with the same study.

    Args:
        study: the study.
        folder: the folder of its results; it may be new.
        threads: number of threads of this process.
        scheduler: address of a Dask scheduler; its workers compute, this process writes.
        file_format: `csv`, or `parquet` (the extra of that name).
        overwrite: whether to remove the results of another study, and begin anew.
        shown: whether to show progress; None: on terminals, for long runs.

    Raises:
        InputError: the folder has another study, or the scheduler does not respond.
        StoppedStudyError: a worker failed repeatedly; what is done is kept.
    """
    place = StudyFolder(folder, study, file_format, overwrite)
    missing = place.missing(study.chunks)
    pieces = _pieces(study, missing)
    if scheduler is None:
        results = _in_threads(integer("threads", threads), computed, pieces)
    else:
        results = _from_cluster(scheduler, pieces)
    done = study.chunks - len(missing)
    count = 0
    with Progress(f"designs of {study.robot.name}", study.chunks, shown) as progress:
        for chunk, columns in results:
            numbered = _numbered(study, chunk, columns)
            place.write(chunk, numbered)
            count += len(numbered["design"])
            done += 1
            progress.update(done)
    place.join(study.chunks)
    return Swept(place.path, study.space.count, count)


def _pieces(study: Study, chunks: Sequence[int]) -> Iterator[tuple[int, Piece]]:
    for chunk in chunks:
        yield chunk, (study.work, study.values(chunk))


def _numbered(study: Study, chunk: int, columns: Results) -> Results:
    """The columns with the numbers of the designs."""
    first = chunk * study.chunk
    count = len(columns["status"])
    return {"design": np.arange(first, first + count), **columns}


def _in_threads(
    threads: int, work: Callable[[Piece], Results], pieces: Iterable[tuple[int, Piece]]
) -> Iterator[tuple[int, Results]]:
    """Results of pieces by number, in any order; few pieces wait at a time."""
    remaining = iter(pieces)
    waiting: dict[Future[Results], int] = {}
    pool = ThreadPoolExecutor(threads, thread_name_prefix="sweep")
    try:
        while True:
            for chunk, piece in islice(remaining, AHEAD * threads - len(waiting)):
                waiting[pool.submit(work, piece)] = chunk
            if not waiting:
                return
            finished, _ = wait(waiting, return_when=FIRST_COMPLETED)
            for future in finished:
                yield waiting.pop(future), future.result()
    finally:
        pool.shutdown(cancel_futures=True)


def _attempt(piece: Piece) -> Results | HybridDynamicsError:
    """The columns of a piece, or an error that further attempts would have too."""
    try:
        return computed(piece)
    except HybridDynamicsError as error:
        return error


def _from_cluster(
    scheduler: str, pieces: Iterable[tuple[int, Piece]]
) -> Iterator[tuple[int, Results]]:
    """Results of pieces from a cluster.

    Raises:
        StoppedStudyError: a chunk failed.
    """
    for chunk, result in on_cluster(scheduler, _attempt, pieces, TRIES):
        if isinstance(result, HybridDynamicsError):
            raise result
        if isinstance(result, Exception):
            raise StoppedStudyError(
                f"chunk {chunk}: its worker failed: {result}; what is done is kept, and the same"
                " call goes on there"
            )
        yield chunk, result
