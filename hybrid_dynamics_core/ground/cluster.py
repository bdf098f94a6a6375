"""Work on a Dask cluster: pieces are handed to its workers, results come back as they are ready."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from itertools import islice
from typing import Any, Final, TypeVar

from ..errors import InputError, MissingPackageError

Piece = TypeVar("Piece")
Result = TypeVar("Result")

PATIENCE: Final = "10s"
WAITING: Final = 256  # pieces at the cluster at once


def on_cluster(
    address: str,
    work: Callable[[Piece], Result],
    pieces: Iterable[tuple[int, Piece]],
    tries: int,
) -> Iterator[tuple[int, Result | Exception]]:
    """Results of pieces by number, in any order; an exception where a worker failed.

    Args:
        address: of the scheduler.
        work: a function of a module that the workers have too.
        pieces: numbered pieces; they are taken as workers become free.
        tries: attempts for each piece, since a worker may be lost.

    Raises:
        MissingPackageError: dask is not installed.
        InputError: the scheduler does not respond.
    """
    try:
        import distributed  # noqa: PLC0415 - an extra
    except ImportError as error:
        raise MissingPackageError("distributed", "dask", "clusters") from error
    try:
        client = distributed.Client(address, timeout=PATIENCE)
    except (OSError, ValueError, TimeoutError) as error:
        raise InputError(f"scheduler {address}: {error}") from error
    with client:
        numbers: dict[Any, int] = {}
        remaining = iter(pieces)

        def submitted(count: int) -> list[Any]:
            futures: list[Any] = []
            for number, piece in islice(remaining, count):
                future = client.submit(work, piece, pure=False, retries=tries)
                numbers[future] = number
                futures.append(future)
            return futures

        waiting = distributed.as_completed(submitted(WAITING))
        for done in waiting:
            number = numbers.pop(done)
            if done.status == "finished":
                yield number, done.result()
            else:
                yield number, done.exception()
            waiting.update(submitted(1))
