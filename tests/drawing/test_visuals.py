"""Visuals in drawings: each pixel shows what is nearest, and the skeleton is a switch away."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure

from hybrid_dynamics_core import Robot, load
from hybrid_dynamics_core.drawing import draw, draw_on
from hybrid_dynamics_core.drawing.paint import surfaces
from hybrid_dynamics_core.drawing.paint.picture import make_scene, with_visuals
from hybrid_dynamics_core.formats.reader import read_description
from hybrid_dynamics_core.scene.projection import Projection
from hybrid_dynamics_core.scene.visuals.primitives import triangles_of
from hybrid_dynamics_core.scene.visuals.surfaces import Surface, surfaces_of
from tests.mesh_files import write_mesh
from tests.sampling import examples

FRONT = Projection(np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]))  # seen along y
ARM = """\
format: 1
name: arm
links:
  base: {visuals: [{box: {size: [0.2, 0.2, 0.1]}, colour: "#0000ff"}]}
  upper: {mass: 1, visuals: [VISUAL]}
  lower: {mass: 1}
joints:
  q1: {type: revolute, parent: base, child: upper, axis: y}
  q2: {type: revolute, parent: upper, child: lower, axis: y, origin: {xyz: [1, 0, 0]}}
active: [q1, q2]
end_effector: {link: lower, xyz: [1, 0, 0]}
reference: {q1: -0.5, q2: 1}
"""
BAR = '{box: {size: [1, 0.1, 0.1]}, origin: {xyz: [0.5, 0, 0]}, colour: "#ff0000"}'


def arm(folder: Path, visual: str = BAR) -> Robot:
    file = folder / "arm.yaml"
    file.write_text(ARM.replace("VISUAL", visual), encoding="utf-8")
    return Robot(read_description(file))


def volume(vertices: np.ndarray, faces: np.ndarray) -> float:
    """By the divergence theorem; positive where all faces are seen from outside."""
    a, b, c = (vertices[corner] for corner in faces.T)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


VOLUMES = {
    "box": ((1.0, 2.0, 3.0), 6.0),
    "cylinder": ((0.5, 2.0), np.pi * 0.5),
    "sphere": ((0.5,), np.pi / 6.0),
    "capsule": ((0.5, 2.0), np.pi * 0.5 + np.pi / 6.0),
    "ellipsoid": ((1.0, 2.0, 3.0), 8.0 * np.pi),
}


@pytest.mark.parametrize("shape", VOLUMES)
def test_primitives_are_closed_and_as_large_as_they_say(shape: str) -> None:
    size, expected = VOLUMES[shape]
    vertices, faces = triangles_of(shape, size)
    assert volume(vertices, faces) == pytest.approx(expected, rel=0.02)
    extent = np.ptp(vertices, axis=0)
    if shape in ("box", "ellipsoid"):
        assert extent == pytest.approx(np.array(size) * (1 if shape == "box" else 2), rel=0.01)
    else:
        height = size[-1] if shape == "cylinder" else 2 * size[0] + sum(size[1:])
        assert extent[2] == pytest.approx(height, rel=0.01)
        assert extent[:2] == pytest.approx([2 * size[0]] * 2, rel=0.01)


@examples(40)
@given(seed=st.integers(0, 10_000))
def test_every_sample_shows_the_nearest_triangle(seed: int) -> None:
    """Against rays through the middles of samples, away from edges of triangles."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 12))
    vertices = rng.uniform(0.0, 40.0, (3 * count, 3)) * (1.0, 1.0, 0.1)
    faces = np.arange(3 * count).reshape(count, 3)
    canvas = surfaces._Canvas(40, 40, 40.0)
    canvas.add(Surface("a", vertices, faces, (1.0, 0.0, 0.0, 1.0)), vertices, np.eye(3))
    shown = canvas.triangles.reshape(40, 40)
    for _ in range(60):
        column, row = rng.integers(0, 40, 2)
        hits = {}
        is_near_an_edge = False
        for k, corners in enumerate(vertices[faces]):
            system = np.vstack([corners[:, :2].T, np.ones(3)])
            if abs(np.linalg.det(system)) < 1.0:
                is_near_an_edge = True  # seen from its edge
                continue
            weights = np.linalg.solve(system, [column + 0.5, row + 0.5, 1.0])
            slack = 1.5 * np.linalg.norm(np.linalg.inv(system)[:, :2], axis=1).max()
            if weights.min() > slack:
                hits[k] = float(weights @ corners[:, 2])
            elif weights.min() > -slack:
                is_near_an_edge = True
        depths = sorted(hits.values())
        is_close = len(depths) > 1 and depths[-1] - depths[-2] < 1.0
        if not is_near_an_edge and not is_close:
            assert shown[row, column] == max(hits, key=hits.__getitem__, default=-1)


