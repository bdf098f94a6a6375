"""Units of FMI called through ctypes, as an importer calls them, without a library for it."""

from __future__ import annotations

import ctypes
import io
import zipfile
from collections.abc import Mapping, Sequence
from ctypes import POINTER, byref, c_bool, c_char_p, c_double, c_int, c_size_t, c_uint32, c_void_p
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from hybrid_dynamics_core.formats.fmu.writer import FunctionalMockupUnit

OK, WARNING, DISCARD, ERROR = range(4)
LOG = ctypes.CFUNCTYPE(None, c_void_p, c_int, c_char_p, c_char_p)


def unpacked(unit: FunctionalMockupUnit, folder: Path) -> Path:
    """The folder with the files of a unit."""
    place = folder / unit.identifier
    with zipfile.ZipFile(io.BytesIO(unit.content)) as archive:
        archive.extractall(place)
    return place


def described(folder: Path) -> ElementTree.Element:
    """The description of an unpacked unit."""
    return ElementTree.parse(folder / "modelDescription.xml").getroot()


class Unit3:
    """A unit of FMI 3.0, instantiated for co-simulation or for model exchange."""

    def __init__(self, folder: Path, *, exchange: bool = False, mark: str = "") -> None:
        root = described(folder)
        self.references: dict[str, int] = {}
        for variable in root.find("ModelVariables"):
            self.references[variable.get("name")] = int(variable.get("valueReference"))
        library = next((folder / "binaries").rglob(f"{root.get('modelName')}.*"))
        self.library = ctypes.CDLL(str(library))
        self.said: list[str] = []
        self.log = LOG(lambda _where, _status, _category, text: self.said.append(text.decode()))
        token = (mark or root.get("instantiationToken")).encode()
        name = "ModelExchange" if exchange else "CoSimulation"
        function = getattr(self.library, f"fmi3Instantiate{name}")
        function.restype = c_void_p
        head = (b"one", token, None, c_bool(False), c_bool(False))
        middle = () if exchange else (c_bool(False), c_bool(True), None, c_size_t(0))
        ends = (None, self.log) if exchange else (None, self.log, None)
        self.instance = function(*head, *middle, *ends)

    def start(self, values: Mapping[str, float], tolerance: float = 1e-9) -> int:
        """Set values and initialise; the worst status."""
        status = self.call(
            "EnterInitializationMode",
            c_bool(True),
            c_double(tolerance),
            c_double(0.0),
            c_bool(False),
            c_double(0.0),
        )
        return max(status, self.set(values), self.call("ExitInitializationMode"))

    def call(self, name: str, *arguments: object) -> int:
        return getattr(self.library, f"fmi3{name}")(c_void_p(self.instance), *arguments)

    def set(self, values: Mapping[str, float]) -> int:
        references = self._references(list(values))
        numbers = (c_double * len(values))(*values.values())
        size = c_size_t(len(values))
        return self.call("SetFloat64", references, size, numbers, size)

    def vary(self, values: Mapping[str, float]) -> int:
        """Set states of model exchange, u before u', and inputs; the worst status."""
        size = c_size_t()
        assert self.call("GetNumberOfContinuousStates", byref(size)) == OK
        names = list(values)
        states = np.array([values[name] for name in names[: size.value]])
        inputs = {name: values[name] for name in names[size.value :]}
        return max(self.call("SetContinuousStates", pointer(states), size), self.set(inputs))

    def set_boolean(self, name: str, value: bool) -> int:
        one = c_size_t(1)
        return self.call("SetBoolean", self._references([name]), one, byref(c_bool(value)), one)

    def get(self, names: Sequence[str]) -> tuple[int, np.ndarray]:
        """The status and the values."""
        numbers = (c_double * len(names))()
        size = c_size_t(len(names))
        status = self.call("GetFloat64", self._references(names), size, numbers, size)
        return status, np.array(numbers)

    def step(self, time: float, length: float) -> tuple[int, bool, float]:
        """The status, whether the unit wants to end, and the time that it came to."""
        flags = [c_bool(), c_bool(), c_bool()]
        last = c_double()
        pointers = [byref(flag) for flag in flags]
        status = self.call(
            "DoStep", c_double(time), c_double(length), c_bool(True), *pointers, byref(last)
        )
        return status, flags[1].value, last.value

    def slopes(self, states: np.ndarray) -> tuple[int, np.ndarray]:
        """The status and the derivatives at states of model exchange."""
        size = c_size_t(len(states))
        values = np.ascontiguousarray(states, dtype=float)
        assert self.call("SetContinuousStates", pointer(values), size) == OK
        out = np.full(len(states), 7.0)
        return self.call("GetContinuousStateDerivatives", pointer(out), size), out

    def directional(
        self, unknowns: Sequence[str], seeds: Mapping[str, float]
    ) -> tuple[int, np.ndarray]:
        """The status and the changes of unknowns for changes of others."""
        n, m = c_size_t(len(unknowns)), c_size_t(len(seeds))
        seed = np.array([*seeds.values()])
        out = np.full(len(unknowns), 7.0)
        references = self._references(unknowns), n, self._references([*seeds]), m
        values = pointer(seed), m, pointer(out), n
        return self.call("GetDirectionalDerivative", *references, *values), out

    def _references(self, names: Sequence[str]) -> object:
        return (c_uint32 * len(names))(*(self.references[name] for name in names))


