"""What comes in: joint samples by name, checked and put into the robot's order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.errors import (
    ClosureError,
    HybridDynamicsError,
    InputError,
    SingularityError,
)
from hybrid_dynamics_core.ground.suggestions import suggestion
from hybrid_dynamics_core.ground.wording import counted, one_line

from .cdr import NS

FloatArray = NDArray[np.float64]
Named = dict[str, float]  # a number of each joint
# Of any measured number, in its unit: no joint is there, and all that follows from it is finite.
LARGEST: Final = 1e12
LONGEST: Final = 131_072  # [bytes] of a message that is read
_MOST_LISTED: Final = 12  # names in a text
_MOST_COMPARED: Final = 64  # names among which a slip is looked for: messages may be long and many


def nanoseconds(sec: int, nanosec: int) -> int:
    """A stamp in nanoseconds.

    Negative where it says so, or where its nanoseconds are a second or more.
    """
    if nanosec >= NS:
        return -1
    return int(sec) * NS + int(nanosec)


class RejectionCode(Enum):
    """Why a sample was not used."""

    EMPTY = "empty"  # no joint names at all
    WRONG_LENGTH = "wrong length"  # an array has not one value for each name
    DUPLICATE_JOINT = "duplicate joint"  # an active joint is named twice
    MISSING_JOINT = "missing joint"  # an active joint is not named
    NOT_FINITE = "not finite"  # NaN or infinity for an active joint
    BAD_STAMP = "bad stamp"  # negative
    BAD_REQUEST = "bad request"  # of a service: a frame, a mode or a choice that there is not
    UNREACHABLE = "unreachable"  # a loop cannot be closed
    LIMIT = "limit"  # of a trajectory: a joint beyond its limit
    SINGULAR = "singular"  # a loop is at a toggle point
    TOO_LONG = "too long"  # a message of more bytes than any robot's
    OVERFLOW = "overflow"  # input so large that a result is not finite
    NOT_READY = "not ready"  # of a service: no robot yet, or no input yet
    REFUSED = "refused"  # of a service: the state of the robot forbids it
    BUSY = "busy"  # of a service: too many calls wait
    TIMEOUT = "timeout"  # of a service: it took too long
    INTERNAL = "internal"  # the model failed in a way that is not the input's fault


@dataclass(frozen=True)
class Rejection:
    """A sample that was not used: why, and a sentence for people."""

    code: RejectionCode
    text: str


def oversized(size: int) -> Rejection | None:
    """Why a message of so many bytes is not even read; None where it is.

    Reading it would take so long that messages of other topics were lost meanwhile.
    """
    if size <= LONGEST:
        return None
    return Rejection(
        RejectionCode.TOO_LONG,
        f"a message of {size} bytes, expected {LONGEST} at most: some thousand joints",
    )


class RejectedError(Exception):
    """Carries a :class:`Rejection` to whoever answers for it."""

    def __init__(self, code: RejectionCode, text: str) -> None:
        self.rejection = Rejection(code, text)
        super().__init__(text)


def rejection_of(error: HybridDynamicsError) -> Rejection:
    """The rejection that an error of the model means."""
    text = one_line(error)
    if isinstance(error, ClosureError):
        return Rejection(RejectionCode.UNREACHABLE, text)
    if isinstance(error, SingularityError):
        return Rejection(RejectionCode.SINGULAR, text)
    if isinstance(error, InputError):
        # Names, lengths and finite input were checked before: only a number too large is left.
        return Rejection(RejectionCode.OVERFLOW, text)
    return Rejection(RejectionCode.INTERNAL, text)


class JointSample(NamedTuple):
    """Joints by name at one stamp, as they came.

    Attributes:
        stamp_ns: stamp [ns].
        names: joint names, in any order; more than the active joints are allowed.
        position: one value for each name [rad or m].
        velocity: one for each name [rad/s or m/s], or None where there is none.
        acceleration: one for each name [rad/s^2 or m/s^2], or None where it has to be estimated.
        effort: one for each name [N m or N], or None where there is none or nobody asks.
    """

    stamp_ns: int
    names: Sequence[str]
    position: FloatArray
    velocity: FloatArray | None = None
    acceleration: FloatArray | None = None
    effort: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class Calibration:
    """Sensors: coordinate = factor * (reading - offset).

    Attributes:
        offset, factor: (n,) in the order of the measured joints.
    """

    offset: FloatArray
    factor: FloatArray


class OrderedMotion(NamedTuple):
    """Motion of some joints in a fixed order, finite: arrays (n,), or of rows (N, n).

    Attributes:
        position: [rad or m].
        velocity: [rad/s or m/s], or None where it is not known; of readings NaN for single joints.
        acceleration: [rad/s^2 or m/s^2], or None where it is not known.
    """

    position: FloatArray
    velocity: FloatArray | None
    acceleration: FloatArray | None

    def calibrated(self, calibration: Calibration) -> OrderedMotion:
        """The motion of the joints from the readings of their sensors."""
        factor = calibration.factor
        return OrderedMotion(
            factor * (self.position - calibration.offset),
            None if self.velocity is None else factor * self.velocity,
            None if self.acceleration is None else factor * self.acceleration,
        )

    def complete(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Position, velocity and acceleration.

        Raises:
            RejectedError: one of them is not there.
        """
        if self.velocity is None or self.acceleration is None:
            raise RejectedError(
                RejectionCode.WRONG_LENGTH, "velocities and accelerations are needed"
            )
        return self.position, self.velocity, self.acceleration

    def by_name(self, names: Sequence[str]) -> tuple[Named, Named | None, Named | None]:
        """Positions, velocities and accelerations of one sample, each by joint name."""
        position = dict(zip(names, self.position.tolist(), strict=True))
        return position, _by_name(names, self.velocity), _by_name(names, self.acceleration)


