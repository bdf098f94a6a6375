"""Units of FMI: the motion of `simulate`, the efforts of the library, and clear refusals."""

from __future__ import annotations

import tempfile
import zipfile
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given

from hybrid_dynamics_cli.app import app
from hybrid_dynamics_core import InputError, Payload, load
from hybrid_dynamics_core.export import to_fmu
from hybrid_dynamics_core.formats.c.names import identifiers
from hybrid_dynamics_core.formats.fmu.description import VERSIONS
from hybrid_dynamics_core.formats.fmu.variables import PROGRAMS
from hybrid_dynamics_core.simulation import Settings, simulate
from tests.generated.case import Case
from tests.generated.class_three import class_three
from tests.generated.robots import examples
from tests.sampling import swept

from .c_builds import WARNINGS, needs_compiler, run
from .units import DISCARD, ERROR, OK, Unit2, Unit3, described, unpacked

ROBOTS = swept(("type_c", "ankle", "excavator"), ("type_c",))
SPAN = 0.2  # [s]
# Both integrate to a relative tolerance of 1e-9 a step, in tens of steps.
CLOSE = 1e-7
FREE = Settings(stop_at_limits=False, rate=50.0)


@pytest.fixture(scope="module")
def unpack(tmp_path_factory: pytest.TempPathFactory):
    @cache
    def unpacked_once(name: str, program: str, version: str) -> Path:
        unit = to_fmu(load(name), program, version=version)
        assert not unit.without_binary
        return unpacked(unit, tmp_path_factory.mktemp("unit"))

    def make(name: str, program: str = "forward_dynamics", version: str = "3.0") -> Path:
        return unpacked_once(name, program, version)

    return make


def named(kind: str, robot) -> list[str]:
    """Names of variables along the active coordinates."""
    names = identifiers(robot.coordinates)
    return [f"{kind}.{names[name]}" for name in robot.active]


def efforts(robot) -> np.ndarray:
    """Efforts that hold the robot, and something besides."""
    held = robot.inverse_dynamics(robot.close(robot.reference), np.zeros(len(robot.active)))
    return held * 0.95


@needs_compiler
@pytest.mark.parametrize("name", ROBOTS)
def test_co_simulation_moves_as_simulate_does(unpack, name: str) -> None:
    robot = load(name)
    tau = efforts(robot)
    wanted = simulate(robot, robot.reference, tau=tau, t_span=(0.0, SPAN), settings=FREE)
    unit = Unit3(unpack(name))
    assert unit.set_boolean("stop_at_limits", False) == OK
    assert unit.start(dict(zip(named("tau", robot), tau, strict=True))) == OK
    for begin, end in zip(wanted.t[:-1], wanted.t[1:], strict=True):
        assert unit.step(begin, end - begin)[0] == OK
    status, got = unit.get([*named("u", robot), *named("du", robot)])
    assert status == OK
    scale = max(1.0, np.abs(wanted.du).max())
    ends = np.concatenate([wanted.u[-1], wanted.du[-1]])
    assert np.abs(got - ends).max() <= CLOSE * scale


@needs_compiler
@pytest.mark.parametrize("name", ROBOTS)
def test_model_exchange_has_the_slopes_and_places_of_the_library(unpack, name: str) -> None:
    robot = load(name)
    unit = Unit3(unpack(name), exchange=True)
    assert unit.start({}) == OK
    tau = efforts(robot)
    assert unit.set(dict(zip(named("tau", robot), tau, strict=True))) == OK
    rng = np.random.default_rng(0)
    state = robot.close(robot.reference)
    n = len(robot.active)
    for _ in range(5):
        u = robot.reference + 0.02 * rng.uniform(-1.0, 1.0, n)
        state = robot.close(u, rng.uniform(-1.0, 1.0, n), near=state)
        status, slopes = unit.slopes(np.concatenate([state.u, state.du]))
        assert status == OK
        ddu = robot.forward_dynamics(state, tau)
        scale = max(1.0, np.abs(ddu).max())
        assert np.abs(slopes - [*state.du, *ddu]).max() <= 1e-11 * scale
        names = identifiers(robot.coordinates)
        passive = [names[name] for name in robot.coordinates[n:]]
        listed = [f"z.{name}" for name in passive] + [f"dz.{name}" for name in passive]
        wanted = [*state.s[n:], *state.ds[n:], *robot.forward_kinematics(state).position]
        status, got = unit.get([*listed, "position.x", "position.y", "position.z"])
        assert status == OK
        assert np.abs(got - wanted).max() <= 1e-11


