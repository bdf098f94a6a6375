"""What the scene holds, without a browser: every link, joint and loop where the model has it."""

from __future__ import annotations

import functools
from itertools import chain

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hybrid_dynamics_core import ClosedState, ClosureStatus, Robot, load, shipped_robots
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.scene.part_style import IDLE
from hybrid_dynamics_core.scene.skeleton import place_skeleton
from hybrid_dynamics_core.scene.style import RED
from hybrid_dynamics_core.view.bodies import robot_shape, span_pose
from hybrid_dynamics_core.view.camera import camera_for, floor_under
from hybrid_dynamics_core.view.meshes import ring_arrow
from hybrid_dynamics_core.view.session import DriveEfforts
from tests.drawing.conftest import SAMPLE
from tests.drawing.shapes import SHAPES, shape
from tests.export.test_round_trip import CART
from tests.sampling import swept

from .conftest import Opened

SENT = (
    2e-5  # relative: viser does not send a pose that differs by less than 1e-5 from the one before
)
FLOAT = 1e-6  # of the size of the robot: rounding of meshes, which is far below what a screen shows


@functools.cache
def loaded(name: str) -> Robot:
    return shape(name) if name in SHAPES else load(name)


@functools.cache
def moved(name: str, seed: int = 0) -> ClosedState:
    """Some other state, at random."""
    robot, rng = loaded(name), np.random.default_rng(seed)
    home = robot.close(robot.reference)
    for reach in 0.3 * 0.7 ** np.arange(20):
        low, high = (
            np.maximum(robot.limits[:, 0], home.u - reach),
            np.minimum(robot.limits[:, 1], home.u + reach),
        )
        state = robot.close(rng.uniform(low, high), near=home, check=False)
        if state.status is ClosureStatus.OK:
            return state
    raise AssertionError(f"{name}: no other state found")


@pytest.fixture(params=swept(shipped_robots(), SAMPLE))
def robot(request: pytest.FixtureRequest) -> Robot:
    """Each shipped robot in turn."""
    return loaded(request.param)


@pytest.fixture(params=swept((*shipped_robots(), *SHAPES), SAMPLE))
def any_robot(request: pytest.FixtureRequest) -> Robot:
    """Robots of many shapes: without loops, of one point, with every kind of joint and closure."""
    return loaded(request.param)


def test_every_link_joint_and_loop_is_shown(any_robot: Robot) -> None:
    robot = any_robot
    shape = robot_shape(robot, robot.close(robot.reference))
    shown: dict[str, set[str]] = {kind: set() for kind in ("link", "joint", "closure")}
    for piece in chain(shape.bodies, shape.spans):
        shown[piece.kind] |= set(piece.names)
    assert shown["joint"] == set(robot.coordinates)
    assert shown["closure"] == {closure.name for closure in robot.description.closures}
    assert shown["link"] >= set(robot.description.links)


def test_links_stand_where_forward_kinematics_says(robot: Robot, opened: Opened) -> None:
    viewer = opened(robot)
    for state in (moved(robot.name, seed) for seed in range(2)):
        viewer.session.take_state(state)
        viewer.show()
        for link in robot.description.links:
            pose = robot.forward_kinematics(state, link)
            handle = viewer.scene_view.links[link]
            assert handle.position == pytest.approx(pose.position, rel=SENT, abs=1e-7)
            turned = Rotation.from_quat(handle.wxyz[[1, 2, 3, 0]]).inv() * Rotation.from_matrix(
                pose.rotation
            )
            assert turned.magnitude() < 1e-4  # [rad] four components, each to SENT


def test_joints_and_pins_hold_their_links_together(robot: Robot) -> None:
    """The middle of each hinge, ball and pin moves with one link, and is on the other one too."""
    shape = robot_shape(robot, robot.close(robot.reference))
    state = moved(robot.name)
    poses, skeleton = shape.poses(state), place_skeleton(robot, state)
    points = {joint.name: joint.point for joint in skeleton.joints if joint.type == "revolute"}
    points |= {closure.name: closure.points[1] for closure in skeleton.closures}
    checked = set()
    for body in shape.bodies:
        for name in points.keys() & set(body.names) if body.kind != "link" else ():
            rotation, origin = poses[body.link]
            middle = 0.5 * (body.mesh.vertices.min(axis=0) + body.mesh.vertices.max(axis=0))
            assert rotation @ middle + origin == pytest.approx(points[name], abs=FLOAT * shape.size)
            checked.add(name)
    assert checked == set(points) - {name for span in shape.spans for name in span.names}


def test_rods_slide_in_their_barrels(robot: Robot) -> None:
    """A rod ends on its own link, and grows by what its joint does."""
    home = robot.close(robot.reference)
    shape = robot_shape(robot, home)
    state = moved(robot.name)
    slides = {j.child: j.name for j in robot.description.joints.values() if j.type == "prismatic"}
    for span in (span for span in shape.spans if span.kind == "link"):
        k = robot.coordinates.index(slides[span.names[0]])
        before, after = (span_pose(span, shape.poses(s))[2] for s in (home, state))
        assert abs(after - before) == pytest.approx(
            abs(state.s[k] - home.s[k]), abs=FLOAT * shape.size
        )


