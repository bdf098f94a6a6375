"""Typed into the box of a slider: taken as it stands, or refused with what to type instead."""

from __future__ import annotations

import asyncio
import functools
import json
import time
from collections.abc import Callable, Iterator
from types import SimpleNamespace

import numpy as np
import pytest

from hybrid_dynamics_core import InputError, Robot, load
from hybrid_dynamics_core.control import JointTrajectory
from hybrid_dynamics_core.view.motion import motion_of
from hybrid_dynamics_core.view.ranges import Range, decimals
from tools.browser import NoBrowserError, opened_page

from .conftest import Opened, wait_for_camera

pytestmark = pytest.mark.usefixtures("needs_viser")
PATIENCE = 60_000  # [ms] a machine may be loaded; nothing waits for this where all is well
SLEW, LOAD = 1, 5  # of the number boxes of an excavator with a motion
ANGLE, LENGTH, MASS = (
    Range(name, unit, -100.0, 100.0) for name, unit in (("q", "rad"), ("x", "m"), ("load", "kg"))
)


@pytest.mark.parametrize(
    ("text", "scope", "value"),
    [
        ("0.3", LENGTH, 0.3),
        (" -.5 ", LENGTH, -0.5),
        ("+2.", MASS, 2.0),
        ("007", MASS, 7.0),
        ("5e-2", MASS, 0.05),
        ("1E+1", ANGLE, 10.0),
        ("30*deg", ANGLE, np.pi / 6.0),
        ("-30 * deg", ANGLE, -np.pi / 6.0),
        ("pi/4", ANGLE, np.pi / 4.0),
        ("65*mm", LENGTH, 0.065),
        ("-7 * cm", LENGTH, -0.07),
        ("500*g", MASS, 0.5),
    ],
)
def test_numbers_are_read_as_the_command_line_reads_them(
    text: str, scope: Range, value: float
) -> None:
    from hybrid_dynamics_core.view.number_input import parse_number

    assert parse_number(text, scope) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "scope", "advice"),
    [
        ("2,5", MASS, "decimals have a point, write 2.5"),
        ("-0,3", ANGLE, "decimals have a point, write -0.3"),
        ("1,5*deg", ANGLE, "decimals have a point, write 1.5*deg"),
        ("30 deg", ANGLE, "write 30*deg"),
        ("30deg", ANGLE, "write 30*deg"),
        ("30°", ANGLE, "write 30*deg"),
        ("0.5 rad", ANGLE, "write 0.5"),
        ("20 kg", MASS, "write 20"),
        ("−0.2", LENGTH, "write -0.2"),
        ("20 cm", LENGTH, "write the number alone, in m, as"),
        ("2*deg", LENGTH, "write the number alone, in m, as"),
        ("1,000.5", MASS, "write the number alone, in kg, as"),
        ("1 2", LENGTH, "write the number alone"),
        ("--2", MASS, "write the number alone"),
        ("nan", MASS, "write the number alone"),
        ("1e999", MASS, "write the number alone"),
        ("5*kg", LENGTH, "write the number alone, in m, as"),
        ("3*mm", ANGLE, "in rad, as 0.25 or 5e-2, or degrees, as 30*deg"),
        ("1/0", ANGLE, "in rad, as 0.25 or 5e-2, or degrees, as 30*deg"),
        ("1e", ANGLE, "or degrees"),
    ],
)
def test_all_else_is_refused_with_what_to_type_instead(
    text: str, scope: Range, advice: str
) -> None:
    from hybrid_dynamics_core.view.number_input import parse_number

    with pytest.raises(InputError) as refused:
        parse_number(text, scope)
    assert f"{scope.name}: '{text}' was not taken: " in str(refused.value)
    assert advice in str(refused.value)


