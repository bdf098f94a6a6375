"""The code blocks of a page, run in order as a reader would.

They run in one folder, with one Python session and bash. `python examples/SCRIPT` is that of this
tree.

* ```python: run; where lines begin with >>> the answers must be those that the page shows (...
  stands for anything).
* ```bash: run line by line with `hybrid-dynamics` of this tree; every line must succeed.
* ```console: lines after `$ ` are run; what the page shows must be what they print, in the same
  order.
* ```yaml: a robot is written to a file and loaded.
* ```yaml, ```xml, ```c and ```cpp after a comment `<!-- file: NAME -->`: written to that file.

A comment before a block says what else: `<!-- not run: REASON -->`; `<!-- needs LIBRARY -->`, run
where there is that library; `<!-- beside the node -->`, which tests/ros/test_page_blocks.py runs
beside the node that the page starts.
"""

from __future__ import annotations

import contextlib
import doctest
import io
import os
import re
import runpy
import shlex
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from hybrid_dynamics_core import load

ROOT = Path(__file__).parents[2]
FENCE = re.compile(
    r"^(?:<!-- (?P<mark>[^\n]*?) -->\n+)?```(?P<language>\w+)\n(?P<text>.*?)^```$",
    re.DOTALL | re.MULTILINE,
)
RUN = {"python", "bash", "c", "cpp", "console", "yaml", "xml"}
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
PROGRAM = "hybrid-dynamics"
COMMAND_LINES = re.compile(rf"({PROGRAM} [^\n|<>&;$`\\]*\n?)+")
SCRIPT_LINE = re.compile(r"python (examples/[\w/]+\.py)([ \w]*)")
PROGRAMS = {PROGRAM: "-m hybrid_dynamics_cli", "python": ""}


@dataclass(frozen=True)
class Block:
    """A block with the line on which it begins and the comment before it."""

    page: str
    line: int
    language: str
    text: str
    mark: str

    @property
    def where(self) -> str:
        return f"{self.page}:{self.line}"

    @property
    def is_not_run(self) -> bool:
        return self.mark.startswith("not run: ") and len(self.mark) > len("not run: ")

    @property
    def lacks_a_library(self) -> bool:
        library = self.mark.removeprefix("needs ")
        return library != self.mark and find_spec(library) is None

    @property
    def starts_nodes(self) -> bool:
        """Whether it is lines that each start a node, which runs until it is ended."""
        return self.language == "bash" and self.text.startswith("hybrid_dynamics_node ")

    @property
    def beside_the_node(self) -> bool:
        return self.mark == "beside the node"


def commands(text: str) -> list[str]:
    """The commands of a bash block, continued lines joined."""
    return text.replace("\\\n", " ").strip().splitlines()


def blocks_of(page: str) -> Iterator[Block]:
    """Every block of a page."""
    text = (ROOT / page).read_text(encoding="utf-8")
    for match in FENCE.finditer(text):
        line = text.count("\n", 0, match.start("language")) + 1
        yield Block(page, line, match["language"], match["text"], match["mark"] or "")


