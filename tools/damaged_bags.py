"""Damaged recordings: what the bag tool makes of them is right, or a line says what was lost.

python tools/damaged_bags.py [--count 2000] [--seed 0] [--show]

Each damage is a cut, a bit that turns, or bytes that are overwritten. It goes into a random place,
or into a place of a kind: payload, index, head of a chunk, footer, page of a database. The damaged
recording goes through `process`, `report` and `export` in this process. The last lines count, by
form of recording: right and complete; changed, with a line that says so; refused in words; changed
without a line; ended by another exception than the tool's own. Forms without checksums cannot show
a bit that turns inside a number.
"""

from __future__ import annotations

import argparse
import shutil
import struct
import sys
import tempfile
import traceback
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, Final
from unittest.mock import patch

import numpy as np
from mcap.writer import CompressionType
from mcap.writer import Writer as McapLibraryWriter
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

from hybrid_dynamics_core.errors import HybridDynamicsError
from hybrid_dynamics_core.ground.file_kinds import BAG_METADATA, storage_suffix
from hybrid_dynamics_core.library import load
from hybrid_dynamics_ros.bags.analysis.collect import collect
from hybrid_dynamics_ros.bags.analysis.tables import export
from hybrid_dynamics_ros.bags.input_topic import INPUT
from hybrid_dynamics_ros.bags.job import Job
from hybrid_dynamics_ros.bags.make import simulated, write_trajectory
from hybrid_dynamics_ros.bags.process import process
from hybrid_dynamics_ros.bags.storage.bag_reader import BagReader
from hybrid_dynamics_ros.bags.storage.bag_writer import new_bag
from hybrid_dynamics_ros.bags.storage.mcap_chunk import RecordBlock
from hybrid_dynamics_ros.bags.storage.storage import Messages, Topic
from hybrid_dynamics_ros.messages.interfaces import JOINT_STATE, typestore

ROBOT: Final = "five_bar"
PROCESS: Final = "hybrid_dynamics_ros.bags.process"
COLLECT: Final = "hybrid_dynamics_ros.bags.analysis.collect"
STRING: Final = "std_msgs/msg/String"
LABELS: Final = "/labels"
SECONDS: Final = 1.0
RATE: Final = 120.0  # [Hz]
PER_CHUNK: Final = 15  # messages of each topic
OUTPUT: Final = "/hybrid_dynamics/joint_states"
LENGTH: Final = struct.Struct("<BQ")  # head of a record in an MCAP file
RECORDS: Final = {5: "payload", 6: "chunk", 7: "index", 8: "index", 11: "index", 2: "footer"}
CHUNK_HEAD: Final = 48  # bytes of a chunk before its records
DATABASE_PAGE: Final = 4096
PAGE_HEAD: Final = 100  # bytes of a page in which its tree is described
VERDICTS: Final = ("right", "told", "refused", "silent", "traceback")

Pairs = list[tuple[str, int, bytes]]  # topic, log time [ns], message


@dataclass(frozen=True)
class Form:
    """A form of recording.

    Attributes:
        write: writes one into a folder that is not there.
        has_checksums: whether every byte of a message is under one.
    """

    write: Callable[[Path, Pairs], None]
    has_checksums: bool


def recorded(folder: Path) -> Pairs:
    """The messages of all recordings: joint states with efforts, and labels."""
    robot = load(ROBOT)
    write_trajectory(folder, simulated(robot, SECONDS, RATE), INPUT, {})
    label = typestore().types[STRING]
    pairs: Pairs = []
    with BagReader(folder) as bag:
        for _, messages in bag.read(frozenset([INPUT])):
            for k, (log_ns, data) in enumerate(messages.raw()):
                text = bytes(typestore().serialize_cdr(label(f"step {k}"), STRING))
                pairs += [(INPUT, log_ns, data), (LABELS, log_ns + 1, text)]
    return pairs


def _own(path: Path, pairs: Pairs) -> None:
    with new_bag(path, [Topic(INPUT, JOINT_STATE), Topic(LABELS, STRING)]) as bag:
        for begin in range(0, len(pairs), 2 * PER_CHUNK):
            blocks: list[RecordBlock] = []
            for name in (INPUT, LABELS):
                part = [pair for pair in pairs[begin : begin + 2 * PER_CHUNK] if pair[0] == name]
                times = [log_ns for _, log_ns, _ in part]
                messages = Messages.of(times, [data for _, _, data in part])
                blocks += RecordBlock.copies(bag.channels[name], messages)
            bag.write(blocks)


