"""The metadata.yaml of a rosbag2 folder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import yaml

from hybrid_dynamics_core.ground.file_kinds import BAG_METADATA

from .qos import profile_entries, read_profiles
from .storage import CDR, Losses, Topic

_ROOT: Final = "rosbag2_bagfile_information"
_SAFE_LOADER: Final = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # the C version is faster
_ERRORS: Final = (OSError, ValueError, KeyError, TypeError, AttributeError, yaml.YAMLError)


@dataclass(frozen=True)
class BagMetadata:
    """The metadata of a bag.

    Attributes:
        file_names: names of the bag's files.
        topics: topics with their numbers of messages.
        message_compression: whether messages are compressed one by one.
    """

    file_names: tuple[str, ...] = ()
    topics: tuple[Topic, ...] = ()
    message_compression: bool = False


def read_metadata(folder: Path, losses: Losses) -> BagMetadata:
    """The metadata of a folder; empty if they are missing or damaged."""
    file = folder / BAG_METADATA
    if not folder.is_dir() or not file.is_file():
        return BagMetadata()
    try:
        entries = _load(file)
        file_names = [Path(str(path)).name for path in entries.get("relative_file_paths") or ()]
        topics = [_topic_of(entry) for entry in entries["topics_with_message_count"] or ()]
        compression = str(entries.get("compression_mode") or "")
    except _ERRORS as error:
        losses.add(
            f"{file.name}: cannot be read ({type(error).__name__}); its files are read without it"
        )
        return BagMetadata()
    return BagMetadata(tuple(file_names), tuple(topics), compression.lower() == "message")


def read_notes(folder: Path) -> dict[str, Any]:
    """The custom data of a bag; empty if they cannot be read."""
    try:
        return dict(_load(folder / BAG_METADATA)["custom_data"])
    except _ERRORS:
        return {}


def metadata_text(
    file_name: str,
    topics: Sequence[Topic],
    log_span: tuple[int, int],
    notes: Mapping[str, str],
) -> str:
    """The text of metadata.yaml for a bag with one MCAP file.

    Args:
        file_name: name of the MCAP file.
        topics: topics with their numbers of messages.
        log_span: first and last log time [ns].
        notes: custom data.
    """
    first, last = log_span
    counts = [topic.message_count or 0 for topic in topics]
    starting_time = {"nanoseconds_since_epoch": first}
    duration = {"nanoseconds": last - first}
    file = {
        "path": file_name,
        "starting_time": starting_time.copy(),  # a copy, since YAML would write an alias
        "duration": duration.copy(),
        "message_count": sum(counts),
    }
    entries = {
        "version": 9,
        "storage_identifier": "mcap",
        "starting_time": starting_time,
        "duration": duration,
        "message_count": sum(counts),
        "topics_with_message_count": [_entry_of(topic) for topic in topics],
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [file_name],
        "files": [file],
        "custom_data": dict(notes) or None,
        "ros_distro": "jazzy",
    }
    return yaml.safe_dump({_ROOT: entries}, sort_keys=False)


def _load(file: Path) -> dict[str, Any]:
    text = file.read_text(encoding="utf-8")
    tree = yaml.load(text, Loader=_SAFE_LOADER)  # noqa: S506 - both loaders are safe
    entries: dict[str, Any] = tree[_ROOT]
    return entries


def _topic_of(entry: Mapping[str, Any]) -> Topic:
    description = entry["topic_metadata"]
    return Topic(
        name=str(description["name"]),
        kind=str(description["type"]),
        qos=read_profiles(description.get("offered_qos_profiles")),
        encoding=str(description.get("serialization_format") or CDR),
        digest=str(description.get("type_description_hash") or ""),
        message_count=int(entry.get("message_count") or 0),
    )


def _entry_of(topic: Topic) -> dict[str, Any]:
    description = {
        "name": topic.name,
        "type": topic.kind,
        "serialization_format": topic.encoding,
        "offered_qos_profiles": profile_entries(topic.qos),
        "type_description_hash": topic.digest,
    }
    return {"topic_metadata": description, "message_count": topic.message_count or 0}
