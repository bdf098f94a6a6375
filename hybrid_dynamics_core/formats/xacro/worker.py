"""The program of the isolated process that expands a xacro file.

It is run by its path and imports only xacro and the standard library. It requests the text of every
file and the folder of every package from its parent, in lines of JSON. Expressions of the file are
Python. Those that could reach more than xacro's functions and values are refused before they run.
An audit hook refuses files, sockets and processes. System limits end it if it needs too much time
or memory.
"""

from __future__ import annotations

import ast
import builtins
import io
import json
import os
import runpy
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from xml.dom import expatbuilder, minidom

_MEMORY = 1_000_000_000  # bytes
_MAX_WARNINGS = 20
_PLACE = "place"  # key of the file and line of elements
_HIDDEN_NAMES = ("type", "vars")  # names in xacro's Python namespace that lead to all classes
_INSPECTION = frozenset(  # attributes for introspection
    {
        *("ag_await", "ag_code", "ag_frame", "cr_await", "cr_code", "cr_frame", "cr_origin"),
        *("f_back", "f_builtins", "f_code", "f_globals", "f_lineno", "f_locals", "f_trace"),
        *("gi_code", "gi_frame", "gi_yieldfrom", "mro", "tb_frame", "tb_next"),
    }
)
_PLAIN = ("list", "dict", "map", "str", "float", "int")  # builtins in $(eval ...)
_FORMATTING = ("format", "format_map")  # methods that read attributes named in texts
_HARMLESS = frozenset(  # audit events that expressions and macros cause
    {"compile", "exec", "object.__getattr__", "object.__setattr__", "builtins.id", "code.__new__"}
)


class RefusedError(Exception):
    """An action that is not allowed while reading a file."""


# -- the parent


def ask(question: dict[str, Any]) -> Any:
    """The answer of the parent process to a request."""
    sys.__stdout__.write(json.dumps(question) + "\n")  # type: ignore[union-attr]
    sys.__stdout__.flush()  # type: ignore[union-attr]
    answer = json.loads(sys.__stdin__.readline())  # type: ignore[union-attr]
    if answer.get("missing"):
        raise FileNotFoundError(answer["error"])
    if "error" in answer:
        raise RefusedError(answer["error"])
    return answer["value"]


# -- expressions


def require_harmless(tree: ast.AST, text: str) -> None:
    """Raise if an expression could reach more than xacro's functions and values."""
    for node in ast.walk(tree):
        name = ""
        if isinstance(node, ast.Name):
            name = node.id
        elif isinstance(node, ast.Attribute):
            name = node.attr
            if name in _FORMATTING and not _is_plain_format(node.value):
                raise RefusedError(f"'{text}': {name} of a text that is not written there")
        if name in _INSPECTION or name.startswith("__") or (name[:1] == "_" and _is_dotted(node)):
            raise RefusedError(f"'{text}': '{name}' is not allowed in expressions of a file")


def _is_dotted(node: ast.AST) -> bool:
    return isinstance(node, ast.Attribute)


def _is_plain_format(value: ast.expr) -> bool:
    """Whether a text is a literal of the expression that names no hidden attribute."""
    return isinstance(value, ast.Constant) and "_" not in str(value.value)


def evaluate(text: str, symbols: Any, local_symbols: Any = None) -> Any:
    """The value of an expression of a file."""
    tree = ast.parse(text.strip(), mode="eval")
    require_harmless(tree, text)
    symbols.update(__builtins__={})
    code = compile(tree, "<expression>", "eval")
    return eval(code, symbols, local_symbols)  # noqa: S307 - checked above


# -- files


class _Copied:
    """Keeps the location of an element in its copies."""

    def handle(self, _operation: int, key: str, data: Any, _source: Any, copy: Any) -> None:
        if copy is not None:
            copy.setUserData(key, data, self)


class _Builder(expatbuilder.ExpatBuilderNS):
    """Builder of elements with their lines."""

    file = ""

    def start_element_handler(self, name: Any, attributes: Any) -> None:
        super().start_element_handler(name, attributes)
        place = (self.file, self.getParser().CurrentLineNumber)
        self.curNode.setUserData(_PLACE, place, _Copied())

    def start_doctype_decl_handler(self, *_: Any) -> None:
        raise RefusedError(
            f"{self.file}: has a document type (<!DOCTYPE ...>), which could define entities"
        )


def parse(_given: Any, filename: str) -> Any:
    """Parse a file; replaces xacro's function."""
    try:
        text = ask({"read": filename})
    except FileNotFoundError as error:
        xacro.filestack.pop()
        raise xacro.XacroException(exc=error) from error
    builder = _Builder()
    builder.file = filename
    return builder.parseString(text.removeprefix("\ufeff").encode())


def find(name: str) -> str:
    """The folder of a package."""
    return str(ask({"find": name}))


def absolute(filename: str) -> str:
    """An absolute path, from one relative to the including file."""
    if filename.startswith("package://"):
        name, _, inside = filename.removeprefix("package://").partition("/")
        return f"{find(name)}/{inside}"
    return str(plain_absolute(filename))


def open_text(filename: str, *_: Any, **__: Any) -> io.StringIO:
    """Open a file for reading; replaces `open`."""
    return io.StringIO(ask({"read": filename}))


def no_environment(name: str) -> str:
    """Refuse `$(env ...)`."""
    raise RefusedError(
        f"$(env {name}): the environment is not passed on to a file; make it a xacro:arg"
    )


def default_of_environment(name: str, default: str = "") -> str:
    """The default of `$(optenv ...)`, with a warning."""
    xacro.warning(f"$(optenv {name}): the environment is not read; taken: '{default}'")
    return default


