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
from ...kernels.differentiate import jacobian
from ...kernels.trace import Results, Trace, flatten, trace
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


class CallTracer:
    """Traces calls of a robot under loads.

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
        pattern, values = dynamics.pack(loads)
        self._pattern = pattern.under_any_gravity()  # an argument of the calls
        self._constants: dict[str, Scalars] = {"branch": signs.tolist()}
        for name, array in values.items():
            self._constants[name] = array.tolist()
        self._frame = closure.model.frame(frame)
        self._follows = closure.is_followed

    def start_names(self) -> tuple[str, ...]:
        """Names of the inputs for the start of a call; they come after the call's inputs."""
        return ("start", "start_map") if self._follows else ("guess",)

    def values(self, call: Call) -> Trace:
        """The results of a call, and its checks."""

        def run(named: Mapping[str, Scalars]) -> Results:
            results = self._run(call.program, named)
            outputs = {name: results.outputs[name] for name in call.results}
            return Results(outputs, results.checks)

        return self._trace(call, run, call.name)

    def slopes(self, call: Call, by: Sequence[str]) -> Trace:
        """Derivatives (flat results, size of an input) by some inputs, one matrix after another.

        Those that the call has no program for are differentiated from its trace.

        Args:
            call: the call.
            by: names of the inputs, in order.
        """

        def run(named: Mapping[str, Scalars]) -> Results:
            outputs: dict[str, Any] = {}
            ready = [name for name in by if name in call.slopes]
            if ready and call.derivatives is not None:
                results = self._run(call.derivatives, named)
                for name in ready:
                    outputs[name] = results.outputs[call.slopes[name]]
            others = [name for name in by if name not in outputs]
            if others:
                results = self._run(call.program, named)
                flat = flatten([results.outputs[name] for name in call.results])
                for name in others:
                    outputs[name] = jacobian(flat, list(named[name]))
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

    def _run(self, of_robot: OfRobot, named: Mapping[str, Scalars]) -> Results:
        """The results of a program, with varied inputs by name."""
        program = of_robot(self._pattern, self._frame)
        if self._follows:
            program = program.from_start()
        values = {**self._constants, **named}
        inputs = {name: values[name] for name in program.inputs}
        return program.run(self._model, Inputs(**inputs))
