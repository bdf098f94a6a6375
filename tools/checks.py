"""Lint, pages and tests, side by side, each as soon as it has what it needs.

python tools/checks.py VENV {test,all,remaining,lint,docs} [ARGUMENTS OF PYTEST]

* `test`: what each change must pass: lint, the pages, and all tests with a sample of whole sets.
* `all`: the same with whole sets.
* `remaining`: what `all` has beyond `test`, the build with colcon, and the core beside the
  libraries of Ubuntu 24.04.
* `lint`, `docs`: one of them.

VENV is made and filled where needed, meanwhile. With arguments there is one run of pytest, after
that. The output of a task follows when it ends. Every task is tried, whatever another one says.
"""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CORES = len(os.sched_getaffinity(0))
SLOWEST = 10  # tests that are named
HEARTBEAT = 30.0  # [s] between signs of life
POLL = 0.2  # [s]
NODE = ("tests/demo", "tests/ros")  # folders of tests that need the interfaces
# Tests of the node look at deadlines and mostly wait. They need the interfaces, which take longest.
# What is beside them gives way.
GIVES_WAY = 10

PURPOSES = ("test", "all", "remaining", "lint", "docs")
WHOLE = {"MORE_EXAMPLES": "1"}  # all random examples: see tests/sampling.py
UBUNTU = (  # libraries of Ubuntu 24.04, without a compiler and without ROS
    "numpy==1.26.4",
    "scipy==1.11.4",
    "PyYAML==6.0.1",
    "jsonschema==4.10.3",
    "pytest==7.4.4",
    "pytest-timeout==2.2.0",
    "pytest-xdist==3.4.0",
    "hypothesis==6.98.15",
)


@dataclass
class Task:
    """Commands one after the other.

    Attributes:
        name: for people.
        commands: programs with their arguments; the task ends with the first that fails.
        needs: names of tasks that must have passed before.
        settings: environment variables.
        gives_way: whether it runs at a lower priority.
    """

    name: str
    commands: Sequence[Sequence[str]]
    needs: tuple[str, ...] = ()
    settings: dict[str, str] = field(default_factory=dict)
    gives_way: bool = True


class Running:
    """A task at work; its output goes to a file."""

    def __init__(self, task: Task, folder: Path) -> None:
        self.task = task
        self.start = time.monotonic()
        self._log = folder / f"{task.name.replace(' ', '_')}.log"
        self._waiting = list(task.commands)
        self._process: subprocess.Popen[bytes] | None = None
        self._begin_next()

    def _begin_next(self) -> None:
        command = list(self._waiting.pop(0))
        if self.task.gives_way:
            command = ["nice", "-n", str(GIVES_WAY), *command]
        with self._log.open("ab") as output:
            self._process = subprocess.Popen(
                command,
                cwd=ROOT,
                env={**os.environ, **self.task.settings},
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )

    def code(self) -> int | None:
        """The exit code, or None while it works."""
        assert self._process is not None  # noqa: S101  one was begun
        code = self._process.poll()
        if code == 0 and self._waiting:
            self._begin_next()
            return None
        return code

    def output(self) -> str:
        """All that it wrote."""
        return self._log.read_text(encoding="utf-8", errors="replace")

    def seconds(self) -> float:
        """Since it began."""
        return time.monotonic() - self.start

    def stop(self) -> None:
        """End it and all that it started."""
        assert self._process is not None  # noqa: S101  one was begun
        if self._process.poll() is None:
            os.killpg(self._process.pid, 15)
            self._process.wait()


class Schedule:
    """Tasks, of which each begins when those that it needs have passed."""

    def __init__(self, tasks: Sequence[Task], folder: Path) -> None:
        self._folder = folder  # of their outputs
        self._waiting = list(tasks)
        self._running: list[Running] = []
        self._passed: dict[str, float] = {}  # seconds
        self._failed: dict[str, float] = {}
        self._start = self._last_word = time.monotonic()

    def run(self) -> bool:
        """Run all; whether all passed."""
        try:
            while self._waiting or self._running:
                self._begin()
                self._collect()
                self._say_alive()
                time.sleep(POLL)
        finally:
            for running in self._running:
                running.stop()
        self._report()
        return not self._failed

    def _begin(self) -> None:
        for task in list(self._waiting):
            if all(name in self._passed for name in task.needs):
                self._waiting.remove(task)
                self._running.append(Running(task, self._folder))
            elif any(name in self._failed for name in task.needs):
                self._waiting.remove(task)
                self._failed[task.name] = 0.0

    def _collect(self) -> None:
        for running in list(self._running):
            code = running.code()
            if code is not None:
                self._running.remove(running)
                results = self._failed if code else self._passed
                results[running.task.name] = running.seconds()
                verdict = f"FAILED with {code}" if code else "passed"
                say(f"\n===== {running.task.name}: {verdict}, {running.seconds():.0f} s")
                say(running.output().rstrip())
                self._last_word = time.monotonic()

    def _say_alive(self) -> None:
        now = time.monotonic()
        if now - self._last_word > HEARTBEAT and self._running:
            self._last_word = now
            words = [f"{running.task.name} {running.seconds():.0f} s" for running in self._running]
            say(f"{now - self._start:5.0f} s  at work: {', '.join(words)}")

    def _report(self) -> None:
        say("\n===== Seconds a task, side by side")
        for name, seconds in {**self._passed, **self._failed}.items():
            note = ""
            if name in self._failed:
                note = "  FAILED" if seconds else "  not begun: what it needs failed"
            say(f"{seconds:6.0f}  {name}{note}")
        say(f"{time.monotonic() - self._start:6.0f}  in all")


