"""Parameters from a recording, with confidence, and what they are worth on a part of it that they have not seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core import Loads
from hybrid_dynamics_core.description.schema import nearest
from hybrid_dynamics_core.dynamics.parameters import Parameters, described_parameters
from hybrid_dynamics_core.errors import InputError
from hybrid_dynamics_core.identification import Identification, identify
from hybrid_dynamics_core.robot import Robot
from hybrid_dynamics_ros.offline.collect import Track
from hybrid_dynamics_ros.offline.errors import BagError
from hybrid_dynamics_ros.samples import FloatArray

_NOTHING: Final = 1e-9  # share of the largest base parameter up to which one is zero but for rounding
_EDGE: Final = 0.02  # share of the samples at both ends of the held-out part that neither side sees


@dataclass(frozen=True, eq=False)
class Found:
    """What identification found.

    Attributes:
        result: estimates with confidence.
        trained, held: how many samples each part has.
        noise: (n,) standard deviation of what is left in the held-out part with the estimates [N m or N].
        before: (n,) the same with the parameters of the robot file.
        spread: (n,) standard deviation of the recorded efforts there.
        described: (b,) base parameters as the robot file has them, in the order of the result.
    """

    result: Identification
    trained: int
    held: int
    noise: FloatArray
    before: FloatArray
    spread: FloatArray
    described: FloatArray

    @property
    def meant(self) -> tuple[str, ...]:
        """Base parameters that are not zero in the robot file."""
        largest = max(float(np.abs(self.described).max(initial=0.0)), 1e-300)
        names = zip(self.result.table(), self.described, strict=True)
        return tuple(name for name, value in names if abs(value) > _NOTHING * largest)

    @property
    def determined(self) -> tuple[str, ...]:
        """Base parameters whose 95 % interval does not contain 0: the motion shows at least their sign."""
        return tuple(name for name, (_, low, high) in self.result.table().items() if not low <= 0.0 <= high)

    @property
    def unsettled(self) -> tuple[str, ...]:
        """Those of them whose 95 % interval contains 0: the motion does not even show their sign."""
        return tuple(name for name in self.meant if name not in self.determined)

    @property
    def explained(self) -> FloatArray:
        """Share of the variance of the held-out efforts that the estimates explain, (n,); NaN where none varies."""
        told = self.spread > 0.0
        return np.where(told, 1.0 - (self.noise / np.where(told, self.spread, 1.0)) ** 2, np.nan)


def asked_parameters(robot: Robot, links: Sequence[str] = (), friction: Sequence[str] = ()) -> Parameters:
    """Inertias of these links (none: of all that have mass) and friction of these joints.

    Raises:
        InputError: the robot has no such link that moves, or no such joint.
    """
    moving = [name for name in robot.description.links if name != robot.description.base]
    for names, known, what in ((links, moving, "moving link"), (friction, [*robot.description.joints], "joint")):
        for name in names:
            if name not in known:
                raise InputError(f"'{name}' is not a {what}{nearest(name, known)}; they are {', '.join(known)}")
    asked = described_parameters(robot.description, tuple(dict.fromkeys(friction)))
    return replace(asked, links=tuple(dict.fromkeys(links))) if links else asked


def identify_track(track: Track, parameters: Parameters | None = None, hold_out: float = 0.25) -> Found:
    """Identify from recorded efforts; the last part of the recording is held out.

    Args:
        track: of a recording with efforts.
        parameters: which are asked for, see `asked_parameters`; None: inertias of all links with mass.
        hold_out: share of the samples.

    Raises:
        BagError: there are no recorded efforts.
        InputError: the motion does not show the parameters.
    """
    robot = track.robot
    usable = np.isfinite(track.recorded).all(axis=1) & np.isfinite(track.acceleration).all(axis=1)
    rows = np.flatnonzero(usable)
    if len(rows) < 10:
        raise BagError(
            f"{track.topic}: {len(rows)} samples have recorded efforts of {', '.join(robot.active)} and accelerations; "
            "identification needs the effort field of the recorded joint states"
        )
    cut = round(len(rows) * (1.0 - hold_out))
    edge = round(_EDGE * len(rows))
    train, held = rows[: max(cut - edge, 1)], rows[cut:]
    parameters = asked_parameters(robot) if parameters is None else parameters
    result = identify(
        robot, track.state.rows(train), track.acceleration[train], track.recorded[train], parameters, track.loads
    )
    better = Robot(result.described(robot.description))
    loads = better.loads.with_gravity(track.loads.gravity)
    left = _left(better, track, held, loads)
    before = _left(robot, track, held, track.loads)
    spread = track.recorded[held].std(axis=0)
    described = np.asarray(result.base.values(parameters.values(robot.description)))
    return Found(result, len(train), len(held), left.std(axis=0), before.std(axis=0), spread, described)


def _left(robot: Robot, track: Track, rows: NDArray[np.intp], loads: Loads) -> FloatArray:
    state = robot.close(track.state.u[rows], track.state.du[rows])
    computed = robot.inverse_dynamics(state, track.acceleration[rows], loads)
    left: FloatArray = track.recorded[rows] - computed
    return left
