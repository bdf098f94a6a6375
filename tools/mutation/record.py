"""Which test runs which line of the product, and how long it takes.

Lines that run in a process which a test starts count for all tests of its file: they may share it.
"""

from __future__ import annotations

import json
import os
import shutil
from collections import defaultdict
from collections.abc import Generator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import coverage
import pytest

from .sites import PACKAGES

VARIABLE = "MUTATION_TEST"  # names the running test to the processes that it starts
PROCESS = "process of "
SETTINGS = """[run]
parallel = true
concurrency = multiprocessing, thread
sigterm = true
data_file = {work}/data
context = {process}${{{variable}-}}
source =
    {sources}
"""


class Record(NamedTuple):
    """Of one folder of tests.

    Attributes:
        seconds: by test.
        tests: by module and line.
    """

    seconds: dict[str, float]
    tests: dict[str, dict[int, set[str]]]


class Recorder:
    """A plugin of pytest that writes the record of what it runs."""

    def __init__(self, root: Path, work: Path, target: Path) -> None:
        self._root, self._work, self._target = root, work, target
        self._seconds: dict[str, float] = defaultdict(float)
        self._failed: set[str] = set()
        shutil.rmtree(work, ignore_errors=True)  # of a run that was ended
        work.mkdir(parents=True)
        sources = "\n    ".join(str(root / package) for package in PACKAGES)
        path = work / "coverage.rc"
        text = SETTINGS.format(work=work, sources=sources, process=PROCESS, variable=VARIABLE)
        path.write_text(text, encoding="utf-8")
        os.environ["COVERAGE_PROCESS_START"] = str(path)
        os.environ[VARIABLE] = ""
        self._coverage = coverage.Coverage(config_file=str(path))
        self._coverage.start()

    @pytest.hookimpl(hookwrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None]:
        """Note the name of the test."""
        os.environ[VARIABLE] = item.nodeid
        self._coverage.switch_context(item.nodeid)
        yield

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Add up the time of a test."""
        self._seconds[report.nodeid] += report.duration
        if report.outcome != "passed":
            self._failed.add(report.nodeid)

    def pytest_sessionfinish(self) -> None:
        """Write the record."""
        self._coverage.stop()
        self._coverage.save()
        self._coverage.combine([str(self._work)])
        data = self._coverage.get_data()
        modules: dict[str, dict[int, list[str]]] = {}
        for path in data.measured_files():
            module = Path(path).relative_to(self._root).as_posix()
            modules[module] = data.contexts_by_lineno(path)
        passed = {name: t for name, t in self._seconds.items() if name not in self._failed}
        content = {"seconds": passed, "failed": sorted(self._failed), "modules": modules}
        self._target.write_text(json.dumps(content), encoding="utf-8")


@cache
def read(path: Path) -> Record:
    """A record from a file; reading takes longer than some mutants."""
    content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    seconds = content["seconds"]
    by_file: dict[str, set[str]] = defaultdict(set)
    for test in seconds:
        by_file[file_of(test)].add(test)
    tests: dict[str, dict[int, set[str]]] = defaultdict(lambda: defaultdict(set))
    for module, lines in content["modules"].items():
        for line, contexts in lines.items():
            for context in contexts:
                name = context.split("|")[-1]
                if name.startswith(PROCESS):
                    tests[module][int(line)] |= by_file[file_of(name.removeprefix(PROCESS))]
                elif name in seconds:
                    tests[module][int(line)].add(name)
    return Record(seconds, tests)


def file_of(test: str) -> str:
    """The file of a test."""
    return test.partition("::")[0]
