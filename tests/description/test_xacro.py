"""Xacro files are expanded where they are named so, and can reach nothing outside."""

from __future__ import annotations

import os
import runpy
from pathlib import Path

import pytest

from hybrid_dynamics_core import DescriptionError, InputError, load
from hybrid_dynamics_core.formats.output_files import source_files
from hybrid_dynamics_core.formats.packages import PackageError, Packages
from hybrid_dynamics_core.formats.xacro import expand
from tests.cli.calling import call

pytest.importorskip("xacro")

NAMESPACE = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
ROBOT = f"""\
<robot name="r" {NAMESPACE}>
  <xacro:arg name="prefix" default="a_"/>
  <xacro:arg name="mass" default="2"/>
  <xacro:property name="m" value="$(arg mass)"/>
  <xacro:include filename="$(find parts)/urdf/arm.xacro"/>
  <link name="base"/>
  <xacro:arm name="$(arg prefix)1" parent="base" mass="${{m}}"/>
  <xacro:arm name="$(arg prefix)2" parent="$(arg prefix)1" mass="${{2*m}}"/>
</robot>
"""
ARM = f"""\
<robot {NAMESPACE}>
  <xacro:macro name="arm" params="name parent mass">
    <link name="${{name}}"><inertial><mass value="${{mass}}"/><origin xyz="0.1 0 0"/>
      <inertia ixx="0.1" iyy="0.2" izz="0.2" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="${{name}}_joint" type="revolute"><parent link="${{parent}}"/>
      <child link="${{name}}"/><origin xyz="0 0 ${{sqrt(0.04)}}"/><axis xyz="0 1 0"/>
      <limit lower="${{-pi/2}}" upper="1" effort="10" velocity="1"/></joint>
  </xacro:macro>
</robot>
"""


def package(folder: Path, name: str, text: str = ARM, file: str = "arm.xacro") -> Path:
    """A package with one file."""
    (folder / "urdf").mkdir(parents=True)
    (folder / "package.xml").write_text(f"<package><name>{name}</name></package>", "utf-8")
    (folder / "urdf" / file).write_text(text, encoding="utf-8")
    return folder / "urdf" / file


@pytest.fixture(autouse=True)
def _no_ros(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)


@pytest.fixture(name="robot")
def robot_file(tmp_path: Path) -> Path:
    """A robot in a package, with a macro in the package beside it."""
    package(tmp_path / "the_arm", "parts")  # its folder has another name
    return package(tmp_path / "robot", "robot", ROBOT, "r.urdf.xacro")


def small(folder: Path, inside: str, file: str = "small.xacro") -> Path:
    """A file with a few elements before a robot that is right."""
    text = f"""\
<robot name="r" {NAMESPACE}>
  {inside}
  <link name="base"/><link name="a"/>
  <joint name="q" type="continuous"><parent link="base"/><child link="a"/></joint>
</robot>
"""
    path = folder / file
    path.write_text(text, encoding="utf-8")
    return path


def test_macros_arguments_and_expressions_make_a_robot(robot: Path) -> None:
    plain = load(robot)
    assert list(plain.description.joints) == ["a_1_joint", "a_2_joint"]
    given = load(robot, xacro_args={"prefix": "left/", "mass": 3})
    assert given.active == ("left/1_joint", "left/2_joint")
    assert [link.mass for link in given.description.links.values()][-2:] == [3.0, 6.0]
    joint = given.description.joints["left/1_joint"]
    assert joint.limits == (pytest.approx(-1.5707963267948966), 1.0)
    assert joint.translation.tolist() == [0.0, 0.0, 0.2]
    files = {Path(file).name for file in given.description.files.values()}
    assert files == {"arm.xacro"}


def test_included_files_without_a_link_are_files_of_the_robot_too(tmp_path: Path) -> None:
    """So none of them is overwritten by what is made of it."""
    numbers = f'<robot {NAMESPACE}><xacro:property name="k" value="1"/></robot>'
    (tmp_path / "numbers.xacro").write_text(numbers, encoding="utf-8")
    robot = load(small(tmp_path, '<xacro:include filename="numbers.xacro"/>'))
    names = sorted(file.name for file in source_files(robot.description))
    assert names == ["numbers.xacro", "small.xacro"]


