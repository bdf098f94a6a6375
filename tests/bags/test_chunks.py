"""Chunks of bags: records of all sizes are found again, and there is no bag after an error."""

from __future__ import annotations

from functools import partial
from itertools import chain
from zlib import crc32

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_ros.bags.input_topic import INPUT
from hybrid_dynamics_ros.bags.storage.bag_reader import BagReader
from hybrid_dynamics_ros.bags.storage.bag_writer import new_bag
from hybrid_dynamics_ros.bags.storage.compression import zstd
from hybrid_dynamics_ros.bags.storage.mcap_chunk import ChunkPacker, RecordBlock
from hybrid_dynamics_ros.bags.storage.pieces import Piece, in_time_order
from hybrid_dynamics_ros.bags.storage.storage import Topic
from hybrid_dynamics_ros.messages.cdr import MessageTemplate
from hybrid_dynamics_ros.messages.interfaces import JOINT_STATE
from tests.bags.messages import START, messages_of
from tests.sampling import examples


def blocks(rng, count):
    """Blocks of random columns.

    Numbers of several sizes, views with steps, messages as they were.
    """
    log_ns = START + np.sort(rng.integers(0, 10**9, count))
    template = (
        MessageTemplate()
        .header("base")
        .sequence("a", 3)
        .slot("b", "<f8")
        .sequence("c", 5, "u1")
        .sequence("d", 1, "u1")
    )
    template.string("end")
    values = {
        "sec": log_ns // 10**9,
        "nanosec": log_ns % 10**9,
        "a": rng.normal(size=(count, 6))[:, ::2],
        "b": rng.normal(size=count),
        "c": rng.integers(0, 2, (count, 5)),
        "d": rng.integers(0, 2, (count, 1)),
    }
    yield RecordBlock.filled(1, log_ns, template, values)
    yield from RecordBlock.copies(
        2, messages_of([(int(t), rng.bytes(int(rng.choice([7, 30])))) for t in log_ns])
    )
    yield from RecordBlock.copies(3, messages_of([(int(t), rng.bytes(16)) for t in log_ns]))


@pytest.mark.parametrize("count", [1, 2, 300])
def test_a_chunk_holds_the_records_of_its_messages(count):
    made = list(blocks(np.random.default_rng(count), count))
    chunk = ChunkPacker().pack(made)
    wanted = b"".join(record for block in made for record in records_of(block))
    assert zstd.decompress(chunk.compressed) == wanted
    assert (chunk.size, chunk.checksum) == (len(wanted), crc32(wanted))


def records_of(block):
    """The records of a block, one by one."""
    for k in range(len(block)):
        record = bytearray(block.pattern.tobytes())
        for start, column in block.columns:
            record[start : start + column.shape[1]] = column[k].tobytes()
        yield bytes(record)


@pytest.mark.parametrize(
    ("start", "rows", "width"),
    [(-1, 4, 8), (13, 4, 8), (0, 3, 8), (0, 1, 8), (0, 4, 21)],
)
def test_columns_that_do_not_fit_are_refused(start, rows, width):
    column, pattern = np.zeros((rows, width), dtype=np.uint8), np.zeros(20, dtype=np.uint8)
    block = RecordBlock(1, np.arange(4), pattern, [(start, column)])
    with pytest.raises(ValueError, match="columns inside them"):
        block.write(np.zeros((4, 20), dtype=np.uint8))


def test_a_packer_gives_a_chunk_the_same_bytes_whatever_it_packed_before():
    small, large = (list(blocks(np.random.default_rng(7), count)) for count in (5, 500))
    used = ChunkPacker()
    for made in (large, small, large):
        assert used.pack(made).compressed == ChunkPacker().pack(made).compressed


def test_messages_of_any_sizes_are_found_again(tmp_path):
    """Runs of one size, from one record to hundreds, and two topics in between."""
    from mcap.writer import Writer

    rng = np.random.default_rng(3)
    sizes = np.repeat(rng.choice([20, 20, 21, 300], 200), rng.choice([1, 2, 8, 9, 10, 150], 200))
    wanted = {"/a": [], "/b": []}
    with (tmp_path / "a.mcap").open("wb") as file:
        writer = Writer(file, chunk_size=100_000)
        writer.start(profile="ros2")
        schema = writer.register_schema(JOINT_STATE, "ros2msg", b"")
        channels = {name: writer.register_channel(name, "cdr", schema) for name in wanted}
        for k, size in enumerate(sizes.tolist()):
            name, data = ("/b" if k % 700 > 600 else "/a"), rng.bytes(size)
            writer.add_message(channels[name], START + k, data, START + k)
            wanted[name].append((START + k, data))
        writer.finish()
    found = {"/a": [], "/b": []}
    with BagReader(tmp_path / "a.mcap") as source:
        for name, messages in source.read():
            found[name] += [
                (int(messages.log_ns[k]), messages.message(k)) for k in range(len(messages))
            ]
        assert source.losses.describe() == []
    assert found == wanted


@pytest.mark.parametrize(
    "count", [1, 3, 20]
)  # the error comes back from close, or from a later write
def test_what_goes_wrong_beside_the_caller_is_raised_and_leaves_no_bag(
    count, tmp_path, monkeypatch
):
    def full(_self, _blocks):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(ChunkPacker, "pack", full)
    with pytest.raises(OSError, match="No space left"):
        write_chunks(tmp_path / "out", count)
    assert list(tmp_path.iterdir()) == []


def write_chunks(path, count):
    """A bag with a message in each chunk."""
    with new_bag(path, [Topic(INPUT, JOINT_STATE)]) as out:
        for k in range(count):
            out.write(list(RecordBlock.copies(1, messages_of([(START + k, b"1234")]))))


BATCHES = st.lists(st.lists(st.integers(0, 60), max_size=3), min_size=1, max_size=24)


@given(st.lists(BATCHES, min_size=1, max_size=4))
@examples(200)
def test_pieces_that_overlap_are_read_in_the_order_of_log_times(pieces: list) -> None:
    made, every = [], []
    for batches in pieces:
        times = sorted(chain.from_iterable(batches))
        cuts = np.cumsum([len(batch) for batch in batches])[:-1]
        parts = [part.tolist() for part in np.split(np.array(times, dtype=int), cuts)]
        messages = [("topic", messages_of([(time, b"1234") for time in part])) for part in parts]
        made.append(Piece((min(times, default=0), max(times, default=0)), partial(iter, messages)))
        every += times
    there = [log for _, part in in_time_order(made) for log, _ in part.raw()]
    assert there == sorted(every)
