"""Steps of an explicit Runge-Kutta method, with error control and dense output, in machine code.

The state is y = (u, u', work), and the program gives u'', the power, the closed configuration s and
R there, row by row. Each stage starts from the guess s + R (u - u_0) of the last accepted state.
Nothing depends on time. The numbers of the method come in a tableau (`Tableau`).

Error control is that of Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I
(1993), Section II.10, as SciPy's DOP853 has it. A stage without an answer counts as a large error.
"""

from __future__ import annotations

from enum import IntEnum

from ..status import GOOD, NO_STEP
from ..trace import Trace
from .entry import Entry, Header
from .states import sizes
from .text import Function, Lanes, constant

# inputs of the program that the steps set
U, DU, GUESS = 0, 1, 4
STAGES = 16  # the last three are for dense output
LAST = 12  # the stage at the end of the step
ERRORS = 13  # stages that the estimates of the error read
DEGREES = 7  # rows of dense output
_DENSE = 4  # of them, those of the tableau
_SAFETY, _LEAST_FACTOR, _LARGEST_FACTOR = 0.9, 0.2, 10.0
_TRIALS = 1000  # a step is shortened by at least a tenth each time
_SPACING = 10 * 2.0**-52  # shortest step, as a share of the time
_TINY = 1e-300
_UNKNOWN = 1e30  # error of a step with a stage without an answer


class Tableau(IntEnum):
    """Where the numbers of the method begin: coefficients, two estimates, dense output."""

    COEFFICIENTS = 0  # (STAGES, STAGES)
    FIFTH = STAGES * STAGES  # (ERRORS,)
    THIRD = FIFTH + ERRORS  # (ERRORS,)
    DENSE = THIRD + ERRORS  # (4, STAGES)
    SIZE = DENSE + _DENSE * STAGES


class Control(IntEnum):
    """Numbers that the caller sets, and that the steps change."""

    TIME = 0  # [s], changed
    END = 1  # [s]
    STEP = 2  # the next step [s], changed
    LONGEST = 3  # the longest step [s]
    RELATIVE = 4  # tolerance
    ABSOLUTE = 5  # tolerance
    LARGEST_MOVE = 6  # of an angle in a step, by its rate at the start [rad]
    COUNT = 7  # steps done, set
    EVALUATIONS = 8  # set
    SIZE = 9


class _Sizes:
    """Lengths of the vectors of a trace."""

    def __init__(self, trace: Trace) -> None:
        self.active = trace.inputs[U]
        self.all = trace.inputs[GUESS]
        self.map = self.all * self.active
        self.y = 2 * self.active + 1
        fixed = [k for k in range(len(trace.inputs)) if k not in (U, DU, GUESS)]
        self.fixed = {k: trace.inputs[k] for k in fixed}


def steps_entry(trace: Trace, header: Header) -> str:
    """`call(control, tableau, angles, y, s, R, *fixed, times, Y, dense, S, maps)`.

    `fixed` are the other inputs of the program. The last five have a row for each step. The result
    is 0, or the status of a state without an answer; `Control.COUNT` steps are done.
    """
    of = _Sizes(trace)
    entry = Entry.counted("call", 6 + len(of.fixed) + 5, header)
    f = entry.f
    arguments = []
    given = [Control.SIZE, Tableau.SIZE, of.all, of.y, of.all, of.map, *of.fixed.values()]
    for number, size in enumerate(given):
        arguments.append(entry.array(number, [int(size)], writable=number == 0))
    first = len(given)
    (rows,) = entry.lengths(first, 1)
    shapes: list[list[str | int]] = [[rows], [rows, of.y], [rows, DEGREES, of.y]]
    shapes += [[rows, of.all], [rows, of.map]]
    for number, shape in enumerate(shapes, first):
        arguments.append(entry.array(number, shape, writable=True))
    pointers = ", ".join(f"ptr {pointer}" for pointer in arguments)
    thread = f.let("call ptr @PyEval_SaveThread()")
    status = f.let(f"call i64 @steps(i64 {rows}, {pointers})")
    f.do(f"call void @PyEval_RestoreThread(ptr {thread})")
    return entry.finish(status)


