"""The papers' own formulas, in examples/papers, against the library's closures and dynamics."""

from __future__ import annotations

import math
import re
import runpy
import sys
from importlib import resources
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from scipy.optimize import fsolve

from hybrid_dynamics_core import Robot, load
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.mechanism.configuration import given_configuration
from tests.sampling import examples
from tests.strategies import positions

from .equations import FIGURES, LAST, LAST_FIGURE, NOT_ON_RECORD, PAPERS
from .test_forging_chu2020 import REFERENCE, ROWS, close_to, label
from .test_staicu2015 import POSE, law
from .test_staicu2015 import REFERENCE as STAICU_REFERENCE

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "examples" / "papers"
PAGE = (ROOT / "docs" / "papers.md").read_text(encoding="utf-8")
PARTS = ("classes", "tables", "closures", "jacobians", "lemma", "graph", "legs")
FORGING = load("forging_chu2020")
STAICUS = load("staicu2015")


def script(name: str) -> ModuleType:
    """A module of examples/papers."""
    module = ModuleType(name)
    module.__dict__.update(runpy.run_path(str(FOLDER / f"{name}.py"), run_name=name))
    return module


chu = script("chu2020_forms")
staicu = script("staicu2015_forms")


def named(values: Any) -> dict[str, float]:
    return dict(zip(FORGING.coordinates, np.asarray(values).tolist(), strict=True))


@pytest.fixture(scope="module")
def with_pins() -> Robot:
    """The forging robot with all four loops as pins; parallelograms close by angles otherwise."""
    robots = resources.files("hybrid_dynamics_core").joinpath("robots")
    text = robots.joinpath("forging_chu2020.yaml").read_text(encoding="utf-8")
    assert text.count("assembly: parallelogram") == 2
    return Robot(parse_description(text.replace("assembly: parallelogram", "assembly: clockwise")))


def test_lengths_are_those_of_table_1() -> None:
    assert set(REFERENCE["params"]) - set(chu.LENGTHS) == {"L12", "L22", "g"}
    for name, length in chu.LENGTHS.items():
        assert length == REFERENCE["params"][name]
    assert [*chu.U, *chu.Z] == list(FORGING.coordinates)
    assert sorted(chu.APPENDIX) == sorted(chu.Z)


@pytest.mark.parametrize("k", range(10))
def test_closures_are_the_librarys_at_any_coordinates(with_pins: Robot, k: int) -> None:
    """f1 to f8 and their Jacobian, closed or not; the axes of the planes may be others.

    f, J of one and Q f, Q J of the other have the same products.
    """
    s = np.random.default_rng(k).uniform(-3.0, 3.0, 12)
    model = with_pins._model
    configuration = given_configuration(model.tree, dict(enumerate(s)))
    f = chu.closures(named(s))
    J = chu.jacobian(named(s), FORGING.coordinates)
    loops = model.plan.loops
    assert [loop.name for loop in loops] == ["theta_1", "theta_2", "theta_3", "theta_4"]
    for number, loop in enumerate(loops):
        linear = loop.linearise(configuration)
        theirs = np.zeros((2, 13))
        for row, residual, entries in zip(theirs, linear.residual, linear.rows, strict=True):
            row[0] = residual
            for coordinate, entry in entries.items():
                row[1 + coordinate] = entry
        theirs *= loop.length
        pair = slice(2 * number, 2 * number + 2)
        ours = np.column_stack([f[pair], J[pair]])
        assert ours.T @ ours == pytest.approx(theirs.T @ theirs, abs=1e-12)


@pytest.mark.parametrize("k", range(3))
def test_the_jacobian_is_that_of_the_closures(k: int) -> None:
    s = np.random.default_rng(k).uniform(-3.0, 3.0, 12)
    h = 1e-6
    J = chu.jacobian(named(s), FORGING.coordinates)
    for column, step in zip(J.T, h * np.eye(12), strict=True):
        slope = (chu.closures(named(s + step)) - chu.closures(named(s - step))) / (2.0 * h)
        assert column == pytest.approx(slope, abs=1e-9)


@examples(30)
@given(positions(FORGING))
def test_closed_states_meet_the_papers_equations(u: np.ndarray) -> None:
    """f = 0, T and R, at states that the library has closed with other equations.

    As general four-bars the parallelograms have change points, which are kept away from.
    """
    state = FORGING.close(u)
    s = named(state.s)
    assert np.abs(chu.closures(s)).max() < 1e-12
    assume(abs(math.cos(s["q2"] + s["q3"])) > 0.1)
    assume(abs(math.sin(s["q2"])) > 0.1)
    allowed = 1e-11 * np.abs(state.R).max()  # J_z is a tenth as well conditioned as its blocks
    assert chu.passive_map(s) == pytest.approx(state.R[4:], abs=allowed)
    assert chu.velocity_map(s) == pytest.approx(state.R, abs=allowed)


@pytest.mark.parametrize("row", ROWS, ids=label)
def test_reference_values_meet_the_papers_equations(row: dict) -> None:
    """Without the library: reference values of z, and of z' = T u'."""
    s = named([*row["u"], *row["z"]])
    assert np.abs(chu.closures(s)).max() < 1e-12
    assert close_to(chu.passive_map(s) @ row["ud"], row["zd"])


