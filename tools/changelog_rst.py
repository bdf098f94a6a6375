"""Write the CHANGELOG.rst of both packages from the releases in CHANGELOG.md.

python tools/changelog_rst.py

bloom reads these files (REP-132). What is not released yet stays in CHANGELOG.md.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = {"hybrid_dynamics_ros": ROOT, "hybrid_dynamics_msgs": ROOT / "msg_defs"}
RELEASE = re.compile(
    r"^## \[(?P<version>\d+\.\d+\.\d+)\] - (?P<date>\d{4}-\d{2}-\d{2})$", re.MULTILINE
)
KIND = re.compile(r"^### (\w+)\n(.*?)(?=^### |^## |\Z)", re.MULTILINE | re.DOTALL)
ENTRY = re.compile(r"^- (.*?)(?=^- |^\S|\Z)", re.MULTILINE | re.DOTALL)
CODE_OR_LINK = re.compile(r"(`[^`]+`|\[[^\]]+\]\([^)]+\))")
FORTHCOMING = (
    "Forthcoming\n-----------\n* What is not released yet stands in CHANGELOG.md of the"
    " repository.\n"
)


def changelog_of(package: str, markdown: str) -> str:
    """The CHANGELOG.rst of a package; both are released together, with one list of changes."""
    title = f"Changelog for package {package}"
    bar = "^" * len(title)
    parts = [f"{bar}\n{title}\n{bar}\n\n{FORTHCOMING}", *_releases(markdown)]
    return "\n".join(parts)


def _releases(markdown: str) -> Iterator[str]:
    releases = list(RELEASE.finditer(markdown))
    starts = [release.start() for release in releases]
    ends = [*starts, len(markdown)][1:]
    for release, end in zip(releases, ends, strict=True):
        text = markdown[release.end() : end]
        heading = f"{release['version']} ({release['date']})"
        entries = "".join(f"* {entry}\n" for entry in _entries(text))
        yield f"{heading}\n{'-' * len(heading)}\n{entries}"


def _entries(text: str) -> Iterator[str]:
    """One line for each entry, with the kind of change before it."""
    for kind, block in KIND.findall(text):
        for entry in ENTRY.findall(block):
            yield f"{kind}: {_inline(' '.join(entry.split()))}"


def _inline(text: str) -> str:
    """Markdown's code and links as reStructuredText has them."""
    return "".join(_part(part) for part in CODE_OR_LINK.split(text))


def _part(part: str) -> str:
    if not CODE_OR_LINK.fullmatch(part):
        return re.sub(r"([*_|])", r"\\\1", part)  # these would begin something there
    if part.startswith("`"):
        return f"`{part}`"
    label, _, address = part[1:-1].partition("](")
    return f"`{label} <{address}>`__"


def main() -> None:
    """Write both files."""
    markdown = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    for package, folder in PACKAGES.items():
        (folder / "CHANGELOG.rst").write_text(changelog_of(package, markdown), encoding="utf-8")


if __name__ == "__main__":
    main()
