"""MJCF in all its styles is read as MuJoCo itself reads it: poses, inverse dynamics, closures."""

from __future__ import annotations

import math
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import Phase, given
from hypothesis import strategies as st

from hybrid_dynamics_core import ClosedState, Robot
from hybrid_dynamics_core.algebra.rotations import quaternion
from hybrid_dynamics_core.description.geometry import (
    Transform,
    rotation_about,
    rotation_from_quaternion,
)
from hybrid_dynamics_core.description.model import Frame, RobotDescription
from hybrid_dynamics_core.formats.reader import read_description
from tests.export.mjcf_models import RandomModel
from tests.sampling import examples

mujoco = pytest.importorskip("mujoco")
COUPLINGS = [int(mujoco.mjtEq.mjEQ_JOINT), int(mujoco.mjtEq.mjEQ_TENDON)]
SEEDS = st.integers(0, 2**32 - 1)
NEAR = 1e-9  # of numbers of the size 1 to 100, which go through angles and back


def described(text: str) -> RobotDescription:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "model.xml"
        file.write_text(text, encoding="utf-8")
        return read_description(file)


class Pair:
    """One file in MuJoCo and here, where its loops are cut and every joint is active."""

    def __init__(self, text: str) -> None:
        self.model = mujoco.MjModel.from_xml_string(text)
        self.data = mujoco.MjData(self.model)
        self.description = described(text)
        self.tree = Robot(
            replace(
                self.description,
                closures=(),
                mimics={},
                active=tuple(self.description.joints),
                active_set="exact",
            )
        )

    def single(self, values: np.ndarray, indices: str) -> np.ndarray:
        """Entries of hinges and slides, in the order of this library."""
        index = [getattr(self.model.joint(name), indices)[0] for name in self.tree.active]
        return values[index]

    def placed(self, state: ClosedState, frame: Frame) -> Transform:
        """A frame on a link, in the world."""
        inside = Transform(frame.rotation, frame.translation)
        if frame.link == self.description.base:
            return inside
        pose = self.tree.forward_kinematics(state, frame.link)
        named = self.description.frames.get(frame.link, Frame(frame.link))
        at_joint = Transform(named.rotation, named.translation).inverse()
        return Transform(pose.rotation, pose.position) @ at_joint @ inside

    def assert_poses(self, state: ClosedState) -> None:
        for name in self.tree.frames:
            if name in self.description.links or name in self.description.frames:
                self.assert_pose(state, name)

    def assert_pose(self, state: ClosedState, name: str) -> None:
        kind = mujoco.mjtObj.mjOBJ_BODY
        number = mujoco.mj_name2id(self.model, kind, name)
        places, turns = self.data.xpos, self.data.xmat
        if number < 0:
            number = mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_SITE, name)
            places, turns = self.data.site_xpos, self.data.site_xmat
        if number < 0:
            return  # a massless link between joints, or the end effector
        pose = self.tree.forward_kinematics(state, name)
        assert pose.position == pytest.approx(places[number], abs=NEAR)
        assert pose.rotation.ravel() == pytest.approx(turns[number], abs=NEAR)


@examples(36, phases=(Phase.explicit, Phase.generate))
@given(SEEDS)
def test_hinges_and_slides_move_as_in_mujoco(seed: int) -> None:
    """Poses, efforts, limits and gaps of closures at a random state, loops open."""
    assert_moves_alike(RandomModel(seed).text(), seed)


def assert_moves_alike(text: str, seed: int) -> None:
    """A file of hinges and slides is the same here and in MuJoCo."""
    pair = Pair(text)
    model, data = pair.model, pair.data
    rng = np.random.default_rng(seed)
    data.qpos[:], data.qvel[:], data.qacc[:] = rng.uniform(-1, 1, (3, model.nv))
    mujoco.mj_fwdPosition(model, data)
    mujoco.mj_fwdVelocity(model, data)
    q, v = pair.single(data.qpos, "qposadr"), pair.single(data.qvel, "dofadr")
    qacc = rng.uniform(-1, 1, model.nv)
    state = pair.tree.close(q, v)
    pair.assert_poses(state)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    expected = mass @ qacc + data.qfrc_bias - data.qfrc_passive
    efforts = pair.tree.inverse_dynamics(state, pair.single(qacc, "dofadr"))
    size = max(1.0, float(np.abs(expected).max()))
    assert efforts == pytest.approx(pair.single(expected, "dofadr"), abs=NEAR * size)
    assert_limits(pair)
    assert_gaps(pair, state)


def assert_limits(pair: Pair) -> None:
    for name, joint in pair.description.joints.items():
        actual = pair.model.joint(name)
        if actual.limited[0]:
            assert joint.limits == pytest.approx(actual.range, abs=1e-12)
        else:
            assert joint.limits == (-math.inf, math.inf)


