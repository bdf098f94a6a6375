"""What is shown follows what is asked for, or stays and says why."""

from __future__ import annotations

import threading
from collections.abc import Callable
from types import SimpleNamespace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import InputError, Payload, Robot, load
from hybrid_dynamics_core.control import JointTrajectory
from hybrid_dynamics_core.description.actuators import HydraulicCylinder
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.view.effort_scale import EffortScale
from hybrid_dynamics_core.view.motion import motion_of
from hybrid_dynamics_core.view.panel_html import (
    efforts_html,
    mode_labels,
    modes_html,
    problem_html,
    state_html,
)
from hybrid_dynamics_core.view.ranges import (
    Range,
    on_round_steps,
    on_step,
    round_above,
    round_value,
    slider_ranges,
)
from hybrid_dynamics_core.view.session import DriveEfforts, ViewSession
from hybrid_dynamics_core.view.state_interpolation import SPAN
from tests.export.test_round_trip import CART
from tests.mechanisms import changed
from tests.sampling import examples, swept

from .conftest import Opened

if TYPE_CHECKING:
    from hybrid_dynamics_core.view.slider import Slider

PATIENCE = 30.0  # [s] a machine may be loaded; nothing waits for this where all is well
EXACT = 1e-12  # the same computation twice, in another order at most


def swing(robot: Robot) -> JointTrajectory:
    """Half a second there."""
    way = 0.1 * (robot.closing_range[:, 1] - robot.closing_range[:, 0])
    return JointTrajectory.between(
        robot.reference, robot.reference + np.where(np.isfinite(way), way, 0.2), 0.5
    )


def test_a_move_that_does_not_close_leaves_the_pose_and_says_why(
    forging: Robot, opened: Opened
) -> None:
    viewer = opened(forging)
    session, before = viewer.session, np.array(viewer.session.state.s)
    assert not session.move(np.add(forging.reference, [0.0, 0.9, 0.0, 0.0]))
    viewer.show()
    assert np.array_equal(session.state.s, before)
    assert "q12" in session.problem
    assert "[-0.1, 0.7] m, where the loop closes" in problem_html(session.problem)
    assert session.move(np.add(forging.reference, [0.0, 0.05, 0.0, 0.0]))
    assert session.problem == ""
    assert problem_html(session.problem) == ""


def test_a_move_keeps_the_assembly_mode(forging: Robot) -> None:
    session = ViewSession(forging)

    session.take_mode(session.modes()[1])
    branch = dict(session.state.branch)
    assert branch != dict(session.reference.branch)
    assert session.move(np.add(session.state.u, [0.1, 0.02, 0.01, 0.2]))
    assert dict(session.state.branch) == branch
    session.reset()
    assert np.array_equal(session.state.s, session.reference.s)


@pytest.mark.parametrize("name", ["forging_chu2020", "gough", "excavator"])
def test_every_assembly_mode_can_be_chosen_and_has_another_name(name: str) -> None:
    session = ViewSession(load(name))
    modes = session.modes()
    labels = mode_labels(modes, session.reference.branch)
    assert len(set(labels)) == len(labels) > 1
    for k, mode in enumerate(modes):
        session.take_mode(mode)
        assert session.present(modes) == k
        assert (
            float(np.asarray(session.state.residual)) < 1e-9
        )  # closed to what Newton's iteration ends with


def test_efforts_are_those_of_the_model(forging: Robot) -> None:
    session = ViewSession(forging)
    at_standstill = forging.inverse_dynamics(session.state, np.zeros(4))
    efforts = session.efforts()
    assert dict(zip(efforts.joints, efforts.values, strict=True)) == pytest.approx(
        dict(zip(forging.active, at_standstill, strict=True)), rel=EXACT, abs=1e-9
    )
    session.payload = 20.0
    laden = forging.inverse_dynamics(
        session.state, np.zeros(4), forging.loads.with_payload(Payload(20.0))
    )
    assert session.efforts().values == pytest.approx(laden, rel=EXACT, abs=1e-9)
    assert f"{laden[1]:,.0f}" in efforts_html(forging, session.efforts())


