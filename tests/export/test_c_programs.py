"""C code on request: reactions, derivatives, steps, hydraulics; loads as arguments; float; C++."""

from __future__ import annotations

import ctypes
import shutil
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest
from click.testing import CliRunner

from hybrid_dynamics_cli.app import app
from hybrid_dynamics_core import (
    HydraulicCylinder,
    InputError,
    Robot,
    SingularityError,
    load,
    shipped_robots,
)
from hybrid_dynamics_core.export import to_c
from hybrid_dynamics_core.formats.c import parts, shared, writer
from hybrid_dynamics_core.formats.c.calls import CALLS
from hybrid_dynamics_core.formats.c.names import identifier
from tests.hard_cases import linkages
from tests.sampling import MORE_EXAMPLES, swept

from .c_builds import WARNINGS, Built, build, needs_compiler, run, states
from .c_requests import names_for, requested

ROBOTS = swept(shipped_robots(), ("five_bar",))
COUNT = 1000 if MORE_EXAMPLES else 100  # states of a robot
# Robots whose code is optimised with every option: closed forms and Newton's iteration. Only then
# gcc finds what may have no value. That of others is optimised with the default options.
OPTIMISED = ("ankle", "excavator", "type_c")

OK, SINGULAR = 0, 2


@needs_compiler
@pytest.mark.parametrize("name", ROBOTS)
def test_programs_on_request_are_those_of_the_library(name: str, tmp_path: Path) -> None:
    robot = load(name)
    here = build(robot, tmp_path, names_for(robot))
    near, state = states(robot, COUNT)
    for function, (inputs, outputs) in requested(robot, state, seed=1).items():
        flat = [np.reshape(out, (COUNT, -1)) for out in outputs]
        sizes = [out.shape[1] for out in flat]
        scales = [max(1.0, np.nanmax(np.abs(out))) for out in flat]
        for k in range(COUNT):
            answer = here.call(function, [*(x[k] for x in inputs), near.s[k]], sizes)
            assert answer.status == OK, (function, k)
            for got, wanted, scale in zip(answer.outs, flat, scales, strict=True):
                same = np.isnan(wanted[k]) | (np.abs(got - wanted[k]) <= 1e-12 * scale)
                assert same.all(), (function, k)
                assert (np.isnan(got) == np.isnan(wanted[k])).all(), (function, k)


def every(robot: Robot) -> list[str]:
    return [call.name for call in CALLS if not call.lacks(robot)]


@needs_compiler
@pytest.mark.parametrize("name", swept(shipped_robots(), ("type_c",)))
@pytest.mark.parametrize(
    "options",
    [
        pytest.param({"real": "float"}, marks=pytest.mark.sweep),
        pytest.param({"loads": "arguments"}, marks=pytest.mark.sweep),
        {"real": "float", "loads": "arguments"},
    ],
    ids=str,
)
def test_every_option_checks_itself(name: str, options: dict[str, str], tmp_path: Path) -> None:
    """The vectors are answers of the library, with random payloads and friction as arguments."""
    robot = load(name)
    names = every(robot) if name != "type_c" else ["inverse_dynamics", "minimal_form"]
    build(robot, tmp_path, names, fast=name not in OPTIMISED, **options)
    said = run(tmp_path, "./test_vectors")
    assert said.count(" 10 of 10 as the library") == len(names)


