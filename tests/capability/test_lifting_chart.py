"""Lifting charts: each mass is what the drives hold there, and the picture says so."""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core import InputError, load
from hybrid_dynamics_core.capability import lifting_chart
from tests.cli.calling import call, data_of


@pytest.fixture(scope="module")
def excavator():
    return load("excavator")


@pytest.fixture(scope="module")
def chart(excavator):
    return lifting_chart(excavator, frame="bucket", share=0.87)


def test_each_mass_is_held_where_the_chart_has_it(excavator, chart):
    assert chart.joints == ("boom_cylinder", "stick_cylinder")
    rng = np.random.default_rng(1)
    places = np.argwhere(np.isfinite(chart.mass))
    for i, j in places[rng.integers(0, len(places), 12)]:
        state = excavator.close(chart.u[i, j])
        position = excavator.forward_kinematics(state, "bucket").position
        assert [chart.radius[i, j], chart.height[i, j]] == pytest.approx(
            [np.hypot(*position[:2]), position[2]], abs=1e-9
        )
        lifted = excavator.capability(state, frame="bucket").lifted_mass()
        assert chart.mass[i, j] == pytest.approx(max(0.87 * lifted.value, 0.0), rel=1e-9)
        assert chart.drives[chart.limited_by[i, j]] == lifted.limited_by[0]


def test_the_chart_is_drawn_with_its_numbers(excavator, chart, tmp_path):
    pytest.importorskip("matplotlib")
    from hybrid_dynamics_core.drawing import draw_lifting_chart

    figure = draw_lifting_chart(excavator, chart, tmp_path / "chart.svg")
    axes = figure.axes[0]
    numbers = [text for text in axes.texts if text.get_text().replace(".", "").isdigit()]
    assert len(numbers) > 20
    for text in numbers:
        x, z = text.get_position()
        gap = np.hypot(chart.radius - x, chart.height - z)
        about = np.argsort(np.nan_to_num(gap, nan=np.inf), axis=None)[:9]
        neighbours = chart.mass.ravel()[about] / 1000.0  # rounded to 0.1 t in the picture
        assert neighbours.min() - 0.06 < float(text.get_text()) < neighbours.max() + 0.06
    assert "87 %" in figure.texts[1].get_text()


def test_the_command_tells_forces_and_what_limits_them():
    data = data_of("capability", "excavator", "--limit", "slew=90*kN*m", "--axes", "x,z")
    assert data["forces"]["+z"]["limited_by"] == ["boom_cylinder"]
    assert data["limits"]["slew"] == [-90e3, 90e3]
    normals, offsets = np.array(data["polytope"]["normals"]), data["polytope"]["offsets"]
    up = data["forces"]["+z"]["value"]
    assert (normals @ [0.0, up] <= np.array(offsets) + 1e-6 * up).all()
    text = call("capability", "excavator").stdout
    assert "breakout, bucket_cylinder" in text
    assert "no limit" in text
    wrong = call("capability", "excavator", "--limit", "boom_cylindr=3*kN")
    assert wrong.exit_code == 2
    assert "--limit: there is no drive" in wrong.output
    assert "did you mean 'boom_cylinder'" in wrong.output


def test_charts_that_cannot_be_drawn_are_refused(excavator):
    with pytest.raises(InputError, match="no active joint 'boom'"):
        lifting_chart(excavator, ("boom", "stick_cylinder"))
    with pytest.raises(InputError, match="share is 2"):
        lifting_chart(excavator, share=2.0)
