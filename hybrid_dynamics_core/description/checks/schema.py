"""Check plain data against the published JSON Schema, and say in words what is wrong."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache
from importlib import resources
from typing import Any

import jsonschema
from jsonschema.exceptions import best_match

from ...ground.decimal_commas import comma_in_list, comma_in_mapping
from ...ground.suggestions import did_you_mean, fold_name, suggestion
from ...ground.wording import counted, singular_or_plural
from ..document import Document, Path_
from .examples import example


@cache
def robot_schema() -> dict[str, Any]:
    """The JSON Schema of format 1, as shipped beside this module."""
    text = (
        resources.files("hybrid_dynamics_core.description")
        .joinpath("robot.schema.json")
        .read_text(encoding="utf-8")
    )
    schema: dict[str, Any] = json.loads(text)
    return schema


def check_schema(document: Document, part: str = "") -> None:
    """Raise a DescriptionError at the first entry that does not fit the schema, or one of its definitions."""
    schema = robot_schema()
    if part:
        schema = {"$defs": schema["$defs"], **schema["$defs"][part]}
    if not isinstance(document.data, dict):
        raise document.error(
            (), f"expected a mapping with the keys {', '.join(list(schema['properties'])[:6])}, ..."
        )
    validator = jsonschema.Draft202012Validator(schema)
    error = best_match(validator.iter_errors(document.data), key=_relevance)
    if error is None:
        return
    path: Path_ = tuple(error.absolute_path)
    extra = _extra_key(error)
    raise document.error(path if extra is None else (*path, extra), _words(error, extra))


def _relevance(error: Any) -> Any:
    return (
        -len(error.absolute_path),
        error.validator == "additionalProperties",
    )  # a slip in a key explains the rest


def _extra_key(error: Any) -> str | None:
    if (
        error.validator != "additionalProperties"
        or error.schema.get("additionalProperties") is not False
    ):
        return None
    return next(str(key) for key in error.instance if key not in error.schema.get("properties", {}))


OTHER_WORDS = {  # what other formats and people call the keys
    "weight": ("mass",),
    "inertial": ("inertia", "mass"),
    "centre": ("com",),
    "center": ("com",),
    "actuated": ("active",),
    "motors": ("active",),
    "driven": ("active",),
    "tool": ("end_effector",),
    "ground": ("base",),
    "range": ("limits",),
    "tie": ("between",),
    "mode": ("assembly",),
}
_MISSING = {  # how they are written
    "format": "write `format: 1`, the version of this format",
    "active": "name the driven joints, as in `active: [q1, q2]`",
    "end_effector": (
        "name the link that carries the tool, as in `end_effector: {link: hand, xyz: [0.1, 0, 0]}`"
    ),
    "axis": "the direction along which it moves or about which it turns, as in `axis: z`",
}
_KINDS = {"object": "a mapping", "array": "a list", "string": "text", "number": "a number"}


def _words(error: Any, extra: str | None) -> str:
    if extra is not None:
        known = list(error.schema.get("properties", {}))
        if {"type", "k1"} <= {*known} and extra in ("kind", "between"):  # a closure among the loops
            return (
                "unknown key of a loop of Type A to D; a closure, with kind and between, stands"
                " under 'closures'"
            )
        comma = comma_in_mapping(error.instance, extra)
        if comma:
            return f"unknown key{comma}"
        other = [key for key in OTHER_WORDS.get(fold_name(extra), ()) if key in known]
        hint = did_you_mean(other[0]) if other else suggestion(extra, known)
        return f"unknown key{hint}; known keys: {', '.join(known)}"
    told = error.absolute_path and "description" in error.schema
    hint = f" ({error.schema['description']})" if told else ""
    say = _SAY.get(
        error.validator, lambda e: f"is {_short(e.instance)}; expected something else: {e.message}"
    )
    shown = example(tuple(error.absolute_path), error.instance) if error.validator == "type" else ""
    return say(error) + hint + shown


def _say_missing(error: Any) -> str:
    missing = [key for key in error.schema["required"] if key not in error.instance]
    hints = [f"; {_MISSING[key]}" for key in missing if key in _MISSING]
    return "missing " + ", ".join(f"'{key}'" for key in missing) + (hints or [""])[0]


def _say_type(error: Any) -> str:
    wanted = (
        error.schema["type"] if isinstance(error.schema["type"], list) else [error.schema["type"]]
    )
    return (
        f"is {_short(error.instance)}; expected"
        f" {' or '.join(_KINDS.get(str(kind), str(kind)) for kind in wanted)}"
    )


def _say_size(error: Any) -> str:
    wanted = error.schema.get("minItems", error.schema.get("minProperties"))
    split = isinstance(error.instance, list) and any(
        str(v).count("(") != str(v).count(")") for v in error.instance
    )
    hint = "; put an expression with a comma in quotes" if split else ""
    if isinstance(error.instance, list) and not hint:
        hint = comma_in_list(error.instance, wanted)
        if not hint and error.schema is robot_schema()["$defs"]["vector"]:
            hint = ", as in [x, y, z]"
    return f"has {counted(len(error.instance), 'entry', 'entries')}; expected {wanted}{hint}"


def _say_beside(error: Any) -> str:
    given = [key for key in error.schema["dependentRequired"] if key in error.instance]
    wanted = {other for key in given for other in error.schema["dependentRequired"][key]} - {
        *error.instance
    }
    told, verb, them = (
        " and ".join(given),
        singular_or_plural(len(given), "needs", "need"),
        singular_or_plural(len(given), "it", "them"),
    )
    return f"{told} {verb} {', '.join(repr(key) for key in sorted(wanted))} beside {them}"


def _say_choice(error: Any) -> str:
    known = [str(choice) for choice in error.schema["enum"]]
    hint = suggestion(error.instance, known) if isinstance(error.instance, str) else ""
    return f"is {error.instance!r}{hint}; expected one of {', '.join(known)}"


def _say_name(error: Any) -> str:
    name = str(error.instance)
    hint = (
        f"; if it is part of a number, decimals are written with a point, as 0.{name}"
        if name.isdigit()
        else ""
    )
    return f"'{name}' is not a valid name: letters, digits and _, a letter first, at most 64{hint}"


_SAY: dict[str, Callable[[Any], str]] = {
    "required": _say_missing,
    "type": _say_type,
    "minItems": _say_size,
    "maxItems": _say_size,
    "minProperties": _say_size,
    "maxProperties": _say_size,
    "dependentRequired": _say_beside,
    "enum": _say_choice,
    "const": lambda e: f"is {e.instance!r}; expected {e.schema['const']!r}",
    "not": lambda e: f"has keys that exclude each other: {', '.join(e.instance)}",
    "minLength": lambda _: "is empty; expected a name",
    "maxLength": lambda e: (
        f"{_short(e.instance)} is longer than {e.schema['maxLength']} characters"
    ),
    "minimum": lambda e: f"is {e.instance}; expected {e.schema['minimum']} or more",
    "oneOf": lambda e: f"is {_short(e.instance)}; expected another form",
    "uniqueItems": lambda e: f"names one entry twice: {_short(e.instance)}",
    "pattern": _say_name,
}


def _short(value: Any) -> str:
    text = "nothing" if value is None else repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
