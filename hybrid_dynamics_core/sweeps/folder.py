"""The folder of a study: what it is, and a file for each chunk that is done.

A file that is there is whole. Its name has the digest of the study, so that it is of no other.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any, Final, Literal, get_args

import numpy as np

from ..errors import InputError, MissingPackageError
from ..ground.atomic_files import atomic_file
from ..ground.suggestions import suggestion
from .study import Column, Study, described

Format = Literal["csv", "parquet"]
FORMATS: Final[tuple[Format, ...]] = get_args(Format)
STUDY: Final = "study.json"
TABLE: Final = "results.csv"
Columns = Mapping[str, Column]


class StudyFolder:
    """The folder of a study.

    Attributes:
        path: the folder.
        format: of the files: `csv` or `parquet`.
    """

    def __init__(self, path: str | Path, study: Study, file_format: str, overwrite: bool) -> None:
        """Open the folder, or make it.

        Args:
            path: the folder.
            study: the study.
            file_format: `csv` or `parquet`.
            overwrite: whether to remove the results of another study.

        Raises:
            InputError: the folder has another study, or something else, or cannot be written.
            MissingPackageError: Parquet needs pyarrow.
        """
        self.path = Path(path)
        self.format = _format(file_format)
        self._study = study
        self._mark = study.digest[:12]
        place = self.path / STUDY
        content = {**described(study), "format": self.format}
        if self.path.exists() and not self.path.is_dir():
            raise InputError(f"{path}: is a file; expected a folder for the results")
        if place.exists():
            _require_same(place, content, overwrite=overwrite)
        elif self.path.is_dir() and any(self.path.iterdir()):
            raise InputError(f"{path}: has other files and no study; name a new or empty folder")
        if not self.path.parent.is_dir():
            raise InputError(f"{path}: there is no folder {self.path.parent}")
        try:
            self._begin(json.dumps(content, indent=2).encode() + b"\n", overwrite=overwrite)
        except OSError as error:
            problem = error.strerror or error
            raise InputError(
                f"{path}: cannot be written: {problem}; name another folder"
            ) from error

    def _begin(self, content: bytes, *, overwrite: bool) -> None:
        """Make the folder with the file of the study."""
        self.path.mkdir(exist_ok=True)
        if overwrite:
            for old in self.path.glob("part-*"):
                old.unlink()
            (self.path / TABLE).unlink(missing_ok=True)
        _write(self.path / STUDY, content)

    def part(self, chunk: int) -> Path:
        """The file of a chunk."""
        return self.path / f"part-{chunk:06d}-{self._mark}.{self.format}"

    def missing(self, chunks: int) -> list[int]:
        """The chunks that have no file, or one that lacks rows."""
        there = {path.name for path in self.path.glob(f"part-*-{self._mark}.{self.format}")}
        rows_of = _ROWS[self.format]
        missing: list[int] = []
        for chunk in range(chunks):
            part = self.part(chunk)
            if part.name not in there or rows_of(part) != self._study.rows(chunk):
                missing.append(chunk)
        return missing

    def write(self, chunk: int, columns: Columns) -> None:
        """Write the file of a chunk."""
        _write(self.part(chunk), _WRITERS[self.format](columns))

    def join(self, chunks: int) -> None:
        """Join all files of CSV to one table."""
        if self.format != "csv":
            return
        with atomic_file(self.path / TABLE, is_durable=True) as new, new.open("wb") as file:
            for chunk in range(chunks):
                header, _, rows = self.part(chunk).read_bytes().partition(b"\n")
                if not chunk:
                    file.write(header + b"\n")
                file.write(rows)


def read_results(path: str | Path) -> dict[str, Column]:
    """The columns (N,) of all chunks that are done, in the order of the designs.

    Args:
        path: the folder of a study.

    Raises:
        InputError: it is no folder of a study, or has no results yet.
        MissingPackageError: Parquet needs pyarrow.
    """
    place = Path(path) / STUDY
    if not place.is_file():
        raise InputError(f"{path}: has no {STUDY}; expected the folder of a study")
    content = _read(place)
    mark, suffix = content["digest"][:12], content["format"]
    files = sorted(Path(path).glob(f"part-*-{mark}.{suffix}"))
    if not files:
        raise InputError(f"{path}: has no results yet")
    parts = [_read_part(file, suffix) for file in files]
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def _read_part(file: Path, suffix: Format) -> dict[str, Column]:
    """The columns of a chunk. Raises InputError if its file is damaged."""
    try:
        return _READERS[suffix](file)
    except (ValueError, OSError) as error:  # also those of pyarrow
        raise InputError(
            f"{file}: is damaged; give the study again with this folder, which computes this chunk"
            " anew"
        ) from error


def _write(path: Path, content: bytes) -> None:
    with atomic_file(path, is_durable=True) as new:
        new.write_bytes(content)


def _require_same(place: Path, content: Mapping[str, Any], *, overwrite: bool) -> None:
    """Raise InputError if the folder has another study."""
    before = _read(place)
    if before == content or overwrite:
        return
    changed = _changes(before, content)
    raise InputError(
        f"{place.parent}: has the results of another study; changed: {', '.join(changed)}; name"
        " another folder, or give overwrite to begin anew"
    )


def _read(place: Path) -> Any:
    try:
        content = json.loads(place.read_text(encoding="utf-8"))
        content["digest"], content["digests"], content["format"]
    except (ValueError, TypeError, KeyError) as error:
        raise InputError(f"{place}: is not the file of a study") from error
    return content


def _changes(before: Mapping[str, Any], content: Mapping[str, Any]) -> list[str]:
    """What differs between two studies."""
    parts = dict(before["digests"])
    changed = [name for name, value in content["digests"].items() if parts.get(name) != value]
    if before["format"] != content["format"]:
        changed.append("format")
    return changed or ["the file of the study"]


def _format(name: str) -> Format:
    for one in FORMATS:
        if name == one:
            return one
    listed = ", ".join(FORMATS)
    raise InputError(f"format: no '{name}'{suggestion(name, FORMATS)}; expected one of {listed}")


# -- formats


def _csv(columns: Columns) -> bytes:
    cells: list[Sequence[str]] = []
    for column in columns.values():
        values = column.tolist()
        cells.append(values if column.dtype.kind == "U" else list(map(repr, values)))
    rows = [",".join(row) for row in zip(*cells, strict=True)]
    return "\n".join([",".join(columns), *rows, ""]).encode()


def _read_csv(path: Path) -> dict[str, Column]:
    with path.open(encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    columns: dict[str, Column] = {}
    for name, cells in zip(header, zip(*rows, strict=True), strict=True):
        if name == "status":
            columns[name] = np.array(cells)
        elif name == "design":
            columns[name] = np.array(list(map(int, cells)))
        else:
            columns[name] = np.array(list(map(float, cells)))
    return columns


def _rows_of_csv(path: Path) -> int:
    """Number of rows; -1 if the last one is not whole."""
    content = path.read_bytes()
    if not content.endswith(b"\n"):
        return -1
    return content.count(b"\n") - 1


def _rows_of_parquet(path: Path) -> int:
    """Number of rows; -1 if the file is not whole."""
    _, parquet = _pyarrow()
    try:
        return int(parquet.read_metadata(path).num_rows)
    except (ValueError, OSError):  # also those of pyarrow
        return -1


def _parquet(columns: Columns) -> bytes:
    arrow, parquet = _pyarrow()
    buffer = BytesIO()
    parquet.write_table(arrow.table(dict(columns)), buffer)
    return buffer.getvalue()


def _read_parquet(path: Path) -> dict[str, Column]:
    _, parquet = _pyarrow()
    table = parquet.read_table(path)
    columns: dict[str, Column] = {}
    for name in table.column_names:
        values = table.column(name).to_numpy()
        columns[name] = values.astype(str) if values.dtype == object else values
    return columns


def _pyarrow() -> tuple[Any, Any]:
    try:
        import pyarrow as arrow  # noqa: PLC0415 - an extra
        from pyarrow import parquet  # noqa: PLC0415
    except ImportError as error:
        raise MissingPackageError("pyarrow", "parquet", "tables in Parquet") from error
    return arrow, parquet


_WRITERS: Final[Mapping[str, Callable[[Columns], bytes]]] = {"csv": _csv, "parquet": _parquet}
_ROWS: Final[Mapping[str, Callable[[Path], int]]] = {
    "csv": _rows_of_csv,
    "parquet": _rows_of_parquet,
}
_READERS: Final[Mapping[str, Callable[[Path], dict[str, Column]]]] = {
    "csv": _read_csv,
    "parquet": _read_parquet,
}
