"""modelDescription.xml of a unit, for FMI 3.0 and 2.0."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from xml.etree import ElementTree as ET

from .variables import DISTANCE, Variable

FMI2, FMI3 = "2.0", "3.0"
VERSIONS = (FMI3, FMI2)
TOLERANCE = "1e-9"
BASE_UNITS: Mapping[str, Mapping[str, str]] = {
    "s": {"s": "1"},
    "m": {"m": "1"},
    "m/s": {"m": "1", "s": "-1"},
    "m/s2": {"m": "1", "s": "-2"},
    "rad": {"rad": "1"},
    "rad/s": {"rad": "1", "s": "-1"},
    "rad/s2": {"rad": "1", "s": "-2"},
    "kg": {"kg": "1"},
    "kg.m2": {"kg": "1", "m": "2"},
    "N": {"kg": "1", "m": "1", "s": "-2"},
    "N.m": {"kg": "1", "m": "2", "s": "-2"},
    "N.s/m": {"kg": "1", "s": "-1"},
    "N.m.s/rad": {"kg": "1", "m": "2", "s": "-1", "rad": "-1"},
}


@dataclass(frozen=True)
class Unit:
    """A unit to be described.

    Attributes:
        identifier: C identifier of the model.
        title: name and purpose, for people.
        token: marks the unit, in the description and in its code.
        version: of FMI, "3.0" or "2.0".
        variables: in the order of their value references.
        sources: names of files to compile.
    """

    identifier: str
    title: str
    token: str
    version: str
    variables: Sequence[Variable]
    sources: Sequence[str]


def description_text(unit: Unit) -> str:
    """The text of modelDescription.xml."""
    root = ET.Element("fmiModelDescription", _heading(unit))
    if unit.version == FMI3:
        _interfaces_3(root, unit)
    else:
        _interfaces_2(root, unit)
    _units(root, unit.variables)
    categories = ET.SubElement(root, "LogCategories")
    for name in _CATEGORIES[unit.version]:
        ET.SubElement(categories, "Category", {"name": name})
    experiment = {"startTime": "0", "stopTime": "1", "tolerance": TOLERANCE}
    ET.SubElement(root, "DefaultExperiment", experiment)
    listed = ET.SubElement(root, "ModelVariables")
    write = _variable_3 if unit.version == FMI3 else _variable_2
    numbers = {variable.name: k for k, variable in enumerate(unit.variables)}
    for variable in unit.variables:
        write(listed, variable, numbers)
    _structure(root, unit, numbers)
    return _text(root)


def build_text(unit: Unit) -> str:
    """The text of buildDescription.xml of FMI 3.0, which says what to compile."""
    root = ET.Element("fmiBuildDescription", {"fmiVersion": FMI3})
    build = ET.SubElement(root, "BuildConfiguration", {"modelIdentifier": unit.identifier})
    files = ET.SubElement(build, "SourceFileSet", {"language": "C99"})
    for name in unit.sources:
        ET.SubElement(files, "SourceFile", {"name": name})
    return _text(root)


_TYPES_3 = {"Real": "Float64", "Boolean": "Boolean"}
_CATEGORIES = {
    FMI3: ("warning", "discard", "error"),
    FMI2: ("logStatusWarning", "logStatusDiscard", "logStatusError"),
}


def _text(root: ET.Element) -> str:
    ET.indent(root)
    body = ET.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{body}\n'


def _heading(unit: Unit) -> dict[str, str]:
    marks = {FMI3: "instantiationToken", FMI2: "guid"}
    heading = {
        "fmiVersion": unit.version,
        "modelName": unit.identifier,
        marks[unit.version]: unit.token,
        "description": unit.title,
        "generationTool": "hybrid_dynamics",
        "variableNamingConvention": "structured",
    }
    if unit.version == FMI2:
        heading["numberOfEventIndicators"] = str(sum(x.block == DISTANCE for x in unit.variables))
    return heading


def _interfaces_3(root: ET.Element, unit: Unit) -> None:
    common = {
        "modelIdentifier": unit.identifier,
        "canGetAndSetFMUState": "true",
        "canSerializeFMUState": "true",
        "providesDirectionalDerivatives": "true",
    }
    ET.SubElement(root, "ModelExchange", {**common, "needsCompletedIntegratorStep": "true"})
    variable_steps = {"canHandleVariableCommunicationStepSize": "true"}
    ET.SubElement(root, "CoSimulation", {**common, **variable_steps})


def _interfaces_2(root: ET.Element, unit: Unit) -> None:
    common = {
        "modelIdentifier": unit.identifier,
        "canGetAndSetFMUstate": "true",
        "canSerializeFMUstate": "true",
        "providesDirectionalDerivative": "true",
    }
    variable_steps = {"canHandleVariableCommunicationStepSize": "true"}
    exchange = ET.SubElement(root, "ModelExchange", common)
    simulation = ET.SubElement(root, "CoSimulation", {**common, **variable_steps})
    for interface in (exchange, simulation):
        files = ET.SubElement(interface, "SourceFiles")
        for name in unit.sources:
            ET.SubElement(files, "File", {"name": name})


def _units(root: ET.Element, variables: Sequence[Variable]) -> None:
    names = dict.fromkeys(variable.unit for variable in variables if variable.unit)
    definitions = ET.SubElement(root, "UnitDefinitions")
    for name in names:
        unit = ET.SubElement(definitions, "Unit", {"name": name})
        ET.SubElement(unit, "BaseUnit", dict(BASE_UNITS[name]))


def _attributes(variable: Variable, number: int) -> dict[str, str]:
    attributes = {
        "name": variable.name,
        "valueReference": str(number),
        "causality": variable.causality,
        "variability": variable.variability,
    }
    if variable.initial:
        attributes["initial"] = variable.initial
    if variable.text:
        attributes["description"] = variable.text
    return attributes


def _value(variable: Variable) -> dict[str, str]:
    attributes = {}
    if variable.unit:
        attributes["unit"] = variable.unit
    if variable.start is not None:
        attributes["start"] = repr(variable.start).lower()
    return attributes


def _variable_3(parent: ET.Element, variable: Variable, numbers: Mapping[str, int]) -> None:
    attributes = {**_attributes(variable, numbers[variable.name]), **_value(variable)}
    if variable.derivative_of:
        attributes["derivative"] = str(numbers[variable.derivative_of])
    ET.SubElement(parent, _TYPES_3[variable.type], attributes)


def _variable_2(parent: ET.Element, variable: Variable, numbers: Mapping[str, int]) -> None:
    outer = _attributes(variable, numbers[variable.name])
    scalar = ET.SubElement(parent, "ScalarVariable", outer)
    value = _value(variable)
    if variable.derivative_of:
        value["derivative"] = str(numbers[variable.derivative_of] + 1)
    ET.SubElement(scalar, variable.type, value)


def _structure(root: ET.Element, unit: Unit, numbers: Mapping[str, int]) -> None:
    """Outputs, derivatives, and what is unknown at the start."""
    structure = ET.SubElement(root, "ModelStructure")
    lists = _lists(unit.variables, numbers)
    if unit.version == FMI3:
        for tag, listed in lists.items():
            for number in listed:
                ET.SubElement(structure, tag, {"valueReference": str(number)})
        return
    for tag, tag_3 in _LISTS_2.items():
        listed = lists[tag_3]
        if listed:
            group = ET.SubElement(structure, tag)
            _indices(group, listed)


_LISTS_2 = {
    "Outputs": "Output",
    "Derivatives": "ContinuousStateDerivative",
    "InitialUnknowns": "InitialUnknown",
}


def _lists(variables: Sequence[Variable], numbers: Mapping[str, int]) -> dict[str, list[int]]:
    """Numbers of variables by the list of FMI 3.0 that they are in."""
    lists: dict[str, list[int]] = {tag: [] for tag in _LISTS_2.values()}
    lists["EventIndicator"] = []
    for variable in variables:
        number = numbers[variable.name]
        if variable.causality == "output":
            lists["Output"].append(number)
        if variable.derivative_of:
            lists["ContinuousStateDerivative"].append(number)
        if variable.block == DISTANCE:
            lists["EventIndicator"].append(number)
        elif variable.initial == "calculated":
            lists["InitialUnknown"].append(number)
    return lists


def _indices(group: ET.Element, numbers: Sequence[int]) -> None:
    for number in numbers:
        ET.SubElement(group, "Unknown", {"index": str(number + 1)})
