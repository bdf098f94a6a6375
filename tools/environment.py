"""Install into a virtual environment what a make target needs, and nothing twice.

python tools/environment.py VENV {run,test,docs,colcon}

VENV is made where it does not exist. `run` brings ROS 2 from PyPI, the interfaces and this package,
editable; `test` brings the tools of tests and lint as well, and a headless browser where npm is
there; `docs` those that build the pages; `colcon` brings colcon and the interfaces' build tools. A
stamp in VENV remembers what each step was given: a step with unchanged inputs is skipped.
"""

import platform
import shutil
import sys

if sys.version_info < (3, 11):  # noqa: UP036  (for those who have an older one)
    newer = [name for name in ("python3.13", "python3.12", "python3.11") if shutil.which(name)]
    example = newer[0] if newer else "/path/to/python3.11"
    sys.exit(
        f"Python {platform.python_version()} is too old: 3.11 or newer is needed. Try"
        f" PYTHON={example}"
    )

import hashlib
import json
import os
import subprocess
import sysconfig
import tempfile
import time
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import metadata, util
from pathlib import Path
from textwrap import fill, shorten

ROOT = Path(__file__).resolve().parent.parent
RUN_EXTRAS = "fast,cli,plot,bag,view,ros"
PURPOSES = ("run", "test", "docs", "colcon")
NAME = "hybrid-dynamics-ros"
PACKAGE_INPUTS = (
    "setup.*",
    "pyproject.toml",
    "package.xml",
    "*/__init__.py",
    "launch/*.py",
    "config/*.yaml",
    "rviz/*",
    "security/*",
)
INTERFACE_INPUTS = (
    "setup.py",
    "pyproject.toml",
    "package.xml",
    "*.txt",
    "cmake/*",
    "msg/*",
    "srv/*",
)
# pip would take up to a minute to remove what it built with, in silence: `discard` does that beside
# what follows.
PIP = [
    sys.executable,
    "-m",
    "pip",
    "install",
    "--no-clean",
    "--no-input",
    "--disable-pip-version-check",
]
PIP += ["--progress-bar=off"]
WIDTH = 80  # letters of a terminal
HEARTBEAT = 15.0  # [s] between signs of life of a long step


@dataclass(frozen=True)
class Step:
    """One call of pip: what it depends on, a distribution that it brings, how long it takes."""

    title: str
    arguments: list[str]
    inputs: list[Path]
    provides: str
    expected: str

    def digest(self) -> str:
        """Hash of all that the outcome depends on."""
        total = hashlib.sha256(json.dumps([sys.version, str(ROOT), self.arguments]).encode())
        for path in self.inputs:
            total.update(f"{path.relative_to(ROOT)}\n".encode() + path.read_bytes())
        return total.hexdigest()

    def is_done(self, stamp: dict[str, str]) -> bool:
        """Whether the environment has the outcome already."""
        return is_installed(self.provides) and stamp.get(self.title) == self.digest()


def main(venv: Path, purpose: str) -> None:
    """Bring the environment at ``venv`` up to date for ``purpose``, one of PURPOSES."""
    if Path(sys.prefix).resolve() != venv.resolve():
        make_venv(venv)
        python = str(venv / "bin" / "python")
        os.execv(python, [python, __file__, str(venv), purpose])  # noqa: S606
    stamp_file = venv / "hybrid_dynamics_setup.json"
    stamp = json.loads(stamp_file.read_text(encoding="utf-8")) if stamp_file.exists() else {}
    if stamp.setdefault("home", str(venv)) != str(venv):  # its scripts name the old path
        sys.exit(f"{venv} was made as {stamp['home']} and moved since: remove it, then try again")
    for step in steps(purpose):
        if not step.is_done(stamp):
            require_build_tools()
            run(
                f"{step.title}, {step.expected}",
                [*PIP, *step.arguments],
                venv / "hybrid_dynamics_setup.log",
            )
            stamp[step.title] = step.digest()
            stamp_file.write_text(json.dumps(stamp, indent=2), encoding="utf-8")
    if purpose == "test":
        bring_browser()


def bring_browser() -> None:
    """A headless browser for the 3D view, once.

    Its tests are skipped, with the reason, where it cannot be had.
    """
    done = subprocess.run([sys.executable, str(ROOT / "tools" / "browser.py")], check=False)
    if done.returncode:
        print(
            "  The 3D view is tested in an installed Chromium, or not in a browser at all",
            flush=True,
        )


def steps(purpose: str) -> Iterator[Step]:
    """What there is to do, in order. Each step may rely on those before it."""
    interfaces = ROOT / "msg_defs"
    yield Step(
        f"Installing ROS 2 Jazzy and libraries from PyPI ({RUN_EXTRAS})",
        ["--editable", f"{ROOT}[{RUN_EXTRAS}]"],
        files(ROOT, PACKAGE_INPUTS),
        NAME,
        "1 to 3 minutes",
    )
    yield Step(
        "Building and installing the interfaces of msg_defs/",
        [
            "--verbose",
            "--no-deps",
            "--force-reinstall",
            str(interfaces),
        ],  # the signs of life name what is built
        files(interfaces, INTERFACE_INPUTS),
        "hybrid-dynamics-msgs",
        "2 to 5 minutes: the compiler is busy",
    )
    if purpose == "test":
        yield Step(
            "Installing the tools of tests and lint",
            requirements("test", "dev"),
            [],
            "pytest",
            "a minute",
        )
    if purpose == "docs":
        yield Step(
            "Installing what builds the pages", requirements("docs"), [], "sphinx", "half a minute"
        )
    if purpose == "colcon":
        project = tomllib.loads((interfaces / "pyproject.toml").read_text(encoding="utf-8"))
        tools = requirements("colcon") + project["build-system"]["requires"]
        yield Step(
            "Installing colcon and the build tools of ROS 2 Jazzy",
            tools,
            [],
            "colcon-core",
            "a minute",
        )


