"""Places of the product that can be changed, and their changes."""

from __future__ import annotations

import ast
from collections.abc import Collection
from pathlib import Path
from typing import NamedTuple

PACKAGES = ("hybrid_dynamics_core", "hybrid_dynamics_ros", "hybrid_dynamics_cli")
SWAPS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.And: ast.Or,
    ast.Or: ast.And,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.USub: ast.UAdd,
}
COMMUTING = {"isclose", "logaddexp", "max", "maximum", "min", "minimum"}
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
SHOWN = (ast.expr, ast.If, ast.AugAssign, ast.Expr, ast.Assign, ast.Raise)
BLOCKS = ("body", "orelse", "finalbody", "handlers", "cases")


class Site(NamedTuple):
    """A place where a module can be changed.

    Attributes:
        module: its path below the root.
        number: of the place among all of its module.
    """

    module: str
    number: int


class Change(NamedTuple):
    """A mutant.

    Attributes:
        source: of the changed module.
        text: what was changed, with its line.
        lines: of the statement that was changed; where it runs as the module is imported, those of
            the module that use the name that it defines, if any.
    """

    source: str
    text: str
    lines: Collection[int]


class Mutator(ast.NodeTransformer):
    """Changes the place with a number; counts all places.

    Attributes:
        count: places so far.
        change: what was changed, as text.
        lines: of the innermost statement around it, if that is in a function.
        defined: otherwise the name that it defines, if it does.
    """

    def __init__(self, number: int = -1) -> None:
        self.number = number
        self.count = 0
        self.change = ""
        self.lines = range(0)
        self.defined = ""
        self._is_in_function = False

    def visit(self, node: ast.AST) -> ast.AST:
        """Change the operator, constant or condition if it is the one."""
        if isinstance(node, FUNCTIONS):
            return self._visit_function(node)
        before = self.count
        text = ast.unparse(node) if isinstance(node, SHOWN) else ""
        statement = _lines(node) if isinstance(node, ast.stmt) else range(0)
        node = self._changed(self.generic_visit(node))
        is_inside = before <= self.number < self.count
        if is_inside and text and not self.change:
            self.change = f"line {node.lineno}: {_line(text)} -> {_line(ast.unparse(node))}"
        if is_inside and self._is_in_function and not self.lines:
            self.lines = statement
        if is_inside and not self._is_in_function:
            self.defined = self.defined or _defined(node)
        return node

    def _visit_function(self, node: ast.AST) -> ast.AST:
        """Decorators, defaults and annotations run outside of the function; defaults act in it."""
        body, node.body = node.body, []
        before = self.count
        self.generic_visit(node)
        if before <= self.number < self.count:
            self.lines = self.lines or range(body[0].lineno, body[-1].end_lineno + 1)
        outside, self._is_in_function = self._is_in_function, True
        node.body = [self.visit(statement) for statement in body]
        self._is_in_function = outside
        return node

    def _changed(self, node: ast.AST) -> ast.AST:
        if type(node) in SWAPS and self._is_here():
            return SWAPS[type(node)]()
        if isinstance(node, ast.Constant) and _is_number(node.value) and self._is_here():
            return ast.copy_location(ast.Constant(node.value + 1), node)
        if isinstance(node, ast.Constant) and isinstance(node.value, bool) and self._is_here():
            return ast.copy_location(ast.Constant(not node.value), node)
        if isinstance(node, (ast.If, ast.IfExp)) and self._is_here():
            node.test = ast.UnaryOp(ast.Not(), node.test)
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not) and self._is_here():
            return node.operand
        if isinstance(node, ast.Call) and _has_order(node) and self._is_here():
            node.args[:2] = node.args[1::-1]
        if self._is_in_function and _can_go(node) and self._is_here():
            return ast.copy_location(ast.Pass(), node)
        return node

    def _is_here(self) -> bool:
        self.count += 1
        return self.count - 1 == self.number


def _defined(node: ast.AST) -> str:
    if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
        return node.targets[0].id
    return ""


def _has_order(call: ast.Call) -> bool:
    """Whether a call has two arguments whose order matters."""
    name = ast.unparse(call.func).rpartition(".")[2]
    first = call.args[:2]
    is_plain = len(first) == 2 and not any(isinstance(one, ast.Starred) for one in first)
    return is_plain and name not in COMMUTING and ast.dump(first[0]) != ast.dump(first[1])


def _can_go(node: ast.AST) -> bool:
    """Whether a statement can be left out, and every name is still defined."""
    if isinstance(node, ast.Assign):
        return all(isinstance(target, ast.Subscript) for target in node.targets)
    is_call = isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)
    return is_call or isinstance(node, (ast.AugAssign, ast.Raise))


def _lines(statement: ast.stmt) -> range:
    """Lines of a statement, of its head alone where it has a body."""
    parts = [part for block in BLOCKS for part in getattr(statement, block, [])]
    last = statement.end_lineno
    if parts:
        last = max(statement.lineno, min(_first_line(part) for part in parts) - 1)
    return range(statement.lineno, last + 1)


def _first_line(part: ast.AST) -> int:
    return part.pattern.lineno if isinstance(part, ast.match_case) else part.lineno


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _line(text: str) -> str:
    return " ".join(text.split())[:100]


def sites(root: Path) -> list[Site]:
    """All places of the product."""
    result: list[Site] = []
    for package in PACKAGES:
        for path in sorted((root / package).rglob("*.py")):
            counter = Mutator()
            counter.visit(ast.parse(path.read_text(encoding="utf-8")))
            module = path.relative_to(root).as_posix()
            result += [Site(module, k) for k in range(counter.count)]
    return result


def changed(site: Site, root: Path) -> Change:
    """The module of a site with its change."""
    text = (root / site.module).read_text(encoding="utf-8")
    mutator = Mutator(site.number)
    tree = mutator.visit(ast.parse(text))
    source = ast.unparse(ast.fix_missing_locations(tree))
    lines = mutator.lines or _uses(mutator.defined, ast.parse(text))
    return Change(source, mutator.change, lines)


def _uses(name: str, tree: ast.Module) -> set[int]:
    """Lines of functions that use a name."""
    functions = [node for node in ast.walk(tree) if isinstance(node, FUNCTIONS)]
    inner = [node for function in functions for node in ast.walk(function)]
    return {node.lineno for node in inner if isinstance(node, ast.Name) and node.id == name}