def evaluate_substitution(text: str, context: dict[str, Any]) -> str:
    """The value of `$(eval ...)`, with xacro's functions only."""
    arguments = context.get("arg", {})
    values = {name: arguments_module.convert_value(arguments[name], "auto") for name in arguments}
    functions = dict(arguments_module._eval_dict, arg=lambda name: values[name])  # noqa: SLF001
    functions.pop("__builtins__", None)
    plain = {name: getattr(builtins, name) for name in _PLAIN}
    return str(evaluate(text, {**plain, **functions, **values}))


class Arguments(dict):  # type: ignore[type-arg]
    """Arguments of the file, which record the requested names."""

    def __init__(self, given: dict[str, str]) -> None:
        super().__init__(given)
        self.declared: set[str] = set()

    def __contains__(self, name: object) -> bool:
        self.declared.add(str(name))
        return super().__contains__(name)


# -- places of errors


def place_of(node: Any) -> Any:
    """File and line of an element, or of the nearest enclosing one that has them."""
    while node is not None:
        place = node.getUserData(_PLACE) if hasattr(node, "getUserData") else None
        if place:
            return place
        node = node.parentNode
    return None


def located(function: Any) -> Any:
    """Wrap a function so that its errors have the location of the innermost element."""

    def call(node: Any, *arguments: Any) -> Any:
        place = place_of(node)
        try:
            return function(node, *arguments)
        except Exception as error:
            if not hasattr(error, "place"):
                error.place = place  # type: ignore[attr-defined]
            raise

    return call


def words_of(error: Exception) -> str:
    """The words of an error, without the class that xacro puts before those of another one."""
    words = str(error) or type(error).__name__
    return words.replace(f"{RefusedError}: ", "")


# -- the whole


def guard(seconds: int) -> None:
    """Redirect xacro's access to files to the parent, and refuse all other access."""
    for name in ("eval_all", "process_include", "grab_property", "grab_macro"):
        setattr(xacro, name, located(getattr(xacro, name)))
    xacro.handle_macro_call = located(xacro.handle_macro_call)
    xacro.safe_eval = evaluate
    xacro.parse = parse
    xacro.abs_filename_spec = absolute
    xacro.open = open_text
    xacro.glob = SimpleNamespace(glob=lambda pattern: ask({"glob": pattern}))
    namespace = xacro._global_symbols["python"]  # noqa: SLF001
    for name in _HIDDEN_NAMES:
        dict.pop(namespace, name, None)
    replaced = {
        "find": find,
        "env": no_environment,
        "optenv": default_of_environment,
    }
    arguments_module._eval_dict.update(replaced)  # noqa: SLF001
    for name, function in replaced.items():
        setattr(arguments_module, f"_eval_{name}", function)
    arguments_module._eval = evaluate_substitution  # noqa: SLF001
    limits["limit"]("AS", _MEMORY)
    limits["limit"]("CPU", seconds, seconds + 1)
    sys.addaudithook(refuse)


def refuse(event: str, arguments: Any) -> None:
    """Audit hook: refuse events that reading a file does not need."""
    if event not in _HARMLESS and not event.startswith("cpython."):
        raise RefusedError(f"{event} {arguments!r:.100}: reading a file must not do that")


def elements(root: Any) -> list[Any]:
    """Depth, tag, attributes, location and text of every element, in the order of the file."""
    rows = []
    open_nodes = [(root, 0)]
    while open_nodes:
        node, depth = open_nodes.pop()
        texts = [child.data for child in node.childNodes if child.nodeType in _TEXT_NODES]
        rows.append(
            [depth, node.tagName, dict(node.attributes.items()), place_of(node), "".join(texts)]
        )
        inner = [child for child in node.childNodes if child.nodeType == minidom.Node.ELEMENT_NODE]
        open_nodes += [(child, depth + 1) for child in reversed(inner)]
    return rows


_TEXT_NODES = (minidom.Node.TEXT_NODE, minidom.Node.CDATA_SECTION_NODE)


def expanded(file: str, given: dict[str, str]) -> dict[str, Any]:
    """The expanded elements of a file, or the error."""
    arguments = Arguments(given)
    try:
        document = xacro.process_file(file, mappings=arguments)
        result = {"elements": elements(document.documentElement)}
    except MemoryError:
        return {"error": f"needs more than {_MEMORY} bytes of memory to be expanded"}
    except RecursionError:
        return {"error": "macros or expressions call each other without end"}
    except Exception as error:  # noqa: BLE001 - xacro raises whatever an expression does
        return {"error": words_of(error), "place": getattr(error, "place", None)}
    result["declared"] = sorted(arguments.declared)
    return result


limits = runpy.run_path(str(Path(__file__).parents[2] / "ground" / "worker_limits.py"))
request = json.loads(sys.stdin.readline())
sys.path[:] = request["path"]
import xacro  # noqa: E402 - found by the parent's path
import yaml  # noqa: E402, F401 - loaded before files are refused
from xacro import substitution_args as arguments_module  # noqa: E402

plain_absolute = xacro.abs_filename_spec
sys.stdout = sys.stderr = io.StringIO()  # discards what xacro and the file print
guard(request["seconds"])
result = expanded(request["file"], request["arguments"])
result["printed"] = sys.stderr.getvalue().splitlines()[:_MAX_WARNINGS]
sys.__stdout__.write(json.dumps({"result": result}) + "\n")  # type: ignore[union-attr]
sys.__stdout__.flush()  # type: ignore[union-attr]
os._exit(0)
