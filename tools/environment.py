"""Install into a virtual environment what a make target needs, and nothing twice.

python tools/environment.py VENV {run,test,docs,colcon,venv,tools,interfaces}

VENV is made where it does not exist. Libraries come from PyPI, ROS 2 among them, and this package
is installed editable. Meanwhile the compiler builds the interfaces of msg_defs/.

* `run`: libraries and interfaces.
* `test`: these, and the tools of tests and lint, with a headless browser where npm is there.
* `docs`: these, and what builds the pages.
* `colcon`: these, colcon, and the build tools of the interfaces.
* `venv`, `tools`, `interfaces`: parts for tools/checks.py. They are an empty environment, all that
  needs no compiler, and the interfaces alone.

A stamp in VENV remembers what each step was given: a step with unchanged inputs is skipped. Several
processes may work on one environment: they install one after the other.
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

import fcntl
import hashlib
import json
import os
import subprocess
import sysconfig
import tempfile
import time
import tomllib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import metadata, util
from pathlib import Path

import installer
from watched_process import Process, discard

ROOT = Path(__file__).resolve().parent.parent
INTERFACES = ROOT / "msg_defs"
RUN_EXTRAS = "fast,cli,plot,bag,view,meshes,xacro,mjcf,drives,ros"
# The interfaces come last: they are built while the others are installed.
PURPOSES = {
    "run": ("libraries", "interfaces"),
    "test": ("libraries", "test tools", "interfaces"),
    "docs": ("libraries", "page tools", "interfaces"),
    "colcon": ("libraries", "colcon", "interfaces"),
    "venv": (),
    "tools": ("libraries", "test tools", "page tools"),
    "interfaces": ("interfaces",),
}
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
    "action/*",
    "msg/*",
    "srv/*",
)


@dataclass(frozen=True)
class Step:
    """One thing to install.

    Attributes:
        title: what is done, for people.
        arguments: of pip.
        inputs: files that the outcome depends on.
        provides: a distribution that it brings.
        expected: how long it takes, for people.
    """

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

    def is_done(self, venv: Path) -> bool:
        """Whether the environment has the outcome already."""
        stamp = read_stamp(venv)
        return is_installed(self.provides) and stamp.get(self.title) == self.digest()


def main(venv: Path, purpose: str) -> None:
    """Bring the environment at ``venv`` up to date for ``purpose``, one of PURPOSES."""
    if Path(sys.prefix).resolve() != venv.resolve():
        make_venv(venv)
        python = str(venv / "bin" / "python")
        os.execv(python, [python, __file__, str(venv), purpose])  # noqa: S606
    home = read_stamp(venv).get("home", str(venv))
    if home != str(venv):  # its scripts name the old path
        sys.exit(f"{venv} was made as {home} and moved since: remove it, then try again")
    names = PURPOSES[purpose]
    build = None
    if "interfaces" in names and not interfaces().is_done(venv):
        require_build_tools()
        build = Build(venv)
    try:
        for name in names:
            bring(STEPS[name](), build, venv)
    finally:
        if build is not None:
            build.process.stop()
    if "test tools" in names:
        bring_browser()


def bring(step: Step, build: "Build | None", venv: Path) -> None:
    """Do a step, unless it is done; the interfaces are what ``build`` makes."""
    if step.is_done(venv):
        return
    require_build_tools()
    if build is not None and step == interfaces():
        build.install(step)
    else:
        install(step, step.arguments, venv)


class Build:
    """The interfaces, built into a wheel in the background."""

    def __init__(self, venv: Path) -> None:
        self.venv = venv
        self.folder = tempfile.mkdtemp(prefix="hybrid_dynamics_wheel-")
        with exclusive(venv):  # uv may have to be installed
            commands = installer.wheel_commands(INTERFACES, self.folder)
        self.process = Process(
            commands, venv / "hybrid_dynamics_build.log", installer.environment()
        )

    def install(self, step: Step) -> None:
        """Wait for the wheel, then install it."""
        self.process.finish(f"{step.title}, {step.expected}")
        wheels = [str(path) for path in Path(self.folder).glob("*.whl")]
        arguments = ["--no-deps", "--force-reinstall", *wheels]
        install(step, arguments, self.venv, "They are built; installing them")
        discard(self.folder)


def install(step: Step, arguments: list[str], venv: Path, headline: str = "") -> None:
    """Install, and note in the stamp that it is done.

    Args:
        step: what is installed.
        arguments: of pip and uv.
        venv: the environment.
        headline: what is printed first; by default the title of the step.
    """
    with exclusive(venv):
        if "--force-reinstall" in arguments or not step.is_done(venv):
            commands = installer.install_commands(arguments)
            process = Process(commands, venv / "hybrid_dynamics_setup.log", installer.environment())
            process.finish(headline or f"{step.title}, {step.expected}")
            stamp = {"home": str(venv), **read_stamp(venv), step.title: step.digest()}
            text = json.dumps(stamp, indent=2)
            stamp_file(venv).write_text(text, encoding="utf-8")
            print(f"  {time.monotonic() - process.start:4.0f} s  done", flush=True)


@contextmanager
def exclusive(venv: Path) -> Iterator[None]:
    """While no other process installs into the environment."""
    with (venv / "hybrid_dynamics_setup.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def stamp_file(venv: Path) -> Path:
    """Where the stamp is."""
    return venv / "hybrid_dynamics_setup.json"


def read_stamp(venv: Path) -> dict[str, str]:
    """Digests of the steps that are done, by title, and the path at which VENV was made."""
    file = stamp_file(venv)
    if not file.exists():
        return {}
    stamp: dict[str, str] = json.loads(file.read_text(encoding="utf-8"))
    return stamp


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


def libraries() -> Step:
    """The libraries from PyPI, and this package."""
    return Step(
        f"Installing ROS 2 Jazzy and libraries from PyPI ({RUN_EXTRAS})",
        ["--editable", f"{ROOT}[{RUN_EXTRAS}]"],
        files(ROOT, PACKAGE_INPUTS),
        NAME,
        "1 to 3 minutes",
    )


def interfaces() -> Step:
    """The messages and services of this package."""
    return Step(
        "Building and installing the interfaces of msg_defs/",
        ["--verbose", "--no-deps", "--force-reinstall", str(INTERFACES)],
        files(INTERFACES, INTERFACE_INPUTS),
        "hybrid-dynamics-msgs",
        "2 to 5 minutes: the compiler is busy",
    )


def test_tools() -> Step:
    """What tests and lint need."""
    return Step(
        "Installing the tools of tests and lint",
        requirements("test", "dev"),
        [],
        "pytest",
        "a minute",
    )


def page_tools() -> Step:
    """What builds the pages."""
    return Step(
        "Installing what builds the pages", requirements("docs"), [], "sphinx", "half a minute"
    )


def colcon() -> Step:
    """Colcon, and what it builds the interfaces with."""
    project = tomllib.loads((INTERFACES / "pyproject.toml").read_text(encoding="utf-8"))
    return Step(
        "Installing colcon and the build tools of ROS 2 Jazzy",
        requirements("colcon") + project["build-system"]["requires"],
        [],
        "colcon-core",
        "a minute",
    )


STEPS: dict[str, Callable[[], Step]] = {
    "libraries": libraries,
    "interfaces": interfaces,
    "test tools": test_tools,
    "page tools": page_tools,
    "colcon": colcon,
}


def requirements(*extras: str) -> list[str]:
    """What the extras of the installed package ask for."""
    names = []
    for line in metadata.requires(NAME) or ():
        name, _, marker = line.partition(";")
        if any(f'"{extra}"' in marker for extra in extras):
            names.append(name.strip())
    return names


def files(folder: Path, patterns: tuple[str, ...]) -> list[Path]:
    """The files of ``folder`` that match, in a fixed order."""
    matches: list[Path] = []
    for pattern in patterns:
        matches += filter(Path.is_file, folder.glob(pattern))
    return sorted(matches)


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
    compilers = [os.environ.get("CC", "cc"), os.environ.get("CXX", "c++")]
    if not all(map(shutil.which, compilers)):
        missing.append("g++")
    if missing:
        sys.exit(f"Python.h or a C++ compiler is missing. Mend it: {apt(missing)}")
    if not util.find_spec("pip"):
        subprocess.run([sys.executable, "-m", "ensurepip"], check=True)


def apt(missing: list[str]) -> str:
    """The line that brings g++ or the parts dev and venv of this Python on Debian and Ubuntu."""
    python = f"python{sys.version_info.major}.{sys.version_info.minor}"
    packages = {"g++": "g++", "dev": f"{python}-dev", "venv": f"{python}-venv"}
    return "sudo apt install " + " ".join(packages[part] for part in missing)


if __name__ == "__main__":
    if len(sys.argv) != 3 or sys.argv[2] not in PURPOSES:
        sys.exit(__doc__)
    try:
        main(Path(sys.argv[1]).absolute(), sys.argv[2])
    except KeyboardInterrupt:
        sys.exit("interrupted: what was done so far stays, the rest is done next time")
