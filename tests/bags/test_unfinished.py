"""sqlite3 bags whose recorder was killed: what it left beside the file is read, or told."""

from __future__ import annotations

import shutil
import sqlite3

import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin

from hybrid_dynamics_core.ground.file_kinds import BAG_METADATA
from hybrid_dynamics_ros.bags.errors import BagError
from tests.bags.messages import bag, recorded
from tests.bags.test_damage import read
from tests.sampling import swept

COUNT = 40
INSERT = "INSERT INTO messages (topic_id, timestamp, data) VALUES (1, ?, ?)"


def killed(folder, robot, count_in_file, journal="WAL", commit_every=5):
    """A bag as a killed recorder leaves it: later messages are beside the file; all messages."""
    pairs = recorded(robot, COUNT)
    source = bag(folder / "whole", pairs[: max(count_in_file, 1)], plugin=StoragePlugin.SQLITE3)
    with sqlite3.connect(source / "whole.db3") as whole:
        script = list(whole.iterdump())
    place = folder / "live.db3"
    live = sqlite3.connect(place, isolation_level=None)
    live.execute(f"PRAGMA journal_mode = {journal}")
    live.execute("PRAGMA cache_size = 1")
    if count_in_file:
        live.executescript("\n".join(script))
        if journal == "WAL":
            live.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    live.execute("PRAGMA wal_autocheckpoint = 0")
    if not count_in_file:
        live.executescript("\n".join(script))
        count_in_file = 1
    later = pairs[count_in_file:]
    for start in range(0, len(later), commit_every):
        live.execute("BEGIN")
        live.executemany(INSERT, later[start : start + commit_every])
        if commit_every < COUNT:
            live.execute("COMMIT")
        else:  # more than the cache holds: a part is in the file before the write ends
            live.executemany(INSERT, 100 * later)
    left = folder / "in"
    left.mkdir()
    for beside in folder.glob("live.db3*"):
        if not beside.name.endswith("-shm"):
            shutil.copy(beside, left / beside.name.replace("live", "in"))
    live.close()
    return left, pairs


def files_of(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.parametrize("count_in_file", [20, 0])
def test_messages_of_the_log_beside_a_file_are_read(count_in_file, forging, tmp_path):
    left, pairs = killed(tmp_path, forging, count_in_file)
    before = files_of(left)
    assert len(before["in.db3-wal"]) > 10_000
    assert read(left) == (pairs, [])
    assert read(left / "in.db3") == (pairs, [])
    assert files_of(left) == before


def test_a_write_that_did_not_end_is_taken_back_and_told(forging, tmp_path):
    left, pairs = killed(tmp_path, forging, 20, journal="DELETE", commit_every=COUNT)
    before = files_of(left)
    assert before["in.db3-journal"]
    found, (loss,) = read(left)
    assert found == pairs[:20]
    assert "in.db3-journal beside it: its recorder did not end the last write" in loss
    assert files_of(left) == before


def test_the_last_messages_of_a_log_without_a_commit_are_told(forging, tmp_path):
    left, pairs = killed(tmp_path, forging, 20, commit_every=COUNT)
    found, (loss,) = read(left)
    assert found == pairs[:20]
    assert "in.db3-wal beside it" in loss


@pytest.mark.parametrize("seed", swept(range(60), sample=range(12)))
def test_a_damaged_log_gives_true_messages_and_tells_what_is_lost(seed, forging, tmp_path):
    left, pairs = killed(tmp_path, forging, 20)
    assert not (left / BAG_METADATA).exists()
    rng = np.random.default_rng(seed)
    log = left / "in.db3-wal"
    raw = bytearray(log.read_bytes())
    if seed % 2:
        raw[int(rng.integers(len(raw)))] ^= 1 << int(rng.integers(8))
    else:
        del raw[int(rng.integers(1, len(raw))) :]
    log.write_bytes(raw)
    found, losses = read(left)
    assert found == pairs[: len(found)]
    assert len(found) >= 20
    assert len(found) == COUNT or losses


def test_a_log_that_cannot_be_copied_is_told(forging, tmp_path, monkeypatch):
    left, pairs = killed(tmp_path, forging, 20)

    def full(*_, **__):
        raise OSError("no space left")

    monkeypatch.setattr(shutil, "copyfile", full)
    found, (loss,) = read(left)
    assert found == pairs[:20]
    assert "in.db3-wal beside it cannot be taken in" in loss
    assert "no space left" in loss


def test_a_log_beside_what_is_no_database_is_no_traceback(forging, tmp_path):
    left, _ = killed(tmp_path, forging, 20)
    (left / "in.db3").write_bytes(b"no database" * 100)
    with pytest.raises(BagError, match=r"in\.db3"):
        read(left / "in.db3")