def _by_name(names: Sequence[str], values: FloatArray | None) -> Named | None:
    if values is None:
        return None
    return dict(zip(names, values.tolist(), strict=True))


def wrong_length(what: str, size: int, count: int) -> str:
    """That an array has not one value for each joint name."""
    expected = str(count)
    if size == 0 and what in ("velocity", "acceleration"):
        expected = f"{count}, zeros for a robot at rest"
    values, names = counted(size, "value"), counted(count, "joint name")
    return f"{what} has {values} for {names}; expected {expected}"


def _listed(names: Sequence[str]) -> str:
    text = ", ".join(names[:_MOST_LISTED])
    return f"{text}, ..." if len(names) > _MOST_LISTED else text


def _why_missing(missing: Sequence[str], names: Sequence[str], joints: Sequence[str]) -> str:
    """The name that is nearly that of a missing joint; where there is none, the given ones."""
    for name in names[:_MOST_COMPARED]:
        if name not in joints:
            hint = suggestion(name, missing[:_MOST_LISTED])
            if hint:
                return f"'{name}' is none of {_listed(joints)}{hint}"
    return f"named are {_listed(names)}"


def resting_joints(robot: Robot) -> Named:
    """Where joints are [rad or m] that nobody drives, while nobody says where they are."""
    return {name: float(robot.reference[robot.active.index(name)]) for name in robot.idle}


def resting_besides(robot: Robot, names: Sequence[str]) -> Named:
    """Idle joints that fewer coordinates than the robot has freedoms leave out [rad or m]."""
    if len(names) >= len(robot.active):
        return {}
    resting = resting_joints(robot)
    return {name: position for name, position in resting.items() if name not in names}


def active_order(robot: Robot) -> JointOrder:
    """Picks the active coordinates of a robot; idle ones may be left out."""
    return JointOrder(robot.active, resting_joints(robot))


