"""Parameters from a recording, with confidence, and what they are worth on a part of it that they have not seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core import Loads
from hybrid_dynamics_core.dynamics.parameters import Parameters, described_parameters
from hybrid_dynamics_core.errors import InputError
from hybrid_dynamics_core.ground.suggestions import suggestion
from hybrid_dynamics_core.ground.wording import counted, singular_or_plural
from hybrid_dynamics_core.identification import (
    Identification,
    identify,
    noise_limit,
    robust_deviation,
)
from hybrid_dynamics_core.robot.robot import Robot

from ...messages.joint_samples import FloatArray
from ..errors import BagError
from .collect import Track

_NOTHING: Final = (
    1e-9  # share of the largest base parameter up to which one is zero but for rounding
)
_WORSE: Final = (
    1.1  # times what the file leaves: noise in the estimates alone makes some percent at most
)
_SEEN: Final = 1e-3  # share of the efforts below which what is left does not matter
_EDGE: Final = 0.02  # share of the samples at both ends of the held-out part that neither side sees


@dataclass(frozen=True)
class LeftOut:
    """A sample that was left out.

    Attributes:
        time: [s] since the start of the bag.
        joint: the one that is furthest off.
        off: by how much: an effort [N m or N], for a sample outlier a position [rad or m] or a
        velocity.
        what: of these three which.
        late: by how much later than the motion says a stray's stamp is [s]; NaN where that is not
        known.
    """

    time: float
    joint: str
    off: float
    what: str
    late: float = float("nan")


@dataclass(frozen=True, eq=False)
class Found:
    """What identification found.

    Attributes:
        result: estimates with confidence.
        joints: the active ones, (n,).
        trained, held: how many samples each part has.
        noise: (n,) standard deviation of what is left in the held-out part with the estimates [N m
        or N].
        before: (n,) the same with the parameters of the robot file.
        spread: (n,) standard deviation of the recorded efforts there.
        left_out: samples that count in neither part, in the order of their times.
        described: (b,) base parameters as the robot file has them, in the order of the result.
    """

    result: Identification
    joints: tuple[str, ...]
    trained: int
    held: int
    noise: FloatArray
    before: FloatArray
    spread: FloatArray
    left_out: tuple[LeftOut, ...]
    described: FloatArray

    @property
    def worse(self) -> tuple[str, ...]:
        """Joints whose efforts, where they were not seen, the estimates explain worse than the robot file.

        What is below a thousandth of the efforts does not count.
        """
        least = _SEEN * np.maximum(self.spread, 0.1 * self.spread.max())
        worse = self.noise > np.maximum(_WORSE * self.before, least)
        return tuple(name for name, bad in zip(self.joints, worse, strict=True) if bad)

    @property
    def meant(self) -> tuple[str, ...]:
        """Base parameters that are not zero in the robot file."""
        largest = max(float(np.abs(self.described).max(initial=0.0)), 1e-300)
        names = zip(self.result.table(), self.described, strict=True)
        return tuple(name for name, value in names if abs(value) > _NOTHING * largest)

    @property
    def determined(self) -> tuple[str, ...]:
        """Base parameters that are not 0, at 95 % for all of them together: the motion shows at least their signs.

        One interval in twenty misses, and where the motion excites too little many miss at once: so
        the least of all has to be as far from 0 as the largest of as many Gaussian values hardly
        ever is. None of those that bodies with positive masses cannot have (`bodiless`), and none
        where the estimates are `worse` than the robot file: their intervals hold for a model that
        does not.
        """
        return self._named(self._sure & self._embodied)

    @property
    def bodiless(self) -> tuple[str, ...]:
        """Those that would be determined, if bodies could have them: their noise cannot be white.

        Where the motion hardly shows a combination, small errors of stamps and accelerations, which
        make errors of the efforts, look like it. They know nothing of positive masses, and land far
        off what masses can make.
        """
        return self._named(self._sure & ~self._embodied)

    @property
    def physical(self) -> FloatArray:
        """(b,) base parameters of bodies with positive masses, nearest to the efforts."""
        return np.asarray(self.result.base.values(self.result.values))

    def _named(self, chosen: NDArray[np.bool_]) -> tuple[str, ...]:
        """The chosen ones (b,); none where the estimates are `worse`."""
        names = zip(self.result.base.names, chosen, strict=True)
        return () if self.worse else tuple(name for name, one in names if one)

    @property
    def _sure(self) -> NDArray[np.bool_]:
        return np.asarray(np.abs(self.result.estimate) > self._reach)

    @property
    def _embodied(self) -> NDArray[np.bool_]:
        return np.asarray(np.abs(self.result.estimate - self.physical) <= self._reach)

    @property
    def _reach(self) -> FloatArray:
        """(b,) how far the estimates may be off, at 95 % for all of them together."""
        return np.asarray(noise_limit(len(self.result.estimate)) * self.result.deviation)

    @property
    def unsettled(self) -> tuple[str, ...]:
        """Those of them that are not determined: the motion does not even show their sign."""
        return tuple(name for name in self.meant if name not in self.determined)

    @property
    def explained(self) -> FloatArray:
        """Share of the variance of the held-out efforts that the estimates explain, (n,); NaN where none varies."""
        told = self.spread > 0.0
        return np.where(told, 1.0 - (self.noise / np.where(told, self.spread, 1.0)) ** 2, np.nan)


def asked_parameters(
    robot: Robot, links: Sequence[str] = (), friction: Sequence[str] = ()
) -> Parameters:
    """Inertias of these links (none: of all that have mass) and friction of these joints.

    Raises:
        InputError: the robot has no such link that moves, or no such joint.
    """
    moving = [name for name in robot.description.links if name != robot.description.base]
    for names, known, what in (
        (links, moving, "moving link"),
        (friction, [*robot.description.joints], "joint"),
    ):
        for name in names:
            if name not in known:
                raise InputError(
                    f"'{name}' is not a {what}{suggestion(name, known)}; they are {', '.join(known)}"
                )
    asked = described_parameters(robot.description, tuple(dict.fromkeys(friction)))
    return replace(asked, links=tuple(dict.fromkeys(links))) if links else asked


def identify_track(
    track: Track, parameters: Parameters | None = None, hold_out: float = 0.25
) -> Found:
    """Identify from recorded efforts; the last part of the recording is held out.

    Args:
        track: of a recording with efforts.
        parameters: which are asked for, see `asked_parameters`; None: inertias of all links with
        mass.
        hold_out: share of the samples.

    Raises:
        BagError: there are no recorded efforts.
        InputError: the motion does not show the parameters.
    """
    robot = track.robot
    usable = np.isfinite(track.recorded).all(axis=1) & np.isfinite(track.acceleration).all(axis=1)
    rows = np.flatnonzero(usable)
    if len(rows) < 10:
        count = f"{counted(len(rows), 'sample')} {singular_or_plural(len(rows), 'has', 'have')}"
        kept = (
            "; these are what `bag process` computed: process the recording with --keep, which"
            " takes its topics over too, or identify from the recording itself"
        )
        raise BagError(
            f"{track.topic}: {count} recorded efforts of {', '.join(robot.active)} and"
            " accelerations; identification needs the effort field of the recorded joint"
            f" states{kept if track.computed else ''}"
        )
    cut = round(len(rows) * (1.0 - hold_out))
    edge = round(_EDGE * len(rows))
    train, held = rows[: max(cut - edge, 1)], rows[cut:]
    parameters = asked_parameters(robot) if parameters is None else parameters
    result = identify(
        robot,
        track.state.rows(train),
        track.acceleration[train],
        track.recorded[train],
        parameters,
        track.loads,
    )
    better = Robot(result.described(robot.description))
    loads = better.loads.with_gravity(track.loads.gravity)
    left = _left(better, track, held, loads)
    before = _left(robot, track, held, track.loads)
    neither = _unexplained(left, before)
    strange = [
        (train, result.outlying, result.residual, result.noise),
        (held, neither, before, before.std(axis=0)),
    ]
    left_out = sorted(
        [*_strays(track), *(entry for part in strange for entry in _told(track, *part))], key=_time
    )
    left, before, held = left[~neither], before[~neither], held[~neither]
    return Found(
        result=result,
        joints=robot.active,
        trained=int((~result.outlying).sum()),
        held=len(held),
        noise=left.std(axis=0),
        before=before.std(axis=0),
        spread=track.recorded[held].std(axis=0),
        left_out=tuple(left_out),
        described=np.asarray(result.base.values(parameters.values(robot.description))),
    )


def _time(entry: LeftOut) -> float:
    return entry.time


def _unexplained(left: FloatArray, before: FloatArray) -> NDArray[np.bool_]:
    """Samples (N,) whose efforts neither the estimates nor the robot file explain, beyond what noise does.

    By the better one of both: what a wrong model leaves everywhere is no fault of a sample.
    """
    least = np.minimum(
        np.abs(left - np.median(left, axis=0)), np.abs(before - np.median(before, axis=0))
    )
    limit = noise_limit(least.size) * np.maximum(robust_deviation(least), 1e-300)
    return np.asarray((least > limit).any(axis=1))


def _strays(track: Track) -> list[LeftOut]:
    names, start = track.measured, track.start_ns
    return [
        LeftOut(s.at(start), names[s.joint], s.off, "velocity" if s.rate else "position", s.late)
        for s in track.outliers
    ]


def _told(
    track: Track,
    rows: NDArray[np.intp],
    out: NDArray[np.bool_],
    residual: FloatArray,
    noise: FloatArray,
) -> list[LeftOut]:
    found = []
    for k in np.flatnonzero(out):
        joint = int(np.argmax(np.abs(residual[k]) / np.maximum(noise, 1e-300)))
        found.append(
            LeftOut(
                float(track.time[rows[k]]),
                track.robot.active[joint],
                float(residual[k, joint]),
                "effort",
            )
        )
    return found


def _left(robot: Robot, track: Track, rows: NDArray[np.intp], loads: Loads) -> FloatArray:
    state = robot.close(track.state.u[rows], track.state.du[rows])
    computed = robot.inverse_dynamics(state, track.acceleration[rows], loads)
    left: FloatArray = track.recorded[rows] - computed
    return left