def requirements(*extras: str) -> list[str]:
    """What the extras of the installed package ask for."""
    lines = [line.partition(";") for line in metadata.requires(NAME) or ()]
    return [
        name.strip() for name, _, marker in lines if any(f'"{extra}"' in marker for extra in extras)
    ]


def files(folder: Path, patterns: tuple[str, ...]) -> list[Path]:
    """The files of ``folder`` that match, in a fixed order."""
    return sorted(path for pattern in patterns for path in folder.glob(pattern) if path.is_file())


def is_installed(distribution: str) -> bool:
    """Whether this environment has the distribution, in any version."""
    try:
        metadata.version(distribution)
    except metadata.PackageNotFoundError:
        return False
    return True


def make_venv(venv: Path) -> None:
    """Make the environment with this Python, unless there is one of the same version."""
    version = f"{sys.version_info.major}.{sys.version_info.minor}"
    if (venv / "bin" / "python").exists() and (venv / "lib" / f"python{version}").is_dir():
        return
    if os.environ.get("VIRTUAL_ENV"):
        sys.exit(
            f"The active environment {venv} is not one of Python {version}: deactivate it, or omit"
            " PYTHON="
        )
    if not util.find_spec("ensurepip") or not util.find_spec("venv"):
        sys.exit(
            f"Python {version} cannot make virtual environments here. Mend it: {apt(['venv'])}"
        )
    print(f"Making {venv} with Python {platform.python_version()}", flush=True)
    subprocess.run([sys.executable, "-m", "venv", "--clear", str(venv)], check=True)


def require_build_tools() -> None:
    """Stop with what to do where this machine cannot build the interfaces.

    Add pip where it is missing.
    """
    if sys.platform != "linux" or platform.machine() != "x86_64":
        sys.exit(
            "ROS 2 is on PyPI for Linux on x86_64 only. Elsewhere, install ROS 2 Jazzy and use"
            " colcon."
        )
    missing = []
    if not Path(sysconfig.get_path("include"), "Python.h").exists():
        missing.append("dev")
    if not shutil.which(os.environ.get("CC", "cc")) or not shutil.which(
        os.environ.get("CXX", "c++")
    ):
        missing.append("g++")
    if missing:
        sys.exit(f"Python.h or a C++ compiler is missing. Mend it: {apt(missing)}")
    if not util.find_spec("pip"):
        subprocess.run([sys.executable, "-m", "ensurepip"], check=True)


def apt(missing: list[str]) -> str:
    """The line that brings g++ or the parts dev and venv of this Python on Debian and Ubuntu."""
    python = f"python{sys.version_info.major}.{sys.version_info.minor}"
    return "sudo apt install " + " ".join(
        part if part == "g++" else f"{python}-{part}" for part in missing
    )


def run(title: str, command: list[str], log: Path) -> None:
    """Run a step with its output in ``log``.

    Say how long it takes, that it lives, or how it failed.
    """
    print(fill(f"{title} ...", WIDTH, subsequent_indent="  "), flush=True)
    start, scratch = time.monotonic(), tempfile.mkdtemp(prefix="hybrid_dynamics_setup-")
    try:
        code = watched(command, log, scratch, start)
    finally:
        discard(scratch)
    if code != 0:
        sys.exit(
            f"{last_lines(log, 30)}\nThis failed: {' '.join(command)}\nAll it said is in {log}"
        )
    print(f"  {time.monotonic() - start:4.0f} s  done", flush=True)


def watched(command: list[str], log: Path, scratch: str, start: float) -> int:
    """Run a command with its temporary files in ``scratch`` and report progress; its exit code."""
    with log.open("w", encoding="utf-8") as output:
        process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=subprocess.STDOUT,
            env={**os.environ, "TMPDIR": scratch},
        )
        told = ""
        while True:
            try:
                return process.wait(HEARTBEAT)
            except subprocess.TimeoutExpired:
                last = last_lines(log, 1)
                said = (
                    shorten(last, WIDTH - 10)
                    if last != told
                    else "at work, and has said nothing new"
                )
                print(f"  {time.monotonic() - start:4.0f} s  {said}", flush=True)
                told = last


def discard(scratch: str) -> None:
    """Remove a folder with many files, beside what follows."""
    remove = "import shutil, sys; shutil.rmtree(sys.argv[1], ignore_errors=True)"
    subprocess.Popen(
        [sys.executable, "-c", remove, scratch], stdin=subprocess.DEVNULL, start_new_session=True
    )


def last_lines(log: Path, count: int) -> str:
    """The last lines of a log that say something."""
    lines = [
        line.strip() for line in log.read_text(encoding="utf-8", errors="replace").splitlines()
    ]
    return "\n".join([line for line in lines if line and not line.startswith("WARNING")][-count:])


if __name__ == "__main__":
    if len(sys.argv) != 3 or sys.argv[2] not in PURPOSES:
        sys.exit(__doc__)
    try:
        main(Path(sys.argv[1]).absolute(), sys.argv[2])
    except KeyboardInterrupt:
        sys.exit("interrupted: what was done so far stays, the rest is done next time")
