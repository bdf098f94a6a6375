"""Safe YAML reader with the line of every entry, YAML 1.2 numbers and no duplicate keys."""

from __future__ import annotations

import re
from typing import Any

import yaml
from yaml.reader import ReaderError

from ..errors import DescriptionError
from .document import Data, Document, FilePath, KeyPath, dotted
from .yaml_errors import syntax_problem

MAX_NODES = 200_000  # aliases may expand a small file without bound

_CORE_TAG = "tag:yaml.org,2002:"
_PYTHON_TAG = "tag:yaml.org,2002:python"
_INT = re.compile(r"^[-+]?[0-9]+$")
_FLOAT = re.compile(
    r"^(?:[-+]?(?:[0-9]+\.[0-9]*|\.[0-9]+|[0-9]+)(?:[eE][-+]?[0-9]+)?"
    r"|[-+]?\.(?:inf|Inf)|\.(?:nan|NaN))$"
)
_BOOL = re.compile(r"^(?:true|True|false|False)$")


class _Loader(yaml.SafeLoader):
    """SafeLoader that also knows floats such as 1e-3, and leaves yes/no/on/off as text."""


def _remaining_resolvers() -> dict[str, list[tuple[str, re.Pattern[str]]]]:
    """Resolvers of SafeLoader by first letter, without those that _Loader replaces."""
    replaced = {_CORE_TAG + kind for kind in ("float", "bool", "int")}
    resolvers = {}
    for letter, entries in yaml.SafeLoader.yaml_implicit_resolvers.items():
        resolvers[letter] = [(tag, pattern) for tag, pattern in entries if tag not in replaced]
    return resolvers


_Loader.yaml_implicit_resolvers = _remaining_resolvers()
_Loader.add_implicit_resolver(_CORE_TAG + "bool", _BOOL, list("tTfF"))
_Loader.add_implicit_resolver(_CORE_TAG + "int", _INT, list("-+0123456789"))
_Loader.add_implicit_resolver(_CORE_TAG + "float", _FLOAT, list("-+.0123456789"))


def _decimal(loader: yaml.SafeLoader, node: yaml.ScalarNode) -> int:
    """An integer as YAML 1.2 has it: 012 is twelve, where YAML 1.1 has an octal ten."""
    return int(str(loader.construct_scalar(node)))


_Loader.add_constructor(_CORE_TAG + "int", _decimal)


def read_yaml(text: str, file: FilePath = None) -> Document:
    """The document of a YAML text.

    Args:
        text: the YAML.
        file: the file it was read from, for messages.

    Raises:
        DescriptionError: the text is not valid, repeats a key, or has tags that stand for code.
    """
    return _Reader(text, file).document()


class _Reader:
    def __init__(self, text: str, file: FilePath) -> None:
        self.text = text
        self.file = file
        self._lines: dict[KeyPath, int] = {(): 1}
        self._count = 0

    def document(self) -> Document:
        loader = self._loader()
        data = None
        try:
            node = loader.get_single_node()
            if node is not None:
                data = self._value(loader, node, ())
        except yaml.MarkedYAMLError as error:
            problem, line = syntax_problem(self.text, error, _Loader)
            raise self._error(f"not valid YAML: {problem}", line) from error
        except yaml.YAMLError as error:
            raise self._error(f"not valid YAML: {error}") from error
        except RecursionError:
            raise self._error("nested too deeply (an alias inside itself?)") from None
        finally:
            loader.dispose()
        return Document(data, self.file, self._lines)

    def _loader(self) -> _Loader:
        try:
            return _Loader(self.text)
        except ReaderError as error:
            line = self.text[: error.position].count("\n") + 1
            code = ord(self.text[error.position])
            raise self._error(
                f"not valid YAML: the character U+{code:04X} is not allowed", line
            ) from error

    def _value(self, loader: _Loader, node: yaml.Node, path: KeyPath) -> Any:
        line = node.start_mark.line + 1
        self._count += 1
        if self._count > MAX_NODES:
            raise self._error("too many entries (aliases that multiply?)", path=path)
        self._lines.setdefault(path, line)
        if not node.tag.startswith(_CORE_TAG) or node.tag.startswith(_PYTHON_TAG):
            raise self._error(f"the tag {node.tag} is not allowed; plain values only", line)
        if isinstance(node, yaml.MappingNode):
            return self._mapping(loader, node, path)
        if isinstance(node, yaml.SequenceNode):
            return [self._value(loader, child, (*path, k)) for k, child in enumerate(node.value)]
        try:
            return loader.construct_object(node)
        except ValueError as error:
            raise self._error(f"not a value: {error}", line, path) from error

    def _mapping(self, loader: _Loader, node: yaml.MappingNode, path: KeyPath) -> Data:
        mapping: Data = {}
        for key_node, value_node in node.value:
            line = key_node.start_mark.line + 1
            if not isinstance(key_node, yaml.ScalarNode):
                raise self._error("a key must be a plain name", line, path)
            key = key_node.value
            key_path = (*path, key)
            if key in mapping:
                first = self._lines[key_path]
                raise self._error(
                    f"'{key}' is given twice (first in line {first}); rename or remove one",
                    line,
                    key_path,
                )
            self._lines[key_path] = line
            mapping[key] = self._value(loader, value_node, key_path)
        return mapping

    def _error(self, problem: str, line: int | None = None, path: KeyPath = ()) -> DescriptionError:
        return DescriptionError(problem, key=dotted(path), file=self.file, line=line)
