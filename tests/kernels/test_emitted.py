"""Generated code holds numbered names and numbers only; long programs come in parts."""

from __future__ import annotations

import builtins
import logging
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest

from hybrid_dynamics_core import Robot, load, programs
from hybrid_dynamics_core.algebra.scalar import cos, sin
from hybrid_dynamics_core.kernels import caller, extension, native, run
from hybrid_dynamics_core.kernels.emit_numpy import emit_columns
from hybrid_dynamics_core.kernels.emit_python import emit_scalar
from hybrid_dynamics_core.kernels.ir import parts
from hybrid_dynamics_core.kernels.ir.entry import Header
from hybrid_dynamics_core.kernels.ir.module import module_text
from hybrid_dynamics_core.kernels.run import Kernel
from hybrid_dynamics_core.kernels.trace import Check, Results
from tests.kernels.programs_of import BACKENDS, inputs, kernel
from tests.robots import random_states
from tests.sampling import swept

HOSTILE = 'x")\nimport os; os.abort()  # %s {0} ; ret void }'


def renamed(robot: Robot) -> Robot:
    """The robot with names that no loader would let through."""
    d = robot.description
    name = {
        n: f"{HOSTILE}{k}"
        for k, n in enumerate([*d.joints, *d.links, *(c.name for c in d.closures)])
    }
    name[d.base] = d.base
    joints = {
        name[n]: replace(j, name=name[n], parent=name[j.parent], child=name[j.child])
        for n, j in d.joints.items()
    }
    links = {name[n]: replace(link, name=name[n]) for n, link in d.links.items()}
    closures = tuple(
        replace(c, name=name[c.name], link_a=name[c.link_a], link_b=name[c.link_b])
        for c in d.closures
    )
    frames = {n: replace(f, link=name[f.link]) for n, f in d.frames.items()}
    return Robot(
        replace(
            d,
            name=HOSTILE,
            joints=MappingProxyType(joints),
            links=MappingProxyType(links),
            closures=closures,
            loops=MappingProxyType({}),
            frames=MappingProxyType(frames),
            active=tuple(name[n] for n in d.active),
            reference=MappingProxyType({name[n]: v for n, v in d.reference.items()}),
        )
    )


def test_no_name_of_a_description_reaches_the_code(monkeypatch: pytest.MonkeyPatch) -> None:
    hostile, plain = renamed(load("forging_chu2020")), load("forging_chu2020")
    written: list[Any] = []
    compiled = builtins.compile

    def note(source: Any, *rest: Any, **options: Any) -> Any:
        written.append(source)
        return compiled(source, *rest, **options)

    monkeypatch.setattr(builtins, "compile", note)
    for robot in (hostile, plain):
        call = robot.kernels.inverse_dynamics
        u = np.array([0.3, 0.15, 0.175, 0.4])
        assert np.isfinite(call(u, u, u)).all()
        trace = robot.kernel("inverse_dynamics", programs.inverse_dynamics()).trace
        for emit in (emit_scalar, emit_columns):
            compiled(emit(trace), "<test>", "exec")
    assert "os.abort" not in str(written)
    a, b = (
        r.kernel("inverse_dynamics", programs.inverse_dynamics()).trace for r in (hostile, plain)
    )
    assert emit_scalar(a) == emit_scalar(b)
    assert emit_columns(a) == emit_columns(b)
    for form in ("one", "rows"):
        assert module_text(a, form, 4, Header(16)) == module_text(b, form, 4, Header(16))


@pytest.mark.parametrize("name", ["forging_chu2020", "seven_bar"])
def test_generated_python_is_names_with_numbers(name: str) -> None:
    trace = kernel(name, "inverse", "python").trace
    functions = {
        "sin",
        "cos",
        "sqrt",
        "fabs",
        "rint",
        "atan2",
        "invert",
        "newton",
        "absolute",
        "arctan2",
        "divide",
    }
    functions |= {
        "add",
        "subtract",
        "multiply",
        "negative",
        "greater",
        "logical_not",
        "kernel",
        "ROWS",
    }
    keywords = {"def", "return", "if", "not", "status", "scratch", "out", "inf", "nan"}
    for source in (emit_scalar(trace), emit_columns(trace)):
        words = set(re.findall(r"[A-Za-z_]\w*", re.sub(r"\d+\.?\d*e[-+]?\d+", "0", source)))
        strange = words - functions - keywords
        assert all(
            re.fullmatch(r"(v|s|o|b|a\d+_|a|body_0_|_)\d*(_\d+)*", word) for word in strange
        ), strange


