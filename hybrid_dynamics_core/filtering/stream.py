"""The filter of a stream of readings: late ones are put in their place, and the rest repeated."""

from __future__ import annotations

import bisect
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..closed_state.state import ClosedState
from ..errors import InputError
from ..estimation.sensors import SensorError
from ..ground.arrays import Array
from ..ground.check_arrays import finite_vectors
from ..ground.suggestions import no_such_name
from ..robot.robot import Robot
from .belief import Belief, Layout, predicted
from .gate import GATE, Innovation, updated
from .motion_model import MotionModel
from .observability import Observability, observability
from .raw_checks import check_values
from .sensors import Sensor
from .start import SEARCHES, Reading, first_belief

LATEST = 0.5  # [s] by which a reading may come late
PATIENCE = 1.0  # [s] that a start waits for the first reading of each sensor
LOST = 50  # readings in a row without one that passes its gate, after which the filter starts anew


class Estimate(NamedTuple):
    """The state of a machine at one time.

    Attributes:
        time: [s].
        state: closed state.
        ddu: (n,) active accelerations [rad/s^2, m/s^2].
        covariance: (3 n, 3 n) of [u; u'; u''].
    """

    time: float
    state: ClosedState
    ddu: Array
    covariance: Array


@dataclass
class Counts:
    """What became of readings.

    Attributes:
        used: number by sensor, with those of the first state.
        beyond_gate: number by sensor of those that the others contradict.
        duplicate: number by sensor of those with the stamp of an earlier one.
        late: number by sensor of those that came too late.
        early: number by sensor of those between its first one and the first state.
        starts: how often the filter started.
    """

    used: Counter[str] = field(default_factory=Counter)
    beyond_gate: Counter[str] = field(default_factory=Counter)
    duplicate: Counter[str] = field(default_factory=Counter)
    late: Counter[str] = field(default_factory=Counter)
    early: Counter[str] = field(default_factory=Counter)
    starts: int = 0


class _Step(NamedTuple):
    """A reading, and what was known after it."""

    key: tuple[float, int]
    reading: Reading
    belief: Belief
    innovation: Innovation | None