@dataclass
class Session:
    """A reader in a folder."""

    folder: Path
    names: dict[str, Any] = field(default_factory=dict)
    ran: list[Block] = field(default_factory=list)

    def __post_init__(self) -> None:
        bin_folder = self.folder / ".bin"
        bin_folder.mkdir()
        for program, module in PROGRAMS.items():
            (bin_folder / program).write_text(
                f'#!/bin/sh\nexec "{sys.executable}" {module} "$@"\n', encoding="utf-8"
            )
            (bin_folder / program).chmod(0o755)
        paths = {
            "PATH": f"{bin_folder}:{os.environ['PATH']}",
            "PYTHONPATH": str(ROOT),
            "COLUMNS": "120",
        }
        self.environment = {**os.environ, **paths}

    def run(self, block: Block) -> None:
        """Run one block; those of other languages, or with a reason not to, are passed over."""
        if block.language not in RUN:
            return
        if block.is_not_run or block.starts_nodes or block.lacks_a_library:
            return
        getattr(self, f"_{block.language}")(block)
        self.ran.append(block)

    def _python(self, block: Block) -> None:
        if block.text.lstrip().startswith(">>>"):
            example = doctest.DocTestParser().get_doctest(
                block.text, self.names, block.where, block.page, block.line
            )
            said: list[str] = []
            runner = doctest.DocTestRunner(optionflags=FLAGS, verbose=False)
            runner.run(example, out=said.append, clear_globs=False)
            self.names.update(example.globs)
            assert not said, "".join(said)
        else:
            lines = "\n" * block.line + block.text  # so that a traceback names the line of the page
            code = compile(lines, str(ROOT / block.page), "exec")
            exec(code, self.names)  # noqa: S102  our text

    def _bash(self, block: Block) -> None:
        self._shell(block, block.text)

    def _console(self, block: Block) -> None:
        assert block.text.startswith("$ "), f"{block.where}: commands of a console begin with $"
        for step in re.split(r"^\$ ", block.text, flags=re.MULTILINE)[1:]:
            command, _, wanted = step.partition("\n")
            got = self._shell(block, command, fails="Error:" in wanted)
            if not wanted.strip():
                continue
            same = doctest.OutputChecker().check_output(wanted, got, FLAGS)
            problem = f"The page shows:\n{wanted}\nIt prints:\n{got}"
            assert same, f"{block.where}: {command}\n{problem}"

    def _shell(self, block: Block, script: str, *, fails: bool = False) -> str:
        ours = SCRIPT_LINE.fullmatch(script.strip())
        if ours:
            code, said = 0, self._example(ours[1], ours[2].split())
        elif COMMAND_LINES.fullmatch(script.strip()):
            code, said = self._command(script)
        else:
            code, said = self._bash_process(script)
        assert (code != 0) == fails, f"{block.where}: ended with {code}:\n{script}\n{said}"
        return said

    def _example(self, script: str, words: list[str]) -> str:
        """Run a script of `examples` in this process."""
        place = ROOT / script
        said = io.StringIO()
        with pytest.MonkeyPatch.context() as patch, contextlib.redirect_stdout(said):
            patch.setattr(sys, "argv", [script, *words])
            patch.syspath_prepend(str(place.parent))
            runpy.run_path(str(place), run_name="__main__")
        return said.getvalue()

    def _command(self, script: str) -> tuple[int, str]:
        """Run lines of nothing but our command in this process, which has imported everything."""
        from click.testing import CliRunner

        from hybrid_dynamics_cli.app import app

        said = ""
        for line in script.strip().splitlines():
            words = shlex.split(line, comments=True)[1:]
            done = CliRunner(env={"COLUMNS": "120"}).invoke(app, words, prog_name=PROGRAM)
            said += done.output
            if done.exception and not isinstance(done.exception, SystemExit):
                raise done.exception
            if done.exit_code:
                return done.exit_code, said
        return 0, said

    def _bash_process(self, script: str) -> tuple[int, str]:
        done = subprocess.run(
            ["/bin/bash", "-euo", "pipefail", "-c", script],
            cwd=self.folder,
            env=self.environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
        )
        return done.returncode, done.stdout

    def _yaml(self, block: Block) -> None:
        name = re.search(r"^name: (\w+)$", block.text, re.MULTILINE)
        if block.mark.startswith("file: "):
            self._write(block.mark.removeprefix("file: "), block.text)
        elif block.text.startswith("format:"):
            assert name is not None, f"{block.where}: a robot without a name"
            self._write(f"{name[1]}.yaml", block.text)
            assert load(self.folder / f"{name[1]}.yaml").name == name[1]
        else:
            raise AssertionError(f"{block.where}: neither a robot nor marked with what it is")

    def _xml(self, block: Block) -> None:
        assert block.mark.startswith("file: "), f"{block.where}: not marked with what it is"
        self._write(block.mark.removeprefix("file: "), block.text)

    _c = _cpp = _xml

    def _write(self, name: str, text: str) -> None:
        (self.folder / name).write_text(text, encoding="utf-8")