def test_every_verb_takes_arguments(robot: Path) -> None:
    answer = call("info", str(robot), "--xacro-arg", "prefix:=b_")
    assert "b_1_joint" in answer.stdout
    wrong = call("info", str(robot), "--xacro-arg", "prfix:=b_")
    assert wrong.exit_code == 2
    assert "--xacro-arg: " in wrong.output
    assert "did you mean 'prefix'?" in wrong.output


def test_a_description_may_name_a_xacro_file(robot: Path, tmp_path: Path) -> None:
    file = robot.parent / "r.yaml"
    file.write_text(
        "{format: 1, name: r, urdf: {file: 'package://robot/urdf/r.urdf.xacro',"
        " xacro_args: {prefix: c_, mass: 4}}, active: [c_1_joint, c_2_joint],"
        " end_effector: {link: c_2}}",
        encoding="utf-8",
    )
    assert load(file).description.links["c_1"].mass == 4.0
    assert load(file, xacro_args={"mass": 5}).description.links["c_1"].mass == 5.0
    file.write_text(
        "{format: 1, name: r, urdf: ../../secret.urdf, active: [q], end_effector: {link: a}}",
        encoding="utf-8",
    )
    small(tmp_path, "", "secret.urdf")
    with pytest.raises(DescriptionError, match=r"r.yaml:1: urdf: .* is not below"):
        load(file)


def test_errors_name_file_and_line_of_what_was_written(robot: Path) -> None:
    with pytest.raises(DescriptionError) as caught:
        load(robot, xacro_args={"mass": "heavy"})
    assert "arm.xacro:3" in str(caught.value)
    assert "mass" in str(caught.value)
    robot.write_text(ROBOT.replace("${m}", "${m*k}"), encoding="utf-8")
    with pytest.raises(DescriptionError, match=r"r.urdf.xacro:7: xacro: .*'k' is not defined"):
        load(robot)


def test_other_names_are_not_expanded(robot: Path) -> None:
    other = robot.with_name("r.urdf")
    other.write_text(ROBOT, encoding="utf-8")
    with pytest.raises(DescriptionError, match=r"name ends in \.xacro"):
        load(other)
    with pytest.raises(InputError, match="no xacro file"):
        load("five_bar", xacro_args={"a": 1})


# -- packages


def test_packages_are_where_the_file_leads_to(tmp_path: Path, monkeypatch) -> None:
    file = package(tmp_path / "ws" / "robot", "robot_description", "", "r.urdf")
    beside = package(tmp_path / "ws" / "src_a", "a").parent.parent
    installed = package(tmp_path / "prefix" / "share" / "b", "b").parent.parent
    given = package(tmp_path / "more" / "src_c", "c").parent.parent
    by_name = tmp_path / "more" / "d"
    by_name.mkdir()
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"/nowhere:{tmp_path / 'prefix'}")
    packages = Packages(file, [tmp_path / "more"])
    expected = {"robot_description": file.parent.parent, "a": beside, "b": installed, "c": given}
    assert {name: packages.find(name) for name in expected} == expected
    assert packages.find("d") == by_name
    assert packages.resolve("package://a/urdf/arm.xacro") == beside / "urdf" / "arm.xacro"
    with pytest.raises(PackageError) as caught:
        packages.find("e")
    for searched in (file.parent, tmp_path / "ws" / "robot", "/nowhere", tmp_path / "more"):
        assert str(searched) in str(caught.value)
    with pytest.raises(PackageError, match="no name of a package"):
        packages.find("../more/d")


def test_a_missing_package_names_what_was_searched(robot: Path, tmp_path: Path) -> None:
    robot.write_text(ROBOT.replace("find parts", "find prts"), encoding="utf-8")
    with pytest.raises(DescriptionError, match=r"r.urdf.xacro:5: xacro: .*'prts'; searched: "):
        load(robot)
    (tmp_path / "the_arm").rename(tmp_path / "elsewhere")
    (tmp_path / "far").mkdir()
    (tmp_path / "elsewhere").rename(tmp_path / "far" / "elsewhere")
    robot.write_text(ROBOT, encoding="utf-8")
    with pytest.raises(DescriptionError, match=r"AMENT_PREFIX_PATH \(not set\)"):
        load(robot)
    assert load(robot, search_path=tmp_path / "far").active == ("a_1_joint", "a_2_joint")
    assert call("info", str(robot), "--search-path", str(tmp_path / "far")).exit_code == 0


# -- what a file must not do


