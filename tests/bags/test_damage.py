"""Damaged bags: what can be read is right, what is lost is told, nothing is left half-written."""

from __future__ import annotations

import os
import re
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag2 import CompressionMode, StoragePlugin

from hybrid_dynamics_core.ground.file_kinds import BAG_METADATA
from hybrid_dynamics_ros.bags.errors import BagError
from hybrid_dynamics_ros.bags.input_topic import INPUT
from hybrid_dynamics_ros.bags.job import Job
from hybrid_dynamics_ros.bags.make import simulated, write_trajectory
from hybrid_dynamics_ros.bags.process import process
from hybrid_dynamics_ros.bags.storage.bag_reader import BagReader
from hybrid_dynamics_ros.bags.storage.bag_writer import new_bag
from hybrid_dynamics_ros.bags.storage.mcap_chunk import RecordBlock
from hybrid_dynamics_ros.bags.storage.storage import MAX_LOSSES, Losses, Messages, Topic
from tests.bags.messages import START, bag, recorded

ROOT = Path(__file__).resolve().parents[2]
JOINT_STATE = "sensor_msgs/msg/JointState"


def read(path, topic=INPUT):
    """(log time, bytes) of all messages of a topic, and what was lost."""
    with BagReader(path) as source:
        pairs = [
            (int(m.log_ns[k]), m.message(k))
            for _, m in source.read(frozenset([topic]))
            for k in range(len(m))
        ]
        return pairs, source.losses.describe()


FORMS = {
    "mcap": (StoragePlugin.MCAP, CompressionMode.NONE),
    "mcap, chunks packed": (StoragePlugin.MCAP, CompressionMode.STORAGE),
    "mcap, messages packed": (StoragePlugin.MCAP, CompressionMode.MESSAGE),
    "mcap, file packed": (StoragePlugin.MCAP, CompressionMode.FILE),
    "sqlite3": (StoragePlugin.SQLITE3, CompressionMode.NONE),
    "sqlite3, messages packed": (StoragePlugin.SQLITE3, CompressionMode.MESSAGE),
    "sqlite3, file packed": (StoragePlugin.SQLITE3, CompressionMode.FILE),
}


@pytest.mark.parametrize("form", FORMS)
def test_every_form_of_bag_gives_its_messages(form, forging, tmp_path):
    pairs = recorded(forging, 40)
    path = bag(tmp_path / "in", pairs, plugin=FORMS[form][0], mode=FORMS[form][1])
    assert read(path) == (pairs, [])


@pytest.mark.parametrize("compression", ["NONE", "LZ4", "ZSTD"])
@pytest.mark.parametrize("chunked", [True, False])
def test_files_of_the_mcap_library_are_read(compression, chunked, forging, tmp_path):
    from mcap.writer import CompressionType, Writer

    pairs = recorded(forging, 40)
    with (tmp_path / "a.mcap").open("wb") as file:
        writer = Writer(
            file, chunk_size=2000, compression=CompressionType[compression], use_chunking=chunked
        )
        writer.start(profile="ros2")
        schema = writer.register_schema(JOINT_STATE, "ros2msg", b"")
        channel = writer.register_channel(INPUT, "cdr", schema)
        for log_ns, data in reversed(pairs):  # in any order of log times
            writer.add_message(channel, log_ns, data, log_ns)
        writer.finish()
    assert read(tmp_path / "a.mcap") == (pairs, [])


def test_a_file_that_describes_its_topics_in_chunks_alone_is_read(forging, tmp_path):
    from mcap.writer import IndexType, Writer

    pairs = recorded(forging, 40)
    with (tmp_path / "a.mcap").open("wb") as file:
        writer = Writer(
            file,
            chunk_size=2000,
            index_types=IndexType.NONE,
            repeat_channels=False,
            repeat_schemas=False,
            use_statistics=False,
            use_summary_offsets=False,
        )
        writer.start(profile="ros2")
        schema = writer.register_schema(JOINT_STATE, "ros2msg", b"")
        channel = writer.register_channel(INPUT, "cdr", schema)
        for log_ns, data in pairs:
            writer.add_message(channel, log_ns, data, log_ns)
        writer.finish()
    assert read(tmp_path / "a.mcap") == (pairs, [])