def test_efforts_of_drives_that_are_not_active_joints_belong_to_the_drives() -> None:
    robot = load("excavator")
    session = ViewSession(robot)
    tau = robot.inverse_dynamics(session.state, np.zeros(len(robot.active)))
    assert session.efforts().joints == robot.drives
    back = robot.generalised_forces(
        session.state, dict(zip(session.efforts().joints, session.efforts().values, strict=True))
    )
    assert back == pytest.approx(tau, rel=1e-9)  # one linear system solved and multiplied back


def test_numbers_of_the_state_are_on_the_page(forging: Robot) -> None:
    session = ViewSession(forging)
    session.move(np.add(forging.reference, [0.3, 0.05, 0.02, 0.1]))
    text = state_html(session)
    for value in forging.forward_kinematics(session.state).position:
        assert f"{value:.4f}" in text
    assert f"{session.state.singularity:.3f}" in text
    for loop, mode in session.state.branch.items():
        assert loop in modes_html(session.state)
        assert mode in modes_html(session.state)


@pytest.mark.parametrize(
    "name", swept(["forging_chu2020", "staicu2015", "excavator"], ["forging_chu2020", "excavator"])
)
def test_sliders_reach_as_far_as_the_loops_close(name: str) -> None:
    robot = load(name)
    session = ViewSession(robot)
    ranges = slider_ranges(robot, session.reference, 1.0)
    assert np.isfinite(ranges).all()
    assert (ranges[:, 0] < robot.reference).all()
    assert (ranges[:, 1] > robot.reference).all()
    for k in np.flatnonzero(~np.isfinite(robot.limits).any(axis=1)):
        for end in ranges[k]:
            session.reset()
            target = np.array(robot.reference)
            target[k] = end
            assert session.move(target), session.problem


@given(st.floats(1e-6, 1e6))
@examples(80)
def test_round_numbers_are_one_two_or_five_and_near(value: float) -> None:
    every = np.array([digit * 10.0**power for power in range(-8, 8) for digit in (1, 2, 5)])
    nearest = every[np.argmin(np.abs(np.log(every / value)))]
    assert round_value(value) == pytest.approx(nearest, rel=1e-12)
    assert round_above(value) == pytest.approx(every[every >= value * (1.0 - 1e-9)].min())


@pytest.mark.parametrize(
    ("low", "high"), [(-np.pi, np.pi), (0.0321098, 0.7), (-0.1, 0.3), (0.0, 1e-3), (-6.28, 6.28)]
)
def test_sliders_have_round_steps_up_to_the_ends_of_the_range(low: float, high: float) -> None:
    first, last, step = on_round_steps(low, high)
    assert abs(first - low) <= 0.5001 * step  # half a step, and rounding
    assert abs(last - high) <= 0.5001 * step
    assert np.log10(step) == pytest.approx(round(np.log10(step)))
    assert 1000 <= round((last - first) / step) + 1 <= 10001
    scope = Range("q", "rad", low, high)
    assert (scope.take(first, 0.5 * step), scope.take(last, 0.5 * step)) == (
        low,
        high,
    )  # the very ends
    assert scope.take(first + 3.0 * step, 0.5 * step) == first + 3.0 * step


