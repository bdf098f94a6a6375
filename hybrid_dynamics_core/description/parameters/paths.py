"""Names and paths of the numbers of a description.

A name is one of `parameters:`. A path has keys and indices as in the file: `links.boom.mass`,
`joints.q2.origin.xyz[0]`. A path without its last index means all numbers of a list. Entries that
short forms stand for, such as joints of modules, have paths too. Pins of loops may be named by the
role of their link: `loops.lift.pin.arm[0]`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from ...errors import InputError, UnknownNameError
from ...ground.arrays import Array, frozen
from ...ground.suggestions import suggestion
from ..document import Document, KeyPath, dotted
from ..expressions import evaluate
from ..model import RobotDescription
from ..value_units import units_at
from ..values import ValueReader
from .entries_at import entry_at, has_entry
from .number_keys import is_number_key, is_schema_key, number_leaves, unwritten
from .pin_roles import with_link
from .written import Written, written_of

_PARAMETERS = "parameters"
_INDEX = re.compile(r"\[(\d+)\]")
_NUMBERS = (int, float, np.integer, np.floating)
_KEY_END = re.compile(r"[.\[]")
_PLAIN = ("visuals", "templates", "format")  # parts whose numbers are no parameters


def parameter_paths(description: RobotDescription) -> Mapping[str, float]:
    """All numbers of a description: names of `parameters:`, then paths, with values in SI units.

    Numbers that are left out and count as zero, such as `joints.q1.offset`, are not listed, but
    can be read and changed.

    Raises:
        InputError: the description was not read from a file.
    """
    before, after = written_of(description).expanded
    result: dict[str, float] = {}
    for document in (before, after):
        values = ValueReader(after)
        for path in _listed(document):
            name = name_of(path)
            if name not in result:
                result[name] = _number(values, document, path)
    return result


def parameter_value(description: RobotDescription, name: str) -> float | Array:
    """The value of a number, in SI units; an array (k,) if the path means several.

    Args:
        description: a description that was read from a file.
        name: a name of `parameters:`, or a path.

    Raises:
        InputError: there is no such number.
    """
    written = written_of(description)
    path = path_of(written, name)
    components = component_paths(written, name)
    if components == [path]:
        return number_at(written, path)
    return frozen([number_at(written, component) for component in components])


def with_parameters(description: RobotDescription, values: Mapping[str, Any]) -> RobotDescription:
    """The description with other numbers, as if its file had them.

    Args:
        description: a description that was read from a file; not changed.
        values: numbers in SI units, or expressions, by name of `parameters:` or path. A path that
            means several numbers takes as many.

    Raises:
        InputError: there is no such number, a value is none, or there are too many or too few.
        DescriptionError: the numbers do not fit the description.
    """
    written = written_of(description)
    changes: dict[KeyPath, Any] = {}
    for name, value in values.items():
        path = path_of(written, name)
        if path in changes:
            raise InputError(f"{name_of(path)} is given twice, the second time as '{name}'")
        changes[path] = _checked(written, name, path, value)
    return written.changed(changes).described()


def name_of(path: KeyPath) -> str:
    """The name of a number: that in `parameters:`, or its path."""
    if path[0] == _PARAMETERS:
        return dotted(path[1:])
    return dotted(path)


def component_paths(written: Written, name: str) -> list[KeyPath]:
    """The path of a number, or the paths of all numbers in a list.

    Raises:
        InputError: there is no such number.
    """
    path = path_of(written, name)
    entry = entry_at(_document_of(written, path).data, path)
    if not isinstance(entry, list):
        return [path]
    return [(*path, k) for k in range(len(entry))]


def number_at(written: Written, path: KeyPath) -> float:
    """The number at a path, in SI units."""
    _, after = written.expanded
    return _number(ValueReader(after), _document_of(written, path), path)


def _document_of(written: Written, path: KeyPath) -> Document:
    """The document that has an entry: as it was written, or with short forms expanded."""
    before, after = written.expanded
    return before if has_entry(before.data, path[:2]) else after


def path_of(written: Written, name: str) -> KeyPath:
    """The path of a name.

    Raises:
        InputError: there is no such number; the message has names that are near.
    """
    if not isinstance(name, str):
        raise InputError(f"a parameter is named by a text, not by {name!r}")
    before, after = written.expanded
    text = str(name).strip()
    if text in before.entries(_PARAMETERS):
        return (_PARAMETERS, text)
    for document in (before, after):
        for path in _resolved(document.data, with_link(document, text), ()):
            if _is_parameter(document, path):
                return path
    raise UnknownNameError(_unknown(text, before, after))


def _is_parameter(document: Document, path: KeyPath) -> bool:
    if not path or path[0] in _PLAIN or "visuals" in path:
        return False
    entry = entry_at(document.data, path)
    if isinstance(entry, list):
        inner = [(*path, k) for k in range(len(entry))]
        return bool(inner) and all(map(is_number_key, inner))
    return entry is not None and is_number_key(path)


def _resolved(data: Any, text: str, path: KeyPath) -> Iterator[KeyPath]:
    """Paths that a text may mean; names may have dots, so the longest key comes first."""
    if not text:
        yield path
        return
    index = _INDEX.match(text)
    if index:
        number = int(index[1])
        inner = _inside(data, number)
        yield from _resolved(inner, _behind(text, index[0]), (*path, number))
        return
    for key in _first_keys(data, text, path):
        inner_path = (*path, key)
        inner = _inside(data, key)
        if inner is None:
            inner = unwritten(inner_path)
        yield from _resolved(inner, _behind(text, key), inner_path)


def _behind(text: str, key: str) -> str:
    """The text after its first key."""
    return text[len(key) :].removeprefix(".")


def _first_keys(data: Any, text: str, path: KeyPath) -> list[str]:
    """Keys with which a text may begin, the longest first; the data may lack one of the schema."""
    candidates = {key for key in _keys(data) if isinstance(key, str) and _begins(text, key)}
    simple = _KEY_END.split(text, maxsplit=1)[0]
    if is_schema_key((*path, simple)):
        candidates.add(simple)
    return sorted(candidates, key=len, reverse=True)


def _keys(data: Any) -> Iterable[Any]:
    """Keys of a mapping; none of anything else."""
    return data if isinstance(data, dict) else ()


def _begins(text: str, key: str) -> bool:
    return text == key or text.startswith((f"{key}.", f"{key}["))


def _inside(data: Any, key: str | int) -> Any:
    if isinstance(data, dict):
        return data.get(key)
    if isinstance(data, list) and isinstance(key, int) and key < len(data):
        return data[key]
    return None


def _unknown(name: str, before: Document, after: Document) -> str:
    """The message for a name that is no number of the description."""
    parameters = list(before.entries(_PARAMETERS))
    paths = [name_of(path) for path in (*_listed(before), *_listed(after))]
    hint = suggestion(name, dict.fromkeys(paths))
    listed = ", ".join(parameters) or "none"
    return (
        f"there is no parameter '{name}'{hint}; parameters: {listed}; other numbers are named by"
        " their place in the file, as links.NAME.mass, joints.NAME.origin.xyz[0]"
        " or modules.NAME.parameters.NAME"
    )


def _listed(document: Document) -> Iterator[KeyPath]:
    """Paths of the numbers of a document, each once: pins of loops are closures too."""
    pins = document.entries("loops")
    for path in number_leaves(document.data):
        is_pin = path[0] == "closures" and path[1] in pins
        if not is_pin and path[0] not in _PLAIN and "visuals" not in path:
            yield path


def _number(values: ValueReader, document: Document, path: KeyPath) -> float:
    entry = entry_at(document.data, path)
    return values.number_or_infinity(entry, path)


def _checked(written: Written, name: str, path: KeyPath, value: Any) -> Any:
    """The value as plain data: a number, an expression, or a list of them."""
    _check_unit(written, name, path, value)
    former = entry_at(_document_of(written, path).data, path)
    if not isinstance(former, list):
        return _plain(name, value)
    if isinstance(value, str) or not isinstance(value, (Sequence, np.ndarray)):
        raise InputError(f"{name} means {len(former)} numbers; {value!r} is given")
    if len(value) != len(former):
        raise InputError(f"{name} means {len(former)} numbers; {len(value)} are given")
    return [_plain(name, one) for one in value]


def _check_unit(written: Written, name: str, path: KeyPath, value: Any) -> None:
    """Raise InputError for an expression in another unit than the entries that are a parameter."""
    if path[0] != _PARAMETERS or not isinstance(value, str):
        return
    _, after = written.expanded
    units = units_of(written, path)
    if not units:
        return
    numbers = ValueReader(after).parameters
    try:
        evaluate(value, numbers, units=units)
    except (ValueError, ArithmeticError) as error:
        raise InputError(f"{name}: {error}") from error


def units_of(written: Written, path: KeyPath) -> tuple[str, ...]:
    """Allowed units of a number, also of one in `parameters:`; empty if any is allowed."""
    _, after = written.expanded
    if path[0] == _PARAMETERS:
        return units_of_parameter(after, str(path[1]))
    return units_at(after, path)


def units_of_parameter(document: Document, name: str) -> tuple[str, ...]:
    """Allowed units of a number of `parameters:`, by the entries that are this number or a share.

    They are empty if there is no such entry, or if entries of several units are.
    """
    alone = re.compile(rf"\s*-?\s*{re.escape(name)}(\s*[*/]\s*[\d.]+)?\s*")
    units: set[tuple[str, ...]] = set()
    for path in number_leaves(document.data):
        entry = entry_at(document.data, path)
        if isinstance(entry, str) and path[0] != _PARAMETERS and alone.fullmatch(entry):
            units.add(units_at(document, path))
    units.discard(())  # of places that do not say
    if len(units) != 1:
        return ()
    return units.pop()


def _plain(name: str, value: Any) -> float | str:
    if isinstance(value, str):
        return value
    if isinstance(value, _NUMBERS) and not isinstance(value, bool):
        number = float(value)
        if not math.isnan(number):  # limits may be infinite
            return number
    raise InputError(f"{name} is {value!r}; expected a number in SI units or an expression")
