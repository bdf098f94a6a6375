"""The page of the real command in a real browser: what it draws, and what a slider does to it."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.scene.style import BLUE, GREEN, ORANGE
from tools.browser import NoBrowserError, opened_page

ROOT = Path(__file__).resolve().parents[2]
pytestmark = pytest.mark.usefixtures("needs_viser")
WIDTH, HEIGHT = 820, 400
SCENE = {"x": 0, "y": 0, "width": 420, "height": HEIGHT}  # [px] the rest is the panel
PATIENCE = 60_000  # [ms] a machine may be loaded; nothing waits for this where all is well


@pytest.fixture
def served(tmp_path: Path) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """`hybrid-dynamics view` of the forging robot in a process of its own, and its address."""
    process = subprocess.Popen(
        [
            sys.executable,
            "-m",
            "hybrid_dynamics_cli",
            "view",
            "forging_chu2020",
            "--port",
            "0",
            "--no-browser",
        ],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    line = process.stdout.readline()
    address = re.search(r"http://\S+", line)
    assert address, line
    yield process, address.group()
    if process.poll() is None:
        process.kill()
    process.wait()
    process.stdout.close()


def picture(page) -> np.ndarray:
    """The scene (h, w, 3) as the page shows it, 0 to 1."""
    from matplotlib.image import imread

    return imread(BytesIO(page.screenshot(clip=SCENE, timeout=PATIENCE)))[..., :3]


def coloured(image: np.ndarray, colour: str) -> int:
    """How many pixels have the hue of a colour, whatever the light makes of it."""
    wanted = np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)], dtype=float)
    wanted = (wanted - wanted.mean()) / np.linalg.norm(wanted - wanted.mean())
    hue = image - image.mean(axis=2, keepdims=True)
    strength = np.linalg.norm(hue, axis=2)
    return int((((hue @ wanted) > 0.95 * strength) & (strength > 0.1)).sum())


def drawn(page) -> np.ndarray:
    """The picture once cylinders and parallelogram are in it, and nothing fades or moves."""
    before = picture(page)
    for _ in range(40):
        page.wait_for_timeout(250)
        image = picture(page)
        still = np.abs(image - before).mean() < 1e-3
        if still and all(coloured(image, colour) > 100 for colour in (BLUE, GREEN, ORANGE)):
            return image
        before = image
    raise AssertionError("the robot was not drawn")


@pytest.mark.sweep(sample="test_what_a_person_does_in_the_page_moves_the_robot")
def test_a_slider_in_the_page_moves_the_robot(forging: Robot, served, tmp_path: Path) -> None:
    process, url = served
    try:
        with opened_page(url, WIDTH, HEIGHT) as page:
            look_and_move(page, forging, tmp_path / "view.png")
    except NoBrowserError as problem:
        pytest.skip(str(problem))
    process.send_signal(signal.SIGINT)
    assert process.wait(30.0) == 0
    assert process.stdout.read().split() == ["ended"]


def look_and_move(page, forging: Robot, place: Path) -> None:
    def tip(u) -> str:
        return f"{forging.forward_kinematics(forging.close(u)).position[2]:.4f} m"

    u = np.array(forging.reference)
    page.get_by_text(tip(u)).wait_for(timeout=PATIENCE)
    before = drawn(page)
    slider = page.get_by_role("slider").nth(1)
    box = slider.bounding_box()
    x, y = box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"]
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 60.0, y, steps=4)
    page.mouse.up()
    u[1] = float(slider.get_attribute("aria-valuenow"))
    assert u[1] > 0.15  # it was at 0.1
    page.get_by_text(tip(u)).wait_for(timeout=PATIENCE)
    after = drawn(page)
    changed = np.abs(after - before).max(axis=2) > 0.1
    assert changed.mean() > 0.01  # of the pixels
    assert page.title() == forging.name
    type_numbers(page, tip, u)
    slider.focus()
    page.keyboard.press("End")  # where the loop has its toggle point
    page.get_by_text("The last pose stays.").wait_for(timeout=PATIENCE)
    assert page.get_by_text("theta_1", exact=False).count() > 1
    page.get_by_text(tip(u)).wait_for(
        timeout=PATIENCE
    )  # the panel may be between two of its states
    page.screenshot(path=place, timeout=PATIENCE)
    assert place.stat().st_size > 10_000  # bytes: a picture, not an empty page


def type_numbers(page, tip, u: np.ndarray) -> None:
    """A number in the box is no request before Enter; beyond the range the box goes back."""
    box = page.locator("input.mantine-NumberInput-input").nth(1)
    for leave, within in (("Enter", 0.2345), ("Tab", 0.1234)):
        before = box.input_value()
        box.click()
        page.keyboard.press("Control+a")
        page.keyboard.type(
            "0.9", delay=150
        )  # [ms] three times what the page waits between two updates
        assert page.get_by_text(tip(u)).count() == 1  # not at 0
        page.keyboard.press(leave)
        page.get_by_text("q12 = 0.9 m is beyond").wait_for(timeout=PATIENCE)
        back = "([box, text]) => box.value === text"
        page.wait_for_function(back, arg=[box.element_handle(), before], timeout=PATIENCE)
        assert page.get_by_text(tip(u)).count() == 1
        box.click()
        page.keyboard.press("Control+a")
        page.keyboard.type(f"{within}")
        page.keyboard.press("Tab")
        u[1] = within
        page.get_by_text(tip(u)).wait_for(timeout=PATIENCE)
        page.get_by_text("The last pose stays.").wait_for(state="detached", timeout=PATIENCE)
