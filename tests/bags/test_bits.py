"""One bit in a recording: times come from the messages, and what is lost is told."""

from __future__ import annotations

import struct

import numpy as np
import pytest

from hybrid_dynamics_ros.bags.input_topic import INPUT
from hybrid_dynamics_ros.bags.job import Job
from hybrid_dynamics_ros.bags.process import process
from hybrid_dynamics_ros.bags.storage.mcap_format import CHUNK, MESSAGE_INDEX, RECORD_HEAD
from tests.bags.test_damage import read
from tools.damaged_bags import FORMS, OUTPUT, ROBOT, recorded, run

CHECKED = [name for name, form in FORMS.items() if form.has_checksums]


@pytest.fixture(scope="module")
def pairs(tmp_path_factory):
    """Messages of two topics."""
    return recorded(tmp_path_factory.mktemp("recorded") / "in")


@pytest.fixture(scope="module", params=CHECKED)
def whole(request, pairs, tmp_path_factory):
    """A file with checksums."""
    folder = tmp_path_factory.mktemp("whole") / "in"
    FORMS[request.param].write(folder, pairs)
    return folder / "in.mcap"


def heads(raw, code):
    """First bytes of the records with a code."""
    start, found = 8, []
    while start + RECORD_HEAD.size < len(raw) - 8:
        record, size = RECORD_HEAD.unpack_from(raw, start)
        if record == code:
            found.append(start)
        start += RECORD_HEAD.size + size
    return found


def turned(whole, place, bit, folder):
    """A copy with one bit turned."""
    raw = bytearray(whole.read_bytes())
    raw[place] ^= 1 << bit
    folder.mkdir(exist_ok=True)
    (folder / "in.mcap").write_bytes(raw)
    return folder / "in.mcap"


def of_topic(pairs, topic=INPUT):
    """Log times and messages of a topic."""
    return [(log_ns, data) for name, log_ns, data in pairs if name == topic]


def test_the_time_in_the_head_of_a_chunk_decides_nothing(whole, pairs, tmp_path):
    """No checksum covers it."""
    rng = np.random.default_rng(0)
    for start in heads(whole.read_bytes(), CHUNK):
        for bit in rng.choice(128, 6, replace=False).tolist():
            place = start + RECORD_HEAD.size + bit // 8
            assert read(turned(whole, place, bit % 8, tmp_path / "a")) == (of_topic(pairs), [])


def test_a_later_start_in_the_head_of_a_chunk_changes_no_effort(whole, tmp_path):
    """The case: bit 4 of the fifth byte made a chunk come 69 s late."""
    process(Job(whole, tmp_path / "right", ROBOT))
    start = heads(whole.read_bytes(), CHUNK)[1] + RECORD_HEAD.size
    for name, place, bit in (("late", start + 4, 4), ("early", start + 5, 0)):
        outcome = process(Job(turned(whole, place, bit, tmp_path / "a"), tmp_path / name, ROBOT))
        assert outcome.summary == "120 received, 120 accepted, 117 with efforts"
        assert read(tmp_path / name, OUTPUT) == read(tmp_path / "right", OUTPUT)


@pytest.mark.parametrize("code", [CHUNK, MESSAGE_INDEX])
def test_no_message_is_lost_with_the_head_of_a_record(code, whole, pairs, tmp_path):
    """The index at the end of the file says where chunks are."""
    rng = np.random.default_rng(1)
    starts = heads(whole.read_bytes(), code)
    for start in starts[:4]:
        for bit in rng.choice(8 * RECORD_HEAD.size, 8, replace=False).tolist():
            messages, _ = read(turned(whole, start + bit // 8, bit % 8, tmp_path / "a"))
            assert messages == of_topic(pairs)


def test_a_text_without_its_end_costs_one_chunk(whole, pairs, tmp_path):
    start = heads(whole.read_bytes(), CHUNK)[1]
    name_length = start + RECORD_HEAD.size + 28
    raw = whole.read_bytes()
    assert struct.unpack_from("<I", raw, name_length) == (4,)
    messages, losses = read(turned(whole, name_length + 2, 5, tmp_path / "a"))
    right = of_topic(pairs)
    assert set(messages) < set(right)
    assert len(messages) >= len(right) - 15
    assert f"in.mcap: the chunk at byte {start + RECORD_HEAD.size}" in losses[0]
    assert f"{len(messages)} messages could be read of 120" in losses[1]


def verdicts_of(count, seed, folder):
    """Damage, and what comes of it in three verbs."""
    verdicts = set()
    for name, verdict, what, details in run(count, seed, list(FORMS), folder):
        is_seen = verdict != "silent" or not FORMS[name].has_checksums
        assert verdict != "traceback", f"{name}, {what}: {details}"
        assert is_seen, f"{name}, {what}"
        verdicts.add(verdict)
    return verdicts


def test_damage_gives_right_values_or_a_line(tmp_path):
    assert verdicts_of(18, 3, tmp_path) >= {"right", "told"}


@pytest.mark.sweep(sample="test_damage_gives_right_values_or_a_line")
def test_many_damages_give_right_values_or_a_line(tmp_path):
    assert verdicts_of(160, 4, tmp_path) >= {"right", "told", "refused"}
