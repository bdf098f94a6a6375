"""Overlays of the view show what the library computes at the present state."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from hybrid_dynamics_core import Payload, Robot, load
from hybrid_dynamics_core.capability import LiftingChart
from hybrid_dynamics_core.view.session import ViewSession

from .conftest import Opened

if TYPE_CHECKING:
    from hybrid_dynamics_core.view.viewer import Viewer


@pytest.fixture(scope="module")
def excavator() -> Robot:
    return load("excavator")


def overlay(viewer: Viewer, kind: str):
    """The overlay of a class."""
    (found,) = [one for one in viewer.overlays if type(one).__name__ == kind]
    return found


def test_a_dragged_tool_is_where_it_was_dragged_on_the_same_mode(excavator: Robot) -> None:
    session = ViewSession(excavator)
    target = np.add(session.tool(), [-0.3, 0.2, 0.4])
    assert session.reach(target)
    assert session.tool() == pytest.approx(target, abs=1e-8)
    assert session.state.branch == session.reference.branch


def test_a_tool_dragged_too_far_stays_nearest(excavator: Robot) -> None:
    session = ViewSession(excavator)
    assert session.reach([40.0, 0.0, 1.0])
    error = np.subtract([40.0, 0.0, 1.0], session.tool())
    state = session.state
    downhill = excavator.jacobian(state)[:3].T @ error
    lower, upper = excavator.limits.T
    at_limit = (state.u - lower < 1e-6) | (upper - state.u < 1e-6)
    assert np.abs(downhill[~at_limit]).max(initial=0.0) < 1e-3 * np.linalg.norm(error)
    assert (downhill * (state.u - 0.5 * (lower + upper)))[at_limit].min(initial=0.0) >= 0.0


def test_the_trace_has_a_gap_where_the_tool_jumps(needs_viser: None) -> None:  # noqa: ARG001
    from hybrid_dynamics_core.view.overlays.tool import Trace

    trace = Trace(size=1.0)
    places = [np.array([x, 0.0, 0.0]) for x in (0.0, 1e-4, 0.1, 0.2, 0.9, 1.0)]
    added = [trace.add(place) for place in places]
    assert added == [False, False, True, True, False, True]
    assert trace.segments[:, :, 0] == pytest.approx(np.array([[0, 0.1], [0.1, 0.2], [0.9, 1.0]]))
    trace.clear()
    assert trace.segments.shape == (0, 2, 3)


@pytest.mark.usefixtures("needs_viser")
def test_the_section_of_a_chart_is_what_is_lifted_at_a_height() -> None:
    from hybrid_dynamics_core.view.overlays.lifting import diagram, section

    a, b = np.meshgrid(np.linspace(0.1, 1.0, 7), np.linspace(-0.5, 1.0, 9), indexing="ij")
    radius, height = 4.0 * a - 0.3 * b, 2.0 * b + 0.2 * a
    mass = 3e3 - 500.0 * radius + 100.0 * height  # linear, so interpolation is exact
    mass[0, 0] = radius[0, 0] = np.nan  # the robot cannot be there
    limited = np.zeros((7, 9), int)
    chart = LiftingChart(
        ("q1", "q2"), np.zeros((7, 9, 2)), radius, height, mass, limited, ("q1",), 1.0
    )
    reach, lifted = section(chart, 0.7)
    assert len(reach) > 6
    assert (np.diff(reach) >= 0.0).all()
    assert lifted == pytest.approx(3e3 - 500.0 * reach + 70.0)
    assert section(chart, 9.0)[0].size == 0
    tool = 2.0
    assert f"{(3e3 - 500.0 * tool + 70.0) / 1e3:.2f} t" in diagram(reach, lifted, tool, 0.7)
    assert "outside the chart" in diagram(reach, lifted, reach[-1] + 0.1, 0.7)


def test_the_panel_has_pressures_and_pins_of_the_present_load(
    excavator: Robot, opened: Opened
) -> None:
    viewer = opened(excavator)
    session = viewer.session
    session.lift(500.0)
    loads = excavator.loads.with_payload(Payload(500.0), excavator.end_effector)
    tau = excavator.inverse_dynamics(session.state, np.zeros(4), loads)
    cylinder = excavator.hydraulics(session.state, tau)["boom_cylinder"]
    viewer.show()
    pressures = overlay(viewer, "PressuresOverlay").html.content
    assert f"{float(cylinder.cap_pressure) / 1e5:.4g}" in pressures
    pins = overlay(viewer, "PinsOverlay")
    assert pins.html.content == ""
    assert not pins.arrows
    pins.shown.value = True
    viewer.show()
    force = excavator.reactions(session.state, np.zeros(4), loads).pins["boom_loop"].force
    size = float(np.linalg.norm(force))
    assert f"{size:,.0f} N" in pins.html.content
    arrow = pins.arrows["boom_loop"]
    assert arrow.scale[2] == pytest.approx(size / pins.full * 0.25 * pins.size)
    w, x, y, z = arrow.wxyz
    along = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]
    assert along == pytest.approx((force / size).tolist(), abs=1e-9)


def test_robots_without_cylinders_and_limits_have_no_such_folders(opened: Opened) -> None:
    viewer = opened(load("five_bar"))
    kinds = [type(one).__name__ for one in viewer.overlays]
    assert "PressuresOverlay" not in kinds
    assert "ToolOverlay" in kinds
    viewer.show()