@pytest.mark.parametrize("change", ["DROP TABLE messages", "DELETE FROM messages"])
def test_a_database_without_messages_begins_and_ends_at_no_time(change, forging, tmp_path):
    path = bag(tmp_path / "in", recorded(forging, 3), plugin=StoragePlugin.SQLITE3)
    (file,) = path.glob("*.db3")
    with closing(sqlite3.connect(file)) as base:
        base.execute(change)
        base.commit()
    with BagReader(path) as source:
        assert source.span() == (0, 0)
        assert list(source.read()) == []


def test_split_bags_are_one(forging, tmp_path):
    pairs = recorded(forging, 40)
    for k in range(2):
        bag(tmp_path / f"p{k}", pairs[20 * k : 20 * k + 20])
    whole = tmp_path / "whole"
    whole.mkdir()
    for k in range(2):
        (tmp_path / f"p{k}" / f"p{k}.mcap").rename(whole / f"whole_{k}.mcap")
    assert read(whole) == (pairs, [])
    text = (
        (tmp_path / "p0" / BAG_METADATA)
        .read_text(encoding="utf-8")
        .replace("message_count: 20", "message_count: 40")
    )
    (whole / BAG_METADATA).write_text(
        text.replace("- p0.mcap", "- whole_0.mcap\n  - whole_1.mcap"), encoding="utf-8"
    )
    assert read(whole) == (pairs, [])


def test_messages_that_only_the_metadata_know_of_are_told(forging, tmp_path):
    pairs = recorded(forging, 20)
    bag(tmp_path / "in", pairs)
    file = tmp_path / "in" / BAG_METADATA
    text = file.read_text(encoding="utf-8")
    file.write_text(text.replace("message_count: 20", "message_count: 23"), encoding="utf-8")
    told = f"{INPUT}: 20 messages could be read of 23 that the bag says it has"
    assert read(tmp_path / "in") == (pairs, [told])
    file.write_text(text.replace(f"name: {INPUT}", "name: /other"), encoding="utf-8")
    told = "/other: in metadata.yaml with 20 messages, and in no file that can be read"
    assert read(tmp_path / "in") == (pairs, [told])


@pytest.fixture(scope="module")
def whole(forging, tmp_path_factory):
    """A bag of several chunks with checksums, and its messages."""
    path = tmp_path_factory.mktemp("whole") / "in"
    motion = simulated(forging, 2.0, 200.0)
    pieces = [slice(k, k + 50) for k in range(0, 400, 50)]
    write_trajectory(path, motion, INPUT, {})
    pairs, _ = read(path)
    chunked = path.parent / "chunked"
    with new_bag(chunked, [Topic(INPUT, JOINT_STATE)]) as out:
        for piece in pieces:
            times, data = zip(*pairs[piece], strict=True)
            out.write(list(RecordBlock.copies(1, Messages.of(list(times), list(data)))))
    return chunked, pairs


LOST_MESSAGES = 1200


def damage(whole, folder, rng):
    """A copy with a random bit turned or its end cut off; the messages of the original."""
    path, pairs = whole
    folder.mkdir()
    raw = bytearray((path / "chunked.mcap").read_bytes())
    (folder / BAG_METADATA).write_bytes((path / BAG_METADATA).read_bytes())
    if rng.random() < 0.5:
        del raw[int(rng.integers(len(raw))) :]
    else:
        raw[int(rng.integers(len(raw)))] ^= 1 << int(rng.integers(8))
    (folder / "chunked.mcap").write_bytes(raw)
    return folder, pairs


def assert_true_or_told(path, pairs):
    """Everything that is read was there; where something is missing, that is told."""
    try:
        found, losses = read(path)
    except BagError:
        return 0
    known = set(pairs)
    assert all(pair in known for pair in found)
    assert found == sorted(found)
    assert len(found) == len(pairs) or losses
    return len(found)


def test_damaged_bags_give_true_messages_and_tell_what_is_lost(whole, tmp_path):
    rng = np.random.default_rng(8)
    counts = [assert_true_or_told(*damage(whole, tmp_path / str(k), rng)) for k in range(60)]
    assert (
        0 < np.count_nonzero(np.array(counts) < 400) < 60
    )  # some are damaged where it counts, others not
    assert max(counts) == 400


