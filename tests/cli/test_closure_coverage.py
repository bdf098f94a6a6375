"""`check` says no more than what it computed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hybrid_dynamics_cli.closure_coverage import PLACES
from hybrid_dynamics_core import SingularityError, load
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
        "singular": 0,
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


SCISSOR = """\
format: 1
name: scissor
links: {base: {}, arm1: {mass: 10}, arm2: {mass: 10}, skid: {mass: 2}, table: {mass: 50},
  slider: {mass: 2}, barrel: {mass: 3}, rod: {mass: 2}}
joints:
  roll: {type: prismatic, parent: base, child: skid, axis: x}
  a1: {type: revolute, parent: base, child: arm1, axis: z}
  a2: {type: revolute, parent: skid, child: arm2, axis: z}
  t: {type: revolute, parent: arm2, child: table, axis: z, origin: {xyz: [1, 0, 0]}}
  slide: {type: prismatic, parent: table, child: slider, axis: x}
  tilt: {type: revolute, parent: base, child: barrel, axis: z, origin: {xyz: [0.1, -0.1, 0]}}
  stroke: {type: prismatic, parent: barrel, child: rod, axis: x, origin: {xyz: [0.4, 0, 0]},
    limits: [0.05, 0.5]}
closures:
  middle: {kind: planar, between: {arm1: [0.5, 0, 0], arm2: [0.5, 0, 0]}}
  level: {kind: planar, between: {slider: [0, 0, 0], arm1: [1, 0, 0]}}
  lift: {kind: planar, between: {rod: [0, 0, 0], arm1: [0.7, 0, 0]}}
active: [stroke]
end_effector: {link: table}
reference: {stroke: 0.25, a1: 0.5, a2: 2.6, roll: 0.85, t: -2.6, slide: 0.85, tilt: 0.8}
"""


def test_places_that_close_and_are_singular_are_counted_apart(tmp_path: Path) -> None:
    """Upright the arms of a lift table lie on each other: from there on it is singular."""
    place = tmp_path / "scissor.yaml"
    place.write_text(SCISSOR, encoding="utf-8")
    upright = np.hypot(0.1, 0.7 + 0.1) - 0.4  # arm1 straight up, by hand
    machine = load(place)
    assert machine.closing_range[0, 1] == pytest.approx(upright, abs=1e-6)
    with pytest.raises(SingularityError):
        machine.close([upright + 0.01])
    said = call("check", str(place)).stdout
    assert "tried within the limits of the active joints, as the file gives them; " in said
    assert "more are singular" in said