def test_rods_and_thin_lines_reach_from_link_to_link(robot: Robot) -> None:
    shape = robot_shape(robot, robot.close(robot.reference))
    poses = shape.poses(moved(robot.name))
    for span in shape.spans:
        turned, start, length = span_pose(span, poses)
        ends = start, start + length * turned[:, 2]
        for link, point, end in zip(span.links, span.points, ends, strict=True):
            rotation, origin = poses[link]
            assert end == pytest.approx(rotation @ point + origin, abs=FLOAT * shape.size)
        assert turned @ turned.T == pytest.approx(np.eye(3), abs=1e-12)


def test_meshes_are_closed_and_turned_outward(any_robot: Robot) -> None:
    """The volume that the triangles enclose is positive, and their areas as vectors cancel."""
    for body in robot_shape(any_robot, any_robot.close(any_robot.reference)).bodies:
        a, b, c = (body.mesh.vertices[body.mesh.faces[:, k]] for k in range(3))
        areas = np.cross(b - a, c - a)
        assert np.einsum("ij,ij->", a - body.mesh.vertices.mean(axis=0), areas) > 0.0, body.names
        assert np.abs(areas.sum(axis=0)).max() < 1e-9 * np.abs(areas).sum(), body.names  # rounding


def test_the_camera_sees_all_of_the_robot(any_robot: Robot) -> None:
    shape = robot_shape(any_robot, any_robot.close(any_robot.reference))
    camera, floor = camera_for(shape.skeleton, shape.points), floor_under(shape.points, shape.unit)
    ahead = (camera.look_at - camera.position) / np.linalg.norm(camera.look_at - camera.position)
    away = shape.points - camera.position
    angles = np.arccos(np.clip(away @ ahead / np.linalg.norm(away, axis=1), -1.0, 1.0))
    assert angles.max() < 0.5 * camera.field
    assert angles.max() > 0.1 * camera.field or np.ptp(shape.points) == 0.0
    assert camera.position[2] > floor.level
    assert shape.points[:, 2].min() > floor.level
    # The corner is beside it, within a picture as wide as high.
    assert np.linalg.norm(camera.corner - camera.look_at) > camera.radius
    assert camera.sees(camera.corner[None], 1.0)


@pytest.mark.parametrize("name", ["palletizer", "ankle"])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_ring_of_a_torque_is_open_where_the_link_is_that_it_turns(
    name: str, sign: float, opened: Opened
) -> None:
    """In another state too: seen along the axis, 0.5 rad to either side of the link stay free."""
    from hybrid_dynamics_core.view.scene_view import RING, reach

    viewer, robot = opened(loaded(name)), loaded(name)
    state, stage = moved(name), viewer.scene_view
    stage.show(state)
    count = len(robot.drives)
    stage.show_efforts(DriveEfforts(robot.drives, sign * np.ones(count), np.ones(count)))
    skeleton, poses = place_skeleton(robot, state), stage.shape.poses(state)
    rings = 0
    for joint in (joint for joint in skeleton.joints if joint.name in robot.drives):
        arm = reach(skeleton, joint)
        if not arm.any():
            continue
        rotation, origin = poses[joint.child]
        handle = stage.arrows[joint.name].handle
        turned = rotation @ Rotation.from_quat(handle.wxyz[[1, 2, 3, 0]]).as_matrix()
        ring = (
            handle.scale * ring_arrow(RING).vertices @ turned.T
            + rotation @ handle.position
            + origin
            - joint.point
        )
        ahead = ring @ joint.axis
        assert (
            np.abs(ahead) > stage.shape.unit
        ).all()  # the radius of the joint: the ring is before it
        across = ring - np.outer(ahead, joint.axis)
        cosines = across @ arm / np.linalg.norm(across, axis=1) / np.linalg.norm(arm)
        angles = np.arccos(np.clip(cosines, -1.0, 1.0))
        assert angles.min() > 0.5
        assert np.degrees(angles).max() > 170.0  # and it is there, on the other side
        direction = np.cross(ring[:-1], ring[1:]).sum(axis=0) @ joint.axis
        assert np.sign(direction) == sign
        rings += 1
    assert rings > 0


def test_what_is_idle_is_grey() -> None:
    robot = Robot(parse_description(CART))
    shape = robot_shape(robot, robot.close(robot.reference))
    colours = {body.names[0]: body.colour for body in shape.bodies if body.kind == "joint"}
    assert colours["th"] == IDLE
    drawn = {body.role: body.colour for body in shape.bodies if body.names == ("x",)}
    assert drawn["block"] == RED
