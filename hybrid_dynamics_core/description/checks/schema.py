"""Validation of plain data with the published JSON Schema."""

from __future__ import annotations

import json
from functools import cache
from importlib import resources
from typing import Any

from ..document import Data, Document, KeyPath
from .schema_messages import schema_message

_EXAMPLE_KEYS = 6  # keys listed in the error for a value that is no mapping


@cache
def robot_schema() -> Data:
    """The JSON Schema of format 1."""
    folder = resources.files("hybrid_dynamics_core.description")
    text = folder.joinpath("robot.schema.json").read_text(encoding="utf-8")
    schema: Data = json.loads(text)
    return schema


def check_schema(document: Document, definition: str = "") -> None:
    """Check a document against the schema, or against one of its definitions.

    Args:
        document: the document to check.
        definition: name under `$defs`; empty for a robot.

    Raises:
        DescriptionError: the first entry that does not fit.
    """
    schema = robot_schema()
    if definition:
        schema = {"$defs": schema["$defs"], **schema["$defs"][definition]}
    if not isinstance(document.data, dict):
        keys = ", ".join(list(schema["properties"])[:_EXAMPLE_KEYS])
        raise document.error((), f"expected a mapping with the keys {keys}, ...")
    # Imported late: processes that get their robot as data need no validator.
    import jsonschema  # noqa: PLC0415
    from jsonschema.exceptions import best_match  # noqa: PLC0415

    validator = jsonschema.Draft202012Validator(schema)
    error = best_match(validator.iter_errors(document.data), key=_relevance)
    if error is None:
        return
    path: KeyPath = tuple(error.absolute_path)
    unknown_key = _unknown_key(error)
    if unknown_key is not None:
        path = (*path, unknown_key)
    raise document.error(path, schema_message(error, unknown_key))


def _relevance(error: Any) -> tuple[int, bool]:
    """Sort key of errors: outer entries first, and unknown keys before other errors."""
    return -len(error.absolute_path), error.validator == "additionalProperties"


def _unknown_key(error: Any) -> str | None:
    """The first key that the schema does not know, if that is the error."""
    if error.validator != "additionalProperties":
        return None
    if error.schema.get("additionalProperties") is not False:
        return None
    properties = error.schema.get("properties", {})
    return next(str(key) for key in error.instance if key not in properties)
