"""The option --margin of verbs that size drives."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Final

import click

from hybrid_dynamics_core.ground.suggestions import no_such_name
from hybrid_dynamics_core.sizing import Margins

from ...quantities import value_of
from ...robot_options import named_pairs

_UNITS: Final = {"stroke": "m"}  # the others are factors

margins_option = click.option(
    "--margin",
    "margins",
    multiple=True,
    metavar="NAME=VALUE",
    help=(
        "What is needed beyond the cycle: a factor of pressure, torque, rms, speed, power or"
        " buckling (3.5 where left out), or a stroke left at either end; repeatable."
    ),
)


def margins_of(texts: tuple[str, ...]) -> Margins:
    """Margins from texts such as `pressure=1.2`.

    Raises:
        click.BadParameter: a name is unknown, or a value is no number of zero or more.
    """
    margins = Margins()
    names = [field.name for field in fields(margins)]
    for name, term in named_pairs("--margin", texts, "=", "pressure=1.2").items():
        if name not in names:
            raise click.BadParameter(no_such_name("margin", name, names), param_hint="--margin")
        try:
            value = value_of(term, [_UNITS.get(name, "1")])
        except (ValueError, ArithmeticError) as error:
            raise click.BadParameter(f"'{term}': {error}", param_hint="--margin") from error
        if value < 0.0:
            raise click.BadParameter(f"{name} is below zero", param_hint="--margin")
        margins = replace(margins, **{name: value})
    return margins
