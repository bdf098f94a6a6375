"""Packages of ros2_control: numbers of the library, commands within limits, files that fit."""

from __future__ import annotations

import shutil
import tempfile
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from hypothesis import given

from hybrid_dynamics_cli.app import app
from hybrid_dynamics_core import InputError, load
from hybrid_dynamics_core.export import to_ros2_control
from hybrid_dynamics_core.formats.c.states import random_states
from hybrid_dynamics_core.formats.output_files import write_folder
from hybrid_dynamics_core.formats.ros2_control.sides import sides_of
from tests.generated.case import Case
from tests.generated.class_three import class_three
from tests.generated.robots import examples
from tests.sampling import swept

from .c_builds import WARNINGS, needs_compiler, run

ROBOTS = swept(("five_bar", "excavator", "forging_chu2020", "staicu2015"), ("five_bar",))
JOINTS = {  # from the base to the end effector, those that move independently
    "ankle": ("pitch", "roll"),
    "delta": ("x", "y", "z", "q4"),
    "excavator": ("slew", "boom_pitch", "stick_pitch", "bucket_pitch"),
    "forging_chu2020": ("q1", "q2", "q3", "q4"),
    "type_c": ("q1", "q2", "q4"),
    "type_d": ("q1", "p2", "p4", "q4"),
}
PLUGINS = {"transmission": "transmission", "controller": "feed_forward_controller"}


@cache
def texts_of(name: str) -> dict[str, str]:
    return to_ros2_control(load(name))


def written(name: str, folder: Path) -> Path:
    """The folder of a shipped robot's package."""
    place = folder / "package"
    write_folder(texts_of(name), place)
    return place


def built(folder: Path, main: str) -> Path:
    """A program of the numeric core, compiled without a warning."""
    objects = []
    for source in sorted((folder / "src").glob("*.c")):
        objects.append(f"{source.stem}.o")
        run(folder, "gcc", "-std=c99", "-O0", "-Iinclude", "-c", str(source), "-o", objects[-1])
    flags = ("-std=c++17", "-O0", *WARNINGS, "-Iinclude")
    run(folder, "g++", *flags, main, *objects, "-lm", "-o", "program")
    return folder / "program"


@needs_compiler
@pytest.mark.parametrize("name", ROBOTS)
def test_numbers_are_those_of_the_library(name: str, tmp_path: Path) -> None:
    """Positions, rates and efforts both ways, and efforts of the controller on both sides."""
    folder = written(name, tmp_path)
    assert run(folder, str(built(folder, "test/test_core.cpp"))) == "10 of 10 as the library\n"


@needs_compiler
@pytest.mark.sweep(sample="test_numbers_are_those_of_the_library")
def test_other_numbers_are_noticed(tmp_path: Path) -> None:
    folder = written("five_bar", tmp_path)
    model = folder / "include/five_bar_ros2_control/model.hpp"
    text = model.read_text(encoding="utf-8")
    assert "JOINTS{{0, 3, 2}}" in text
    model.write_text(text.replace("JOINTS{{0, 3, 2}}", "JOINTS{{0, 4, 2}}"), encoding="utf-8")
    program = built(folder, "test/test_core.cpp")
    with pytest.raises(AssertionError, match="0 of 10 as the library"):
        run(folder, str(program))


@pytest.mark.parametrize("name", ROBOTS)
def test_files_of_a_package_fit_together(name: str) -> None:
    texts = texts_of(name)
    package = f"{name}_ros2_control"
    manifest = ElementTree.fromstring(texts["package.xml"])
    assert manifest.findtext("name") == package
    cmake = texts["CMakeLists.txt"]
    needed = [element.text for element in manifest.findall("depend")]
    assert all(f"{dependency}::{dependency}" in cmake for dependency in needed)
    for path in (path for path in texts if path.startswith("src/")):
        assert path in cmake
    for kind, source in PLUGINS.items():
        description = texts.get(f"{kind}_plugins.xml")
        if description is None:
            assert name == "staicu2015"  # no masses, no efforts
            continue
        plugin = ElementTree.fromstring(description).find("class")
        exported = f"{plugin.get('type')}, {plugin.get('base_class_type')})"
        assert exported in " ".join(texts[f"src/{source}.cpp"].split())
        assert f"{kind}_plugins.xml)" in cmake


