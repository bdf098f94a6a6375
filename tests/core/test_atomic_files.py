"""Files that are written appear whole, or stay as they were."""

from __future__ import annotations

from pathlib import Path

import pytest

from hybrid_dynamics_core.ground.atomic_files import atomic_file


@pytest.mark.parametrize("is_durable", [False, True])
def test_a_file_is_replaced_at_the_end_alone(tmp_path: Path, is_durable: bool) -> None:
    path = tmp_path / "table.csv"
    path.write_text("old")
    with atomic_file(path, is_durable=is_durable) as new:
        assert new.suffix == ".csv"
        new.write_text("half of it")
        assert path.read_text() == "old"
        new.write_text("new")
    assert path.read_text() == "new"
    assert list(tmp_path.iterdir()) == [path]


def write_half(path: Path, error: type[BaseException]) -> None:
    with atomic_file(path) as new:
        new.write_text("half of it")
        raise error


@pytest.mark.parametrize("error", [OSError, KeyboardInterrupt])
def test_nothing_is_left_of_a_file_that_fails(tmp_path: Path, error: type[BaseException]) -> None:
    path = tmp_path / "table.csv"
    path.write_text("old")
    with pytest.raises(error):
        write_half(path, error)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_writers_of_the_same_file_do_not_meet(tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    with atomic_file(path) as first, atomic_file(path) as second:
        assert first != second
        first.write_text("first")
        second.write_text("second")
    assert path.read_text() == "first"


def test_others_may_read_a_file_as_the_user_sets(tmp_path: Path) -> None:
    plain, replaced = tmp_path / "plain", tmp_path / "replaced"
    plain.write_text("")
    with atomic_file(replaced) as new:
        new.write_text("")
    assert replaced.stat().st_mode == plain.stat().st_mode
