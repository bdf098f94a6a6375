"""The C functions of a robot: what they take and give, and the traces behind them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from ... import programs
from ...algebra.scalar import Scalar, Scalars
from ...description.model import Frame
from ...dynamics.load_pattern import LoadPattern
from ...dynamics.loads import Loads, described_loads
from ...dynamics.pack_loads import pack_loads
from ...errors import InputError
from ...ground.suggestions import no_such_name
from ...kernels.trace import Results, Trace, trace
from ...programs import Inputs, Outcome, Program
from ...programs.closure import closed_motion
from ...robot.model import RobotModel
from ...robot.robot import Robot

OfRobot = Callable[[LoadPattern, Frame], Program]
GUESS = "guess"


@dataclass(frozen=True)
class Call:
    """A C function.

    Attributes:
        name: after the robot's prefix.
        inputs: vectors before the guess, in order.
        results: names of its outputs in C, by their names in the program, in order.
        program: the program for a pattern of loads and a frame.
        text: what it computes.
    """

    name: str
    inputs: tuple[str, ...]
    results: Mapping[str, str]
    program: OfRobot
    text: str


CALLS = (
    Call(
        "close",
        ("u", "du"),
        {"s": "s", "ds": "ds"},
        lambda _pattern, _frame: programs.MOTION,
        "all coordinates s (NS) and their rates s' (NS)",
    ),
    Call(
        "inverse_dynamics",
        ("u", "du", "ddu", "gravity"),
        {"tau": "tau"},
        lambda pattern, _frame: programs.inverse_dynamics(pattern),
        "efforts of the drives tau (NU) for accelerations u''",
    ),
    Call(
        "forward_dynamics",
        ("u", "du", "tau", "gravity"),
        {"ddu": "ddu"},
        lambda pattern, _frame: programs.forward_dynamics(pattern),
        "accelerations u'' (NU) from efforts tau",
    ),
    Call(
        "minimal_form",
        ("u", "du", "gravity"),
        {"M": "M", "h": "h", "g": "g"},
        lambda pattern, _frame: programs.minimal_form(pattern),
        "M (NU, NU), h = C u' (NU) and g (NU) of M u'' + h + g = tau; friction, springs and"
        " wrenches are not in them",
    ),
    Call(
        "forward_kinematics",
        ("u",),
        {"position": "position", "rotation": "rotation"},
        lambda _pattern, frame: programs.forward_kinematics(frame),
        "position (3) and rotation (3, 3) of the end effector in base axes",
    ),
    Call(
        "jacobian",
        ("u",),
        {"jacobian": "J"},
        lambda _pattern, frame: programs.jacobian(frame),
        "J (6, NU): linear, then angular velocity of the end effector per unit rate",
    ),
)


def calls_of(names: Sequence[str] | None) -> list[Call]:
    """The calls of some names; all if None.

    Raises:
        InputError: there is no such program.
    """
    if names is None:
        return list(CALLS)
    by_name = {call.name: call for call in CALLS}
    for name in names:
        if name not in by_name:
            raise InputError(no_such_name("program", name, by_name))
    if not names:
        raise InputError(f"no program is named; expected some of {', '.join(by_name)}")
    return [by_name[name] for name in dict.fromkeys(names)]


@dataclass(frozen=True)
class TracedCall:
    """A C function with its trace: `results` of the program, then the configuration s.

    Attributes:
        call: the function.
        trace: its operations. Inputs: those of the call, then the guess (n_s,), or a closed
            configuration (n_s,) and R there (n_s * n,).
        sizes: numbers of values of the results, in order.
    """

    call: Call
    trace: Trace
    sizes: list[int]


class Tracer:
    """Traces calls of a robot, its loads and assembly mode compiled in.

    Attributes:
        follows: whether loops without a closed form are followed from the guess.
        size: number of coordinates n_s.
    """

    def __init__(self, robot: Robot, loads: Loads | None = None) -> None:
        model = RobotModel.from_description(robot.description)
        if loads is None:
            loads = described_loads(model.description, model.coordinates)
        self._model = model.program_model
        self._frame = model.frame(None)
        self._pattern, values = pack_loads(loads, model.tree, model.frame, None)
        self._constants: dict[str, Scalars] = {"branch": model.plan.signs}
        for name, array in values.items():
            self._constants[name] = array.tolist()
        self.follows = model.follows
        self.size = len(model.coordinates)

    def trace(self, call: Call) -> TracedCall:
        """The trace of a call."""
        program = call.program(self._pattern, self._frame)
        if self.follows:
            program = program.from_start()
        last = ("start", "start_map") if self.follows else (GUESS,)
        names = (*call.inputs, *last)

        def run(*vectors: Scalars) -> Results:
            x = self._inputs(program, dict(zip(names, vectors, strict=True)))
            results = program.run(self._model, x)
            motion, _, _ = closed_motion(self._model, x)
            outputs = {name: results.outputs[name] for name in call.results}
            outputs["configuration"] = motion.configuration.q
            return Results(outputs, results.checks)

        sizes = [program.size(self._model, name) for name in names]
        traced = _with_public_codes(trace(run, sizes, call.name))
        lengths = [_count(shape) for _, shape in traced.layout[:-1]]
        return TracedCall(call, traced, lengths)

    def trace_start(self) -> Trace:
        """The trace of what a followed call starts from: s and R of the guess, closed."""

        def run(guess: Scalars) -> Results:
            u = [guess[k] for k in self._model.plan.given]
            motion, checks, _ = closed_motion(
                self._model, Inputs(u=u, guess=guess, branch=self._constants["branch"])
            )
            start_map: list[Scalar] = []
            for row in motion.velocity_map():
                start_map += row
            return Results({"start": motion.configuration.q, "start_map": start_map}, checks)

        return _with_public_codes(trace(run, [self.size], "start"))

    def _inputs(self, program: Program, vectors: dict[str, Scalars]) -> Inputs:
        """Inputs of a program: those that it takes, the others from constants."""
        named = {**self._constants, **vectors}
        given = {name: named[name] for name in program.inputs if name in named}
        return Inputs(**given)


def _with_public_codes(traced: Trace) -> Trace:
    """The trace with kinds of outcome as codes of its checks."""
    checks = []
    for check in traced.checks:
        kind = Outcome.decode(check.code).kind
        checks.append(replace(check, code=int(kind)))
    return replace(traced, checks=tuple(checks))


def _count(shape: tuple[int, ...]) -> int:
    count = 1
    for length in shape:
        count *= length
    return count