def assert_gaps(pair: Pair, state: ClosedState) -> None:
    """What is left open is what MuJoCo would close, by the length of each gap."""
    rows = pair.data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY
    residuals, ids = pair.data.efc_pos[rows], pair.data.efc_id[rows]
    closures = iter(pair.description.closures)
    for number in range(pair.model.neq):
        residual = residuals[ids == number]
        if pair.model.eq_type[number] in COUPLINGS:
            continue
        closure = next(closures)
        a, b = (pair.placed(state, frame) for frame in closure.frames())
        gap = np.linalg.norm(a.translation - b.translation)
        assert gap == pytest.approx(np.linalg.norm(residual[:3]), abs=NEAR)
        if closure.kind == "frame":
            turn = a.rotation.T @ b.rotation
            cosine = (np.trace(turn) - 1.0) / 2.0
            half_sine = math.sqrt(max(0.0, (1.0 - cosine) / 2.0))
            torque_scale = pair.model.eq_data[number, 10]
            size = torque_scale * half_sine
            assert size == pytest.approx(np.linalg.norm(residual[3:]), abs=1e-7)
    followers = pair.description.mimics
    positions = dict(zip(pair.tree.active, state.u, strict=True))
    couplings = np.flatnonzero(np.isin(pair.model.eq_type, COUPLINGS))
    closed = pair.data.qpos.copy()
    for name, mimic in [*followers.items()] * len(followers):  # until the last one follows
        value = mimic.offset
        for source, multiplier in mimic.multipliers.items():
            value += multiplier * positions[source]
        positions[name] = value
        closed[pair.model.joint(name).qposadr[0]] = value
    assert len(followers) == len(couplings)
    pair.data.qpos[:] = closed
    mujoco.mj_fwdPosition(pair.model, pair.data)
    rows = pair.data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY
    for number in couplings:
        residual = pair.data.efc_pos[rows & (pair.data.efc_id == number)]
        assert residual == pytest.approx(0.0, abs=NEAR)


@examples(18, phases=(Phase.explicit, Phase.generate))
@given(SEEDS)
def test_balls_and_free_bodies_move_as_in_mujoco(seed: int) -> None:
    """Poses, weight and kinetic energy; MuJoCo counts them by quaternions and twists."""
    types = ("hinge", "slide", "ball", "free")
    pair = Pair(RandomModel(seed, types, has_constraints=False).text())
    model, data = pair.model, pair.data
    rng = np.random.default_rng(seed)
    q = dict(zip(pair.tree.active, rng.uniform(-1, 1, model.nv), strict=True))
    v = dict(zip(pair.tree.active, rng.uniform(-1, 1, model.nv), strict=True))
    for number in range(model.njnt):
        qpos, qvel = quaternions_and_twists(model, number, q, v)
        first, first_rate = model.jnt_qposadr[number], model.jnt_dofadr[number]
        data.qpos[first : first + len(qpos)] = qpos
        data.qvel[first_rate : first_rate + len(qvel)] = qvel
    mujoco.mj_fwdPosition(model, data)
    state = pair.tree.close(list(q.values()), list(v.values()))
    pair.assert_poses(state)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    energy = pair.tree.energy(state).kinetic
    assert energy == pytest.approx(0.5 * data.qvel @ mass @ data.qvel, rel=NEAR)
    rates = data.qvel.copy()
    data.qvel[:] = 0.0
    mujoco.mj_fwdVelocity(model, data)
    power = (data.qfrc_bias - data.qfrc_passive) @ rates
    still = pair.tree.close(list(q.values()))
    held = pair.tree.inverse_dynamics(still, np.zeros(model.nv))
    assert held @ list(v.values()) == pytest.approx(power, abs=NEAR * max(1.0, np.abs(held).max()))


def quaternions_and_twists(
    model, number: int, q: dict[str, float], v: dict[str, float]
) -> tuple[np.ndarray, np.ndarray]:
    """MuJoCo's numbers of a joint: position and quaternion, velocity and angular velocity."""
    joint = model.joint(number)
    name = joint.name or f"joint{number}"
    if joint.type[0] > 1:  # a hinge or slide
        return np.array([q[name]]), np.array([v[name]])
    names = [f"{name}_r{letter}" for letter in "xyz"]
    angles = [q[hinge] for hinge in names]
    turns = [rotation_about(axis, angle) for axis, angle in zip(np.eye(3), angles, strict=True)]
    x, y, z = turns
    drawn = model.body(joint.bodyid[0])
    start = np.eye(3)
    if joint.type[0] == 0:
        start = rotation_from_quaternion(drawn.quat)
    qx, qy, qz, qw = quaternion(start @ x @ y @ z)
    rates = [v[hinge] for hinge in names]
    spin = z.T @ y.T @ [rates[0], 0, 0] + z.T @ [0, rates[1], 0] + [0, 0, rates[2]]
    turned = np.array([qw, qx, qy, qz])
    if joint.type[0] == 1:
        return turned, spin
    slides = [f"{name}_{letter}" for letter in "xyz"]
    position = drawn.pos + start @ [q[slide] for slide in slides]
    velocity = start @ [v[slide] for slide in slides]
    return np.concatenate([position, turned]), np.concatenate([velocity, spin])


@examples(30, phases=(Phase.explicit, Phase.generate))
@given(SEEDS)
def test_what_mujoco_saves_is_read_as_mujoco_reads_it(seed: int) -> None:
    spec = mujoco.MjSpec.from_string(RandomModel(seed).text())
    spec.compile()
    assert_moves_alike(spec.to_xml(), seed)


