"""Joints of several freedoms: equal to engines that have quaternions, wherever they stand."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pinocchio as pin
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hybrid_dynamics_core import DescriptionError, InputError, Robot, load
from hybrid_dynamics_core.description.elasticity import Elasticity
from hybrid_dynamics_core.export import to_mjcf, to_sdf, to_urdf_plus, to_yaml
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.kinematics.pose import Pose
from hybrid_dynamics_core.scene.skeleton import link_poses
from hybrid_dynamics_core.simulation import Settings, simulate
from tests.sampling import examples

SUFFIXES = {to_yaml: ".yaml", to_mjcf: ".xml", to_sdf: ".sdf", to_urdf_plus: ".urdf"}
ROUNDING = 1e-11  # of numbers of about 10, through solves with the map of rates
BALL, FREE, KNEE = "hip", "floating_base", "knee"


def robot_of(**entries: Any) -> Robot:
    data = {"format": 1, "name": "robot", "end_effector": {"link": "l2"}, **entries}
    return Robot(parse_description(yaml.safe_dump(data)))


def body(mass: float) -> dict[str, Any]:
    inertia = {"xx": 0.02 * mass, "yy": 0.03 * mass, "zz": 0.014 * mass, "xy": 0.002 * mass}
    return {"mass": mass, "com": [0.1, 0.05, -0.2], "inertia": inertia}


def two_links(first: dict[str, Any], **entries: Any) -> Robot:
    """A joint of any type, then a hinge."""
    return robot_of(
        links={"l1": body(2.0), "l2": body(0.5)},
        joints={
            BALL: {"parent": "base", "child": "l1", **first},
            KNEE: {
                "type": "revolute",
                "parent": "l1",
                "child": "l2",
                "origin": {"xyz": [0, 0.1, -0.4]},
                "axis": [0.6, 0.8, 0],
            },
        },
        **entries,
    )


ORIGIN = {"xyz": [0.1, 0.2, 0.3], "rpy": [0.4, -0.5, 1.2]}


def ball_robot(**entries: Any) -> Robot:
    return two_links({"type": "ball", "origin": ORIGIN, **entries}, active=[BALL, KNEE])


def floating_robot(**entries: Any) -> Robot:
    """A floating link with another on a hinge."""
    return robot_of(
        floating=True,
        base="l1",
        links={"l1": body(2.0), "l2": body(0.5)},
        joints={
            KNEE: {
                "type": "revolute",
                "parent": "l1",
                "child": "l2",
                "origin": {"xyz": [0, 0.1, -0.4]},
                "axis": [0.6, 0.8, 0],
            }
        },
        active=[KNEE],
        **entries,
    )


def in_pinocchio(robot: Robot, joint: Any, placement: pin.SE3) -> pin.Model:
    """The two links in Pinocchio, the first on a native joint."""
    model = pin.Model()
    model.gravity.linear = np.array(robot.description.gravity)
    hinge = pin.JointModelRevoluteUnaligned(np.array([0.6, 0.8, 0.0]))
    at_knee = pin.SE3(np.eye(3), np.array([0, 0.1, -0.4]))
    for name, kind, place in (("l1", joint, placement), ("l2", hinge, at_knee)):
        link = robot.description.links[name]
        index = model.addJoint(model.njoints - 1, kind, place, name)
        inertia = pin.Inertia(link.mass, np.array(link.com), np.array(link.inertia))
        model.appendBodyToJoint(index, inertia, pin.SE3.Identity())
    return model


def random_pose(rng: np.random.Generator) -> Pose:
    return Pose(rng.normal(size=3), Rotation.random(random_state=rng).as_matrix())


@given(st.integers(0, 10_000))
@examples(80)
@pytest.mark.parametrize("axis", ["z", [0.3, -0.5, 0.81]])
def test_a_ball_joint_is_pinocchios_at_every_orientation(axis: Any, seed: int) -> None:
    robot = ball_robot(axis=axis)
    rng = np.random.default_rng(seed)
    placement = pin.SE3(pin.rpy.rpyToMatrix(np.array(ORIGIN["rpy"])), np.array(ORIGIN["xyz"]))
    model = in_pinocchio(robot, pin.JointModelSpherical(), placement)
    data = model.createData()
    pose, v, dv = random_pose(rng), rng.normal(size=4), rng.normal(size=4)
    q = rng.normal()
    state = robot.close_at_poses({BALL: pose}, {BALL: v[:3]}, u=[0, 0, 0, q], du=[0, 0, 0, v[3]])
    quaternion = Rotation.from_matrix(pose.rotation).as_quat()
    expected = pin.rnea(model, data, np.r_[quaternion, q], v, dv)
    twists = robot.twist_map(state)
    tau = robot.inverse_dynamics(state, twists.rate_accelerations(dv))
    assert twists.velocity(state.du) == pytest.approx(v, abs=ROUNDING)
    assert twists.wrenches(tau) == pytest.approx(expected, abs=ROUNDING)
    assert twists.efforts(expected) == pytest.approx(tau, abs=ROUNDING)
    mass = twists.mass_matrix(robot.minimal_form(state)[0])
    assert mass == pytest.approx(pin.crba(model, data, np.r_[quaternion, q]), abs=ROUNDING)
    back = twists.acceleration(robot.forward_dynamics(state, tau))
    assert back == pytest.approx(dv, abs=1e-9)


@given(st.integers(0, 10_000))
@examples(80)
def test_a_floating_base_is_pinocchios_free_flyer(seed: int) -> None:
    robot = floating_robot()
    rng = np.random.default_rng(seed)
    model = in_pinocchio(robot, pin.JointModelFreeFlyer(), pin.SE3.Identity())
    data = model.createData()
    pose, v, dv = random_pose(rng), rng.normal(size=7), rng.normal(size=7)
    q, dq = rng.normal(), v[0]
    state = robot.close_at_poses({FREE: pose}, {FREE: v[1:]}, u=[q, *[0] * 6], du=[dq, *[0] * 6])
    there = np.r_[pose.position, Rotation.from_matrix(pose.rotation).as_quat(), q]
    expected = pin.rnea(model, data, there, np.r_[v[1:], dq], np.r_[dv[1:], dv[0]])
    twists = robot.twist_map(state)
    tau = robot.inverse_dynamics(state, twists.rate_accelerations(dv))
    assert twists.wrenches(tau) == pytest.approx(np.r_[expected[6], expected[:6]], abs=ROUNDING)
    assert robot.joint_twist(state, FREE) == pytest.approx(v[1:], abs=ROUNDING)
    assert robot.forward_kinematics(state, "l1").rotation == pytest.approx(pose.rotation)
    assert robot.forward_kinematics(state, "l1").position == pytest.approx(pose.position)


@given(st.integers(0, 10_000))
@examples(40)
def test_momentum_and_centre_of_mass_are_pinocchios(seed: int) -> None:
    robot = floating_robot()
    rng = np.random.default_rng(seed)
    model = in_pinocchio(robot, pin.JointModelFreeFlyer(), pin.SE3.Identity())
    data = model.createData()
    pose, v = random_pose(rng), rng.normal(size=7)
    q = rng.normal()
    state = robot.close_at_poses({FREE: pose}, {FREE: v[1:]}, u=[q, *[0] * 6], du=[v[0], *[0] * 6])
    there = np.r_[pose.position, Rotation.from_matrix(pose.rotation).as_quat(), q]
    rates = np.r_[v[1:], v[0]]
    momentum_there = pin.computeCentroidalMomentum(model, data, there, rates).vector
    matrix_there = pin.computeCentroidalMap(model, data, there)
    centroidal = robot.centroidal(state)
    assert centroidal.mass == pytest.approx(2.5)
    assert centroidal.com == pytest.approx(pin.centerOfMass(model, data, there), abs=ROUNDING)
    assert centroidal.momentum == pytest.approx(momentum_there, abs=ROUNDING)
    in_twists = centroidal.momentum_matrix @ np.linalg.inv(robot.twist_map(state).V)
    assert in_twists[:, 1:] == pytest.approx(matrix_there[:, :6], abs=ROUNDING)
    assert in_twists[:, 0] == pytest.approx(matrix_there[:, 6], abs=ROUNDING)
    assert centroidal.com_jacobian @ state.du == pytest.approx(centroidal.com_velocity)


@given(st.integers(0, 10_000))
@examples(40)
def test_both_charts_give_the_same_answers(seed: int) -> None:
    robot = floating_robot()
    rng = np.random.default_rng(seed)
    pose, v, dv = random_pose(rng), rng.normal(size=6), rng.normal(size=7)
    state = robot.close_at_poses({FREE: pose}, {FREE: v}, du=rng.normal(size=7))
    other = robot.recentred(state, leave=0.0)
    assert (other.signs == -state.signs).all()
    far = 1.0 / np.cos(other.s[robot.middle_turns[0]])  # condition of the map there
    first, second = (robot.twist_map(one) for one in (state, other))
    answers = []
    for one, twists in ((state, first), (other, second)):
        tau = robot.inverse_dynamics(one, twists.rate_accelerations(dv))
        answers.append(
            [
                robot.joint_pose(one, FREE).matrix.ravel(),
                robot.joint_twist(one, FREE),
                robot.forward_kinematics(one).matrix.ravel(),
                twists.wrenches(tau),
                twists.mass_matrix(robot.minimal_form(one)[0]).ravel(),
            ]
        )
    for one, two in zip(*answers, strict=True):
        assert one == pytest.approx(two, abs=ROUNDING * far**2)
    assert robot.recentred(state) is state


def test_what_depends_on_the_chart_is_refused() -> None:
    """A limit or a stiffness along one of three angles would be another in the other chart."""
    robot = ball_robot()
    state = robot.close(robot.reference)
    name, own = robot.active[0], {KNEE: 5.0}
    with pytest.raises(InputError, match=f"efforts: '{name}' is an angle of a ball"):
        robot.capability(state, efforts={name: 5.0})
    with pytest.raises(InputError, match=f"rates: '{name}' is an angle of a ball"):
        robot.capability(state, rates={name: 5.0})
    with pytest.raises(InputError, match=f"drives: '{name}' is an angle of a ball"):
        robot.stiffness(state, Elasticity({name: 1e4}))
    assert robot.stiffness(state, Elasticity(own)).compliance.shape == (6, 6)
    assert robot.capability(state, efforts=own, rates=own)


@pytest.mark.parametrize("seed", range(3))
def test_stiffness_and_inverse_kinematics_do_not_know_charts(seed: int) -> None:
    robot = ball_robot()
    rng = np.random.default_rng(seed)
    pose = Pose(np.zeros(3), random_pose(rng).rotation)
    state = robot.close_at_poses({BALL: pose}, du=np.zeros(4), u=rng.normal(size=4))
    target = robot.forward_kinematics(robot.close(state.u + 0.05, near=state))
    answers = []
    for one in (state, robot.recentred(state, leave=0.0)):
        found = robot.inverse_kinematics(target, near=one).state
        reached = robot.forward_kinematics(found).matrix
        answers.append((robot.stiffness(one, Elasticity({KNEE: 1e3})).compliance, reached))
        assert reached == pytest.approx(target.matrix, abs=1e-9)
    assert answers[0][0] == pytest.approx(answers[1][0], abs=ROUNDING)


def test_a_batch_has_charts_of_its_rows() -> None:
    robot = floating_robot()
    rng = np.random.default_rng(3)
    poses = [random_pose(rng) for _ in range(12)]
    states = [robot.close_at_poses({FREE: pose}, {FREE: rng.normal(size=6)}) for pose in poses]
    batch = type(states[0]).joined(states)
    assert len(np.unique(batch.signs[:, -1])) == 2
    tau = robot.inverse_dynamics(batch, np.ones((12, 7)))
    wrenches = robot.twist_map(batch).wrenches(tau)
    for k, state in enumerate(states):
        one = robot.inverse_dynamics(state, np.ones(7))
        assert tau[k] == pytest.approx(one, abs=ROUNDING)
        assert wrenches[k] == pytest.approx(robot.twist_map(state).wrenches(one), abs=ROUNDING)
        assert robot.joint_pose(batch, FREE).rotation[k] == pytest.approx(poses[k].rotation)
    assert (robot.recentred(batch, 0.0).signs[:, -1] == -batch.signs[:, -1]).all()


MJCF = """
<mujoco><option gravity="0 0 -9.81"/><worldbody><body name="l1">
<joint name="hip" type="ball" armature="0.3" damping="0.7" stiffness="{stiffness}"/>
<inertial pos="0.1 0.05 -0.2" mass="2" fullinertia="0.04 0.06 0.028 0.004 0 0"/>
<body name="l2" pos="0 0.1 -0.4"><joint name="knee" axis="0.6 0.8 0"/>
<inertial pos="0.1 0.05 -0.2" mass="0.5" fullinertia="0.01 0.015 0.007 0.001 0 0"/>
</body></body></worldbody></mujoco>"""


@given(st.integers(0, 10_000))
@examples(40)
def test_armature_damping_and_spring_of_a_ball_are_mujocos(seed: int) -> None:
    effects = {"drive": {"rotor_inertia": 0.3}, "friction": {"viscous": 0.7}}
    robot = two_links(
        {"type": "ball", **effects, "spring": {"stiffness": 6.0}}, active=[BALL, KNEE]
    )
    rng = np.random.default_rng(seed)
    pose, v, dv = random_pose(rng), rng.normal(size=4), rng.normal(size=4)
    q = rng.normal()
    state = robot.close_at_poses({BALL: pose}, {BALL: v[:3]}, u=[0, 0, 0, q], du=[0, 0, 0, v[3]])
    model = mujoco.MjModel.from_xml_string(MJCF.format(stiffness=6))
    data = mujoco.MjData(model)
    x, y, z, w = Rotation.from_matrix(pose.rotation).as_quat()
    data.qpos[:], data.qvel[:], data.qacc[:] = [w, x, y, z, q], v, dv
    mujoco.mj_inverse(model, data)
    twists = robot.twist_map(state)
    tau = robot.inverse_dynamics(state, twists.rate_accelerations(dv))
    assert twists.wrenches(tau) == pytest.approx(data.qfrc_inverse, abs=ROUNDING)


def sprung(kind: str = "ball", stiffness: float = 6.0) -> Robot:
    return two_links(
        {"type": kind, "origin": ORIGIN, "spring": {"stiffness": stiffness}},
        active=[BALL, KNEE],
    )


@pytest.mark.parametrize("start", [[0.0, 0.0, 0.0], [1e-9, 0.0, 0.0], [0.4, -0.6, 0.9]])
def test_the_spring_of_a_ball_is_the_slope_of_its_energy(start: list[float]) -> None:
    """At rest too, where the axis of the rotation has no direction; kernels and derivatives."""
    robot, step = sprung(), 1e-6
    u = np.array([*start, 0.2])
    state = robot.close(u, np.zeros(4))
    taken = robot.passive_forces(state)
    slopes = []
    for unit in np.eye(4):
        ends = [robot.energy(robot.close(u + h * unit)).springs for h in (-step, step)]
        slopes.append((ends[1] - ends[0]) / (2 * step))
    assert taken == pytest.approx(slopes, abs=1e-8)
    by_u = robot.inverse_dynamics_derivatives(state, np.zeros(4))[0]
    columns = []
    for unit in np.eye(4):
        moved = [robot.close(u + h * unit, np.zeros(4)) for h in (-step, step)]
        before, after = (robot.inverse_dynamics(one, np.zeros(4)) for one in moved)
        columns.append((after - before) / (2 * step))
    assert by_u == pytest.approx(np.column_stack(columns), abs=1e-6)


@pytest.mark.parametrize("kind", ["ball", "free"])
@given(st.integers(0, 10_000))
@examples(16)
def test_the_spring_does_not_know_charts(kind: str, seed: int) -> None:
    robot = sprung(kind)
    pose = random_pose(np.random.default_rng(seed))
    first = robot.close_at_poses({BALL: pose})
    angle = Rotation.from_matrix(pose.rotation).magnitude()
    energy = 3.0 * angle**2
    if kind == "free":
        energy += 3.0 * pose.position @ pose.position
    for state in (first, robot.recentred(first, 0.0)):
        assert robot.energy(state).springs == pytest.approx(energy, rel=1e-9)


@pytest.mark.parametrize("export", SUFFIXES)
def test_files_keep_the_spring_of_a_ball(export: Any, tmp_path: Path) -> None:
    robot = sprung()
    file = tmp_path / f"back{SUFFIXES[export]}"
    file.write_text(export(robot), encoding="utf-8")
    back = load(file)
    u, du = [0.3, -0.4, 0.8, 0.1], [1.0, 0.5, -0.2, 0.3]
    expected = robot.inverse_dynamics(robot.close(u, du), np.ones(4))
    assert back.inverse_dynamics(back.close(u, du), np.ones(4)) == pytest.approx(expected, rel=1e-9)


def test_the_spring_of_a_ball_has_no_rest() -> None:
    with pytest.raises(DescriptionError, match="its spring is at rest at zero"):
        two_links({"type": "ball", "spring": {"stiffness": 1, "rest": 0.2}}, active=[BALL, KNEE])


def test_terms_of_armature_and_damping_agree_with_each_other() -> None:
    """M-bar, C-bar, energy, regressor and derivatives see what inverse dynamics sees."""
    robot = two_links(
        {"type": "ball", "drive": {"rotor_inertia": 0.3}, "friction": {"viscous": 0.7}},
        active=[BALL, KNEE],
    )
    rng = np.random.default_rng(1)
    u, du, ddu = [0.4, 0.5, -0.3, 0.2], rng.normal(size=4), rng.normal(size=4)
    state = robot.close(u, du)
    tau = robot.inverse_dynamics(state, ddu)
    mass, bias, gravity = robot.minimal_form(state)
    passive = robot.passive_forces(state)
    assert mass @ ddu + bias + gravity + passive == pytest.approx(tau, abs=ROUNDING)
    assert robot.coriolis_matrix(state) @ du == pytest.approx(bias, abs=ROUNDING)
    assert robot.energy(state).kinetic == pytest.approx(0.5 * du @ mass @ du)
    terms = robot.spanning_terms(state, ddu)
    assert np.abs(terms.M - mass).max() < ROUNDING
    assert terms.C @ du == pytest.approx(bias, abs=ROUNDING)
    assert robot.forward_dynamics(state, tau) == pytest.approx(ddu, abs=1e-9)
    step = 1e-6
    derivatives = robot.inverse_dynamics_derivatives(state, ddu)
    for k, unit in enumerate(np.eye(4)):
        ahead, behind = (
            robot.inverse_dynamics(robot.close(u + sign * step * unit, du), ddu)
            for sign in (1.0, -1.0)
        )
        numeric = (ahead - behind) / (2.0 * step)
        assert derivatives[0][:, k] == pytest.approx(numeric, abs=1e-7)


TYPES = {
    "universal": {"axis": "x", "axis2": [0, 0.6, 0.8]},
    "cylindrical": {"axis": [0, 0.6, 0.8]},
    "planar": {"axis": [0, 0.6, 0.8]},
    "screw": {"axis": "y", "pitch": 0.01},
}


@pytest.mark.parametrize("kind", TYPES)
def test_other_types_are_their_joints_in_a_row(kind: str) -> None:
    robot = two_links({"type": kind, "origin": ORIGIN, **TYPES[kind]}, active=[BALL, KNEE])
    rng = np.random.default_rng(0)
    n = len(robot.active)
    assert n == (2 if kind == "screw" else 3 if kind != "planar" else 4)
    joint = robot.description.multi_dof[BALL]
    assert (joint.type, joint.parent, joint.child) == (kind, "base", "l1")
    u = rng.normal(size=n)
    pose = robot.forward_kinematics(robot.close(u), "l1")
    place = Rotation.from_euler("xyz", ORIGIN["rpy"]).as_matrix()
    rotation = place.T @ pose.rotation
    position = place.T @ (pose.position - ORIGIN["xyz"])
    axis = np.array([0, 0.6, 0.8])
    if kind == "universal":
        expected = Rotation.from_rotvec([u[0], 0, 0]) * Rotation.from_rotvec(u[1] * axis)
        assert position == pytest.approx([0, 0, 0], abs=1e-14)
    elif kind == "cylindrical":
        expected = Rotation.from_rotvec(u[0] * axis)
        assert position == pytest.approx(u[1] * axis)
    elif kind == "planar":
        expected = Rotation.from_rotvec(u[2] * axis)
        assert position @ axis == pytest.approx(0.0, abs=1e-14)
        assert np.linalg.norm(position) == pytest.approx(np.hypot(u[0], u[1]))
    else:
        expected = Rotation.from_rotvec([0, u[0], 0])
        assert position == pytest.approx([0, 0.01 * u[0] / (2 * np.pi), 0])
    assert rotation == pytest.approx(expected.as_matrix(), abs=1e-14)


@pytest.mark.parametrize("spin", [[0.3, 4.0, 0.2], [1.0, -2.0, 6.0]])
def test_a_tumbling_body_keeps_momentum_and_energy_through_changes_of_charts(
    spin: list[float],
) -> None:
    robot = floating_robot(gravity=[0, 0, 0])
    twist = [0.1, 0.2, 0.3, *spin]
    start = robot.close_at_poses(
        {FREE: Pose(np.zeros(3), np.eye(3))}, {FREE: twist}, du=[1.0, *[0] * 6]
    )
    motion = simulate(
        robot, start, t_span=(0.0, 3.0), settings=Settings(rate=20, rtol=1e-12, atol=1e-12)
    )
    assert motion.completed
    assert len(np.unique(motion.state.signs[:, -1])) == 2
    momenta = np.array([momentum(robot, motion.state.rows(k)) for k in range(len(motion.t))])
    assert np.abs(momenta - momenta[0]).max() < 1e-9
    assert np.ptp(motion.energy.kinetic) < 1e-9 * motion.energy.kinetic[0]


def momentum(robot: Robot, state: Any) -> np.ndarray:
    """Linear and angular momentum (6,) about the origin of the world, body by body."""
    total = np.zeros(6)
    for name in ("l1", "l2"):
        link = robot.description.links[name]
        pose = robot.forward_kinematics(state, name)
        velocity = robot.jacobian(state, name) @ state.du
        arm = pose.rotation @ link.com
        linear = link.mass * (velocity[:3] + np.cross(velocity[3:], arm))
        inertia = pose.rotation @ link.inertia @ pose.rotation.T
        angular = np.cross(pose.position + arm, linear) + inertia @ velocity[3:]
        total += np.r_[linear, angular]
    return total


def test_a_reference_may_be_an_orientation_anywhere() -> None:
    quaternion = [0.0, 0.5**0.5, 0.0, 0.5**0.5]  # pi/2 about y: singular in one chart
    robot = two_links(
        {"type": "ball", "origin": ORIGIN},
        active=[BALL, KNEE],
        reference={BALL: {"quat": quaternion}, KNEE: 0.3},
    )
    state = robot.close(robot.reference)
    there = Rotation.from_quat(quaternion).as_matrix()
    assert robot.joint_pose(state, BALL).rotation == pytest.approx(there, abs=1e-14)
    assert abs(state.u[1]) < 0.8
    assert robot.kernels.inverse_dynamics(state.u, state.du, np.ones(4)) == pytest.approx(
        robot.inverse_dynamics(state, np.ones(4))
    )


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ({"type": "ball", "limits": [-1, 1]}, "write limits under"),
        ({"type": "ball", "axis2": "x"}, "a ball joint has no axis2"),
        ({"type": "ball", "each": {"hip_x": {}}}, "no coordinate 'hip_x'"),
        ({"type": "ball", "each": {"hip_rx": {"spring": {"stiffness": 1}}}}, "no spring along"),
        ({"type": "screw", "axis": "x", "pitch": 0}, "make the joint revolute"),
        ({"type": "universal", "axis": "x"}, "missing 'axis2'"),
        ({"type": "revolute", "axis": "x", "pitch": 1}, "a revolute joint has no pitch"),
    ],
)
def test_what_a_joint_cannot_have_is_refused(entry: dict[str, Any], words: str) -> None:
    with pytest.raises(DescriptionError, match=words):
        two_links(entry, active=[BALL, KNEE])


def test_wrong_poses_and_names_are_refused() -> None:
    robot = ball_robot()
    pose = Pose(np.zeros(3), np.eye(3))
    with pytest.raises(InputError, match="no ball or free joint 'hop'"):
        robot.close_at_poses({"hop": pose})
    with pytest.raises(InputError, match="expected 3 finite numbers"):
        robot.close_at_poses({BALL: pose}, {BALL: [1, 2]})
    with pytest.raises(InputError, match="'knee' has no pose"):
        robot.close_at_poses({BALL: pose}, {KNEE: [1, 2, 3]})
    with pytest.raises(InputError, match="orthonormal"):
        robot.close_at_poses({BALL: Pose(np.zeros(3), 2 * np.eye(3))})


def crank_and_rocker(rpy: list[float]) -> Robot:
    """An RSSR linkage whose rod hangs on the crank by a ball joint and spins idly."""
    return robot_of(
        links={"crank": body(1.0), "rod": body(0.5), "l2": body(1.0)},
        joints={
            "q1": {"type": "revolute", "parent": "base", "child": "crank", "axis": "z"},
            BALL: {
                "type": "ball",
                "parent": "crank",
                "child": "rod",
                "origin": {"xyz": [0.2, 0, 0], "rpy": rpy},
            },
            "q2": {
                "type": "revolute",
                "parent": "base",
                "child": "l2",
                "axis": "y",
                "origin": {"xyz": [0.8, 0.1, 0.4]},
            },
        },
        closures={"pin": {"kind": "point", "between": {"rod": [0, 0, 1.0], "l2": [0.5, 0, 0]}}},
        active=["q1"],
        idle=["hip_rz"],
        reference={"q1": 0.3},
    )


def test_a_ball_in_a_loop_changes_its_chart_and_nothing_else() -> None:
    """However its frame is drawn, the rod goes the same way, twice round with the crank."""
    u = np.stack([np.linspace(0.3, 0.3 + 4.0 * np.pi, 60), np.zeros(60)], axis=1)
    drawn = [[0.0, 0.0, 0.0], [0.4, 1.2, -2.0], [-1.7, 2.9, 0.6], [2.5, 0.3, 1.1]]
    directions, rockers, signs = [], [], set()
    for rpy in drawn:
        robot = crank_and_rocker(rpy)
        motion = robot.close_path(u)
        signs |= set(np.unique(motion.signs[..., -1]))
        middle = motion.s[:, robot.middle_turns[0]]
        assert np.abs(middle).max() < 1.3
        directions.append(robot.forward_kinematics(motion, "rod").rotation[..., 2])
        rockers.append(motion.s[:, robot.coordinates.index("q2")])
        jump = robot.close(u[-1], near=motion.rows(0))  # at once, from two turns before
        assert robot.forward_kinematics(jump, "rod").rotation[..., 2] == pytest.approx(
            directions[-1][-1], abs=1e-12
        )
    assert signs == {1.0, -1.0}
    for direction, rocker in zip(directions, rockers, strict=True):
        assert direction == pytest.approx(directions[0], abs=1e-12)
        assert rocker == pytest.approx(rockers[0], abs=1e-12)


@pytest.mark.parametrize("write", [to_yaml, to_mjcf, to_sdf, to_urdf_plus])
def test_every_format_brings_the_joints_back(write: Any, tmp_path: Path) -> None:
    quaternion = [0.0, 0.5**0.5, 0.0, 0.5**0.5]
    first = {"type": "ball", "origin": ORIGIN, "axis": [0.3, -0.5, 0.81]}
    robots = [
        two_links(first, active=[BALL, KNEE], reference={BALL: {"quat": quaternion}}),
        floating_robot(),
        two_links({"type": "screw", **TYPES["screw"]}, active=[BALL, KNEE]),
    ]
    for robot in robots:
        file = tmp_path / f"robot{SUFFIXES[write]}"
        file.write_text(write(robot))
        back = load(file)
        assert back.description.multi_dof.keys() == robot.description.multi_dof.keys()
        assert (back.active, back.idle) == (robot.active, robot.idle)
        here, there = (one.close(one.reference) for one in (robot, back))
        for link in ("l1", "l2"):
            pose = robot.forward_kinematics(here, link).matrix
            assert back.forward_kinematics(there, link).matrix == pytest.approx(pose, abs=1e-12)
        for joint in robot.description.freely_turning:
            pose = robot.joint_pose(here, joint.name).matrix
            assert back.joint_pose(there, joint.name).matrix == pytest.approx(pose, abs=1e-12)


def test_a_row_that_is_no_ball_joint_is_refused() -> None:
    robot = two_links({"type": "universal", **TYPES["universal"]}, active=[BALL, KNEE])
    text = to_yaml(robot).replace("type: universal", "type: ball")
    with pytest.raises(DescriptionError, match="a ball joint is revolute, revolute, revolute"):
        parse_description(text)


def test_a_drawing_stands_where_the_state_does() -> None:
    robot = floating_robot()
    pose = random_pose(np.random.default_rng(5))
    for leave in (0.0, 1.0):
        state = robot.recentred(robot.close_at_poses({FREE: pose}), leave)
        rotation, origin = link_poses(robot._model.tree, state)["l1"]
        assert rotation == pytest.approx(pose.rotation, abs=1e-14)
        assert origin == pytest.approx(pose.position, abs=1e-14)


URDF = """<robot name="r"><link name="world"/>
<link name="l1"><inertial><origin xyz="0.1 0.05 -0.2"/><mass value="2"/>
<inertia ixx="0.04" iyy="0.06" izz="0.028" ixy="0.004" ixz="0" iyz="0"/></inertial></link>
<link name="l2"><inertial><origin xyz="0.1 0.05 -0.2"/><mass value="0.5"/>
<inertia ixx="0.01" iyy="0.015" izz="0.007" ixy="0.001" ixz="0" iyz="0"/></inertial></link>
<joint name="root" type="TYPE"><parent link="world"/><child link="l1"/>
<origin xyz="0.1 0.2 0.3" rpy="0.4 -0.5 1.2"/><axis xyz="0 0.6 0.8"/></joint>
<joint name="knee" type="continuous"><parent link="l1"/><child link="l2"/>
<origin xyz="0 0.1 -0.4"/><axis xyz="0.6 0.8 0"/></joint></robot>"""


def test_a_floating_joint_of_urdf_is_pinocchios(tmp_path: Path) -> None:
    file = tmp_path / "robot.urdf"
    file.write_text(URDF.replace("TYPE", "floating"))
    robot = load(file)
    assert (robot.active[0], len(robot.idle)) == ("knee", 6)
    model = pin.buildModelFromUrdf(str(file))
    data = model.createData()
    rng = np.random.default_rng(2)
    pose, v, dv = random_pose(rng), rng.normal(size=7), rng.normal(size=7)
    state = robot.close_at_poses({"root": pose}, {"root": v[:6]}, du=[v[6], *[0] * 6])
    there = pin.neutral(model)
    there[:7] = np.r_[pose.position, Rotation.from_matrix(pose.rotation).as_quat()]
    expected = pin.rnea(model, data, there, v, dv)
    twists = robot.twist_map(state)
    ddu = twists.rate_accelerations(np.r_[dv[6], dv[:6]])
    found = twists.wrenches(robot.inverse_dynamics(state, ddu))
    assert found == pytest.approx(np.r_[expected[6], expected[:6]], abs=ROUNDING)


def test_a_planar_joint_of_urdf_moves_across_its_axis(tmp_path: Path) -> None:
    file = tmp_path / "robot.urdf"
    file.write_text(URDF.replace("TYPE", "planar"))
    robot = load(file)
    assert robot.active == ("root_x", "root_y", "root_turn", "knee")
    place = Rotation.from_euler("xyz", [0.4, -0.5, 1.2]).as_matrix()
    pose = robot.forward_kinematics(robot.close([0.3, -0.2, 0.7, 0.1]), "l1")
    moved = place.T @ (pose.position - [0.1, 0.2, 0.3])
    assert moved @ [0, 0.6, 0.8] == pytest.approx(0.0, abs=1e-14)
    turned = Rotation.from_matrix(place.T @ pose.rotation).as_rotvec()
    assert turned == pytest.approx([0, 0.7 * 0.6, 0.7 * 0.8], abs=1e-14)
