"""Visuals of links: read from every format, kept by every export, never an obstacle."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import DescriptionError, Robot, load
from hybrid_dynamics_core.description.geometry import rpy_of
from hybrid_dynamics_core.description.model import RobotDescription, Visual
from hybrid_dynamics_core.export import to_mjcf, to_sdf, to_urdf, to_urdf_plus, to_yaml
from hybrid_dynamics_core.formats.mesh_files import MAX_BYTES
from hybrid_dynamics_core.formats.reader import parse_description, read_description
from hybrid_dynamics_core.formats.urdf.visuals import ELLIPSOID
from hybrid_dynamics_core.ground.file_options import file_options
from tests.mesh_files import CORNERS, write_mesh
from tests.sampling import examples

WRITERS = {
    "urdf": (to_urdf, ".urdf"),
    "urdf+": (to_urdf_plus, ".urdf"),
    "sdf": (to_sdf, ".sdf"),
    "mjcf": (to_mjcf, ".xml"),
    "yaml": (to_yaml, ".yaml"),
}
ARM = """\
format: 1
name: arm
links:
  base: {visuals: [{box: {size: [0.4, 0.4, 0.1]}, colour: "#808080"}]}
  upper:
    mass: 2
    com: [0.2, 0, 0]
    visuals:
      - {cylinder: {radius: 0.05, length: 0.4}, origin: {xyz: [0.2, 0, 0], rpy: [0, pi/2, 0]}}
      - {sphere: {radius: 0.07}, colour: [0.2, 0.3, 0.9, 0.5]}
      - {mesh: {file: meshes/part.stl, scale: 0.1}, origin: {xyz: [0.1, 0.2, 0.3], rpy: [1, 2, 3]}}
  tool: {visuals: [{capsule: {radius: 0.02, length: 0.1}, origin: {xyz: [0, 0, 0.05]}}]}
  lower:
    mass: 1
    visuals: [{ellipsoid: {radii: [0.1, 0.2, 0.3]}, colour: "#ff8000"}]
joints:
  q1: {type: revolute, parent: base, child: upper, axis: z}
  q2: {type: revolute, parent: upper, child: lower, axis: y, origin: {xyz: [0.4, 0, 0]}}
  t: {type: fixed, parent: lower, child: tool, origin: {xyz: [0.3, 0, 0], rpy: [0.3, 0.2, 0.1]}}
frames:
  lower: {link: lower, xyz: [0.01, 0.02, 0.03], rpy: [0.1, 0, 0]}
