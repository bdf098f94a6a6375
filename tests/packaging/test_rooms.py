"""The layout of the code: folders that are narrow, imports without circles, names of the field."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ("hybrid_dynamics_cli", "hybrid_dynamics_core", "hybrid_dynamics_ros")
WIDEST = 20  # modules in one folder
LONGEST = 400  # lines of a module

# Words that mean something else in every sentence. A name says what a thing is.
VAGUE = {
    "told",
    "looks",
    "rest",
    "many",
    "few",
    "odd",
    "spread",
    "own",
    "found",
    "known",
    "left",
    "whole",
    "kept",
    "seen",
    "again",
    "stray",
    "tried",
    "doubt",
    "doubts",
}
ALLOWED = {  # sides, terms of files, names that users see, names of other libraries
    "left",
    "_LEFT",
    "bisect_left",
    "rest",
    "at_rest",
    "kept",
    "mark_own",
    "spread",
    "ModuleNotFoundError",
    "FileNotFoundError",
    "NOT_FOUND",
}


@cache
def sources() -> dict[str, Path]:
    """Modules of the product by dotted name; packages by the name of their folder."""
    paths = {}
    for package in PACKAGES:
        for path in sorted(ROOT.glob(f"{package}/**/*.py")):
            parts = path.relative_to(ROOT).with_suffix("").parts
            paths[".".join(parts).removesuffix(".__init__")] = path
    return paths


@cache
def tree_of(module: str) -> ast.Module:
    return ast.parse(sources()[module].read_text(encoding="utf-8"))


def imports_of(module: str) -> Iterator[str]:
    """Modules of the product that a module imports, at its head, in a function or for types."""
    path = sources()[module]
    package = module if path.name == "__init__.py" else module.rpartition(".")[0]
    for node in ast.walk(tree_of(module)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in sources())
        elif isinstance(node, ast.ImportFrom):
            base = base_of(node, package)
            for alias in node.names:
                name = f"{base}.{alias.name}"
                yield name if name in sources() else base


def base_of(node: ast.ImportFrom, package: str) -> str:
    """The absolute name of the module that a statement imports from."""
    if node.level == 0:
        return node.module or ""
    parts = package.split(".")
    parents = parts[: len(parts) - node.level + 1]
    return ".".join([*parents, node.module] if node.module else parents)


def test_imports_have_no_circle() -> None:
    graph = {}
    for module in sources():
        graph[module] = {name for name in imports_of(module) if name in sources()} - {module}
    assert sum(map(len, graph.values())) > 1000  # they are read at all
    try:
        order = list(TopologicalSorter(graph).static_order())
    except CycleError as error:
        pytest.fail(f"a circle of imports: {' <- '.join(error.args[1])}")
    assert set(order) == set(sources())


def test_folders_are_narrow() -> None:
    folders: dict[str, int] = {}
    for path in sources().values():
        folder = str(path.parent.relative_to(ROOT))
        folders[folder] = folders.get(folder, 0) + 1
    assert {name: count for name, count in folders.items() if count > WIDEST} == {}


def test_modules_are_short() -> None:
    lines = {name: len(path.read_text("utf-8").splitlines()) for name, path in sources().items()}
    assert {name: count for name, count in lines.items() if count > LONGEST} == {}


def test_every_folder_says_its_subject() -> None:
    silent = []
    for name, path in sources().items():
        if path.name == "__init__.py" and not ast.get_docstring(tree_of(name)):
            silent.append(name)
    assert silent == []


def identifiers(tree: ast.Module) -> Iterator[str]:
    """Every name that a module defines or uses."""
    for node in ast.walk(tree):
        for field in ("id", "attr", "arg", "name", "asname"):
            value = getattr(node, field, None)
            if isinstance(value, str):
                yield from value.split(".")


def words_of(identifier: str) -> set[str]:
    """`first_few` and `FirstFew` have the words first and few."""
    parts = re.findall(r"[A-Z]?[a-z0-9]+|[A-Z]+(?![a-z])", identifier)
    return {part.lower() for part in parts}


def test_names_say_what_things_are() -> None:
    vague: dict[str, set[str]] = {}
    for module in sources():
        names = {name for name in identifiers(tree_of(module)) if words_of(name) & VAGUE}
        if names - ALLOWED:
            vague[module] = names - ALLOWED
    assert vague == {}
