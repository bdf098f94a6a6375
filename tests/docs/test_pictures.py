"""The pictures of tools/make_page_pictures.py are those of the pages and of the code as it is."""

import importlib.util
import re
from pathlib import Path
from types import ModuleType

import pytest

from .blocks import ROOT

pytest.importorskip("matplotlib")


@pytest.fixture(scope="module")
def tool() -> ModuleType:
    spec = importlib.util.spec_from_file_location(
        "make_page_pictures", ROOT / "tools" / "make_page_pictures.py"
    )
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_robot_of_the_page_is_drawn_with_its_names(tool: ModuleType, tmp_path: Path) -> None:
    robots = tool.robots_of_the_page(tmp_path)
    assert {path.stem for path in tool.ROBOTS.iterdir()} == {*robots, "crank_and_cylinder_drawing"}
    page = tool.PAGE.read_text(encoding="utf-8")
    for name, robot in robots.items():
        assert f"images/own_robot/{name}.svg" in page
        drawn = (tool.ROBOTS / f"{name}.svg").read_text(encoding="utf-8")
        for joint in robot.coordinates:
            is_named = re.search(rf"[>, ]{joint}[<,]", drawn)
            assert is_named, f"{name}.svg lacks {joint}: run tools/make_page_pictures.py"


def test_the_lengths_drawn_are_those_of_the_file(tool: ModuleType, tmp_path: Path) -> None:
    figure = tool.with_dimensions(tool.robots_of_the_page(tmp_path)["crank_and_cylinder"])
    wanted = {text.get_text() for text in figure.axes[0].texts if " m" in text.get_text()}
    assert wanted == {"0.6 m", "0.8 m", "0.4 m + stroke", "0.3 m", "0.5 m"}
    drawn = (tool.ROBOTS / "crank_and_cylinder_drawing.svg").read_text(encoding="utf-8")
    assert all(text in drawn for text in wanted), "run tools/make_page_pictures.py"


def test_the_layers_drawn_are_those_that_are_held(tool: ModuleType) -> None:
    assert tool.LAYERS.read_text(encoding="utf-8") == tool.layers_picture(), (
        "run tools/make_page_pictures.py"
    )
