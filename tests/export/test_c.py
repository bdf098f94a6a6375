"""C99 of robots: compiled without a warning, equal to the library, untouched on failure."""

from __future__ import annotations

import ctypes
import re
import shutil
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_cli.app import app
from hybrid_dynamics_core import InputError, load, shipped_robots
from hybrid_dynamics_core.export import to_c
from hybrid_dynamics_core.formats.c.names import comment, identifier, identifiers, literal
from hybrid_dynamics_core.formats.c.solvers import ANGLE, NEAREST
from tests.sampling import examples, swept

from .c_builds import WARNINGS, Built, build, needs_compiler, results, run, states

ROBOTS = swept(shipped_robots(), ("ankle", "five_bar", "type_c"))
COUNT = 1000
OK, NOT_CLOSED, SINGULAR, JUMP, NOT_FINITE, SINGULAR_MASS = range(6)


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory):
    @cache
    def make(name: str) -> Built:
        return build(load(name), tmp_path_factory.mktemp(name))

    return make


TABLED = """\
format: 1
name: arm
links: {base: {}, upper: {mass: 2, com: [0.2, 0, 0]}, lower: {mass: 1, com: [0.1, 0, 0]}}
joints:
  q1: {type: revolute, parent: base, child: upper, axis: y, TABLE}
  q2: {type: revolute, parent: upper, child: lower, axis: y, effort_limit: 7}
active: [q1, q2]
end_effector: {link: lower}
"""


@pytest.mark.parametrize("is_tabled", [True, False])
def test_a_table_of_efforts_is_noted_where_its_largest_effort_stands(tmp_path, is_tabled) -> None:
    table = "effort_table: {rate: [0, 1], effort: [12, 5]}" if is_tabled else "effort_limit: 12"
    path = tmp_path / "arm.yaml"
    path.write_text(TABLED.replace("TABLE", table), encoding="utf-8")
    files = to_c(load(path), ["inverse_dynamics"])
    assert re.search(r"arm_effort_limits\[\w+\] = \{\s*12\.0, 7\.0\}", files["arm.c"])
    for name in ("arm.h", "README.md"):
        text = " ".join(files[name].split())
        note = "efforts over rate and position (q1). arm_effort_ranges has the largest effort"
        assert (note in text) == is_tabled


@needs_compiler
@pytest.mark.parametrize("name", ROBOTS)
def test_numbers_are_those_of_the_library(built, name: str) -> None:
    here = built(name)
    near, state = states(here.robot, COUNT)
    for function, (inputs, outputs) in results(here.robot, state, seed=1).items():
        flat = [np.reshape(out, (COUNT, -1)) for out in outputs]
        sizes = [out.shape[1] for out in flat]
        scales = [max(1.0, np.abs(out).max()) for out in flat]
        for k in range(COUNT):
            answer = here.call(function, [*(x[k] for x in inputs), near.s[k]], sizes)
            assert answer.status == OK, (function, k)
            assert np.abs(answer.guess - state.s[k]).max() <= 1e-12, (function, k)
            for got, wanted, scale in zip(answer.outs, flat, scales, strict=True):
                assert np.abs(got - wanted[k]).max() <= 1e-12 * scale, (function, k)


@needs_compiler
@pytest.mark.parametrize("name", ROBOTS)
def test_without_a_guess_the_numbers_are_the_same_to_the_last_bit(built, name: str) -> None:
    """Where the header says that it may be NULL: where every loop has a closed form."""
    here = built(name)
    near, state = states(here.robot, 20)
    open_functions = set()
    for function, (inputs, outputs) in results(here.robot, state, seed=1).items():
        if not here.may_lack_guess(function):
            continue
        open_functions.add(function)
        sizes = [np.reshape(out, (20, -1)).shape[1] for out in outputs]
        for k in range(20):
            given = [x[k] for x in inputs]
            whole = here.call(function, [*given, near.s[k]], sizes)
            bare = here.call_without_guess(function, given, sizes)
            assert bare.status == whole.status == OK
            for got, wanted in zip(bare.outs, whole.outs, strict=True):
                np.testing.assert_array_equal(got, wanted)
    iterates = name in ("ankle", "gough", "staicu2015")
    assert ("inverse_dynamics" in open_functions) == (not iterates)
    assert "close" not in open_functions


@needs_compiler
@pytest.mark.parametrize("name", ROBOTS)
def test_a_build_checks_itself(built, name: str) -> None:
    said = run(built(name).folder, "./test_vectors")
    assert said.count(" 10 of 10 as the library") == 6