@needs_compiler
@pytest.mark.parametrize("name", ROBOTS)
def test_inverse_dynamics_is_that_of_the_library(unpack, name: str) -> None:
    robot = load(name)
    unit = Unit3(unpack(name, "inverse_dynamics"))
    assert unit.start({}) == OK
    rng = np.random.default_rng(0)
    n = len(robot.active)
    for k in range(5):
        u = robot.reference + 0.02 * rng.uniform(-1.0, 1.0, n)
        du, ddu = rng.uniform(-1.0, 1.0, (2, n))
        for kind, values in {"u": u, "du": du, "ddu": ddu}.items():
            assert unit.set(dict(zip(named(kind, robot), values, strict=True))) == OK
        status, got = unit.get(named("tau", robot))
        assert status == OK
        wanted = robot.inverse_dynamics(robot.close(u, du), ddu)
        assert np.abs(got - wanted).max() <= 1e-11 * max(1.0, np.abs(wanted).max())
        assert unit.step(0.1 * k, 0.1)[0] == OK


@needs_compiler
def test_a_motion_ends_at_the_limit_where_simulate_does(unpack) -> None:
    robot = load("type_c")
    wanted = simulate(robot, robot.reference, t_span=(0.0, 1.0))
    unit = Unit3(unpack("type_c"))
    assert unit.start({}) == OK
    status, is_over, last = unit.step(0.0, 1.0)
    assert (status, is_over) == (OK, True)
    assert last == pytest.approx(wanted.events[0].time, abs=1e-8)
    assert unit.said == [wanted.events[0].message]
    _, got = unit.get(named("u", robot))
    assert np.abs(got - wanted.u[-1]).max() <= CLOSE


@needs_compiler
def test_what_cannot_be_computed_is_said(unpack) -> None:
    """A start that does not close; places out of reach; values that are no numbers."""
    folder = unpack("type_c")
    unit = Unit3(folder)
    assert unit.start({"u.q2": 2.1}) == ERROR
    assert unit.said == ["a loop cannot close at u"]
    unit = Unit3(folder)
    assert unit.start({"u.q2": np.nan}) == ERROR
    assert "finite" in unit.said[0]
    unit = Unit3(folder)
    assert unit.start({}) == OK
    assert unit.set({"u.q2": 1.0}) == ERROR  # a state, once it moves
    assert unit.set({"tau.q1": np.inf}) == ERROR
    assert unit.step(0.0, -1.0)[0] == ERROR
    unit = Unit3(folder, exchange=True)
    assert unit.start({}) == OK
    status, slopes = unit.slopes(np.array([0.0, 2.1, 1.0, 0.0, 0.0, 0.0]))
    assert (status, unit.said[-1]) == (DISCARD, "a loop cannot close at u")
    assert (slopes == 7.0).all()
    assert Unit3(folder, mark="{another}").instance is None


@needs_compiler
def test_a_motion_into_a_singular_place_is_discarded_there(unpack) -> None:
    unit = Unit3(unpack("type_c"))
    assert unit.set_boolean("stop_at_limits", False) == OK
    assert unit.start({"tau.q2": 5000.0}) == OK
    status, _, last = unit.step(0.0, 5.0)
    assert status == DISCARD
    assert 0.0 < last < 5.0
    assert "near a singular place" in unit.said[-1] or "a loop" in unit.said[-1]


