"""Modules: templates with values for their parameters, attached to a link or frame of the robot.

Names inside a template become names of the robot. A link or frame is called MODULE_NAME. A joint or
closure is called PREFIX + NAME, with no prefix by default. In names, <leg> stands for the label of
a leg. `on` names the link or frame that carries the module.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...ground.suggestions import suggestion
from ..document import Data, Document, KeyPath, Provenance
from ..values import ValueReader
from .module_parameters import ModuleParameters, Scope, leg_labels
from .templates import Template, find_template

_SECTIONS = ("links", "frames", "joints", "closures", "reference")
_PLACES = ("links", "frames")
_NAME_TAKEN = "give this module other leg names (legs) or a prefix"


def expand_modules(document: Document) -> None:
    """Add the entries of every module, and its central configuration to the reference."""
    modules = document.entries("modules")
    if not modules:
        return
    values = ValueReader(document)
    for name, entry in modules.items():
        template = find_template(document, entry["template"], ("modules", name, "template"))
        _Module(values, name, entry, template).expand()


class _Module:
    def __init__(self, values: ValueReader, name: str, entry: Data, template: Template) -> None:
        self.values = values
        self.document: Document = values.document
        self.name = name
        self.entry = entry
        self.template = template
        self.path: KeyPath = ("modules", name)
        self.prefix: str = entry.get("prefix", "")
        self.legs: Data = template.data.get("legs", {})
        self.labels = leg_labels(self.document, name, entry, template)
        self.on = self._on()

    def expand(self) -> None:
        """Add the entries of the module once, then those of each leg."""
        parameters = ModuleParameters(self.values, self.name, self.entry, self.template)
        parameters.check_names()
        self._check_joint_names()
        scope = parameters.module_scope()
        leg_scopes = parameters.leg_scopes(scope, len(self.labels))
        self._add_sections(self.template.data, scope, None)
        for label, leg_scope in zip(self.labels, leg_scopes, strict=True):
            self._add_sections(self.legs, leg_scope, label)

    def _on(self) -> str:
        """The link or frame that carries the module; a frame is added if a pose is given."""
        on: str | Data = self.entry["on"]
        if isinstance(on, str):
            return on
        name = f"{self.name}_on"
        self.document.add(("frames", name), on, (*self.path, "on"))
        return name

    def _check_joint_names(self) -> None:
        once = self.template.data.get("joints", {})
        names = [*once, *self.legs.get("joints", {})]
        for name in self.entry.get("joints", {}):
            if name not in names:
                hint = suggestion(name, names)
                raise self.document.error(
                    (*self.path, "joints", name),
                    f"the template {self.template.name} has no joint '{name}'{hint}; known:"
                    f" {', '.join(names)}",
                )

    # -- entries

    def _add_sections(self, part: Data, scope: Scope, label: str | None) -> None:
        """Add the entries of the template, or of one leg of it."""
        for section in _SECTIONS:
            for name, entry in part.get(section, {}).items():
                self._add(section, name, _with_label(entry, label), scope, label)
        reference = part.get("reference", {})
        for name in part.get("joints", {}):
            if name not in reference:
                self._add("reference", name, 0, scope, label)

    def _add(self, section: str, name: str, entry: Any, scope: Scope, label: str | None) -> None:
        full_name = self._full_name(section, _with_label(name, label))
        if section == "reference" and full_name in self.document.section("reference"):
            return  # the robot has its own
        provenance = Provenance(self.path, f"template {self.template.name}: {section}.{name}")
        if section == "joints":
            entry = {**entry, **self._given_joint_entries(name, full_name)}
        path = (section, full_name)
        renamed = self._with_full_names(section, entry, provenance)
        self.document.add(path, renamed, provenance, scope, _NAME_TAKEN)
        if section == "joints" and entry["parent"] == "on":
            self.document.alias((*path, "parent"), (*self.path, "on"))

    def _given_joint_entries(self, name: str, full_name: str) -> Data:
        """Friction, drive and spring that the module gives a joint of the template."""
        given = self.entry.get("joints", {})
        entries: Data = given.get(name, {})
        for key in entries:
            written = (*self.path, "joints", name, key)
            self.document.alias(("joints", full_name, key), written)
        return entries

    # -- names

    def _full_name(self, section: str, local: str) -> str:
        if section in _PLACES:
            return f"{self.name}_{local}"
        return self.prefix + local

    def _with_full_names(self, section: str, entry: Any, provenance: Provenance) -> Any:
        """The entry with the robot's names of links in place of the template's."""
        if section == "joints":
            parent = self._full_place(entry["parent"], provenance)
            child = self._full_place(entry["child"], provenance)
            return {**entry, "parent": parent, "child": child}
        if section == "closures":
            between = {}
            for local, end in entry["between"].items():
                between[self._full_place(local, provenance)] = end
            return {**entry, "between": between}
        if section == "frames":
            return {**entry, "link": self._full_place(entry["link"], provenance)}
        return entry

    def _full_place(self, local: str, provenance: Provenance) -> str:
        """The robot's name of a link or frame of the template."""
        if local == "on":
            return self.on
        once = _place_names(self.template.data)
        for_legs = _place_names(self.legs)
        if local not in once and local not in self._labelled(for_legs):
            names = [*once, *for_legs]
            hint = suggestion(local, names)
            raise self.document.error(
                provenance.path,
                f"the template has no link '{local}'{hint} ({provenance.note}); known: on,"
                f" {', '.join(names)}",
            )
        return f"{self.name}_{local}"

    def _labelled(self, names: list[str]) -> set[str]:
        """Names with <leg> replaced by the label of each leg."""
        return {_with_label(name, label) for name in names for label in self.labels}


def _place_names(part: Data) -> list[str]:
    links = part.get("links", {})
    return [*links, *part.get("frames", {})]


def _with_label(entry: Any, label: str | None) -> Any:
    """The entry with <leg> replaced by a label, in every name and text."""
    if label is None:
        return entry
    if isinstance(entry, str):
        return entry.replace("<leg>", label)
    if isinstance(entry, Mapping):
        labelled = {}
        for key, value in entry.items():
            labelled[_with_label(key, label)] = _with_label(value, label)
        return labelled
    if isinstance(entry, list):
        return [_with_label(value, label) for value in entry]
    return entry