@pytest.mark.parametrize("name", ROBOTS)
def test_the_example_names_joints_drives_and_plugins(name: str) -> None:
    texts, robot = texts_of(name), load(name)
    joints = list(sides_of(robot).joints.active)
    root = ElementTree.fromstring(texts[f"urdf/{name}.urdf"])
    block = root.find("ros2_control")
    tree = {joint.get("name"): joint.get("type") for joint in root.findall("joint")}
    controlled = [joint.get("name") for joint in block.findall("joint")]
    assert controlled == joints
    assert all(tree[joint] != "fixed" for joint in controlled)
    transmission = block.find("transmission")
    assert transmission.findtext("plugin") == f"{name}_ros2_control/Transmission"
    assert [x.get("role") for x in transmission.findall("joint")] == joints
    assert [x.get("role") for x in transmission.findall("actuator")] == list(robot.active)
    settings = yaml.safe_load(texts["config/controllers.yaml"])
    trajectory = settings["trajectory"]["ros__parameters"]
    assert trajectory["joints"] == joints
    manager = settings["controller_manager"]["ros__parameters"]
    if "feed_forward" in settings:
        assert trajectory["command_joints"] == [f"feed_forward/{joint}" for joint in joints]
        assert manager["feed_forward"]["type"] == f"{name}_ros2_control/FeedForwardController"
    else:
        assert trajectory["command_joints"] == joints


@pytest.mark.parametrize("name", swept(JOINTS, ("type_d",)))
def test_joints_are_those_of_the_serial_arm(name: str) -> None:
    assert sides_of(load(name)).joints.active == JOINTS[name]


@needs_compiler
@pytest.mark.sweep(sample="test_numbers_are_those_of_the_library")
def test_it_builds_without_ros(tmp_path: Path) -> None:
    if shutil.which("cmake") is None:
        pytest.skip("there is no cmake")
    folder = written("five_bar", tmp_path)
    run(folder, "cmake", "-S", ".", "-B", "build", "-DCMAKE_DISABLE_FIND_PACKAGE_ament_cmake=ON")
    run(folder, "cmake", "--build", "build")
    assert "100% tests passed" in run(folder, "ctest", "--test-dir", "build")


ARM = """<robot name="arm">
  <link name="base"/>
  <link name="a"><inertial><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="b"><inertial><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="arm/q-1" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="10" velocity="2"/></joint>
  <joint name="2nd" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="5" velocity="4"/></joint>
</robot>
"""
COMMANDS = """
#include <cstdio>
#include <limits>
#include "arm_ros2_control/core.hpp"
using namespace arm_ros2_control;
int main()
{
  const double none = std::numeric_limits<double>::quiet_NaN();
  Values joints, drives;
  joints.has_position = joints.has_velocity = joints.has_effort = true;
  joints.position = {2.0, 0.5};
  joints.velocity = {4.0, 4.0};
  joints.effort = {-20.0, 3.0};
  TransmissionCore limited, free(false);
  const auto show = [](int status, const Values & x) {
    std::printf("%d: %g %g, %g %g, %g %g; %d%d%d\\n", status, x.position[0], x.position[1],
      x.velocity[0], x.velocity[1], x.effort[0], x.effort[1], x.has_position, x.has_velocity,
      x.has_effort);
  };
  int status = limited.to_drives(joints, drives);
  show(status, drives);
  status = free.to_drives(joints, drives);
  show(status, drives);
  joints.position[1] = joints.velocity[0] = none;
  status = free.to_drives(joints, drives);
  std::printf("%d: %d%d%d\\n", status, drives.has_position, drives.has_velocity, drives.has_effort);
  Values measured, along;
  measured.has_position = true;
  measured.position = {none, 0.0};
  along.position = {7.0, 7.0};
  status = free.to_joints(measured, along);
  std::printf("%s: %g\\n", status_text(status), along.position[0]);
  Vector efforts{};
  FeedForwardCore controller(false);
  status = controller.compute({}, {}, {100.0, 1.0}, efforts);
  std::printf("%d: %g %g\\n", status, efforts[0], efforts[1]);
  return 0;
}
"""
SHOWN = """\
0: 1 0.5, 2 2, -10 3; 111
0: 2 0.5, 4 4, -20 3; 111
0: 001
an argument or a result is not a finite number: 7
0: 10 1
"""


