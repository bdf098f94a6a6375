"""Modules: a template with numbers put in, standing on a link or frame of the robot.

Names of a template are its own. In the robot its links and frames are called MODULE_NAME, its
joints and closures PREFIX + NAME (no prefix unless one is given), and <leg> is the label of a leg;
`on` is what the module stands on.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from ...ground.suggestions import suggestion
from ...ground.wording import counted
from ..document import Document, Origin, Path_
from ..expressions import evaluate
from ..values import Numbers
from .templates import Template, find_template

SECTIONS = ("links", "frames", "joints", "closures", "reference")


def expand_modules(document: Document) -> None:
    """Add links, frames, joints and closures of every module, and its central configuration to the reference."""
    modules = document.data.get("modules", {})
    if not modules:
        return
    numbers = Numbers(document)
    for name, entry in modules.items():
        template = find_template(document, entry["template"], ("modules", name, "template"))
        _Module(document, numbers, name, entry, template).expand()


class _Module:
    def __init__(
        self,
        document: Document,
        numbers: Numbers,
        name: str,
        entry: Mapping[str, Any],
        template: Template,
    ) -> None:
        self.document, self.numbers, self.name, self.entry = document, numbers, name, entry
        self.template = template
        self.path: Path_ = ("modules", name)
        self.prefix: str = entry.get("prefix", "")
        self.legs: Mapping[str, Any] = template.data.get("legs", {})
        self.labels = self._labels()
        self.on = self._on()

    def _labels(self) -> list[str]:
        told = [str(label) for label in self.legs.get("labels", [])]
        labels = [str(label) for label in self.entry.get("legs", told)]
        if len(labels) != len(told):
            problem = (
                f"has {counted(len(labels), 'name')}; the template {self.template.name} has"
                f" {counted(len(told), 'leg')}"
            )
            raise self.document.error((*self.path, "legs"), problem)
        return labels

    def _on(self) -> str:
        """The link or frame under the module; a frame of its own where a pose is given."""
        on: str | dict[str, Any] = self.entry["on"]
        if isinstance(on, str):
            return on
        name = f"{self.name}_on"
        self.document.add(("frames", name), on, (*self.path, "on"))
        return name

    # -- numbers

    def expand(self) -> None:
        scope: dict[str, float] = {}
        self._check_parameters()
        self._check_joints()
        self._parameters(scope, self.template.data.get("parameters", {}), None)
        self._values(scope, self.template.data.get("values", {}), "values")
        for label in self._scopes(scope):
            self._sections(*label)

    def _scopes(
        self, scope: dict[str, float]
    ) -> list[tuple[Mapping[str, Any], dict[str, float], str | None]]:
        """What is added: once for the module, then for each leg; with the names its expressions may use."""
        parts: list[tuple[Mapping[str, Any], dict[str, float], str | None]] = [
            (self.template.data, scope, None)
        ]
        for index, label in enumerate(self.labels):
            own = {**scope, "index": float(index), "count": float(len(self.labels))}
            self._parameters(own, self.legs.get("parameters", {}), index)
            self._values(own, self.legs.get("values", {}), "legs.values")
            parts.append((self.legs, own, label))
        return parts

    def _check_parameters(self) -> None:
        own, of_legs = (part.get("parameters", {}) for part in (self.template.data, self.legs))
        known = [*own, *of_legs]
        for name, value in self.entry.get("parameters", {}).items():
            path = (*self.path, "parameters", name)
            if name not in known:
                problem = (
                    f"the template {self.template.name} has no parameter"
                    f" '{name}'{suggestion(name, known)}"
                )
                raise self.document.error(path, f"{problem}; known: {', '.join(known)}")
            if isinstance(value, list) and name in own:
                raise self.document.error(
                    path, "is a list; this parameter is one number for the whole module"
                )
            if isinstance(value, list) and len(value) != len(self.labels):
                count = counted(len(value), "entry", "entries")
                problem = (
                    f"has {count}; expected one number, or {len(self.labels)}: one for each leg"
                )
                raise self.document.error(path, problem)

    def _check_joints(self) -> None:
        known = [
            name for part in (self.template.data, self.legs) for name in part.get("joints", {})
        ]
        for name in self.entry.get("joints", {}):
            if name not in known:
                problem = f"the template {self.template.name} has no joint '{name}'{suggestion(name, known)}"
                raise self.document.error(
                    (*self.path, "joints", name), f"{problem}; known: {', '.join(known)}"
                )

    def _parameters(
        self, scope: dict[str, float], parameters: Mapping[str, Any], leg: int | None
    ) -> None:
        given = self.entry.get("parameters", {})
        for name, told in parameters.items():
            path = (*self.path, "parameters", name)
            if name in given:
                value, where = given[name], path
                if isinstance(value, list) and leg is not None:
                    value, where = value[leg], (*path, leg)
                scope[name] = self.numbers.extended(value, where)
            elif "default" in told:
                scope[name] = self._evaluate(told["default"], scope, f"default of {name}")
            else:
                problem = (
                    f"missing '{name}', {told['about']}; the template {self.template.name} needs it"
                )
                raise self.document.error((*self.path, "parameters"), problem)
            self._check_range(scope[name], told, path)

    def _check_range(self, value: float, told: Mapping[str, Any], path: Path_) -> None:
        bad = "a number" if math.isnan(value) else ""
        if "above" in told and not value > told["above"]:
            bad = f"a number above {told['above']:g}"
        if "least" in told and not value >= told["least"]:
            bad = f"a number of at least {told['least']:g}"
        if bad:
            raise self.document.error(path, f"is {value:g}; expected {bad} ({told['about']})")

    def _values(self, scope: dict[str, float], values: Mapping[str, Any], where: str) -> None:
        for name, value in values.items():
            scope[name] = self._evaluate(value, scope, f"{where}.{name}")

    def _evaluate(self, value: float | str, scope: Mapping[str, float], what: str) -> float:
        try:
            return evaluate(value, scope) if isinstance(value, str) else float(value)
        except (ValueError, OverflowError) as error:
            problem = (
                f"these parameters do not fit: {error} (template {self.template.name}: {what})"
            )
            raise self.document.error((*self.path, "parameters"), problem) from error

    # -- entries

    def _sections(
        self, part: Mapping[str, Any], scope: Mapping[str, float], label: str | None
    ) -> None:
        for section in SECTIONS:
            for name, entry in part.get(section, {}).items():
                self._add(section, name, _filled(entry, label), scope, label)
        if "joints" in part:
            reference = part.get("reference", {})
            for name in part["joints"]:
                own = self._joint(_filled(name, label))
                if name not in reference and own not in self.document.section("reference"):
                    self._add("reference", name, 0, scope, label)

    def _add(
        self, section: str, name: str, entry: Any, scope: Mapping[str, float], label: str | None
    ) -> None:
        local = _filled(name, label)
        full = f"{self.name}_{local}" if section in ("links", "frames") else self._joint(local)
        if section == "reference" and full in self.document.section("reference"):
            return  # the user's own
        note = f"template {self.template.name}: {section}.{name}"
        origin = Origin(self.path, note)
        mend = "give this module other leg names (legs) or a prefix"
        if section == "joints":
            entry = {**entry, **self._told(name, full)}
        self.document.add(
            (section, full), self._renamed(section, entry, origin), origin, scope, mend
        )
        if section == "joints" and entry["parent"] == "on":
            self.document.alias((section, full, "parent"), (*self.path, "on"))

    def _told(self, name: str, full: str) -> Mapping[str, Any]:
        """Friction, drive and spring that the module gives a joint of the template."""
        told: Mapping[str, Any] = self.entry.get("joints", {}).get(name, {})
        for key in told:
            self.document.alias(("joints", full, key), (*self.path, "joints", name, key))
        return told

    def _joint(self, local: str) -> str:
        return self.prefix + local

    def _renamed(self, section: str, entry: Any, origin: Origin) -> Any:
        """The entry with the template's names of links replaced by the robot's."""
        if section == "joints":
            return {
                **entry,
                "parent": self._link(entry["parent"], origin),
                "child": self._link(entry["child"], origin),
            }
        if section == "closures":
            return {
                **entry,
                "between": {self._link(k, origin): v for k, v in entry["between"].items()},
            }
        if section == "frames":
            return {**entry, "link": self._link(entry["link"], origin)}
        return entry

    def _link(self, local: str, origin: Origin) -> str:
        if local == "on":
            return self.on
        known = [name for part in ("links", "frames") for name in self.template.data.get(part, {})]
        of_legs = [name for part in ("links", "frames") for name in self.legs.get(part, {})]
        if local not in known and not any(
            local == _filled(name, label) for name in of_legs for label in self.labels
        ):
            problem = (
                f"the template has no link '{local}'{suggestion(local, [*known, *of_legs])}"
                f" ({origin.note}); "
            )
            raise self.document.error(
                origin.path, f"{problem}known: on, {', '.join([*known, *of_legs])}"
            )
        return f"{self.name}_{local}"


def _filled(entry: Any, label: str | None) -> Any:
    """The entry with <leg> replaced in every name and text."""
    if label is None:
        return entry
    if isinstance(entry, str):
        return entry.replace("<leg>", label)
    if isinstance(entry, Mapping):
        return {_filled(key, label): _filled(value, label) for key, value in entry.items()}
    if isinstance(entry, list):
        return [_filled(value, label) for value in entry]
    return entry
