"""Recordings: `hybrid-dynamics bag VERB`."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import click

from ..groups import Group

VERBS = ("process", "report", "identify", "export", "make")
NEEDS = (
    "this needs rosbags and lz4: pip install 'hybrid-dynamics-ros[bag]', or: pip install"
    " rosbags lz4"
)


class BagVerbs(Group):
    """Group that loads a verb when it is used; errors about bags are shown without a traceback."""

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
        try:
            module = import_module(f"..bags.{cmd_name}", __package__)
        except ModuleNotFoundError as error:
            raise missing(error) from error
        command: click.Command = module.command
        return command

    def invoke(self, ctx: click.Context) -> Any:
        """Run a verb; errors in a parameter file are shown without a traceback."""
        try:
            import_module("hybrid_dynamics_ros.bags.storage.bag_reader")
        except ModuleNotFoundError as error:
            raise missing(error) from error
        parameters = import_module("hybrid_dynamics_ros.parameters")
        try:
            return super().invoke(ctx)
        except parameters.ParameterError as error:
            raise click.ClickException(str(error)) from error


def missing(error: ModuleNotFoundError) -> click.ClickException:
    """The error for a missing module, with the extra to install."""
    return click.ClickException(f"{NEEDS} (there is no module {error.name})")


EPILOG = """\b
Examples:
  hybrid-dynamics bag process recording results --robot forging_chu2020
  hybrid-dynamics bag report results
  hybrid-dynamics bag process night_shift/ results/ --robot excavator --jobs 4
"""


@click.group(cls=BagVerbs, epilog=EPILOG, short_help="The model on recordings (rosbag2).")
def command() -> None:
    """The model on recordings (rosbag2): what the node would have said, reports, identification."""
