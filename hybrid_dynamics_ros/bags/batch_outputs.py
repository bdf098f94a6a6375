"""What goes out for each accepted sample: the node's topics, encoded in bulk.

The table follows `outputs.TABLE`; a test compares both, message by message.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core import ClosedState, CylinderState, Loads, Robot
from hybrid_dynamics_core.dynamics.reactions import PinReaction
from hybrid_dynamics_core.errors import SingularityError

from ..messages import layouts
from ..messages.cdr import Template
from ..messages.interfaces import JOINT_STATE
from ..messages.joint_samples import FloatArray
from ..messages.link_transforms import LinkTransforms
from ..parameters import RATES, TF_RATE, Settings
from ..stream.rate_limit import Pace
from ..stream.stroke_margins import Strokes
from .batch_pipeline import Motion
from .storage.mcap_chunk import Block

Rows = NDArray[np.intp]
Filled = tuple[Rows, Template, dict[str, Any]]  # rows of the motion, their layout, their numbers
_NS: Final = 10**9
NODE: Final = "/hybrid_dynamics"
_TYPES: Final = {
    "joint_states": JOINT_STATE,
    "required_efforts": JOINT_STATE,
    "closed_state": "hybrid_dynamics_msgs/msg/ClosedState",
    "end_effector_pose": "geometry_msgs/msg/PoseStamped",
    "end_effector_twist": "geometry_msgs/msg/TwistStamped",
    "loop_reactions": "hybrid_dynamics_msgs/msg/LoopReactions",
    "cylinder_states": "hybrid_dynamics_msgs/msg/CylinderStates",
}


@dataclass(frozen=True)
class Output:
    """One topic: its name, its type, what makes its messages, and which of them are due."""

    name: str
    kind: str
    make: Callable[[Motion, Rows], Iterator[Filled]]
    rate: float
    pace: Pace

    def blocks(self, channel: int, motion: Motion) -> Iterator[Block]:
        """The messages of the motion."""
        rows = self.pace.due_rows(motion.stamp_ns, self.rate)
        if not len(rows):
            return
        for own, template, values in self.make(motion, rows):
            stamps = _of(motion.stamp_ns, own)
            head = {"sec": stamps // _NS, "nanosec": stamps % _NS}
            yield Block.filled(channel, _of(motion.log_ns, own), template, {**head, **values})


def outputs_of(robot: Robot, loads: Loads, settings: Settings) -> list[Output]:
    """All topics of the node for one robot."""
    makers: dict[str, Callable[[Motion, Rows], Iterator[Filled]]] = {
        "joint_states": JointStates(robot),
        "required_efforts": RequiredEfforts(robot),
        "closed_state": ClosedStates(robot),
        "end_effector_pose": Poses(robot),
        "end_effector_twist": Twists(robot),
        "loop_reactions": Reactions(robot, loads),
        "cylinder_states": Cylinders(robot),
    }
    rates = dict(zip(_TYPES, RATES, strict=True))
    table = [
        Output(f"{NODE}/{name}", _TYPES[name], make, settings[rates[name]], Pace())
        for name, make in makers.items()
    ]
    if settings[TF_RATE] >= 0.0:
        table.append(
            Output("/tf", "tf2_msgs/msg/TFMessage", Transforms(robot), settings[TF_RATE], Pace())
        )
    return table


class JointStates:
    """All joints: position, velocity, and the effort of the drives."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._own = set(robot.drives) == set(robot.active)
        names = robot.coordinates
        self._templates = [
            (moving, driven, layouts.joint_state(names, velocity=moving, effort=driven))
            for moving in (False, True)
            for driven in (False, True)
        ]

    def __call__(self, motion: Motion, rows: Rows) -> Iterator[Filled]:
        """Layouts differ in what is known."""
        along, known = self._along(motion)
        state = motion.state
        for moving, driven, template in self._templates:
            own = rows[(motion.moving[rows] == moving) & (known[rows] == driven)]
            if len(own):
                yield own, template, {
                    "position": _of(state.s, own), "velocity": _of(state.ds, own), "effort": _of(along, own)
                }  # fmt: skip

    def _along(self, motion: Motion) -> tuple[FloatArray, NDArray[np.bool_]]:
        robot, known = self._robot, motion.driven.copy()
        along = np.zeros_like(motion.state.s)
        if self._own:
            along[:, : len(robot.active)] = motion.efforts
            return along, known
        places = [robot.coordinates.index(name) for name in robot.drives]
        which = np.flatnonzero(known)
        if not len(which):
            return along, known
        try:
            forces = robot.drive_forces(motion.state.rows(which), motion.efforts[which])
            along[which[:, None], places] = np.stack(list(forces.values()), axis=-1)
        except SingularityError:
            for k in which:
                row = np.array([k])
                try:
                    forces = robot.drive_forces(motion.state.rows(row), motion.efforts[row])
                except SingularityError:
                    known[k] = False  # as they stand, the drives cannot give these forces
                else:
                    along[k, places] = [float(force[0]) for force in forces.values()]
        return along, known