def test_the_page_hands_over_what_was_typed_and_where_somebody_went() -> None:
    """Each to the slider that it names; what the program writes there is nobody's."""
    from hybrid_dynamics_core.view.number_input import NumberInput

    line, taken = SimpleNamespace(value=""), []

    def slider(scope: Range) -> SimpleNamespace:
        def take(read: Callable[[Range], float]) -> None:
            taken.append((scope.name, read(scope)))

        return SimpleNamespace(label=scope.name, request_typed=take)

    def hand_over(client: object, *words: object) -> None:
        line.value = json.dumps(words)
        asyncio.run(line.listener(SimpleNamespace(client=client, target=line)))

    line.on_update = functools.partial(setattr, line, "listener")
    gui = SimpleNamespace(add_text=lambda *_: line)
    NumberInput(gui).listen([slider(ANGLE), slider(LENGTH)], lambda: taken.append("began"))
    hand_over("browser", "x", None, 3.5)
    hand_over("browser", "x", "65*mm", 4.0)
    hand_over(None, "x", "1", 5.0)
    hand_over("browser", "q", "-2", 6.0)
    assert taken == ["began", ("x", 0.065), ("q", -2.0)]


def test_a_long_text_is_repeated_in_part() -> None:
    from hybrid_dynamics_core.view.number_input import parse_number

    with pytest.raises(InputError, match=r"'a{40}\.\.\.'"):
        parse_number("a" * 1000, LENGTH)


@pytest.mark.parametrize(
    ("value", "count"), [(1e-3, 3), (0.1, 1), (1.0, 0), (100.0, 0), (0.05, 2), (-12.345, 3)]
)
def test_decimals_of_a_number(value: float, count: int) -> None:
    assert decimals(value) == count


def test_the_very_number_that_was_typed_counts_and_is_shown(forging: Robot, opened: Opened) -> None:
    """Whatever the steps of the slider; of the ends that it shows, rounded, the range's own."""
    viewer = opened(forging)
    slider, robot = viewer.panel.sliders[0], viewer.session

    def typed(value: float) -> None:
        slider.request_typed(lambda _: value)
        assert viewer.step(0.0)

    for value, shown in (
        (0.12345678, 0.12346),
        (0.1231, 0.1231),
        (np.pi / 6.0, 0.5236),
        (np.pi - 1e-5, 3.1416),
    ):
        typed(value)
        assert robot.state.u[0] == value
        viewer.show()
        assert (slider.handle.value, slider.handle.precision) == (shown, decimals(shown))
    typed(slider.handle.max)  # 3.142, which is beyond a half turn
    assert robot.state.u[0] == slider.scope.high == pytest.approx(np.pi)
    typed(3.1417)
    assert robot.state.u[0] == slider.scope.high
    assert "q1 = 3.1417 rad is beyond" in robot.problem
    viewer.panel._reset()
    viewer.show()
    assert (slider.handle.value, slider.handle.precision) == (0.0, 3)


def test_a_notice_is_about_the_latest_entry(forging: Robot, opened: Opened) -> None:
    viewer = opened(forging)
    session, sliders = viewer.session, viewer.panel.sliders
    before = np.array(session.state.u)

    def typed(k: int, value: float) -> None:
        sliders[k].request_typed(lambda _: value)

    typed(0, -11.0)
    assert viewer.step(0.0)
    assert "q1 = -11 rad" in session.problem
    typed(0, 0.0)  # where it is
    assert viewer.step(0.0)
    assert session.problem == ""
    assert not viewer.panel._problem.visible
    typed(0, -11.0)
    typed(1, 9.0)
    typed(0, 12.0)  # before the two were heard: the latest of all counts
    assert viewer.step(0.0)
    assert "q1 = 12 rad" in session.problem
    assert np.array_equal(session.state.u, before)


def test_who_goes_to_a_box_pauses_the_motion_which_would_write_into_it(
    forging: Robot, opened: Opened
) -> None:
    motion = motion_of(
        forging, JointTrajectory.between(forging.reference, forging.reference + 0.01, 1.0), "there"
    )
    viewer = opened(forging, motion)
    playback = viewer.panel.playback
    assert playback is not None
    viewer.panel._pause_for_typing()
    assert not viewer.step(0.0)  # nothing plays
    playback.playing, playback.time = True, 0.5
    viewer.panel._pause_for_typing()
    assert viewer.step(0.0)
    assert (playback.playing, playback.time, playback._play.label) == (False, 0.5, "Play")