@needs_compiler
def test_a_state_is_stored_and_restored(unpack) -> None:
    import ctypes

    unit = Unit3(unpack("type_c"))
    assert unit.start({}) == OK
    state = ctypes.c_void_p()
    assert unit.call("GetFMUState", ctypes.byref(state)) == OK
    places = []
    for _ in range(2):
        assert unit.step(0.0, 0.1)[0] == OK
        places.append(unit.get(["u.q1", "u.q2", "u.q4"])[1])
        assert unit.call("SetFMUState", state) == OK
    assert (places[0] == places[1]).all()
    assert unit.call("FreeFMUState", ctypes.byref(state)) == OK


def differences(unit: Unit3, varied: list[str], unknowns: list[str], seeds) -> np.ndarray:
    """Changes of unknowns by central differences, of fourth order."""
    _, at = unit.get(varied)
    total = np.zeros(len(unknowns))
    step = 1e-3
    for places, weight in ((1, 8.0), (-1, -8.0), (2, -1.0), (-2, 1.0)):
        moved = at + places * step * np.array([seeds[name] for name in varied])
        assert unit.vary(dict(zip(varied, moved, strict=True))) == OK
        status, got = unit.get(unknowns)
        assert status == OK
        total += weight * got
    assert unit.vary(dict(zip(varied, at, strict=True))) == OK
    return total / (12.0 * step)


@needs_compiler
@pytest.mark.parametrize("program", PROGRAMS)
@pytest.mark.parametrize("name", ROBOTS)
def test_directional_derivatives_are_those_of_differences(unpack, name: str, program: str) -> None:
    robot = load(name)
    unit = Unit3(unpack(name, program), exchange=True)
    rng = np.random.default_rng(1)
    n = len(robot.active)
    last = "ddu" if program == "inverse_dynamics" else "tau"
    varied = [*named("u", robot), *named("du", robot), *named(last, robot)]
    scale = np.abs(efforts(robot)).max() if last == "tau" else 1.0
    starts = [*robot.reference, *rng.uniform(-0.3, 0.3, n), *scale * rng.uniform(-1.0, 1.0, n)]
    assert unit.start(dict(zip(varied, starts, strict=True))) == OK
    seeds = dict(zip(varied, rng.uniform(-1.0, 1.0, 3 * n), strict=True))
    kinds = ("tau",) if last == "ddu" else ("ddu", "z", "dz", "position", "rotation", "distance")
    unknowns = [key for key in unit.references if key.split(".")[0].split("[")[0] in kinds]
    status, got = unit.directional(unknowns, seeds)
    assert status == OK
    wanted = differences(unit, varied, unknowns, seeds)
    # differences have an error of step^4 of the fifth derivative
    assert np.abs(got - wanted).max() <= 1e-6 * max(1.0, np.abs(wanted).max())


@needs_compiler
def test_derivatives_of_states_and_by_others_than_states(unpack) -> None:
    unit = Unit3(unpack("type_c"), exchange=True)
    assert unit.start({}) == OK
    unknowns = ["der(u.q2)", "u.q1", "du.q4", "time"]
    status, got = unit.directional(unknowns, {"du.q2": 2.0, "u.q1": 3.0})
    assert (status, [*got]) == (OK, [2.0, 3.0, 0.0, 0.0])
    status, got = unit.directional(["ddu.q2"], {"gravity.z": 1.0})
    assert (status, [*got]) == (ERROR, [7.0])
    assert "neither a state nor an input" in unit.said[-1]


@needs_compiler
@pytest.mark.sweep(sample="test_inverse_dynamics_is_that_of_the_library")
def test_payload_and_friction_are_parameters(tmp_path: Path) -> None:
    robot = load("type_c")
    unit = Unit3(unpacked(to_fmu(robot, "inverse_dynamics", loads="arguments"), tmp_path))
    parameters = {"payload.mass": 3.0, "payload.com.x": 0.1, "viscous.q1": 2.0, "gravity.x": 1.0}
    assert unit.start({**parameters, "du.q1": 0.5}) == OK
    _, got = unit.get(named("tau", robot))
    loads = robot.loads.with_payload(Payload(3.0, [0.1, 0.0, 0.0]), robot.end_effector)
    gravity = robot.loads.gravity + np.array([1.0, 0.0, 0.0])
    viscous = robot.loads.effects.viscous.copy()
    viscous[robot.coordinates.index("q1")] = 2.0
    loads = loads.with_gravity(gravity).with_effects(viscous=viscous)
    state = robot.close(robot.reference, [0.5, 0.0, 0.0])
    wanted = robot.inverse_dynamics(state, np.zeros(3), loads)
    assert np.abs(got - wanted).max() <= 1e-11 * np.abs(wanted).max()