class JointOrder:
    """Picks joints out of samples, in an order. Other joints are ignored, whatever they hold."""

    def __init__(self, joints: Sequence[str], resting: Mapping[str, float] | None = None) -> None:
        """An order of joints.

        Args:
            joints: names.
            resting: positions of joints that a sample need not name [rad or m]: they are at rest.
        """
        self._joints = tuple(joints)
        self._resting = dict(resting or {})
        self._added = np.zeros(0)  # positions of the resting joints that are not named
        # Streams repeat the same names: their places are looked up once.
        self._names: tuple[str, ...] = ()
        self._places = np.zeros(0, dtype=np.intp)

    def arrange(self, sample: JointSample, *, is_reading: bool = False) -> OrderedMotion:
        """The motion of the joints.

        Args:
            sample: joints by name.
            is_reading: whether velocities may be absent, NaN: of all joints, which gives None, or
                of some, which stay NaN.

        Raises:
            RejectedError: names are missing or doubled, lengths differ, or a number is not finite
                or beyond `LARGEST`.
        """
        places = self._find(tuple(sample.names))
        count = len(sample.names)
        velocity, acceleration = sample.velocity, sample.acceleration
        position = self._pick("position", sample.position, count, places)
        if velocity is not None and is_reading:
            velocity = self._pick_rates(velocity, count, places)
        elif velocity is not None:
            velocity = self._pick("velocity", velocity, count, places)
        if acceleration is not None:
            acceleration = self._pick("acceleration", acceleration, count, places)
        return OrderedMotion(position, velocity, acceleration)

    def pick(self, what: str, names: Sequence[str], values: FloatArray) -> FloatArray:
        """One value (n,) of each joint.

        Args:
            what: of what kind the values are, for error texts.
            names: (k,) joint names, in any order; more than the joints are allowed.
            values: (k,) one for each name.

        Raises:
            RejectedError: as `arrange` does.
        """
        places = self._find(tuple(names))
        return self._pick(what, values, len(names), places)

    def _find(self, names: tuple[str, ...]) -> NDArray[np.intp]:
        """Where the joints are among the names of a sample."""
        if names == self._names and names:
            return self._places
        if not names:
            raise RejectedError(
                RejectionCode.EMPTY, f"no joint is named, expected {', '.join(self._joints)}"
            )
        unnamed = [name for name in self._joints if name not in names]
        missing = [name for name in unnamed if name not in self._resting]
        if missing:
            why = _why_missing(missing, names, self._joints)
            raise RejectedError(RejectionCode.MISSING_JOINT, f"{_listed(missing)} not named; {why}")
        doubled = [name for name in self._joints if names.count(name) > 1]
        if doubled:
            raise RejectedError(
                RejectionCode.DUPLICATE_JOINT, f"joint {', '.join(doubled)} is named twice"
            )
        completed = (*names, *unnamed)
        self._places = np.array([completed.index(name) for name in self._joints], dtype=np.intp)
        self._added = np.array([self._resting[name] for name in unnamed])
        self._names = names
        return self._places

    def _pick(
        self, what: str, values: FloatArray, count: int, places: NDArray[np.intp]
    ) -> FloatArray:
        picked = self._completed(what, values, count)[places]
        size = sum(map(abs, picked.tolist()))  # in plain floats this costs least
        if not size < LARGEST:  # NaN is not
            self._require_good(what, picked)
        return picked

    def _pick_rates(
        self, values: FloatArray, count: int, places: NDArray[np.intp]
    ) -> FloatArray | None:
        """Velocities, NaN where they are absent; None where they are of all named joints."""
        picked = self._completed("velocity", values, count)[places]
        size = sum(map(abs, picked.tolist()))
        if size < LARGEST:
            return picked
        is_absent = np.isnan(picked)
        self._require_good("velocity", np.where(is_absent, 0.0, picked))
        is_named = places < count
        return None if is_absent[is_named].all() else picked

    def _completed(self, what: str, values: FloatArray, count: int) -> FloatArray:
        """One value for each name, and one for each resting joint that is not named."""
        if values.shape != (count,):
            text = wrong_length(what, values.size, count)
            raise RejectedError(RejectionCode.WRONG_LENGTH, text)
        if not len(self._added):
            return values
        added = self._added if what == "position" else np.zeros_like(self._added)
        return np.concatenate([values, added])

    def _require_good(self, what: str, picked: FloatArray) -> None:
        finite = np.isfinite(picked)
        if not finite.all():
            raise RejectedError(RejectionCode.NOT_FINITE, self._value(what, picked, finite))
        small = np.abs(picked) < LARGEST
        if not small.all():
            text = f"{self._value(what, picked, small)}, expected less than {LARGEST:g}"
            raise RejectedError(RejectionCode.OVERFLOW, text)

    def _value(self, what: str, picked: FloatArray, good: NDArray[np.bool_]) -> str:
        """The first value that is not good, in words."""
        bad = int(np.argmin(good))
        return f"{what} of joint {self._joints[bad]} is {picked[bad]}"