@pytest.mark.parametrize("seed", range(3))
def test_outlines_are_where_a_neighbour_is_of_another_paint(seed: int) -> None:
    """Above, below, to the left or to the right; the background is one too."""
    random = np.random.default_rng(seed)
    canvas = surfaces._Canvas(9, 7, 9.0)
    paints = np.array([0, 0, 1])
    canvas.paints.append(paints)
    canvas.normals.append(np.tile([0.0, 0.0, 1.0], (3, 1)))
    canvas.depths[:] = 0.0
    triangles = random.choice([-1, 0, 1, 2], p=[0.1, 0.3, 0.4, 0.2], size=canvas.shape)
    colours = np.pad(np.append(paints, -1)[triangles], 1, mode="edge")
    inner = colours[1:-1, 1:-1]
    around = (colours[:-2, 1:-1], colours[2:, 1:-1], colours[1:-1, :-2], colours[1:-1, 2:])
    expected = np.any([inner != other for other in around], axis=0)
    assert np.array_equal(canvas._edges(triangles), expected)


def test_a_link_is_painted_in_its_colour_where_it_is(tmp_path: Path) -> None:
    robot = arm(tmp_path)
    scene = with_visuals(make_scene(robot, None), robot, None)
    image = surfaces.image_of(scene.surfaces, scene.projection, 0.5)
    pose = robot.forward_kinematics(robot.close(robot.reference), "upper")
    middle = pose.position + pose.rotation @ [0.7, 0.0, 0.0]
    low, high = image.corners
    share = (scene.projection.project(middle) - low) / (high - low)
    row, column = (share[::-1] * image.pixels.shape[:2]).astype(int)
    red, green, blue, opacity = image.pixels[row, column]
    assert red > 120
    assert (green, blue, opacity) == (0, 0, 255)
    assert image.pixels[0, -1, 3] == 0


def test_bodies_give_way_to_visuals_link_by_link(tmp_path: Path) -> None:
    robot = arm(tmp_path)
    plain = make_scene(robot, None)
    scene = with_visuals(plain, robot, None)
    owners = {part.owner for part in plain.parts} - {part.owner for part in scene.parts}
    assert owners == {"link:upper"}
    assert (len(plain.ground), len(scene.ground)) == (1, 0)  # the base has a visual
    assert {surface.link for surface in scene.surfaces} == {"base", "upper"}


def test_links_are_named_on_their_visuals(tmp_path: Path) -> None:
    robot = arm(tmp_path)
    (axes,) = draw(robot, names="all").axes
    places = {text.get_gid(): text.xyann for text in axes.texts if text.get_gid()}
    assert {"name:link:base", "name:link:upper", "name:link:lower", "name:q1"} <= set(places)


def test_the_skeleton_is_a_switch_away(tmp_path: Path) -> None:
    robot = arm(tmp_path)
    bare = tmp_path / "bare"
    bare.mkdir()
    text = ARM.replace("visuals: [VISUAL]", "com: [0, 0, 0]").replace("visuals: [{box", "mass: 0 #")
    (bare / "arm.yaml").write_text(text.replace("mass: 0 #", "}  #"), encoding="utf-8")
    draw(robot, path=tmp_path / "skeleton.svg", skeleton=True)
    draw(load(bare / "arm.yaml"), path=tmp_path / "bare.svg")
    draw(robot, path=tmp_path / "visuals.svg")
    skeleton = (tmp_path / "skeleton.svg").read_text()
    assert skeleton == (tmp_path / "bare.svg").read_text()
    assert 'id="link:upper"' in skeleton
    visuals = (tmp_path / "visuals.svg").read_text()
    assert "<image" in visuals
    assert 'id="link:upper"' not in visuals
    assert 'id="link:lower"' in visuals
    assert 'id="joint:q2"' in visuals
    axes = Figure().add_subplot()
    draw_on(axes, robot, skeleton=True)
    assert not axes.get_images()


def test_a_mesh_is_painted_and_one_that_is_not_read_is_a_warning(tmp_path: Path) -> None:
    write_mesh(tmp_path / "part.stl")
    robot = arm(tmp_path, "{mesh: {file: part.stl, scale: -0.1}}")
    (surface,) = [one for one in surfaces_of(robot.description).surfaces if one.link == "upper"]
    assert volume(surface.vertices, surface.faces) == pytest.approx(1e-3)  # a mirror image
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        draw(robot)
    (tmp_path / "part.stl").write_bytes(b"nothing")
    with pytest.warns(UserWarning, match=r"arm: mesh part\.stl is not shown: it has no triangles"):
        figure = draw(robot)
    assert any(patch.get_gid() == "link:upper" for patch in figure.axes[0].patches)