active: [q1, q2]
end_effector: {link: tool}
"""


def written(folder: Path, text: str, name: str = "arm.yaml") -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / name
    file.write_text(text, encoding="utf-8")
    return file


def arm(folder: Path) -> RobotDescription:
    write_mesh(folder / "meshes" / "part.stl")
    return read_description(written(folder, ARM))


def facts(robot: RobotDescription) -> list[tuple]:
    """Shape, sizes, place and colour of all visuals, in an order of their own."""
    rows = []
    for of_link in robot.visuals.values():
        rows += [fact(visual) for visual in of_link]
    return sorted(rows, key=lambda row: (row[0], row[1]))


def fact(visual: Visual) -> tuple:
    numbers = [*visual.size, *visual.frame.translation, *visual.frame.rotation.ravel()]
    colour = tuple(np.round(visual.colour, 9)) if visual.colour else ()
    return visual.shape, visual.frame.link, tuple(np.round(numbers, 9)), colour, visual.file


# -- exports


@pytest.mark.parametrize("form", WRITERS)
@pytest.mark.parametrize("place", ["beside", "elsewhere"])
def test_every_export_keeps_them(form: str, place: str, tmp_path: Path) -> None:
    robot = arm(tmp_path / "beside")
    writer, suffix = WRITERS[form]
    folder = tmp_path / place
    folder.mkdir(exist_ok=True)
    file = folder / f"back{suffix}"
    file.write_text(writer(robot, folder), encoding="utf-8")
    options = file_options(search_path=[tmp_path / "beside"])
    back = read_description(file, options)
    assert facts(back) == facts(robot)
    assert len(facts(robot)) == 6
    if place == "beside":
        assert 'meshes/part.stl"' in file.read_text().replace("<", '"') or form == "yaml"
        assert str(tmp_path) not in file.read_text()


@pytest.mark.parametrize("form", WRITERS)
def test_rods_that_stand_for_links_are_no_visuals(form: str, tmp_path: Path) -> None:
    writer, suffix = WRITERS[form]
    robot = load("five_bar")
    text = writer(robot)
    assert form == "yaml" or "hybrid_dynamics_rod" in text
    assert read_description(written(tmp_path, text, f"back{suffix}")).visuals == {}


@pytest.mark.parametrize("form", WRITERS)
@examples(40)
@given(seed=st.integers(0, 10_000))
def test_random_visuals_come_back(
    form: str, seed: int, tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = tmp_path_factory.mktemp("random")
    rng = np.random.default_rng(seed)
    entries: dict[str, list] = {"base": [], "upper": [], "lower": [], "tool": []}
    shapes = {
        "box": lambda: {"size": rng.uniform(0.1, 1, 3).tolist()},
        "cylinder": lambda: dict(zip(("radius", "length"), rng.uniform(0.1, 1, 2), strict=True)),
        "sphere": lambda: {"radius": rng.uniform(0.1, 1)},
        "capsule": lambda: dict(zip(("radius", "length"), rng.uniform(0.1, 1, 2), strict=True)),
        "ellipsoid": lambda: {"radii": rng.uniform(0.1, 1, 3).tolist()},
        "mesh": lambda: {"file": "part.obj", "scale": rng.uniform(-1, 1, 3).tolist()},
    }
    for _ in range(5):
        shape = str(rng.choice(list(shapes)))
        entry = {shape: shapes[shape](), "colour": rng.uniform(0, 1, rng.integers(3, 5)).tolist()}
        if rng.random() < 0.8:
            entry["origin"] = {
                "xyz": rng.normal(size=3).tolist(),
                "rpy": rng.normal(size=3).tolist(),
            }
        entries[str(rng.choice(list(entries)))].append(entry)
    write_mesh(folder / "part.obj")
    head, _, tail = ARM.partition("links:\n")
    joints = "joints:\n" + tail.partition("joints:\n")[2]
    links = "".join(
        f"  {name}: {{mass: 1, visuals: {visuals}}}\n".replace("np.float64", "")
        for name, visuals in entries.items()
    )
    links = links.replace("(", "").replace(")", "")
    robot = read_description(written(folder, f"{head}links:\n{links}{joints}"))
    writer, suffix = WRITERS[form]
    back = read_description(written(folder, writer(robot, folder), f"back{suffix}"))
    expected, actual = facts(robot), facts(back)
    assert [row[0] for row in actual] == [row[0] for row in expected]
    for one, other in zip(expected, actual, strict=True):
        assert other[2] == pytest.approx(one[2], abs=1e-8)
        assert other[3] == pytest.approx(one[3], abs=1e-8)
        assert other[4] == one[4]


def test_mujoco_sees_what_is_exported(tmp_path: Path) -> None:
    """Corners of the mesh, and middles of the other shapes, in the world."""
    robot = arm(tmp_path)
    model = mujoco.MjModel.from_xml_string(to_mjcf(robot))
    data = mujoco.MjData(model)
    data.qpos[:] = 0.3, -0.4
    mujoco.mj_forward(model, data)
    (mesh,) = np.flatnonzero(model.geom_type == mujoco.mjtGeom.mjGEOM_MESH)
    corners = data.geom_xpos[mesh] + model.mesh_vert @ data.geom_xmat[mesh].reshape(3, 3).T
    machine = Robot(robot)
    pose = machine.forward_kinematics(machine.close([0.3, -0.4]), "upper")
    (visual,) = [visual for visual in robot.visuals["upper"] if visual.uri]
    expected = 0.1 * CORNERS @ visual.frame.rotation.T + visual.frame.translation
    expected = expected @ pose.rotation.T + pose.position
    distances = np.linalg.norm(corners[:, None] - expected[None], axis=2)
    assert distances.min(axis=0) == pytest.approx(np.zeros(4), abs=1e-6)


def test_meshes_that_mujoco_does_not_read_stand_aside(tmp_path: Path) -> None:
    text = ARM.replace("part.stl", "part.dae")
    write_mesh(tmp_path / "meshes" / "part.dae")
    robot = read_description(written(tmp_path, text))
    exported = to_mjcf(robot, tmp_path)
    mujoco.MjModel.from_xml_string(exported)
    assert facts(read_description(written(tmp_path, exported, "back.xml"))) == facts(robot)


# -- what is read of others


def urdf(visual: str, root: str = "") -> str:
    """Line 2 has what is in the link."""
    return (
        f'<robot name="r">{root}<link name="base"/>\n<link name="a">{visual}'
        '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
        '</inertial></link>\n<joint name="q" type="continuous"><parent link="base"/>'
        '<child link="a"/><axis xyz="0 0 1"/></joint></robot>'
    )


def sdf(visual: str) -> str:
    return (
        f'<sdf version="1.9"><model name="r"><link name="base"/>\n<link name="a">{visual}</link>\n'
        '<joint name="q" type="revolute"><parent>base</parent><child>a</child><axis><xyz>0 0 1'
        '</xyz></axis></joint><frame name="f" attached_to="a"><pose>0 0 1 0 0 0</pose></frame>'
        '<joint name="w" type="fixed"><parent>world</parent><child>base</child></joint>'
        "</model></sdf>"
    )


def mjcf(geoms: str, head: str = "") -> str:
    return (
        f'<mujoco>{head}<worldbody>\n<body name="a"><inertial mass="1" pos="0 0 0"'
        f' diaginertia="1 1 1"/><joint name="q" axis="0 0 1"/>{geoms}</body></worldbody></mujoco>'
    )


def visuals_of(folder: Path, text: str, name: str, link: str = "a") -> tuple[Visual, ...]:
    return read_description(written(folder, text, name)).visuals.get(link, ())


def geometry(shape: str, material: str = "") -> str:
    return f"<visual><geometry>{shape}</geometry>{material}</visual>"


URDF = {
    '<box size="1 2 3"/>': ("box", (1, 2, 3)),
    '<cylinder radius="1" length="2"/>': ("cylinder", (1, 2)),
    '<sphere radius="2"/>': ("sphere", (2,)),
    '<capsule radius="1" length="2"/>': ("capsule", (1, 2)),
    '<drake:capsule radius="1" length="2"/>': ("capsule", (1, 2)),
    '<drake:ellipsoid a="1" b="2" c="3"/>': ("ellipsoid", (1, 2, 3)),
    '<mesh filename="m.stl" scale="1 2 -3"/>': ("mesh", (1, 2, -3)),
    '<mesh filename="m.stl" scale="2 2 2"/>': ("mesh", (2, 2, 2)),
    '<mesh filename="m.stl"/>': ("mesh", (1, 1, 1)),
}


@pytest.mark.parametrize("shape", URDF)
def test_shapes_of_urdf(shape: str, tmp_path: Path) -> None:
    (visual,) = visuals_of(tmp_path, urdf(geometry(shape)), "r.urdf")
    assert (visual.shape, visual.size) == URDF[shape]
    assert visual.colour is None


def test_place_and_colour_in_urdf(tmp_path: Path) -> None:
    box = '<geometry><box size="1 1 1"/></geometry>'
    placed = f'<visual><origin xyz="1 2 3" rpy=".1 .2 .3"/>{box}<material name="red"/></visual>'
    own = f'<visual>{box}<material name="x"><color rgba="0 0 1 .5"/></material></visual>'
    root = '<material name="red"><color rgba="1 0 0 1"/></material>'
    red, blue = visuals_of(tmp_path, urdf(placed + own, root), "r.urdf")
    assert (red.colour, blue.colour) == ((1, 0, 0, 1), (0, 0, 1, 0.5))
    assert red.frame.translation == pytest.approx([1, 2, 3])
    assert rpy_of(red.frame.rotation) == pytest.approx([0.1, 0.2, 0.3])


SDF = {
    "<box><size>1 2 3</size></box>": ("box", (1, 2, 3)),
    "<cylinder><radius>1</radius><length>2</length></cylinder>": ("cylinder", (1, 2)),
    "<sphere><radius>2</radius></sphere>": ("sphere", (2,)),
    "<capsule><radius>1</radius><length>2</length></capsule>": ("capsule", (1, 2)),
    "<ellipsoid><radii>1 2 3</radii></ellipsoid>": ("ellipsoid", (1, 2, 3)),
    "<mesh><uri>m.stl</uri><scale>1 2 3</scale></mesh>": ("mesh", (1, 2, 3)),
}


@pytest.mark.parametrize("shape", SDF)
def test_shapes_of_sdformat(shape: str, tmp_path: Path) -> None:
    (visual,) = visuals_of(tmp_path, sdf(geometry(shape)), "r.sdf")
    assert (visual.shape, visual.size) == SDF[shape]


def test_place_and_colour_in_sdformat(tmp_path: Path) -> None:
    head = '<visual name="v"><pose relative_to="f">1 0 0 0 0 0</pose>'
    material = "<material><ambient>0 1 0 1</ambient><diffuse>1 0 0</diffuse></material>"
    text = f"{head}<transparency>0.25</transparency>{geometry('<box><size>1 1 1</size></box>', '')}"
    text = text.replace("<visual><geometry>", "<geometry>").replace("</visual>", material)
    (visual,) = visuals_of(tmp_path, sdf(f"{text}</visual>"), "r.sdf")
    assert visual.colour == (1, 0, 0, 0.75)
    assert visual.frame.translation == pytest.approx([1, 0, 1])


def test_models_in_other_files_have_meshes_beside_them(tmp_path: Path) -> None:
    """Both files name a mesh m.stl; each means the one beside it."""
    mesh = geometry("<mesh><uri>m.stl</uri></mesh>")
    inner = f'<sdf version="1.9"><model name="i"><link name="b">{mesh}</link></model></sdf>'
    written(tmp_path / "inner", inner, "model.sdf")
    write_mesh(tmp_path / "inner" / "m.stl")
    write_mesh(tmp_path / "m.stl")
    include = "<include><uri>model://inner</uri></include>"
    tie = '<joint name="t" type="fixed"><parent>a</parent><child>i::b</child></joint>'
    text = sdf(mesh).replace("</model>", f"{include}{tie}</model>")
    robot = read_description(written(tmp_path, text, "r.sdf"))
    assert robot.visuals["a"][0].file == tmp_path / "m.stl"
    assert robot.visuals["i::b"][0].file == tmp_path / "inner" / "m.stl"


def test_mjcf_means_what_mujoco_makes_of_it(tmp_path: Path) -> None:
    """Classes, frames, materials, references of meshes and fromto, against MuJoCo's own numbers."""
    head = (
        '<compiler meshdir="assets" angle="radian"/><default><mesh scale="0.1 0.1 0.1"/>'
        '<default class="seen"><geom group="1" material="paint"/></default></default><asset>'
        '<material name="paint" rgba="0.2 0.4 0.6 1"/><texture type="2d" name="t" file="no.png"/>'
        '<mesh name="m" file="part.stl" refpos="1 2 3" refquat="0.6 0.8 0 0"/></asset>'
    )
    geoms = (
        '<frame pos="1 0 0" euler="0 0 0.5"><geom type="mesh" mesh="m" class="seen" mass="0"'
        ' pos=".1 .2 .3" euler=".1 .2 .3"/></frame>'
        '<geom type="capsule" fromto="0 0 0 1 1 1" size="0.1"/>'
        '<geom type="box" size="1 2 3" rgba="1 0 0 0.5"/><geom type="box" size="1 1 1" group="3"/>'
    )
    write_mesh(tmp_path / "assets" / "part.stl")
    file = written(tmp_path, mjcf(geoms, head), "r.xml")
    robot = read_description(file)
    mesh, capsule, box = robot.visuals["a"]
    file.write_text(
        mjcf(geoms, head).replace('file="no.png"', 'builtin="flat" width="9" height="9"')
    )
    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    corners = data.geom_xpos[0] + model.mesh_vert @ data.geom_xmat[0].reshape(3, 3).T
    expected = CORNERS * mesh.size @ mesh.frame.rotation.T + mesh.frame.translation
    distances = np.linalg.norm(corners[:, None] - expected[None], axis=2)
    assert distances.min(axis=0) == pytest.approx(np.zeros(4), abs=1e-6)
    assert mesh.colour == (0.2, 0.4, 0.6, 1)
    assert mesh.file == tmp_path / "assets" / "part.stl"
    assert capsule.size == pytest.approx((0.1, 3**0.5))
    assert capsule.frame.translation == pytest.approx([0.5, 0.5, 0.5])
    assert abs(capsule.frame.rotation[:, 2] @ np.ones(3)) == pytest.approx(3**0.5)
    assert (box.size, box.colour) == ((2, 4, 6), (1, 0, 0, 0.5))
    assert any("group 3, which MuJoCo hides: <geom> (line 2)" in note for note in robot.notes)


