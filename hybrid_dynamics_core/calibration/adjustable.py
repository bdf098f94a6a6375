"""A robot whose geometry depends on numbers of its description."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ..algebra.live import kept
from ..description.build import described_numbers
from ..description.document import Data, Document, KeyPath
from ..description.expand.module_parameters import ModuleParameters
from ..description.expand.templates import find_template
from ..description.geometry import unit_axis
from ..description.model import RobotDescription
from ..description.parameters.entries_at import entry_at, has_entry
from ..description.parameters.number_keys import is_number_key
from ..description.parameters.paths import path_of, units_of
from ..description.parameters.written import Written, written_of
from ..description.values import ValueReader
from ..errors import InputError, UnknownNameError
from ..formats.reader import described
from ..ground.file_options import PathText
from ..library import load
from ..robot.robot import Robot

Place = Literal["file", "expanded", "gain", "base"]
Change = float | list[float]
OUTSIDE = ("gain", "base")  # places of parameters that no file has
_AXIS = re.compile(r"joints\.(?P<joint>.+)\.axis(?:\[(?P<index>[012])\])?")
_OF_MODULE = re.compile(r"(?P<name>\w+)(?:\[(?P<leg>\d+)\])?")
_UNIT = re.compile(r"\[(m|rad)\]")


@dataclass(frozen=True)
class FreeParameter:
    """A number that is to be estimated.

    Attributes:
        name: its path, as the user writes it.
        place: what it belongs to: the file, an entry that a template stands for, the gain of an
            encoder, or the pose of the base in the measuring frame.
        path: keys of its entry.
        start: value in the file [rad, m].
        unit: `m` or `rad`; empty if the file does not say.
    """

    name: str
    place: Place
    path: KeyPath
    start: float
    unit: str = ""


class AdjustableRobot:
    """Descriptions of a robot for any values of some of its numbers.

    Attributes:
        name: name of a shipped robot, or path of a file.
        robot: the robot as it is in the file.
        written: the entries of the file.
    """

    def __init__(self, robot: PathText | Robot) -> None:
        """Read a robot.

        Args:
            robot: name of a shipped robot, or path of a file; or a robot that was read.

        Raises:
            InputError, DescriptionError: as in `load`.
        """
        if isinstance(robot, Robot):
            self.name = robot.name
            self.robot = robot
        else:
            self.name = os.fspath(robot)
            if isinstance(robot, str):
                self.name = robot  # with its options
            self.robot = load(robot)
        self.written = written_of(self.robot.description)
        plain = self.written.document.copy()
        for link in plain.entries("links").values():
            if isinstance(link, dict):
                link.pop("visuals", None)
        self._plain = Written(plain, described, self.written.changes)

    def described(
        self, parameters: Iterable[FreeParameter], values: Iterable[float]
    ) -> RobotDescription:
        """The description, without visuals, for some values of parameters [rad, m].

        Raises:
            DescriptionError: a value is impossible.
        """
        return self._described(self._plain, parameters, values)

    def numbers(
        self, parameters: Iterable[FreeParameter], values: Iterable[Any]
    ) -> RobotDescription:
        """The numbers of the description, as its file has them, for values that may be live."""
        changes = self.changes(parameters, values)
        return described_numbers(self._plain.changed(changes).document_to_build())

    def with_visuals(
        self, parameters: Iterable[FreeParameter], values: Iterable[float]
    ) -> RobotDescription:
        """The description for some values of parameters [rad, m], with visuals."""
        return self._described(self.written, parameters, values)

    def _described(
        self, written: Written, parameters: Iterable[FreeParameter], values: Iterable[float]
    ) -> RobotDescription:
        changes = self.changes(parameters, values)
        return written.changed(changes).described()

    def changes(
        self, parameters: Iterable[FreeParameter], values: Iterable[Any]
    ) -> dict[KeyPath, Change]:
        """Numbers and lists to set in the file, by path.

        A component of what the file does not give as a list, such as an axis by its letter, sets
        the list.
        """
        changes: dict[KeyPath, Change] = {}
        for parameter, value in zip(parameters, values, strict=True):
            path = parameter.path
            if parameter.place in OUTSIDE:
                continue
            before = self._list_before(path)
            if not before:
                changes[path] = kept(value)
                continue
            numbers = changes.setdefault(path[:-1], before)
            if isinstance(numbers, list):
                numbers[int(path[-1])] = kept(value)
        return changes

    def _list_before(self, path: KeyPath) -> list[float]:
        """The list that an axis by its letter or a parameter of all legs stands for; or empty."""
        outer = path[:-1]
        if not isinstance(path[-1], int) or has_entry(self._document(path).data, path):
            return []
        if outer[-1] == "axis":
            letter = entry_at(self._document(path).data, outer)
            axis: list[float] = unit_axis(letter).tolist()
            return axis
        if outer[0] == "modules":
            return self._values_of_legs(outer)
        return []

    # -- names

    def parameters(self, names: Iterable[str]) -> list[FreeParameter]:
        """The parameters of some paths; a vector stands for its components.

        Raises:
            InputError: a path leads to no number, or is given twice.
        """
        parameters: dict[str, FreeParameter] = {}
        for name in names:
            for parameter in self._located(name.strip()):
                if parameter.name in parameters:
                    raise InputError(f"free: '{parameter.name}' is given twice")
                parameters[parameter.name] = parameter
        if not parameters:
            raise InputError("free: names no parameter; expected paths such as joints.q1.offset")
        return list(parameters.values())

    def _located(self, name: str) -> list[FreeParameter]:
        """The parameters of one path."""
        virtual = self._encoder_gain(name) or _base_poses(name)
        if virtual:
            return virtual
        try:
            path = path_of(self.written, name)
        except UnknownNameError as error:
            others = self._axis(name) or self._module_default(name)
            if others:
                return others
            raise InputError(f"free: {error}") from error
        document = self._document(path)
        entry = entry_at(document.data, path)
        if not isinstance(entry, list):
            return [self._parameter(name, path)]
        paths = [(*path, k) for k in range(len(entry))]
        return [self._parameter(f"{name}[{one[-1]}]", one) for one in paths]

    def _document(self, path: KeyPath) -> Document:
        """The document with a path: before short forms are expanded, or after."""
        before, after = self.written.expanded
        return before if has_entry(before.data, path[:2]) else after

    def _parameter(self, name: str, path: KeyPath) -> FreeParameter:
        """The parameter of a path."""
        document = self._document(path)
        _, after = self.written.expanded
        entry = entry_at(document.data, path)
        start = ValueReader(after).number(entry, path)
        unit = self._unit(path)
        before, _ = self.written.expanded
        if document is before:
            return FreeParameter(name, "file", path, start, unit)
        in_file, note = after.as_written(path)
        outer = entry_at(before.data, in_file[:-1])
        is_in_file = isinstance(outer, (dict, list)) and is_number_key(in_file)
        if note or not is_in_file:
            return FreeParameter(name, "expanded", path, start, unit)
        return FreeParameter(name, "file", in_file, start, unit)

    def _unit(self, path: KeyPath) -> str:
        """The unit of a number; empty if its place does not say."""
        units = units_of(self.written, path)
        if units in (("m",), ("rad",)):
            return units[0]
        if path[0] == "modules" and len(path) > 3:
            return self._unit_in_template(path)
        keys = [key for key in path if isinstance(key, str)]
        if keys[0] == "loops" or keys[-1] in ("xyz", "end"):
            return "m"
        return "rad" if keys[-1] in ("rpy", "axis") else ""

    def _unit_in_template(self, path: KeyPath) -> str:
        """The unit of a module's parameter, as its template says."""
        template = self._template(path)
        legs = template.get("legs", {})
        parameters: Data = dict(template.get("parameters", {}))
        parameters |= legs.get("parameters", {})
        entry = parameters.get(str(path[3]), {})
        about = entry.get("about", "")
        match = _UNIT.search(about)
        return "" if match is None else match[1]

    def _template(self, path: KeyPath) -> Data:
        return self._module(path).template.data

    def _encoder_gain(self, name: str) -> list[FreeParameter]:
        """The gain of an encoder, as `joints.q1.gain`."""
        joint = name.removeprefix("joints.").removesuffix(".gain")
        if name != f"joints.{joint}.gain" or joint not in self.robot.coordinates:
            return []
        return [FreeParameter(name, "gain", (joint,), 1.0, "1")]

    def _axis(self, name: str) -> list[FreeParameter]:
        """Components of an axis that the file gives by a letter."""
        match = _AXIS.fullmatch(name)
        _, after = self.written.expanded
        if match is None or match["joint"] not in after.entries("joints"):
            return []
        path: KeyPath = ("joints", match["joint"], "axis")
        vector = unit_axis(entry_at(after.data, path))
        in_file, note = after.as_written(path)
        place: Place = "expanded"
        if not note:
            place = "file"
            path = in_file
        chosen = [0, 1, 2]
        if match["index"] is not None:
            chosen = [int(match["index"])]
        parameters: list[FreeParameter] = []
        for k in chosen:
            label = f"joints.{match['joint']}.axis[{k}]"
            start = float(vector[k])
            parameter = FreeParameter(label, place, (*path, k), start, "rad")
            parameters.append(parameter)
        return parameters

    def _module_default(self, name: str) -> list[FreeParameter]:
        """A parameter of a module that has the default of its template, or one of a leg."""
        for module in self.written.document.entries("modules"):
            prefix = f"modules.{module}.parameters."
            match = _OF_MODULE.fullmatch(name.removeprefix(prefix))
            if not name.startswith(prefix) or match is None:
                continue
            path: KeyPath = ("modules", module, "parameters", match["name"])
            if match["leg"] is None:
                return self._from_scope(name, path)
            values = self._values_of_legs(path)
            leg = int(match["leg"])
            if leg < len(values):
                unit = self._unit_in_template(path)
                return [FreeParameter(name, "file", (*path, leg), values[leg], unit)]
        return []

    def _from_scope(self, name: str, path: KeyPath) -> list[FreeParameter]:
        """A parameter of a whole module that is left out."""
        start = self._module(path).module_scope().get(str(path[3]), np.nan)
        if not np.isfinite(start) or path[3] not in self._template(path).get("parameters", {}):
            return []
        return [FreeParameter(name, "file", path, start, self._unit_in_template(path))]

    def _values_of_legs(self, path: KeyPath) -> list[float]:
        """Values of a module's parameter by leg; empty if it is none of legs."""
        legs = self._template(path).get("legs", {})
        if path[3] not in legs.get("parameters", {}):
            return []
        module = self._module(path)
        scopes = module.leg_scopes(module.module_scope(), len(legs.get("labels", [])))
        return [scope[str(path[3])] for scope in scopes]

    def _module(self, path: KeyPath) -> ModuleParameters:
        """The parameters of a module."""
        document = self.written.document
        module = str(path[1])
        entry = document.entries("modules")[module]
        template = find_template(document, entry["template"], (*path[:2], "template"))
        return ModuleParameters(ValueReader(document), module, entry, template)


def _base_poses(name: str) -> list[FreeParameter]:
    """Components of the pose of the base in the measuring frame, as `base.xyz[0]`."""
    parameters: list[FreeParameter] = []
    for key, unit in (("xyz", "m"), ("rpy", "rad")):
        for k in range(3):
            label = f"base.{key}[{k}]"
            if name in (label, f"base.{key}"):
                parameter = FreeParameter(label, "base", (key, k), 0.0, unit)
                parameters.append(parameter)
    return parameters
