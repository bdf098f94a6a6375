"""Trajectories between processes, as columns of numbers.

Pickling message objects holds the GIL for all points, for a second or more with ten thousands of
them. Meanwhile no input would be answered. Loops in Python release it in between.
"""

from __future__ import annotations

import gc
from array import array
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing.reduction import ForkingPickler
from typing import Any, Final, NamedTuple

from builtin_interfaces.msg import Duration
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

_FIELDS: Final = ("positions", "velocities", "accelerations", "effort")
_DOUBLE: Final = 8  # bytes
Rebuild = Callable[["Columns"], JointTrajectory]


class Columns(NamedTuple):
    """Trajectory as columns of numbers.

    Attributes:
        header: header of the message.
        names: names of the joints.
        seconds, nanoseconds: time of each point, as integers of four bytes.
        lengths: lengths of the arrays of each point, field after field, as integers of four bytes.
        numbers: all entries, field after field, as doubles.
    """

    header: Any
    names: list[str]
    seconds: bytes
    nanoseconds: bytes
    lengths: tuple[bytes, ...]
    numbers: tuple[bytes, ...]


def columns_of(message: JointTrajectory) -> Columns:
    """The columns of a message."""
    seconds, nanoseconds = array("i"), array("I")
    lengths = [array("I") for _ in _FIELDS]
    numbers = [bytearray() for _ in _FIELDS]
    for point in message.points:
        seconds.append(point.time_from_start.sec)
        nanoseconds.append(point.time_from_start.nanosec)
        for k, name in enumerate(_FIELDS):
            values = getattr(point, name)
            lengths[k].append(len(values))
            numbers[k] += values  # the bytes of an array of doubles
    return Columns(
        header=message.header,
        names=list(message.joint_names),
        seconds=seconds.tobytes(),
        nanoseconds=nanoseconds.tobytes(),
        lengths=tuple(column.tobytes() for column in lengths),
        numbers=tuple(map(bytes, numbers)),
    )


def message_of(columns: Columns) -> JointTrajectory:
    """The message of columns."""
    message = JointTrajectory(header=columns.header, joint_names=columns.names)
    points = message.points
    ends = [0] * len(_FIELDS)
    lengths = [array("I", column) for column in columns.lengths]
    times = zip(array("i", columns.seconds), array("I", columns.nanoseconds), strict=True)
    with _no_collection():
        for number, (sec, nanosec) in enumerate(times):
            point = JointTrajectoryPoint(time_from_start=Duration(sec=sec, nanosec=nanosec))
            for k, name in enumerate(_FIELDS):
                begin = ends[k]
                ends[k] = begin + _DOUBLE * lengths[k][number]
                setattr(point, name, array("d", columns.numbers[k][begin : ends[k]]))
            points.append(point)
    return message


@contextmanager
def _no_collection() -> Iterator[None]:
    """Context without garbage collection, which holds the GIL longer the more points there are."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


def _reduced(message: JointTrajectory) -> tuple[Rebuild, tuple[Columns]]:
    return message_of, (columns_of(message),)


def send_as_columns() -> None:
    """Register columns as the pickled form of trajectories."""
    ForkingPickler.register(JointTrajectory, _reduced)