def test_a_mesh_that_gives_mass_stands_where_it_is_written(tmp_path: Path) -> None:
    """MuJoCo moves it to its centre of mass."""
    write_mesh(tmp_path / "part.stl")
    head = '<asset><mesh name="m" file="part.stl"/></asset>'
    geom = '<geom type="mesh" mesh="m" pos="1 2 3" quat="0.6 0.8 0 0"/>'
    text = mjcf(geom, head).replace('<inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/>', "")
    (visual,) = visuals_of(tmp_path, text, "r.xml")
    assert visual.frame.translation == pytest.approx([1, 2, 3], abs=1e-12)
    assert visual.frame.rotation[:, 2] == pytest.approx([0, -0.96, -0.28], abs=1e-12)


# -- never an obstacle


WRONG = {
    "r.urdf": [
        urdf(geometry("")),
        urdf(geometry('<box size="1 2"/>')),
        urdf(geometry('<box size="1 2 x"/>')),
        urdf(geometry('<sphere radius="-1"/>')),
        urdf(geometry('<sphere radius="nan"/>')),
        urdf(geometry('<mesh filename=""/>')),
        urdf(geometry('<mesh filename="m.stl" scale="0 1 1"/>')),
        urdf('<visual><origin xyz="a"/><geometry><sphere radius="1"/></geometry></visual>'),
        urdf(geometry('<sphere radius="1"/>').replace("<visual", f"<visual name='{ELLIPSOID} x'")),
    ],
    "r.sdf": [
        sdf("<visual name='v'/>"),
        sdf(geometry("<box><size>1 2</size></box>")),
        sdf(geometry("<sphere/>")),
        sdf(geometry("<plane><normal>0 0 1</normal></plane>")),
        sdf(geometry("<mesh><uri>m.stl</uri><submesh><name>s</name></submesh></mesh>")),
        sdf('<visual name="v"><pose relative_to="no">0 0 0 0 0 0</pose>'
            "<geometry><sphere><radius>1</radius></sphere></geometry></visual>"),
    ],
}  # fmt: skip


