"""Export of topics to tables: a row for each message, a column for each number."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from hybrid_dynamics_core.ground.atomic_files import atomic_file
from hybrid_dynamics_core.ground.progress import Progress
from hybrid_dynamics_core.ground.suggestions import suggestion

from ...messages.cdr import NS
from ..errors import BagCallError, BagError
from ..storage.bag_reader import BagReader
from .topic_types import Decode, UnknownTypeError, decoder_of

FORMATS: Final = ("csv", "parquet", "npz")
# Fields with names for the entries of other fields.
_NAME_FIELDS: Final[tuple[str, ...]] = ("name", "loops", "pins", "stroke_joints", "joint_names")
_STROKE_FIELDS: Final = ("to_lower", "to_upper")  # their entries are named by `stroke_joints`
_UPDATE: Final = 256  # messages between two updates of the progress
_LOG_TIME: Final = "log_ns"

Columns = dict[str, list[Any]]


def flatten(message: Any) -> dict[str, Any]:
    """Flatten a message to numbers and texts by path.

    Entries of arrays have the names that the message gives them. Stamps become nanoseconds.
    """
    return dict(_flatten(message, "", ()))


def _flatten(value: Any, path: str, names: tuple[str, ...]) -> Iterator[tuple[str, Any]]:
    """Paths and values.

    Args:
        value: a part of a message.
        path: path of the part.
        names: names of its entries, if it is an array.
    """
    if hasattr(value, "nanosec"):
        yield f"{path}_ns", int(value.sec) * NS + int(value.nanosec)
    elif is_dataclass(value):
        yield from _flatten_fields(value, path)
    elif isinstance(value, (list, tuple, np.ndarray)):
        for k, entry in enumerate(value):
            label = names[k] if k < len(names) else k
            yield from _flatten(entry, f"{path}[{label}]", ())
    elif isinstance(value, np.generic):
        yield path, value.item()
    else:
        yield path, value


def _flatten_fields(message: Any, path: str) -> Iterator[tuple[str, Any]]:
    names = [entry.name for entry in fields(message) if entry.name != "__msgtype__"]
    parts = {name: getattr(message, name) for name in names}
    prefix = f"{path}." if path else ""
    for name, part in parts.items():
        if name not in _NAME_FIELDS:
            yield from _flatten(part, prefix + name, _entry_names(parts, name))


def _entry_names(parts: Mapping[str, Any], name: str) -> tuple[str, ...]:
    """Names in a message for the entries of one of its fields."""
    size = _size(parts[name])
    candidates = _NAME_FIELDS
    if name in _STROKE_FIELDS:
        candidates = ("stroke_joints", *_NAME_FIELDS)
    for candidate in candidates:
        if candidate in parts and len(parts[candidate]) == size:
            return tuple(parts[candidate])
    return ()


def _size(value: Any) -> int:
    return len(value) if isinstance(value, (list, tuple, np.ndarray)) else -1


def table_file(folder: Path, topic: str, kind: str) -> Path:
    """Path of the table of a topic."""
    return folder / f"{topic.strip('/').replace('/', '.')}.{kind}"


def export(
    path: Path, target: Path, kind: str, topics: tuple[str, ...] = (), *, overwrite: bool = False
) -> tuple[dict[str, int], list[str]]:
    """Write a file for each topic into a folder.

    Args:
        path: the bag.
        target: the folder.
        kind: one of `FORMATS`.
        topics: names of the topics; empty: all.
        overwrite: whether files of the same names are replaced. Other files stay.

    Returns:
        Number of messages by topic, and texts on parts that could not be read.

    Raises:
        BagCallError: a topic is missing, or the folder is not empty.
        BagError: the format needs a package that is not installed.
    """
    _require_folder(target, overwrite=overwrite)
    with BagReader(path) as source:
        tables = _tables(source, _exported_topics(source, topics))
        losses = source.losses.describe()
    target.mkdir(parents=True, exist_ok=True)
    for name, columns in tables.items():
        file = table_file(target, name, kind)
        with atomic_file(file) as new:
            _WRITERS[kind](new, columns)
    return {name: len(columns[_LOG_TIME]) for name, columns in tables.items()}, losses


def _require_folder(target: Path, *, overwrite: bool) -> None:
    """Check that tables can be written to a folder; raises BagCallError."""
    if target.exists() and not target.is_dir():
        raise BagCallError(f"{target}: is a file; name a folder")
    if not overwrite and target.is_dir() and any(target.iterdir()):
        raise BagCallError(
            f"{target}: there is something in it already, and tables of two bags would mix; name a"
            " new folder, or give --overwrite to replace the files of the same names"
        )


def _exported_topics(source: BagReader, names: tuple[str, ...]) -> dict[str, Decode]:
    """Decoders of the requested topics that can be decoded; raises BagCallError."""
    for name in names:
        if name not in source.topics:
            hint = suggestion(name, source.topics)
            raise BagCallError(
                f"{source.path}: no topic {name}{hint}; there are: {', '.join(source.topics)}"
            )
    exported: dict[str, Decode] = {}
    for name, topic in source.topics.items():
        if names and name not in names:
            continue
        try:
            decode, problem = decoder_of(topic)
        except UnknownTypeError as error:
            source.losses.add(f"{name}: {error}; it is left out")
            continue
        exported[name] = decode
        if problem:
            source.losses.add(f"{name}: {problem}")
    return exported


def _tables(source: BagReader, topics: Mapping[str, Decode]) -> dict[str, Columns]:
    """Columns of each topic."""
    tables: dict[str, Columns] = {}
    total = sum(source.topics[name].message_count or 0 for name in topics)
    with Progress(source.path.name, total or 1) as progress:
        done = 0
        for name, messages in source.read(frozenset(topics)):
            columns = tables.setdefault(name, {_LOG_TIME: []})
            for log_ns, data in messages.raw():
                try:
                    message = topics[name](data)
                except Exception as error:  # noqa: BLE001 - whatever rosbags meets in damaged bytes
                    source.losses.add(
                        f"{name}: the message logged at {log_ns} ns is none ({error})"
                    )
                    continue
                _append(columns, {_LOG_TIME: log_ns, **flatten(message)})
                done += 1
                if done % _UPDATE == 0:
                    progress.update(done)
    return tables


def _append(columns: Columns, values: Mapping[str, Any]) -> None:
    """Append a row; missing values are None."""
    count = len(columns[_LOG_TIME])
    for name, value in values.items():
        columns.setdefault(name, [None] * count).append(value)
    for column in columns.values():
        if len(column) == count:
            column.append(None)


def _write_csv(path: Path, columns: Columns) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(zip(*columns.values(), strict=True))


def _write_npz(path: Path, columns: Columns) -> None:
    arrays: dict[str, Any] = {name: _array_of(values) for name, values in columns.items()}
    with path.open("wb") as file:
        np.savez_compressed(file, **arrays)


def _array_of(values: list[Any]) -> Any:
    """A column as an array; missing values are an empty text or NaN."""
    if any(isinstance(value, str) for value in values):
        return np.array(["" if value is None else str(value) for value in values])
    if all(isinstance(value, int) for value in values):
        return np.array(values)
    return np.array(values, dtype=np.float64)  # None becomes NaN


def _write_parquet(path: Path, columns: Columns) -> None:
    try:
        import pyarrow as pa  # noqa: PLC0415 - an extra
        from pyarrow import parquet  # noqa: PLC0415
    except ModuleNotFoundError as error:
        raise BagError("parquet needs pyarrow: pip install pyarrow") from error
    parquet.write_table(pa.table(columns), path)


_WRITERS: Final[dict[str, Callable[[Path, Columns], None]]] = {
    "csv": _write_csv,
    "npz": _write_npz,
    "parquet": _write_parquet,
}
