"""The calls that frameworks have, and the traces of their values and exact derivatives."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from ... import programs
from ...algebra.scalar import Scalars
from ...description.model import Frame
from ...dynamics.load_pattern import LoadPattern
from ...dynamics.loads import Loads
from ...ground.arrays import Array
from ...kernels.run import Kernel
from ...kernels.trace import Results, Trace, trace
from ...programs import Inputs, Program
from ...programs.outcome import with_kinds
from ..closure import Closure
from ..dynamics import Dynamics

OfRobot = Callable[[LoadPattern, Frame], Program]


@dataclass(frozen=True)
class Call:
    """A call of a robot.

    Attributes:
        name: name of the call, as in `robot.kernels`.
        inputs: names of its vectors, in order.
        results: names of its results in the program, in order.
        program: the program for a pattern of loads and a frame.
        derivatives: the program of its derivatives, if there is one.
        slopes: name of the derivative in that program, by the input that is varied.
    """

    name: str
    inputs: tuple[str, ...]
    results: tuple[str, ...]
    program: OfRobot
    derivatives: OfRobot | None = None
    slopes: Mapping[str, str] = field(default_factory=dict)


CALLS = (
    Call("close", ("u", "du"), ("s", "ds"), lambda _pattern, _frame: programs.MOTION),
    Call(
        "forward_kinematics",
        ("u",),
        ("position", "rotation"),
        lambda _pattern, frame: programs.forward_kinematics(frame),
    ),
    Call("jacobian", ("u",), ("jacobian",), lambda _pattern, frame: programs.jacobian(frame)),
    Call(
        "inverse_dynamics",
        ("u", "du", "ddu", "gravity"),
        ("tau",),
        lambda pattern, _frame: programs.inverse_dynamics(pattern),
        lambda pattern, _frame: programs.inverse_dynamics_derivatives(pattern),
        {"u": "d_u", "du": "d_du", "ddu": "d_ddu"},
    ),
    Call(
        "minimal_form",
        ("u", "du", "gravity"),
        ("M", "h", "g"),
        lambda pattern, _frame: programs.minimal_form(pattern),
    ),
    Call(
        "forward_dynamics",
        ("u", "du", "tau", "gravity"),
        ("ddu",),
        lambda pattern, _frame: programs.forward_dynamics(pattern),
        lambda pattern, _frame: programs.forward_dynamics_derivatives(pattern),
        {"u": "d_u", "du": "d_du", "tau": "d_tau"},
    ),
)
# gives the start of the next call along a motion
STEP = Call("step", ("u",), ("start", "start_map"), lambda _pattern, _frame: programs.STEP)

CALL_BY_NAME = {call.name: call for call in (*CALLS, STEP)}


class CallTracer:
    """Programs of the calls of a robot under loads, and their traces.

    Attributes:
        constants: inputs of the programs that calls do not have, by name.

    Args:
        closure: closes its loops.
        dynamics: packs its loads.
        loads: the loads.
        frame: name of the frame of poses and Jacobians; the end effector if None.
        signs: branch signs and charts, constants of the traces.
    """

    def __init__(
        self,
        closure: Closure,
        dynamics: Dynamics,
        loads: Loads,
        frame: str | None,
        signs: Array,
    ) -> None:
        self._model = closure.model.program_model
        self._name = closure.model.name
        pattern, values = dynamics.pack(loads)
        self._pattern = pattern.under_any_gravity()  # an argument of the calls
        self.constants: dict[str, Array] = {"branch": signs, **values}
        self._scalars: dict[str, Scalars] = {}
        for name, array in self.constants.items():
            self._scalars[name] = array.tolist()
        self._frame = closure.model.frame(frame)
        self._follows = closure.is_followed

    def start_names(self) -> tuple[str, ...]:
        """Names of the inputs for the start of a call; they come after the call's inputs."""
        return ("start", "start_map") if self._follows else ("guess",)

    def kernel(self, program: Program, label: str) -> Kernel:
        """The compiled code of a program."""
        return program.kernel(self._model, f"{label} of {self._name}")

    def program(self, call: Call) -> Program:
        """The program of a call, for the inputs that a call has."""
        return self._started(call.program)

    def slope_programs(self, call: Call, by: Sequence[str]) -> list[tuple[Program, dict[str, str]]]:
        """Programs for derivatives (flat results, size of an input) by some inputs.

        Those that the call has no program for are differentiated from its own.

        Returns:
            Each program, with the name of the derivative by the name of an input.
        """
        parts = []
        ready = {name: call.slopes[name] for name in by if name in call.slopes}
        if ready and call.derivatives is not None:
            parts.append((self._started(call.derivatives), ready))
        others = {name: f"d_{name}" for name in by if name not in ready}
        if others:
            program = programs.slopes(self.program(call), call.results, tuple(others))
            parts.append((program, others))
        return parts

    def values(self, call: Call) -> Trace:
        """The trace of the results of a call, and of its checks."""

        def run(named: Mapping[str, Scalars]) -> Results:
            results = self._run(self.program(call), named)
            outputs = {name: results.outputs[name] for name in call.results}
            return Results(outputs, results.checks)

        return self._trace(call, run, call.name)

    def slopes(self, call: Call, by: Sequence[str]) -> Trace:
        """The trace of the derivatives of `slope_programs`, one matrix after another.

        Args:
            call: the call.
            by: names of the inputs, in order.
        """
        parts = self.slope_programs(call, by)

        def run(named: Mapping[str, Scalars]) -> Results:
            outputs: dict[str, Any] = {}
            for program, results in parts:
                matrices = self._run(program, named).outputs
                outputs |= {name: matrices[result] for name, result in results.items()}
            return Results({name: outputs[name] for name in by}, [])

        return self._trace(call, run, f"{call.name}_by_{'_'.join(by)}")

    def _trace(
        self, call: Call, run: Callable[[Mapping[str, Scalars]], Results], label: str
    ) -> Trace:
        """The trace of a function of named inputs, which are those of a call."""
        names = (*call.inputs, *self.start_names())
        sizes = [self._model.size(name) for name in names]

        def of_vectors(*vectors: Scalars) -> Results:
            return run(dict(zip(names, vectors, strict=True)))

        return with_kinds(trace(of_vectors, sizes, label))

    def _started(self, of_robot: OfRobot) -> Program:
        """A program under the loads; where loops are followed, from a start."""
        program = of_robot(self._pattern, self._frame)
        return program.from_start() if self._follows else program

    def _run(self, program: Program, named: Mapping[str, Scalars]) -> Results:
        """The results of a program, with varied inputs by name."""
        values = {**self._scalars, **named}
        inputs = {name: values[name] for name in program.inputs}
        return program.run(self._model, Inputs(**inputs))
