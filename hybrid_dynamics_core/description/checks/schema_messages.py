"""Texts for errors of the JSON Schema: the value, what was expected, and a suggestion."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ...ground.decimal_commas import comma_in_list, comma_in_mapping
from ...ground.suggestions import did_you_mean, fold_name, suggestion
from ...ground.wording import counted, singular_or_plural
from .examples import example

_MAX_SHOWN = 60  # characters of a value
_OTHER_WORDS = {  # other names of keys, from other formats
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
_HOW_TO_WRITE = {  # examples for missing keys
    "format": "write `format: 1`, the version of this format",
    "active": "name the driven joints, as in `active: [q1, q2]`",
    "end_effector": (
        "name the link that carries the tool, as in `end_effector: {link: hand, xyz: [0.1, 0, 0]}`"
    ),
    "axis": "the direction along which it moves or about which it turns, as in `axis: z`",
}
_NUMBER = {"$ref": "#/$defs/number"}
_ALLOWED_NAMES = {  # by the pattern of a name
    "^[A-Za-z0-9_][A-Za-z0-9_./-]{0,199}$": (
        ": letters, digits and _ - . /, the first a letter, a digit or _, at most 200"
    ),
    "^[A-Za-z_][A-Za-z0-9_]*$": ": letters, digits and _, no digit first, as expressions have them",
}
_TYPES = {"object": "a mapping", "array": "a list", "string": "text", "number": "a number"}


def schema_message(error: Any, unknown_key: str | None) -> str:
    """The error text for an entry.

    Args:
        error: a ValidationError of jsonschema.
        unknown_key: a key of the entry that the schema does not know, or None.
    """
    if unknown_key is not None:
        return _unknown(error, unknown_key)
    message = _MESSAGES.get(error.validator, _other)(error)
    if error.absolute_path and "description" in error.schema:
        message += f" ({error.schema['description']})"
    if error.validator == "type":
        message += example(tuple(error.absolute_path), error.instance)
    return message


def _unknown(error: Any, key: str) -> str:
    keys = list(error.schema.get("properties", {}))
    in_loop = "type" in keys and "k1" in keys
    if in_loop and key in ("kind", "between"):
        return (
            "unknown key of a loop of Type A to D; a closure, with kind and between, stands under"
            " 'closures'"
        )
    comma_hint = comma_in_mapping(error.instance, key)
    if comma_hint:
        return f"unknown key{comma_hint}"
    hint = suggestion(key, keys)
    for word in _OTHER_WORDS.get(fold_name(key), ()):
        if word in keys:
            hint = did_you_mean(word)
            break
    return f"unknown key{hint}; known keys: {', '.join(keys)}"


def _missing(error: Any) -> str:
    keys = [key for key in error.schema["required"] if key not in error.instance]
    message = "missing " + ", ".join(f"'{key}'" for key in keys)
    for key in keys:
        if key in _HOW_TO_WRITE:
            return f"{message}; {_HOW_TO_WRITE[key]}"
    return message


def _wrong_type(error: Any) -> str:
    types = error.schema["type"]
    if not isinstance(types, list):
        types = [types]
    expected = " or ".join(_TYPES.get(str(name), str(name)) for name in types)
    hint = ""
    if types == ["string"] and isinstance(error.instance, (bool, int, float)):
        hint = f"; a name that YAML takes for something else stands in quotes: '{error.instance}'"
    return f"is {_shown(error.instance)}; expected {expected}{hint}"


def _wrong_size(error: Any) -> str:
    expected = error.schema.get("minItems", error.schema.get("minProperties"))
    hint = ""
    if isinstance(error.instance, list):
        hint = _list_hint(error.instance, expected, error.schema)
    entries = counted(len(error.instance), "entry", "entries")
    return f"has {entries}; expected {expected}{hint}"


def _list_hint(values: list[Any], expected: int, schema: Any) -> str:
    if any(map(_has_open_parenthesis, values)):
        return "; put an expression with a comma in quotes"
    hint = comma_in_list(values, expected)
    if not hint and expected == 3 and schema.get("items") == _NUMBER:
        hint = ", as in [x, y, z]"
    return hint


def _has_open_parenthesis(value: Any) -> bool:
    """Whether a value is a part of an expression that was split at a comma."""
    text = str(value)
    return text.count("(") != text.count(")")


def _missing_beside(error: Any) -> str:
    """The error text for a key that requires another one."""
    required = error.schema["dependentRequired"]
    given = [key for key in required if key in error.instance]
    missing: set[str] = set()
    for key in given:
        missing.update(required[key])
    missing.difference_update(error.instance)
    listed = ", ".join(repr(key) for key in sorted(missing))
    verb = singular_or_plural(len(given), "needs", "need")
    pronoun = singular_or_plural(len(given), "it", "them")
    return f"{' and '.join(given)} {verb} {listed} beside {pronoun}"


def _wrong_choice(error: Any) -> str:
    choices = [str(choice) for choice in error.schema["enum"]]
    hint = ""
    if isinstance(error.instance, str):
        hint = suggestion(error.instance, choices)
    return f"is {error.instance!r}{hint}; expected one of {', '.join(choices)}"


def _wrong_name(error: Any) -> str:
    name = str(error.instance)
    allowed = _ALLOWED_NAMES.get(error.validator_value, "")
    hint = ""
    if name.isdigit():
        hint = f"; if it is part of a number, decimals are written with a point, as 0.{name}"
    return f"'{name}' is not a valid name{allowed}{hint}"


def _other(error: Any) -> str:
    return f"is {_shown(error.instance)}; expected something else: {error.message}"


def _shown(value: Any) -> str:
    text = "nothing" if value is None else repr(value)
    if len(text) > _MAX_SHOWN:
        return text[: _MAX_SHOWN - 3] + "..."
    return text


_MESSAGES: dict[str, Callable[[Any], str]] = {
    "required": _missing,
    "type": _wrong_type,
    "minItems": _wrong_size,
    "maxItems": _wrong_size,
    "minProperties": _wrong_size,
    "maxProperties": _wrong_size,
    "dependentRequired": _missing_beside,
    "enum": _wrong_choice,
    "const": lambda error: f"is {error.instance!r}; expected {error.schema['const']!r}",
    "not": lambda error: f"has keys that exclude each other: {', '.join(error.instance)}",
    "minLength": lambda _: "is empty; expected a name",
    "maxLength": lambda error: (
        f"{_shown(error.instance)} is longer than {error.schema['maxLength']} characters"
    ),
    "minimum": lambda error: f"is {error.instance}; expected {error.schema['minimum']} or more",
    "oneOf": lambda error: f"is {_shown(error.instance)}; expected another form",
    "uniqueItems": lambda error: f"names one entry twice: {_shown(error.instance)}",
    "pattern": _wrong_name,
}
