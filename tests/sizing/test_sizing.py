"""Sizing of drives: textbook numbers, forces worked out by hand, and one line for wrong files."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import InputError, Robot, load
from hybrid_dynamics_core.errors import StateError
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.kernels.run import VARIABLE
from hybrid_dynamics_core.sizing import (
    Margins,
    demand_of,
    euler_load,
    read_catalogue,
    read_duty,
    size_drive,
)
from tests.cli.calling import call

ARM = """\
format: 1
name: arm
gravity: [0, 0, -10]
links: {base: {}, arm: {mass: 3, com: [0.5, 0, 0], inertia: {zz: 0.25}}}
joints:
  q:
    type: revolute
    parent: base
    child: arm
    origin: {rpy: [pi/2, 0, 0]}
    axis: z
    drive: {rotor_inertia: 0.001, gear_ratio: 100}
active: [q]
end_effector: {link: arm, xyz: [1, 0, 0]}
"""
CRANK = """\
format: 1
name: crank
gravity: [0, 0, -10]
links: {base: {}, crank: {mass: 100, com: [0.8, 0, 0]}, barrel: {}, rod: {}}
joints:
  lever: {type: revolute, parent: base, child: crank, origin: {rpy: [pi/2, 0, 0]}, axis: z}
  pivot:
    type: revolute
    parent: base
    child: barrel
    origin: {xyz: [0, 0, -0.8], rpy: [pi/2, 0, 0]}
    axis: z
  stroke: {type: prismatic, parent: barrel, child: rod, origin: {xyz: [0.7, 0, 0]}, axis: x}
loops:
  lift:
    {type: A, base: base, arm: crank, k1: barrel, k2: rod,
     pin: {rod: [0, 0, 0], crank: [0.6, 0, 0]}}
actuators:
  stroke: {kind: hydraulic_cylinder, bore: 50*mm, rod: 30*mm}
