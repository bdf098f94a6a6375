"""Which mechanisms are planar, from where they are seen, and where their parts are."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.path import Path

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.drawing.paint.picture import make_scene
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.mechanism.tree import build_tree
from hybrid_dynamics_core.scene.attach import attach, rail
from hybrid_dynamics_core.scene.bodies import body_shapes
from hybrid_dynamics_core.scene.depth import from_back
from hybrid_dynamics_core.scene.drives import travel_arrow
from hybrid_dynamics_core.scene.groups import group_joints
from hybrid_dynamics_core.scene.parts import convex_hull
from hybrid_dynamics_core.scene.points import span_dimension
from hybrid_dynamics_core.scene.projection import choose_projection, find_plane
from hybrid_dynamics_core.scene.skeleton import place_skeleton
from tests.generated.robots import scaled
from tests.sampling import swept

from .conftest import robot_of

PLANAR = {"excavator", "five_bar", "forging_chu2020", "palletizer", "type_c", "type_d"}
PLANAR |= {"wrist", "slider_crank", "hinge_and_weld", "pendulum", "point"}
EXACT = 1e-12  # [m] the same products of rotations in another order


def at(robot: Robot, **values: float):
    u = np.array(robot.reference)
    for name, value in values.items():
        u[robot.active.index(name)] = value
    return place_skeleton(robot, robot.close(u))


def kinds_of(robot: Robot) -> dict[str, str]:
    """Kinds of the groups of joints, by name."""
    return {group.names: group.kind for group in group_joints(at(robot))}


def test_planar_mechanisms_are_recognised(robot: Robot) -> None:
    view = choose_projection(place_skeleton(robot, robot.close(robot.reference)))
    assert view.planar == (robot.name in PLANAR)


def test_a_turned_column_and_a_rolled_gripper_leave_an_arm_planar() -> None:
    normal = find_plane(at(robot_of("forging_chu2020"), q1=0.8, q4=1.3))
    assert normal is not None
    assert abs(normal @ [-np.sin(0.8), np.cos(0.8), 0.0]) == pytest.approx(1.0)


def test_a_turned_wrist_makes_an_arm_spatial() -> None:
    assert find_plane(at(robot_of("wrist"), q4=0.6)) is None


def test_a_side_view_stands_upright_and_points_to_the_right() -> None:
    for turn in (0.0, 0.8, 2.5, -1.6):
        skeleton = at(robot_of("excavator"), slew=turn)
        view = choose_projection(skeleton)
        np.testing.assert_allclose(view.up, [0.0, 0.0, 1.0], atol=1e-12)
        assert view.project(skeleton.tip.point)[0] > 1.0  # the bucket is to the right of the column
    excavator = robot_of("excavator")
    names = choose_projection(at(excavator)).names
    assert names == ("x [m]", "z [m]")
    names = choose_projection(at(excavator, slew=0.8)).names
    assert names == ("along the arm [m]", "z [m]")
    names = choose_projection(at(robot_of("five_bar"))).names
    assert names == ("x [m]", "y [m]")


def test_a_view_is_orthonormal_and_from_above(robot: Robot) -> None:
    view = choose_projection(place_skeleton(robot, robot.close(robot.reference)))
    axes = np.stack([view.right, view.up, view.toward])
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    assert view.planar or 0.2 < view.toward[2] < 0.6


def test_joints_closures_and_frames_are_where_kinematics_puts_them(robot: Robot) -> None:
    state = robot.close(robot.reference)
    skeleton = place_skeleton(robot, state)
    for joint in skeleton.joints:
        pose = robot.forward_kinematics(state, joint.child)
        np.testing.assert_allclose(joint.point, pose.position, atol=EXACT)
        axis = pose.rotation @ robot.description.joints[joint.name].axis
        np.testing.assert_allclose(joint.axis, axis, atol=EXACT)
    tip = robot.forward_kinematics(state)
    np.testing.assert_allclose(skeleton.tip.point, tip.position, atol=EXACT)
    np.testing.assert_allclose(skeleton.tip.rotation, tip.rotation, atol=EXACT)
    for closure in skeleton.closures:
        planar = find_plane(skeleton) if closure.kind == "planar" else None
        gap = closure.points[0] - closure.points[1]
        if planar is not None:
            gap = gap - (gap @ planar) * planar
        assert np.linalg.norm(gap) < 1e-9  # the closure's own tolerance


def test_every_joint_is_in_one_group_and_every_link_between_joints_too(robot: Robot) -> None:
    groups = group_joints(place_skeleton(robot, robot.close(robot.reference)))
    names = []
    children = {body.joint: body.name for body in build_tree(robot.description).bodies}
    for group in groups:
        names += [joint.name for joint in group.joints]
        inner = [children[joint.name] for joint in group.joints[:-1]]
        assert list(group.inner) == inner
    assert sorted(names) == sorted(robot.coordinates)


def test_legs_of_a_platform_have_universal_joints_and_its_pose_is_no_mechanism() -> None:
    kinds = kinds_of(robot_of("staicu2015"))
    assert kinds["x+y+z"] == "carrier"
    assert kinds["alpha_1+alpha_2+alpha_3"] == "spherical"
    for leg in "ABCDEF":
        assert kinds[f"phi10_{leg}+phi21_{leg}"] == "universal"
    gough = kinds_of(robot_of("gough"))
    assert gough["x+y+z+alpha_1+alpha_2+alpha_3"] == "carrier"
    arm = kinds_of(robot_of("wrist"))
    assert set(arm.values()) == {"revolute"}  # what is driven is always drawn by itself


def test_cylinders_reach_from_pin_to_pin() -> None:
    scene = make_scene(robot_of("excavator"), None)
    by_name = {joint.name: joint.point for joint in scene.skeleton.joints}
    pins = {closure.name: closure.point for closure in scene.skeleton.closures}
    ends = {
        "barrel_1": ("boom_barrel_pitch", "boom_loop"),
        "barrel_2": ("stick_barrel_pitch", "stick_loop"),
    }
    for part in scene.parts:
        if part.role == "barrel" and part.links[0] in ends:
            joint, closure = ends[part.links[0]]
            foot, pin = by_name[joint], pins[closure]
            np.testing.assert_allclose(part.points[0], foot, atol=1e-9)
            along = (pin - foot) / np.linalg.norm(pin - foot)
            np.testing.assert_allclose(part.axis, along, atol=1e-9)


COORDINATES = st.integers(-50, 50).map(float)


@given(st.lists(st.tuples(COORDINATES, COORDINATES), min_size=3, max_size=25))
def test_a_hull_is_convex_and_holds_every_point(points: list[tuple[float, float]]) -> None:
    corners = convex_hull(np.array(points))
    assert {tuple(corner) for corner in corners} <= set(points)
    if len(corners) > 2:
        edges = np.roll(corners, -1, axis=0) - corners
        for point in np.array(points):
            offsets = point - corners
            turns = edges[:, 0] * offsets[:, 1] - edges[:, 1] * offsets[:, 0]
            assert turns.min() >= 0.0  # whole numbers: no rounding


def shrunk(robot: Robot, factor: float) -> Robot:
    """The robot with every length multiplied, strokes too."""
    description = scaled(robot.description, factor)
    joints = dict(description.joints)
    for name, joint in joints.items():
        if joint.type == "prismatic":
            lower, upper = joint.limits
            joints[name] = replace(joint, limits=(factor * lower, factor * upper))
    return Robot(replace(description, joints=joints))


ALIKE = ("slider_crank", "type_d", "gough", "excavator", "delta", "staicu2015", "palletizer")


@pytest.mark.parametrize("name", swept(ALIKE, ["slider_crank", "type_d", "delta", "staicu2015"]))
def test_a_small_robot_is_drawn_as_a_large_one_is(name: str) -> None:
    factor = 1.0 / 64.0
    large = make_scene(robot_of(name), None)
    small = make_scene(shrunk(robot_of(name), factor), None)
    assert small.projection.right == pytest.approx(large.projection.right, abs=1e-9)
    assert small.projection.up == pytest.approx(large.projection.up, abs=1e-9)
    for kind in ("parts", "lines"):
        for mark, other in zip(getattr(small, kind), getattr(large, kind), strict=True):
            assert (mark.owner, mark.role) == (other.owner, other.role)
            assert mark.points == pytest.approx(factor * other.points, abs=1e-9)
            if kind == "parts":
                assert mark.radius == pytest.approx(factor * other.radius, rel=1e-9)
    sizes = [part.radius for part in small.parts]
    assert sizes == pytest.approx([factor * part.radius for part in large.parts], rel=1e-9)


@pytest.mark.parametrize(("name", "is_disc"), [("gantry", True), ("rssr", False), ("gough", False)])
def test_a_base_with_one_joint_is_a_disc_and_a_plate_with_several(name: str, is_disc: bool) -> None:
    parts = make_scene(robot_of(name), None).parts
    (base,) = (part for part in parts if part.role == "base")
    assert (base.axis is not None) == is_disc


def test_what_hides_nothing_is_seen_from_the_usual_side() -> None:
    """35 degrees to the left of the plane y = 0, from 24 degrees above."""
    view = choose_projection(at(robot_of("gantry")))
    turn, height = np.radians([35.0, 24.0])
    assert view.right == pytest.approx([np.cos(turn), np.sin(turn), 0.0])
    assert view.toward[2] == pytest.approx(np.sin(height))


@pytest.mark.parametrize("count", [1, 2, 3, 4, 6])
def test_points_at_random_span_what_their_number_allows(count: int) -> None:
    points = np.random.default_rng(count).normal(size=(count, 3))
    assert span_dimension(points) == min(count - 1, 3)


def test_a_body_is_a_plate_with_posts_or_has_faces() -> None:
    square = np.array([[1, 1, 0], [1, -1, 0], [-1, -1, 0], [-1, 1, 0]], dtype=float)
    post = np.array([0.2, 0.1, 1.0])
    (plate, bar) = body_shapes(square, np.vstack([square, post]), 0.05)
    assert plate[0] == "plate"
    assert plate[1] == pytest.approx(square)
    assert bar[0] == "bar"
    assert bar[1] == pytest.approx(np.array([[0.0, 0.0, 0.0], post]))
    pyramid = np.vstack([square[:3], post])
    faces = body_shapes(pyramid, pyramid, 0.05)
    assert [(role, len(corners)) for role, corners in faces] == [("plate", 3)] * 4


@pytest.mark.parametrize("count", [4, 5, 6])
def test_a_plate_has_all_points_of_the_largest_plane_and_posts_lead_to_the_others(
    count: int,
) -> None:
    random = np.random.default_rng(count)
    flat = random.normal(size=(count, 2)) @ random.normal(size=(2, 3)) + random.normal(size=3)
    others = random.normal(size=(2, 3))
    points = random.permutation(np.vstack([flat, others]))
    (role, plate), *posts = body_shapes(points, points, 0.0)
    assert role == "plate"
    assert np.array_equal(np.unique(plate, axis=0), np.unique(flat, axis=0))
    ends = np.array([ends[-1] for _, ends in posts])
    assert np.array_equal(np.unique(ends, axis=0), np.unique(others, axis=0))


@pytest.mark.parametrize(("begin", "stays"), [(0.95, False), (1.05, False), (1.2, True)])
def test_an_arrow_changes_sides_where_it_and_its_heads_would_be_on_a_part(
    begin: float, stays: bool
) -> None:
    """A part ahead of an arrow, which begins at a share of its length."""
    scene = make_scene(robot_of("gantry"), None)
    for joint in scene.skeleton.joints:
        if joint.type != "prismatic":
            continue
        free = travel_arrow(joint, None, scene.projection, scene.joint_radius, [])
        start, end = scene.projection.project(free.points[[0, -1]])
        along = end - start
        wide = 0.05 * np.array([-along[1], along[0]])
        near, far = start + begin * along, start + 3.0 * along
        part = Path([near - wide, far - wide, far + wide, near + wide])
        arrow = travel_arrow(joint, None, scene.projection, scene.joint_radius, [part])
        assert np.array_equal(arrow.points, free.points) == stays


def test_an_arrow_with_room_on_both_sides_is_to_the_left_of_its_slide() -> None:
    scene = make_scene(robot_of("gantry"), None)
    slides = [joint for joint in scene.skeleton.joints if joint.type == "prismatic"]
    for joint in slides:
        arrow = travel_arrow(joint, None, scene.projection, scene.joint_radius, [])
        ahead = scene.projection.project(joint.axis[None])[0]
        beside = scene.projection.project(arrow.points.mean(axis=0)[None] - joint.point)[0]
        assert ahead[0] * beside[1] - ahead[1] * beside[0] > 0.0
    assert slides


@pytest.mark.parametrize("name", ["gough", "staicu2015"])
def test_symbols_are_no_wider_than_their_bodies_and_the_floor_is_behind_them(name: str) -> None:
    scene = make_scene(robot_of(name), None)
    floor, *others = from_back(scene)
    assert floor.role == "base"
    symbols = [part for part in others if part.role in ("hinge", "ball", "cross", "pin", "weld")]
    sizes = [part.radius / scene.joint_radius for part in symbols]
    assert 0.4 < min(sizes) <= max(sizes) < 1.6


@pytest.mark.parametrize("name", ["gantry", "slider_crank"])
def test_a_slide_is_held_on_its_rail_and_a_frame_has_its_axes(name: str) -> None:
    skeleton = at(robot_of(name))
    held = attach(skeleton, group_joints(skeleton))
    slides = [joint for joint in skeleton.joints if joint.type == "prismatic"]
    for joint in slides:
        shares = [(point - joint.start) @ joint.axis for point in held[joint.parent].fixed]
        lower, upper = sorted((end - joint.start) @ joint.axis for end in rail(joint))
        assert any(lower - 1e-9 <= share <= upper + 1e-9 for share in shares)
    assert slides
    scene = make_scene(robot_of(name), None)
    ways = {f"joint:{joint.name}": rail(joint) for joint in scene.skeleton.joints}
    rails = [part for part in scene.parts if part.role == "rail"]
    for part in rails:  # as far beyond one end as beyond the other
        assert part.points.mean(axis=0) == pytest.approx(ways[part.owner].mean(axis=0))
    assert rails
    arrows = [line.points for line in scene.lines if line.role == "triad"]
    along = np.array([end - start for start, end in arrows])
    tip = scene.skeleton.tip
    assert along / np.linalg.norm(along, axis=1)[:, None] == pytest.approx(tip.rotation.T)


SWIVEL = """
format: 1
name: swivel
active_set: motors
links: {base: {}, fork: {}, bar: {mass: 1, com: [0.2, 0.1, 0.3], inertia: {sphere: {radius: 0.1}}}}
joints:
  loose: {type: revolute, parent: base, child: fork, axis: y}
  driven: {type: revolute, parent: fork, child: bar, axis: x}
active: [driven]
end_effector: {link: bar, xyz: [0.4, 0, 0]}
"""


def test_what_is_driven_is_drawn_by_itself() -> None:
    """Also behind a joint at the same place that nobody drives."""
    assert kinds_of(Robot(parse_description(SWIVEL))) == {
        "loose": "revolute",
        "driven": "revolute",
    }