class RequiredEfforts:
    """Torques and forces of the active joints."""

    def __init__(self, robot: Robot) -> None:
        self._template = layouts.joint_state(robot.active, velocity=True, effort=True)

    def __call__(self, motion: Motion, rows: Rows) -> Iterator[Filled]:
        """Nothing before accelerations are known."""
        own = rows[motion.driven[rows] & motion.moving[rows]]
        if len(own):
            state = motion.state
            yield own, self._template, {
                "position": _of(state.u, own), "velocity": _of(state.du, own), "effort": _of(motion.efforts, own)
            }  # fmt: skip


class ClosedStates:
    """Residual, assembly modes, distances to singularities and to the ends of strokes."""

    def __init__(self, robot: Robot) -> None:
        self._robot, self._strokes = robot, Strokes(robot)
        self._templates: dict[tuple[str, ...], Template] = {}  # by nearest loop and modes

    def __call__(self, motion: Motion, rows: Rows) -> Iterator[Filled]:
        """Layouts differ in the loop that is nearest to its singularity."""
        state = motion.state
        lower, upper = self._strokes.left(state.s)
        if state.loops:
            nearest, distance = np.argmin(state.distances, axis=-1), np.asarray(state.singularity)
        else:
            nearest, distance = np.zeros(len(motion), dtype=np.intp), np.ones(len(motion))
        for k in dict.fromkeys(_of(nearest, rows).tolist()):
            own = rows[_of(nearest, rows) == k]
            yield own, self._template(state, state.loops[k] if state.loops else ""), {
                "residual": _of(np.asarray(state.residual), own),
                "singularity": _of(state.distances, own),
                "nearest": _of(distance, own),
                "lower": _of(lower, own),
                "upper": _of(upper, own),
            }  # fmt: skip

    def _template(self, state: ClosedState, nearest: str) -> Template:
        key = (nearest, *state.branch.values())
        if key not in self._templates:
            self._templates[key] = layouts.closed_state(
                self._robot, self._strokes.joints, state.branch, nearest
            )
        return self._templates[key]


class Poses:
    """Pose of the end effector in the base frame."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._template = layouts.pose(robot)

    def __call__(self, motion: Motion, rows: Rows) -> Iterator[Filled]:
        """One for each."""
        state = _states(motion, rows)
        pose = self._robot.forward_kinematics(state)
        yield rows, self._template, {"position": pose.position, "turn": quaternions(pose.rotation)}


class Twists:
    """Velocity of the end effector's origin and its rotation."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._template = layouts.twist(robot)

    def __call__(self, motion: Motion, rows: Rows) -> Iterator[Filled]:
        """Nothing before rates are known."""
        own = rows[motion.moving[rows]]
        if len(own):
            state = _states(motion, own)
            twists = self._robot.jacobian(state) @ state.du[:, :, None]
            yield own, self._template, {"twist": twists}


