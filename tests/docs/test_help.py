"""The examples that `--help` shows do what they say, as far as they use shipped robots alone."""

import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import pytest

click = pytest.importorskip("click")
pytest.importorskip("matplotlib")

from click.testing import CliRunner  # noqa: E402  an extra

from hybrid_dynamics_cli.app import app  # noqa: E402

from .blocks import PROGRAM  # noqa: E402

LINE = re.compile(rf"^\s*(?:Examples?: )?{PROGRAM} (.+)$", re.MULTILINE)
OTHERS = re.compile(r"my_robot|^bag |^benchmark|\|")  # files of the reader, and what takes long: tested elsewhere


def examples() -> Iterator[str]:
    context = click.Context(app)
    for verb in app.list_commands(context):
        yield from LINE.findall(app.get_command(context, verb).epilog or "")


@pytest.mark.parametrize("line", [line for line in examples() if not OTHERS.search(line)])
def test_an_example_of_help_works(line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, shlex.split(line))
    assert done.exit_code == 0, done.output