@needs_compiler
@pytest.mark.parametrize(("version", "program"), swept(product(VERSIONS, PROGRAMS), ("3.0",)))
def test_sources_compile_without_a_warning(unpack, version: str, program: str) -> None:
    """Also with a prefix, as units are linked into one program."""
    sources = unpack("type_c", program, version) / "sources"
    number = version[0]
    flags = ("-std=c99", *WARNINGS, "-fsyntax-only")
    run(sources, "gcc", *flags, f"fmi{number}.c")
    run(sources, "gcc", *flags, f"-DFMI{number}_FUNCTION_PREFIX=type_c_", f"fmi{number}.c")


@pytest.mark.sweep(sample="test_co_simulation_moves_as_simulate_does")
@pytest.mark.parametrize("name", ["ankle", "type_c"])
@pytest.mark.parametrize("program", PROGRAMS)
@pytest.mark.parametrize("version", VERSIONS)
def test_fmpy_validates_and_simulates(unpack, name: str, program: str, version: str) -> None:
    pytest.importorskip("fmpy")
    from fmpy import simulate_fmu
    from fmpy.validation import validate_fmu

    folder = str(unpack(name, program, version))
    assert validate_fmu(folder) == []
    robot = load(name)
    if program == "inverse_dynamics":
        starts = dict.fromkeys(named("ddu", robot), 0.3)
        result = simulate_fmu(folder, stop_time=0.1, output_interval=0.1, start_values=starts)
        state = robot.close(robot.reference)
        wanted = robot.inverse_dynamics(state, np.full(len(robot.active), 0.3))
        got = np.array([result[key][-1] for key in named("tau", robot)])
        assert np.abs(got - wanted).max() <= 1e-11 * max(1.0, np.abs(wanted).max())
        return
    wanted = simulate(robot, robot.reference, t_span=(0.0, SPAN), settings=FREE)
    for kind in ("CoSimulation", "ModelExchange"):
        result = simulate_fmu(
            folder,
            fmi_type=kind,
            stop_time=SPAN,
            output_interval=0.02,
            relative_tolerance=1e-9,
            start_values={"stop_at_limits": False},
        )
        got = np.array([result[key][-1] for key in named("u", robot)])
        # CVode of model exchange bounds the error of a step, not of the whole motion
        assert np.abs(got - wanted.u[-1]).max() <= 10 * CLOSE


