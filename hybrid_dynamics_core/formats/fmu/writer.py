"""A robot as a Functional Mock-up Unit."""

from __future__ import annotations

import hashlib
import io
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files

from ...errors import InputError
from ...ground.suggestions import no_such_name
from ...robot.robot import Robot
from ...robot.taken import AnyRobot, robot_of
from ..c.calls import lack_of_masses
from ..c.limit_notes import limits_not_exported
from ..c.names import identifier
from ..c.writer import LoadsOf, source_of
from .binary import Binary, compiled
from .description import FMI3, VERSIONS, Unit, build_text, description_text
from .directional import DIRECTIONAL
from .model_header import model_text
from .variables import FORWARD_DYNAMICS, INVERSE_DYNAMICS, PROGRAMS, Variable, variables_of

FUNCTIONS = {
    FORWARD_DYNAMICS: ("close", "forward_dynamics", "forward_kinematics"),
    INVERSE_DYNAMICS: ("close", "inverse_dynamics"),
}
TITLES = {
    FORWARD_DYNAMICS: "efforts of the drives in, motion out",
    INVERSE_DYNAMICS: "motion in, efforts of the drives out",
}
DATE = (1980, 1, 1, 0, 0, 0)  # of all files, so that the same robot is the same unit


@dataclass(frozen=True)
class FunctionalMockupUnit:
    """A unit to be written to a file.

    Attributes:
        identifier: C identifier of the model, and the usual name of the file.
        content: bytes of the file.
        without_binary: why there is no binary in it; empty if there is one.
    """

    identifier: str
    content: bytes
    without_binary: str


def to_fmu(
    robot: AnyRobot,
    program: str = FORWARD_DYNAMICS,
    *,
    version: str = FMI3,
    loads: LoadsOf = "description",
) -> FunctionalMockupUnit:
    """The model of a robot as a unit of FMI, for co-simulation and model exchange.

    Its sources are inside, and a binary for this machine where there is a C compiler.

    Args:
        robot: the robot, or its description.
        program: "forward_dynamics" for efforts in and motion out, or "inverse_dynamics".
        version: of FMI, "3.0" or "2.0".
        loads: "description" to compile its loads in; "arguments" for parameters of a payload and
            of friction.

    Raises:
        InputError: there is no such program or version, nothing moves, or no link has a mass.
    """
    machine = robot_of(robot)
    if program not in PROGRAMS:
        raise InputError(no_such_name("program of a unit", program, PROGRAMS))
    if version not in VERSIONS:
        raise InputError(f"version: {version!r}: expected {' or '.join(VERSIONS)}")
    lack = lack_of_masses(machine)
    if lack:
        raise InputError(f"{machine.name}: {lack}, so a unit of its dynamics has no results")
    model = identifier(machine.name)
    variables = variables_of(machine, program, loads == "arguments")
    texts = _code(machine, program, version, loads)
    name = model if program == FORWARD_DYNAMICS else f"{model}_{program}"
    token = _token(name, version, variables, texts)
    texts["unit_model.h"] = model_text(machine, program, variables, token)
    sources = [f"{model}.c", f"fmi{version[0]}.c"]
    title = f"{machine.name}: {TITLES[program]}"
    note = limits_not_exported(machine.description)
    if note:
        title = f"{title}. {note}"
    described = Unit(name, title, token, version, variables, sources)
    binary = compiled(texts, sources, name, version)
    return FunctionalMockupUnit(name, _zipped(described, texts, binary), binary.reason)


def _code(robot: Robot, program: str, version: str, loads: LoadsOf) -> dict[str, str]:
    """The C files of a unit, but for what ties them to its variables."""
    further = [DIRECTIONAL[program]]
    texts = source_of(robot, FUNCTIONS[program], loads, further=further)
    ours = files(__package__) / "sources"
    places = {
        "unit.h": "unit.h",
        "continuous.h": "continuous.h",
        "unit_kind.h": f"{program}.h",
        f"fmi{version[0]}.c": f"fmi{version[0]}.c",
    }
    for name, place in places.items():
        texts[name] = (ours / place).read_text(encoding="utf-8")
    return texts


def _token(name: str, version: str, variables: list[Variable], texts: Mapping[str, str]) -> str:
    """The instantiation token, another one for other variables or code."""
    digest = hashlib.sha256(f"{name} {version} {variables}".encode())
    for text in texts.values():
        digest.update(text.encode())
    return f"{{{digest.hexdigest()[:32]}}}"


def _zipped(unit: Unit, texts: Mapping[str, str], binary: Binary) -> bytes:
    """The bytes of the file."""
    content: dict[str, bytes] = {"modelDescription.xml": description_text(unit).encode()}
    for name, text in texts.items():
        content[f"sources/{name}"] = text.encode()
    if unit.version == FMI3:
        content["sources/buildDescription.xml"] = build_text(unit).encode()
    if binary.path:
        content[binary.path] = binary.content
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in content.items():
            entry = zipfile.ZipInfo(name, DATE)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, data)
    return file.getvalue()