def slope_function(trace: Trace) -> str:
    """`@slope(y, dy, u0, s, R, s_out, R_out, *fixed)`: y' at y, and the status."""
    of = _Sizes(trace)
    if [shape for _, shape in trace.layout] and sizes(trace) != [of.active, 1, of.all, of.map]:
        raise ValueError(f"a program of {trace.layout} gives no motion")
    names = ["y", "dy", "u0", "s", "map", "s_out", "map_out", *[f"a{k}" for k in of.fixed]]
    f = Function(f"define internal i64 @slope({', '.join(f'ptr %{name}' for name in names)})")
    guess = f.slot("double", of.all)
    with f.loop(0, of.all) as i:
        total = f.slot("double")
        f.store(f.load("%s", i), total)
        row = f.row("%map", i, of.active)
        with f.loop(0, of.active) as j:
            move = f.let(f"fsub double {f.load('%y', j)}, {f.load('%u0', j)}")
            _add_product(f, total, f.load(row, j), move)
        f.store(f.load(total), guess, i)
    with f.loop(0, of.active) as j:
        f.store(f.load("%y", of.active, j), "%dy", j)
    inputs = {U: "%y", DU: f.at("%y", of.active), GUESS: guess}
    inputs |= {k: f"%a{k}" for k in of.fixed}
    outs = [f.at("%dy", of.active), f.at("%dy", 2 * of.active), "%s_out", "%map_out"]
    pointers = [inputs[k] for k in range(len(trace.inputs))] + outs
    arguments = ", ".join(f"ptr {pointer}" for pointer in pointers)
    f.do(f"ret i64 {f.let(f'call i64 @one({arguments})')}")
    return f.text()


def _add_product(f: Function, total: str, a: str, b: str) -> None:
    """Add a product to a slot."""
    before = f.load(total)
    f.store(f.let(f"call double @llvm.fmuladd.f64(double {a}, double {b}, double {before})"), total)