@pytest.mark.parametrize(
    ("name", "text"), [(name, text) for name, texts in WRONG.items() for text in texts]
)
def test_a_wrong_visual_is_a_note_with_its_line(name: str, text: str, tmp_path: Path) -> None:
    robot = read_description(written(tmp_path, text, name))
    assert robot.visuals == {}
    assert any(note.startswith(f"{name}:2: <visual> is left out: ") for note in robot.notes)


def test_other_words_of_visuals_are_noted_once(tmp_path: Path) -> None:
    box = geometry('<box size="1 1 1"/>', '<material name="m"><texture filename="t"/></material>')
    robot = read_description(written(tmp_path, urdf(2 * box), "r.urdf"))
    words = "r.urdf:2: <texture> of <material> is left out, here and 1 times more"
    assert words in robot.notes


NOT_SHOWN = {
    "missing": "there is no such file",
    "a folder": "a folder, pipe or device; expected a regular file",
    "a pipe": "a folder, pipe or device; expected a regular file",
    "a device": "is not below",
    "large": f"{MAX_BYTES + 1} bytes; a mesh has at most {MAX_BYTES}",
    "an archive": "archives are not opened",
    "above": "is not below",
    "by a link": "is not below",
    "elsewhere": "nothing is fetched by https://",
    "no package": "there is no package 'nobody'; searched:",
    "long": "File name too long",
}