def test_callers_take_names_only() -> None:
    signature = caller.Signature(["u; import os"], ["u; import os"], {}, [(1,)])
    loaders = caller.Loaders(*[lambda: lambda *_: 0] * 3)
    with pytest.raises(ValueError, match="not all names"):
        caller.make_caller(signature, loaders, lambda *_: None)


IN_PARTS = [("forging_chu2020", "minimal"), ("gough", "forward")]


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(("name", "which"), swept(IN_PARTS))
def test_a_program_in_parts_gives_the_same(
    monkeypatch: pytest.MonkeyPatch, backend: str, name: str, which: str
) -> None:
    state = random_states(name, 1)[0]
    arguments = inputs(name, which, state, 0)
    whole, _ = kernel(name, which, backend)(*arguments)
    monkeypatch.setattr(parts, "UNDIVIDED", 100)
    monkeypatch.setattr(parts, "PART", 60)
    monkeypatch.setattr(Kernel, "_identity", None)
    made = kernel(name, which, backend)
    divided = Kernel(made._program, made._sizes, backend)
    if backend == "native":
        text = module_text(divided.trace, "rows", 4, Header(16))
        assert text.count("define internal void @wide.") > 5
    values, status = divided(*arguments)
    rows, codes = divided(*(np.tile(a, (11, 1)) for a in arguments))
    assert status == 0
    assert not codes.any()
    for key, value in whole.items():
        assert values[key] == pytest.approx(value, rel=1e-12, abs=1e-12 * np.abs(value).max())
        assert rows[key][10] == pytest.approx(value, rel=1e-12, abs=1e-12 * np.abs(value).max())


