"""Help, completion and exit codes of every verb."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import click
import pytest
from click.shell_completion import ShellComplete

from hybrid_dynamics_cli.app import app
from hybrid_dynamics_cli.exit_codes import MEANINGS
from tests.cli.calling import call, shipped_text
from tests.sampling import swept

pytest.importorskip("rosbags")


def commands(group: click.Group = app, way: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """The words of every verb, those of `bag` too."""
    context = click.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        if isinstance(command, click.Group):
            yield from commands(command, (*way, name))
        else:
            yield (*way, name)


ALL = list(commands())


def command_of(words: tuple[str, ...]) -> click.Command:
    command: click.Command = app
    for word in words:
        assert isinstance(command, click.Group)
        member = command.get_command(click.Context(command), word)
        assert member is not None
        command = member
    return command


def options_of(words: tuple[str, ...]) -> set[str]:
    """The names of a verb's options and arguments."""
    names: set[str] = set()
    for param in command_of(words).params:
        names.update(param.opts)
    return names


def examples(words: tuple[str, ...]) -> list[str]:
    """The commands, as a shell reads them: what goes on below stands in one line."""
    epilog = re.sub(r" \\\n +", " ", command_of(words).epilog or "")
    lines = [line.strip() for line in epilog.splitlines()]
    return [line for line in lines if line.startswith("hybrid-dynamics")]


@pytest.mark.parametrize("words", ALL, ids="-".join)
def test_every_verb_has_help_with_examples_of_itself(words: tuple[str, ...]) -> None:
    page = call(*words, "--help")
    assert page.exit_code == 0
    assert len(examples(words)) >= 2
    for line in (command_of(words).epilog or "").replace("\b", "").splitlines():
        assert line in page.output  # as it was written, not wrapped
    for line in examples(words):
        assert shlex.split(line)[1 : len(words) + 1] == list(words)
    for param in command_of(words).params:
        if isinstance(param, click.Option) and words != SPARE:
            assert param.help


@pytest.mark.parametrize("words", [(), *ALL], ids="-".join)
def test_help_fits_a_terminal(words: tuple[str, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    page = call(*words, "--help").output
    assert page
    assert [line for line in page.splitlines() if len(line) > 80] == []


SPARE = ("export",)  # its output is for programs as it is


@pytest.mark.parametrize(
    "words", [words for words in ALL if words not in (SPARE, ("view",))], ids="-".join
)
def test_every_verb_has_a_form_for_programs(words: tuple[str, ...]) -> None:
    assert "--json" in options_of(words)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """What the examples name."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HYBRID_DYNAMICS_KERNELS", "python")
    (tmp_path / "my_robot.yaml").write_text(shipped_text("five_bar"), encoding="utf-8")
    (tmp_path / "dig.csv").touch()
    return tmp_path


LONG = ("bag", "benchmark", "calibrate", "estimate", "size", "view", "weigh")  # not run


def short_examples() -> Iterator[str]:
    """The examples that run to their end, one command each."""
    for words in ALL:
        if words[0] not in LONG:
            yield from (line for line in examples(words) if "|" not in line)


# pictures, searches for all modes, play of pins, and compilers
SLOW = re.compile(
    r" --(draw|plot)\b| workspace | bag report | design | --all\b|\.play=| --format fmu "
)
LINES = list(short_examples())


@pytest.mark.parametrize("line", swept(LINES, [line for line in LINES if not SLOW.search(line)]))
@pytest.mark.usefixtures("folder")
def test_the_examples_run(line: str) -> None:
    pytest.importorskip("matplotlib")
    words = shlex.split(line)[1:]
    if " workspace " in line:
        words += ["--samples", "500"]
    result = call(*words)
    assert result.exit_code == 0, result.output


@pytest.mark.parametrize("words", [words for words in ALL if words[0] in LONG], ids="-".join)
@pytest.mark.usefixtures("folder")
def test_the_examples_of_long_runs_are_understood(words: tuple[str, ...]) -> None:
    for line in examples(words):
        context = command_of(words).make_context(words[-1], shlex.split(line)[1 + len(words) :])
        assert context.params


def test_exit_codes_stand_under_help() -> None:
    page = " ".join(call("--help").output.split())
    for code, meaning in MEANINGS.items():
        assert f"{code} {' '.join(meaning.split())}" in page
    assert list(MEANINGS) == [0, 1, 2, 3]


@pytest.mark.parametrize(
    ("words", "incomplete", "wanted"),
    [
        ([], "wo", "workspace"),
        (["fk"], "forg", "forging_chu2020"),
        (["bag"], "id", "identify"),
        (["bag", "process"], "--sm", "--smooth"),
        (["bag", "report", "results", "--robot"], "exc", "excavator"),
        (["workspace", "ankle", "--colour"], "l", "limits"),
        (["check", "ankle"], "--d", "--draw"),
        (["fk", "excavator", "--frame"], "buck", "bucket"),
        (["fk", "forging_chu2020", "-u"], "q1=0.1,q12=0.1,q2", "q1=0.1,q12=0.1,q22="),
    ],
)
def test_shells_complete_verbs_options_and_robots(
    words: list[str], incomplete: str, wanted: str
) -> None:
    complete = ShellComplete(app, {}, "hybrid-dynamics", "_HYBRID_DYNAMICS_COMPLETE")
    assert [item.value for item in complete.get_completions(words, incomplete)] == [wanted]


def test_shells_complete_nothing_of_a_robot_that_is_none() -> None:
    complete = ShellComplete(app, {}, "hybrid-dynamics", "_HYBRID_DYNAMICS_COMPLETE")
    assert complete.get_completions(["fk", "nowhere.yaml", "--frame"], "") == []