@needs_compiler
@pytest.mark.parametrize("name", ROBOTS)
def test_nothing_is_allocated_or_printed(built, name: str) -> None:
    here = built(name)
    lines = run(here.folder, "nm", "model.o").splitlines()
    needed = {line.split()[-1] for line in lines if " U " in line}
    assert needed <= {"copysign", "cos", "fabs", "rint", "sin", "sincos", "sqrt"}
    assert not [line for line in lines if re.search(r" [bBdDC] (?!.*coordinate_names)", line)]


@needs_compiler
def test_angles_and_turns_are_those_of_the_c_library(tmp_path: Path) -> None:
    """All signs and orders of size, zeros and what is not finite."""
    head = "#include <float.h>\n#include <math.h>\n"
    ends = "double angle_of(double y, double x) { return angle(y, x); }\n"
    ends += "double nearest_to(double x) { return nearest(x); }\n"
    (tmp_path / "angle.c").write_text(head + ANGLE + NEAREST + ends, encoding="utf-8")
    run(tmp_path, "gcc", "-std=c99", *WARNINGS, "-O1", "-fPIC", "-shared", "angle.c", "-o", "it.so")
    library = ctypes.CDLL(str(tmp_path / "it.so"))
    for name, count in (("angle_of", 2), ("nearest_to", 1)):
        getattr(library, name).argtypes = [ctypes.c_double] * count
        getattr(library, name).restype = ctypes.c_double
    rng = np.random.default_rng(0)
    sizes = 10.0 ** rng.uniform(-9.0, 9.0, (4000, 2))
    points = [*(sizes * rng.choice([-1.0, 1.0], (4000, 2))), *rng.normal(size=(4000, 2))]
    points += [np.array(pair) for pair in product([0.0, 1.0, -1.0, 1e-300, np.nan], repeat=2)]
    for y, x in points:
        wanted = np.arctan2(y, x)
        got = library.angle_of(y, x)
        assert got == pytest.approx(wanted, rel=4e-16, abs=0.0, nan_ok=True), (y, x)
        assert library.nearest_to(x) == pytest.approx(np.rint(x), rel=0.0, abs=0.0, nan_ok=True)


@needs_compiler
@pytest.mark.parametrize("name", ROBOTS)
def test_it_is_cpp_too(built, name: str) -> None:
    here = built(name)
    flags = ("-std=c++17", "-x", "c++", *WARNINGS, "-fsyntax-only")
    run(here.folder, "g++", *flags, f"{here.prefix}.c")


@needs_compiler
@pytest.mark.sweep(sample="test_a_build_checks_itself")
@pytest.mark.parametrize("name", ["ankle", "forging_chu2020", "staicu2015"])
@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_sanitizers_find_nothing(built, name: str, compiler: str) -> None:
    if shutil.which(compiler) is None:
        pytest.skip(f"there is no {compiler}")
    here = built(name)
    flags = ("-std=c99", *WARNINGS, "-g", "-fsanitize=address,undefined")
    sources = (f"{here.prefix}.c", "test_vectors.c")
    run(here.folder, compiler, *flags, *sources, "-lm", "-o", "sanitized")
    run(here.folder, "./sanitized")


@needs_compiler
@pytest.mark.parametrize("name", ROBOTS)
def test_failures_leave_everything_alone(built, name: str) -> None:
    here = built(name)
    n, n_s = len(here.robot.active), len(here.robot.coordinates)
    start = here.robot.close(here.robot.reference).s
    still = np.zeros(n)
    nan = np.full(n, np.nan)
    cases = {
        "u": ([nan, still, start], {NOT_FINITE}),
        "du": ([here.robot.reference, nan, start], {NOT_FINITE}),
        "guess": ([here.robot.reference, still, np.full(n_s, np.inf)], {NOT_FINITE}),
        "far": ([here.robot.reference + 1e6, still, start], {NOT_CLOSED, SINGULAR, JUMP, OK}),
    }
    if here.robot.follows:
        open_guess = start + np.where(np.arange(n_s) < n, 0.0, 0.4)
        cases["open"] = ([here.robot.reference, still, open_guess], {NOT_CLOSED, SINGULAR, JUMP})
    for case, (inputs, wanted) in cases.items():
        answer = here.call("close", inputs, [n_s, n_s])
        assert answer.status in wanted, case
        assert answer.status == OK or answer.is_untouched(inputs[-1]), case


