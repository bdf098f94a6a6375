"""What tools/environment.py prints of its steps, each of them once."""

from __future__ import annotations

import importlib
import importlib.util
import shutil
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
    monkeypatch.syspath_prepend(str(ROOT / "tools"))
    spec.loader.exec_module(module)
    monkeypatch.setattr(module, "Process", Finished)
    monkeypatch.setattr(module.installer, "uv_program", lambda: None)
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


@pytest.mark.parametrize(
    ("listed", "variables"),
    [
        ("", {}),
        ("global.timeout='60'\ninstall.no-compile='true'", {"UV_HTTP_TIMEOUT": "60"}),
        (
            "freeze.timeout='10'\n:env:.cert='/a.pem'\nglobal.cert='/b.pem'",
            {"SSL_CERT_FILE": "/a.pem"},
        ),
        ("global.extra-index-url='\\nfile:///a\\nfile:///b'", {"UV_INDEX": "file:///a file:///b"}),
        (
            "global.find-links='/a /b'\nglobal.constraint='/c'",
            {"UV_FIND_LINKS": "/a,/b", "UV_CONSTRAINT": "/c"},
        ),
    ],
)
def test_what_pip_is_told_of_places_and_versions_uv_is_told_too(
    environment: ModuleType, listed: str, variables: dict[str, str]
) -> None:
    strategy = {"UV_INDEX_STRATEGY": "unsafe-best-match"}
    assert environment.installer.as_uv_has_them(listed) == {**strategy, **variables}


@pytest.mark.parametrize("listed", ["global.pre='true'", "install.no-binary=':all:'"])
def test_pip_installs_where_uv_has_no_word_for_a_setting(
    environment: ModuleType, listed: str
) -> None:
    assert environment.installer.as_uv_has_them(listed) is None


@pytest.mark.usefixtures("environment")
def test_what_one_program_failed_to_do_the_next_one_does(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    module = importlib.import_module("watched_process")
    monkeypatch.setattr(module, "discard", shutil.rmtree)
    fails, works = [
        [sys.executable, "-c", f"print({code}); raise SystemExit({code})"] for code in (1, 0)
    ]
    log = tmp_path / "log"
    module.Process([fails, works], log, {}).finish("It is tried")
    assert "another way is tried" in capsys.readouterr().out
    assert log.read_text() == "0\n"
    with pytest.raises(SystemExit, match="This failed"):
        module.Process([fails], log, {}).finish("It is tried")