HARMFUL = {
    "classes": "${().__class__.__base__}",
    "inside a lambda": "${(lambda: ().__class__)()}",
    "a frame": "${[g.gi_frame for g in [(x for x in [1])]]}",
    "globals by a format": "${'{0.__globals__}'.format(load_yaml)}",
    "a made format": "${('{0.' + '_' + '_globals_' + '_}').format(load_yaml)}",
    "vars": "${python.vars(load_yaml)}",
    "builtins": "${open('/etc/passwd')}",
    "substitution": "$(eval open('/etc/passwd').read())",
    "dunder substitution": "$(eval ''.join([]).__class__)",
    "environment": "$(env HOME)",
    "yaml outside": "${xacro.load_yaml('/etc/passwd')}",
    "yaml above": "${xacro.load_yaml('../../../secret.yaml')}",
}


@pytest.mark.parametrize("expression", HARMFUL.values(), ids=HARMFUL.keys())
def test_expressions_reach_nothing_outside(expression: str, tmp_path: Path) -> None:
    file = small(tmp_path, f'<link name="{expression}"/>')
    with pytest.raises(DescriptionError) as caught:
        load(file)
    assert "root:" not in str(caught.value)
    assert os.environ["HOME"] not in str(caught.value).replace(str(tmp_path), "")


OUTSIDE = {
    "above": "../outside.xacro",
    "absolute": "/etc/hostname",
    "a device": "/dev/zero",
    "a link": "link.xacro",
    "a pattern": "/etc/*",
}


@pytest.mark.parametrize("name", OUTSIDE.values(), ids=OUTSIDE.keys())
def test_includes_stay_below_the_folder(name: str, tmp_path: Path) -> None:
    small(tmp_path, "", "outside.xacro")
    folder = tmp_path / "inside"
    folder.mkdir()
    (folder / "link.xacro").symlink_to(tmp_path / "outside.xacro")
    file = small(folder, f'<xacro:include filename="{name}"/>')
    with pytest.raises(DescriptionError, match=r"small.xacro:2: xacro: .*is not below"):
        load(file)
    assert load(small(folder, '<xacro:include filename="none.xacro" optional="true"/>')).active


BOMBS = {
    "power": ('<link name="${9**9**9}"/>', "too long|memory"),
    "loop": ('<link name="${[x for x in range(10**12) if x == -1]}"/>', "too long"),
    "memory": ("<link name=\"${'a' * 10**10}\"/>", "memory"),
    "itself": (
        '<xacro:macro name="m" params=""><xacro:m/></xacro:macro><xacro:m/>',
        "without end",
    ),
    "include of itself": ('<xacro:include filename="small.xacro"/>', "without end|more than"),
    "entities": ('<xacro:include filename="entities.xacro"/>', "document type"),
}


