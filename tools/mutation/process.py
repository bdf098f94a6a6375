"""Runs of pytest in forks of one process that has imported the large libraries once."""

from __future__ import annotations

import contextlib
import importlib
import importlib.util
import os
import resource
import signal
import sys
import time
import traceback
from collections.abc import Callable, Collection
from pathlib import Path

import pytest
from hypothesis import Phase, settings

LIBRARIES = (
    "click.testing",
    "hypothesis.strategies",
    "jsonschema",
    "matplotlib.pyplot",
    "mujoco",
    "pinocchio",
    "rosbags.rosbag2",
    "scipy.integrate",
    "scipy.optimize",
    "scipy.signal",
    "scipy.spatial",
    "yaml",
)
# The fork has imported plugins that pytest would rather import itself.
OPTIONS = ("-q", "-p", "no:cacheprovider", "-W", "ignore::pytest.PytestAssertRewriteWarning")
MEMORY = 6 << 30  # [byte]: a mutant may ask for any amount
POLL = 0.02  # [s]


def import_libraries() -> None:
    """Import what most tests need, so that forks have it."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    for name in LIBRARIES:
        if importlib.util.find_spec(name.partition(".")[0]):
            importlib.import_module(name)


class Chosen:
    """A plugin of pytest: these tests alone, file by file, the quickest first.

    Random examples that fail are not made smaller: nobody reads them.
    """

    def __init__(self, tests: Collection[str], seconds: dict[str, float]) -> None:
        self._tests, self._seconds = tests, seconds

    def pytest_collection(self) -> None:
        """Set Hypothesis once conftest.py has."""
        settings.register_profile("mutation", phases=[Phase.explicit, Phase.generate])
        settings.load_profile("mutation")

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Leave out and sort."""
        items[:] = [item for item in items if item.nodeid in self._tests]
        files: dict[Path, float] = {}
        for item in items:
            files[item.path] = files.get(item.path, 0.0) + self._seconds[item.nodeid]
        items.sort(key=lambda item: (files[item.path], item.path))


def run(
    folder: Path,
    arguments: Collection[str],
    plugin: Callable[[], object],
    environment: dict[str, str],
    patience: float,
    log: Path,
) -> int | None:
    """Run pytest in a fork.

    Args:
        folder: checkout to work in.
        arguments: of pytest.
        plugin: is called in the fork for a plugin of pytest.
        environment: variables for it.
        patience: [s] after which it is ended.
        log: file for what it prints.

    Returns:
        The exit code; None where it took too long.
    """
    sys.stdout.flush()
    number = os.fork()
    if not number:
        _work(folder, arguments, plugin, environment, log)
    end = time.monotonic() + patience
    try:
        while time.monotonic() < end:
            done, status = os.waitpid(number, os.WNOHANG)
            if done:
                return os.waitstatus_to_exitcode(status)
            time.sleep(POLL)
        return None
    finally:  # with all that it started
        with contextlib.suppress(ProcessLookupError):
            os.killpg(number, signal.SIGKILL)
        with contextlib.suppress(ChildProcessError):
            os.waitpid(number, 0)


def _work(
    folder: Path,
    arguments: Collection[str],
    plugin: Callable[[], object],
    environment: dict[str, str],
    log: Path,
) -> None:
    code = 70
    try:
        os.setsid()
        resource.setrlimit(resource.RLIMIT_DATA, (MEMORY, MEMORY))
        output = os.open(log, os.O_CREAT | os.O_WRONLY | os.O_TRUNC)
        os.dup2(output, 1)
        os.dup2(output, 2)
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        os.chdir(folder)
        os.environ.update({"PYTHONPATH": str(folder), **environment})
        sys.path[:0] = [str(folder)]
        code = int(pytest.main([*OPTIONS, *arguments], [plugin()]))
    except BaseException:  # noqa: BLE001  whatever it is, it ends this process alone
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)