@pytest.mark.skipif("native" not in BACKENDS, reason="no compiler here")
def test_a_very_long_program_is_compiled_quickly_and_says_so(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(native, "LONG", 100)
    monkeypatch.setattr(Kernel, "_identity", None)
    made = kernel("forging_chu2020", "inverse", "native")
    arguments = inputs("forging_chu2020", "inverse", random_states("forging_chu2020", 1)[0], 0)
    expected, _ = made(*arguments)
    with caplog.at_level(logging.WARNING):
        found, _ = Kernel(made._program, made._sizes, "native")(*arguments)
    assert "compiled quickly instead of well" in caplog.text
    assert found["tau"] == pytest.approx(expected["tau"], rel=1e-12)


def test_equal_operations_are_done_once() -> None:
    def run_(x: Any) -> Results:
        a, b = x
        negative = -a
        same = [sin(a) * cos(b) + 2.0 * a, cos(b) * sin(a) + a * 2.0, (a / b) * b, a / b, 3.0 / b]
        return Results(
            {"y": [*same, 0.0 * a, a - a, -negative, 1.0 * b, (a * 2.0) * 3.0]}, [Check(a, 0.0, 1)]
        )

    trace = Kernel(run_, [2]).trace
    operations = [trace.graph.nodes[i][0] for i in trace.live]
    assert operations.count("div") == 1  # of a and 3 by b: one reciprocal
    assert operations.count("sin") == operations.count("cos") == 1
    outputs = trace.outputs
    assert outputs[0].index == outputs[1].index  # type: ignore[union-attr]
    assert outputs[5:7] == (0.0, 0.0)
    assert trace.graph.nodes[outputs[9].index][2] == 6.0  # type: ignore[union-attr]


WITHOUT = """
import sys
sys.modules["llvmlite"] = None
import numpy as np
from hybrid_dynamics_core import load
robot = load("forging_chu2020")
u = np.array([0.3, 0.15, 0.175, 0.4])
print(robot.kernels.inverse_dynamics(u, u, u).tolist())
kernels = robot._kernels.kernels.values()
print({kernel.backend for kernel in kernels}, "llvmlite.binding" in sys.modules)
"""


def test_it_works_without_a_compiler() -> None:
    root = Path(__file__).resolve().parents[2]
    answer = subprocess.run(
        [sys.executable, "-c", WITHOUT], cwd=root, capture_output=True, text=True, check=True
    )
    values, backends = answer.stdout.splitlines()
    u = np.array([0.3, 0.15, 0.175, 0.4])
    assert eval(values) == pytest.approx(  # noqa: S307
        load("forging_chu2020").kernels.inverse_dynamics(u, u, u), rel=1e-12
    )
    assert backends == "{'python'} False"


def test_the_backend_can_be_chosen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(run.VARIABLE, "python")
    assert run.default_backend() == "python"
    monkeypatch.delenv(run.VARIABLE)
    assert run.default_backend() == BACKENDS[-1]


def test_a_chain_of_any_length_is_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    """Python takes 200 brackets in one another."""

    def chain(x: Any) -> Results:
        (value,) = x
        for k in range(150):
            value = (value + 0.01 * (k + 1)) * 0.99
        return Results({"y": [value]}, [])

    monkeypatch.setattr(Kernel, "_identity", None)
    expected = 0.3
    for k in range(150):
        expected = (expected + 0.01 * (k + 1)) * 0.99
    values, status = Kernel(chain, [1], "python")(np.array([0.3]))
    assert status == 0
    assert values["y"] == pytest.approx([expected], rel=1e-12)


@pytest.mark.skipif("native" not in BACKENDS, reason="no compiler here")
@pytest.mark.parametrize("width", [1, 2])
def test_a_processor_with_short_vectors_gives_the_same(
    monkeypatch: pytest.MonkeyPatch, width: int
) -> None:
    monkeypatch.setattr(native.llvm, "vector_width", lambda: width)
    monkeypatch.setattr(Kernel, "_identity", None)

    def two(x: Any, y: Any) -> Results:
        a, b = x
        (c,) = y
        return Results({"y": [sin(a) * c, a / b], "z": [a + width * c]}, [Check(b, 0.0, 7)])

    made = Kernel(two, [2, 1], "native")
    x = np.array([[0.3, 1.0], [0.4, -2.0], [0.5, 3.0]])
    y = np.array([2.0])
    values, codes = made(x, y)
    assert codes.tolist() == [0, 7, 0]
    assert values["y"][::2] == pytest.approx(
        np.stack([2.0 * np.sin(x[:, 0]), x[:, 0] / x[:, 1]], 1)[::2]
    )
    assert values["z"][::2, 0] == pytest.approx(x[::2, 0] + 2.0 * width)


def signed(a: Any, b: Any) -> list[Any]:
    """Terms in which signs and factors meet."""
    sums = [a + -b, -a + b, -a + -b, a - -b, -a - b, 2.0 - -a, 0.0 - a, -a - 3.0]
    products = [-a * -b, -a * b, a * -b, a * -1.0, -a * -2.0, (a * 2.0) * -3.0, (a * -3.0) * -0.5]
    shares = [1.0 / -a, 3.0 / -b, a / -b, -a / -b, -a / 4.0, 0.0 / a, 5.0 / (a * -b)]
    return [*sums, *products, *shares]


def test_arithmetic_of_programs_is_that_of_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Kernel, "_identity", None)
    made = Kernel(lambda x: Results({"y": signed(*x)}, []), [2], "python")
    for a, b in ((0.7, 1.9), (-1.3, 0.4)):
        values, _ = made(np.array([a, b]))
        assert values["y"] == pytest.approx(signed(a, b), rel=1e-14)


@pytest.mark.skipif(
    native.llvm.binding() is None or sys.implementation.name != "cpython", reason="no compiler here"
)
def test_machine_code_is_made_where_there_is_a_compiler() -> None:
    """Otherwise all tests of it would be left out in silence."""
    assert extension.usable()
    assert "native" in BACKENDS