active: [stroke]
end_effector: {link: crank, xyz: [1, 0, 0]}
reference: {stroke: 0.3, lever: 0, pivot: 1}
"""
CYLINDERS = """\
name,bore [mm],rod [mm],stroke [mm],pressure [bar]
B,50,30,500,150
A,40,25,500,150
C,63,40,500,150
"""


@pytest.fixture(autouse=True, scope="module")
def _without_compiler() -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(VARIABLE, "python")
        yield


@pytest.fixture(name="arm", scope="module")
def arm_robot() -> Robot:
    return Robot(parse_description(ARM))


@pytest.fixture(name="crank", scope="module")
def crank_robot() -> Robot:
    return Robot(parse_description(CRANK))


def written(folder: Path, text: str, name: str = "catalogue.csv") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def test_eulers_load_of_a_steel_bar() -> None:
    """A bar of 20 mm and 1 m, 200 GPa: I = 7854 mm^4, so 15.50 kN."""
    assert euler_load(200e9, 0.020, 1.0) == pytest.approx(15503.0, rel=1e-4)


def test_a_motor_gives_the_torques_of_a_textbook_cycle(arm: Robot, tmp_path: Path) -> None:
    """Half of the time at 4 rad/s^2 and half at rest, held level: torques by hand.

    Level, the arm weighs 30 N at 0.5 m, and has 1 kg m^2 about its joint.
    """
    columns = {
        "time": np.array([0.0, 1.0, 1.0 + 1e-9, 2.0]),
        "q": np.zeros(4),
        "q.velocity": np.array([2.0, 2.0, 0.0, 0.0]),
        "q.acceleration": np.array([4.0, 4.0, 0.0, 0.0]),
    }
    text = (
        "name,torque [N m],peak_torque [N m],speed [rad/s],inertia [kg m^2],gear_ratio,efficiency\n"
        "M,1,2,30,0.01,10,0.8\n"
    )
    sizing = size_drive(
        arm, read_duty(columns, arm), read_catalogue(written(tmp_path, text)), "q", Margins(rms=2.0)
    )
    fast = (15.0 + 4.0) / 10.0 / 0.8 + 0.01 * 10.0 * 4.0
    rms = np.sqrt((fast**2 + 1.5**2) / 2.0)
    checks = {check.quantity: check for check in sizing.candidates[0].checks}
    assert checks["peak torque"].needed == pytest.approx(fast)
    assert checks["rms torque"].needed == pytest.approx(2.0 * rms, rel=1e-8)
    assert checks["speed"].needed == pytest.approx(20.0)
    assert sizing.demand.power == pytest.approx(38.0)
    assert [check.quantity for check in sizing.candidates[0].lacking] == [
        "peak torque",
        "rms torque",
    ]
    assert sizing.chosen is None


def test_a_load_that_drives_the_motor_is_braked_by_less(arm: Robot, tmp_path: Path) -> None:
    columns = {"q": np.zeros(2), "q.velocity": np.array([1.0, -1.0])}
    text = "name,torque,speed,gear_ratio,efficiency\nM,9,30,10,0.5\n"
    catalogue = read_catalogue(written(tmp_path, text))
    up, down = (
        size_drive(arm, read_duty({k: v[row] for k, v in columns.items()}, arm), catalogue, "q")
        for row in (slice(0, 1), slice(1, 2))
    )
    assert up.candidates[0].checks[0].needed == pytest.approx(1.5 / 0.5)
    assert down.candidates[0].checks[0].needed == pytest.approx(1.5 * 0.5)


def test_a_screw_turns_a_force_into_a_torque(crank: Robot, tmp_path: Path) -> None:
    text = "name,torque,speed,lead [mm]\nS,1000,1000,10\n"
    duty = read_duty({"stroke": [0.3], "stroke.velocity": [0.05]}, crank)
    sizing = size_drive(crank, duty, read_catalogue(written(tmp_path, text)), "stroke")
    checks = {check.quantity: check.needed for check in sizing.candidates[0].checks}
    turn = 0.010 / (2.0 * np.pi)
    assert checks["peak torque"] == pytest.approx(sizing.demand.peak * turn)
    assert checks["speed"] == pytest.approx(0.05 / turn)


def test_forces_of_a_crank_with_its_load_are_those_by_hand(crank: Robot) -> None:
    """The crank is level: pins 0.6 m ahead and 0.8 m below, so the cylinder is 1 m long."""
    demand = demand_of(crank, read_duty({"stroke": [0.3], "payload": [50.0]}, crank), "stroke")
    moment = 10.0 * (100.0 * 0.8 + 50.0 * 1.0)
    lever = 0.6 * 0.8  # of the force about the pivot
    assert demand.force[0] == pytest.approx(moment / lever)
    assert demand.length == pytest.approx([1.0])


def test_the_smallest_cylinder_that_fits_is_chosen(crank: Robot, tmp_path: Path) -> None:
    catalogue = read_catalogue(written(tmp_path, CYLINDERS))
    assert [row.name for row in catalogue.rows] == ["A", "B", "C"]
    duty = read_duty({"lever": [-0.3, 0.0, 0.3], "payload": [900.0] * 3}, crank)
    sizing = size_drive(crank, duty, catalogue, "stroke", Margins(stroke=0.01))
    needed = {one.name: one.checks[0].needed for one in sizing.candidates}
    assert needed["B"] == pytest.approx(sizing.demand.peak / (np.pi / 4.0 * 0.050**2))
    assert sizing.chosen.name == "B"
    strokes = sizing.demand.position
    assert sizing.candidates[0].checks[1].needed == pytest.approx(np.ptp(strokes) + 0.02)


def test_rods_buckle_and_cylinders_have_room_between_the_pins(crank: Robot, tmp_path: Path) -> None:
    text = CYLINDERS.replace("pressure [bar]", "pressure [bar],retracted [mm],modulus [MPa]")
    text = text.replace(",150\n", ",150,720,210000\n")
    duty = read_duty({"lever": [-0.3, 0.0, 0.3], "payload": [900.0] * 3}, crank)
    sizing = size_drive(crank, duty, read_catalogue(written(tmp_path, text)), "stroke")
    checks = {check.quantity: check for check in sizing.candidates[1].checks}
    angles = np.array([-0.3, 0.0, 0.3])
    lengths = np.sqrt(0.36 + 0.64 + 2.0 * 0.6 * 0.8 * np.sin(angles))  # law of cosines
    assert checks["retracted length"].given == pytest.approx(lengths.min())
    assert checks["extended length"].needed == pytest.approx(lengths.max())
    shares = 3.5 * sizing.demand.force / [euler_load(210e9, 0.03, length) for length in lengths]
    assert checks["buckling"].share == pytest.approx(shares.max())
    assert "buckling" in [check.quantity for check in sizing.candidates[1].lacking]


@given(factor=st.floats(1.0, 3.0))
def test_more_margin_never_makes_a_drive_fit(crank: Robot, factor: float) -> None:
    folder = Path(__file__).parents[2] / "examples" / "catalogues"
    catalogue = read_catalogue(folder / "cylinders.csv")
    duty = read_duty({"lever": [0.0], "payload": [3000.0]}, crank)
    plain = size_drive(crank, duty, catalogue, "stroke")
    more = size_drive(crank, duty, catalogue, "stroke", Margins(factor, buckling=3.5 * factor))
    for one, other in zip(plain.candidates, more.candidates, strict=True):
        assert one.fits or not other.fits


def test_a_simulated_motion_asks_for_its_own_efforts(crank: Robot, tmp_path: Path) -> None:
    """`simulate` writes the efforts that it applied; the cycle finds them again."""
    from hybrid_dynamics_core.simulation import simulate

    run = simulate(crank, [0.3], tau=[1700.0], t_span=(0.0, 0.2))
    run.save(tmp_path / "run.csv")
    duty = read_duty(tmp_path / "run.csv", crank)
    demand = demand_of(crank, duty, "stroke")
    assert demand.force == pytest.approx(run.tau[:, 0], rel=1e-8)
    assert "work" in duty.unused


@pytest.mark.parametrize(
    ("slip", "meant"),
    [("force_z", "force.z"), ("payloads", "payload"), ("q.velocty", "q.velocity")],
)
def test_a_slip_in_the_name_of_a_column_is_refused(arm: Robot, slip: str, meant: str) -> None:
    with pytest.raises(InputError, match=rf"no column '{slip}' \(did you mean '{meant}'\?\)"):
        read_duty({"q": [0.1], slip: [50.0]}, arm)
    assert read_duty({"q": [0.1], "remark": [50.0]}, arm).unused == ("remark",)


def test_rates_follow_from_the_time(arm: Robot) -> None:
    time = np.linspace(0.0, 1.0, 5)
    duty = read_duty({"time": time, "q": time**3 - time}, arm)
    assert np.allclose(duty.rates[:, 0], 3.0 * time**2 - 1.0)
    assert np.allclose(duty.accelerations[:, 0], 6.0 * time)
    assert np.allclose(duty.weights, [0.125, 0.25, 0.25, 0.25, 0.125])
    assert duty.payload.shape == (5, 4)


def test_other_coordinates_give_the_same_forces(crank: Robot) -> None:
    time = np.linspace(0.0, 1.0, 6)
    lever = 0.3 * np.sin(time)
    states = crank.close_given({"lever": lever}, {"lever": 0.3 * np.cos(time)}, {"lever": -lever})
    by_angle = {"time": time, "lever": lever}
    by_angle |= {"lever.velocity": 0.3 * np.cos(time), "lever.acceleration": -lever}
    by_stroke = {"time": time, "stroke": states.u[:, 0], "stroke.velocity": states.du[:, 0]}
    by_stroke |= {"stroke.acceleration": states.dds[:, 0], "force.z": np.full(6, -70.0)}
    by_angle |= {"force.z": np.full(6, -70.0)}
    one = demand_of(crank, read_duty(by_angle, crank), "stroke")
    other = demand_of(crank, read_duty(by_stroke, crank), "stroke")
    assert np.allclose(one.force, other.force, rtol=1e-9)
    assert np.allclose(one.acceleration, other.acceleration, rtol=1e-9)


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        ({"lver": [0.0]}, r"columns of coordinates: none \(did you mean 'lever'\?\)"),
        ({"lever": [0.0], "pivot": [1.0]}, "or 1 coordinates that determine the motion"),
        ({"stroke": [np.nan]}, "row:1: stroke has no finite number"),
        ({"stroke": [0.3, 0.3], "time": [1.0, 1.0]}, "row:2: the time does not rise"),
        ({"stroke": [0.3], "payload": [-1.0]}, "row:1: the payload is negative"),
        ({"stroke": [0.3], "weight": [0.0]}, "all weights are zero"),
        ({"stroke": [0.3], "weight": [-1.0]}, "row:1: the weight is negative"),
        ({"stroke": [0.3, 0.4], "time": [0.0, 1.0]}, "has 2 rows; stroke.velocity follows from 4"),
    ],
)
def test_wrong_cycles_get_one_line(crank: Robot, columns: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        read_duty(columns, crank)


def test_a_row_out_of_reach_is_named(crank: Robot) -> None:
    with pytest.raises(StateError, match=r"^row:2: loop 'lift' cannot close"):
        demand_of(crank, read_duty({"stroke": [0.3, 2.0]}, crank), "stroke")
    with pytest.raises(InputError, match="there is no drive 'lever'"):
        demand_of(crank, read_duty({"stroke": [0.3]}, crank), "lever")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("name,size\nA,1\n", "expected name, bore, rod and stroke of cylinders"),
        ("bore,rod,stroke\n1,0.5,1\n", "expected name, bore, rod and stroke of cylinders"),
        ("name,bore,rod\nA,1,0.5\n", "there is no column stroke"),
        ("name,bore,rod,stroke,presure\nA,1,0.5,1,1\n", r"'presure' \(did you mean 'pressure'\?\)"),
        ("name,bore,rod,stroke\nA,1,2,1\n", ":2: the rod is not thinner than the bore"),
        ("name,bore,rod,stroke\nA,1,0.5,0\n", ":2: stroke is 0; expected more than zero"),
        ("name,bore,rod,stroke\nA,1,0.5,\n", ":2: stroke is nan"),
        ("name,bore,rod,stroke\nA,2,1,1\nA,2,1,1\n", ":3: the name A is given twice"),
        ("name,bore,rod,stroke\n,2,1,1\n", ":2: the name is empty"),
        ("name,bore [bar],rod,stroke\nA,2,1,1\n", r"column bore \[bar\]: .* is a pressure"),
        ("name,torque,speed,efficiency\nM,1,1,1.5\n", ":2: the efficiency is above 1"),
        ("name,torque,speed [m/s]\nM,1,1\n", r"column speed \[m/s\]: .* is a velocity"),
    ],
)
def test_wrong_catalogues_get_one_line(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        read_catalogue(written(tmp_path, text))


def test_what_a_joint_or_a_catalogue_lacks_is_said(
    arm: Robot, crank: Robot, tmp_path: Path
) -> None:
    cylinders = read_catalogue(
        written(tmp_path, CYLINDERS.replace(",pressure [bar]", ",mass [kg]"))
    )
    assert [row.name for row in cylinders.rows] == ["B", "A", "C"]  # of one mass, as in the file
    duty = read_duty({"stroke": [0.3]}, crank)
    with pytest.raises(InputError, match="B: no highest pressure"):
        size_drive(crank, duty, cylinders, "stroke")
    with pytest.raises(InputError, match="has cylinders, and q is a revolute joint"):
        size_drive(arm, read_duty({"q": [0.0]}, arm), cylinders, "q")
    motors = read_catalogue(written(tmp_path, "name,torque,speed\nM,1,1\n"))
    with pytest.raises(InputError, match="stroke slides, so a motor needs a column lead"):
        size_drive(crank, duty, motors, "stroke")


def test_the_verb_chooses_and_says_what_fails(tmp_path: Path) -> None:
    robot = written(tmp_path, CRANK, "crank.yaml")
    cycle = written(tmp_path, "lever [deg],payload [t]\n-10,0.9\n0,0.9\n10,0.9\n", "cycle.csv")
    catalogue = written(tmp_path, CYLINDERS)
    words = ["size", str(robot), "--cycle", str(cycle), "--catalogue", str(catalogue)]
    answer = call(*words, "--drive", "stroke", "--json")
    assert answer.exit_code == 0
    shown = json.loads(answer.stdout)
    assert shown["chosen"] == "B"
    first = shown["candidates"][0]
    assert not first["fits"]
    assert first["lacking"] == [first["lacking"][0]]
    assert first["checks"]["pressure"]["needed"] > first["checks"]["pressure"]["given"]
    answer = call(*words, "--drive", "stroke", "--margin", "pressure=4")
    assert answer.exit_code == 1
    assert "none of the catalogue fits" in answer.stdout
    answer = call(*words, "--drive", "stroke", "--margin", "presure=4")
    assert answer.exit_code == 2
    assert "did you mean 'pressure'?" in answer.stderr


def test_the_catalogues_of_the_examples_are_read() -> None:
    folder = Path(__file__).parents[2] / "examples" / "catalogues"
    for path in folder.glob("*.csv"):
        assert len(read_catalogue(path).rows) == 8


def test_drives_of_shipped_robots_have_pins() -> None:
    excavator = load("excavator")
    duty = read_duty(
        {"boom_pitch": [0.4], "slew": [0.0], "stick_cylinder": [0.7], "bucket_cylinder": [0.6]},
        excavator,
    )
    assert demand_of(excavator, duty, "boom_cylinder").length[0] > 1.5
    assert demand_of(excavator, duty, "slew").length is None
