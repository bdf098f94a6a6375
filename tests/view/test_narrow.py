"""A narrow window: scene and panel share it, nothing is cut off, all of the robot is visible."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hybrid_dynamics_core import Robot, load
from hybrid_dynamics_core.scene.skeleton import place_skeleton
from hybrid_dynamics_core.view.camera import Camera, camera_for
from tools.browser import NoBrowserError, opened_page

from .conftest import Opened, wait_for_camera

pytestmark = pytest.mark.usefixtures("needs_viser")
PATIENCE = 60_000  # [ms] a machine may be loaded; nothing waits for this where all is well
WIDTH, HEIGHT = 500, 800  # [px]
BOXES = """() => {
  const box = e => {
    const r = e.getBoundingClientRect();
    return [r.left, r.top, r.right, r.bottom];
  };
  const area = document.querySelector('.hd-sheet').closest("div.mantine-ScrollArea-root");
  const sheet = area.parentElement.parentElement;
  const tables = [...document.querySelectorAll('.hd table')];
  const rightmost = Math.max(...tables.map(t => t.getBoundingClientRect().right));
  return {scene: box(document.querySelector('canvas')), panel: box(sheet), rightmost};
}"""
SETTLED = """height => {
  const sheet = document.querySelector('.hd-sheet');
  const canvas = document.querySelector('canvas');
  return sheet && Math.abs(canvas.getBoundingClientRect().height - height) < 1.5;
}"""


@pytest.mark.sweep(sample="test_the_camera_follows_the_window_until_somebody_moves_it")
def test_scene_and_panel_share_a_narrow_window() -> None:
    from tools.view_screenshot import running

    try:
        with running(load("gough")) as viewer, opened_page(viewer.url, WIDTH, HEIGHT) as page:
            page.wait_for_function(SETTLED, arg=0.5 * HEIGHT, timeout=PATIENCE)
            page.get_by_text("lambda_F", exact=True).wait_for(timeout=PATIENCE)
            boxes = page.evaluate(BOXES)
            assert boxes["scene"] == pytest.approx([0.0, 0.0, WIDTH, 0.5 * HEIGHT], abs=1.0)
            assert boxes["panel"] == pytest.approx([0.0, 0.5 * HEIGHT, WIDTH, HEIGHT], abs=1.0)
            assert 0.0 < boxes["rightmost"] <= WIDTH  # readouts are not cut off
            (client,) = viewer.server.get_clients().values()
            wide_enough = viewer.scene_view.camera.position
            wait_for_camera(page, client, lambda eye: np.allclose(eye, wide_enough, rtol=1e-4))
            page.get_by_text("gough", exact=True).click()  # folds the panel: the scene has the rest
            page.wait_for_function(
                "height => document.querySelector('canvas').getBoundingClientRect().height >"
                " height",
                arg=0.9 * HEIGHT,
                timeout=PATIENCE,
            )
    except NoBrowserError as problem:
        pytest.skip(str(problem))


@pytest.mark.parametrize("aspect", [3.0, 1.0, 0.6, 0.25])
def test_every_point_is_in_the_picture_however_narrow(forging: Robot, aspect: float) -> None:
    """Within the pyramid of view of a canvas of this shape."""
    from hybrid_dynamics_core.view.bodies import robot_shape

    shape = robot_shape(forging, forging.close(forging.reference))
    camera = camera_for(shape.skeleton, shape.points)
    away = camera.look_at - camera.position_for(aspect)
    forward = away / np.linalg.norm(away)
    right = np.cross(forward, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    rays = shape.points - camera.position_for(aspect)
    depth, up = rays @ forward, rays @ np.cross(right, forward)
    assert np.abs(up / depth).max() < np.tan(0.5 * camera.field)
    assert np.abs(rays @ right / depth).max() < aspect * np.tan(0.5 * camera.field)
    if aspect >= 1.0:
        assert camera.position_for(aspect) == pytest.approx(camera.position, rel=1e-12)


@pytest.mark.parametrize("name", ["forging_chu2020", "excavator", "gough", "five_bar", "ankle"])
def test_what_stands_in_the_corner_is_visible_and_hides_nothing(name: str) -> None:
    """The arrow of gravity: within a square picture, and farther out than all of the robot."""
    from hybrid_dynamics_core.view.bodies import robot_shape

    robot = load(name)
    shape = robot_shape(robot, robot.close(robot.reference))
    camera = camera_for(shape.skeleton, shape.points)
    forward = (camera.look_at - camera.position) / np.linalg.norm(camera.look_at - camera.position)
    right = np.cross(forward, (0.0, 0.0, 1.0)) / np.linalg.norm(np.cross(forward, (0.0, 0.0, 1.0)))
    ends = camera.corner + np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -0.14 * shape.size]])

    def picture(points: np.ndarray) -> np.ndarray:
        rays = points - camera.position
        flat = (
            np.stack([rays @ right, rays @ np.cross(right, forward)], axis=1)
            / (rays @ forward)[:, None]
        )
        return flat / np.tan(0.5 * camera.field)

    assert np.abs(picture(ends)).max() < 0.9  # a name above the arrow has room too
    along = np.linspace(*picture(ends), 20)
    assert np.linalg.norm(along, axis=1).min() > np.linalg.norm(picture(shape.points), axis=1).max()


@dataclass
class Eye:
    """The camera of a browser."""

    position: np.ndarray
    look_at: np.ndarray
    aspect: float
    heard: list[Any] = field(default_factory=list)

    def on_update(self, act: Any) -> None:
        self.heard.append(act)


class Page:
    """A browser, as the server knows it."""

    client_id = 7

    def __init__(self, camera: Camera, aspect: float) -> None:
        self.camera = Eye(camera.position, camera.look_at, aspect)

    def atomic(self) -> Any:
        return pytest.MonkeyPatch.context()  # any context will do

    def turned(self, aspect: float) -> None:
        """The window has another shape now."""
        self.camera.aspect = aspect
        for act in self.camera.heard:
            act(self.camera)


def test_the_camera_follows_the_window_until_somebody_moves_it() -> None:
    from hybrid_dynamics_core.view.camera_fit import CameraFit

    met: dict[str, Any] = {}
    server = SimpleNamespace(
        on_client_connect=lambda act: met.update(come=act),
        on_client_disconnect=lambda act: met.update(gone=act),
    )
    camera = Camera(np.array([3.0, 4.0, 12.0]), np.zeros(3), 2.0)
    fitting, page = CameraFit(server, camera), Page(camera, 0.5)  # type: ignore[arg-type]
    met["come"](page)
    assert page.camera.position == pytest.approx([6.0, 8.0, 24.0])
    assert page.camera.look_at == pytest.approx([0.0, 0.0, 0.0])
    page.turned(2.0)
    assert page.camera.position == pytest.approx([3.0, 4.0, 12.0])
    page.camera.position = np.array([1.0, 0.0, 0.0])
    page.turned(0.5)
    assert page.camera.position == pytest.approx([1.0, 0.0, 0.0])
    met["gone"](page)
    page.turned(0.25)
    assert page.camera.position == pytest.approx([1.0, 0.0, 0.0])
    assert not fitting._positions


def test_the_camera_follows_what_leaves_its_picture_unless_a_person_moved_it() -> None:
    from hybrid_dynamics_core.view.camera_fit import CameraFit

    met: dict[str, Any] = {}
    camera = Camera(np.array([3.0, 4.0, 12.0]), np.zeros(3), 2.0)
    stays, turned = Page(camera, 1.5), Page(camera, 0.5)
    turned.client_id = 8
    server = SimpleNamespace(
        on_client_connect=lambda act: met.update(come=act),
        on_client_disconnect=lambda act: met.update(gone=act),
        get_clients=lambda: {7: stays, 8: turned},
    )
    fitting = CameraFit(server, camera)  # type: ignore[arg-type]
    for page in (stays, turned):
        met["come"](page)
    turned.camera.position = np.array([0.0, -20.0, 1.0])
    near, far = (
        np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]]),
        np.array([[12.0, 0.0, -9.0], [13.0, 0.0, -3.0]]),
    )
    fitting.follow(near)
    assert fitting.camera is camera  # all of them see it: nothing moves
    fitting.follow(far)
    eye = stays.camera
    assert sees(eye, far)
    assert np.cross(eye.position - eye.look_at, (3.0, 4.0, 12.0)) == pytest.approx(
        np.zeros(3), abs=1e-9
    )
    assert turned.camera.position == pytest.approx([0.0, -20.0, 1.0])
    assert fitting.camera.sees(far, 1.0)
    assert not camera.sees(far, 1.0)
    fitting.follow(-far)
    there = np.array(eye.position)
    fitting.follow(far)
    assert np.array_equal(eye.position, there)  # what goes to and fro does not shake the picture
    fitting.show(near, turned)  # type: ignore[arg-type]  # who asks for it is shown it
    assert sees(turned.camera, near)
    assert np.cross(
        turned.camera.position - turned.camera.look_at, (0.0, -20.0, 1.0)
    ) == pytest.approx(np.zeros(3))
    turned.turned(2.0)  # and follows its window again,
    assert sees(turned.camera, near)
    fitting.follow(far)  # and the robot
    assert sees(turned.camera, far)


def test_a_browser_that_still_tells_of_an_older_place_has_not_been_turned() -> None:
    """The camera is put elsewhere at each step of a slider, faster than its browser answers."""
    from hybrid_dynamics_core.view.camera_fit import CameraFit

    met: dict[str, Any] = {}
    camera = Camera(np.array([3.0, 4.0, 12.0]), np.zeros(3), 2.0)
    page = Page(camera, 1.5)
    server = SimpleNamespace(
        on_client_connect=lambda act: met.update(come=act),
        on_client_disconnect=lambda act: met.update(gone=act),
        get_clients=lambda: {7: page},
    )
    fitting = CameraFit(server, camera)  # type: ignore[arg-type]
    met["come"](page)
    fitting.follow(np.array([[9.0, 0.0, 0.0]]))
    page.camera.position, page.camera.look_at = camera.position, camera.look_at
    far = np.array([[40.0, 0.0, 0.0]])
    fitting.follow(far)
    assert sees(page.camera, far)


def sees(eye: Eye, points: np.ndarray) -> bool:
    """Whether a browser shows points (k, 3)."""
    return Camera(eye.position, eye.look_at, 0.0).sees(points, eye.aspect)


def test_an_arm_that_slews_out_of_the_picture_is_followed(opened: Opened) -> None:
    """Whoever moves it, by a slider or along a motion; the gravity beside it comes along."""
    viewer = opened(load("excavator"))
    start = viewer.camera_fit.camera
    viewer.ask("move 0", lambda: viewer.panel._move(0, 2.0))
    assert viewer.step(0.0)
    points = place_skeleton(viewer.session.robot, viewer.session.state).points
    assert not start.sees(points, 1.0)
    assert viewer.camera_fit.camera.sees(points, 1.0)
    assert viewer.camera_fit.camera.sees(
        viewer.scene_view.shape.points, 1.0
    )  # and where it came from
    assert viewer.scene_view._gravity is not None
    assert viewer.scene_view._gravity.position == pytest.approx(viewer.camera_fit.camera.corner)


def test_in_a_mode_below_the_floor_the_floor_goes_down_and_gravity_comes_along(
    opened: Opened,
) -> None:
    robot = load("excavator")
    viewer = opened(robot)
    stage, start = viewer.scene_view, viewer.scene_view.camera
    level = stage._tiles.position[2]
    home = stage.shape.points
    viewer.fit()
    assert (stage.camera, stage._tiles.position[2]) == (start, level)
    below = home - np.array([0.0, 0.0, 3.0 * stage.shape.size])
    viewer.camera_fit.follow(below)
    stage.surround(below, viewer.camera_fit.camera)
    assert stage._tiles.position[2] < below[:, 2].min()
    assert stage._gravity is not None
    assert stage._gravity.position == pytest.approx(stage.camera.corner)
    assert viewer.server.initial_camera.position == pytest.approx(stage.camera.position)
    viewer.fit()  # back home
    assert stage._tiles.position[2] == level
    assert stage.camera.sees(home, 1.0)
