"""A warm start traces nothing, an equal text is not compiled twice, and nothing stale is used."""

from __future__ import annotations

import ast
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hybrid_dynamics_core import ClosedState, errors, load
from hybrid_dynamics_core.kernels import (
    artifact,
    cache,
    digest,
    formula_code,
    generated,
    llvm,
    native,
    run,
)
from hybrid_dynamics_core.kernels.backend import Source
from hybrid_dynamics_core.kernels.run import Kernel
from tests.kernels.programs_of import BACKENDS, PROGRAMS, kernel

ROOT = Path(__file__).resolve().parents[2]
NEEDS_COMPILER = pytest.mark.skipif("native" not in BACKENDS, reason="no compiler here")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache of its own."""
    place = tmp_path / "cache"
    monkeypatch.setenv(cache.VARIABLE, str(place))
    return place


def torques() -> np.ndarray:
    """Through compiled code of a robot that is made anew."""
    robot = load("five_bar")
    u = robot.reference
    return np.array(robot.kernels.inverse_dynamics(u, 0.1 * u, u))


def never(*_: object) -> Any:
    raise AssertionError("this was to be taken from the cache")


# -- The first key: the program and the code that formulas come from


def imports_of(module: str) -> set[str]:
    """Modules of the package that a module imports when it runs, packages on the way left out."""
    path = path_of(module)
    assert path is not None
    package = module if path.name == "__init__.py" else module.rpartition(".")[0]
    names: set[str] = set()
    for node in ast.walk(without_type_checking(ast.parse(path.read_text(encoding="utf-8")))):
        if isinstance(node, ast.ImportFrom):
            above = package.split(".")[: len(package.split(".")) - node.level + 1]
            start = ".".join([*above, node.module or ""] if node.level else [node.module or ""])
            names.add(start.strip("."))
            names |= {f"{start.strip('.')}.{name.name}" for name in node.names}
        elif isinstance(node, ast.Import):
            names |= {name.name for name in node.names}
    ours = {name for name in names if name.startswith(f"{formula_code.PACKAGE}.")}
    return {name for name in ours if path_of(name) is not None}


def without_type_checking(tree: ast.Module) -> ast.Module:
    tree.body = [
        node
        for node in tree.body
        if not (isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING")
    ]
    return tree


def path_of(module: str) -> Path | None:
    place = ROOT / module.replace(".", "/")
    paths = [place / "__init__.py", place.with_suffix(".py")]
    return next((path for path in paths if path.is_file()), None)


def reached_from(*modules: str) -> set[str]:
    reached: set[str] = set()
    waiting = list(modules)
    while waiting:
        module = waiting.pop()
        if module not in reached:
            reached.add(module)
            waiting += imports_of(module)
    return reached


def test_all_that_programs_import_is_digested() -> None:
    """And nothing is listed that they do not import: it would make kernels anew for nothing."""
    package = formula_code.PACKAGE
    reached = reached_from(f"{package}.programs", f"{package}.kernels.run")
    assert len(reached) > 60
    assert [m for m in sorted(reached) if not formula_code.decides_formulas(m)] == []
    for place in formula_code.PLACES:
        name = f"{package}.{place.removesuffix('.py').replace('/', '.')}"
        assert any(f"{module}.".startswith(f"{name}.") for module in reached), place


@pytest.mark.parametrize("which", PROGRAMS)
@pytest.mark.parametrize("name", ["forging_chu2020", "seven_bar", "gough"])
def test_every_program_has_a_key(name: str, which: str) -> None:
    """What it reads is digested or a number: nothing of it is out of reach."""
    assert kernel(name, which, BACKENDS[0])._identity is not None


def test_what_is_not_of_that_code_has_no_digest() -> None:
    for thing in (ClosedState, load, load("five_bar"), np.random.default_rng()):
        with pytest.raises(digest.NoDigestError):
            digest.digest(thing)
    assert digest.digest(errors.InputError)
    assert not formula_code.decides_formulas("hybrid_dynamics_core.kernels_of_another_kind")


SOURCE = '''"""What it does."""
SCALE = 2.0


class Scale:
    """A scale."""

    factor = 3.0

    def of(self, x, y=1.0):
        """Scaled."""
        return self.factor * x + y  # why
'''


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("  # why", ""),
        ('"""What it does."""', '"""What it says."""\n\n\n# and more'),
        ('"""A scale."""', '"""A longer\n\n    text.\n    """'),
        ('"""Scaled."""', '"""Scaled, and moved."""'),
        ("self.factor * x + y", "(\n            self.factor * x + y\n        )"),
        ("self.factor * x + y", "(self.factor * x) + y"),
    ],
)
def test_comments_docstrings_and_layout_are_no_change(old: str, new: str) -> None:
    assert old in SOURCE
    changed = SOURCE.replace(old, new)
    assert formula_code.canonical(changed.encode()) == formula_code.canonical(SOURCE.encode())


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("SCALE = 2.0", "SCALE = 2.0000000000000004"),
        ("* x + y", "* (x + y)"),
        ("* x + y", "* y + x"),
        ("y=1.0", "y=1"),
        ("def of", "def off"),
        ('    """Scaled."""\n    ', '    """Scaled."""\n        x = -x\n    '),
        ("    factor = 3.0", '    factor = "3.0"'),
    ],
)
def test_every_change_of_code_is_a_change(old: str, new: str) -> None:
    assert old in SOURCE
    changed = SOURCE.replace(old, new)
    assert formula_code.canonical(changed.encode()) != formula_code.canonical(SOURCE.encode())


def test_a_change_of_the_bytes_is_looked_at_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The digest of the syntax is kept under one of the bytes: of every file, and of its name."""
    monkeypatch.setattr(formula_code, "_ROOT", tmp_path)
    (tmp_path / "rules").mkdir()
    file = tmp_path / "rules" / "a.py"
    file.write_text("x = 1.0\n")
    digests = [formula_code._digest_of(["rules"])]
    file.write_text("x = 1.0  # one\n")
    assert formula_code._digest_of(["rules"]) == digests[0]
    file.write_text("x = 1.5\n")
    digests.append(formula_code._digest_of(["rules"]))
    file.rename(tmp_path / "rules" / "b.py")
    digests.append(formula_code._digest_of(["rules"]))
    (tmp_path / "rules" / "c.py").write_text("")
    digests.append(formula_code._digest_of(["rules"]))
    assert len(set(digests)) == 4
    with pytest.raises(formula_code.NoSourceError):
        formula_code._digest_of(["rules", "nothing"])


