"""Each kind of measurement, and each kind of parameter, on a crank with a cylinder."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hybrid_dynamics_core import load
from hybrid_dynamics_core.calibration import calibrate, new_text
from hybrid_dynamics_core.calibration.quantities import rotation_vectors
from hybrid_dynamics_core.robot.robot import Robot
from tests.cli.calling import shipped_text
from tests.sampling import swept

from .crank import changed, columns, poses, write

EXACT = 1e-8  # [m, rad] of data without noise, by the step of the derivatives and the prior
NOISE = 5e-5  # [m]
PARAMETERS = {  # change of the file's text, path, true value
    "name": ({"reach": "reach: 0.802 "}, "reach", 0.802),
    "pin": ({"pin": "crank: [0.6, 0.003, 0]"}, "loops.lift.pin.crank[1]", 0.003),
    "pin by its place": ({"pin": "crank: [0.602, 0, 0]"}, "loops.lift.pin.arm[0]", 0.602),
    "origin": ({"foot": "xyz: [0.301, 0, -0.5]"}, "joints.pivot.origin.xyz[0]", 0.301),
    "offset left out": (
        {"turn": "child: column, axis: z, offset: 0.02"},
        "joints.turn.offset",
        0.02,
    ),
    "origin left out": (
        {"turn": "child: column, axis: z, origin: {xyz: [0, 0.004, 0]}"},
        "joints.turn.origin.xyz[1]",
        0.004,
    ),
    "tilt": (
        {"turn": "child: column, axis: z, origin: {rpy: [0.003, 0, 0]}"},
        "joints.turn.origin.rpy[0]",
        0.003,
    ),
    "axis of a letter": (
        {"turn": "child: column, axis: [0.01, 0, 1]"},
        "joints.turn.axis[0]",
        0.01,
    ),
    "tool": ({"tool": "xyz: [reach, 0, 0.001]}"}, "end_effector.xyz[2]", 0.001),
}


@pytest.mark.parametrize("case", swept(PARAMETERS, ("pin by its place", "axis of a letter")))
def test_a_parameter_is_found_from_points(tmp_path, case):
    texts, path, value = PARAMETERS[case]
    data = columns(changed(tmp_path, **texts), poses(12))
    result = calibrate(write(tmp_path), data, path, sigma=NOISE)
    assert result.parameters[path].value == pytest.approx(value, abs=EXACT)
    assert result.identifiable == {path: True}
    assert result.chi2 < 1e-6


KINDS = {
    "poses": (("points", "turns"), "reach, joints.turn.offset"),
    "other frames": (("marks",), "frames.mark.xyz[0], joints.turn.offset"),
    "distances": (("distances",), "reach, joints.turn.offset"),
    "inclinations": (("inclinations",), "joints.stroke.offset, loops.lift.pin.crank[0]"),
    "encoders": (("encoders",), "joints.stroke.offset, loops.lift.pin.crank[0]"),
}


@pytest.mark.parametrize("case", swept(KINDS, ("poses", "encoders")))
def test_a_kind_of_measurement_shows_its_parameters(tmp_path, case):
    kinds, free = KINDS[case]
    true = changed(
        tmp_path,
        reach="reach: 0.802 ",
        pin="crank: [0.598, 0, 0]",
        turn="child: column, axis: z, offset: 0.01",
    )
    nominal = ["reach", "joints.turn.offset", "joints.stroke.offset", "loops.lift.pin.crank[0]"]
    values = dict(zip(nominal, (0.802, 0.01, 0.0, 0.598), strict=True))
    values["frames.mark.xyz[0]"] = 0.3
    fixed = [name for name in nominal[:2] if name not in free]
    robot = write(tmp_path)
    if "loops" not in free:
        true = changed(tmp_path, reach="reach: 0.802 ", turn="child: column, axis: z, offset: 0.01")
    elif fixed:
        true = changed(tmp_path, pin="crank: [0.598, 0, 0]")
    result = calibrate(robot, columns(true, poses(15), kinds), free)
    for path, one in result.parameters.items():
        assert one.value == pytest.approx(values[path], abs=1e-6), path
        assert one.identifiable


def test_gains_and_the_pose_of_the_base_have_paths_of_their_own(tmp_path):
    true = changed(tmp_path)
    u = poses(20)
    data = columns(true, u)
    data["stroke"] = u[:, 1] / 1.01
    angle = 0.02
    x, y = data["tool.x"], data["tool.y"]
    data["tool.x"] = np.cos(angle) * x - np.sin(angle) * y + 0.1
    data["tool.y"] = np.sin(angle) * x + np.cos(angle) * y
    free = "joints.stroke.gain, base.xyz, base.rpy[2]"
    result = calibrate(write(tmp_path), data, free, sigma=NOISE)
    values = {name: one.value for name, one in result.parameters.items()}
    expected = {"joints.stroke.gain": 1.01, "base.xyz[0]": 0.1, "base.rpy[2]": angle}
    for name in ("base.xyz[1]", "base.xyz[2]"):
        expected[name] = 0.0
    assert values == pytest.approx(expected, abs=1e-6)


def test_other_coordinates_than_the_active_ones_may_be_given(tmp_path):
    true = changed(tmp_path, reach="reach: 0.802 ")
    u = poses(12)
    data = columns(true, u, ("points", "encoders"))
    del data["stroke"], data["pivot"]
    result = calibrate(write(tmp_path), data, "reach", sigma=NOISE)
    assert result.parameters["reach"].value == pytest.approx(0.802, abs=EXACT)


def test_what_cannot_be_seen_apart_is_named(tmp_path):
    data = columns(changed(tmp_path, reach="reach: 0.802 "), poses(12), noise=NOISE)
    free = "reach, end_effector.xyz[0], links.crank.mass, joints.turn.offset"
    result = calibrate(write(tmp_path), data, free, sigma=NOISE)
    # the tool's place replaces `reach` in the file, and nothing depends on a mass
    assert not result.identifiable["reach"]
    assert not result.identifiable["links.crank.mass"]
    assert result.identifiable["joints.turn.offset"]
    named = {name for one in result.unseen for name in one.names}
    assert {"reach", "links.crank.mass"} <= named


def test_what_cannot_change_keeps_its_value_and_the_others_are_found(tmp_path):
    true = changed(tmp_path, foot="xyz: [0.301, 0, -0.5]")
    data = columns(true, poses(20), noise=NOISE)
    result = calibrate(write(tmp_path), data, "joints.pivot.origin.xyz, reach", sigma=NOISE)
    across = "joints.pivot.origin.xyz[1]"
    assert list(result.fixed) == [across]
    assert "along the loop's axis" in result.fixed[across]
    assert result.parameters[across].value == 0.0
    assert not result.identifiable[across]
    along = result.parameters["joints.pivot.origin.xyz[0]"]
    assert along.interval[0] < 0.301 < along.interval[1]


def test_two_offsets_about_one_axis_are_seen_only_together(tmp_path):
    data = columns(changed(tmp_path), poses(12), noise=NOISE)
    free = "joints.turn.offset, joints.turn.origin.rpy[2], reach"
    result = calibrate(write(tmp_path), data, free, sigma=NOISE)
    assert result.identifiable == {
        "joints.turn.offset": False,
        "joints.turn.origin.rpy[2]": False,
        "reach": True,
    }
    (combination,) = result.unseen
    changes = dict(combination.pairs)
    assert changes["joints.turn.offset"] == pytest.approx(-changes["joints.turn.origin.rpy[2]"])


def test_outliers_are_named_and_left_out(tmp_path):
    data = columns(changed(tmp_path, reach="reach: 0.802 "), poses(40), noise=NOISE)
    data["tool.y"][7] += 0.02
    data["tool.z"][21] -= 0.001
    robot = write(tmp_path)
    result = calibrate(robot, data, "reach, joints.turn.offset", sigma=NOISE)
    assert [one.line for one in result.outliers] == [8, 22]
    low, high = result.parameters["reach"].interval
    assert low < 0.802 < high
    assert result.chi2 < 1.5
    trusting = calibrate(robot, data, "reach, joints.turn.offset", sigma=NOISE, loss="linear")
    assert trusting.chi2 > 100.0
    robust = calibrate(robot, data, "reach, joints.turn.offset", sigma=NOISE, loss="huber")
    assert robust.parameters["reach"].value == pytest.approx(0.802, abs=1e-4)


@pytest.mark.parametrize("loss", ["reject", "huber"])
def test_many_outliers_do_not_hide_behind_an_estimated_noise(tmp_path, loss):
    data = columns(changed(tmp_path, reach="reach: 0.802 "), poses(60), noise=NOISE)
    signs = np.random.default_rng(2).choice([-1.0, 1.0], size=(3, 9))
    for axis, sign in zip("xyz", signs, strict=True):
        data[f"tool.{axis}"][:9] += 0.03 * sign
    result = calibrate(write(tmp_path), data, "reach, joints.turn.offset", loss=loss)
    assert [one.line for one in result.outliers] == list(range(1, 10))
    assert result.parameters["reach"].value == pytest.approx(0.802, abs=10.0 * NOISE)
    assert result.misfits["tool"].sigma == pytest.approx(NOISE, rel=0.3)


def test_a_row_with_weight_zero_does_not_count(tmp_path):
    data = columns(changed(tmp_path, reach="reach: 0.802 "), poses(12))
    data["tool.x"][3] = 5.0
    data["weight"] = np.where(np.arange(12) == 3, 0.0, 1.0)
    result = calibrate(write(tmp_path), data, "reach", sigma=NOISE, loss="linear")
    assert result.parameters["reach"].value == pytest.approx(0.802, abs=EXACT)


def test_cells_that_are_empty_were_not_measured(tmp_path):
    data = columns(changed(tmp_path, reach="reach: 0.802 "), poses(12))
    data["tool.x"][3] = np.nan
    data["tool.z"][:] = np.nan
    result = calibrate(write(tmp_path), data, "reach", sigma=NOISE)
    assert result.parameters["reach"].value == pytest.approx(0.802, abs=EXACT)


def test_noise_that_is_not_given_is_estimated(tmp_path):
    data = columns(changed(tmp_path), poses(200), ("points", "turns"), noise=NOISE)
    result = calibrate(write(tmp_path), data, "reach, joints.turn.offset")
    assert result.misfits["tool"].sigma == pytest.approx(NOISE, rel=0.15)
    assert result.chi2 == pytest.approx(1.0, abs=0.01)


LOOSE = ("level_1", "pin: {bar_1: [L2, 0, 0]", "pin: {bar_1: [1.1015, 0, 0]")


def test_a_bar_of_a_parallelogram_may_be_longer_than_the_other(tmp_path):
    text = shipped_text("palletizer")
    loop, old, new = LOOSE
    before, name, after = text.partition(f"  {loop}:")
    assert old in after
    true_text = before + name + after.replace(old, new, 1)
    line = next(part for part in true_text.splitlines() if new in part)
    true_text = true_text.replace(line, line.replace(", assembly: parallelogram", ""))
    path = tmp_path / "true.yaml"
    path.write_text(true_text, encoding="utf-8")
    true = load(str(path))
    low, high = np.array([[-1.0, 1.0, -0.6, -1.0], [1.0, 1.8, 0.2, 1.0]])
    u = np.random.default_rng(3).uniform(low, high, (30, 4))
    position = true.forward_kinematics(true.close(u)).position
    data = dict(zip(true.active, u.T, strict=True))
    data |= dict(zip(("tool.x", "tool.y", "tool.z"), position.T, strict=True))
    result = calibrate("palletizer", data, "loops.level_1.pin.bar_1[0], L3", sigma=NOISE)
    values = [one.value for one in result.parameters.values()]
    assert values == pytest.approx([1.1015, 1.2], abs=1e-7)
    new_path = tmp_path / "new.yaml"
    new_path.write_text(new_text(result), encoding="utf-8")
    for robot in (load(str(new_path)), Robot(result.description)):
        place = robot.forward_kinematics(robot.close(u)).position
        assert np.abs(place - position).max() < 1e-6


def test_a_parameter_of_one_leg_may_be_left_out_in_the_file(tmp_path):
    free = "modules.delta.parameters.angle[1], modules.delta.parameters.theta_0"
    nominal = load("delta")
    u = np.random.default_rng(2).uniform(0.0, 0.8, (12, 4))
    position = nominal.forward_kinematics(nominal.close(u)).position
    data = dict(zip(nominal.active, u.T, strict=True))
    data |= dict(zip(("tool.x", "tool.y", "tool.z"), position.T, strict=True))
    result = calibrate("delta", data, free, sigma=NOISE)
    angle = result.parameters["modules.delta.parameters.angle[1]"]
    assert angle.start == pytest.approx(2.0 * np.pi / 3.0)
    assert angle.value == pytest.approx(angle.start, abs=1e-9)
    # theta_0 only says where the joints count from
    assert not result.identifiable["modules.delta.parameters.theta_0"]
    path = tmp_path / "new.yaml"
    path.write_text(new_text(result), encoding="utf-8")
    assert "template: delta" in path.read_text(encoding="utf-8")
    load(str(path))


def test_rows_that_close_with_the_estimates_only_count_too(tmp_path):
    true = changed(tmp_path, pin="crank: [0.62, 0, 0]")
    u = poses(20)
    nominal = write(tmp_path)
    # the crank is stretched here: farther than the file's pin allows
    reachable = true.closing_range[1, 1]
    u[4, 1] = u[9, 1] = reachable - 0.002
    assert u[4, 1] > load(nominal).closing_range[1, 1]
    data = columns(true, u, noise=NOISE)
    result = calibrate(nominal, data, "loops.lift.pin.crank[0], reach", sigma=NOISE)
    low, high = result.parameters["loops.lift.pin.crank[0]"].interval
    assert low < 0.62 < high
    assert result.residuals.shape == (20, 3)
    assert not result.outliers


def test_offsets_of_joints_that_short_forms_stand_for_are_theirs(tmp_path):
    path = tmp_path / "floating.yaml"
    path.write_text(FLOATING, encoding="utf-8")
    robot = load(str(path))
    u = np.random.default_rng(1).uniform(-0.4, 0.4, (12, len(robot.active)))
    position = robot.forward_kinematics(robot.close(u)).position
    data = dict(zip(robot.active, u.T, strict=True))
    data |= dict(zip(("tool.x", "tool.y", "tool.z"), position.T, strict=True))
    free = "joints.floating_base_x.offset, joints.bend.offset"
    result = calibrate(str(path), data, free, sigma=NOISE)
    values = [one.value for one in result.parameters.values()]
    assert values == pytest.approx([0.0, 0.0], abs=EXACT)
    assert all(result.identifiable.values())


FLOATING = """\
format: 1
name: floating
base: body
floating: true
links:
  body: {mass: 5, inertia: {box: {size: [0.3, 0.2, 0.1]}}}
  arm: {mass: 1, com: [0.2, 0, 0], inertia: {rod: {axis: x, length: 0.4}}}
joints:
  bend: {type: revolute, parent: body, child: arm, axis: y}
active: [bend]
end_effector: {link: arm, xyz: [0.4, 0, 0]}
"""


@pytest.mark.parametrize("left", [0.0, 1e-14, 1e-9, 1e-5, 1.0, np.pi - 1e-3, np.pi])
def test_rotation_vectors_of_any_angle(left):
    random = np.random.default_rng(5)
    axes = np.concatenate([np.eye(3), random.normal(size=(20, 3))])
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    vectors = (np.pi - left) * axes
    found = rotation_vectors(Rotation.from_rotvec(vectors).as_matrix())
    if left < 1e-12:  # either way round
        found *= np.sign((found * vectors).sum(axis=1))[:, None]
    assert found == pytest.approx(vectors, abs=1e-8)