@pytest.mark.parametrize("case", NOT_SHOWN)
def test_a_mesh_that_is_not_shown_is_a_note_with_its_line(case: str, tmp_path: Path) -> None:
    folder = tmp_path / "robot"
    folder.mkdir()
    uris = {
        "a device": "/dev/zero",
        "an archive": "m.zip",
        "above": "../m.stl",
        "elsewhere": "https://a.b/m.stl",
        "no package": "package://nobody/m.stl",
        "long": "a" * 300 + ".stl",
    }
    uri = uris.get(case, "m.stl")
    place = folder / "m.stl"
    if case == "a folder":
        place.mkdir()
    elif case == "a pipe":
        os.mkfifo(place)
    elif case == "large":
        place.touch()
        os.truncate(place, MAX_BYTES + 1)
    elif case == "an archive":
        (folder / "m.zip").write_bytes(b"PK")
    elif case == "by a link":
        place.symlink_to(write_mesh(tmp_path / "m.stl"))
    robot = read_description(written(folder, urdf(geometry(f'<mesh filename="{uri}"/>')), "r.urdf"))
    assert robot.visuals["a"][0].file is None
    (note,) = [note for note in robot.notes if note.startswith("r.urdf: meshes are not shown: ")]
    assert f"{uri} (line 2): " in note
    assert NOT_SHOWN[case] in note


