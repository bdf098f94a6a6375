"""Delegation of a facade's methods to its parts."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from operator import attrgetter
from typing import Any, Concatenate, ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")


def delegate(
    part: str, method: Callable[Concatenate[Any, P], T]
) -> Callable[Concatenate[Any, P], T]:
    """Make a method that calls the same method of a part of the facade.

    Signature and docstring are those of the part's method.

    Args:
        part: attribute of the facade that holds the part.
        method: method of the part's class.

    Returns:
        The method of the facade.
    """
    method_of_part = attrgetter(f"{part}.{method.__name__}")

    @wraps(method)
    def call(facade: Any, /, *args: P.args, **kwargs: P.kwargs) -> T:
        result: T = method_of_part(facade)(*args, **kwargs)
        return result

    return call
