"""Every block of the README and of the pages in docs runs, and does what the page says."""

from __future__ import annotations

import ast
import builtins
import re
import shutil
from pathlib import Path
from typing import Any

import pytest

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.formats.reader import parse_description
from tests.sampling import swept

from .blocks import ROOT, RUN, Session, blocks_of

PAGES = [
    "README.md",
    "CONTRIBUTING.md",
    *sorted(str(path.relative_to(ROOT)) for path in ROOT.glob("docs/**/*.md")),
]
MARKS = re.compile(r"not run: \w.+|beside the node|needs \w+|file: [\w.-]+|")
OTHERS = {"text", "csv", "dockerfile", "json", "cmake"}  # languages of blocks that show something


@pytest.fixture
def read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Runs a page from top to bottom; the names that its Python leaves."""
    monkeypatch.chdir(tmp_path)

    def run(page: str) -> dict[str, Any]:
        session = Session(tmp_path)
        for block in blocks_of(page):
            if not block.beside_the_node:
                session.run(block)
        return session.names

    return run


# Pages whose results have tests below.
CHECKED = (
    "README.md",
    "docs/dynamics.md",
    "docs/examples.md",
    "docs/exchange.md",
    "docs/figure_10.md",
    "docs/humanoid.md",
    "docs/performance.md",
    "docs/view.md",
)


RUN_ALONE = [page for page in PAGES if page not in CHECKED and any(blocks_of(page))]
LONG = (  # some seconds of commands
    "docs/bags.md",
    "docs/cylinders.md",
    "docs/design_procedure.md",
    "docs/first_ten_minutes.md",
    "docs/in_your_controller.md",
    "docs/install.md",
    "docs/jax.md",
    "docs/own_robot.md",
    "docs/papers.md",
    "docs/robots.md",
    "docs/tolerances.md",
)


@pytest.mark.parametrize("page", swept(RUN_ALONE, [page for page in RUN_ALONE if page not in LONG]))
def test_every_block_runs(read: Any, page: str) -> None:
    needs(page)
    read(page)


def needs(page: str) -> None:
    """Skip where a library that the page's blocks use is not installed."""
    text = "".join(block.text for block in blocks_of(page) if not block.is_not_run)
    libraries = {
        "--draw": "matplotlib",
        "--plot": "matplotlib",
        "draw(": "matplotlib",
        "draw_simulation(": "matplotlib",
        "hybrid-dynamics": "click",
        "bag ": "rosbags",
    }
    if "gcc " in text and shutil.which("gcc") is None:
        pytest.skip("there is no gcc")
    for sign, library in libraries.items():
        if sign in text:
            pytest.importorskip(library)


@pytest.mark.parametrize("page", PAGES)
def test_every_block_is_run_or_says_why_not(page: str) -> None:
    for block in blocks_of(page):
        assert block.language in RUN | OTHERS, f"{block.where}: a block of {block.language}"
        assert MARKS.fullmatch(block.mark) or block.language in OTHERS, (
            f"{block.where}: what is '{block.mark}'?"
        )
    fences = re.findall(r"^```\w+$", (ROOT / page).read_text(encoding="utf-8"), re.MULTILINE)
    assert len(fences) == len(list(blocks_of(page)))  # none is hidden by its form


@pytest.mark.parametrize("page", PAGES)
def test_links_to_files_lead_somewhere(page: str) -> None:
    text = (ROOT / page).read_text(encoding="utf-8")
    prose = re.sub(r"^```.*?^```$", "", text, flags=re.DOTALL | re.MULTILINE)
    links = re.findall(r"\]\(([^)\s#]+)[^)]*\)", prose)
    files = [link for link in links if "://" not in link]
    folder = (ROOT / page).parent
    assert [file for file in files if not (folder / file).exists()] == []


def test_the_readme_runs(read: Any) -> None:
    needs("README.md")
    scope = read("README.md")
    assert scope["robot"].name == "excavator"
    assert scope["state"].residual < 1e-12


def test_python_of_the_readme_stands_alone() -> None:
    """A block that loads a robot can be copied into another script."""
    blocks = [block for block in blocks_of("README.md") if block.language == "python"]
    loading = [block for block in blocks if " = load(" in block.text]
    assert loading
    for block in loading:
        assert undefined_names(block.text) == set(), block.where


def undefined_names(code: str) -> set[str]:
    """Names that a piece of code uses, and neither makes nor imports."""
    nodes = [node for node in ast.walk(ast.parse(code)) if isinstance(node, ast.Name)]
    stored = {node.id for node in nodes if isinstance(node.ctx, ast.Store)}
    imports = " ".join(re.findall(r"import (.*)", code))
    imported = set(re.findall(r"\b\w+\b", imports))
    return {node.id for node in nodes} - stored - imported - set(dir(builtins))


