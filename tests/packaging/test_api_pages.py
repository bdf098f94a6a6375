"""The API reference has every public name of the core."""

from __future__ import annotations

import ast
import re

import pytest

from .test_rooms import ROOT, sources, tree_of

PAGES = ROOT / "docs" / "api"
CORE = "hybrid_dynamics_core"
# Their names are used by other packages of the core, and by nobody else.
INTERNAL = {
    f"{CORE}.{name}"
    for name in (
        "kernels.rewrite",
        "mechanism",
        "programs",
        "robot.passing",
        "robot.proofs",
        "view.overlays",
    )
}
# The data behind a robot file, whose keys `docs/own_robot.md` describes.
DATA = {f"{CORE}.description"}
# Offered a second time by `stiffness`.
REPEATED = {f"{CORE}.description.elasticity"}


def exported(module: str) -> set[str]:
    """The names in `__all__` of a package."""
    for node in tree_of(module).body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            return set(ast.literal_eval(node.value))
    return set()


def public_packages() -> list[str]:
    packages = []
    for name, path in sources().items():
        if path.name == "__init__.py" and name.startswith(CORE) and exported(name):
            packages.append(name)
    return sorted(set(packages) - INTERNAL - DATA - REPEATED)


def documented() -> set[str]:
    """Full names of all that the pages describe."""
    names = set()
    for page in PAGES.glob("*.md"):
        module = ""
        for line in page.read_text("utf-8").splitlines():
            if match := re.match(r"\.\. currentmodule:: (\S+)", line):
                module = match[1]
            elif match := re.match(r"\.\. auto\w+:: ([\w.]+)", line):
                name = match[1]
                names.add(name if name.startswith(CORE) else f"{module}.{name}")
    return names


@pytest.mark.parametrize("package", public_packages())
def test_every_public_name_has_an_entry(package: str) -> None:
    entries = {entry for entry in documented() if entry.startswith(f"{package}.")}
    names = {entry.rpartition(".")[2] for entry in entries}
    assert exported(package) - names == set()


def test_every_page_is_in_the_index() -> None:
    index = (PAGES / "index.md").read_text("utf-8")
    pages = {path.stem for path in PAGES.glob("*.md")} - {"index"}
    linked = set(re.findall(r"^\| \[[^\]]+\]\((\w+)\.md\)", index, re.MULTILINE))
    listed = set(index.partition("```{toctree}")[2].split())
    assert linked == pages
    assert pages <= listed


def test_internal_packages_exist() -> None:
    assert set(sources()) >= INTERNAL | DATA | REPEATED
