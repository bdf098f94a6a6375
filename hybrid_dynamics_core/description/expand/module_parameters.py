"""Parameters of a module: numbers that the robot gives to a template, once or for each leg."""

from __future__ import annotations

import math

from ...ground.suggestions import suggestion
from ...ground.wording import counted
from ..document import Data, Document, KeyPath
from ..values import Scalar, ValueReader, number_from
from .templates import Template

Scope = dict[str, float]  # the names that expressions of a template may use


def leg_labels(document: Document, name: str, entry: Data, template: Template) -> list[str]:
    """Labels of the legs, from the module or, by default, from its template.

    Raises:
        DescriptionError: the module gives a wrong number of labels.
    """
    legs = template.data.get("legs", {})
    defaults = list(map(str, legs.get("labels", [])))
    labels = list(map(str, entry.get("legs", defaults)))
    if len(labels) != len(defaults):
        raise document.error(
            ("modules", name, "legs"),
            f"has {counted(len(labels), 'name')}; the template {template.name} has"
            f" {counted(len(defaults), 'leg')}",
        )
    return labels


class ModuleParameters:
    """Reads the parameters and values of one module."""

    def __init__(self, values: ValueReader, name: str, entry: Data, template: Template) -> None:
        self.values = values
        self.document = values.document
        self.template = template
        self.path: KeyPath = ("modules", name, "parameters")
        self.given: Data = entry.get("parameters", {})
        self.once: Data = template.data
        self.for_legs: Data = template.data.get("legs", {})

    def check_names(self) -> None:
        """Check that the template has the parameters, with one number or one for each leg.

        Raises:
            DescriptionError: a name or a number of values is wrong.
        """
        once = self.once.get("parameters", {})
        names = [*once, *self.for_legs.get("parameters", {})]
        leg_count = len(self.for_legs.get("labels", []))
        for name, value in self.given.items():
            path = (*self.path, name)
            if name not in names:
                hint = suggestion(name, names)
                raise self.document.error(
                    path,
                    f"the template {self.template.name} has no parameter '{name}'{hint}; known:"
                    f" {', '.join(names)}",
                )
            if not isinstance(value, list):
                continue
            if name in once:
                raise self.document.error(
                    path, "is a list; this parameter is one number for the whole module"
                )
            if len(value) != leg_count:
                entries = counted(len(value), "entry", "entries")
                raise self.document.error(
                    path,
                    f"has {entries}; expected one number, or {leg_count}: one for each leg",
                )

    def module_scope(self) -> Scope:
        """Parameters and values of the module."""
        scope: Scope = {}
        for name, parameter in self.once.get("parameters", {}).items():
            scope[name] = self._parameter(name, parameter, scope, None)
        self._add_values(scope, self.once, "values")
        return scope

    def leg_scopes(self, module_scope: Scope, count: int) -> list[Scope]:
        """For each leg, its parameters and values, those of the module, `index` and `count`."""
        scopes: list[Scope] = []
        for leg in range(count):
            scope = {**module_scope, "index": float(leg), "count": float(count)}
            for name, parameter in self.for_legs.get("parameters", {}).items():
                scope[name] = self._parameter(name, parameter, scope, leg)
            self._add_values(scope, self.for_legs, "legs.values")
            scopes.append(scope)
        return scopes

    def _parameter(self, name: str, parameter: Data, scope: Scope, leg: int | None) -> float:
        """The value of a parameter for the module or one leg, or its default."""
        path = (*self.path, name)
        if name in self.given:
            value = self._given_value(name, leg)
        elif "default" in parameter:
            value = self._evaluate(parameter["default"], scope, f"default of {name}")
        else:
            raise self.document.error(
                self.path,
                f"missing '{name}', {parameter['about']}; the template {self.template.name} needs"
                " it",
            )
        self._check_range(value, parameter, path)
        return value

    def _given_value(self, name: str, leg: int | None) -> float:
        value = self.given[name]
        path = (*self.path, name)
        if isinstance(value, list) and leg is not None:
            return self.values.number_or_infinity(value[leg], (*path, leg))
        return self.values.number_or_infinity(value, path)

    def _check_range(self, value: float, parameter: Data, path: KeyPath) -> None:
        expected = ""
        if math.isnan(value):
            expected = "a finite number; this is not finite"
        if "above" in parameter and not value > parameter["above"]:
            expected = f"a number above {parameter['above']:g}"
        if "least" in parameter and not value >= parameter["least"]:
            expected = f"a number of at least {parameter['least']:g}"
        if expected:
            raise self.document.error(
                path, f"is {value:g}; expected {expected} ({parameter['about']})"
            )

    def _add_values(self, scope: Scope, part: Data, where: str) -> None:
        """Add the values that a template computes from its parameters."""
        for name, value in part.get("values", {}).items():
            scope[name] = self._evaluate(value, scope, f"{where}.{name}")

    def _evaluate(self, value: Scalar, scope: Scope, what: str) -> float:
        try:
            return number_from(value, scope)
        except (ValueError, OverflowError) as error:
            raise self.document.error(
                self.path,
                f"these parameters do not fit: {error} (template {self.template.name}: {what})",
            ) from error