def test_thousands_of_lost_messages_are_told_in_a_thousand_lines_and_counted(forging, tmp_path):
    """Every other message is none: the first ones are named, and the sum is right."""
    pairs = recorded(forging, 60)
    good = [pairs[k % 60][1] for k in range(2 * LOST_MESSAGES)]
    mixed = [(START + k * 10**6, data if k % 2 else data[:20]) for k, data in enumerate(good)]
    path = bag(tmp_path / "in", mixed)
    outcome = process(Job(path, tmp_path / "out", forging.name))
    assert len(outcome.losses) == MAX_LOSSES + 1
    assert outcome.losses[0].startswith(
        "message 0, logged at 1700000000000000000 ns: no JointState"
    )
    assert outcome.losses[MAX_LOSSES - 1].startswith(f"message {2 * MAX_LOSSES - 2}, ")
    told = re.fullmatch(
        r"\.\.\. and (\d+) more: message N, logged at N ns: no JointState.*", outcome.losses[-1]
    )
    assert told is not None
    assert int(told[1]) == LOST_MESSAGES - MAX_LOSSES


def test_losses_told_again_are_told_once_and_kinds_stay_few():
    losses = Losses()
    for k in range(MAX_LOSSES):
        for _ in range(2):
            losses.add(f"/arm_2: sample {k} is lost")
    assert losses.describe() == [f"/arm_2: sample {k} is lost" for k in range(MAX_LOSSES)]
    for k in range(5000):
        losses.add(f"/arm_2: sample {k + MAX_LOSSES} is lost")
        losses.add(f"/arm_2: {'x' * (k % 40)} is lost")
    more = losses.describe()[MAX_LOSSES:]
    assert more[0] == "... and 5000 more: /arm_2: sample N is lost"
    assert len(more) < 30
    assert sum(int(text.split()[2]) for text in more) == 10_000


@pytest.mark.sweep(sample="test_damaged_bags_give_true_messages_and_tell_what_is_lost")
def test_a_thousand_damaged_bags(whole, tmp_path):
    rng = np.random.default_rng(9)
    for k in range(1000):
        assert_true_or_told(*damage(whole, tmp_path / str(k), rng))


def test_damaged_databases_do_not_escape(forging, tmp_path):
    """sqlite3 has no checksums.

    What it gives may be wrong, as the page on bags says; it never ends in a traceback.
    """
    rng = np.random.default_rng(3)
    source = bag(tmp_path / "in", recorded(forging, 200), plugin=StoragePlugin.SQLITE3)
    raw = (source / "in.db3").read_bytes()
    for k in range(20):
        folder = tmp_path / str(k)
        folder.mkdir()
        cut = bytearray(raw[: int(rng.integers(len(raw)))] if k % 2 else raw)
        for _ in range(20):
            cut[int(rng.integers(len(cut)))] ^= 255
        (folder / BAG_METADATA).write_bytes((source / BAG_METADATA).read_bytes())
        (folder / "in.db3").write_bytes(cut)
        try:
            found, losses = read(folder)
        except BagError:
            continue
        else:
            assert len(found) == 200 or losses


