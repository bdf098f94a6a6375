"""Traces of the C functions, with the robot's numbers in them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from ...algebra.scalar import Scalar, Scalars
from ...algebra.vector import Rotation, Vector, add, dot, matmul, matvec, scale, transpose
from ...dynamics.load_pattern import INERTIAL, LoadPattern
from ...dynamics.loads import Loads, described_loads
from ...dynamics.pack_loads import pack_loads
from ...dynamics.pins import Pin, find_pins
from ...errors import InputError
from ...ground.lazy import lazy
from ...kernels.graph import Graph
from ...kernels.trace import Results, Trace, trace, trace_of
from ...mechanism.tree import frame_offset
from ...programs import Inputs, Program
from ...programs.closure import closed_motion
from ...programs.outcome import with_kinds
from ...programs.warm_start import next_start
from ...robot.model import RobotModel
from ...robot.robot import Robot
from .calls import FRICTION, GUESS, PINS, CFunction, Setting
from .emit import Split, split_at
from .real import PRECISIONS, Precision, Real, loosened

PAYLOAD = 10  # m, centre of mass (3), Ixx, Ixy, Ixz, Iyy, Iyz, Izz about it, all in the frame


@dataclass(frozen=True)
class TracedFunction:
    """A C function with its trace: `results` of the program, then the configuration s.

    Attributes:
        call: the function.
        inputs: its vectors before the guess.
        trace: its operations. Inputs: those of the call, then the guess (n_s,), or a closed
            configuration (n_s,) and R there (n_s * n,).
        results: names in C and numbers of values of the results that are not empty, in order.
        vectors: names of the inputs of the trace.
        loops: indices of the joints in the loop of each pin, of reactions.
        lists: names of what the results belong to, by its kind.
        is_shared: whether its trace has the graph of other functions.
    """

    call: CFunction
    inputs: tuple[str, ...]
    trace: Trace
    results: dict[str, int]
    vectors: tuple[str, ...]
    loops: Sequence[Sequence[int]] = ()
    lists: Mapping[str, Sequence[str]] = field(default_factory=dict)
    is_shared: bool = False

    @property
    def total(self) -> int:
        """Number of values of all results."""
        return sum(self.results.values())

    @lazy
    def split(self) -> Split | None:
        """What is left out where the guess is NULL; None where it has to be there."""
        if self.is_shared or GUESS not in self.vectors:
            return None
        return split_at(self.trace, self.vectors.index(GUESS), self.total)


class Tracer:
    """Traces calls of a robot.

    Its assembly mode is compiled in, and so are its loads, but for those that are arguments.

    Attributes:
        follows: whether loops without a closed form are followed from the guess.
        size: number of coordinates n_s.
    """

    def __init__(self, robot: Robot, *, with_loads: bool = False, real: Real = "double") -> None:
        """Pack the loads of a description.

        Args:
            robot: the robot.
            with_loads: whether payload and friction are arguments.
            real: precision of the code.

        Raises:
            InputError: there is no link for a payload.
        """
        model = RobotModel.from_description(robot.description)
        loads = described_loads(model.description, model.coordinates)
        self._robot_model = model
        self._model = replace(model.program_model, singular=PRECISIONS[real].singular)
        self._frame = model.frame(None)
        pattern, values = pack_loads(loads, model.tree, model.frame, None)
        self._pattern = pattern.under_any_gravity()  # an argument of the functions
        self._constants: dict[str, Scalars] = {"branch": model.plan.signs}
        for name, array in values.items():
            self._constants[name] = array.tolist()
        self._with_loads = with_loads
        self._real = real
        if with_loads:
            self._open_loads(loads)
        self.follows = model.follows
        self.size = len(model.coordinates)

    def _open_loads(self, loads: Loads) -> None:
        """Extend the pattern by a payload at the end effector and friction, as arguments."""
        body = self._model.tree.body_index(self._frame.link)
        if body < 0:
            name = self._robot_model.name
            raise InputError(
                f"{name}: the end effector is fixed to the base, so a payload there is no argument"
            )
        self._carrier = body
        described = {}
        for n, index in enumerate(self._pattern.payloads):
            values = self._constants["payloads"]
            described[index] = list(values[INERTIAL * n : INERTIAL * (n + 1)])
        described.setdefault(body, [0.0] * INERTIAL)
        bodies = tuple(sorted(described))
        self._described = [described[index] for index in bodies]
        self._pattern = replace(self._pattern, payloads=bodies, friction=True)
        self._constants["smoothing"] = loads.effects.smoothing.tolist()

    @property
    def precision(self) -> Precision:
        """Precision of the code."""
        return PRECISIONS[self._real]

    @property
    def pins(self) -> tuple[str, ...]:
        """Names of the pins, in the order of `reactions`."""
        return tuple(pin.name for pin in self._pins())

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints, in the order of `reactions`."""
        return tuple(body.joint for body in self._model.tree.bodies)

    def trace(self, call: CFunction) -> TracedFunction:
        """The trace of a call."""
        program, names = self._program(call), self._vectors(call)

        def run(*vectors: Scalars) -> Results:
            return self._run(call, program, dict(zip(names, vectors, strict=True)))

        sizes = [self._size(program, name) for name in names]
        return self._traced(call, self._checked(trace(run, sizes, call.name)), names)

    def trace_together(self, calls: Sequence[CFunction]) -> list[TracedFunction]:
        """The traces of calls in one graph, with the inputs of all of them."""
        graph = Graph()
        sizes: dict[str, int] = {}
        for call in calls:
            for name in self._vectors(call):
                sizes[name] = self._size(self._program(call), name)
        symbols: dict[str, Scalars] = {}
        for number, (name, size) in enumerate(sizes.items()):
            symbols[name] = [graph.input(number, k) for k in range(size)]
        traced = []
        for call in calls:
            given = {name: symbols[name] for name in self._vectors(call)}
            results = self._run(call, self._program(call), given)
            one = trace_of(graph, results, [*sizes.values()], call.name)
            function = self._traced(call, self._checked(one), tuple(sizes))
            traced.append(replace(function, is_shared=True))
        return traced

    def _program(self, call: CFunction) -> Program:
        setting = Setting(self._robot_model, self._pattern_of(call), self._frame)
        program = call.program(setting)
        if self.follows:
            return program.from_start()
        return program

    def _vectors(self, call: CFunction) -> tuple[str, ...]:
        """Names of the inputs of a call's program."""
        last = ("start", "start_map") if self.follows else (GUESS,)
        return (*call.inputs, *self._loads(call), *last)

    def _loads(self, call: CFunction) -> tuple[str, ...]:
        return call.loads if self._with_loads else ()

    def _run(self, call: CFunction, program: Program, vectors: dict[str, Scalars]) -> Results:
        """The results of a call, then the configuration."""
        x = self._inputs(program, vectors)
        results = program.run(self._model, x)
        motion, _, _ = closed_motion(self._model, x)
        outputs = {name: results.outputs[name] for name in call.results}
        outputs["configuration"] = motion.configuration.q
        return Results(outputs, results.checks)

    def _traced(self, call: CFunction, traced: Trace, vectors: tuple[str, ...]) -> TracedFunction:
        results: dict[str, int] = {}
        # the layout ends with the configuration, which is no result
        for name, (_, shape) in zip(call.results.values(), traced.layout, strict=False):
            count = math.prod(shape)
            if count:
                results[name] = count
        inputs = (*call.inputs, *self._loads(call))
        if PINS[0] not in call.results:
            listed = self._cylinders(call)
            return TracedFunction(call, inputs, traced, results, vectors, lists=listed)
        lists = {"pin": self.pins, "joint": self.joints}
        lists = {kind: listed for kind, listed in lists.items() if listed}
        return TracedFunction(call, inputs, traced, results, vectors, self._loops(), lists)

    def _cylinders(self, call: CFunction) -> dict[str, tuple[str, ...]]:
        """The names of the cylinders, of the call on them."""
        if "cap_pressure" not in call.results:
            return {}
        return {"cylinder": tuple(self._robot_model.description.actuators)}

    def trace_start(self) -> Trace:
        """The trace of what a followed call starts from: s and R of the guess, closed."""

        def run(guess: Scalars) -> Results:
            u = [guess[k] for k in self._model.plan.given]
            inputs = Inputs(u=u, guess=guess, branch=self._constants["branch"])
            return next_start(self._model, inputs)

        return self._checked(trace(run, [self.size], "start"))

    def _checked(self, traced: Trace) -> Trace:
        """The trace with kinds of outcome as codes, and with thresholds of its precision."""
        if self._real == "float":
            blocks = len(self._robot_model.plan.blocks)
            checks = [loosened(check, blocks) for check in traced.checks]
            traced = replace(traced, checks=tuple(checks))
        return with_kinds(traced)

    def _pattern_of(self, call: CFunction) -> LoadPattern:
        """The pattern for a call; friction without effect on it is no argument."""
        if self._with_loads and "viscous" not in call.loads:
            return replace(self._pattern, friction=False)
        return self._pattern

    def _size(self, program: Program, name: str) -> int:
        if name == "payload":
            return PAYLOAD
        if name in FRICTION:
            return self.size
        return program.size(self._model, name)

    def _inputs(self, program: Program, vectors: dict[str, Scalars]) -> Inputs:
        """Inputs of a program: those that it takes, the others from constants."""
        named = {**self._constants, **vectors}
        if "payload" in vectors:
            named["payloads"] = self._with_payload(vectors["payload"])
        given = {name: named[name] for name in program.inputs if name in named}
        return Inputs(**given)

    def _with_payload(self, payload: Scalars) -> list[Scalar]:
        """The parameters of all payloads, with an argument added at the end effector."""
        added = _about_origin(payload, *frame_offset(self._frame))
        flat: list[Scalar] = []
        for body, described in zip(self._pattern.payloads, self._described, strict=True):
            extra: Scalars = [0.0] * INERTIAL
            if body == self._carrier:
                extra = added
            flat += add(described, extra)
        return flat

    def _pins(self) -> list[Pin]:
        model = self._robot_model
        return find_pins(model.tree, model.plan, model.description.closures)

    def _loops(self) -> list[list[int]]:
        """Indices of the joints between the links of each pin."""
        loops = []
        for pin in self._pins():
            side_a, side_b, _ = self._model.tree.branches(pin.body_a, pin.body_b)
            loops.append([*side_a, *side_b])
        return loops


def _about_origin(payload: Scalars, rotation: Rotation, offset: Vector) -> list[Scalar]:
    """The ten parameters of a payload about the origin of its link, as `inertial_vector`.

    Args:
        payload: mass, centre of mass (3,) and inertia about it (6,), in its frame.
        rotation: of the frame, in its link.
        offset: origin of the frame, in its link (3,).
    """
    mass, x, y, z, xx, xy, xz, yy, yz, zz = payload
    place = add(offset, matvec(rotation, (x, y, z)))
    inertia = ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
    turned = matmul(matmul(rotation, inertia), transpose(rotation))
    square = dot(place, place)
    components: list[Scalar] = []
    for i in range(3):
        for j in range(i, 3):
            steiner = -place[i] * place[j]
            if i == j:
                steiner = steiner + square
            components.append(turned[i][j] + mass * steiner)
    return [mass, *scale(mass, place), *components]
