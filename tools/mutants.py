"""Random faults in the product, and whether the tests of their own layer notice them.

python tools/mutants.py COUNT [--seed 0] [--only PART]

Works in a copy of the checkout. Each line of the report is one mutant: killed, or alive with its
change. Read those that live: they are equal to the original, or a law is missing.
"""

from __future__ import annotations

import argparse
import ast
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ("hybrid_dynamics_core", "hybrid_dynamics_ros", "hybrid_dynamics_cli")
PATIENCE = 400.0  # [s] for the tests of one mutant; a mutant that hangs is killed
# Folders of tests by the start of a module's path, the longest that fits.
TESTS = {
    "hybrid_dynamics_core": ("tests/core", "tests/laws", "tests/hard_cases"),
    "hybrid_dynamics_core/control": ("tests/control",),
    "hybrid_dynamics_core/description": ("tests/description", "tests/core"),
    "hybrid_dynamics_core/drawing": ("tests/drawing",),
    "hybrid_dynamics_core/dynamics": ("tests/dynamics", "tests/laws", "tests/agreement"),
    "hybrid_dynamics_core/export": ("tests/export",),
    "hybrid_dynamics_core/formats": ("tests/export", "tests/description"),
    "hybrid_dynamics_core/identification": ("tests/identification",),
    "hybrid_dynamics_core/kernels": ("tests/kernels",),
    "hybrid_dynamics_core/kinematics": ("tests/core", "tests/generated/test_reach_laws.py"),
    "hybrid_dynamics_core/programs": ("tests/dynamics", "tests/laws", "tests/agreement"),
    "hybrid_dynamics_core/scene": ("tests/drawing", "tests/view"),
    "hybrid_dynamics_core/simulation": ("tests/simulation", "tests/laws"),
    "hybrid_dynamics_core/view": ("tests/view",),
    "hybrid_dynamics_ros": ("tests/ros", "tests/bags/test_stream.py"),
    "hybrid_dynamics_ros/bags": ("tests/bags",),
    "hybrid_dynamics_ros/demo": ("tests/demo",),
    "hybrid_dynamics_cli": ("tests/cli",),
    "hybrid_dynamics_cli/bags": ("tests/bags",),
}
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


class Site(NamedTuple):
    """A place where a module can be changed.

    Attributes:
        path: of the module.
        number: of the place among all of its module.
    """

    path: Path
    number: int


class Mutator(ast.NodeTransformer):
    """Changes the place with a number; counts all places.

    Attributes:
        count: places so far.
        change: what was changed, as text.
    """

    def __init__(self, number: int = -1) -> None:
        self.number = number
        self.count = 0
        self.change = ""

    def visit(self, node: ast.AST) -> ast.AST:
        """Change the operator, constant or condition if it is the one."""
        before = self.count
        text = ast.unparse(node) if isinstance(node, (ast.expr, ast.If)) else ""
        node = self.generic_visit(node)
        node = self._changed(node)
        is_inside = before <= self.number < self.count
        if is_inside and text and not self.change:
            self.change = f"line {node.lineno}: {_line(text)} -> {_line(ast.unparse(node))}"
        return node

    def _changed(self, node: ast.AST) -> ast.AST:
        if type(node) in SWAPS and self._is_here():
            return SWAPS[type(node)]()
        if isinstance(node, ast.Constant) and _is_number(node.value) and self._is_here():
            return ast.copy_location(ast.Constant(node.value + 1), node)
        if isinstance(node, (ast.If, ast.IfExp)) and self._is_here():
            node.test = ast.UnaryOp(ast.Not(), node.test)
        return node

    def _is_here(self) -> bool:
        self.count += 1
        return self.count - 1 == self.number


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _line(text: str) -> str:
    return " ".join(text.split())[:100]


def sites() -> list[Site]:
    """All places of the product."""
    result: list[Site] = []
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            counter = Mutator()
            counter.visit(ast.parse(path.read_text(encoding="utf-8")))
            result += [Site(path, k) for k in range(counter.count)]
    return result


def tests_of(path: Path) -> tuple[str, ...]:
    """The tests of a module's own layer."""
    name = path.relative_to(ROOT).as_posix()
    return TESTS[max((start for start in TESTS if name.startswith(start)), key=len)]


def outcome(site: Site, folder: Path) -> tuple[str, str]:
    """Whether a mutant is killed, and what was changed."""
    relative = site.path.relative_to(ROOT)
    source = site.path.read_text(encoding="utf-8")
    mutator = Mutator(site.number)
    tree = ast.fix_missing_locations(mutator.visit(ast.parse(source)))
    (folder / relative).write_text(ast.unparse(tree), encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider"]
    environment = {**os.environ, "PYTHONPATH": str(folder)}
    try:
        done = subprocess.run(
            [*command, *tests_of(site.path)],
            cwd=folder,
            env=environment,
            capture_output=True,
            timeout=PATIENCE,
            check=False,
        )
        state = "alive" if done.returncode == 0 else "killed"
    except subprocess.TimeoutExpired:
        state = "killed"
    finally:
        (folder / relative).write_text(source, encoding="utf-8")
    return state, mutator.change


def main() -> None:
    """Try so many mutants and print each."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", type=int)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", default="", help="part of a module's path")
    arguments = parser.parse_args()
    every = [site for site in sites() if arguments.only in site.path.as_posix()]
    chosen = random.Random(arguments.seed).sample(every, min(arguments.count, len(every)))  # noqa: S311
    alive = 0
    with tempfile.TemporaryDirectory() as aside:
        folder = Path(aside) / "copy"
        ignored = shutil.ignore_patterns(".git", ".venv", "build", "__pycache__")
        shutil.copytree(ROOT, folder, ignore=ignored)
        for number, site in enumerate(chosen, start=1):
            start = time.monotonic()
            state, change = outcome(site, folder)
            alive += state == "alive"
            seconds = time.monotonic() - start
            place = site.path.relative_to(ROOT)
            print(f"{number} {state} {seconds:.0f} s {place} {change}", flush=True)
    print(f"{alive} of {len(chosen)} live")


if __name__ == "__main__":
    main()