def test_figure_10_is_made(read: Any, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    scope = read("docs/figure_10.md")
    assert scope["tau"].shape == (101, 4)
    assert (tmp_path / "figure_10.svg").stat().st_size > 10_000


@pytest.mark.sweep(sample="test_planes_are_chosen_for_the_robot")
def test_the_maps_of_the_examples_run(read: Any) -> None:
    needs("docs/examples.md")
    scope = read("docs/examples.md")
    extents = scope["found"].extents
    assert extents.shape == (3, 2)
    assert extents[2, 1] == pytest.approx(1.6, abs=0.01)  # b1 + L2 + L3 - b3, upright


def test_the_view_opens(read: Any) -> None:
    pytest.importorskip("viser")
    scope = read("docs/view.md")
    assert scope["viewer"].url.startswith("http://localhost:")
    assert scope["viewer"].session.motion.duration == 2.0


def test_dynamics_runs_and_does_what_it_says(read: Any, tmp_path: Path) -> None:
    scope = read("docs/dynamics.md")
    assert scope["ddu"] == pytest.approx([0.1, 0.2, 0.0, 0.0], abs=1e-9)
    assert scope["pendulum"].loads.effects.armature == pytest.approx([2.0, 0.0])
    assert scope["fall"].events[0].message.startswith("stick_cylinder reached its lower limit 0.32")
    assert scope["fall"].relative_energy_error < 1e-8
    assert scope["fall"].residual < 1e-12
    assert (tmp_path / "fall.npz").is_file()
    assert scope["run"].completed
    assert scope["run"].u[-1] == pytest.approx(scope["path"](1.0).u, abs=2e-3)
    assert _inside(scope) > 0.85


def _inside(scope: dict[str, Any]) -> float:
    """Share of the true base parameters within the intervals of the estimate."""
    result = scope["found"]
    truth = result.base.values(result.parameters.values(scope["robot"].description))
    low, high = result.interval.T
    return float(((truth > low) & (truth < high)).mean())


def test_the_humanoid_of_the_page_loads() -> None:
    block = next(block for block in blocks_of("docs/humanoid.md") if block.language == "yaml")
    robot = Robot(parse_description(block.text, file="humanoid.yaml"))
    assert len(robot.description.motors) == 12
    assert len(robot.idle) == 6
    drawn = (ROOT / "docs" / "images" / "humanoid.svg").read_text(encoding="utf-8")
    assert all(loop in drawn for loop in ("push_in_L", "push_out_L", "push_in_R", "push_out_R"))


@pytest.mark.sweep(sample="test_the_humanoid_of_the_page_loads")
def test_the_humanoid_stands_on_one_foot_and_falls(read: Any, tmp_path: Path) -> None:
    needs("docs/humanoid.md")
    scope = read("docs/humanoid.md")
    robot, standing, by_motor = scope["robot"], scope["standing"], scope["by_motor"]
    weight = 9.81 * robot.centroidal(standing).mass
    assert scope["contact"] == pytest.approx([0, 0, weight, 0, scope["contact"][4], 0], abs=1e-8)
    assert scope["pressure"] == pytest.approx(robot.centroidal(standing).com[0], abs=1e-9)
    shown = [by_motor[name] for name in ("q_in_L", "q_out_L", "knee_L")]
    assert shown == pytest.approx([5.5, 6.7, -41.0], abs=0.1)
    assert scope["push_off"] == pytest.approx(scope["ankle"].T @ [80.0, 5.0], rel=1e-9)
    assert scope["momentum"] == pytest.approx(
        robot.centroidal(standing).momentum_matrix @ scope["du"], abs=1e-12
    )
    assert scope["momentum"][0] != pytest.approx(0.0, abs=0.1)
    assert scope["fall"] == pytest.approx([0, 0, -9.81], abs=1e-9)
    assert (tmp_path / "humanoid.svg").stat().st_size > 10_000


def test_performance_runs(read: Any) -> None:
    scope = read("docs/performance.md")
    assert scope["efforts"].shape == (100_000, 4)
    assert scope["efforts"][7] == pytest.approx(scope["tau"], rel=1e-9, abs=1e-9)
    assert scope["moon"] == pytest.approx(scope["tau"] * 1.62 / 9.81, abs=1e-6)


def test_exchange_runs_and_does_what_it_says(read: Any) -> None:
    for engine in ("mujoco", "pinocchio"):
        pytest.importorskip(engine)
    scope = read("docs/exchange.md")
    assert scope["efforts"][1] == pytest.approx(scope["efforts"][0], rel=1e-9)
    assert scope["drift"] < 1e-6
    assert len(scope["constraints"]) == 4
    if "plant" in scope:  # where there is Drake
        assert scope["plant"].num_constraints() == 4
