"""Install with uv, which takes a third of the time that pip takes; with pip where uv fails.

python tools/installer.py DISTRIBUTION...

The command installs into the environment of its Python. Other tools take what it is made of.

uv is itself installed by pip. It reads no settings of pip, so those that say where packages come
from are handed to it. With any other setting of pip, pip installs.
"""

import ast
import os
import subprocess
import sys
from collections.abc import Sequence
from functools import cache
from pathlib import Path

from watched_process import Process

PIP = [sys.executable, "-m", "pip"]
# pip would take up to a minute to remove what it built with, in silence.
OPTIONS = ["--no-clean", "--no-input", "--disable-pip-version-check", "--progress-bar=off"]
SECTIONS = ("global", "install", "wheel", ":env:")  # of pip's settings: later ones count
# pip's settings as environment variables of uv, and what separates several values there
AS_UV_HAS_IT = {
    "cert": ("SSL_CERT_FILE", " "),
    "constraint": ("UV_CONSTRAINT", " "),
    "default-timeout": ("UV_HTTP_TIMEOUT", " "),
    "extra-index-url": ("UV_INDEX", " "),
    "find-links": ("UV_FIND_LINKS", ","),
    "index-url": ("UV_DEFAULT_INDEX", " "),
    "timeout": ("UV_HTTP_TIMEOUT", " "),
    "trusted-host": ("UV_INSECURE_HOST", " "),
}
OF_NO_MATTER = {
    "cache-dir",
    "compile",
    "disable-pip-version-check",
    "no-cache-dir",
    "no-color",
    "no-compile",
    "no-input",
    "no-python-version-warning",
    "progress-bar",
    "quiet",
    "require-virtualenv",
    "retries",
    "root-user-action",
    "verbose",
}


def install_commands(arguments: Sequence[str]) -> list[list[str]]:
    """Commands that install into this environment: each is for the failure of the one before.

    Args:
        arguments: of `pip install`, as uv has them too.
    """
    pip = [*PIP, "install", *OPTIONS, *arguments]
    uv = uv_program()
    if uv is None:
        return [pip]
    return [[uv, "pip", "install", "--python", sys.executable, *arguments], pip]


def wheel_commands(source: Path, folder: str) -> list[list[str]]:
    """Commands that build the wheel of a source tree into a folder, likewise."""
    pip = [*PIP, "wheel", *OPTIONS, "--verbose", "--no-deps", "--wheel-dir", folder, str(source)]
    uv = uv_program()
    if uv is None:
        return [pip]
    build = [uv, "build", "--wheel", "--python", sys.executable, "--out-dir", folder, str(source)]
    return [build, pip]


def uv_program() -> str | None:
    """The program uv of this environment, installed if need be; None where pip has to do."""
    if uv_settings() is None:
        return None
    program = Path(sys.prefix, "bin", "uv")
    if not program.exists():
        command = [*PIP, "install", *OPTIONS, "--quiet", "uv"]
        subprocess.run(command, check=False, capture_output=True)
    return str(program) if program.exists() else None


@cache
def uv_settings() -> dict[str, str] | None:
    """pip's settings as environment variables of uv; None where uv has no word for one."""
    listed = subprocess.run([*PIP, "config", "list"], check=False, capture_output=True, text=True)
    return as_uv_has_them(listed.stdout) if listed.returncode == 0 else None


def as_uv_has_them(listed: str) -> dict[str, str] | None:
    """What `pip config list` prints as environment variables of uv, likewise."""
    settings = {"UV_INDEX_STRATEGY": "unsafe-best-match"}  # the newest of all indices, as pip
    for section in SECTIONS:
        for line in listed.splitlines():
            key, _, value = line.partition("=")
            place, _, name = key.partition(".")
            if place != section or name in OF_NO_MATTER:
                continue
            if name not in AS_UV_HAS_IT:
                return None
            variable, separator = AS_UV_HAS_IT[name]
            settings[variable] = separator.join(str(ast.literal_eval(value)).split())
    return settings


def environment() -> dict[str, str]:
    """Environment variables for these commands."""
    # Modules are compiled when they are first imported, which most never are. This counts for the
    # environments that pip makes to build in, too.
    return {**(uv_settings() or {}), **os.environ, "PIP_COMPILE": "0"}


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    log = Path(sys.prefix, "hybrid_dynamics_setup.log")
    installing = Process(install_commands(sys.argv[1:]), log, environment())
    installing.finish(f"Installing {', '.join(sys.argv[1:])}")