@pytest.mark.parametrize(("inside", "words"), BOMBS.values(), ids=BOMBS.keys())
def test_bombs_are_refused(
    inside: str, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(expand, "_MAX_COMPUTING", 1)
    entities = '<!DOCTYPE r [<!ENTITY a "aaaa">]><robot>&a;</robot>'
    (tmp_path / "entities.xacro").write_text(entities, encoding="utf-8")
    with pytest.raises(DescriptionError, match=words):
        load(small(tmp_path, inside))


def test_the_environment_is_not_read_and_that_is_noted(tmp_path: Path) -> None:
    file = small(
        tmp_path,
        '<link name="$(optenv HOME b)"/><joint name="f" type="fixed">'
        '<parent link="a"/><child link="b"/></joint>',
    )
    notes = load(file).description.notes
    assert any("$(optenv HOME): the environment is not read; taken: 'b'" in n for n in notes)


def test_files_of_a_package_are_found_before_it_is_installed(tmp_path: Path) -> None:
    """CMake installs description/urdf of the package `arms` as share/arms/urdf."""
    package = tmp_path / "arms"
    (package / "description" / "urdf").mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>arms</name></package>", encoding="utf-8")
    part = '<robot><link name="b"/></robot>'
    (package / "description" / "urdf" / "b.xacro").write_text(part, encoding="utf-8")
    file = small(
        package / "description" / "urdf",
        '<xacro:include filename="$(find arms)/urdf/b.xacro"/><joint name="f" type="fixed">'
        '<parent link="a"/><child link="b"/></joint>',
    )
    notes = load(file).description.notes
    assert any("is there once its package is installed; read:" in note for note in notes)
    (package / "other" / "urdf").mkdir(parents=True)
    (package / "other" / "urdf" / "b.xacro").write_text(part, encoding="utf-8")
    with pytest.raises(DescriptionError, match=r"there is no file .*urdf/b\.xacro"):
        load(file)


def test_a_missing_package_is_told_in_words_alone(tmp_path: Path) -> None:
    file = small(tmp_path, '<xacro:include filename="$(find nobody)/a.xacro"/>')
    with pytest.raises(DescriptionError, match="xacro: there is no package 'nobody'; searched:"):
        load(file)


def test_expressions_in_other_files_are_told_what_they_are(tmp_path: Path) -> None:
    file = tmp_path / "arm.urdf"
    file.write_text(
        '<robot name="r"><link name="a"/><link name="b"/>\n<joint name="j" type="continuous">\n'
        '<parent link="a"/><child link="b"/><origin xyz="$(optenv A 0 0 1)"/></joint></robot>',
        encoding="utf-8",
    )
    with pytest.raises(
        DescriptionError, match=r"an expression of xacro: .* \.urdf\.xacro"
    ) as caught:
        load(file)
    assert caught.value.line == 3


def test_a_file_named_as_xml_is_read_as_xml(tmp_path: Path) -> None:
    file = tmp_path / "arm.sdf"
    file.write_text('?xml version="1.0"?>\n<sdf version="1.9"/>', encoding="utf-8")
    with pytest.raises(DescriptionError, match="XML"):
        load(file)


def test_without_the_library_a_sentence_says_what_to_install(
    robot: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(expand, "find_spec", lambda _: None)
    with pytest.raises(DescriptionError, match="pip install xacro"):
        load(robot)


def test_a_file_of_macros_alone_is_no_robot(robot: Path) -> None:
    macros = robot.parents[2] / "the_arm" / "urdf" / "arm.xacro"
    with pytest.raises(
        DescriptionError, match=r"arm.xacro:1: there are no links; a file of macros"
    ):
        load(macros)


def test_sdformat_and_mjcf_may_be_xacro_files(tmp_path: Path) -> None:
    mjcf = tmp_path / "arm.mjcf.xacro"
    mjcf.write_text(
        f'<mujoco {NAMESPACE}><xacro:property name="m" value="2"/><worldbody><body name="a">'
        '<joint name="q" type="hinge" axis="0 1 0"/><inertial pos="0.1 0 0" mass="${2*m}"'
        ' diaginertia="1 1 1"/></body></worldbody></mujoco>',
        encoding="utf-8",
    )
    assert load(mjcf).description.links["a"].mass == 4.0
    sdf = tmp_path / "arm.sdf.xacro"
    sdf.write_text(
        f'<sdf version="1.9" {NAMESPACE}><xacro:arg name="m" default="2"/><model name="arm">'
        '<link name="base"/><link name="a"><inertial><mass>${2*$(arg m)}</mass></inertial></link>'
        '<joint name="f" type="fixed"><parent>world</parent><child>base</child></joint>'
        '<joint name="q" type="revolute"><parent>base</parent><child>a</child>'
        "<axis><xyz>0 1 0</xyz></axis></joint></model></sdf>",
        encoding="utf-8",
    )
    assert load(sdf, xacro_args={"m": 3}).description.links["a"].mass == 6.0


def test_a_robot_that_cannot_move_has_no_limits(tmp_path: Path) -> None:
    file = tmp_path / "stand.urdf"
    file.write_text(
        '<robot name="stand"><link name="base"/><link name="plate"/><joint name="f" type="fixed">'
        '<parent link="base"/><child link="plate"/></joint></robot>',
        encoding="utf-8",
    )
    assert load(file).limits.shape == (0, 2)


@pytest.mark.parametrize("form", ["yaml", "json", "xacro"])
def test_files_with_faults_are_read_or_refused(form: str, tmp_path: Path, monkeypatch) -> None:
    """The short form of tools/mutated_files.py."""
    monkeypatch.setattr(expand, "_MAX_COMPUTING", 1)
    tool = runpy.run_path(str(Path(__file__).parents[2] / "tools" / "mutated_files.py"))
    right = tool["texts"](form)
    mutation = tool["Mutation"](form, seed=1)
    file = tmp_path / f"r.{form}"
    file.write_text(right[0], encoding="utf-8")
    assert tool["outcome"](file) == "read"
    for _ in range(4):
        text = mutation.changed(mutation.random.choice(right))
        file.write_text(text, encoding="utf-8", errors="surrogatepass")
        assert tool["outcome"](file) in ("read", "refused"), text