def pointer(values: np.ndarray) -> object:
    return values.ctypes.data_as(POINTER(c_double))


class Callbacks2(ctypes.Structure):
    """The functions that an importer of FMI 2.0 lends to a unit."""

    _fields_ = (
        ("log", c_void_p),
        ("allocate", c_void_p),
        ("release", c_void_p),
        ("finished", c_void_p),
        ("environment", c_void_p),
    )


class Unit2:
    """A unit of FMI 2.0 for co-simulation; it is said nothing, and takes memory from C."""

    def __init__(self, folder: Path) -> None:
        root = described(folder)
        self.references: dict[str, int] = {}
        for variable in root.find("ModelVariables"):
            self.references[variable.get("name")] = int(variable.get("valueReference"))
        library = next((folder / "binaries").rglob(f"{root.get('modelName')}.*"))
        self.library = ctypes.CDLL(str(library))
        c = ctypes.CDLL(None)
        lent = [ctypes.cast(function, c_void_p) for function in (c.calloc, c.free)]
        self.callbacks = Callbacks2(None, *lent, None, None)
        create = self.library.fmi2Instantiate
        create.restype = c_void_p
        mark = root.get("guid").encode()
        self.instance = create(b"one", 1, mark, None, byref(self.callbacks), 0, 0)

    def call(self, name: str, *arguments: object) -> int:
        return getattr(self.library, f"fmi2{name}")(c_void_p(self.instance), *arguments)

    def start(self) -> int:
        none = c_double(0.0)
        first = self.call("SetupExperiment", 1, c_double(1e-9), none, 0, none)
        return max(first, self.call("EnterInitializationMode"), self.call("ExitInitializationMode"))

    def step(self, time: float, length: float) -> int:
        return self.call("DoStep", c_double(time), c_double(length), 1)

    def get(self, names: Sequence[str]) -> np.ndarray:
        references = (c_uint32 * len(names))(*(self.references[name] for name in names))
        numbers = (c_double * len(names))()
        assert self.call("GetReal", references, c_size_t(len(names)), numbers) == OK
        return np.array(numbers)

    def last(self) -> tuple[float, bool]:
        """The time that the last step came to, and whether the unit wants to end."""
        time, over = c_double(), c_int()
        assert self.call("GetRealStatus", 2, byref(time)) == OK
        assert self.call("GetBooleanStatus", 3, byref(over)) == OK
        return time.value, bool(over.value)
