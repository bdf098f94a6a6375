"""Results in a file, so that a long comparison can go on where it was ended."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

from .sides import Reached
from .turns import Result


def kept(path: Path | None) -> dict[str, list[Result]]:
    """Results by problem; none without a file."""
    if path is None or not path.exists():
        return {}
    rows: dict[str, list[Result]] = {}
    for name, results in json.loads(path.read_text(encoding="utf-8")).items():
        rows[name] = []
        for fields in results:
            fields["best"] = Reached(*fields["best"])
            rows[name].append(Result(**fields))
    return rows


def keep(path: Path | None, rows: Mapping[str, Sequence[Result]]) -> None:
    """Write all results."""
    if path is not None:
        text = {name: [asdict(result) for result in results] for name, results in rows.items()}
        path.write_text(json.dumps(text), encoding="utf-8")
