"""What tools/environment.py prints of its steps, each of them once."""

from __future__ import annotations

import importlib.util
import sys
import time
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]


class Finished:
    """Stands for a program that has ended well."""

    def __init__(self, *_: object) -> None:
        self.start = time.monotonic()

    def finish(self, title: str) -> None:
        """Print what the program does."""
        sys.stdout.write(f"{title}\n")


@pytest.fixture
def environment(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    spec = importlib.util.spec_from_file_location("environment", ROOT / "tools/environment.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, "environment", module)  # dataclasses look there
    spec.loader.exec_module(module)
    monkeypatch.setattr(module, "Process", Finished)
    monkeypatch.setattr(module, "require_build_tools", lambda: None)
    monkeypatch.setattr(module, "discard", lambda _: None)
    monkeypatch.setattr(module, "is_installed", lambda _: False)
    return module


def test_building_the_interfaces_is_said_once(
    environment: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    environment.bring(environment.interfaces(), environment.Build(tmp_path), tmp_path)
    lines = capsys.readouterr().out.splitlines()
    said = [line for line in lines if not line.endswith("done")]
    assert len(said) == len(set(said)) == 2
    assert sum("msg_defs" in line for line in said) == 1


@pytest.mark.parametrize("name", ["libraries", "test tools"])
def test_other_steps_are_said_once(
    environment: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    step = environment.STEPS[name]()
    environment.bring(step, None, tmp_path)
    said, done = capsys.readouterr().out.splitlines()
    assert said.startswith(step.title)
    assert done.endswith("done")