def say(text: str) -> None:
    """To people, at once."""
    print(text, flush=True)


class Commands:
    """The commands of an environment."""

    def __init__(self, venv: Path) -> None:
        self.venv = venv
        self.python = str(venv / "bin" / "python")

    def program(self, name: str, *arguments: str) -> list[str]:
        """A program of the environment."""
        return [str(self.venv / "bin" / name), *arguments]

    def environment(self, purpose: str) -> list[str]:
        """Install for a purpose."""
        python = self.python if Path(self.python).exists() else sys.executable
        return [python, "tools/environment.py", str(self.venv), purpose]

    def pytest(self, *arguments: str) -> list[str]:
        """Tests on all cores, in the order of tests/conftest.py: long files first."""
        options = ["--numprocesses", str(CORES), "--dist", "loadfile", "--no-loadscope-reorder"]
        options.append(f"--durations={SLOWEST}")
        return [self.python, "-m", "pytest", *options, *arguments]


def installing(run: Commands, *more: str) -> list[Task]:
    """The environment, in parts: the interfaces are built beside what needs no compiler."""
    purposes = ("tools", *more)
    return [
        Task("environment", [run.environment(p) for p in purposes], gives_way=False),
        Task("interfaces", [run.environment("interfaces")], gives_way=False),
    ]


def lint(run: Commands) -> Task:
    """Style, types and layers."""
    commands = [
        run.program("ruff", "check", "."),
        run.program("ruff", "format", "--check", "."),
        run.program("mypy"),
        run.program("lint-imports", "--no-logo"),
    ]
    return Task("lint", commands, ("environment",))


def pages(run: Commands) -> Task:
    """docs/ as HTML; every warning is an error."""
    options = ["--quiet", "--fail-on-warning", "--keep-going", "--nitpicky"]
    command = [run.python, "-m", "sphinx", *options, "docs", "build/docs"]
    return Task("pages", [command], ("environment", "interfaces"))


def tests(run: Commands, marks: str, settings: dict[str, str]) -> list[Task]:
    """All tests with these marks: those of the node apart, which need the interfaces."""
    others = [f"--ignore={folder}" for folder in NODE]
    node = run.pytest("-m", f"ros and ({marks})", *files_of_the_node())
    return [
        Task(
            "tests",
            [run.pytest("-m", f"not ros and ({marks})", *others)],
            ("environment",),
            settings,
        ),
        Task(
            "tests of the node",
            [node],
            ("environment", "interfaces"),
            settings,
            gives_way=False,
        ),
    ]


def files_of_the_node() -> list[str]:
    """The folders of tests of the node, and files elsewhere with tests that are marked `ros`."""
    files = []
    for path in sorted((ROOT / "tests").rglob("test_*.py")):
        name = str(path.relative_to(ROOT))
        if not name.startswith(NODE) and "pytest.mark.ros" in path.read_text(encoding="utf-8"):
            files.append(name)
    return [*NODE, *files]


def colcon(run: Commands) -> Task:
    """Both packages built with colcon, and tried."""
    return Task("colcon", [["tools/colcon.sh", str(run.venv)]], ("environment", "interfaces"))


def ubuntu(folder: Path) -> Task:
    """The core beside the libraries of Ubuntu 24.04, in an environment of its own."""
    python = str(folder / "ubuntu" / "bin" / "python")
    # one search of poses takes minutes without a compiler; it runs with one among the tests
    slow = (
        "tests/core/test_closed_form_ik.py::"
        "test_a_pose_that_the_platform_cannot_have_is_told[staicu2015]"
    )
    commands = [
        [sys.executable, "-m", "venv", str(folder / "ubuntu")],
        [python, "tools/installer.py", *UBUNTU],
        [python, "-m", "pytest", "-q", "tests/core", "tests/published", "--deselect", slow],
    ]
    return Task("the core with NumPy 1.26 and SciPy 1.11", commands)


def tasks_of(purpose: str, run: Commands, folder: Path) -> list[Task]:
    """The tasks of a purpose."""
    if purpose == "lint":
        return [*installing(run), lint(run)]
    if purpose == "docs":
        return [*installing(run), pages(run)]
    if purpose == "remaining":
        sweeps = tests(run, "sweep or examples", WHOLE)
        return [*installing(run, "colcon"), *sweeps, colcon(run), ubuntu(folder)]
    chosen = tests(run, "not sweep", {})
    if purpose == "all":
        chosen = tests(run, "sweep or not sweep", WHOLE)
    return [*installing(run), lint(run), pages(run), *chosen]


def main(venv: Path, purpose: str, arguments: Sequence[str]) -> bool:
    """Make the environment and do the tasks; whether all is well."""
    run = Commands(venv)
    subprocess.run(run.environment("venv"), cwd=ROOT, check=True)
    if arguments:
        for name in ("tools", "interfaces"):
            subprocess.run(run.environment(name), cwd=ROOT, check=True)
        return subprocess.run(run.pytest(*arguments), cwd=ROOT, check=False).returncode == 0
    with tempfile.TemporaryDirectory(prefix="hybrid_dynamics_checks-") as folder:
        return Schedule(tasks_of(purpose, run, Path(folder)), Path(folder)).run()


if __name__ == "__main__":
    if len(sys.argv) < 3 or sys.argv[2] not in PURPOSES:
        sys.exit(__doc__)
    try:
        is_good = main(Path(sys.argv[1]).absolute(), sys.argv[2], sys.argv[3:])
    except (KeyboardInterrupt, subprocess.CalledProcessError) as problem:
        sys.exit(f"stopped: {problem!r}")
    sys.exit(0 if is_good else 1)
