"""Groups of verbs: a verb is loaded when it is used, and a wrong name gets a hint."""

from __future__ import annotations

import click


class Group(click.Group):
    """Looks for a verb among the names of `list_commands`, so that none is loaded for it."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """The verb of the first argument.

        Raises:
            click.UsageError: there is no such verb.
        """
        name = args[0]
        verbs = self.list_commands(ctx)
        is_option = name.startswith("-")
        if name not in verbs and not is_option and not ctx.resilient_parsing:
            raise click.UsageError(_no_such_verb(name, verbs), ctx)
        return super().resolve_command(ctx, args)


def _no_such_verb(name: str, verbs: list[str]) -> str:
    # Loaded only for this message.
    from hybrid_dynamics_core.ground.suggestions import suggestion  # noqa: PLC0415

    return f"No such command '{name}'{suggestion(name, verbs)}; known: {', '.join(verbs)}"