@pytest.mark.sweep(sample="test_damaged_bags_give_true_messages_and_tell_what_is_lost")
def test_a_truncated_bag_is_processed_as_far_as_it_goes(whole, tmp_path):
    path, pairs = whole
    cut = tmp_path / "cut.mcap"
    raw = (path / "chunked.mcap").read_bytes()
    cut.write_bytes(raw[: len(raw) // 2])
    command = ["bag", "process", str(cut), str(tmp_path / "out"), "--robot", "forging_chu2020"]
    done = subprocess.run(
        [sys.executable, "-m", "hybrid_dynamics_cli", *command],
        capture_output=True,
        text=True,
        check=False,
        cwd=ROOT,
    )
    assert done.returncode == 3, done.stderr
    assert "lost: cut.mcap: the record at byte" in done.stderr
    found, _ = read(tmp_path / "out", "/hybrid_dynamics/joint_states")
    assert 0 < len(found) < len(pairs)


def test_an_interruption_leaves_what_was_there(tmp_path):
    def write(path, *, end):
        with new_bag(path, [Topic(INPUT, JOINT_STATE)]):
            if end:
                raise KeyboardInterrupt

    write(tmp_path / "out", end=False)
    before = (tmp_path / "out" / BAG_METADATA).read_bytes()
    for path in (tmp_path / "out", tmp_path / "other"):
        with pytest.raises(KeyboardInterrupt):
            write(path, end=True)
    assert [p.name for p in tmp_path.iterdir()] == ["out"]
    assert (tmp_path / "out" / BAG_METADATA).read_bytes() == before


def test_wrong_bags_are_told_in_words(forging, tmp_path):
    with pytest.raises(BagError, match="there is no such file or folder; expected a recording"):
        process(Job(tmp_path / "nothing", tmp_path / "out", "forging_chu2020"))
    path = bag(tmp_path / "in", recorded(forging, 5), topic="/measured")
    with pytest.raises(BagError, match=r"no topic /other .* /measured"):
        process(Job(path, tmp_path / "out", "forging_chu2020", topic="/other"))
    with pytest.raises(BagError, match="would replace"):
        process(Job(path, path, "forging_chu2020"))
    assert (
        process(Job(path, tmp_path / "out", "forging_chu2020")).samples == 5
    )  # the only topic of the type
    assert sorted(p.name for p in tmp_path.iterdir()) == ["in", "out"]


@pytest.mark.sweep(sample="test_an_interruption_leaves_what_was_there")
def test_ctrl_c_leaves_nothing_behind(forging, tmp_path):
    write_trajectory(tmp_path / "in", simulated(forging, 60.0, 3000.0), INPUT, {})
    command = ["bag", "process", "in", "out", "--robot", "forging_chu2020"]
    # A shell's background jobs ignore the signal. No function runs between fork and exec: other
    # tests may have left threads.
    start = "import signal, runpy; signal.signal(signal.SIGINT, signal.default_int_handler);"
    start += "runpy.run_module('hybrid_dynamics_cli', run_name='__main__', alter_sys=True)"
    done = subprocess.Popen(
        [sys.executable, "-c", start, *command],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    deadline = time.monotonic() + 60.0
    while not any(tmp_path.glob(".out.*/out/out.mcap")):
        assert done.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.01)
    done.send_signal(signal.SIGINT)
    assert done.wait(30.0) in (
        1,
        -signal.SIGINT,
    )  # Python may end itself by the signal, for the shell to see
    assert [p.name for p in tmp_path.iterdir()] == ["in"]


def test_bags_need_no_ros_and_start_without_libraries_that_are_slow_to_start():
    code = (
        "import sys, hybrid_dynamics_ros.bags.process;"
        "sys.exit(bool({'rclpy', 'sensor_msgs', 'scipy'} & set(sys.modules)))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False, cwd=ROOT).returncode == 0


def test_log_times_beyond_the_numbers_of_the_reader_are_told(forging, tmp_path):
    pairs = recorded(forging, 30)
    late = [(2**63 + 5 if k == 10 else log, data) for k, (log, data) in enumerate(pairs)]
    path = bag(tmp_path / "in", late)
    outcome = process(Job(path, tmp_path / "out", "forging_chu2020"))
    assert "29 received" in outcome.summary
    assert any("1 messages with log times beyond the year 2262" in told for told in outcome.losses)


@pytest.mark.parametrize("keep", [False, True])
def test_a_loss_names_the_number_of_its_message(keep, forging, tmp_path):
    pairs = recorded(forging, 3000)
    pairs[2500] = (pairs[2500][0], pairs[2500][1][:20])
    outcome = process(
        Job(bag(tmp_path / "in", pairs), tmp_path / "out", "forging_chu2020", keep=keep)
    )
    assert [told.split(",")[0] for told in outcome.losses] == ["message 2500"]


def test_a_message_index_that_is_said_to_be_a_message_is_none(whole, tmp_path):
    """One bit makes code 7 of a record code 5, in a place that no checksum covers."""
    path, pairs = whole
    raw = bytearray((path / "chunked.mcap").read_bytes())
    place = 8
    while raw[place] != 7:
        place += 9 + int.from_bytes(raw[place + 1 : place + 9], "little")
    raw[place] = 5
    (tmp_path / BAG_METADATA).write_bytes((path / BAG_METADATA).read_bytes())
    (tmp_path / "chunked.mcap").write_bytes(raw)
    found, _ = read(tmp_path)
    assert found == pairs