@pytest.fixture(scope="module")
def page_of_an_excavator() -> Iterator[tuple]:
    """Its viewer, with a motion, and its page, low enough that the panel has to be scrolled."""
    from tools.view_screenshot import running

    pytest.importorskip("viser", reason="viser, the extra `view`, is not installed")
    try:
        robot = load("excavator")
        motion = motion_of(
            robot, JointTrajectory.between(robot.reference, robot.reference + 0.1, 1.0), "there"
        )
        with running(robot, motion) as viewer, opened_page(viewer.url, 1280, 420) as page:
            boxes(page).nth(LOAD).wait_for(timeout=PATIENCE)
            yield viewer, page
    except NoBrowserError as problem:
        pytest.skip(str(problem))


def boxes(page):
    """The number boxes beside the sliders: time, four joints, payload."""
    return page.locator("div:has(> .mantine-Slider-root) input.mantine-NumberInput-input")


def enter(page, k: int, text: str, leave: str = "Enter") -> None:
    box = boxes(page).nth(k)
    box.click()
    page.keyboard.press("Control+a")
    page.keyboard.type(text)
    page.keyboard.press(leave)


def shows(page, k: int, text: str) -> None:
    """Wait until a box shows a text."""
    arg = [boxes(page).nth(k).element_handle(), text]
    page.wait_for_function("([box, text]) => box.value === text", arg=arg, timeout=PATIENCE)


def becomes(page, read: Callable[[], float], value: float) -> None:
    """Wait until a quantity of the session has a value: a box shows it before it is used."""
    end = time.monotonic() + PATIENCE / 1000.0
    while read() != value:
        assert time.monotonic() < end, f"it stays {read()}, not {value}"
        page.wait_for_timeout(20)


@pytest.mark.sweep(sample="test_the_very_number_that_was_typed_counts_and_is_shown")
def test_boxes_of_the_page_take_numbers_as_they_stand_and_refuse_others(
    page_of_an_excavator,
) -> None:
    viewer, page = page_of_an_excavator
    session, notice = viewer.session, page.get_by_role("alert")
    for text, shown, value in (("5e-2", "0.05", 0.05), ("1e-1", "0.1", 0.1), ("300", "300", 300.0)):
        enter(page, LOAD, text)
        shows(page, LOAD, shown)
        becomes(page, lambda: session.payload, value)
    for text, advice in (("2,5", "write 2.5"), ("20 cm", "in kg"), ("2*deg", "in kg")):
        enter(page, LOAD, text)
        assert boxes(page).nth(LOAD).input_value() == "300"  # at once
        notice.get_by_text(f"'{text}' was not taken").wait_for(timeout=PATIENCE)
        assert advice in notice.inner_text()
        assert notice.bounding_box()["y"] >= 0.0  # though the panel is scrolled to the payload
        assert session.payload == 300.0
    enter(page, SLEW, "30*deg", "Tab")
    shows(page, SLEW, "0.5236")
    becomes(page, lambda: session.state.u[0], np.pi / 6.0)
    notice.wait_for(state="detached", timeout=PATIENCE)
    enter(page, SLEW, "-11")
    notice.get_by_text("slew = -11 rad is beyond its limit").wait_for(timeout=PATIENCE)
    enter(page, SLEW, "")
    assert boxes(page).nth(SLEW).input_value() == "0.5236"
    enter(page, LOAD, "300")  # where it is
    notice.wait_for(state="detached", timeout=PATIENCE)
    assert session.state.u[0] == np.pi / 6.0