def test_without_a_source_nothing_is_kept(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing() -> str:
        raise formula_code.NoSourceError

    monkeypatch.setattr(artifact, "formula_digest", missing)
    monkeypatch.setattr(native, "compiler_digest", missing)
    assert np.isfinite(torques()).all()
    assert not folder.exists() or not list(folder.iterdir())


def functions(scale: float) -> list[Any]:
    return [lambda x: x + scale, lambda x: x - scale, lambda x: x + scale + 1.0, lambda x: x]


def test_functions_of_one_name_are_told_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    """By what they do and hold, not by their line: they may move."""
    monkeypatch.setattr(digest, "decides_formulas", lambda module: module == __name__)
    assert len({digest.digest(f) for f in (*functions(1.0), functions(2.0)[0])}) == 5
    scope: dict[str, Any] = {"__name__": __name__}
    text = 'def f(x):\n    """A."""\n    return (x, 1.0, (2, 3))\n'
    exec(text, scope)  # noqa: S102
    first = digest.digest(scope["f"])
    for changed, is_equal in (
        ("\n\n# a comment\n" + text, True),
        (text.replace("A.", "A longer one."), True),
        (text.replace("(2, 3)", "(2, 4)"), False),
        (text.replace("1.0", "1"), False),
        (text.replace("x, 1.0", "y, 1.0"), False),
    ):
        exec(changed, scope)  # noqa: S102
        assert (digest.digest(scope["f"]) == first) is is_equal, changed


# -- The second key: the text and what compiles it


def test_a_warm_start_traces_and_compiles_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    first = torques()
    monkeypatch.setattr(run, "trace", never)
    monkeypatch.setattr(llvm, "compile_text", never)
    monkeypatch.setattr(generated, "emit_scalar", never)
    assert np.array_equal(torques(), first)


@NEEDS_COMPILER
def test_code_that_gives_the_same_text_compiles_nothing(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = torques()
    names = set(folder.iterdir())
    monkeypatch.setattr(artifact, "formula_digest", lambda: "another version of this package")
    monkeypatch.setattr(llvm, "compile_text", never)
    assert np.array_equal(torques(), first)
    assert len(set(folder.iterdir()) - names) == 1  # the new first key, to the same code
    monkeypatch.setattr(run, "trace", never)
    assert np.array_equal(torques(), first)


@NEEDS_COMPILER
def test_all_that_decides_object_code_is_in_its_key(monkeypatch: pytest.MonkeyPatch) -> None:
    made = kernel("five_bar", "inverse", "native")
    trace = Kernel(made._program, made._sizes, "native").trace

    def key(form: Any = "rows") -> str:
        return artifact.second_key(native.source(trace, form), native)

    keys = [key(), key("one")]
    assert key() == keys[0]
    for owner, name, value in (
        (native, "LONG", 1),  # another level
        (native, "LEVEL", 2),
        (native, "compiler_digest", lambda: "another way to compile"),
        (llvm, "processor", lambda: ("another processor", "")),
        (llvm, "versions", lambda: ("0.45", "21.0.0")),
        (llvm, "vector_width", lambda: 2),
    ):
        with monkeypatch.context() as patch:
            patch.setattr(owner, name, value)
            keys.append(key())
    assert len(set(keys)) == len(keys)


def test_one_digit_of_a_text_is_another_key() -> None:
    text = "fadd double %a, 0x3FF0000000000000"
    sources = [Source(text, 1), Source(text, 0), Source(text.replace("3FF0", "3FF1"), 1)]
    assert len({artifact.second_key(source, generated) for source in sources}) == 3


def test_facts_without_their_code_are_made_anew(folder: Path) -> None:
    first = torques()
    entries = {path: path.read_bytes() for path in folder.glob("*.kernel")}
    facts = [path for path, data in entries.items() if b'"code_key"' in data]
    for path in set(entries) - set(facts):
        path.unlink()
    assert facts
    assert np.array_equal(torques(), first)
    assert {path: path.read_bytes() for path in folder.glob("*.kernel") if path in facts} == {
        path: entries[path] for path in facts
    }


def test_the_longest_unused_go_first(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cache, "MAX_ENTRIES", 3)
    keys = [letter * 64 for letter in "abcd"]
    for age, key in enumerate(keys[:3]):
        cache.write(key, cache.Entry())
        os.utime(folder / f"{key}.kernel", (1000.0 + age, 1000.0 + age))
    assert cache.read(keys[0]) is not None  # used once more
    cache.write(keys[3], cache.Entry())
    assert [cache.read(key) is None for key in keys] == [False, True, True, False]
