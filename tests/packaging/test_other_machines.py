"""The core and the command use nothing that only Linux has."""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TypeGuard

import pytest
import yaml

from hybrid_dynamics_core.ground.worker_limits import IDLE, environment

ROOT = Path(__file__).parents[2]
LIMITS = ROOT / "hybrid_dynamics_core" / "ground" / "worker_limits.py"
MODULES = {"fcntl", "grp", "posix", "pty", "pwd", "resource", "syslog", "termios", "tty"}
NAMES = {  # "os.fork" and its like; those in GUARDED are asked for first
    "os": {
        *("chown", "fork", "forkpty", "getgid", "getpgid", "getuid", "killpg", "mkfifo", "nice"),
        *("sched_getaffinity", "sched_setaffinity", "setsid", "sysconf", "uname", "wait"),
    },
    "signal": {"SIGALRM", "SIGHUP", "SIGKILL", "SIGUSR1", "alarm", "pthread_kill", "setitimer"},
}
GUARDED = {("cache.py", "os.getuid"), ("worker_limits.py", "signal.alarm")}
FOLDERS = tuple(f"/{name}/" for name in ("proc", "sys", "tmp", "usr", "etc", "home"))

SUSPECT = re.compile(  # what is worth parsing
    rf"\b(?:{'|'.join(sorted(MODULES))})\b|\b(?:os|signal)\.|[\"'](?:{'|'.join(FOLDERS)})"
)


def sources() -> list[Path]:
    packages = ("hybrid_dynamics_core", "hybrid_dynamics_cli")
    return [path for package in packages for path in sorted(ROOT.glob(f"{package}/**/*.py"))]


def used(path: Path) -> Iterator[str]:
    """Modules, names and folders in a file that not every system has."""
    text = path.read_text(encoding="utf-8")
    if not SUSPECT.search(text):
        return
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in MODULES)
        elif isinstance(node, ast.ImportFrom) and node.module in MODULES:
            yield node.module
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            if node.attr in NAMES.get(node.value.id, ()):
                yield f"{node.value.id}.{node.attr}"
        elif is_text(node) and node.value.startswith(FOLDERS):
            yield node.value


def is_text(node: ast.AST) -> TypeGuard[ast.Constant]:
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def test_nothing_is_of_one_system() -> None:
    wrong = []
    paths = sources()
    for path in paths:
        wrong += [(path.name, name) for name in used(path) if (path.name, name) not in GUARDED]
    assert len(paths) > 400
    assert wrong == []


def elsewhere(text: str) -> subprocess.CompletedProcess[str]:
    """Run a text as on a system without limits, alarms and users."""
    head = f"""
import os, runpy, signal, sys
sys.modules["resource"] = None
for module, name in ((signal, "alarm"), (os, "getuid"), (os, "sched_getaffinity")):
    if hasattr(module, name):
        delattr(module, name)
limits = runpy.run_path({str(LIMITS)!r})
"""
    variables = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.run(
        [sys.executable, "-c", head + text],
        capture_output=True,
        text=True,
        env=variables,
        check=False,
    )


def test_workers_start_where_there_are_no_limits() -> None:
    done = elsewhere(
        "limits['close_off'](10**9); limits['limit_computing'](1); limits['limit']('CPU', 1)\n"
        "with limits['IdleAlarm'](60):\n    pass\n"
        "open(os.devnull).close(); print('goes on')\n"
    )
    assert done.stdout == "goes on\n", done.stderr


def test_an_idle_worker_ends_without_alarms() -> None:
    done = elsewhere("with limits['IdleAlarm'](0):\n    import time; time.sleep(60)\n")
    assert done.returncode == IDLE, done.stderr


@pytest.mark.sweep(sample="test_workers_start_where_there_are_no_limits")
def test_robots_are_computed_and_kept_without_users() -> None:
    done = elsewhere(
        "from hybrid_dynamics_core import load\n"
        "robot = load('five_bar')\n"
        "state = robot.close(robot.reference)\n"
        "print(len(robot.inverse_dynamics(state, [0.0, 0.0, 0.0])))\n"
    )
    assert done.stdout == "3\n", done.stderr


def test_workers_get_what_windows_needs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SYSTEMROOT", "C:\\Windows")
    monkeypatch.setenv("SECRET", "1")
    assert environment({"A": "b"}) == {"SYSTEMROOT": "C:\\Windows", "A": "b"}


@pytest.mark.parametrize("path", sorted((ROOT / ".github").glob("**/*.yml")), ids=lambda x: x.name)
def test_workflows_can_be_read(path: Path) -> None:
    jobs = yaml.safe_load(path.read_text(encoding="utf-8"))["jobs"]
    for job in jobs.values():
        assert all("uses" in step or "run" in step for step in job["steps"])
