"""The Containerfile, as far as it can be tried without an engine and a registry."""

from __future__ import annotations

import json
import shlex
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def test_its_shell_reads_the_setup_files_of_ros(tmp_path: Path) -> None:
    """These look at variables that nobody sets (AMENT_TRACE_SETUP_FILES).

    `set -u` takes that for an error.
    """
    text = (ROOT / "Containerfile").read_text(encoding="utf-8")
    (line,) = [line for line in text.splitlines() if line.startswith("SHELL ")]
    shell = json.loads(line.removeprefix("SHELL "))
    setup = tmp_path / "setup.bash"
    script = 'if [ -n "$AMENT_TRACE_SETUP_FILES" ]; then echo traced; fi\n'
    setup.write_text(script, encoding="utf-8")
    command = [*shell, f"source {shlex.quote(str(setup))} && echo read"]
    done = subprocess.run(
        command, env={"PATH": "/usr/bin:/bin"}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout == "read\n"
