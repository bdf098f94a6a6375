"""Write the CHANGELOG.rst of both packages, which bloom reads (REP-132), from the releases in CHANGELOG.md.

usage: python tools/changelog_rst.py. What is not released yet stays in CHANGELOG.md.
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
    found = list(RELEASE.finditer(markdown))
    ends = [*(release.start() for release in found), len(markdown)][1:]
    for release, end in zip(found, ends, strict=True) if found else ():
        text = markdown[release.end() : end]
        heading = f"{release['version']} ({release['date']})"
        yield f"{heading}\n{'-' * len(heading)}\n" + "".join(
            f"* {entry}\n" for entry in _entries(text)
        )


def _entries(text: str) -> Iterator[str]:
    """One line for each entry, with the kind of change before it."""
    for kind, block in re.findall(
        r"^### (\w+)\n(.*?)(?=^### |^## |\Z)", text, re.MULTILINE | re.DOTALL
    ):
        for entry in re.findall(r"^- (.*?)(?=^- |^\S|\Z)", block, re.MULTILINE | re.DOTALL):
            yield f"{kind}: {_inline(' '.join(entry.split()))}"


def _inline(text: str) -> str:
    """Markdown's code and links as reStructuredText has them; a bare * or _ would begin something there."""
    parts = re.split(r"(`[^`]+`|\[[^\]]+\]\([^)]+\))", text)
    return "".join(
        _marked(part) if k % 2 else re.sub(r"([*_|])", r"\\\1", part)
        for k, part in enumerate(parts)
    )


def _marked(part: str) -> str:
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