def test_errata_f8_as_printed_tilts_the_carrier() -> None:
    """ERRATA: f8 prints sin for cos. How far it tilts depends on f7 too, here as in the script."""
    printed = {"f7": chu.CLOSURES["f7"], "f8": chu.PRINTED_F8}
    assert chu.CLOSURES["f8"] != chu.PRINTED_F8
    tilts = []
    for second in (0, 5, 10):
        row = REFERENCE["trajectory"][second]
        s = named([*row["u"], *row["z"]])

        def gap(angles: np.ndarray, s: dict[str, float] = s) -> list[float]:
            values = {**s, "q41": float(angles[0]), "q42": float(angles[1])}
            return [chu.value(formula, values) for formula in printed.values()]

        _, q42 = fsolve(gap, [s["q41"], s["q42"]], xtol=1e-12)
        tilts.append(round(math.degrees(s["q2"] + s["q3"] + q42)))
    assert tilts == [1, -17, -52]
    assert "{:+}, {} and {} degrees".format(*tilts) in PAGE


@pytest.mark.parametrize("row", STAICU_REFERENCE["example"], ids=lambda row: f"t={row['t']}")
def test_leg_formulas_give_the_reference_values(row: dict) -> None:
    for name, number in staicu.leg_variables(law(row["t"])[0]).items():
        assert number == pytest.approx(row[name][0], abs=1e-12)


@pytest.mark.parametrize("k", range(5))
def test_leg_formulas_are_the_librarys_closure(k: int) -> None:
    """At any pose, with both modules moved about all their axes."""
    sizes = [0.08, 0.08, 0.1, 0.3, 0.3, 0.3]
    values = np.random.default_rng(k).uniform(-1.0, 1.0, 6) * sizes
    pose = dict(zip(POSE, values.tolist(), strict=True))
    variables = staicu.leg_variables(pose)
    s = dict(zip(STAICUS.coordinates, STAICUS.close_given(pose).s.tolist(), strict=True))
    assert len(variables) == 18
    assert variables == pytest.approx({name: s[name] for name in variables}, abs=1e-12)


def test_the_graph_has_every_joint_and_tie_once() -> None:
    lines = staicu.graph(STAICUS.description)
    joints = re.findall(r"-(\w+)-", " ".join(lines))
    assert sorted(joints) == sorted(STAICUS.coordinates)
    assert sum("=ball=" in line for line in lines) == len(STAICUS.description.closures) == 6
    assert len(lines) == 8  # six legs and two platforms


@pytest.mark.parametrize("name", ["forging_chu2020", "type_c", "type_d", "excavator", "palletizer"])
def test_class_iii_is_an_arm_with_loops(name: str) -> None:
    loops = load(name).description.loops
    assert loops
    assert {loop.type for loop in loops.values()} <= set("ABCD")


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Any:
    monkeypatch.syspath_prepend(str(FOLDER))

    def printed(*words: str) -> str:
        monkeypatch.setattr(sys, "argv", ["line_by_line.py", *words])
        runpy.run_path(str(FOLDER / "line_by_line.py"), run_name="__main__")
        return capsys.readouterr().out

    return printed


def test_the_script_prints_every_part(run: Any) -> None:
    out = run()
    for part in PARTS:
        assert f"== {part}\n" in out
    for formula in chu.CLOSURES.values():
        assert formula in out
    assert out.count("equal to 1e-12") == 6
    assert out.count("= 0 to 1e-12 m") == 8


def test_the_script_names_its_parts(run: Any, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        run("closure")
    assert "there is no part 'closure': classes, tables" in capsys.readouterr().err


ROW = re.compile(
    r"^\| ((?:below )?\(\d+\)(?: to \(\d+\))?) \| ([^|]+) \| ([^|]+) \|$", re.MULTILINE
)
FIGURE_ROW = re.compile(r"^\| (\d[\d, to]*) \| ([^|]+) \| ([^|]+) \|$", re.MULTILINE)
GIVES = re.compile(
    r"`[^`]+`|\[[^]]+\]\([^)]+\)|the same"
)  # code of the library, or a place to read


def part_of(paper: str) -> str:
    """What the page has of a paper."""
    first, second = PAGE.split("\n## Staicu (2015)\n")
    return {"Chu": first, "Staicu": second}[paper]


def numbers(name: str) -> list[int]:
    """Those of `3`, `3 to 5`, `3, 5` and `below 3`."""
    first, *last = map(int, re.findall(r"\d+", name))
    return [*range(first, last[0] + 1)] if " to " in name else [first, *last]


@pytest.mark.parametrize("paper", PAPERS)
def test_the_page_has_the_table_of_equations(paper: str) -> None:
    rows = ROW.findall(part_of(paper))
    shown = {re.sub(r"[()]", "", number): what for number, what, _ in rows}
    assert shown == {number: equation.what for number, equation in PAPERS[paper].items()}


@pytest.mark.parametrize("paper", PAPERS)
def test_every_equation_has_a_row_and_what_gives_it(paper: str) -> None:
    every = {number for name in PAPERS[paper] for number in numbers(name)}
    assert every == set(range(1, LAST[paper] + 1))
    for number, _, gives in ROW.findall(part_of(paper)):
        assert GIVES.search(gives), number


@pytest.mark.parametrize("paper", FIGURES)
def test_every_figure_has_a_row_and_what_gives_it(paper: str) -> None:
    rows = FIGURE_ROW.findall(part_of(paper))
    assert {number: what for number, what, _ in rows} == FIGURES[paper]
    every = sorted(number for name, _, _ in rows for number in numbers(name))
    assert every == [*range(1, LAST_FIGURE + 1)]
    assert all(GIVES.search(gives) for _, _, gives in rows)


def test_what_is_not_on_record_cannot_be_cited() -> None:
    for equations in PAPERS.values():
        for number, equation in equations.items():
            if equation.what.startswith(NOT_ON_RECORD):
                assert not re.search(equation.beside, f"whatever (Eq. {number}) says"), number


def test_the_page_shows_every_part() -> None:
    for part in PARTS:
        assert f"$ python examples/papers/line_by_line.py {part}\n" in PAGE
