"""Recognition of the parts of one recording, by names and times of files."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Final

from hybrid_dynamics_core.ground.file_kinds import STORAGE_SUFFIXES, storage_suffix

_PART: Final = re.compile(r"(.+)_(\d+)")  # names of parts by `ros2 bag record`
_OVERLAP: Final = 10**9  # [ns] largest overlap of consecutive parts
_MAX_PAUSE: Final = 10 * 10**9  # [ns] largest gap between consecutive parts

Span = tuple[int, int]  # first and last log time [ns]
SpanOf = Callable[[Path], Span | None]


@dataclass(frozen=True)
class PartName:
    """The name of a file: `recording_3.mcap.zstd` is part 3 of `recording`.

    Attributes:
        stem: common part of the names.
        number: number of the part; -1 if the name has none.
    """

    stem: str
    number: int


def part_name(path: Path) -> PartName:
    """Stem and number of a file's name."""
    name = path.name.removesuffix(".zstd")
    for suffix in STORAGE_SUFFIXES:
        name = name.removesuffix(suffix)
    match = _PART.fullmatch(name)
    if match is None:
        return PartName(name, -1)
    return PartName(match[1], int(match[2]))


def recording_files(folder: Path) -> list[Path]:
    """The files of recordings in a folder, with parts in the order of their numbers."""
    files = [file for file in folder.iterdir() if file.is_file() and storage_suffix(file)]

    def key(path: Path) -> tuple[str, int, str]:
        part = part_name(path)
        return part.stem, part.number, path.name

    return sorted(files, key=key)


def are_one_recording(folder: Path, files: Sequence[Path], span_of: SpanOf) -> bool:
    """Whether files without metadata are parts of one recording.

    They are if all are named after the folder. They are also if all have another common name,
    numbers, and consecutive times.

    Args:
        folder: their folder.
        files: the files, in the order of their numbers.
        span_of: function from a file to its first and last log time [ns]; None if it cannot be
            read.
    """
    if len(files) < 2:
        return bool(files)
    parts = [part_name(file) for file in files]
    if len({part.stem for part in parts}) > 1:
        return False
    numbers = [part.number for part in parts]
    if len(set(numbers)) < len(numbers):
        return False
    if parts[0].stem == folder.resolve().name:
        return True
    return _follow_each_other(numbers, [span_of(file) for file in files])


def missing_parts(files: Sequence[Path]) -> list[str]:
    """Names of parts that are missing between existing ones."""
    names = []
    for before, after in pairwise(files):
        first, last = part_name(before), part_name(after)
        if first.stem != last.stem or not 0 <= first.number < last.number - 1:
            continue
        name = f"{first.stem}_{first.number + 1}"
        if last.number - first.number > 2:
            name += f" to {first.stem}_{last.number - 1}"
        names.append(name)
    return names


def _follow_each_other(numbers: Sequence[int], spans: Sequence[Span | None]) -> bool:
    """Whether each part begins approximately at the end of the previous one."""
    readable = [(number, span) for number, span in zip(numbers, spans, strict=True) if span]
    longest = max((last - first for _, (first, last) in readable), default=0)
    for (number, (_, end)), (later_number, (begin, _)) in pairwise(readable):
        missing = later_number - number - 1
        pause = begin - end
        if not -_OVERLAP <= pause <= _MAX_PAUSE + 2 * missing * longest:
            return False
    return True
