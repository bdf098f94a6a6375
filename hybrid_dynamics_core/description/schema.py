"""Check plain data against the published JSON Schema, and say in words what is wrong."""

from __future__ import annotations

import difflib
import json
from collections.abc import Iterable
from functools import cache
from importlib import resources
from typing import Any

import jsonschema
from jsonschema.exceptions import best_match

from .located_yaml import LocatedDocument, Path_


@cache
def robot_schema() -> dict[str, Any]:
    """The JSON Schema of format 1, as shipped beside this module."""
    text = resources.files(__package__).joinpath("robot.schema.json").read_text(encoding="utf-8")
    schema: dict[str, Any] = json.loads(text)
    return schema


def check_schema(document: LocatedDocument) -> None:
    """Raise a DescriptionError at the first entry that does not fit the schema."""
    if not isinstance(document.data, dict):
        raise document.error((), "expected a mapping with the keys format, name, links, joints, ...")
    validator = jsonschema.Draft202012Validator(robot_schema())
    error = best_match(validator.iter_errors(document.data), key=_relevance)
    if error is None:
        return
    path: Path_ = tuple(error.absolute_path)
    extra = _extra_key(error)
    raise document.error((*path, extra) if extra else path, _words(error, extra))


def _relevance(error: Any) -> Any:
    return (-len(error.absolute_path), error.validator not in ("additionalProperties", "required"))


def nearest(name: str, known: Iterable[str]) -> str:
    """A hint such as ' (did you mean "mass"?)', or nothing."""
    match = difflib.get_close_matches(name, list(known), n=1)
    return f" (did you mean '{match[0]}'?)" if match else ""


def _extra_key(error: Any) -> str:
    if error.validator != "additionalProperties" or error.schema.get("additionalProperties") is not False:
        return ""
    return str(next(key for key in error.instance if key not in error.schema.get("properties", {})))


def _words(error: Any, extra: str) -> str:
    schema, value = error.schema, error.instance
    hint = f" ({schema['description']})" if "description" in schema else ""
    if extra:
        known = list(schema.get("properties", {}))
        return f"unknown key{nearest(extra, known)}; known keys: {', '.join(known)}"
    if error.validator == "required":
        missing = [key for key in schema["required"] if key not in value]
        return f"missing {', '.join(repr(key) for key in missing)}{hint}"
    if error.validator == "dependentRequired":
        return "needs 'mass' beside it"
    if error.validator == "enum":
        return f"is {value!r}; expected one of {', '.join(map(str, schema['enum']))}{hint}"
    if error.validator == "const":
        return f"is {value!r}; expected {schema['const']!r}{hint}"
    if error.validator == "type":
        kinds = schema["type"] if isinstance(schema["type"], list) else [schema["type"]]
        names = {"object": "a mapping", "array": "a list", "string": "text", "number": "a number"}
        return f"is {_short(value)}; expected {' or '.join(names.get(k, k) for k in kinds)}{hint}"
    if error.validator in ("minItems", "maxItems") and isinstance(value, list):
        return f"has {len(value)} entries; expected {schema.get('minItems')}" + hint
    if error.validator == "pattern":
        return f"'{value}' is not a valid name: letters, digits and _, a letter first, at most 64"
    return f"is {_short(value)}: {error.message if not hint else 'expected' + hint}"


def _short(value: Any) -> str:
    text = "nothing" if value is None else repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
