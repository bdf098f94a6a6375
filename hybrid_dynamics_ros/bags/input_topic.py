"""The topic of a bag that holds the samples."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from hybrid_dynamics_core.ground.suggestions import suggestion

from ..messages.interfaces import JOINT_STATE
from .batch_outputs import NODE
from .errors import BagCallError, BagError
from .storage.bag_reader import BagReader

INPUT: Final = f"{NODE}/active_joint_states"


def input_topic(
    source: BagReader, wanted: str | None, kinds: Sequence[str] = (JOINT_STATE,)
) -> str:
    """The topic with the samples.

    Args:
        source: the bag.
        wanted: name of the topic; None: the node's own topic of joint states, or the only topic of
            the first message type that is there.
        kinds: message types that are taken.

    Raises:
        BagError: there is none.
        BagCallError: there is none of the wanted name, or it is not clear which.
    """
    names_by_kind = [_names_of(source, kind) for kind in kinds]
    candidates = [name for names in names_by_kind for name in names]
    types = " or ".join(kinds)
    if not candidates:
        others = ", ".join(source.topics) or "none that can be read"
        raise BagError(f"{source.path}: holds no topic of type {types}; its topics: {others}")
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
    return [topic.name for topic in source.topics.values() if topic.kind == kind]