def _of_mcap_library(path: Path, pairs: Pairs) -> None:
    path.mkdir()
    with (path / f"{path.name}.mcap").open("wb") as file:
        writer = McapLibraryWriter(file, chunk_size=2500, compression=CompressionType.ZSTD)
        writer.start(profile="ros2")
        channels = {}
        for topic, kind in ((INPUT, JOINT_STATE), (LABELS, STRING)):
            text, _ = typestore().generate_msgdef(kind, ros_version=2)
            schema = writer.register_schema(kind, "ros2msg", str(text).encode())
            channels[topic] = writer.register_channel(topic, "cdr", schema)
        for topic, log_ns, data in pairs:
            writer.add_message(channels[topic], log_ns, data, log_ns)
        writer.finish()


def _of_rosbags(plugin: StoragePlugin, mode: CompressionMode) -> Callable[[Path, Pairs], None]:
    def write(path: Path, pairs: Pairs) -> None:
        writer = Writer(path, version=9, storage_plugin=plugin)
        writer.set_compression(mode, CompressionFormat.ZSTD)
        with writer:
            topics = {
                topic: writer.add_connection(topic, kind, typestore=typestore())
                for topic, kind in ((INPUT, JOINT_STATE), (LABELS, STRING))
            }
            for topic, log_ns, data in pairs:
                writer.write(topics[topic], log_ns, data)

    return write


FORMS: Final = {
    "mcap": Form(_own, has_checksums=True),
    "mcap of its library": Form(_of_mcap_library, has_checksums=True),
    "mcap of rosbags": Form(
        _of_rosbags(StoragePlugin.MCAP, CompressionMode.NONE), has_checksums=False
    ),
    "mcap, messages packed": Form(
        _of_rosbags(StoragePlugin.MCAP, CompressionMode.MESSAGE), has_checksums=False
    ),
    "sqlite3": Form(_of_rosbags(StoragePlugin.SQLITE3, CompressionMode.NONE), has_checksums=False),
    "sqlite3, file packed": Form(
        _of_rosbags(StoragePlugin.SQLITE3, CompressionMode.FILE), has_checksums=False
    ),
}


def places(raw: bytes, name: str) -> dict[str, list[range]]:
    """Places of a file by kind."""
    result = {"anywhere": [range(len(raw))]}
    if name.endswith(".db3"):
        pages = range(0, len(raw), DATABASE_PAGE)
        result["page"] = [range(page, min(page + PAGE_HEAD, len(raw))) for page in pages]
        return result
    if not name.endswith(".mcap"):
        return result
    for start, code, size in _records(raw):
        end = start + LENGTH.size + size
        result.setdefault("record head", []).append(range(start, start + LENGTH.size))
        if code == 6:
            head = min(start + LENGTH.size + CHUNK_HEAD, end)
            result.setdefault("chunk head", []).append(range(start + LENGTH.size, head))
            result.setdefault("payload", []).append(range(head, end))
        elif code in RECORDS:
            result.setdefault(RECORDS[code], []).append(range(start, end))
    return result


def _records(raw: bytes) -> Iterator[tuple[int, int, int]]:
    """First byte, code, and size of each record."""
    start = 8
    while start + LENGTH.size < len(raw):
        code, size = LENGTH.unpack_from(raw, start)
        yield start, code, size
        start += LENGTH.size + size


def damage(raw: bytes, name: str, rng: np.random.Generator) -> tuple[bytes, str]:
    """A damaged copy of a file, and in words what was done to it."""
    kinds = places(raw, name)
    kind = str(rng.choice(sorted(kinds)))
    ranges = [place for place in kinds[kind] if len(place)]
    place = int(rng.choice(ranges[int(rng.integers(len(ranges)))]))
    copy = bytearray(raw)
    how = rng.random()
    if how < 0.2:
        del copy[place:]
        return bytes(copy), f"cut at byte {place} ({kind})"
    if how < 0.85:
        bit = int(rng.integers(8))
        copy[place] ^= 1 << bit
        return bytes(copy), f"bit {bit} of byte {place} ({kind})"
    count = int(rng.integers(1, 64))
    noise = rng.integers(0, 256, len(copy[place : place + count]), dtype=np.uint8)
    copy[place : place + count] = noise.tobytes()
    return bytes(copy), f"{count} bytes from byte {place} ({kind})"


@dataclass
class Answer:
    """What the three verbs make of a recording.

    Attributes:
        values: all that they give, by what it is.
        lines: what they say that is lost, rejected or strange.
        refusals: errors of the tool, in words.
        failure: another exception, with its traceback; empty without one.
    """

    values: dict[object, Any] = field(default_factory=dict)
    lines: list[str] = field(default_factory=list)
    refusals: list[str] = field(default_factory=list)
    failure: str = ""


def answer_of(path: Path, folder: Path) -> Answer:
    """Run the three verbs."""
    answer = Answer()
    for verb in (_process, _report, _export):
        try:
            # The robot is loaded once, which takes most of the time.
            with patch(f"{PROCESS}.load", loaded), patch(f"{COLLECT}.load", loaded):
                verb(path, folder, answer)
        except (HybridDynamicsError, OSError) as error:
            answer.refusals.append(f"{verb.__name__}: {error}")
        except Exception:  # noqa: BLE001 - that is what is counted
            answer.failure = traceback.format_exc()
    return answer


