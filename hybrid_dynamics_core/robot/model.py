"""What a robot is: its description, the spanning tree, the closure plan, and their names."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from ..closed_state.assembly_modes import mode_names
from ..closure.mobility import find_mobility, with_mobility, with_regular_reference
from ..closure.plan import ClosurePlan, build_plan
from ..closure.printed_numbers import snapped
from ..closure.toggle_range import independent_range
from ..description.model import Frame, JointType, RobotDescription
from ..errors import DescriptionError, InputError
from ..ground.arrays import Array, frozen
from ..ground.lazy import lazy
from ..ground.suggestions import no_such_name
from ..ground.wording import counted
from ..mechanism.tree import Tree, build_tree
from ..programs import Model


@dataclass(frozen=True, eq=False)
class RobotModel:
    """The constant part of a robot. All other parts read it.

    Attributes:
        description: what the file says, with the independent coordinates as active ones.
        tree: spanning tree of the links.
        plan: how the loops close from the active coordinates.
        dependent_motors: motors that follow from the other ones. They are passive coordinates.
    """

    description: RobotDescription
    tree: Tree
    plan: ClosurePlan
    dependent_motors: tuple[str, ...] = ()

    @staticmethod
    def from_description(description: RobotDescription) -> RobotModel:
        """Build the tree and the closure plan.

        Raises:
            DescriptionError: the loops do not close, or do not fit the active joints.
        """
        description = snapped(description)
        tree = build_tree(description)
        if description.active_set != "motors":
            return _exact_model(description, tree)
        mobility = find_mobility(tree, description)
        description, tree = with_mobility(mobility)
        plan = build_plan(tree, description)
        return RobotModel(description, tree, plan, mobility.dependent)

    @property
    def name(self) -> str:
        """Name of the robot."""
        return self.description.name

    @lazy
    def active(self) -> tuple[str, ...]:
        """Names of the active coordinates u."""
        return self.tree.coordinates[: self.tree.n_active]

    @property
    def idle(self) -> tuple[str, ...]:
        """Active coordinates that nobody drives."""
        return self.description.idle

    @lazy
    def passive(self) -> tuple[str, ...]:
        """Names of the passive coordinates z."""
        return self.tree.coordinates[self.tree.n_active :]

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of all coordinates s = [u; z]."""
        return self.tree.coordinates

    @lazy
    def joint_types(self) -> Mapping[str, JointType]:
        """'revolute' or 'prismatic' by coordinate name, in the order of `coordinates`."""
        joints = self.description.joints
        return MappingProxyType({name: joints[name].type for name in self.coordinates})

    @lazy
    def frames(self) -> tuple[str, ...]:
        """Names of the frames and links whose pose is known."""
        names = (*self.description.frames, *self.description.links)
        return tuple(dict.fromkeys(names))

    def frame(self, name: str | None) -> Frame:
        """The frame, or link, of a name; the end effector if None.

        Raises:
            InputError: there is no such frame.
        """
        if name is None:
            name = self.description.end_effector
        if not isinstance(name, str):
            raise InputError(f"frame is {name!r}; expected the name of a frame or link")
        if name in self.description.frames:
            return self.description.frames[name]
        if name in self.description.links:
            return Frame(name)
        raise InputError(no_such_name("frame", name, self.frames))

    @lazy
    def loops(self) -> tuple[str, ...]:
        """Names of the blocks of loops in the order in which they close.

        A block is one loop, or several loops joined by +.
        """
        return tuple(dict.fromkeys(block.name for block in self.plan.blocks))

    @lazy
    def redundant_equations(self) -> Mapping[str, int]:
        """How many equations of each loop follow from the others and are left out."""
        counts: dict[str, int] = {}
        for equation in self.plan.redundant:
            loop = equation.loop.name
            counts[loop] = counts.get(loop, 0) + 1
        return MappingProxyType(counts)

    @lazy
    def mode_names(self) -> Mapping[str, tuple[str, ...]]:
        """Names of the assembly modes of each loop that has a closed form."""
        return mode_names(self.plan)

    @lazy
    def follows(self) -> bool:
        """Whether some loop has no closed form, so that its mode is that of a state nearby."""
        return any(block.iterates for block in self.plan.blocks)

    @lazy
    def reference(self) -> Array:
        """Active coordinates (n,) of the description's reference configuration [rad, m]."""
        return frozen(self.plan.reference.q[: len(self.active)])

    @lazy
    def reference_s(self) -> Array:
        """All coordinates (n_s,) of the reference configuration [rad, m]."""
        return frozen(self.plan.reference.q)

    @lazy
    def limits(self) -> Array:
        """Lower and upper limit (n, 2) of each active coordinate [rad, m], infinite if none.

        They are the limits of the description, narrowed to the `closing_range`, and to the limits
        of joints that follow this one alone.
        """
        limits = [self.description.joints[name].limits for name in self.active]
        ranges = [np.array(limits), self.closing_range, *self._limits_of_followers()]
        lower = np.max([one[:, 0] for one in ranges], axis=0)
        upper = np.min([one[:, 1] for one in ranges], axis=0)
        return frozen(np.stack([lower, upper], axis=1))

    def _limits_of_followers(self) -> Iterator[Array]:
        """What the limits of each joint that follows one active joint leave (n, 2) [rad, m]."""
        for name, mimic in self.description.mimics.items():
            followed = [joint for joint in mimic.multipliers if mimic.multipliers[joint]]
            if len(followed) != 1 or followed[0] not in self.active:
                continue
            ends = np.array(self.description.joints[name].limits)
            at_ends = (ends - mimic.offset) / mimic.multipliers[followed[0]]
            limits = np.tile([-np.inf, np.inf], (len(self.active), 1))
            limits[self.active.index(followed[0])] = sorted(at_ends.tolist())
            yield limits

    @lazy
    def effort_limits(self) -> Array:
        """Largest effort (n,) of each active joint [N m, N], infinite if none is given."""
        return frozen([self.description.joints[name].effort_limit for name in self.active])

    @lazy
    def velocity_limits(self) -> Array:
        """Largest rate (n,) of each active joint [rad/s, m/s], infinite if none is given."""
        return frozen([self.description.joints[name].velocity_limit for name in self.active])

    @lazy
    def power_limits(self) -> Array:
        """Largest power (n,) of the drive of each active joint [W], infinite if none is given."""
        return frozen([self.description.joints[name].power_limit for name in self.active])

    @lazy
    def closing_range(self) -> Array:
        """Range (n, 2) of each active coordinate in which the loops close [rad, m].

        Just inside its ends the robot closes and just outside it does not, with the other active
        coordinates at the reference. An end is infinite where nothing ends, or where it would move
        with the other active coordinates. It is infinite too where an iteration decides.
        """
        ranges = [independent_range(self.tree, self.plan, k) for k in range(len(self.active))]
        return frozen(np.reshape(ranges, (-1, 2)))

    def loop_distances(self, distances: Array) -> Array:
        """Distance to a singularity of each of `loops` (..., loops).

        Args:
            distances: distance of each block of the closure plan (..., blocks).
        """
        order, starts = self._loop_order
        # where each block is a loop there is nothing to do
        if not starts or order == starts:
            return distances
        by_loop = distances[..., order]
        nearest: Array = np.minimum.reduceat(by_loop, starts, axis=-1)
        return nearest

    @lazy
    def _loop_order(self) -> tuple[list[int], list[int]]:
        """The blocks, loop by loop as in `loops`, and where in them each loop begins."""
        names = [block.name for block in self.plan.blocks]
        order: list[int] = []
        starts: list[int] = []
        for loop in self.loops:
            starts.append(len(order))
            order += [k for k, name in enumerate(names) if name == loop]
        return order, starts

    @lazy
    def program_model(self) -> Model:
        """What programs compute with: the tree and the plan from the active coordinates."""
        idle = tuple(self.active.index(name) for name in self.idle)
        return Model(self.tree, self.plan, idle)

    def program_model_from(self, given: tuple[str, ...], near: Array | None = None) -> Model:
        """The same with other given coordinates.

        Args:
            given: n names of `coordinates`.
            near: a closed configuration (n_s,) [rad, m] at which the coordinates are judged where
                they do not determine the other ones at the reference.

        Raises:
            InputError: a name is unknown, or these coordinates do not determine the other ones.
        """
        if given not in self._models_by_given:
            self._models_by_given[given] = Model(self.tree, self._plan_near(given, near))
        return self._models_by_given[given]

    def _plan_near(self, given: tuple[str, ...], near: Array | None) -> ClosurePlan:
        try:
            return self._plan_from(given, self.reference_s)
        except InputError:
            if near is None:
                raise
        return self._plan_from(given, near)

    @lazy
    def _models_by_given(self) -> dict[tuple[str, ...], Model]:
        return {}

    def _plan_from(self, given: tuple[str, ...], s: Array) -> ClosurePlan:
        for name in given:
            if name not in self.coordinates:
                raise InputError(no_such_name("coordinate", name, self.coordinates))
        names = ", ".join(given)
        n = len(self.active)
        if len(given) != n:
            raise InputError(
                f"{names} ({counted(len(given), 'coordinate')}) cannot be given together:"
                f" the mechanism has {counted(n, 'degree')} of freedom; name {n}"
            )
        indices = [self.coordinates.index(name) for name in given]
        near = dict(enumerate(s.tolist()))
        try:
            return build_plan(self.tree, self.description, indices, near)
        except DescriptionError as error:
            raise InputError(f"{names} cannot be given together: {error.problem}") from error


def _exact_model(description: RobotDescription, tree: Tree) -> RobotModel:
    """The model of a description whose active joints are the independent ones."""
    try:
        return RobotModel(description, tree, build_plan(tree, description))
    except DescriptionError:
        beside = with_regular_reference(tree, description)
        if beside is None:
            raise
    tree = build_tree(beside)
    return RobotModel(beside, tree, build_plan(tree, beside))