class Reactions:
    """Force and moment in every pin."""

    def __init__(self, robot: Robot, loads: Loads) -> None:
        self._robot, self._loads = robot, loads
        self._template: Template | None = None

    def __call__(self, motion: Motion, rows: Rows) -> Iterator[Filled]:
        """Nothing before accelerations are known."""
        own = rows[motion.driven[rows] & motion.moving[rows]]
        if not len(own):
            return
        pins = self._robot.reactions(
            _states(motion, own), _of(motion.acceleration, own), self._loads
        ).pins
        count = len(pins)
        if self._template is None:
            self._template = _reactions(self._robot, pins)
        places = [pin.place for pin in pins.values()]
        wrenches = [np.concatenate([pin.force, pin.moment], axis=-1) for pin in pins.values()]
        empty = np.zeros((len(own), 0))
        yield own, self._template, {
            "places": np.concatenate(places, axis=-1) if count else empty,
            "wrenches": np.concatenate(wrenches, axis=-1) if count else empty,
        }  # fmt: skip


def _reactions(robot: Robot, pins: Mapping[str, PinReaction]) -> Template:
    count = len(pins)
    template = Template().header(robot.base_frame).strings(list(pins))
    for k in (0, 1):
        template.strings([pin.links[k] for pin in pins.values()])
    template.length(count).slot("places", "<f8", 3 * count)
    return template.length(count).slot("wrenches", "<f8", 6 * count)


class Cylinders:
    """Pressures and flows of the cylinders whose areas the robot file gives."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._numbers = [
            name for name in CylinderState.__dataclass_fields__ if name != "overloaded"
        ]
        count = len(robot.cylinders)
        template = Template().header().strings(list(robot.cylinders))
        for name in self._numbers:
            template.sequence(name, count)
        self._template = template.sequence("overloaded", count, "u1")

    def __call__(self, motion: Motion, rows: Rows) -> Iterator[Filled]:
        """Nothing before accelerations are known, or where no areas are given."""
        own = rows[motion.driven[rows]]
        if not len(own) or not self._robot.cylinders:
            return
        states = list(
            self._robot.hydraulics(_states(motion, own), _of(motion.efforts, own)).values()
        )
        values = {
            name: np.stack(
                [np.broadcast_to(getattr(s, name), (len(own),)) for s in states], axis=-1
            )
            for name in (*self._numbers, "overloaded")
        }
        yield own, self._template, values


class Transforms:
    """Every link in the one before."""

    def __init__(self, robot: Robot) -> None:
        self._template, self._transforms = layouts.transforms(robot), LinkTransforms(robot)

    def __call__(self, motion: Motion, rows: Rows) -> Iterator[Filled]:
        """One for each."""
        yield rows, self._template, dict(self._transforms.values(_of(motion.state.s, rows)))


def _of(values: NDArray[Any], rows: Rows) -> NDArray[Any]:
    """Values of some rows of a motion; as they are where those are all of them."""
    return values if len(rows) == len(values) else values[rows]


def _states(motion: Motion, rows: Rows) -> ClosedState:
    return motion.state if len(rows) == len(motion) else motion.state.rows(rows)


def quaternions(rotations: FloatArray) -> FloatArray:
    """Unit quaternions (N, 4) x y z w of rotation matrices (N, 3, 3), with the steps of `placement.quaternion`."""
    (a, b, c), (d, e, f), (g, h, i) = np.moveaxis(rotations, 0, -1)
    squares = np.stack([1.0 + a - e - i, 1.0 - a + e - i, 1.0 - a - e + i, 1.0 + a + e + i])
    columns = np.array(
        [
            [squares[0], b + d, c + g, h - f],
            [b + d, squares[1], f + h, c - g],
            [c + g, f + h, squares[2], d - b],
            [h - f, c - g, d - b, squares[3]],
        ]
    )
    x, y, z, w = columns[np.argmax(squares, axis=0), :, np.arange(len(rotations))].T
    scale = np.copysign(1.0 / np.sqrt(x * x + y * y + z * z + w * w), w)
    return np.stack([scale * x, scale * y, scale * z, scale * w], axis=-1)