def test_without_a_compiler_there_are_sources_only(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    said = CliRunner().invoke(app, ["export", "five_bar", "--format", "fmu", "-o", "a.fmu"])
    assert said.exit_code == 0
    assert "a.fmu: sources only, without a binary: there is no C compiler here" in said.output
    with zipfile.ZipFile("a.fmu") as archive:
        names = archive.namelist()
    assert "sources/five_bar.c" in names
    assert not [name for name in names if name.startswith("binaries/")]


def test_any_name_is_a_legal_one(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    file = tmp_path / "names.urdf"
    file.write_text(NAMES, encoding="utf-8")
    root = described(unpacked(to_fmu(load(file)), tmp_path))
    names = [variable.get("name") for variable in root.find("ModelVariables")]
    assert {"u.arm_q_1", "u._2nd"} <= set(names)
    assert len(set(names)) == len(names)


def test_the_same_robot_is_the_same_unit(monkeypatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    units = [to_fmu(load("five_bar")).content for _ in range(2)]
    assert units[0] == units[1]


NAMES = """<robot name="two &lt;arms&gt;">
  <link name="base"/>
  <link name="a"><inertial><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="b"><inertial><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="arm/q-1 &lt;&amp;&quot;" type="continuous">
    <parent link="base"/><child link="a"/><axis xyz="0 1 0"/></joint>
  <joint name="2nd" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>
"""

BAD = {
    "program": (["-o", "a.fmu", "--programs", "close"], "there is no program of a unit 'close'"),
    "two": (["-o", "a.fmu", "--programs", ",".join(PROGRAMS)], "--programs: expected one of"),
    "none": (["-o", "new", "--programs", ","], "--programs: expected one of"),
    "nowhere": ([], "say where with --output FILE.fmu"),
    "parent": (["-o", "none/a.fmu"], "there is no folder none"),
    "others": (["-o", "others"], "others: has other files, such as notes.txt"),
    "again": (["-o", "b.fmu"], "b.fmu: there is a file already"),
    "real": (["-o", "a.fmu", "--real", "float"], "--real belongs to --format c; fmu has none"),
    "version": (["-o", "a.fmu", "--fmi", "1.0"], "'1.0' is not one of '3.0', '2.0'"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_writes_nothing(case: str, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", str(tmp_path))
    Path("others").mkdir()
    Path("others/notes.txt").write_text("mine", encoding="utf-8")
    Path("b.fmu").write_text("mine", encoding="utf-8")
    before = sorted(tmp_path.rglob("*"))
    words, wanted = BAD[case]
    said = CliRunner().invoke(app, ["export", "five_bar", "--format", "fmu", *words])
    assert said.exit_code == 2
    assert wanted in said.output
    assert sorted(tmp_path.rglob("*")) == before


def test_a_robot_without_masses_has_no_unit(tmp_path: Path) -> None:
    words = ["export", "staicu2015", "--format", "fmu", "-o", str(tmp_path / "new")]
    said = CliRunner().invoke(app, words)
    assert said.exit_code == 2
    assert said.output.count("\n") == 1
    assert "staicu2015: no link has a mass" in said.output
    assert not (tmp_path / "new").exists()
    with pytest.raises(InputError, match=r"version: '1.0': expected 3\.0 or 2\.0"):
        to_fmu(load("five_bar"), version="1.0")


@needs_compiler
@pytest.mark.timeout(900)
@pytest.mark.sweep(sample="test_co_simulation_moves_as_simulate_does")
@examples(6)
@given(class_three())
def test_units_of_random_robots_move_as_simulate_does(case: Case) -> None:
    robot = case.robot
    tau = efforts(robot)
    wanted = simulate(robot, robot.reference, tau=tau, t_span=(0.0, 0.05), settings=FREE)
    with tempfile.TemporaryDirectory() as place:
        unit = Unit3(unpacked(to_fmu(robot), Path(place)))
        assert unit.set_boolean("stop_at_limits", False) == OK
        assert unit.start(dict(zip(named("tau", robot), tau, strict=True))) == OK
        assert unit.step(0.0, wanted.t[-1])[0] == OK
        _, got = unit.get([*named("u", robot), *named("du", robot)])
    scale = max(1.0, np.abs(wanted.du).max())
    assert np.abs(got - [*wanted.u[-1], *wanted.du[-1]]).max() <= CLOSE * scale


@needs_compiler
@pytest.mark.sweep(sample="test_a_motion_ends_at_the_limit_where_simulate_does")
def test_both_versions_of_fmi_are_one_motion(unpack) -> None:
    new, old = Unit3(unpack("type_c")), Unit2(unpack("type_c", version="2.0"))
    assert max(new.start({}), old.start()) == OK
    names = ["u.q1", "u.q2", "u.q4", "ddu.q2", "position.z"]
    for k in range(4):
        assert max(new.step(0.1 * k, 0.1)[0], old.step(0.1 * k, 0.1)) == OK
        assert (old.get(names) == new.get(names)[1]).all()
    _, is_over, last = new.step(0.4, 1.0)
    assert is_over
    assert old.step(0.4, 1.0) == DISCARD
    assert old.last() == (last, True)
    old.call("FreeInstance")
