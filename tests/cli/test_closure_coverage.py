"""`check` says no more than what it computed."""

from __future__ import annotations

from pathlib import Path

import pytest

from hybrid_dynamics_cli.closure_coverage import PLACES
from tests.cli.calling import call, data_of, shipped_text

pytestmark = pytest.mark.usefixtures("python_kernels")


def test_loops_that_close_everywhere_are_reported_with_their_count() -> None:
    lines = call("check", "five_bar").stdout.splitlines()
    assert lines[-2:] == [
        f"loops close at all {PLACES} places tried within the limits of the active joints",
        "The description is right: every loop closes.",
    ]
    assert data_of("check", "five_bar")["tried"] == {
        "places": PLACES,
        "closed": PLACES,
    }


def test_loops_that_do_not_are_not_called_closing(tmp_path: Path) -> None:
    text = shipped_text("forging_chu2020")
    place = tmp_path / "wide.yaml"
    slide = "child: l12, origin: {xyz: [L11, 0, 0]}, axis: x"
    assert slide in text
    place.write_text(text.replace(slide, f"{slide}, limits: [-2, 2]"), encoding="utf-8")
    result = call("check", str(place))
    coverage = data_of("check", str(place))["tried"]
    assert result.exit_code == 0
    assert 0 < coverage["closed"] < coverage["places"] == PLACES
    assert f"loops close at {coverage['closed']} of {PLACES} places tried" in result.stdout
    assert "every loop closes" not in result.stdout
    assert "its loops close at the reference, and not all over the limits" in result.stdout


def test_a_robot_without_loops_has_none_to_try(tmp_path: Path) -> None:
    place = tmp_path / "arm.yaml"
    place.write_text(
        "format: 1\nname: arm\nlinks: {base: {}, a: {mass: 1}}\njoints: {q: {type: revolute,"
        " parent: base, child: a, axis: z}}\nactive: [q]\nend_effector: {link: a}\n",
        encoding="utf-8",
    )
    said = call("check", str(place))
    assert "tried" not in said.stdout
    assert said.exit_code == 0
    assert "no forward dynamics: " in said.stdout  # a point on its own axis turns without effort


def test_loops_that_hardly_close_are_not_called_right(tmp_path: Path) -> None:
    text = shipped_text("forging_chu2020")
    place = tmp_path / "far.yaml"
    slide = "child: l12, origin: {xyz: [L11, 0, 0]}, axis: x"
    place.write_text(text.replace(slide, f"{slide}, limits: [0, 150]"), encoding="utf-8")
    said = call("check", str(place)).stdout
    assert "joints.q12.limits: 150 m, and the robot reaches" in said
    assert "150 mm are written 0.15" in said
    assert "hardly anywhere else: are limits and lengths meant so?" in said
    assert "is right" not in said
    assert "its loop closes from" in call("workspace", str(place), "--samples", "50").stdout
