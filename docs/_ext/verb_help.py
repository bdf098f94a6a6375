"""The directive `verbs`: what `hybrid-dynamics VERB --help` says, a section a verb."""

from __future__ import annotations

from collections.abc import Iterator

import click
from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from hybrid_dynamics_cli.app import app as program

PROGRAM = "hybrid-dynamics"
WIDTH = 96  # columns of a page


class VerbsDirective(SphinxDirective):
    """The texts, as the command prints them."""

    def run(self) -> list[nodes.Node]:
        """One section a verb."""
        return [self._section(*verb) for verb in verbs(program, PROGRAM)]

    def _section(self, name: str, command: click.Command, context: click.Context) -> nodes.section:
        section = nodes.section(ids=[nodes.make_id(name)], names=[nodes.fully_normalize_name(name)])
        section += nodes.title("", "", nodes.literal(name, name))
        text = command.get_help(context)
        section += nodes.literal_block(text, text, language="text")
        self.state.document.note_explicit_target(section)
        return section


def verbs(
    group: click.Group, name: str, parent: click.Context | None = None
) -> Iterator[tuple[str, click.Command, click.Context]]:
    """Every verb, groups before their members.

    Args:
        group: of verbs.
        name: of the group.
        parent: context of the group's own group.

    Yields:
        Full name, command, and a context to write its help in.
    """
    context = click.Context(
        group, parent, info_name=name, terminal_width=WIDTH, **group.context_settings
    )
    for verb in group.list_commands(context):
        command = group.get_command(context, verb)
        if command is None:
            raise KeyError(verb)
        verb_context = click.Context(command, context, info_name=verb, terminal_width=WIDTH)
        full_name = verb_context.command_path.removeprefix(f"{PROGRAM} ")
        yield full_name, command, verb_context
        if isinstance(command, click.Group):
            yield from verbs(command, verb, context)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("verbs", VerbsDirective)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
