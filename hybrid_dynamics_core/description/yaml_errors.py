"""Texts for syntax errors of YAML: open brackets, indentation, tabs."""

from __future__ import annotations

import yaml

_CLOSING = {"{": "}", "[": "]"}
_OPEN_CONTEXTS = (
    "while parsing a flow mapping",
    "while parsing a flow sequence",
    "while scanning a quoted scalar",
)
_NO_BLOCK_END = "expected <block end>, but found"
_TAB_MESSAGE = "cannot start any token"
_SECOND_COLON = "mapping values are not allowed here"
_FLOW_STARTS = (yaml.FlowMappingStartToken, yaml.FlowSequenceStartToken)
_FLOW_ENDS = (yaml.FlowMappingEndToken, yaml.FlowSequenceEndToken)
_ENTRY_STARTS = (yaml.KeyToken, yaml.BlockEntryToken)


def syntax_problem(
    text: str, error: yaml.MarkedYAMLError, loader: type[yaml.SafeLoader]
) -> tuple[str, int | None]:
    """The problem as text, and its line: that of an open bracket, brace or quote, or of the end.

    Args:
        text: the YAML.
        error: the error that reading raised.
        loader: loader class that scans the text.

    Returns:
        The problem, and its line (1-based) or None.
    """
    problem = (error.problem or error.context or "").replace("'<scalar>'", "a value")
    start = error.context_mark
    end = error.problem_mark
    if start is not None and end is not None and error.context in _OPEN_CONTEXTS:
        return _still_open(text, problem, start, end), start.line + 1
    if end is not None:
        return _misplaced(text, problem, end, loader), end.line + 1
    if start is not None:
        return problem, start.line + 1
    return problem, None


def _still_open(text: str, problem: str, start: yaml.Mark, end: yaml.Mark) -> str:
    """The text for a bracket, brace or quote that is still open at the end."""
    opened = text[start.index]
    hint = ""
    if opened in _CLOSING:
        hint = _missing(text, _CLOSING[opened], start, end)
    return (
        f"the {opened!r} in column {start.column + 1} is still open in line {end.line + 1},"
        f" column {end.column + 1}: {problem}{hint}"
    )


def _missing(text: str, closing: str, start: yaml.Mark, end: yaml.Mark) -> str:
    """The text for a missing bracket, most likely at the end of the last complete line."""
    last = None
    lines = text.splitlines()[start.line : end.line]
    for number, line in enumerate(lines, start.line + 1):
        if line.strip() and not line.lstrip().startswith("#"):
            last = number
    if last is None:
        return ""
    return f"; a '{closing}' is missing, probably at the end of line {last}"


def _misplaced(text: str, problem: str, end: yaml.Mark, loader: type[yaml.SafeLoader]) -> str:
    """The text for a line with wrong indentation or a tab; otherwise the problem itself."""
    lines = text.splitlines()
    line = lines[end.line] if end.line < len(lines) else ""
    column = len(line) - len(line.lstrip()) + 1
    if "\t" in line[:column] and _TAB_MESSAGE in problem:
        return "a line is indented with a tab; indent with spaces"
    is_second_colon = problem == _SECOND_COLON
    above = _entry_above(text, end.line, loader)
    if above is not None and (is_second_colon or problem.startswith(_NO_BLOCK_END)):
        entry_line, entry_column = above
        if entry_column != column:
            return (
                f"the indentation does not fit: this line begins in column {column}, the entry"
                f" above it (line {entry_line}) in column {entry_column}; entries that belong"
                " together begin in one column, parts of an entry further right"
            )
    if is_second_colon:
        return f"{problem}: a second ':' in one line; put text that has one in quotes"
    return problem


def _entry_above(text: str, line: int, loader: type[yaml.SafeLoader]) -> tuple[int, int] | None:
    """Line and column of the last entry of a block that begins before a line (counted from 0)."""
    depth = 0
    entry = None
    try:
        for token in yaml.scan(text, Loader=loader):
            if token.start_mark.line >= line:
                break
            if isinstance(token, _FLOW_STARTS):
                depth += 1
            elif isinstance(token, _FLOW_ENDS):
                depth -= 1
            elif depth == 0 and isinstance(token, _ENTRY_STARTS):
                entry = (token.start_mark.line + 1, token.start_mark.column + 1)
    except yaml.YAMLError:
        pass  # the error is reported already
    return entry
