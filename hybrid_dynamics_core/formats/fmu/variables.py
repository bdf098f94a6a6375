"""The variables of a unit, in the order of their value references."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from ...ground.arrays import Array
from ...ground.units import coordinate_unit, effort_unit
from ...robot.robot import Robot
from ..c.names import identifiers
from .limits import Limit, limits_of

AXES = ("x", "y", "z")
INERTIA = ("xx", "xy", "xz", "yy", "yz", "zz")
PAYLOAD_UNITS = ("kg", "m", "m", "m", *["kg.m2"] * 6)
FORWARD_DYNAMICS, INVERSE_DYNAMICS = "forward_dynamics", "inverse_dynamics"
PROGRAMS = (FORWARD_DYNAMICS, INVERSE_DYNAMICS)
DISTANCE = "DISTANCE"  # block of the distances to limits


@dataclass(frozen=True)
class Variable:
    """A variable of a unit.

    Attributes:
        name: structured name, such as "u.q1".
        block: block of the C code that it belongs to, such as "U".
        causality, variability, initial: as FMI has them; initial is empty where FMI sets it.
        unit: name of its unit; empty for one.
        start: first value; None where it is computed.
        text: what it is.
        derivative_of: name of the variable whose derivative it is; empty if none.
        type: "Real" or "Boolean".
    """

    name: str
    block: str
    causality: str
    variability: str = "continuous"
    initial: str = ""
    unit: str = ""
    start: float | None = None
    text: str = ""
    derivative_of: str = ""
    type: str = "Real"


_STOP = Variable(
    "stop_at_limits",
    "STOP",
    "parameter",
    "fixed",
    "exact",
    start=True,
    text="whether a motion ends at a limit",
    type="Boolean",
)


def variables_of(robot: Robot, program: str, with_loads: bool) -> list[Variable]:
    """All variables of a unit.

    Args:
        robot: the robot.
        program: "forward_dynamics" or "inverse_dynamics".
        with_loads: whether payload and friction are parameters.
    """
    axes = _Coordinates(robot)
    listed = [Variable("time", "TIME", "independent", unit="s", text="time")]
    listed += axes.parameters(with_loads)
    if program == FORWARD_DYNAMICS:
        return [*listed, *axes.forward_dynamics(limits_of(robot)), _STOP]
    return [*listed, *axes.inverse_dynamics()]


class _Coordinates:
    """Makes variables along the coordinates of a robot."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        names = identifiers(robot.coordinates)
        self._names: list[str] = []
        for name in robot.coordinates:
            text = names[name]
            self._names.append(f"_{text}" if text[0].isdigit() else text)
        self._n = len(robot.active)

    def parameters(self, with_loads: bool) -> Iterator[Variable]:
        """Gravity; payload and friction where they are no constants."""
        gravity = self._robot.loads.gravity
        for axis, value in zip(AXES, gravity, strict=True):
            text = f"gravity along {axis} of the base"
            yield _parameter(f"gravity.{axis}", "GRAVITY", "m/s2", float(value), text)
        if not with_loads:
            return
        parts = ["mass", *(f"com.{axis}" for axis in AXES)]
        parts += [f"inertia.{pair}" for pair in INERTIA]
        for part, unit in zip(parts, PAYLOAD_UNITS, strict=True):
            text = "payload at the end effector"
            yield _parameter(f"payload.{part}", "PAYLOAD", unit, 0.0, text)
        effects = self._robot.loads.effects
        yield from self._friction("viscous", effects.viscous)
        yield from self._friction("coulomb", effects.coulomb)

    def _friction(self, kind: str, values: Array) -> Iterator[Variable]:
        for k, value in enumerate(values):
            unit = self._effort_unit(k)
            if kind == "viscous":
                unit = {"N.m": "N.m.s/rad", "N": "N.s/m"}[unit]
            name = f"{kind}.{self._names[k]}"
            text = f"{kind} friction along {self._robot.coordinates[k]}"
            yield _parameter(name, kind.upper(), unit, float(value), text)

    def forward_dynamics(self, limits: Sequence[Limit]) -> Iterator[Variable]:
        """Efforts in, motion out."""
        for k in range(self._n):
            text = f"effort of the drive {self._robot.coordinates[k]}"
            name, unit = f"tau.{self._names[k]}", self._effort_unit(k)
            yield Variable(name, "TAU", "input", unit=unit, start=0.0, text=text)
        reference = self._robot.reference
        yield from self._states("u", "U", "", reference)
        yield from self._states("du", "DU", "/s", [0.0] * self._n)
        yield from self._slopes("u", "DER_U", "/s", "local", "der(u.{})")
        yield from self._slopes("du", "DDU", "/s2", "output", "ddu.{}")
        yield from self._passive("z", "Z", "", "coordinate")
        yield from self._passive("dz", "DZ", "/s", "rate of")
        yield from _pose()
        for limit in limits:
            side = "upper" if limit.is_upper else "lower"
            name = f"distance.{self._names[limit.index]}.{side}"
            text = f"from {self._robot.coordinates[limit.index]} to its {side} limit"
            unit = self._unit(limit.index, "")
            yield Variable(name, DISTANCE, "local", initial="calculated", unit=unit, text=text)

    def inverse_dynamics(self) -> Iterator[Variable]:
        """Motion in, efforts out."""
        reference = self._robot.reference
        yield from self._inputs("u", "U", "", reference)
        yield from self._inputs("du", "DU", "/s", [0.0] * self._n)
        yield from self._inputs("ddu", "DDU", "/s2", [0.0] * self._n)
        for k in range(self._n):
            text = f"effort of the drive {self._robot.coordinates[k]}"
            unit = self._effort_unit(k)
            yield _output(f"tau.{self._names[k]}", "TAU", unit, text)

    def _states(
        self, kind: str, block: str, rate: str, starts: Sequence[float] | Array
    ) -> Iterator[Variable]:
        for k in range(self._n):
            yield Variable(
                f"{kind}.{self._names[k]}",
                block,
                "output",
                initial="exact",
                unit=self._unit(k, rate),
                start=float(starts[k]),
                text=self._text(kind, k),
            )

    def _slopes(
        self, kind: str, block: str, rate: str, causality: str, pattern: str
    ) -> Iterator[Variable]:
        for k in range(self._n):
            name = self._names[k]
            yield Variable(
                pattern.format(name),
                block,
                causality,
                initial="calculated",
                unit=self._unit(k, rate),
                text=f"derivative of {kind}.{name}",
                derivative_of=f"{kind}.{name}",
            )

    def _inputs(
        self, kind: str, block: str, rate: str, starts: Sequence[float] | Array
    ) -> Iterator[Variable]:
        for k in range(self._n):
            yield Variable(
                f"{kind}.{self._names[k]}",
                block,
                "input",
                unit=self._unit(k, rate),
                start=float(starts[k]),
                text=self._text(kind, k),
            )

    def _passive(self, kind: str, block: str, rate: str, text: str) -> Iterator[Variable]:
        for k in range(self._n, len(self._names)):
            name = f"{kind}.{self._names[k]}"
            meaning = f"passive: {text} {self._robot.coordinates[k]}"
            yield _output(name, block, self._unit(k, rate), meaning)

    def _text(self, kind: str, k: int) -> str:
        words = {"u": "coordinate", "du": "rate of", "ddu": "acceleration of"}
        return f"{words[kind]} {self._robot.coordinates[k]}"

    def _unit(self, k: int, rate: str) -> str:
        return coordinate_unit(self._type(k), rate)

    def _effort_unit(self, k: int) -> str:
        return effort_unit(self._type(k)).replace(" ", ".")

    def _type(self, k: int) -> str:
        return self._robot.joint_types[self._robot.coordinates[k]]


def _parameter(name: str, block: str, unit: str, start: float, text: str) -> Variable:
    return Variable(name, block, "parameter", "fixed", "exact", unit, start, text)


def _output(name: str, block: str, unit: str, text: str) -> Variable:
    return Variable(name, block, "output", initial="calculated", unit=unit, text=text)


def _pose() -> Iterator[Variable]:
    for axis in AXES:
        text = f"{axis} of the end effector, in base axes"
        yield _output(f"position.{axis}", "POSITION", "m", text)
    for row in range(1, 4):
        for column in range(1, 4):
            text = "rotation of the end effector, in base axes"
            yield _output(f"rotation[{row},{column}]", "ROTATION", "", text)
