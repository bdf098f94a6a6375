"""Groups of verbs: a verb is loaded when it is asked for, and one that does not exist gets a hint."""

from __future__ import annotations

import click


class Group(click.Group):
    """Names of verbs come from `list_commands`, so that nothing is loaded to look for one."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """The verb of the first argument."""
        name, verbs = args[0], self.list_commands(ctx)
        if name not in verbs and not name.startswith("-") and not ctx.resilient_parsing:
            from hybrid_dynamics_core.ground.suggestions import (  # noqa: PLC0415  only where it is needed
                suggestion,
            )

            raise click.UsageError(
                f"No such command '{name}'{suggestion(name, verbs)}; known: {', '.join(verbs)}", ctx
            )
        return super().resolve_command(ctx, args)
