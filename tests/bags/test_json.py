"""Every verb of `bag` as programs call it.

JSON on the output, losses in it and in the exit code.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from hybrid_dynamics_cli.exit_codes import LOST
from tests.bags.calling import printed

pytestmark = pytest.mark.usefixtures("python_kernels")


def told(*arguments: object, code: int = 0) -> dict[str, Any]:
    answer: dict[str, Any] = json.loads(printed(*arguments, "--json", code=code))
    return answer


def make(path: Path, rate: int) -> dict[str, Any]:
    return told(
        "make",
        path,
        "--robot",
        "five_bar",
        "--seconds",
        5,
        "--rate",
        rate,
        "--noise",
        "effort=0.01",
    )


def test_what_is_made_processed_exported_and_reported_is_told(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    recording = tmp_path / "recording"
    answer = make(recording, 50)
    assert answer == {
        "bag": str(recording),
        "topic": "/hybrid_dynamics/active_joint_states",
        "messages": 250,
    }
    results, tables, page = tmp_path / "results", tmp_path / "tables", tmp_path / "page.html"
    (bag,) = told("process", recording, results, "--robot", "five_bar")["bags"]
    assert bag["failed"] is None
    assert bag["samples"] == 250
    assert bag["target"] == str(results)
    rows = told("export", results, tables, "--topic", "/hybrid_dynamics/required_efforts")["rows"]
    assert list(rows) == ["/hybrid_dynamics/required_efforts"]
    assert 0 < rows["/hybrid_dynamics/required_efforts"] <= 250
    report = told("report", recording, "--robot", "five_bar", "--output", page)
    assert (report["received"], report["losses"]) == (250, [])
    assert page.is_file()


def test_a_bag_that_fails_is_told_with_1(tmp_path: Path) -> None:
    (tmp_path / "none.mcap").write_bytes(b"no recording")
    (bag,) = told(
        "process", tmp_path / "none.mcap", tmp_path / "results", "--robot", "excavator", code=1
    )["bags"]
    assert "none.mcap" in bag["failed"]


def test_losses_are_told_with_3(tmp_path: Path) -> None:
    """One byte of a chunk turned.

    The other chunk is identified from, and the loss is in answer and exit code.
    """
    make(tmp_path / "recording", 2000)  # two chunks
    (source,) = (tmp_path / "recording").glob("*.mcap")
    data = bytearray(source.read_bytes())
    data[len(data) // 3] ^= 0xFF
    damaged = tmp_path / "damaged.mcap"
    damaged.write_bytes(data)
    answer = told("identify", damaged, "--robot", "five_bar", code=LOST)
    assert ["is lost: its checksum differs" in loss for loss in answer["losses"]] == [True, False]
    assert answer["base"]