def test_what_is_beyond_the_range_is_refused_with_its_end_and_a_word_on_degrees() -> None:
    lift = Range("lift", "m", 0.0, 0.15, (0.0, 0.15))
    with pytest.raises(
        InputError, match=r"lift = 0\.5 m is beyond its limit 0\.15 m; it goes from 0 to 0\.15 m$"
    ):
        lift.take(0.5, 0.0)
    with pytest.raises(InputError, match=r"lift = -0\.01 m is beyond its limit 0 m"):
        lift.take(-0.01, 0.0)
    crank = Range(
        "crank", "rad", np.pi / 6, 5 * np.pi / 6, (np.pi / 6, 3.0)
    )  # the loop ends before the upper limit
    with pytest.raises(
        InputError,
        match=r"beyond the end of its slider.*\(30 to 150 deg\).*90 deg are 1\.5708 rad$",
    ):
        crank.take(90.0, 0.0)
    with pytest.raises(InputError, match=r"beyond its limit 0\.523599 rad.*\(30 to 150 deg\)$"):
        crank.take(-90.0, 0.0)
    with pytest.raises(InputError, match="nan"):
        crank.take(np.nan, 0.0)


@pytest.mark.parametrize("step", [1e-4, 1.0])
@pytest.mark.usefixtures("needs_viser")
def test_a_slider_follows_a_move_of_a_step(step: float) -> None:
    from hybrid_dynamics_core.view.slider import Slider

    def added(*values: object) -> SimpleNamespace:
        return SimpleNamespace(value=values[-1], precision=0)

    gui = SimpleNamespace(add_slider=added)
    slider = Slider(gui, Range("q", "rad", -9.0, 9.0), 0.0, step)  # type: ignore[arg-type]
    slider.follow(step)
    assert slider.handle.value == step


def test_idle_joints_have_sliders_of_their_own(opened: Opened) -> None:
    viewer = opened(Robot(parse_description(CART)))
    assert [slider.scope.name for slider in viewer.panel.sliders] == ["x", "th"]


def test_a_number_beyond_a_slider_moves_nothing_and_the_slider_goes_back(
    forging: Robot, opened: Opened
) -> None:
    viewer = opened(forging)
    before, payload = viewer.session.state, viewer.panel._payload

    def typed(slider: Slider, value: float, act: Callable[[float], None]) -> None:
        slider.handle.value = value  # as viser has it when it calls back
        viewer.ask("typed", lambda: act(slider.take(value)))
        assert viewer.step(0.0)

    cylinder = viewer.panel.sliders[1]
    typed(cylinder, 3.0, lambda value: viewer.panel._move(1, value))
    assert viewer.session.state is before
    assert (
        "q12 = 3 m is beyond the end of its slider, 0.7 m; it goes from -0.1 to 0.7 m"
        in viewer.panel._problem.content
    )
    assert cylinder.handle.value == pytest.approx(forging.reference[1])
    typed(payload, 1e4, viewer.session.lift)
    assert (viewer.session.payload, payload.handle.value) == (0.0, 0.0)
    assert "payload = 10000 kg is beyond" in viewer.panel._problem.content
    typed(payload, 20.0, viewer.session.lift)
    assert (viewer.session.payload, viewer.session.problem) == (20.0, "")
    viewer.panel._reset()
    viewer.show()
    assert (viewer.session.payload, payload.handle.value) == (0.0, 0.0)


def test_a_slider_that_was_not_followed_goes_back_when_it_is_let_go() -> None:
    """Where the loops do not close, though the number is within the range."""
    from hybrid_dynamics_core.view import open_viewer

    robot = load("gough")
    with open_viewer(robot, port=0) as viewer:
        slider, target = viewer.panel.sliders[2], viewer.panel.target
        viewer.session.problem = "the loops do not close there"
        target[2] = slider.handle.value = slider.handle.max
        viewer._settle()
        assert slider.handle.value == slider.handle.max  # its wish is under way
        slider.take(slider.handle.max)
        viewer.show()
        assert slider.handle.value == slider.handle.max  # while a person may hold it
        viewer._settle()
        assert slider.handle.value == pytest.approx(robot.reference[2], abs=slider.step)
        assert np.array_equal(viewer.panel.target, viewer.session.state.u)
        assert viewer.session.problem


