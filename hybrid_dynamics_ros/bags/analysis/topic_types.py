"""Decoders of messages, by the definition in the bag or by a known type."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from rosbags.typesys import get_types_from_idl, get_types_from_msg
from rosbags.typesys.store import Typestore

from ...messages.interfaces import typestore
from ..storage.storage import CDR, ROS2_MSG, Topic

_ROS2_IDL: Final = "ros2idl"

Decode = Callable[[bytes], Any]


class UnknownTypeError(Exception):
    """The messages of a topic cannot be decoded; the text says why."""


def decoder_of(topic: Topic) -> tuple[Decode, str]:
    """The decoder of a topic's messages.

    The definition in the bag is preferred, since the messages were written with it.

    Returns:
        The decoder, and the problem of the definition in the bag; empty if there is none.

    Raises:
        UnknownTypeError: the encoding is not CDR, or the type is neither known nor defined in the
            bag.
    """
    if topic.encoding != CDR:
        raise UnknownTypeError(
            f"its messages are in the encoding '{topic.encoding}'; only {CDR}, that of ROS 2, can"
            " be read"
        )
    kind = topic.kind or "without a name"
    is_shipped = topic.kind in typestore().types
    problem = ""
    try:
        store = _defined(topic)
    except Exception as error:
        if not is_shipped:
            raise UnknownTypeError(
                f"its type {kind} is not known, and its definition in"
                f" the bag cannot be read ({str(error) or type(error).__name__})"
            ) from error
        store = typestore()
        problem = "its definition in the bag cannot be read; the known type is taken"
    if store is None and not is_shipped:
        raise UnknownTypeError(f"its type {kind} is not known, and the bag does not define it")
    chosen = store or typestore()

    def decode(data: bytes) -> Any:
        return chosen.deserialize_cdr(data, topic.kind)

    return decode, problem


def _defined(topic: Topic) -> Typestore | None:
    """Known types, extended by those that the bag defines for a topic; None if it defines none.

    Raises:
        ValueError: the hash of the definition is not the one in the bag.
    """
    if not topic.definition.strip():
        return None
    if topic.language == ROS2_MSG:
        types = get_types_from_msg(topic.definition, topic.kind)
    elif topic.language == _ROS2_IDL:
        types = get_types_from_idl(topic.definition)
    else:
        return None
    store = Typestore()
    base = typestore()
    # The bag's types replace known types of the same name, since a store refuses duplicates.
    for name in base.fielddefs.keys() - types:
        store.fielddefs[name] = base.fielddefs[name]
    for name in base.types.keys() - types:
        store.types[name] = base.types[name]
    store.register(types)
    digest = store.hash_rihs01(topic.kind)
    if topic.digest and topic.digest != digest:
        raise ValueError("its hash is another one")
    return store
