"""Groups of verbs that are loaded when used, with hints for wrong names."""

from __future__ import annotations

import click


class Group(click.Group):
    """Group that looks up a verb by `list_commands`, without loading the others."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """The verb named by the first argument.

        Raises: click.UsageError: no verb has this name.
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
