"""The group of verbs.

A verb is a module of `verbs` with a click command named `command`. The module is loaded when the
verb is used.
"""

from __future__ import annotations

import sys
from importlib import import_module
from typing import Any

import click

from hybrid_dynamics_core import __version__
from hybrid_dynamics_core.errors import HybridDynamicsError

from .exit_codes import click_error, exit_table
from .groups import Group
from .output import AS_JSON, fail

VERBS = {  # name -> module, in the order of the help
    "check": "check",
    "info": "info",
    "fk": "fk",
    "ik": "ik",
    "id": "inverse_dynamics",
    "fd": "forward_dynamics",
    "reactions": "reactions",
    "hydraulics": "hydraulics",
    "simulate": "simulate",
    "workspace": "workspace",
    "branches": "branches",
    "capability": "capability",
    "stiffness": "elastic.stiffness",
    "retime": "retime",
    "design": "design.make",
    "size": "design.size",
    "weigh": "measured.weigh",
    "calibrate": "calibrate",
    "estimate": "measured.estimate",
    "tolerances": "studies.tolerances",
    "sweep": "studies.sweep",
    "view": "view",
    "export": "export",
    "import": "import_file",
    "bag": "bag",
    "benchmark": "benchmark",
}


class Verbs(Group):
    """Group that loads the module of a verb when it is used, so that `--help` is quick."""

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002
        """Names of all verbs."""
        return list(VERBS)

    def get_command(
        self,
        ctx: click.Context,  # noqa: ARG002
        cmd_name: str,
    ) -> click.Command | None:
        """The verb with a name; None if there is none."""
        if cmd_name not in VERBS:
            return None
        module = import_module(f".verbs.{VERBS[cmd_name]}", __package__)
        command: click.Command = module.command
        return command

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Store whether JSON is requested, even if the command line is otherwise wrong."""
        ctx.meta[AS_JSON] = "--json" in args
        return super().parse_args(ctx, args)

    def invoke(self, ctx: click.Context) -> Any:
        """Run a verb; its errors are printed as JSON too if JSON is requested."""
        try:
            return self._invoke(ctx)
        except click.ClickException as error:
            if ctx.meta.get(AS_JSON):
                fail(ctx, error)
            raise

    def _invoke(self, ctx: click.Context) -> Any:
        """Run a verb, with errors of the library converted to those of click."""
        try:
            return super().invoke(ctx)
        except HybridDynamicsError as error:
            raise click_error(error) from error
        except BrokenPipeError:
            raise  # the output pipe is closed: click ends silently
        except (OSError, EOFError) as error:
            raise click.ClickException(f"{type(error).__name__}: {error}") from error
        except FloatingPointError as error:
            text = f"the numbers are beyond what can be computed with: {error}"
            raise click.ClickException(text) from error


HELP = """\
The model of a hybrid robot: closure, kinematics and dynamics of serial arms with closed loops.

ROBOT is the name of a robot that comes with the library, or the path of a description file. Values
are in rad, m, N and N m, or with a unit: 30*deg, 65*mm, 3*kN.
"""
EPILOG = f"""\b
Examples:
  hybrid-dynamics check my_robot.yaml --draw my_robot.svg
  hybrid-dynamics id forging_chu2020 -u 0,0.10,0.15,0
  hybrid-dynamics ik excavator --position 6.0 0 0.5 --json

\b
Exit codes:
{exit_table()}

\b
With --json errors are JSON, on stdout: {{"error": {{"kind": ..., "text": ...}}}}

\b
Shell completion of verbs, options, robots and files, by a line in
  ~/.bashrc   eval "$(_HYBRID_DYNAMICS_COMPLETE=bash_source hybrid-dynamics)"
  ~/.zshrc    eval "$(_HYBRID_DYNAMICS_COMPLETE=zsh_source hybrid-dynamics)"
  ~/.config/fish/config.fish
              _HYBRID_DYNAMICS_COMPLETE=fish_source hybrid-dynamics | source
"""


@click.group(
    cls=Verbs,
    help=HELP,
    epilog=EPILOG,
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.version_option(__version__, prog_name="hybrid-dynamics")
def app() -> None:
    """The group of all verbs."""


def run() -> None:
    """Run the command, under its name in help and completion."""
    sys.exit(app(prog_name="hybrid-dynamics"))
