"""YAML with the line of every entry: read safely, numbers as in YAML 1.2, repeated keys refused."""

from __future__ import annotations

import re
from typing import Any

import yaml
from yaml.reader import ReaderError

from ..errors import DescriptionError
from .document import Document, File, Path_, dotted

MAX_NODES = 200_000  # an alias bomb expands far beyond what a robot needs


class _Loader(yaml.SafeLoader):
    """SafeLoader that also knows floats such as 1e-3, and leaves yes/no/on/off as text."""


_REPLACED = {f"tag:yaml.org,2002:{kind}" for kind in ("float", "bool", "int")}
_Loader.yaml_implicit_resolvers = {
    first: [(tag, pattern) for tag, pattern in resolvers if tag not in _REPLACED]
    for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
}
_INT = re.compile(r"^[-+]?[0-9]+$")
_FLOAT = re.compile(
    r"^(?:[-+]?(?:[0-9]+\.[0-9]*|\.[0-9]+|[0-9]+)(?:[eE][-+]?[0-9]+)?|[-+]?\.(?:inf|Inf)|\.(?:nan|NaN))$"
)
_BOOL = re.compile(r"^(?:true|True|false|False)$")
_Loader.add_implicit_resolver("tag:yaml.org,2002:bool", _BOOL, list("tTfF"))
_Loader.add_implicit_resolver("tag:yaml.org,2002:int", _INT, list("-+0123456789"))
_Loader.add_implicit_resolver("tag:yaml.org,2002:float", _FLOAT, list("-+.0123456789"))
_CLOSING = {"{": "}", "[": "]"}
_NO_BLOCK_END = "expected <block end>, but found"
_OPENED = (
    "while parsing a flow mapping",
    "while parsing a flow sequence",
    "while scanning a quoted scalar",
)


def read_yaml(text: str, file: File = None) -> Document:
    """The document of a YAML text; DescriptionError where it is not valid, repeats a key or holds code."""
    return _Reader(text, file).document()


