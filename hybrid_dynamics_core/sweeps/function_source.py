"""What a function of a study is, as text: its source, and the values that it takes from outside."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..errors import InputError
from .designs import EachRobot

PLAIN = (bool, int, float, complex, str, bytes, type(None))


def source_of(function: Any) -> str:
    """The text of a function; functions that it calls by name belong to it.

    Values from outside count if they are numbers, texts, arrays, or lists and mappings of these.

    Raises:
        InputError: Python has neither source nor code of it.
    """
    if function is None:
        return ""
    if isinstance(function, EachRobot):
        return f"each {source_of(function.function)}"
    texts: dict[Any, str] = {}
    _collect(function, texts)
    return "\n".join(texts.values())


def _collect(function: Any, texts: dict[Any, str]) -> None:
    """Add the text of a function, and of those that it calls."""
    text = _source(function)
    texts[function] = text
    if not inspect.isfunction(function):
        return
    outside = inspect.getclosurevars(function)
    values = {**outside.globals, **outside.nonlocals}
    values |= {"defaults": function.__defaults__, "keywords": function.__kwdefaults__}
    called: list[Any] = []
    for name, value in values.items():
        if not inspect.isfunction(value):
            text += f"\n{name} = {_plain(value)}"
        elif value.__module__ == function.__module__:
            called.append(value)
    texts[function] = text
    for other in called:
        if other not in texts:
            _collect(other, texts)


def _source(function: Any) -> str:
    """The source of a function; its code where there is none."""
    try:
        return inspect.getsource(function)
    except (OSError, TypeError):
        code = getattr(function, "__code__", None)
        if code is None:
            raise InputError("function: expected a function that Python can name") from None
        return f"{code.co_code.hex()} {code.co_consts} {code.co_names}"


def _plain(value: Any) -> str:
    """A value as text; empty if it is no plain data."""
    if isinstance(value, PLAIN):
        return repr(value)
    if isinstance(value, np.ndarray):
        return f"{value.dtype} {value.shape} {value.tobytes().hex()}"
    if isinstance(value, Mapping):
        return str([(_plain(key), _plain(one)) for key, one in value.items()])
    if isinstance(value, (list, tuple)):
        return str([_plain(one) for one in value])
    return ""
