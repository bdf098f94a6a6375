"""Forms of recordings: packed, split, renamed, without metadata, and with types of their own."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import CompressionType
from mcap.writer import Writer as McapLibraryWriter
from rosbags.rosbag2 import CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from hybrid_dynamics_core.ground.file_kinds import BAG_METADATA
from hybrid_dynamics_ros.bags.analysis.topic_types import UnknownTypeError, decoder_of
from hybrid_dynamics_ros.bags.errors import BagCallError
from hybrid_dynamics_ros.bags.storage.bag_reader import BagReader, bags_of
from hybrid_dynamics_ros.bags.storage.storage import Topic
from hybrid_dynamics_ros.messages.interfaces import JOINT_STATE
from tests.bags.calling import printed, run
from tests.bags.messages import START, bag, recorded
from tests.bags.test_damage import read
from tests.sampling import swept

PLUGINS = (StoragePlugin.MCAP, StoragePlugin.SQLITE3)
SCALE = "own_msgs/msg/Scale"
DEFINITION = "float64 weight\nstring unit\nown_msgs/Corner[] corners\n"
CORNER = "float64 x\nfloat64 y\n"


def edit(folder, old, new):
    """Change the metadata of a bag."""
    file = folder / BAG_METADATA
    text = file.read_text(encoding="utf-8")
    assert old in text
    file.write_text(text.replace(old, new), encoding="utf-8")


@pytest.mark.parametrize("plugin", PLUGINS)
def test_packed_messages_are_read_without_metadata(plugin, forging, tmp_path):
    pairs = recorded(forging, 40)
    path = bag(tmp_path / "in", pairs, plugin=plugin, mode=CompressionMode.MESSAGE)
    (path / BAG_METADATA).unlink()
    assert read(path) == (pairs, [])


@pytest.mark.parametrize("plugin", PLUGINS)
def test_messages_that_are_not_packed_though_the_metadata_say_so_are_lost(
    plugin, forging, tmp_path
):
    path = bag(tmp_path / "in", recorded(forging, 3), plugin=plugin)
    edit(path, "compression_mode: ''", "compression_mode: MESSAGE")
    messages, losses = read(path)
    assert messages == []
    assert sum("cannot be unpacked" in loss for loss in losses) == 3


def split(folder, robot, counts, names, plugin=StoragePlugin.MCAP, pause=0):
    """Parts of a recording without metadata, some of them left out; all messages that are there."""
    pairs = recorded(robot, sum(counts))
    folder.mkdir()
    there, start = [], 0
    for k, (count, name) in enumerate(zip(counts, names, strict=True)):
        part = [(log + k * pause, data) for log, data in pairs[start : start + count]]
        start += count
        if name is None:
            continue
        path = bag(folder / "part", part, plugin=plugin)
        (file,) = [entry for entry in path.iterdir() if entry.name != BAG_METADATA]
        file.rename(folder / f"{name}{file.suffix}")
        (path / BAG_METADATA).unlink()
        path.rmdir()
        there += part
    return there


@pytest.mark.parametrize("plugin", swept(PLUGINS, PLUGINS[:1]))
def test_parts_of_one_recording_are_joined_in_every_verb(plugin, forging, tmp_path, monkeypatch):
    """Twelve parts: the eleventh comes behind the third where names are sorted as texts."""
    monkeypatch.chdir(tmp_path)
    pairs = split(Path("in"), forging, [10] * 12, [f"run_{k}" for k in range(12)], plugin)
    assert read(Path("in")) == (pairs, [])
    assert bags_of(Path("in")) == [Path("in")]
    said = printed("process", "in", "out", "--robot", forging.name)
    assert "120 received, 120 accepted, 117 with efforts" in said
    assert "120 received" in printed("report", "in", "--robot", forging.name)
    assert "120 rows" in printed("export", "in", "tables")


def test_a_part_that_is_missing_is_told(forging, tmp_path):
    pairs = split(tmp_path / "in", forging, [10] * 4, ["run_0", None, "run_2", "run_3"])
    assert read(tmp_path / "in") == (
        pairs,
        ["run_1: missing, though the parts before and behind are there"],
    )


def test_recordings_with_hours_between_them_are_several(forging, tmp_path):
    folder = tmp_path / "in"
    split(folder, forging, [10] * 3, ["run_1", "run_2", "run_3"], pause=3600 * 10**9)
    assert len(bags_of(folder)) == 3
    with pytest.raises(BagCallError, match=r"holds 3 recordings \(run_1\.mcap, .*name one"):
        BagReader(folder)


@pytest.mark.parametrize("plugin", PLUGINS)
def test_metadata_that_count_nothing_are_no_loss(plugin, forging, tmp_path):
    """A recorder that was killed leaves zeros."""
    pairs = recorded(forging, 40)
    path = bag(tmp_path / "in", pairs, plugin=plugin)
    edit(path, "message_count: 40", "message_count: 0")
    assert read(path) == (pairs, [])


@pytest.mark.parametrize("has_metadata", [True, False])
@pytest.mark.parametrize("is_file_renamed", [True, False])
def test_a_recording_may_be_renamed(has_metadata, is_file_renamed, forging, tmp_path):
    pairs = recorded(forging, 40)
    path = bag(tmp_path / "in", pairs).rename(tmp_path / "friday")
    if not has_metadata:
        (path / BAG_METADATA).unlink()
    if is_file_renamed:
        (path / "in.mcap").rename(path / "friday.mcap")
    assert bags_of(path) == [path]
    assert read(path) == (pairs, [])


def test_a_part_that_the_metadata_forget_is_read(forging, tmp_path):
    """A recorder that was killed names the parts that were complete."""
    pairs = split(tmp_path / "in", forging, [10] * 2, ["in_0", "in_1"])
    first = bag(tmp_path / "first", pairs[:10])
    (first / BAG_METADATA).rename(tmp_path / "in" / BAG_METADATA)
    edit(tmp_path / "in", "first.mcap", "in_0.mcap")
    assert read(tmp_path / "in") == (pairs, [])


def bag_of_scales(path, plugin, count=20):
    """A bag of joint states, and of a type that only the bag knows."""
    types = get_typestore(Stores.ROS2_JAZZY)
    types.register(get_types_from_msg(CORNER, "own_msgs/msg/Corner"))
    types.register(get_types_from_msg(DEFINITION, SCALE))
    corner = types.types["own_msgs/msg/Corner"]
    with Writer(path, version=9, storage_plugin=plugin) as writer:
        topic = writer.add_connection("/scale", SCALE, typestore=types)
        for k in range(count):
            scale = types.types[SCALE](1.5 + k, "kg", [corner(0.1 * k, -1.0)])
            writer.write(topic, START + k, bytes(types.serialize_cdr(scale, SCALE)))
    return path


@pytest.mark.parametrize("plugin", PLUGINS)
def test_types_that_a_bag_defines_are_exported(plugin, tmp_path):
    path = bag_of_scales(tmp_path / "in", plugin)
    run("export", path, tmp_path / "tables")
    with (tmp_path / "tables" / "scale.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 20
    assert rows[3] == {
        "log_ns": str(START + 3),
        "weight": "4.5",
        "unit": "kg",
        "corners[0].x": str(0.1 * 3),
        "corners[0].y": "-1.0",
    }


def test_a_definition_that_is_no_definition_is_told(tmp_path):
    path = bag_of_scales(tmp_path / "in", StoragePlugin.MCAP)
    raw = (path / "in.mcap").read_bytes()
    (path / "in.mcap").write_bytes(raw.replace(b"float64 weight", b"float6} weight"))
    said = run("export", path, tmp_path / "tables", code=3).stderr
    assert f"lost: /scale: its type {SCALE} is not known, and its definition in the bag" in said


@pytest.mark.parametrize(
    ("kind", "encoding"),
    [(JOINT_STATE, "json"), ("sensor_msgs/JointState", "ros1"), (JOINT_STATE, "protobuf")],
)
def test_other_encodings_are_told(kind, encoding, tmp_path):
    path = tmp_path / "in.mcap"
    with path.open("wb") as file:
        writer = McapLibraryWriter(file, compression=CompressionType.NONE)
        writer.start(profile="")
        schema = writer.register_schema(kind, "jsonschema", b"{}")
        channel = writer.register_channel("/joint_states", encoding, schema)
        for k in range(5):
            writer.add_message(channel, START + k, b'{"name": ["q1"]}', START + k)
        writer.finish()
    for verb in ("process", "report", "identify"):
        out = [tmp_path / "out"] if verb == "process" else []
        said = run(verb, path, *out, "--robot", "five_bar", code=1).stderr
        assert f"/joint_states: its messages ({kind}) are in the encoding '{encoding}'" in said
        assert "convert the recording first" in said
    said = run("export", path, tmp_path / "tables", code=3).stderr
    assert f"lost: /joint_states: its messages are in the encoding '{encoding}'; only cdr" in said


def test_files_of_one_recording_that_overlap_give_messages_in_order(forging, tmp_path):
    """Times decide, whichever part a message is in."""
    rng = np.random.default_rng(4)
    pairs = recorded(forging, 200)
    late = rng.random(200) < 0.5
    for plugin in PLUGINS:
        folder = tmp_path / plugin.name
        folder.mkdir()
        for part in range(2):
            chosen = [pair for pair, is_late in zip(pairs, late, strict=True) if is_late == part]
            path = bag(folder / "part", chosen, plugin=plugin)
            (file,) = [entry for entry in path.iterdir() if entry.name != BAG_METADATA]
            file.rename(folder / f"{folder.name}_{part}{file.suffix}")
            (path / BAG_METADATA).unlink()
            path.rmdir()
        assert read(folder) == (pairs, [])


@pytest.mark.parametrize(
    ("kind", "named"), [("a_msgs/msg/A", "a_msgs/msg/A"), ("", "without a name")]
)
def test_a_type_is_called_by_its_name_if_it_has_one(kind, named):
    with pytest.raises(UnknownTypeError, match=f"^its type {named} is not known"):
        decoder_of(Topic("/t", kind))