@needs_compiler
def test_a_jump_is_refused_and_small_steps_are_followed(built) -> None:
    """Where the loops iterate, a long way is gone in steps, each from the guess of the last."""
    here = built("ankle")
    n_s = len(here.robot.coordinates)
    goal = here.robot.limits[:, 1] * 0.8
    guess = here.robot.close(here.robot.reference).s
    still = np.zeros(2)
    assert here.call("close", [goal * 4.0, still, guess], [n_s, n_s]).status in (NOT_CLOSED, JUMP)
    for part in np.linspace(0.0, 1.0, 60):
        u = here.robot.reference + part * (goal - here.robot.reference)
        answer = here.call("close", [u, still, guess], [n_s, n_s])
        assert answer.status == OK
        guess = answer.guess
    assert guess == pytest.approx(here.robot.close(goal).s, abs=1e-12)


@needs_compiler
@pytest.mark.sweep(sample="test_numbers_are_those_of_the_library")
def test_a_robot_without_masses_has_a_status_for_it(built) -> None:
    here = built("staicu2015")
    near, state = states(here.robot, 1)
    u, du, guess = state.u[0], state.du[0], near.s[0]
    answer = here.call("forward_dynamics", [u, du, np.ones(6), [0, 0, -9.8], guess], [6])
    assert answer.status == SINGULAR_MASS
    assert answer.is_untouched(guess)


HOSTILE = """
<robot name="3 */ arm">
  <link name="a"/>
  <link name="b"><inertial><origin xyz="0 0 1"/><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="c"/>
  <joint name="arm/q-1" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name='arm q*/1"??/' type="prismatic"><parent link="b"/><child link="c"/>
    <axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>
"""


@needs_compiler
def test_names_of_a_file_cannot_become_code(tmp_path: Path) -> None:
    file = tmp_path / "hostile.urdf"
    file.write_text(HOSTILE, encoding="utf-8")
    here = build(load(file), tmp_path)
    header = (tmp_path / f"{here.prefix}.h").read_text(encoding="utf-8")
    assert "_Q_arm_q_1 = 0, /* u [rad] arm/q-1 */" in header
    assert "_Q_arm_q_1_2 = 1 /*" in header
    assert names_in(here) == here.robot.coordinates


def names_in(here: Built) -> tuple[str, ...]:
    """The names of the coordinates in the library."""
    kind = ctypes.c_char_p * len(here.robot.coordinates)
    names = kind.in_dll(here.library, f"{here.prefix}_coordinate_names")
    return tuple(name.decode() for name in names)


@examples(200)
@given(st.lists(st.text(min_size=1, max_size=6), min_size=1, max_size=6, unique=True))
def test_any_names_become_different_identifiers(names: list[str]) -> None:
    made = identifiers(names)
    assert len(set(made.values())) == len(names)
    for name, text in made.items():
        assert re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", f"Q_{text}")
        assert re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", identifier(name))
        assert re.fullmatch(r"[A-Za-z0-9_./<>+-]*", comment(name))
        assert re.fullmatch(r'"([A-Za-z0-9_./-]|\\[0-3][0-7]{2})*"', literal(name))


BAD = {
    "program": (["--programs", "close,reaction"], "there is no program 'reaction'"),
    "no program": (["--programs", ","], "no program is named"),
    "parent": (["-o", "none/folder"], "there is no folder none"),
    "file": (["-o", "file"], "file: is a file"),
    "others": (["-o", "others"], "others: has other files, such as notes.txt"),
    "again": (["-o", "again"], "again: has five_bar.c already"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_writes_nothing(
    case: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("others/notes.txt", "again/five_bar.c", "file"):
        Path(name).parent.mkdir(exist_ok=True)
        Path(name).write_text("mine", encoding="utf-8")
    before = sorted(tmp_path.rglob("*"))
    words, wanted = BAD[case]
    given_folder = [] if "-o" in words else ["-o", "new"]
    said = CliRunner().invoke(app, ["export", "five_bar", "--format", "c", *given_folder, *words])
    assert said.exit_code == 2
    assert said.output.count("\n") == 1
    assert wanted in said.output
    assert sorted(tmp_path.rglob("*")) == before


def test_some_programs_only() -> None:
    files = to_c(load("five_bar"), ["jacobian"])
    assert "int five_bar_jacobian(" in files["five_bar.h"]
    assert "five_bar_close(" not in files["five_bar.h"]
    with pytest.raises(InputError, match="there is no program 'jacobien'"):
        to_c(load("five_bar"), ["jacobien"])


def test_formats_without_programs_say_so() -> None:
    said = CliRunner().invoke(app, ["export", "five_bar", "--programs", "close"])
    assert said.exit_code == 2
    assert "--programs belongs to --format c" in said.output
