"""Input samples of joints by name: checks, and conversion to the robot's order."""

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
Named = dict[str, float]  # a number by joint
# Largest measured number in its unit, above any real value, for which all results are finite.
LARGEST: Final = 1e12
LONGEST: Final = 131_072  # [bytes] longest message that is read
_MOST_LISTED: Final = 12  # names listed in a text
_MOST_COMPARED: Final = 64  # names compared for suggestions, since messages may be long


def nanoseconds(sec: int, nanosec: int) -> int:
    """A stamp in nanoseconds.

    It is negative if the stamp is, or if its nanoseconds are a second or more.
    """
    if nanosec >= NS:
        return -1
    return int(sec) * NS + int(nanosec)


class RejectionCode(Enum):
    """Reasons for rejections."""

    EMPTY = "empty"  # no joint names at all
    WRONG_LENGTH = "wrong length"  # an array does not have one value for each name
    DUPLICATE_JOINT = "duplicate joint"  # an active joint is named twice
    MISSING_JOINT = "missing joint"  # an active joint is not named
    NOT_FINITE = "not finite"  # NaN or infinity for an active joint
    BAD_STAMP = "bad stamp"  # negative
    BAD_PRESSURE = "bad pressure"  # one that a cylinder cannot have, as in another unit
    BAD_REQUEST = "bad request"  # of a service: an unknown frame, mode or choice
    UNREACHABLE = "unreachable"  # a loop cannot be closed
    LIMIT = "limit"  # of a trajectory: a joint beyond its limit
    SINGULAR = "singular"  # a loop is at a toggle point
    TOO_LONG = "too long"  # a message larger than any robot's
    OVERFLOW = "overflow"  # input so large that a result is not finite
    NOT_READY = "not ready"  # of a service: no robot yet, or no input yet
    REFUSED = "refused"  # of a service: the state of the robot forbids it
    BUSY = "busy"  # of a service: too many calls wait
    TIMEOUT = "timeout"  # of a service: it took too long
    INTERNAL = "internal"  # an unexpected error of the model


@dataclass(frozen=True)
class Rejection:
    """A rejected sample: the reason, and a sentence."""

    code: RejectionCode
    text: str


def oversized(size: int) -> Rejection | None:
    """The rejection of a message above the size limit; None below it.

    Reading it would take so long that messages of other topics could be lost.
    """
    if size <= LONGEST:
        return None
    return Rejection(
        RejectionCode.TOO_LONG,
        f"a message of {size} bytes, expected {LONGEST} at most: some thousand joints",
    )


class RejectedError(Exception):
    """An exception with a `Rejection`."""

    def __init__(self, code: RejectionCode, text: str) -> None:
        self.rejection = Rejection(code, text)
        super().__init__(text)


def rejection_of(error: HybridDynamicsError) -> Rejection:
    """The rejection for an error of the model."""
    text = one_line(error)
    if isinstance(error, ClosureError):
        return Rejection(RejectionCode.UNREACHABLE, text)
    if isinstance(error, SingularityError):
        return Rejection(RejectionCode.SINGULAR, text)
    if isinstance(error, InputError):
        # Names, lengths and finite input were checked before; only too large numbers remain.
        return Rejection(RejectionCode.OVERFLOW, text)
    return Rejection(RejectionCode.INTERNAL, text)


class JointSample(NamedTuple):
    """Joints by name at one stamp, as in the message.

    Attributes:
        stamp_ns: stamp [ns].
        names: joint names in any order, possibly more than the active joints.
        position: one value for each name [rad or m].
        velocity: one for each name [rad/s or m/s], or None if missing.
        acceleration: one for each name [rad/s^2 or m/s^2], or None if it must be estimated.
        effort: one for each name [N m or N], or None if missing or not requested.
    """

    stamp_ns: int
    names: Sequence[str]
    position: FloatArray
    velocity: FloatArray | None = None
    acceleration: FloatArray | None = None
    effort: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class Calibration:
    """Calibration of sensors: coordinate = factor * (reading - offset).

    Attributes:
        offset, factor: (n,) in the order of the measured joints.
    """

    offset: FloatArray
    factor: FloatArray