loaded = cache(load)


def _process(path: Path, folder: Path, answer: Answer) -> None:
    outcome = process(Job(path, folder / "out", ROBOT), shown=False)
    answer.lines += [*outcome.losses, *outcome.rejections.values()]
    if "," in outcome.summary.partition("with efforts")[2]:  # events, as stamps that go back
        answer.lines.append(outcome.summary)
    with BagReader(folder / "out") as bag:
        for name, messages in bag.read(frozenset([OUTPUT])):
            for log_ns, data in messages.raw():
                answer.values[name, log_ns] = data


def _report(path: Path, _: Path, answer: Answer) -> None:
    recording = collect(path, ROBOT, smooth="spline")
    answer.lines += recording.losses
    answer.lines += [why for _, why in recording.refused]
    answer.lines += [f"gap at {begin}" for begin, _ in recording.gaps]
    joints, start = recording.measured, recording.start_ns
    answer.lines += [outlier.describe(joints, start) for outlier in recording.outliers]
    rows = zip(recording.time.tolist(), recording.efforts, recording.recorded, strict=True)
    for time, efforts, measured in rows:
        stamp = start + round(time * 1e9)
        answer.values["report", stamp] = (efforts.tobytes(), measured.tobytes())


def _export(path: Path, folder: Path, answer: Answer) -> None:
    _, losses = export(path, folder / "tables", "csv")
    answer.lines += losses
    for file in sorted((folder / "tables").iterdir()):
        lines = file.read_text(encoding="utf-8").splitlines()
        for k, line in enumerate(lines):
            answer.values[file.name, line.partition(",")[0]] = line if k else lines[0]


def verdict(answer: Answer, right: Answer) -> str:
    """Which of VERDICTS an answer is."""
    if answer.failure:
        return "traceback"
    usual = set(right.lines)
    is_told = any(line not in usual for line in answer.lines)
    if answer.refusals:
        return "refused"
    if is_told:
        return "told"
    return "right" if answer.values == right.values else "silent"


def damaged_copy(source: Path, target: Path, rng: np.random.Generator) -> str:
    """Copy a recording with one file damaged; in words what was done.

    One copy in ten has no metadata, and of one in ten they are damaged.
    """
    shutil.copytree(source, target)
    metadata = target / BAG_METADATA
    files = [file for file in target.iterdir() if storage_suffix(file)]
    chance = rng.random()
    if metadata.exists() and chance < 0.1:
        metadata.unlink()
    if metadata.exists() and chance > 0.9:
        files = [metadata]
    raw, what = damage(files[0].read_bytes(), files[0].name, rng)
    files[0].write_bytes(raw)
    return f"{files[0].name}, {what}" + ("" if metadata.exists() else ", no metadata")


def run(count: int, seed: int, names: Sequence[str], folder: Path) -> Iterator[tuple[str, ...]]:
    """Form, verdict, damage and details of each of some damages."""
    rng = np.random.default_rng(seed)
    pairs = recorded(folder / "recorded")
    rights = {}
    for k, name in enumerate(names):
        path = folder / f"bag{k}"
        FORMS[name].write(path, pairs)
        rights[name] = path, answer_of(path, folder)
        shutil.rmtree(folder / "out")
        shutil.rmtree(folder / "tables")
    for k in range(count):
        name = names[k % len(names)]
        source, right = rights[name]
        work = folder / "work"
        work.mkdir()
        what = damaged_copy(source, work / source.name, rng)
        answer = answer_of(work / source.name, work)
        details = answer.failure or "; ".join([*answer.refusals, *answer.lines][:3])
        yield name, verdict(answer, right), what, details
        shutil.rmtree(work)


def main() -> None:
    """Damage, run, and count."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--form", action="append", choices=FORMS)
    parser.add_argument("--show", action="store_true", help="a line for each damage")
    options = parser.parse_args()
    names = options.form or list(FORMS)
    counts: Counter[tuple[str, str]] = Counter()
    with tempfile.TemporaryDirectory() as folder:
        for name, found, what, details in run(options.count, options.seed, names, Path(folder)):
            counts[name, found] += 1
            if options.show or found in {"silent", "traceback"}:
                print(f"{name}: {found}: {what}: {details}", flush=True)
    print(f"{'':24}" + "".join(f"{verdict:>11}" for verdict in VERDICTS))
    for name in names:
        print(f"{name:24}" + "".join(f"{counts[name, found]:11}" for found in VERDICTS))
    bad = sum(counts[name, "traceback"] for name in names)
    bad += sum(counts[name, "silent"] for name in names if FORMS[name].has_checksums)
    sys.exit(bool(bad))


if __name__ == "__main__":
    main()
