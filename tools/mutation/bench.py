"""A copy of the checkout where one mutant at a time is tried, and which tests it meets."""

from __future__ import annotations

import functools
import shutil
import time
from collections.abc import Collection
from pathlib import Path
from typing import Any, NamedTuple

from . import process, record
from .layers import WAITING, kernels_of, places_of
from .sites import Change, Site, changed

ROOT = Path(__file__).resolve().parents[2]
RECORDING = 7200.0  # [s] for a place at most
PATIENCE = 120.0  # [s] for the tests of a mutant, and
SLOWNESS = 5.0  # times what they took: one that hangs is killed
QUICK = 5.0  # [s] of tests that are tried before all others
PASSED, NOTHING_RAN = 0, 5  # exit codes of pytest
LEFT_OUT = (".git", ".venv", "build", ".*_cache")


class Tests(NamedTuple):
    """The tests of a layer.

    Attributes:
        records: of its places.
        seconds: by test.
    """

    records: list[record.Record]
    seconds: dict[str, float]

    def running(self, module: str, lines: Collection[int]) -> set[str]:
        """Those that run one of the lines, or any of the module where none is named."""
        result: set[str] = set()
        for one in self.records:
            for line, tests in one.tests[module].items():
                if line in lines or not lines:
                    result |= tests
        return result

    def quickest(self, tests: Collection[str], limit: float) -> set[str]:
        """The quickest of some, together so many seconds at most."""
        spent = 0.0
        result: set[str] = set()
        for test in sorted(tests, key=lambda test: (self.seconds[test], test)):
            spent += self.seconds[test]
            if spent > limit:
                break
            result.add(test)
        return result

    def beside(self, tests: Collection[str]) -> set[str]:
        """All in the files of some: they may share what one of them made."""
        files = set(map(record.file_of, tests))
        return {test for test in self.seconds if record.file_of(test) in files}


class Bench:
    """A copy of the checkout.

    Attributes:
        work: folder of all copies, records and results.
        limit: [s] of tests at each attempt.
    """

    def __init__(self, work: Path, limit: float, number: int) -> None:
        self.work = work
        self._limit = limit
        self._folder = work / f"copy_{number}"
        self._log = work / f"log_{number}"
        ignored = shutil.ignore_patterns(*LEFT_OUT)
        shutil.copytree(ROOT, self._folder, ignore=ignored, dirs_exist_ok=True)

    def record(self, place: str) -> None:
        """Record which test of a place runs which line.

        Raises:
            RuntimeError: no test ran.
        """
        data = self.work / "data" / place.replace("/", "_")
        target = record_of(self.work, place)
        plugin = functools.partial(record.Recorder, self._folder, data, target)
        environment = self._environment([place])
        if not place.startswith(WAITING):
            environment["HYBRID_DYNAMICS_CACHE"] = "off"  # what is kept runs no line
        arguments = ["--timeout=900", place]
        code = process.run(self._folder, arguments, plugin, environment, RECORDING, self._log)
        if not target.exists():
            raise RuntimeError(f"no record of {place}, exit code {code}: see {self._log}")

    def outcome(self, site: Site) -> dict[str, Any]:
        """What was changed, whether the mutant is killed, and by what."""
        start = time.monotonic()
        change = changed(site, ROOT)
        path = self._folder / site.module
        path.write_text(change.source, encoding="utf-8")
        try:
            state, killer = self._tried(site, change)
        finally:
            shutil.copy2(ROOT / site.module, path)  # with its time: what was compiled stays valid
        seconds = round(time.monotonic() - start, 1)
        result = {"state": state, "seconds": seconds, "change": change.text, "killer": killer}
        return {**site._asdict(), **result}

    def _tried(self, site: Site, change: Change) -> tuple[str, str]:
        places = places_of(site.module)
        records = [record.read(record_of(self.work, place)) for place in places]
        seconds = {test: time for one in records for test, time in one.seconds.items()}
        tests = Tests(records, seconds)
        running = tests.running(site.module, change.lines)
        if change.lines and not running:
            return "not run", ""
        others = tests.beside(running) or set(seconds)
        for candidates, limit in ((running, QUICK), (running, self._limit), (others, self._limit)):
            chosen = tests.quickest(candidates, limit)
            code = self._run(chosen, seconds, self._environment(places))
            if code not in (PASSED, NOTHING_RAN):
                return "killed", self._killer(code)
        return "alive", ""

    def _run(
        self, tests: set[str], seconds: dict[str, float], environment: dict[str, str]
    ) -> int | None:
        if not tests:
            return NOTHING_RAN
        arguments = ["-x", *sorted(set(map(record.file_of, tests)))]
        plugin = functools.partial(process.Chosen, tests, seconds)
        patience = PATIENCE + SLOWNESS * sum(seconds[test] for test in tests)
        return process.run(self._folder, arguments, plugin, environment, patience, self._log)

    def _killer(self, code: int | None) -> str:
        if code is None:
            return "too slow"
        text = self._log.read_text(encoding="utf-8", errors="replace")
        for line in text.splitlines():
            if line.startswith(("FAILED", "ERROR")):
                return line[:200]
        return f"exit code {code}"

    def _environment(self, places: Collection[str]) -> dict[str, str]:
        return {
            **kernels_of(places),
            "HYBRID_DYNAMICS_CACHE": str(self.work / "kernels"),
            "PYTHONDONTWRITEBYTECODE": "1",  # of a mutant
        }


def record_of(work: Path, place: str) -> Path:
    """The file of the record of a place of tests."""
    return work / f"record_{place.replace('/', '_')}.json"