class StepsFunction:
    """Writer of `@steps(rows, ...)`, see `steps_entry`."""

    def __init__(self, trace: Trace) -> None:
        self.of = of = _Sizes(trace)
        names = ["control", "tableau", "angles", "start", "s0", "map0"]
        names += [f"a{k}" for k in of.fixed] + ["times", "Y", "dense", "S", "maps"]
        parameters = ", ".join(["i64 %rows", *[f"ptr %{name}" for name in names]])
        self.f = f = Function(f"define internal i64 @steps({parameters}) noinline")
        self.lanes = Lanes(f, 1)
        self.y = f.slot("double", of.y)
        self.u0 = f.slot("double", of.active)
        self.s = f.slot("double", of.all)
        self.map = f.slot("double", of.map)
        self.slopes = f.slot("double", STAGES * of.y)
        self.stage = f.slot("double", of.y)
        self.spare_s = f.slot("double", of.all)
        self.spare_map = f.slot("double", of.map)
        self.status = f.slot("i64")
        self.end = f.slot("double", of.y)
        self.good = f.slot("i1")
        self.going = f.slot("i1")
        self.trying = f.slot("i1")
        self.error = f.slot("double")
        self.factor_limit = f.slot("double")
        self.length = f.slot("double")
        self.next_length = f.slot("double")
        self.next_time = f.slot("double")

    def text(self) -> str:
        """The text of the function."""
        f, of = self.f, self.of
        self._copy("%start", self.y, of.y)
        self._copy("%start", self.u0, of.active)
        self._copy("%s0", self.s, of.all)
        self._copy("%map0", self.map, of.map)
        for counter in (Control.COUNT, Control.EVALUATIONS):
            f.store(constant(0.0), "%control", counter)
        f.store(GOOD, self.status, kind="i64")
        self._evaluate(self.y, self.slopes, self.spare_s, self.spare_map)
        self._set(self.going, self._is_good())
        with f.loop(0, "%rows", while_=self.going) as row:
            self._find_step(row)
            with f.when(self._is_good()):
                self._dense_stages()
            self._set(self.going, self._is_good())
            with f.when(self._is_good()):
                self._accept(row)
        f.do(f"ret i64 {f.load(self.status, kind='i64')}")
        return f.text()

    # -- a step

    def _find_step(self, row: str) -> None:
        """Shorten the step until its error is small enough; status of the last trial."""
        f, of, lanes = self.f, self.of, self.lanes
        time = f.load("%control", Control.TIME)
        least = lanes.arithmetic("fmul", f.absolute(time), constant(_SPACING))
        least = lanes.arithmetic("fadd", least, constant(_TINY))
        longest = self._longest()
        step = self._smaller(f.load("%control", Control.STEP), longest)
        f.store(lanes.larger(step, least), self.next_length)
        f.store(constant(_LARGEST_FACTOR), self.factor_limit)
        self._set(self.trying, "true")
        s, velocity_map = f.row("%S", row, of.all), f.row("%maps", row, of.map)
        with f.loop(0, _TRIALS, while_=self.trying):
            f.store(GOOD, self.status, kind="i64")
            self._set_length(time)
            self._set(self.good, "true")
            with f.loop(1, LAST + 1, while_=self.good) as number:
                self._combine(number)
                self._evaluate(self.stage, f.row(self.slopes, number, of.y), s, velocity_map)
                self._set(self.good, self._is_good())
            f.store(constant(_UNKNOWN), self.error)
            with f.when(self._is_good()):
                self._estimate()
            self._judge(least)

    def _longest(self) -> str:
        """The longest step: no angle may turn by more than a bound, by its rate at the start."""
        f, of, lanes = self.f, self.of, self.lanes
        fastest = f.slot("double")
        f.store(constant(_TINY), fastest)
        with f.loop(0, of.all) as i:
            rate = f.slot("double")
            f.store(constant(0.0), rate)
            row = f.row(self.map, i, of.active)
            with f.loop(0, of.active) as j:
                _add_product(f, rate, f.load(row, j), f.load(self.slopes, j))
            size = f.absolute(lanes.arithmetic("fmul", f.load(rate), f.load("%angles", i)))
            f.store(lanes.larger(size, f.load(fastest)), fastest)
        move = f.load("%control", Control.LARGEST_MOVE)
        by_rate = lanes.arithmetic("fdiv", move, f.load(fastest))
        return self._smaller(by_rate, f.load("%control", Control.LONGEST))

    def _set_length(self, time: str) -> None:
        """Step and its end, at most the end of the span."""
        f, lanes = self.f, self.lanes
        length = f.load(self.next_length)
        until = lanes.arithmetic("fadd", time, length)
        end = f.load("%control", Control.END)
        until = self._smaller(until, end)
        f.store(until, self.next_time)
        f.store(lanes.arithmetic("fsub", until, time), self.length)

    def _combine(self, number: str) -> None:
        """The state of a stage: y + h times the combination of earlier slopes."""
        f, of = self.f, self.of
        row = f.row(f.at("%tableau", int(Tableau.COEFFICIENTS)), number, STAGES)
        with f.loop(0, of.y) as k:
            total = self._dot(row, k, number)
            moved = f.slot("double")
            f.store(f.load(self.y, k), moved)
            _add_product(f, moved, f.load(self.length), total)
            f.store(f.load(moved), self.stage, k)

    def _dot(self, row: str, k: str, count: str | int) -> str:
        """Sum over stages of a row of numbers times component k of their slopes."""
        f = self.f
        total = f.slot("double")
        f.store(constant(0.0), total)
        with f.loop(0, count) as j:
            slope = f.load(f.row(self.slopes, j, self.of.y), k)
            _add_product(f, total, f.load(row, j), slope)
        return f.load(total)

    def _estimate(self) -> None:
        """The error of a step, in units of its tolerance."""
        f, of, lanes = self.f, self.of, self.lanes
        fifth, third = f.slot("double"), f.slot("double")
        f.store(constant(0.0), fifth)
        f.store(constant(0.0), third)
        with f.loop(0, of.y) as k:
            size = lanes.larger(f.absolute(f.load(self.y, k)), f.absolute(f.load(self.stage, k)))
            scale = f.slot("double")
            f.store(f.load("%control", Control.ABSOLUTE), scale)
            _add_product(f, scale, size, f.load("%control", Control.RELATIVE))
            for total, place in ((fifth, Tableau.FIFTH), (third, Tableau.THIRD)):
                error = self._dot(f.at("%tableau", int(place)), k, ERRORS)
                share = f.let(f"fdiv double {error}, {f.load(scale)}")
                _add_product(f, total, share, share)
        both = f.slot("double")
        f.store(f.load(fifth), both)
        _add_product(f, both, constant(0.01), f.load(third))
        spread = lanes.arithmetic("fmul", f.load(both), constant(float(of.y)))
        spread = lanes.arithmetic("fadd", spread, constant(_TINY))
        root = lanes.intrinsic("sqrt", spread)
        share = f.let(f"fdiv double {f.load(fifth)}, {root}")
        f.store(f.let(f"fmul double {f.load(self.length)}, {share}"), self.error)

    def _judge(self, least: str) -> None:
        """Accept the trial, or try a shorter step; without one the status stays that of failure."""
        f, lanes = self.f, self.lanes
        error = lanes.larger(constant(_TINY), f.load(self.error))  # NaN stays
        root = error
        for _ in range(3):
            root = lanes.intrinsic("sqrt", root)
        factor = f.let(f"fdiv double {constant(_SAFETY)}, {root}")
        is_small = lanes.compare("olt", error, constant(1.0))
        largest = self._smaller(factor, f.load(self.factor_limit))
        smallest = lanes.larger(factor, constant(_LEAST_FACTOR))
        factor = lanes.choose(is_small, "double", largest, smallest)
        length = f.let(f"fmul double {f.load(self.length)}, {factor}")
        f.store(length, self.next_length)
        f.store(constant(1.0), self.factor_limit)
        can_try = lanes.compare("oge", length, least)
        is_large = f.let(f"xor i1 {is_small}, true")
        self._set(self.trying, f.let(f"and i1 {is_large}, {can_try}"))
        is_lost = f.let(f"and i1 {is_large}, {f.let(f'xor i1 {can_try}, true')}")
        with f.when(is_lost):
            f.store(NO_STEP, self.status, kind="i64")

    def _dense_stages(self) -> None:
        """Further stages for dense output, after the end of the step was put by."""
        f, of = self.f, self.of
        self._copy(self.stage, self.end, of.y)
        self._set(self.good, "true")
        with f.loop(LAST + 1, STAGES, while_=self.good) as number:
            self._combine(number)
            slope = f.row(self.slopes, number, of.y)
            self._evaluate(self.stage, slope, self.spare_s, self.spare_map)
            self._set(self.good, self._is_good())

    def _accept(self, row: str) -> None:
        """Write the step to its row, and go on from its end."""
        f, of = self.f, self.of
        f.store(f.load(self.next_time), "%times", row)
        self._copy(self.end, f.row("%Y", row, of.y), of.y)
        self._write_dense(f.row("%dense", row, DEGREES * of.y))
        self._copy(self.end, self.y, of.y)
        self._copy(self.end, self.u0, of.active)
        self._copy(f.row("%S", row, of.all), self.s, of.all)
        self._copy(f.row("%maps", row, of.map), self.map, of.map)
        self._copy(f.row(self.slopes, str(LAST), of.y), self.slopes, of.y)
        f.store(f.load(self.next_time), "%control", Control.TIME)
        f.store(f.load(self.next_length), "%control", Control.STEP)
        self._count(Control.COUNT)
        time, end = f.load(self.next_time), f.load("%control", Control.END)
        self._set(self.going, self.lanes.compare("olt", time, end))

    def _write_dense(self, target: str) -> None:
        """Rows of dense output, Hairer et al. (1993), Section II.6."""
        f, of, lanes = self.f, self.of, self.lanes
        h = f.load(self.length)
        with f.loop(0, of.y) as k:
            change = lanes.arithmetic("fsub", f.load(self.end, k), f.load(self.y, k))
            first = lanes.arithmetic("fmul", h, f.load(self.slopes, k))
            last = lanes.arithmetic("fmul", h, f.load(self.slopes, LAST * of.y, k))
            second = f.let(f"fsub double {first}, {change}")
            both = f.let(f"fadd double {first}, {last}")
            twice = f.let(f"fmul double {change}, {constant(2.0)}")
            rows = [change, second, f.let(f"fsub double {twice}, {both}")]
            for degree in range(_DENSE):
                numbers = f.at("%tableau", int(Tableau.DENSE) + degree * STAGES)
                rows.append(f.let(f"fmul double {h}, {self._dot(numbers, k, STAGES)}"))
            for degree, value in enumerate(rows):
                f.store(value, target, degree * of.y, k)

    # -- parts

    def _evaluate(self, y: str, slope: str, s: str, velocity_map: str) -> None:
        """The slope at y; sets the status."""
        f = self.f
        pointers = [y, slope, self.u0, self.s, self.map, s, velocity_map]
        pointers += [f"%a{k}" for k in self.of.fixed]
        arguments = ", ".join(f"ptr {pointer}" for pointer in pointers)
        f.store(f.let(f"call i64 @slope({arguments})"), self.status, kind="i64")
        self._count(Control.EVALUATIONS)

    def _count(self, counter: Control) -> None:
        f = self.f
        total = f.let(f"fadd double {f.load('%control', counter)}, {constant(1.0)}")
        f.store(total, "%control", counter)

    def _is_good(self) -> str:
        f = self.f
        return f.let(f"icmp eq i64 {f.load(self.status, kind='i64')}, {GOOD}")

    def _set(self, flag: str, value: str) -> None:
        self.f.store(value, flag, kind="i1", align=1)

    def _smaller(self, a: str, b: str) -> str:
        lanes = self.lanes
        return lanes.choose(lanes.compare("olt", a, b), "double", a, b)

    def _copy(self, source: str, target: str, count: int) -> None:
        f = self.f
        with f.loop(0, count) as k:
            f.store(f.load(source, k), target, k)