FLAT = """<mujoco model="fourbar">
  <compiler angle="radian"/>
  <default><joint damping="0.1"/><geom density="100"/></default>
  <worldbody>
    <body name="crank">
      <inertial pos="0.1 0 0" quat="0.707107 0 -0.707107 0" mass="0.0284838"
        diaginertia="0.000125362 0.000125362 5.56271e-06"/>
      <joint name="a" axis="0 1 0"/>
      <geom size="0.02 0.1" pos="0.1 0 0" quat="0.707107 0 -0.707107 0" type="capsule"/>
      <body name="coupler" pos="0.2 0 0">
        <inertial pos="0.25 0 0" mass="1" diaginertia=".001 .021 .021"/>
        <joint name="b" axis="0 1 0"/>
      </body>
    </body>
    <body name="rocker" pos="0.45 0 0">
      <inertial pos="0.125 0 0" quat="0.707107 0 -0.707107 0" mass="0.034767"
        diaginertia="0.000225945 0.000225945 6.81935e-06"/>
      <joint name="c" axis="0 1 0"/>
    </body>
  </worldbody>
  <equality><connect body1="coupler" body2="rocker" anchor="0.5 0 0"/></equality>
  <actuator><general joint="a"/></actuator>
</mujoco>
"""
LEANING = FLAT.replace('pos="0.45 0 0"', 'pos="0.55 0 -0.2" euler="0 0.1 0"')


@pytest.mark.parametrize("text", [FLAT, LEANING], ids=["drawn flat", "drawn leaning"])
def test_a_loop_between_bodies_falls_as_with_rigid_loops_in_mujoco(text: str) -> None:
    """Accelerations at rest from MuJoCo's matrices, its loop held by multipliers."""
    robot = Robot(described(text))
    assert robot.active == ("a",)
    state = robot.close(robot.reference)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    for name, value in zip(robot.coordinates, state.s, strict=True):
        data.qpos[model.joint(name).qposadr[0]] = value
    mujoco.mj_fwdPosition(model, data)
    mujoco.mj_fwdVelocity(model, data)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    assert np.abs(data.efc_pos).max() < 1e-9
    J = data.efc_J.reshape(-1, model.nv)
    kkt = np.block([[mass, J.T], [J, np.zeros((len(J), len(J)))]])
    force = np.concatenate([data.qfrc_passive - data.qfrc_bias, np.zeros(len(J))])
    expected = np.linalg.lstsq(kkt, force, rcond=1e-12)[0][: model.nv]
    a = model.joint("a").dofadr[0]
    assert robot.forward_dynamics(state, [0.0]) == pytest.approx([expected[a]], rel=1e-6)


BALL_AND_FREE = """<mujoco><worldbody>
<body name="base" pos="0 0 1" euler="20 30 40"><freejoint name="root"/><geom size=".1"/>
<body name="leg"><joint name="hip" type="ball"/><geom type="capsule" size=".02 .1"/></body>
</body></worldbody>
<keyframe><key qpos="QPOS"/></keyframe></mujoco>"""


@pytest.mark.parametrize(
    "qpos", ["1 2 3 .9 .1 .2 .3 -.9 .1 .4 0", "1 2 3 0 0 0 0 0 0 0 0"], ids=["turned", "zeros"]
)
def test_a_keyframe_is_the_pose_that_mujoco_makes_of_it(qpos: str) -> None:
    text = BALL_AND_FREE.replace("QPOS", qpos)
    pair = Pair(text)
    mujoco.mj_resetDataKeyframe(pair.model, pair.data, 0)
    mujoco.mj_fwdPosition(pair.model, pair.data)
    pair.assert_poses(pair.tree.close(pair.tree.reference))


ALIGNED = """<mujoco>COMPILER<worldbody>
<body name="base" pos="0 0 1" euler="20 30 40"><freejoint name="root" ALIGN/>
<geom type="box" size=".1 .2 .3" pos=".1 .2 -.3" euler="40 10 70"/>
<site name="mark" pos=".3 0 .1"/></body>
</worldbody>
<keyframe><key qpos="1 2 3 .9 .1 .2 .3"/></keyframe></mujoco>"""


@pytest.mark.parametrize(
    ("compiler", "align"),
    [("", 'align="true"'), ('<compiler alignfree="true"/>', ""), ("", 'align="false"')],
)
def test_free_bodies_are_aligned_with_their_inertia_as_mujoco_does(
    compiler: str, align: str
) -> None:
    pair = Pair(ALIGNED.replace("COMPILER", compiler).replace("ALIGN", align))
    mujoco.mj_resetDataKeyframe(pair.model, pair.data, 0)
    mujoco.mj_fwdPosition(pair.model, pair.data)
    state = pair.tree.close(pair.tree.reference)
    pair.assert_poses(state)
    (link,) = (link for link in pair.tree.description.links.values() if link.mass)
    is_aligned = bool(compiler) or "true" in align
    assert (np.abs(link.com).max() < 1e-12) == is_aligned