def test_meshes_are_searched_for_without_ros(tmp_path: Path) -> None:
    mesh = urdf(geometry('<mesh filename="package://robot_parts/m.stl"/>'))
    file = written(tmp_path / "ws" / "robot_arm" / "urdf", mesh, "r.urdf")
    title = "<package><name>robot_arm</name></package>"
    written(tmp_path / "ws" / "robot_arm", title, "package.xml")
    beside = write_mesh(tmp_path / "ws" / "robot_parts" / "m.stl")
    assert read_description(file).visuals["a"][0].file == beside
    far = written(tmp_path / "far" / "away", mesh, "r.urdf")
    assert read_description(far).visuals["a"][0].file is None
    options = file_options(search_path=[tmp_path / "ws"])
    assert read_description(far, options).visuals["a"][0].file == beside
    exported = to_urdf(read_description(far, options), tmp_path)
    assert "package://robot_parts/m.stl" in exported


YAML_ERRORS = {
    "{box: {size: [1, 1, -1]}}": "links.upper.visuals[0].box.size[2]: is -1 m",
    "{}": "expected 1",
    "{box: {size: [1, 1, 1]}, sphere: {radius: 1}}": "has box, sphere; expected one of",
    "{sphere: {radius: 1}, colour: red}": "expected '#rrggbb'",
    "{sphere: {radius: 1}, colour: [255, 0, 0]}": "numbers from 0 to 1",
    "{mesh: {file: m.stl, scale: 0}}": "a scale is another number than zero",
    "{sphere: {radius: 1 rad}}": "radius",
}


@pytest.mark.parametrize("visual", YAML_ERRORS)
def test_a_description_file_is_checked(visual: str) -> None:
    head, _, tail = ARM.partition("    visuals:\n      - {cyl")
    text = f"{head}    visuals: [{visual}]\n  tool:{tail.partition('  tool:')[2]}"
    with pytest.raises(DescriptionError) as caught:
        parse_description(text)
    assert YAML_ERRORS[visual] in str(caught.value)
    assert caught.value.line == 8


READ = """
import sys
seen = []
sys.addaudithook(lambda event, args: seen.append(str(args[0])) if event == "open" else None)
from hybrid_dynamics_core import load
robot = load(sys.argv[1])
assert len(robot.description.visuals) == 4
assert not any(name.endswith(".stl") for name in seen), seen
modules = {"trimesh", "scipy", "matplotlib", "viser", "hybrid_dynamics_core.scene"}
assert not modules & set(sys.modules), modules & set(sys.modules)
"""


def test_reading_opens_no_mesh_and_imports_nothing_for_it(tmp_path: Path) -> None:
    arm(tmp_path)
    environment = {**os.environ, "HYBRID_DYNAMICS_KERNELS": "python"}
    file = str(tmp_path / "arm.yaml")
    subprocess.run([sys.executable, "-c", READ, file], check=True, env=environment)
