"""Chunks of bags: the same bytes compiled and by NumPy, found again whatever the sizes, and no bag after an error."""

from __future__ import annotations

import filecmp

import numpy as np
import pytest

from hybrid_dynamics_core.kernels import native
from hybrid_dynamics_ros.bags.process import INPUT, Job, process
from hybrid_dynamics_ros.bags.storage import compiled_rows
from hybrid_dynamics_ros.bags.storage.bag_reader import Source, Topic
from hybrid_dynamics_ros.bags.storage.mcap_chunk import Block, Packer
from hybrid_dynamics_ros.bags.storage.mcap_writer import new_bag
from hybrid_dynamics_ros.messages.cdr import Template
from hybrid_dynamics_ros.messages.interfaces import JOINT_STATE
from tests.bags.messages import START, bag, messages_of, recorded

compiled = pytest.mark.skipif(bool(native.reason_against()), reason="there is no compiler")


def blocks(rng, count):
    """Blocks of random columns: numbers of several sizes, views with steps, messages as they were."""
    log_ns = START + np.sort(rng.integers(0, 10**9, count))
    template = (
        Template()
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
    yield Block.filled(1, log_ns, template, values)
    yield from Block.copies(
        2, messages_of([(int(t), rng.bytes(int(rng.choice([7, 30])))) for t in log_ns])
    )
    yield from Block.copies(3, messages_of([(int(t), rng.bytes(16)) for t in log_ns]))


@compiled
@pytest.mark.parametrize("count", [1, 2, 300])
def test_compiled_code_and_numpy_write_the_same_records(count, monkeypatch):
    made = list(blocks(np.random.default_rng(count), count))
    found = Packer().chunk(made)
    monkeypatch.setattr(compiled_rows, "writer", lambda: None)
    wanted = Packer().chunk(made)
    assert (found.packed, found.size, found.checksum) == (
        wanted.packed,
        wanted.size,
        wanted.checksum,
    )


@compiled
def test_a_bag_is_the_same_file_with_a_compiler_and_without(forging, tmp_path, monkeypatch):
    source = bag(tmp_path / "in", recorded(forging, 100))
    process(Job(source, tmp_path / "a" / "out", "forging_chu2020", keep=True))
    monkeypatch.setattr(compiled_rows, "writer", lambda: None)
    process(Job(source, tmp_path / "b" / "out", "forging_chu2020", keep=True))
    _, differing, missing = filecmp.cmpfiles(
        tmp_path / "a" / "out", tmp_path / "b" / "out", ["out.mcap", "metadata.yaml"], shallow=False
    )
    assert (differing, missing) == ([], [])


@compiled
@pytest.mark.parametrize(
    ("start", "rows", "width"), [(-1, 4, 8), (13, 4, 8), (0, 3, 8), (0, 4, 21)]
)
def test_columns_that_do_not_fit_are_refused(start, rows, width):
    column, pattern = np.zeros((rows, width), dtype=np.uint8), np.zeros(20, dtype=np.uint8)
    with pytest.raises(ValueError, match="columns inside them"):
        compiled_rows.writer()([(np.zeros((4, 20), dtype=np.uint8), pattern, [(start, column)])])


def test_a_packer_gives_a_chunk_the_same_bytes_whatever_it_packed_before():
    small, large = (list(blocks(np.random.default_rng(7), count)) for count in (5, 500))
    used = Packer()
    for made in (large, small, large):
        assert used.chunk(made).packed == Packer().chunk(made).packed


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
    with Source(tmp_path / "a.mcap") as source:
        for name, messages in source.read():
            found[name] += [
                (int(messages.log_ns[k]), messages.message(k)) for k in range(len(messages))
            ]
        assert source.losses.told == []
    assert found == wanted


@pytest.mark.parametrize(
    "count", [1, 3, 20]
)  # the error comes back from close, or from a later write
def test_what_goes_wrong_beside_the_caller_is_raised_and_leaves_no_bag(
    count, tmp_path, monkeypatch
):
    def full(_self, _blocks):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Packer, "chunk", full)
    with pytest.raises(OSError, match="No space left"):
        write_chunks(tmp_path / "out", count)
    assert list(tmp_path.iterdir()) == []


def write_chunks(path, count):
    """A bag with a message in each chunk."""
    with new_bag(path, [Topic(INPUT, JOINT_STATE)]) as out:
        for k in range(count):
            out.write(list(Block.copies(1, messages_of([(START + k, b"1234")]))))