@pytest.mark.sweep(sample="test_who_goes_to_a_box_pauses_the_motion_which_would_write_into_it")
def test_a_box_of_the_page_that_somebody_goes_to_pauses_the_motion(page_of_an_excavator) -> None:
    viewer, page = page_of_an_excavator
    viewer.panel.playback.speed = 0.005  # a busy machine has time to see it play
    page.get_by_text("Play", exact=True).click()
    page.get_by_text("Pause", exact=True).wait_for(timeout=PATIENCE)
    boxes(page).nth(SLEW).focus()  # as the page does itself when a number comes late
    page.wait_for_timeout(300)
    assert viewer.panel.playback.playing
    boxes(page).nth(SLEW).click()
    page.get_by_text("Play", exact=True).wait_for(timeout=PATIENCE)
    assert 0.0 < viewer.panel.playback.time < 1.0  # [s] it has not come to its end
    enter(page, SLEW, "1.25")
    shows(page, SLEW, "1.25")
    becomes(page, lambda: viewer.session.state.u[0], 1.25)


@pytest.mark.sweep(sample="test_an_arm_that_slews_out_of_the_picture_is_followed")
def test_the_page_follows_the_arm_until_somebody_turns_it_and_keys_of_sliders_do_not(
    page_of_an_excavator,
) -> None:
    viewer, page = page_of_an_excavator
    (client,) = viewer.server.get_clients().values()

    def slew(text: str) -> None:
        enter(page, SLEW, text)
        shows(page, SLEW, text)

    slew("0")
    put = viewer.camera_fit._positions[client.client_id][-1]
    before = wait_for_camera(page, client, lambda eye: np.allclose(eye, put, rtol=1e-4))
    slider = page.get_by_role("slider").nth(SLEW)
    slider.focus()
    page.keyboard.press("ArrowRight", delay=200)
    shows(page, SLEW, "0.001")
    page.wait_for_timeout(300)  # [ms] six times what a browser waits before it tells of its camera
    assert client.camera.position == pytest.approx(before, rel=1e-4)  # viser would turn it as well
    slew("2")
    moved = wait_for_camera(page, client, lambda eye: np.linalg.norm(eye - before) > 1.0)  # [m]
    page.mouse.move(300.0, 200.0)
    page.mouse.down()
    page.mouse.move(360.0, 210.0, steps=4)
    page.mouse.up()
    wait_for_camera(page, client, lambda eye: np.linalg.norm(eye - moved) > 0.5)  # [m]
    page.wait_for_timeout(1000)  # it runs out smoothly
    turned = np.array(client.camera.position)
    slew("-2.5")
    page.wait_for_timeout(300)
    assert client.camera.position == pytest.approx(turned, rel=1e-4)


@pytest.mark.sweep(sample="test_every_assembly_mode_can_be_chosen_and_has_another_name")
def test_a_long_name_of_a_mode_ends_in_dots_before_the_arrows_and_has_a_title(
    page_of_an_excavator, monkeypatch: pytest.MonkeyPatch
) -> None:
    viewer, page = page_of_an_excavator
    page.wait_for_timeout(1000)  # the modes of the pose before are listed by then
    monkeypatch.setattr(viewer.panel, "list_modes", lambda: None)  # they would come back
    name = "1: lifting counterclockwise, carrying counterclockwise, and tilting clockwise"
    viewer.panel._mode.options = (name,)
    field = page.locator("input.mantine-Select-input").last
    look = """([field, name]) => {
      if (field.value !== name) return null;
      const style = getComputedStyle(field);
      const arrows = field.parentElement.querySelector('[data-position=right]');
      const width = arrows.getBoundingClientRect().width;
      return [style.textOverflow, parseFloat(style.paddingRight), width];
    }"""
    arg = [field.element_handle(), name]
    overflow, room, arrows = page.wait_for_function(look, arg=arg, timeout=PATIENCE).json_value()
    assert overflow == "ellipsis"
    assert room >= arrows > 0.0  # [px] of the padding, and of what stands there
    field.hover()
    assert field.get_attribute("title") == name