class StateFilter:
    """Error-state Kalman filter on the closed mechanism.

    The state has the active coordinates, rates and accelerations, and the constant errors of
    sensors. Loops close exactly at each step. Readings may come in any order of sensors.

    Attributes:
        layout: the sensors and the places of their errors.
        observability: what the sensors determine.
        counts: what became of the readings.
    """

    def __init__(
        self,
        robot: Robot,
        sensors: Sequence[Sensor],
        model: MotionModel,
        initial: ArrayLike | None = None,
        latest: float = LATEST,
        searches: int = SEARCHES,
    ) -> None:
        """A filter that has not started.

        Args:
            robot: the robot.
            sensors: its sensors.
            model: how it may move.
            initial: active coordinates (n,) near which it starts [rad, m]; None: it searches.
            latest: time by which readings may come late [s].
            searches: number of further places that a start searches from.

        Raises:
            ObservabilityError: the sensors do not determine the state.
            InputError: names of sensors repeat, or the start has a wrong shape.
        """
        self.layout = Layout(robot, sensors, model)
        self._initial = None
        if initial is not None:
            self._initial = finite_vectors("initial", initial, robot.active, -1)
        self.observability: Observability = observability(robot, sensors, model, self._initial)
        self.observability.require()
        self.counts = Counts()
        self._order = {name: k for k, name in enumerate(self.layout.sensors)}
        self._latest = latest
        self._searches = searches
        self._first: list[Reading] = []
        self._steps: list[_Step] = []
        self._rejected_in_row = 0

    @property
    def has_started(self) -> bool:
        """Whether there is an estimate."""
        return bool(self._steps)

    @property
    def estimate(self) -> Estimate:
        """The estimate after the newest reading.

        Raises:
            InputError: the filter has not started.
        """
        return self.estimate_at(self.belief.time)

    @property
    def belief(self) -> Belief:
        """The belief after the newest reading, with constant errors of sensors."""
        if not self._steps:
            raise InputError("the filter has no estimate yet: it needs a reading of each sensor")
        return self._steps[-1].belief

    @property
    def bias(self) -> dict[str, Array]:
        """Estimated constant errors (k,) by name of the sensor."""
        return self.layout.bias_by_name(self.belief.bias)

    def estimate_at(self, time: float) -> Estimate:
        """The estimate at a time [s] that is not before the newest reading."""
        belief = self.belief
        if time < belief.time:
            raise InputError(f"time {time:g} s is before the newest reading, {belief.time:g} s")
        at_time = predicted(self.layout, belief, time)
        size = self.layout.motion_size
        covariance = at_time.covariance[:size, :size].copy()
        return Estimate(time, at_time.state, at_time.ddu, covariance)

    def add(
        self,
        time: float,
        sensor: str,
        values: ArrayLike,
    ) -> tuple[Innovation, ...]:
        """Take a reading.

        Args:
            time: its stamp [s].
            sensor: name of the sensor.
            values: its readings (k,), or one number.

        Returns:
            What the readings showed that were computed: this one, and the later ones if it came
            late.

        Raises:
            InputError: there is no such sensor, a shape is wrong, or a value is not finite.
            SensorError: no state explains the first readings.
        """
        reading = self._checked(time, sensor, values)
        if not self._steps:
            self._first.append(reading)
            return self._start()
        key = (reading.time, self._order[sensor])
        if key <= self._steps[0].key:
            self.counts.late[sensor] += 1
            return ()
        place = bisect.bisect_left(self._steps, key, key=lambda step: step.key)
        if place < len(self._steps) and self._steps[place].key == key:
            self.counts.duplicate[sensor] += 1
            return ()
        later = [step.reading for step in self._steps[place:]]
        for step in self._steps[place:]:
            self._count(step.innovation, -1)
        del self._steps[place:]
        shown = [self._take(each) for each in (reading, *later)]
        self._forget()
        self._start_anew_if_lost(shown)
        return tuple(shown)

    def _checked(
        self,
        time: float,
        sensor: str,
        values: ArrayLike,
    ) -> Reading:
        if sensor not in self._order:
            raise InputError(no_such_name("sensor", sensor, tuple(self._order)))
        array = np.atleast_1d(np.asarray(values, dtype=np.float64))
        channels = self.layout.sensors[sensor].channels
        if array.shape != (channels,) or not np.isfinite(array).all():
            raise InputError(f"{sensor}: values are {values!r}; expected {channels} finite numbers")
        if not np.isfinite(time):
            raise InputError(f"{sensor}: the stamp is {time}; expected a finite time [s]")
        return Reading(float(time), sensor, array)

    # -- start

    def _start(self) -> tuple[Innovation, ...]:
        """Start, if each sensor has a reading or the wait is long enough."""
        stamps = [reading.time for reading in self._first]
        names = {reading.sensor for reading in self._first}
        waited = max(stamps) - min(stamps)
        is_complete = len(names) == len(self._order) and waited >= self._latest / 2.0
        if not is_complete and waited < PATIENCE:
            return ()
        readings = sorted(self._first, key=self._key)
        self._require_enough(names)
        self._first = []
        for name in sorted(names):
            values = [reading.values for reading in readings if reading.sensor == name]
            check_values(self.layout.sensors[name], np.stack(values))
        first: dict[str, Reading] = {}
        for reading in readings:
            first.setdefault(reading.sensor, reading)
        belief = first_belief(self.layout, tuple(first.values()), self._initial, self._searches)
        self.counts.starts += 1
        last = max(first.values(), key=self._key)
        self._steps = [_Step(self._key(last), last, belief, None)]
        used = {id(reading) for reading in first.values()}
        shown: list[Innovation] = []
        for reading in readings:
            if id(reading) in used:
                self.counts.used[reading.sensor] += 1
            elif self._key(reading) > self._steps[-1].key:
                shown.append(self._take(reading))
            elif self._key(reading) == self._steps[-1].key:
                self.counts.duplicate[reading.sensor] += 1
            else:
                self.counts.early[reading.sensor] += 1
        return tuple(shown)

    def _require_enough(self, names: set[str]) -> None:
        """Raise SensorError if the sensors without readings are needed."""
        missing = [name for name in self._order if name not in names]
        if not missing:
            return
        layout = self.layout
        present = [layout.sensors[name] for name in self._order if name in names]
        shown = observability(layout.robot, present, layout.model, self._initial)
        if shown.undetermined:
            undetermined = ", ".join(shown.undetermined)
            self._first = []
            raise SensorError(
                f"no reading of {', '.join(missing)} in {PATIENCE:g} s; without it nothing"
                f" determines {undetermined}"
            )

    def _start_anew_if_lost(self, shown: Sequence[Innovation]) -> None:
        """Start anew if no reading of any sensor has passed its gate for long."""
        for innovation in shown:
            self._rejected_in_row += 1
            if innovation.is_used:
                self._rejected_in_row = 0
        if self._rejected_in_row >= LOST:
            self._rejected_in_row = 0
            self._first, self._steps = [], []

    # -- steps

    def _key(self, reading: Reading) -> tuple[float, int]:
        return reading.time, self._order[reading.sensor]

    def _take(self, reading: Reading) -> Innovation:
        """Update with a reading that is not before the newest one."""
        before = predicted(self.layout, self._steps[-1].belief, reading.time)
        sensor = self.layout.sensors[reading.sensor]
        after, innovation = updated(self.layout, before, sensor, reading.values, GATE)
        self._count(innovation, 1)
        self._steps.append(_Step(self._key(reading), reading, after, innovation))
        return innovation

    def _count(
        self,
        innovation: Innovation | None,
        number: int,
    ) -> None:
        if innovation is None:
            return
        counter = self.counts.used if innovation.is_used else self.counts.beyond_gate
        counter[innovation.sensor] += number

    def _forget(self) -> None:
        """Drop steps that no late reading can change."""
        oldest = self._steps[-1].reading.time - self._latest
        keep = bisect.bisect_left(self._steps, (oldest, -1), key=lambda step: step.key)
        keep = min(keep, len(self._steps) - 1)
        if keep > 1:
            del self._steps[: keep - 1]
