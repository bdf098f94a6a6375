"""Visuals in the browser's scene: they move with their links, and a switch shows the skeleton."""

from __future__ import annotations

import asyncio
import functools
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.formats.reader import read_description
from hybrid_dynamics_core.scene.visuals.surfaces import surfaces_of
from hybrid_dynamics_core.view import open_viewer
from tests.mesh_files import write_mesh

from .conftest import Opened

ARM = """\
format: 1
name: arm
links:
  base: {visuals: [{box: {size: [0.2, 0.2, 3]}, colour: [0, 0, 1, 0.5]}]}
  upper: {mass: 1, visuals: [{mesh: {file: part.stl, scale: 0.1}, colour: "#ff0000"}]}
  lower: {mass: 1}
joints:
  q1: {type: revolute, parent: base, child: upper, axis: y}
  q2: {type: revolute, parent: upper, child: lower, axis: y, origin: {xyz: [1, 0, 0]}}
active: [q1, q2]
end_effector: {link: lower, xyz: [1, 0, 0]}
"""


def arm_in(folder: Path) -> Robot:
    pytest.importorskip("trimesh")
    write_mesh(folder / "part.stl")
    (folder / "arm.yaml").write_text(ARM, encoding="utf-8")
    return Robot(read_description(folder / "arm.yaml"))


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    """Its mesh is read once."""
    return arm_in(tmp_path_factory.mktemp("arm"))


def owners(viewer) -> set[tuple[str, str]]:
    """Kind and names of the bodies of the skeleton that are shown."""
    scene = viewer.scene_view
    bodies = (*scene.bodies, *scene.spans)
    return {(body.kind, body.names[0]) for body, handle in bodies if handle.visible}


def test_visuals_stand_for_the_bodies_of_their_links(arm: Robot, opened: Opened) -> None:
    viewer = opened(arm)
    scene = viewer.scene_view
    assert [handle.visible for handle in scene.visuals.handles] == [True, True]
    assert owners(viewer) == {("link", "lower"), ("joint", "q2")}
    everything = {("link", "base"), ("link", "upper"), ("joint", "q1")} | owners(viewer)
    scene.show_skeleton(True)
    assert [handle.visible for handle in scene.visuals.handles] == [False, False]
    assert owners(viewer) == everything
    scene.show_skeleton(False)
    assert owners(viewer) == {("link", "lower"), ("joint", "q2")}


def test_visuals_are_sent_in_the_axes_of_their_links_once(arm: Robot, opened: Opened) -> None:
    viewer = opened(arm)
    base, upper = viewer.scene_view.visuals.handles
    assert upper.name.startswith("/links/upper/")
    surfaces = {surface.link: surface for surface in surfaces_of(arm.description).surfaces}
    assert np.allclose(upper.vertices, surfaces["upper"].vertices, atol=1e-6)
    assert tuple(upper.color) == (255, 0, 0)
    assert (upper.opacity, base.opacity) == (None, 0.5)


def test_camera_and_floor_take_in_the_visuals(arm: Robot, opened: Opened) -> None:
    """The box of the base reaches from -1.5 m to 1.5 m."""
    viewer = opened(arm)
    points = viewer.scene_view.points(viewer.session.state)
    assert points[:, 2].min() == pytest.approx(-1.5)
    assert viewer.scene_view.floor.level <= -1.5
    assert viewer.scene_view.camera.sees(points, 1.0)


def test_the_switch_is_there_where_there_are_visuals(arm: Robot, forging: Robot) -> None:
    with open_viewer(arm, port=0, skeleton=True) as viewer:
        assert viewer.switch.value is True
        assert not any(handle.visible for handle in viewer.scene_view.visuals.handles)
    with open_viewer(forging, port=0) as viewer:
        assert viewer.switch is None


def test_the_switch_asks_for_what_a_person_wants() -> None:
    """What the program sets is no request."""
    from hybrid_dynamics_core.view.visuals import add_switch

    box, asked = SimpleNamespace(value=False), []
    box.on_update = functools.partial(setattr, box, "listener")
    gui = SimpleNamespace(add_checkbox=lambda *_: box)
    visuals = SimpleNamespace(surfaces=SimpleNamespace(problems=()), handles=["one"])
    assert add_switch(gui, visuals, lambda key, act: asked.append((key, act)), asked.append) is box
    box.value = True
    asyncio.run(box.listener(SimpleNamespace(client=None, target=box)))
    assert asked == []
    asyncio.run(box.listener(SimpleNamespace(client="browser", target=box)))
    ((key, act),) = asked
    act()
    assert (key, asked[1]) == ("skeleton", True)


def test_a_mesh_that_is_not_read_is_named_and_the_view_opens(
    tmp_path: Path, opened: Opened
) -> None:
    arm = arm_in(tmp_path)
    (tmp_path / "part.stl").write_bytes(b"nothing at all")
    viewer = opened(arm)
    (problem,) = viewer.scene_view.visuals.surfaces.problems
    assert problem == "mesh part.stl is not shown: it has no triangles"
    assert ("link", "upper") in owners(viewer)
