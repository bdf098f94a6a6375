"""The verb `stiffness`, and pictures of what gives way."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from hybrid_dynamics_core import InputError, Payload, load
from hybrid_dynamics_core.scene.displaced import Displacements
from hybrid_dynamics_core.scene.scene import build_scene
from hybrid_dynamics_core.scene.skeleton import place_skeleton
from hybrid_dynamics_core.stiffness import Elasticity, stiffness_map
from tests.cli.calling import call
from tests.stiffness.machines import CRANE
from tests.stiffness.machines import machine as machine_of

DRIVES = {"slew": 5e7, "boom_cylinder": 5e7}
WORDS = ("--drive", "slew=50e6*N*m/rad", "--drive", "boom_cylinder=50*kN/mm")


@pytest.fixture(scope="module")
def machine():
    return load("excavator")


def test_the_answer_is_that_of_the_library(machine):
    answer = call("stiffness", "excavator", *WORDS, "--payload", "500", "--json")
    data = json.loads(answer.stdout)
    state = machine.close(machine.reference)
    stiffness = machine.stiffness(state, Elasticity(DRIVES))
    loads = machine.loads.with_payload(Payload(500.0))
    sag = stiffness.deflection(loads)
    assert data["frame"] == "end_effector"
    assert data["compliance"] == stiffness.compliance.tolist()
    assert data["stiffness"] is None
    assert len(data["rigid_directions"]) == 4
    assert data["along"]["about x"] is None  # infinite
    assert data["along"]["z"] == pytest.approx(stiffness.stiffness_along([0, 0, 1]))
    assert data["deflection"]["displacement"] == pytest.approx(sag.displacement.tolist())
    assert data["deflection"]["energy_by_element"] == pytest.approx(sag.energy_by_element)
    frequencies = [mode["frequency"] for mode in data["modes"]]
    assert frequencies == pytest.approx(stiffness.modes(loads).frequencies.tolist())


def test_the_text_says_what_is_rigid_and_who_gives_way():
    answer = call("stiffness", "excavator", *WORDS)
    assert answer.exit_code == 0
    assert "about x          rigid" in answer.stdout
    assert "drives.boom_cylinder" in answer.stdout
    assert call("stiffness", "staicu2015", "--drive", "lambda_A=1e6").exit_code == 0  # no masses


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--drive", "slew=5*m"), "expected NAME=STIFFNESS"),
        (("--drive", "slew=50*kN/mm"), "expected a number in N m/rad"),
        (("--drive", "boom_cylinder=5e6*N*m/rad"), "expected a number in N/m"),
        (
            (*WORDS, "--draw", "x.svg", "--over", "slew,slew", "--wrench", "1,0,0"),
            "two different joints",
        ),
        (("--drive", "slew=-5"), "--drive: slew: stiffness is -5"),
        (("--drive", "slow=5"), "did you mean 'slew'"),
        (("--mode", "1"), "give --draw FILE too"),
        ((*WORDS, "--draw", "x.svg", "--mode", "9"), "9: it has 2 modes"),
        ((*WORDS, "--draw", "x.svg", "--over", "slew,boom_cylinder"), "give --wrench too"),
        ((*WORDS, "--draw", "x.svg", "--over", "slew", "--wrench", "1,0,0"), "two joints, as A,B"),
        ((), "nothing of the robot is elastic"),
    ],
)
def test_a_wrong_call_gets_one_line(words, says, tmp_path, monkeypatch):
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    answer = call("stiffness", "excavator", *words)
    assert answer.exit_code == 2
    assert says in answer.stderr


def test_a_state_of_another_robot_is_refused(machine):
    other = load("delta")
    with pytest.raises(InputError, match="belongs to another robot"):
        machine.stiffness(other.close(other.reference), Elasticity(DRIVES))
    with pytest.raises(InputError, match="state is of type int"):
        machine.stiffness(3, Elasticity(DRIVES))
    state = machine.close(machine.reference)
    with pytest.raises(InputError, match="two different joints"):
        stiffness_map(machine, ("slew",), [0.0, 0.0, 1.0], elasticity=Elasticity(DRIVES))
    assert machine.stiffness(state, Elasticity(DRIVES)).elements


def test_pictures_are_drawn(tmp_path):
    pytest.importorskip("matplotlib")
    for name, words in {
        "sag.svg": (),
        "mode.png": ("--mode", "2"),
        "map.svg": ("--wrench", "0,0,-1e4", "--over", "boom_cylinder,stick_cylinder"),
    }.items():
        place = tmp_path / name
        answer = call("stiffness", "excavator", *WORDS, *words, "--draw", str(place))
        assert answer.exit_code == 0, answer.stderr
        assert Path(place).stat().st_size > 1000


def test_parts_of_the_picture_move_as_their_links_do(machine):
    """To first order, as forward kinematics moves them with the drive's deformation."""
    state = machine.close(machine.reference)
    stiffness = machine.stiffness(state, Elasticity({"boom_cylinder": 5e7}))
    sag = stiffness.deflection()
    change = -sag.energy_by_element["drives.boom_cylinder"]
    scale = 1e-4
    stroke = scale * np.sqrt(-2.0 * change / 5e7)
    u = machine.reference.copy()
    u[1] -= stroke  # the cylinder gives way inward
    skeleton = place_skeleton(machine, state)
    moved = Displacements(skeleton, sag.links)
    later = place_skeleton(machine, machine.close(u))
    for before, after in zip(skeleton.joints, later.joints, strict=True):
        shift = scale * moved.of_point(before.child, before.point)
        expected = after.point - before.point
        np.testing.assert_allclose(shift, expected, atol=1e-3 * scale * sag.distance)
    scene = build_scene(machine.description, skeleton, moved.projection())
    assert len(moved.of_scene(scene, 10.0).parts) == len(scene.parts)


