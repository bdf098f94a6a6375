"""The page of the shipped robots is the one its script makes."""

import importlib.util
from pathlib import Path

import pytest

from hybrid_dynamics_core import load, shipped_robots

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def pictures():
    spec = importlib.util.spec_from_file_location(
        "make_pictures", ROOT / "tools" / "make_pictures.py"
    )
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_page_is_up_to_date(pictures) -> None:
    page = (ROOT / "docs" / "robots.md").read_text(encoding="utf-8")
    assert page == pictures.page(), "run tools/make_pictures.py"


def test_every_picture_of_the_page_is_there_and_small(pictures) -> None:
    folder = ROOT / "docs" / pictures.IMAGES
    wanted = {f"{name}.svg" for name in shipped_robots()}
    wanted |= {f"{name}_modes.svg" for name in pictures.MODES}
    painted = [name for name in shipped_robots() if load(name).description.visuals]
    wanted |= {f"{name}_visuals.svg" for name in painted}
    assert painted == ["excavator"]
    assert {path.name for path in folder.iterdir()} == wanted
    for path in folder.iterdir():
        assert path.stat().st_size < pictures.LARGEST
