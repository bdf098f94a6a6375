"""Choice of the topic with the samples of a bag."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from hybrid_dynamics_core.ground.suggestions import suggestion

from ..messages.interfaces import JOINT_STATE
from .batch_outputs import NODE
from .errors import BagCallError, BagError
from .storage.bag_reader import BagReader
from .storage.storage import CDR

INPUT: Final = f"{NODE}/active_joint_states"
_MAX_LOSSES: Final = 3  # listed in an error


def input_topic(
    source: BagReader, wanted: str | None, kinds: Sequence[str] = (JOINT_STATE,)
) -> str:
    """The topic with the samples.

    Args:
        source: the bag.
        wanted: name of the topic; None: the node's topic of joint states, or the only topic of the
            first existing message type.
        kinds: accepted message types.

    Raises:
        BagError: there is no such topic.
        BagCallError: the named topic is missing, or there are several candidates.
    """
    names_by_kind = [_names_of(source, kind) for kind in kinds]
    candidates = [name for names in names_by_kind for name in names]
    types = " or ".join(kinds)
    _require_encoding(source, wanted, kinds, candidates)
    if not candidates:
        raise BagError(
            f"{source.path}: holds no topic of type {types}; its topics: {_listed(source)}"
        )
    listed = ", ".join(candidates)
    if wanted is not None and wanted not in candidates:
        hint = suggestion(wanted, candidates)
        raise BagCallError(
            f"{source.path}: no topic {wanted} of type {types}{hint}; topics of this type: {listed}"
        )
    if wanted is not None:
        return wanted
    if INPUT in candidates:
        return INPUT
    first = next(names for names in names_by_kind if names)
    if len(first) != 1:
        raise BagCallError(
            f"{source.path}: which topic holds the joint states? Name it with --topic; there are:"
            f" {listed}"
        )
    return first[0]


def _names_of(source: BagReader, kind: str) -> list[str]:
    topics = source.topics.values()
    return [topic.name for topic in topics if topic.kind == kind and topic.encoding == CDR]


def _listed(source: BagReader) -> str:
    """Text on all topics with their types, and on losses of the reader."""
    topics = [f"{topic.name} ({topic.kind or 'no type'})" for topic in source.topics.values()]
    text = ", ".join(topics) or "none that can be read"
    for loss in source.losses.describe()[:_MAX_LOSSES]:
        text += f"; lost: {loss.removeprefix(f'{source.path.name}: ')}"
    return text


def _require_encoding(
    source: BagReader, wanted: str | None, kinds: Sequence[str], candidates: Sequence[str]
) -> None:
    """Check that samples are in the encoding of ROS 2.

    Raises:
        BagError: the topic, or all topics of these types, have another encoding.
    """
    short_kinds = {kind.replace("/msg/", "/") for kind in kinds}  # names in ROS 1
    for topic in source.topics.values():
        is_of_kind = topic.kind.replace("/msg/", "/") in short_kinds
        if not is_of_kind or topic.encoding == CDR:
            continue
        if wanted == topic.name or (wanted is None and not candidates):
            raise BagError(
                f"{source.path}: {topic.name}: its messages ({topic.kind}) are in the encoding"
                f" '{topic.encoding}', and expected is {CDR}, that of ROS 2; convert the recording"
                " first (one of ROS 1: rosbags-convert of the package rosbags)"
            )