def test_out_of_its_plane_a_robot_is_drawn_obliquely(machine):
    state = machine.close(machine.reference)
    modes = machine.stiffness(state, Elasticity({"slew": 5e7})).modes()
    swing = {name: shapes[0] for name, shapes in modes.links.items()}
    projection = Displacements(place_skeleton(machine, state), swing).projection()
    assert not projection.planar


def test_a_map_has_what_each_state_has(machine):
    joints = ("boom_cylinder", "stick_cylinder")
    soft = Elasticity({"boom_cylinder": 5e7, "stick_cylinder": 1e7})
    chart = stiffness_map(machine, joints, [0, 0, -1e4], elasticity=soft, cells=3)
    stiffness = machine.stiffness(machine.close(chart.u[1, 2]), soft)
    under = stiffness.under([0, 0, -1e4])
    assert chart.deflection[1, 2] == pytest.approx(under.distance)
    assert chart.position[1, 2] == pytest.approx(stiffness.position)
    most = max(under.energy_by_element, key=under.energy_by_element.__getitem__)
    assert chart.elements[chart.largest_share[1, 2]] == most
    with pytest.raises(InputError, match="did you mean 'slew'"):
        stiffness_map(machine, ("slow", "slew"), [0, 0, 1.0], elasticity=soft)
    with pytest.raises(InputError, match="expected 3 finite numbers"):
        stiffness_map(machine, joints, [0, 0], elasticity=soft)


def test_the_view_lists_modes_and_swings_in_one():
    pytest.importorskip("viser", reason="viser, the extra `view`, is not installed")
    from hybrid_dynamics_core.view import open_viewer

    crane = machine_of(CRANE)
    viewer = open_viewer(crane, port=0)
    try:
        overlay = viewer.vibration
        assert overlay is not None
        modes = crane.stiffness(crane.close(crane.reference)).modes()
        assert f"{modes.frequencies[0]:.4g} Hz" in overlay.html.content
        assert not viewer.swinging
        overlay.chosen.value = "1"
        assert viewer.swinging
        origins = {name: np.array(link.position) for name, link in viewer.scene_view.links.items()}
        overlay.tick(0.5)  # a quarter of a swing
        size = viewer.scene_view.shape.size
        shift = viewer.scene_view.links["rod"].position - origins["rod"]
        assert 0.0 < np.linalg.norm(shift) < 0.1 * size
        assert np.allclose(viewer.scene_view.links["base"].position, origins["base"])
        way = modes.links["rod"][0, :3]
        assert abs(shift @ way) == pytest.approx(np.linalg.norm(shift) * np.linalg.norm(way))
        overlay.tick(0.5)  # half of one: back in the middle
        assert np.allclose(viewer.scene_view.links["rod"].position, origins["rod"], atol=1e-9)
    finally:
        viewer.close()
    viewer = open_viewer(load("five_bar"), port=0)
    try:
        assert viewer.vibration is None
        assert not viewer.swinging
    finally:
        viewer.close()
