"""The gallery shows every script, and has its pictures."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "examples.md").read_text(encoding="utf-8")
IMAGES = ROOT / "docs" / "images" / "examples"
LARGEST = 250_000  # bytes


def test_every_script_is_on_the_page_with_its_picture() -> None:
    shown = set(re.findall(r"\(images/examples/([\w.]+)\)", PAGE))
    examples = (ROOT / "examples").glob("*.py")
    figures = (ROOT / "examples" / "figures").glob("*_figure_*.py")
    for script in (*examples, *figures):
        assert f"{script.stem}.svg" in shown
        assert script.name in PAGE or re.fullmatch(r"staicu2015_figure_[6-9]", script.stem)
    assert shown == {place.name for place in IMAGES.iterdir()}
    for place in IMAGES.iterdir():
        assert place.stat().st_size < LARGEST, place


def test_links_within_the_page_lead_somewhere() -> None:
    heads = re.findall(r"^#+ (.+)$", PAGE, re.MULTILINE)
    anchors = {re.sub(r"[^\w -]", "", head.lower()).replace(" ", "-") for head in heads}
    for anchor in re.findall(r"\(#([\w-]+)\)", PAGE):
        assert anchor in anchors
    for place in re.findall(r"\]\(([\w/]+\.md)\)", PAGE):
        assert (ROOT / "docs" / place).is_file()