@needs_compiler
@pytest.mark.sweep(sample="test_numbers_are_those_of_the_library")
def test_commands_stay_within_limits_and_none_is_none(tmp_path: Path) -> None:
    """Velocities keep their direction; what is not finite is no command, and no measurement."""
    file = tmp_path / "arm.urdf"
    file.write_text(ARM, encoding="utf-8")
    folder = tmp_path / "package"
    write_folder(to_ros2_control(load(file)), folder)
    (folder / "commands.cpp").write_text(COMMANDS, encoding="utf-8")
    assert run(folder, str(built(folder, "commands.cpp"))) == SHOWN


BAD = {
    "plugin": ("five_bar", ["--programs", "transmision"], "there is no plugin 'transmision'"),
    "none": ("five_bar", ["--programs", ","], "no plugin is named"),
    "masses": ("staicu2015", ["--programs", "feed_forward"], "staicu2015: no link has a mass"),
    "joint": ("five_bar", ["--joints", "q_L,q_R,x"], "there is no joint 'x'"),
    "few": ("five_bar", ["--joints", "q_L,q_R"], "do not determine the motion; expected 3"),
    "dependent": ("type_c", ["--joints", "q1,q2,q3"], "do not determine the motion"),
    "others": ("five_bar", ["-o", "others"], "others: has other files, such as src/notes.txt"),
    "parent": ("five_bar", ["-o", "none/new"], "new: there is no folder none"),
    "real": ("five_bar", ["--real", "float"], "--real belongs to --format c"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_writes_nothing(case: str, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("others/src").mkdir(parents=True)
    Path("others/src/notes.txt").write_text("mine", encoding="utf-8")
    before = sorted(tmp_path.rglob("*"))
    name, words, wanted = BAD[case]
    place = [] if "-o" in words else ["-o", "new"]
    said = CliRunner().invoke(app, ["export", name, "--format", "ros2_control", *place, *words])
    assert said.exit_code == 2
    assert wanted in said.output
    assert sorted(tmp_path.rglob("*")) == before


def test_a_coordinate_without_a_drive_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "cart.yaml"
    file.write_text(CART, encoding="utf-8")
    with pytest.raises(InputError, match=r"one drive for each .* \(x, th\); the drives are x"):
        to_ros2_control(load(file))


CART = """format: 1
name: cart
active_set: motors
links:
  base: {}
  cart: {mass: 1}
  pole: {mass: 0.2, com: [0, 0, 0.5], inertia: {rod: {axis: z, length: 1}}}
joints:
  x: {type: prismatic, parent: base, child: cart, axis: x}
  th: {type: revolute, parent: cart, child: pole, axis: y}
active: [x]
end_effector: {link: pole}
"""


@examples(24)
@given(class_three())
def test_both_sides_of_random_robots_are_one_motion(case: Case) -> None:
    """The same places and rates from the joints as from the drives, and the same power."""
    robot = case.robot
    try:
        sides = sides_of(robot)
    except InputError as error:
        assert "one drive for each" in str(error)  # noqa: PT017 - nothing else is refused
        return
    rng = np.random.default_rng(0)
    order = sides.order
    for _, state in random_states(robot, 5, rng):
        rates = state.R[sides.joints_in_drives]
        if np.linalg.cond(rates) > 1e3:
            continue
        near = sides.joints.close(sides.joints.reference)
        back = sides.joints.close(
            state.s[sides.joints_in_drives], rates @ state.du, near=near, check=False
        )
        if not back.singularity > 0.05:  # assembly modes meet there
            continue
        assert back.status == 0
        assert np.abs(back.s - state.s[order]).max() <= 1e-9
        assert np.abs(back.ds - state.ds[order]).max() <= 1e-7
        tau = rng.uniform(-1.0, 1.0, state.n)
        forces = np.zeros(len(state.s))
        forces[sides.drives_in_joints] = tau
        along_joints = back.R.T @ forces
        power = tau @ state.du
        assert along_joints @ back.du == pytest.approx(power, abs=1e-7 * (1.0 + abs(power)))


@needs_compiler
@pytest.mark.timeout(900)
@pytest.mark.sweep(sample="test_both_sides_of_random_robots_are_one_motion")
@examples(6)
@given(class_three())
def test_packages_of_random_robots_have_the_numbers_of_the_library(case: Case) -> None:
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "package"
        write_folder(to_ros2_control(case.robot), folder)
        count = int(run(folder, str(built(folder, "test/test_core.cpp"))).split()[0])
        assert count <= 10


CRANK = """format: 1
name: crank
gravity: [0, 0, 0]
links:
  base: {}
  crank: {mass: 1, com: [0.1, 0, 0], inertia: {rod: {axis: x, length: 0.2}}}
  rod: {mass: 1, com: [0.25, 0, 0], inertia: {rod: {axis: x, length: 0.5}}}
  ram: {mass: 1}
joints:
  a: {type: revolute, parent: base, child: crank, axis: z}
  b: {type: revolute, parent: crank, child: rod, axis: z, origin: {xyz: [0.2, 0, 0]}}
  x: {type: prismatic, parent: base, child: ram, axis: x}
closures:
  cl: {kind: planar, between: {rod: [0.5, 0, 0], ram: [0, 0, 0]}}
active: [a]
end_effector: {link: ram}
reference: {a: 0.5, b: -0.7, x: 0.66}
"""
TOGGLE = """
#include <cstdio>
#include "crank_ros2_control/core.hpp"
using namespace crank_ros2_control;
int main()
{
  TransmissionCore core(false);
  Values drive, joint, back;
  drive.has_position = true;
  for (const double a : {0.5, 0.2, -0.2}) {
    drive.position = {a};
    drive.effort = {1.0};
    drive.has_effort = false;
    const int placed = core.to_joints(drive, joint);
    drive.has_effort = true;
    Values pushed;
    const int turned = core.to_joints(drive, pushed);
    const int commanded = core.to_drives(joint, back);
    std::printf("%d %.6f, %d, %d\\n", placed, joint.position[0], turned, commanded);
  }
  return 0;
}
"""


@needs_compiler
@pytest.mark.sweep(sample="test_numbers_are_those_of_the_library")
def test_behind_a_toggle_joints_do_not_determine_the_drives(tmp_path: Path) -> None:
    """The ram has the same place on both sides of the dead centre of its crank, a = 0."""
    file = tmp_path / "crank.yaml"
    file.write_text(CRANK, encoding="utf-8")
    folder = tmp_path / "package"
    write_folder(to_ros2_control(load(file)), folder)
    (folder / "toggle.cpp").write_text(TOGGLE, encoding="utf-8")
    said = run(folder, str(built(folder, "toggle.cpp"))).splitlines()
    jump = 3
    places = 0.2 * np.cos([0.5, 0.2]) + np.sqrt(0.25 - (0.2 * np.sin([0.5, 0.2])) ** 2)
    assert said[0] == f"0 {places[0]:.6f}, 0, 0"
    assert said[1] == f"0 {places[1]:.6f}, 0, 0"
    assert said[2] == f"0 {places[1]:.6f}, {jump}, {jump}"