@needs_compiler
@pytest.mark.parametrize("name", ["type_c", pytest.param("ankle", marks=pytest.mark.sweep)])
def test_long_functions_are_split_and_share_what_they_need(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As those of large robots: here with small bounds on a small robot."""
    robot = load(name)
    names = ["close", "inverse_dynamics", "jacobian", "reactions", "ik_step"]
    apart = len(to_c(robot, names)[f"{name}.c"])
    monkeypatch.setattr(writer, "LARGE", 0)
    monkeypatch.setattr(shared, "LEAST", 20)
    assert len(to_c(robot, names)[f"{name}.c"]) < apart
    monkeypatch.setattr(parts, "LONGEST", 2000)
    build(robot, tmp_path, names, fast=True)
    text = (tmp_path / f"{name}.c").read_text(encoding="utf-8")
    assert "static void shared0(" in text
    assert "PART void " in text
    said = run(tmp_path, "./test_vectors")
    assert said.count(" 10 of 10 as the library") == len(names)


@needs_compiler
def test_float_has_no_double(tmp_path: Path) -> None:
    """The compiler warns of each promotion; nothing of double precision is called."""
    robot = load("type_c")
    for name, text in to_c(robot, ["inverse_dynamics"], real="float").items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    flags = ("-std=c99", *WARNINGS, "-Wdouble-promotion", "-Wfloat-conversion", "-O1")
    run(tmp_path, "gcc", *flags, "-c", "type_c.c", "-o", "model.o")
    needed = [line.split()[-1] for line in run(tmp_path, "nm", "model.o").splitlines()]
    assert not {"sin", "cos", "sqrt", "atan2", "sincos"} & set(needed)
    assert "double" not in (tmp_path / "type_c.c").read_text(encoding="utf-8")


@needs_compiler
@pytest.mark.parametrize("size", [1e-3, 1e-2])
def test_small_loops_are_regular_in_single_precision_too(size: float, tmp_path: Path) -> None:
    """The distance to a singularity has no unit, whatever the bars measure."""
    bar = linkages.robot(linkages.four_bar(5.0 * size, 2.0 * size, 4.0 * size, 3.0 * size))
    assert float(bar.close(bar.reference).singularity) > 0.1
    build(bar, tmp_path, ["close", "jacobian"], fast=True, real="float")
    assert run(tmp_path, "./test_vectors").count(" 10 of 10 as the library") == 2


@needs_compiler
@pytest.mark.sweep(sample="test_programs_on_request_are_those_of_the_library")
def test_steps_reach_a_pose(tmp_path: Path) -> None:
    robot = load("gough")
    here = build(robot, tmp_path, ["ik_step", "forward_kinematics"])
    goal = robot.close(robot.reference + 0.03 * np.array([1, -1, 1, 1, -1, 0.5]))
    wanted = robot.forward_kinematics(goal)
    u, guess = robot.reference, robot.close(robot.reference).s
    for _ in range(8):
        rotation = np.ravel(wanted.rotation)
        inputs = [u, wanted.position, rotation, np.ones(6), guess]
        answer = here.call("ik_step", inputs, [6, 6])
        assert answer.status == OK
        u, guess = answer.outs[0], answer.guess
    assert u == pytest.approx(goal.u, abs=1e-10)


SPANS = """\
#include "type_c.hpp"
#include <cstdio>
#include <vector>
namespace model = type_c_model;
int main()
{
    auto guess = model::reference();
    std::array<model::real, 3> u{{guess[0], guess[1], guess[2]}}, zero{{0, 0, 0}}, tau{{0, 0, 0}};
    model::real J[18] = {0};
    int bad = model::inverse_dynamics(u, zero, zero, type_c_gravity, guess, tau);
    bad += model::jacobian(u, guess, J);
    std::array<model::real, 3> again{{0, 0, 0}};
    bad += model::inverse_dynamics(u, zero, zero, type_c_gravity, again);
    bad += again != tau;
#if defined(__cpp_lib_span)
    std::vector<double> many{0.0, 0.0, 0.0};
    std::span<double, 3> effort(many);
    bad += model::inverse_dynamics(u, zero, zero, type_c_gravity, guess, effort);
    bad += effort[1] != tau[1];
#endif
#if defined(EIGEN_CORE_H) || defined(EIGEN_CORE_MODULE_H)
    Eigen::Matrix<double, 6, 3, Eigen::RowMajor> rows;
    Eigen::Vector3d same(u.data());
    bad += model::jacobian(same, guess, rows);
    bad += rows(1, 2) != J[5];
#endif
    if (bad == 0) {
        std::puts(model::status_text(bad));
    }
    return bad;
}
"""


@needs_compiler
@pytest.mark.sweep(sample="test_a_wrong_length_does_not_compile")
@pytest.mark.parametrize(
    ("compiler", "standard", "with_eigen"),
    [
        ("g++", "c++17", False),
        ("g++", "c++20", True),
        ("clang++", "c++17", True),
        ("clang++", "c++20", False),
    ],
)
def test_the_cpp_face(compiler: str, standard: str, with_eigen: bool, tmp_path: Path) -> None:
    if shutil.which(compiler) is None:
        pytest.skip(f"there is no {compiler}")
    for name, text in to_c(load("type_c"), ["inverse_dynamics", "jacobian"]).items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    if with_eigen and not Path("/usr/include/eigen3/Eigen/Core").exists():
        pytest.skip("there is no Eigen")
    head = "#include <Eigen/Core>\n" if with_eigen else ""
    (tmp_path / "face.cpp").write_text(head + SPANS, encoding="utf-8")
    flags = (f"-std={standard}", *WARNINGS, "-isystem", "/usr/include/eigen3")
    sources = ("-x", "c++", "face.cpp", "type_c.c", "-x", "none", "-lm")
    run(tmp_path, compiler, *flags, *sources, "-o", "face")
    assert run(tmp_path, "./face") == "done\n"


@needs_compiler
def test_a_wrong_length_does_not_compile(tmp_path: Path) -> None:
    for name, text in to_c(load("type_c"), ["jacobian"]).items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    (tmp_path / "short.cpp").write_text(
        '#include "type_c.hpp"\nint main() { auto guess = type_c_model::reference();\n'
        "std::array<double, 2> u{{0, 0}}; double J[18];\n"
        "return type_c_model::jacobian(u, guess, J); }\n",
        encoding="utf-8",
    )
    with pytest.raises(AssertionError, match="std::array<double, 2"):
        run(tmp_path, "g++", "-std=c++17", "-fsyntax-only", "short.cpp")


AARCH64 = ("aarch64-linux-gnu-gcc", "qemu-aarch64")


@pytest.mark.skipif(
    not all(map(shutil.which, AARCH64)), reason=f"there is no {' or '.join(AARCH64)}"
)
@pytest.mark.sweep(sample="test_every_option_checks_itself")
@pytest.mark.parametrize("name", ["type_c", "ankle", "forging_chu2020", "staicu2015"])
def test_another_processor_has_the_same_numbers(name: str, tmp_path: Path) -> None:
    robot = load(name)
    for file, text in to_c(robot).items():
        (tmp_path / file).write_text(text, encoding="utf-8")
    flags = ("-std=c99", *WARNINGS, "-O1", "-static")
    sources = (f"{identifier(robot.name)}.c", "test_vectors.c", "-lm")
    run(tmp_path, AARCH64[0], *flags, *sources, "-o", "test_vectors")
    said = run(tmp_path, AARCH64[1], "./test_vectors")
    assert said.count(" 10 of 10 as the library") == 6


def arm_with_cylinders() -> Robot:
    """The forging robot by its arm angles; cylinders push on passive joints."""
    forging = load("forging_chu2020").description
    cylinder = HydraulicCylinder("stroke", bore=0.05, rod=0.03)
    closures = []
    for closure in forging.closures:
        is_free = closure.assembly != "parallelogram"
        closures.append(replace(closure, assembly=None) if is_free else closure)
    changed = replace(
        forging,
        active=("q1", "q2", "q3", "q4"),
        actuators=MappingProxyType({"q12": cylinder, "q22": cylinder}),
        closures=tuple(closures),
    )
    return Robot(changed)


@needs_compiler
@pytest.mark.sweep(sample="test_what_a_robot_lacks_is_one_line")
def test_drives_that_cannot_give_every_effort_have_a_status(tmp_path: Path) -> None:
    """Where a cylinder is in line with its pivots it has no lever."""
    robot = arm_with_cylinders()
    here = build(robot, tmp_path, ["hydraulics"])
    assert names_of(here, "cylinder") == list(robot.cylinders)
    tau, sizes = np.ones(4), [2] * 9
    state = robot.close(robot.reference, np.full(4, 0.1))
    answer = here.call("hydraulics", [state.u, state.du, tau, state.s], sizes)
    assert answer.status == OK
    cylinders = robot.hydraulics(state, tau)
    for k, cylinder in enumerate(cylinders.values()):
        assert answer.outs[0][k] == pytest.approx(float(cylinder.force), rel=1e-12)
        assert answer.outs[1][k] == pytest.approx(float(cylinder.cap_pressure), rel=1e-12)
    dead = robot.close([0.0, 0.0, -1.2, 0.0], check=False)
    assert dead.status == 0
    with pytest.raises(SingularityError, match="cannot give every tau"):
        robot.hydraulics(dead, tau)
    answer = here.call("hydraulics", [dead.u, dead.du, tau, dead.s], sizes)
    assert answer.status == SINGULAR
    assert answer.is_untouched(dead.s)


def names_of(here: Built, kind: str) -> list[str]:
    """Names that the library lists."""
    names = (ctypes.c_char_p * len(here.robot.cylinders)).in_dll(
        here.library, f"{here.prefix}_{kind}_names"
    )
    return [name.decode() for name in names]


LACKING = {
    "reactions": ("staicu2015", "staicu2015: no link has a mass"),
    "forward_dynamics_derivatives": ("staicu2015", "staicu2015: no link has a mass"),
    "hydraulics": ("five_bar", "five_bar: no joint has a hydraulic cylinder"),
}


@pytest.mark.parametrize("program", LACKING)
def test_what_a_robot_lacks_is_one_line(program: str, tmp_path: Path) -> None:
    name, wanted = LACKING[program]
    words = ["export", name, "--format", "c", "-o", str(tmp_path / "new"), "--programs", program]
    said = CliRunner().invoke(app, words)
    assert said.exit_code == 2
    assert said.output.count("\n") == 1
    assert wanted in said.output
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("option", ["real", "loads"])
def test_options_are_checked(option: str) -> None:
    wrong = {option: "half"}
    with pytest.raises(InputError, match=f"{option}: 'half': expected"):
        to_c(load("five_bar"), ["close"], **wrong)
    said = CliRunner().invoke(app, ["export", "five_bar", f"--{option}", "half"])
    assert said.exit_code == 2
