"""Topics of a bag as tables: a row for each message, a column for each number."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from hybrid_dynamics_core.ground.progress import Progress
from hybrid_dynamics_core.ground.suggestions import suggestion

from ...messages.interfaces import typestore
from ..errors import BagCallError, BagError
from ..storage.bag_reader import BagReader

FORMATS: Final = ("csv", "parquet", "npz")
_NAMES: Final = (
    "name",
    "loops",
    "pins",
    "stroke_joints",
    "joint_names",
)  # fields that name the entries of others

Columns = dict[str, list[Any]]


def flat(message: Any) -> dict[str, Any]:
    """Numbers and texts of a message by path; entries of arrays by the names that the message gives them."""
    return dict(_flat(message, "", ()))


def _flat(value: Any, path: str, names: tuple[str, ...]) -> Iterator[tuple[str, Any]]:
    """A stamp becomes its nanoseconds."""
    if hasattr(value, "nanosec"):
        yield f"{path}_ns", int(value.sec) * 10**9 + int(value.nanosec)
    elif is_dataclass(value):
        own = {f.name: getattr(value, f.name) for f in fields(value) if f.name != "__msgtype__"}
        for name, part in own.items():
            if name not in _NAMES:
                yield from _flat(part, f"{path}.{name}" if path else name, _labels(own, name))
    elif isinstance(value, (list, tuple, np.ndarray)):
        for k, entry in enumerate(value):
            yield from _flat(entry, f"{path}[{names[k] if k < len(names) else k}]", ())
    else:
        yield path, value.item() if isinstance(value, np.generic) else value


def _labels(own: Mapping[str, Any], name: str) -> tuple[str, ...]:
    """What the message itself calls the entries of a field."""
    lists = ["stroke_joints"] if name in ("to_lower", "to_upper") else []
    for key in (*lists, *_NAMES):
        if key in own and len(own[key]) == _sized(own[name]):
            return tuple(own[key])
    return ()


def _sized(value: Any) -> int:
    return len(value) if isinstance(value, (list, tuple, np.ndarray)) else -1


def table_file(folder: Path, topic: str, kind: str) -> Path:
    """Where the table of a topic is."""
    return folder / f"{topic.strip('/').replace('/', '.')}.{kind}"


def export(
    path: Path, target: Path, kind: str, topics: tuple[str, ...] = (), *, overwrite: bool = False
) -> tuple[dict[str, int], list[str]]:
    """Write a file for each topic into a folder; how many messages each has, and what could not be read.

    overwrite: files of the same names are replaced, all else in the folder stays.

    Raises:
        BagCallError: a topic is not there, or the folder is not empty.
        BagError: the format needs what is not installed.
    """
    if target.exists() and not target.is_dir():
        raise BagCallError(f"{target}: is a file; name a folder")
    if not overwrite and target.is_dir() and any(target.iterdir()):
        raise BagCallError(
            f"{target}: there is something in it already, and tables of two bags would mix; name a"
            " new folder, or give --overwrite to replace the files of the same names"
        )
    with BagReader(path) as source:
        missing = [topic for topic in topics if topic not in source.topics]
        if missing:
            hint = suggestion(missing[0], source.topics)
            raise BagCallError(
                f"{path}: no topic {missing[0]}{hint}; there are: {', '.join(source.topics)}"
            )
        wanted = {
            name: topic for name, topic in source.topics.items() if not topics or name in topics
        }
        unknown = [t.name for t in wanted.values() if t.kind not in typestore().types]
        for name in unknown:
            source.losses.add(
                f"{name}: its type {wanted.pop(name).kind} is not known; it is left out"
            )
        tables = _tables(
            source,
            frozenset(wanted),
            {name: topic.kind for name, topic in wanted.items()},
            path.name,
        )
        losses = source.losses.describe()
    target.mkdir(parents=True, exist_ok=True)
    for name, columns in tables.items():
        file = table_file(target, name, kind)
        aside = file.with_name(f".{file.name}.part")
        _WRITERS[kind](aside, columns)
        aside.replace(file)
    return {name: len(columns["log_ns"]) for name, columns in tables.items()}, losses


def _tables(
    source: BagReader, wanted: frozenset[str], kinds: Mapping[str, str], label: str
) -> dict[str, Columns]:
    tables: dict[str, Columns] = {}
    total = sum(source.topics[name].message_count or 0 for name in wanted) or 1
    with Progress(label, total) as progress:
        done = 0
        for name, messages in source.read(wanted):
            columns = tables.setdefault(name, {"log_ns": []})
            for row in range(len(messages)):
                try:
                    message = typestore().deserialize_cdr(messages.message(row), kinds[name])
                except Exception as error:  # noqa: BLE001 - whatever the library meets in damaged bytes
                    source.losses.add(
                        f"{name}: the message logged at {messages.log_ns[row]} ns is none ({error})"
                    )
                    continue
                _append(columns, {"log_ns": int(messages.log_ns[row]), **flat(message)})
                done += 1
                if done % 256 == 0:
                    progress.update(done)
    return tables


def _append(columns: Columns, values: Mapping[str, Any]) -> None:
    before = len(columns["log_ns"])
    for name, value in values.items():
        columns.setdefault(name, [None] * before).append(value)
    for column in columns.values():
        if len(column) == before:
            column.append(None)


def _write_csv(path: Path, columns: Columns) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(zip(*columns.values(), strict=True))


def _write_npz(path: Path, columns: Columns) -> None:
    arrays: dict[str, Any] = {name: _array(values) for name, values in columns.items()}
    with path.open("wb") as file:
        np.savez_compressed(file, **arrays)


def _array(values: list[Any]) -> Any:
    if any(isinstance(value, str) for value in values):
        return np.array(["" if value is None else str(value) for value in values])
    whole = all(isinstance(value, int) for value in values)
    return (
        np.array(values)
        if whole
        else np.array([np.nan if v is None else v for v in values], dtype=np.float64)
    )


def _write_parquet(path: Path, columns: Columns) -> None:
    try:
        import pyarrow as pa  # noqa: PLC0415 - an extra
        from pyarrow import parquet  # noqa: PLC0415
    except ModuleNotFoundError as error:
        raise BagError("parquet needs pyarrow: pip install pyarrow") from error
    parquet.write_table(pa.table(columns), path)


_WRITERS: Final = {"csv": _write_csv, "npz": _write_npz, "parquet": _write_parquet}