def test_full_bars_are_round_and_only_grow(forging: Robot) -> None:
    session = ViewSession(forging)
    force, torque = forging.joint_types["q12"], forging.joint_types["q1"]

    def full(**efforts: float) -> list[float]:
        return session.scale.full(tuple(efforts), np.array(list(efforts.values()))).tolist()

    assert (force, torque) == ("prismatic", "revolute")
    assert full(
        q12=-341.0,
        q22=20.0,
        q1=3.0,
    ) == [500.0, 500.0, 5.0]
    assert full(q12=1.0, q1=5.1) == [500.0, 10.0]
    assert full(q12=501.0) == [1000.0]
    empty = ViewSession(forging).scale
    assert np.isinf(empty.full(("q1",), np.zeros(1))).all()
    assert DriveEfforts(("q1",), np.zeros(1), np.array([np.inf])).shares == [0.0]
    session = ViewSession(forging)
    light = session.efforts()
    session.lift(20.0)
    heavy = session.efforts()
    assert (heavy.full >= light.full).all()
    assert heavy.shares == (heavy.values / heavy.full).tolist()
    assert "above the largest so far" in efforts_html(forging, light)


def test_full_bars_of_cylinders_are_what_they_give_at_their_supply_pressure(forging: Robot) -> None:
    cylinder = HydraulicCylinder("q12", 0.1, 0.06, return_pressure=1e5, supply_pressure=2e7)
    robot = changed(forging, actuators={"q12": cylinder})
    scale = EffortScale(robot)
    push = 2e7 * cylinder.cap_area - 1e5 * cylinder.rod_area
    pull = 2e7 * cylinder.rod_area - 1e5 * cylinder.cap_area
    assert scale.full(("q12",), np.array([10.0])) == pytest.approx([push])
    assert scale.full(("q12",), np.array([-10.0])) == pytest.approx([pull])
    html = efforts_html(robot, DriveEfforts(("q12",), np.array([0.5 * push]), np.array([push])))
    assert "what the cylinder gives at its supply pressure" in html
    assert "width:25.0%" in html  # half of the right half


def test_sliders_begin_on_their_steps_whatever_the_reference(
    forging: Robot, opened: Opened
) -> None:
    """Their number boxes have no room for more digits."""
    robot = changed(
        forging, reference={**forging.description.reference, "q1": 10.0 * np.pi / 180.0}
    )
    assert on_step(0.1745329, 0.001) == 0.175
    for slider, value in zip(opened(robot).panel.sliders, robot.reference, strict=True):
        shown, step = slider.handle.value, slider.step
        assert shown == on_step(shown, step) == pytest.approx(value, abs=0.5 * step)


def test_playback_shows_the_motion_with_the_efforts_that_it_takes(
    forging: Robot, opened: Opened
) -> None:
    curve = swing(forging)
    viewer = opened(forging, motion_of(forging, curve, "swing"))
    playback, session = viewer.panel.playback, viewer.session
    assert playback is not None
    playback.tick(0.1)
    assert playback.time == 0.0  # paused
    playback.playing, playback.speed = True, 2.0
    for elapsed, time in ((0.1, 0.2), (0.1, 0.4)):
        playback.tick(elapsed)
        viewer.show()
        wanted = curve(time)
        assert session.state.u == pytest.approx(wanted.u, abs=EXACT)
        state = forging.close(wanted.u, wanted.du)
        needed = forging.inverse_dynamics(state, wanted.ddu)
        assert session.efforts().values == pytest.approx(
            needed, rel=1e-9, abs=1e-6
        )  # rates scale the last digits
    assert playback.playing
    playback.tick(0.2)
    assert not playback.playing  # its end
    assert session.state.u == pytest.approx(curve.positions[-1], abs=EXACT)


def test_a_motion_that_leaves_its_range_is_refused_with_the_time(forging: Robot) -> None:
    end = np.array(forging.reference)
    end[1] = 0.9
    with pytest.raises(InputError, match=r"dig cannot be followed to its end: at 0\.\d+ s"):
        motion_of(forging, JointTrajectory.between(forging.reference, end, 1.0), "dig")