class _Reader:
    def __init__(self, text: str, file: File) -> None:
        self.text = text
        self.file = file
        self._lines: dict[Path_, int] = {(): 1}
        self._count = 0

    def document(self) -> Document:
        loader = self._loader()
        try:
            node = loader.get_single_node()
            data = None if node is None else self._read(loader, node, ())
        except yaml.MarkedYAMLError as error:
            raise self._invalid(error) from error
        except yaml.YAMLError as error:
            raise DescriptionError(f"not valid YAML: {error}", file=self.file) from error
        except RecursionError:
            raise DescriptionError(
                "nested too deeply (an alias inside itself?)", file=self.file
            ) from None
        finally:
            loader.dispose()
        return Document(data, self.file, self._lines)

    def _invalid(self, error: yaml.MarkedYAMLError) -> DescriptionError:
        """The error at the bracket, brace or quote that is left open, if one is; else where reading ended."""
        problem, start, end = (
            error.problem or error.context or "",
            error.context_mark,
            error.problem_mark,
        )
        problem = problem.replace("'<scalar>'", "a value")
        if start is not None and end is not None and error.context in _OPENED:
            opened = self.text[start.index]
            problem = (
                f"the {opened!r} in column {start.column + 1} is still open in line {end.line + 1},"
                f" column {end.column + 1}: {problem}{self._missing(opened, start, end)}"
            )
            end = start
        elif end is not None:
            problem = self._indentation(problem, end) or problem
        mark = end or start
        line = None if mark is None else mark.line + 1
        return DescriptionError(f"not valid YAML: {problem}", file=self.file, line=line)

    def _indentation(self, problem: str, end: yaml.Mark) -> str:
        """In words, where a line begins in another column than its neighbours; else nothing."""
        line = self.text.splitlines()[end.line] if end.line < len(self.text.splitlines()) else ""
        column, above = len(line) - len(line.lstrip()) + 1, self._entry_above(end.line)
        if "\t" in line[:column] and "cannot start any token" in problem:
            return "a line is indented with a tab; indent with spaces"
        second = problem == "mapping values are not allowed here"
        if above is None or above[1] == column or not (second or problem.startswith(_NO_BLOCK_END)):
            return (
                f"{problem}: a second ':' in one line; put text that has one in quotes"
                if second
                else ""
            )
        return (
            f"the indentation does not fit: this line begins in column {column}, the entry above it"
            f" (line {above[0]}) in column {above[1]}; entries that belong together begin in one"
            " column, parts of an entry further right"
        )

    def _entry_above(self, line: int) -> tuple[int, int] | None:
        """Line and column of the last entry of a block that begins before a line (counted from 0)."""
        depth, found = 0, None
        try:
            for token in yaml.scan(self.text, Loader=_Loader):
                if token.start_mark.line >= line:
                    break
                depth += isinstance(
                    token, (yaml.FlowMappingStartToken, yaml.FlowSequenceStartToken)
                )
                depth -= isinstance(token, (yaml.FlowMappingEndToken, yaml.FlowSequenceEndToken))
                if depth == 0 and isinstance(token, (yaml.KeyToken, yaml.BlockEntryToken)):
                    found = (token.start_mark.line + 1, token.start_mark.column + 1)
        except yaml.YAMLError:
            pass  # what is wrong is told already
        return found

    def _missing(self, opened: str, start: yaml.Mark, end: yaml.Mark) -> str:
        """Where the other bracket is missing, if reading ended in a later line: most likely before that."""
        lines = self.text.splitlines()[start.line : end.line]
        full = [
            start.line + k + 1
            for k, line in enumerate(lines)
            if line.strip() and not line.lstrip().startswith("#")
        ]
        if opened not in _CLOSING or not full:
            return ""
        return f"; a '{_CLOSING[opened]}' is missing, probably at the end of line {full[-1]}"

    def _loader(self) -> _Loader:
        try:
            return _Loader(self.text)
        except ReaderError as error:
            line = self.text[: error.position].count("\n") + 1
            problem = (
                f"not valid YAML: the character U+{ord(self.text[error.position]):04X} is not"
                " allowed"
            )
            raise DescriptionError(problem, file=self.file, line=line) from error

    def _read(self, loader: _Loader, node: yaml.Node, path: Path_) -> Any:
        self._count += 1
        if self._count > MAX_NODES:
            raise DescriptionError(
                "too many entries (aliases that multiply?)", file=self.file, key=dotted(path)
            )
        self._lines.setdefault(path, node.start_mark.line + 1)
        if not node.tag.startswith("tag:yaml.org,2002:") or node.tag.startswith(
            "tag:yaml.org,2002:python"
        ):
            line = node.start_mark.line + 1
            raise DescriptionError(
                f"the tag {node.tag} is not allowed; plain values only", file=self.file, line=line
            )
        if isinstance(node, yaml.MappingNode):
            return self._read_mapping(loader, node, path)
        if isinstance(node, yaml.SequenceNode):
            return [self._read(loader, child, (*path, k)) for k, child in enumerate(node.value)]
        try:
            return loader.construct_object(node)
        except ValueError as error:
            line = node.start_mark.line + 1
            raise DescriptionError(
                f"not a value: {error}", key=dotted(path), file=self.file, line=line
            ) from error

    def _read_mapping(self, loader: _Loader, node: yaml.MappingNode, path: Path_) -> dict[str, Any]:
        result: dict[str, Any] = {}
        for key_node, value_node in node.value:
            key = key_node.value if isinstance(key_node, yaml.ScalarNode) else None
            if not isinstance(key, str):
                raise DescriptionError(
                    "a key must be a plain name",
                    key=dotted(path),
                    file=self.file,
                    line=key_node.start_mark.line + 1,
                )
            here = (*path, key)
            if key in result:
                first = self._lines[here]
                raise DescriptionError(
                    f"'{key}' is given twice (first in line {first}); rename or remove one",
                    key=dotted(here),
                    file=self.file,
                    line=key_node.start_mark.line + 1,
                )
            self._lines[here] = key_node.start_mark.line + 1
            result[key] = self._read(loader, value_node, here)
        return result