class OrderedMotion(NamedTuple):
    """Finite motion of joints in a fixed order: arrays (n,), or (N, n) for rows.

    Attributes:
        position: [rad or m].
        velocity: [rad/s or m/s], or None if unknown; in readings, NaN for joints without one.
        acceleration: [rad/s^2 or m/s^2], or None if unknown.
    """

    position: FloatArray
    velocity: FloatArray | None
    acceleration: FloatArray | None

    def calibrated(self, calibration: Calibration) -> OrderedMotion:
        """The motion of the joints, from readings of their sensors."""
        factor = calibration.factor
        return OrderedMotion(
            factor * (self.position - calibration.offset),
            None if self.velocity is None else factor * self.velocity,
            None if self.acceleration is None else factor * self.acceleration,
        )

    def complete(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Position, velocity and acceleration.

        Raises:
            RejectedError: one of them is missing.
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
    """Text on an array whose length is not that of the joint names."""
    expected = str(count)
    if size == 0 and what in ("velocity", "acceleration"):
        expected = f"{count}, zeros for a robot at rest"
    values, names = counted(size, "value"), counted(count, "joint name")
    return f"{what} has {values} for {names}; expected {expected}"


def _listed(names: Sequence[str]) -> str:
    text = ", ".join(names[:_MOST_LISTED])
    return f"{text}, ..." if len(names) > _MOST_LISTED else text


def _why_missing(missing: Sequence[str], names: Sequence[str], joints: Sequence[str]) -> str:
    """Text with a name similar to a missing joint's; without one, with all given names."""
    for name in names[:_MOST_COMPARED]:
        if name not in joints:
            hint = suggestion(name, missing[:_MOST_LISTED])
            if hint:
                return f"'{name}' is none of {_listed(joints)}{hint}"
    return f"named are {_listed(names)}"


def resting_joints(robot: Robot) -> Named:
    """Default positions [rad or m] of joints without a drive."""
    return {name: float(robot.reference[robot.active.index(name)]) for name in robot.idle}


def resting_besides(robot: Robot, names: Sequence[str]) -> Named:
    """Default positions [rad or m] of idle joints that are not among given coordinates."""
    if len(names) >= len(robot.active):
        return {}
    resting = resting_joints(robot)
    return {name: position for name, position in resting.items() if name not in names}


def active_order(robot: Robot) -> JointOrder:
    """The order of a robot's active coordinates; idle ones may be missing in samples."""
    return JointOrder(robot.active, resting_joints(robot))


class JointOrder:
    """Selects joints of samples, in an order; other joints are ignored."""

    def __init__(self, joints: Sequence[str], resting: Mapping[str, float] | None = None) -> None:
        """Set the order.

        Args:
            joints: names of the joints.
            resting: default positions of joints that may be missing, which are at rest [rad or m].
        """
        self._joints = tuple(joints)
        self._resting = dict(resting or {})
        self._added = np.zeros(0)  # default positions of missing joints
        # Indices are cached, since streams repeat the same names.
        self._names: tuple[str, ...] = ()
        self._places = np.zeros(0, dtype=np.intp)

    def arrange(self, sample: JointSample, *, is_reading: bool = False) -> OrderedMotion:
        """The motion of the joints.

        Args:
            sample: joints by name.
            is_reading: whether velocities may be NaN for absent: for all joints, which gives None,
                or for some, which stay NaN.

        Raises:
            RejectedError: a name is missing or duplicate, lengths differ, or a number is not finite
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
        """Select one value (n,) for each joint.

        Args:
            what: kind of the values, for error texts.
            names: (k,) joint names in any order, possibly more than the joints.
            values: (k,) one value for each name.

        Raises:
            RejectedError: as in `arrange`.
        """
        places = self._find(tuple(names))
        return self._pick(what, values, len(names), places)

    def _find(self, names: tuple[str, ...]) -> NDArray[np.intp]:
        """Indices of the joints in the names of a sample."""
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
        size = sum(map(abs, picked.tolist()))  # plain floats are fastest
        if not size < LARGEST:  # also false for NaN
            self._require_good(what, picked)
        return picked

    def _pick_rates(
        self, values: FloatArray, count: int, places: NDArray[np.intp]
    ) -> FloatArray | None:
        """Velocities, NaN where absent; None if they are absent for all named joints."""
        picked = self._completed("velocity", values, count)[places]
        size = sum(map(abs, picked.tolist()))
        if size < LARGEST:
            return picked
        is_absent = np.isnan(picked)
        self._require_good("velocity", np.where(is_absent, 0.0, picked))
        is_named = places < count
        return None if is_absent[is_named].all() else picked

    def _completed(self, what: str, values: FloatArray, count: int) -> FloatArray:
        """One value for each name, and one for each missing joint with a default."""
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
        """Text on the first wrong value."""
        bad = int(np.argmin(good))
        return f"{what} of joint {self._joints[bad]} is {picked[bad]}"