def test_the_picture_glides_to_where_a_slider_was_moved(forging: Robot, opened: Opened) -> None:
    viewer = opened(forging)
    start, glide = viewer.session.state, viewer.interpolation
    viewer.ask("move 1", lambda: viewer.panel._move(1, 0.2))
    assert viewer.step(0.0)
    shown = []
    while glide.moving:
        shown.append(float(glide.state.u[1]))
        assert (
            float(np.asarray(glide.state.residual)) < 1e-12
        )  # closed at every moment, in closed form
        viewer._frame(SPAN / 4)
    assert shown == pytest.approx([0.1, 0.125, 0.15, 0.175])
    assert glide.state is viewer.session.state
    assert np.array_equal(start.u[[0, 2, 3]], glide.state.u[[0, 2, 3]])
    viewer.session.move(np.add(start.u, [2.0, 0.0, 0.0, 0.0]))
    viewer.show(smoothly=True)
    assert not glide.moving  # far away: at once


def test_what_a_person_does_in_the_page_moves_the_robot(forging: Robot, opened: Opened) -> None:
    """The wishes of the panel, as viser's threads put them."""
    viewer = opened(forging)
    viewer.ask("move 1", lambda: viewer.panel._move(1, 0.2))
    viewer.ask("move 1", lambda: viewer.panel._move(1, 0.25))  # the newer wish counts
    assert viewer.step(0.0)
    assert viewer.session.state.u.tolist() == [0.0, 0.25, 0.15, 0.0]
    assert viewer.panel.sliders[1].handle.value == 0.25
    viewer.panel.list_modes()
    present = viewer.session.present(viewer.panel.modes)
    wanted = 0 if present else 1
    viewer.ask("mode", lambda: viewer.panel._take(viewer.panel.labels[wanted]))
    before = {name: np.array(link.wxyz) for name, link in viewer.scene_view.links.items()}
    assert viewer.step(0.0)
    assert viewer.session.present(viewer.panel.modes) == wanted
    assert (
        max(
            float(np.abs(link.wxyz - before[name]).max())
            for name, link in viewer.scene_view.links.items()
        )
        > 0.1
    )
    assert not viewer.step(0.0)


def test_what_the_robot_refuses_is_said_in_the_panel_and_the_view_goes_on(
    forging: Robot, opened: Opened, monkeypatch: pytest.MonkeyPatch
) -> None:
    viewer = opened(forging)
    before = viewer.session.state

    def no_modes() -> None:
        raise InputError("no modes here")

    serving = threading.Thread(target=viewer.run, daemon=True)
    serving.start()
    viewer.ask("move 0", lambda: viewer.panel._move(0, np.nan))
    done = threading.Event()
    viewer.ask("look", done.set)  # behind it, or in a later round
    assert done.wait(PATIENCE)
    viewer.ask("end", lambda: setattr(viewer, "_ended", True))
    serving.join(PATIENCE)
    assert not serving.is_alive()
    assert viewer.session.state is before
    assert "q1 is nan" in viewer.session.problem
    assert viewer.panel._problem.visible
    assert "q1 is nan" in viewer.panel._problem.content
    monkeypatch.setattr(viewer.session, "modes", no_modes)
    viewer._settle()
    assert "no modes here" in viewer.panel._problem.content
    assert not viewer.panel.stale  # not looked for again before something moves


@pytest.mark.usefixtures("needs_viser")
def test_a_viewer_that_cannot_be_made_leaves_its_port(
    forging: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    from hybrid_dynamics_core.view import open_viewer, viewer

    def broken(*_: object) -> None:
        raise ZeroDivisionError("a bug")

    port = viewer.free_port("localhost", 0)
    monkeypatch.setattr(viewer, "SceneView", broken)
    with pytest.raises(ZeroDivisionError):
        open_viewer(forging, port=port)
    assert viewer.free_port("localhost", port) == port
