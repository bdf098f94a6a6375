"""Every citation of an equation goes with what the equation is, by one table for both papers.

A citation is `Chu (2020), Eq. 17`; or `Eq. 17` alone, of the paper that the file named last. The
words before it have to be those of the table.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest

from .equations import PAPERS

ROOT = Path(__file__).parents[2]
KINDS = {".py", ".md", ".yaml", ".json", ".srv", ".msg", ".rst", ".toml", ".cff", ".js", ".html"}
FOLDERS = (
    "benchmarks",
    "docs",
    "examples",
    "hybrid_dynamics_cli",
    "hybrid_dynamics_core",
    "hybrid_dynamics_ros",
    "launch",
    "msg_defs",
    "tests",
    "tools",
)
OURS = {Path(__file__), Path(__file__).with_name("equations.py")}
CITATION = re.compile(r"\b(below )?(?:Eqs?\.|[Ee]quations?) ?\(?(\d+)\)?(?: (to|and) \(?(\d+)\)?)?")
PAPER = re.compile(r"\b(Chu|Staicu)\b(?! *,? et al\.\Z)")
WINDOW = 80  # characters before a citation, up to the one before
MISPRINT = re.compile(r"\((\d+)\)\s+prints (?=([^\n]*\n?[^\n]*))")


@dataclass(frozen=True)
class Citation:
    """A number of an equation with its paper, and the words before it."""

    place: str
    paper: str
    number: str
    words: str

    def fits(self, number: str) -> bool:
        """Whether the words are those of an equation."""
        equation = PAPERS[self.paper].get(number)
        return equation is not None and re.search(equation.beside, self.words) is not None


def files() -> Iterator[Path]:
    yield from (path for path in ROOT.iterdir() if path.suffix in KINDS)
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in KINDS and path not in OURS and "build" not in path.parts:
                yield path


def numbers(match: re.Match[str]) -> list[str]:
    below, first, word, last = match.groups()
    if word == "to":
        return [f"{first} to {last}"]
    name = first
    if below:
        name = f"below {first}"
    return [name] if last is None else [name, last]


def citations_in(text: str, place: str) -> Iterator[Citation]:
    end = 0
    for match in CITATION.finditer(text):
        papers = PAPER.findall(text, 0, match.start())
        line = text.count("\n", 0, match.start()) + 1
        before = text[max(end, match.start() - WINDOW) : match.start()]
        words = re.sub(r"[\s#]+", " ", before)
        for number in numbers(match):
            yield Citation(f"{place}:{line}", papers[-1] if papers else "", number, words)
        end = match.end()


@cache
def citations() -> tuple[Citation, ...]:
    everything: list[Citation] = []
    for path in files():
        everything += citations_in(path.read_text(encoding="utf-8"), str(path.relative_to(ROOT)))
    return tuple(everything)


def test_there_are_citations_of_both_papers() -> None:
    assert len(citations()) > 30
    assert {citation.paper for citation in citations()} == set(PAPERS)


def test_every_citation_names_its_paper() -> None:
    assert [citation.place for citation in citations() if citation.paper not in PAPERS] == []


def test_every_citation_goes_with_its_equation() -> None:
    wrong = [citation for citation in citations() if not citation.fits(citation.number)]
    assert wrong == []


def test_any_other_number_would_be_noticed() -> None:
    """The words beside a citation are of its equation alone; ranges hold their members."""
    for citation in citations():
        for number in PAPERS[citation.paper]:
            same = {number, citation.number} == {"17", "below 17"}
            if number == citation.number or same or " to " in number + citation.number:
                continue
            assert not citation.fits(number), f"{citation.place}: Eq. {number} fits too"


@pytest.mark.parametrize(
    "text",
    [
        "R (n_s, n), Chu (2020), Eq. 20.",
        "s'' = R u'' + R' u', Chu (2020), Eq. 20.",
        "M-bar u'' + C-bar u' + G-bar = tau, Chu et al. (2020), Eq. 25.",
        "tau = R^T f, Chu (2020), Eq. 22.",
        "the DAE of Chu (2020), Eq. 10, with J_s of Eq. 18",
        "C-bar = R^T (M R' + C R), Chu (2020), Eq. 24",
        "all 18 leg variables, Staicu (2015), Eq. 9",
    ],
)
def test_wrong_citations_are_noticed(text: str) -> None:
    assert not all(citation.fits(citation.number) for citation in citations_in(text, "text"))


def test_misprints_are_those_of_the_table() -> None:
    """`(2) prints alpha_E = -alpha_E`: the words come after."""
    count = 0
    for path in files():
        for number, words in MISPRINT.findall(path.read_text(encoding="utf-8")):
            fitting = [paper for paper in PAPERS.values() if number in paper]
            assert any(re.search(paper[number].beside, words) for paper in fitting), path
            count += 1
    assert count >= 3


def test_rows_of_the_errata_are_of_equations_in_the_table() -> None:
    text = (ROOT / "docs/errata.md").read_text(encoding="utf-8")
    chu, staicu = text.split("\n## Staicu (2015)\n")
    for part, paper in ((chu, PAPERS["Chu"]), (staicu, PAPERS["Staicu"])):
        cells = re.findall(r"^\| ([^|]*\(\d[^|]*)\|", part, re.MULTILINE)
        rows = re.findall(r"\((\d+)\)", " ".join(cells))
        assert rows
        assert set(rows) <= set(paper)
