"""bloom's changelogs are made from the one that people write."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SPEC = importlib.util.spec_from_file_location("changelog_rst", ROOT / "tools" / "changelog_rst.py")
assert SPEC is not None
assert SPEC.loader is not None
tool = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(tool)

MARKDOWN = """# Changelog

## [Unreleased]

### Added
- Nothing yet.

## [0.2.0] - 2031-05-04

### Added
- A method `close_path(u)` for motions,
  row by row: [the page](docs/dynamics.md).
- R = [E; -J_z] and 2 * 3.

### Changed
- The node `hybrid_dynamics`.

## [0.1.0] - 2030-01-02

### Added
- Everything.
"""


@pytest.mark.parametrize("package", tool.PACKAGES)
def test_the_files_that_are_there_are_made_from_the_markdown(package: str) -> None:
    made = tool.changelog_of(package, (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"))
    file = tool.PACKAGES[package] / "CHANGELOG.rst"
    assert file.read_text(encoding="utf-8") == made, "run python tools/changelog_rst.py"


# catkin_pkg with a newer docutils warns.
@pytest.mark.filterwarnings("ignore:nodes.Node.traverse:DeprecationWarning")
def test_every_release_is_read_as_bloom_reads_it() -> None:
    changelog = pytest.importorskip("catkin_pkg.changelog")
    text = tool.changelog_of("hybrid_dynamics_ros", MARKDOWN)
    made = changelog.populate_changelog_from_rst(changelog.Changelog("hybrid_dynamics_ros"), text)
    dates = {}
    texts = {}
    for version, date, content in made.foreach_version():
        dates[version] = str(date.date())
        texts[version] = "\n".join(part.as_txt() for part in content)
    assert dates == {"0.2.0": "2031-05-04", "0.1.0": "2030-01-02"}
    assert texts["0.2.0"].splitlines() == [
        "* Added: A method ``close_path(u)`` for motions, row by row: the page <docs/dynamics.md>.",
        "* Added: R = [E; -J_z] and 2 * 3.",
        "* Changed: The node ``hybrid_dynamics``.",
    ]
