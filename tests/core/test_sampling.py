"""The sample of robots, with which `make test` tries what holds for all, has every kind of part."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from hybrid_dynamics_core import Robot
from tests.robots import ROBOTS, robot
from tests.sampling import SAMPLE, SHIPPED_SAMPLE, swept


@pytest.fixture(autouse=True)
def uncompiled(python_kernels: None) -> None:
    """Robots are read, and compute nothing."""


def kinds(machine: Robot) -> set[str]:
    """Kinds of its joints, of the blocks that its loops close by, and of its closures."""
    blocks = {type(block).__name__ for block in machine._model.plan.blocks}
    closures = {closure.kind for closure in machine.description.closures}
    return blocks | closures | set(machine.joint_types.values())


def test_the_sample_has_every_kind_of_joint_block_and_closure() -> None:
    every = set().union(*(kinds(robot(name)) for name in ROBOTS))
    sampled = set().union(*(kinds(robot(name)) for name in SAMPLE))
    assert sampled == every
    assert set(SHIPPED_SAMPLE) < set(ROBOTS)
    assert any(robot(name).follows for name in SHIPPED_SAMPLE)


def test_what_is_not_in_the_sample_is_a_sweep() -> None:
    cases = swept([*ROBOTS, ("delta", 1), ("gough", 2)])
    marked = {case.values for case in cases if case.marks}
    assert ("gough", 2) in marked
    assert ("delta", 1) not in marked
    assert {name for name in ROBOTS if (name,) not in marked} == set(SAMPLE)
    shipped = swept(["ankle", "delta", "gough"])
    assert [case.values for case in shipped if case.marks] == [("gough",)]


def test_each_test_that_stands_for_another_is_there() -> None:
    """`sweep(sample="...")` names the test that `make test` runs instead."""
    folder = Path(__file__).resolve().parents[1]
    text = "".join(path.read_text(encoding="utf-8") for path in folder.rglob("test_*.py"))
    names = re.findall(r'^ *@pytest\.mark\.sweep\(\s*sample="(\w+)"', text, re.MULTILINE)
    assert len(names) > 5
    assert [name for name in names if f"def {name}(" not in text] == []
