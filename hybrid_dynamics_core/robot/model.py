"""The constant part of a robot: description, spanning tree, closure plan, names and limits."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from ..algebra.charts import LEAVE, angles_in
from ..closed_state.assembly_modes import mode_names
from ..closure.drawn_flat import with_parallelograms
from ..closure.limit_range import limited_range
from ..closure.loop_length import measured_at_reference
from ..closure.mobility import find_mobility, with_mobility, with_regular_reference
from ..closure.plan import ClosurePlan, build_plan
from ..closure.printed.planar import DRAWN_EQUAL, snapped
from ..closure.printed.spherical import with_common_centres
from ..closure.toggle_range import independent_range
from ..description.model import Frame, JointType, RobotDescription
from ..description.parameters.written import carry
from ..errors import DescriptionError, InputError, UndecidedModeError
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
        description: the description, with the independent coordinates as active ones.
        tree: spanning tree of the links.
        plan: closure plan from the active coordinates.
        dependent_motors: motors that depend on the other ones, and so are passive coordinates.
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
        model = _movable_model(description)
        recentred = _in_better_charts(model)
        if recentred is not None:
            model = replace(_model(recentred), dependent_motors=model.dependent_motors)
        carry(model.description, description.written)
        return model

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
        """Names of active coordinates without a drive."""
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
    def middle_turns(self) -> list[int]:
        """Index in s of each ball or free joint's second angle, which is singular at +-pi/2."""
        return [middle for _, middle, _ in self.tree.turns]

    @lazy
    def frames(self) -> tuple[str, ...]:
        """Names of all frames and links."""
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
        """Names of the loops, or of groups that close together, in solving order.

        Names of a group are joined by +.
        """
        return tuple(dict.fromkeys(block.name for block in self.plan.blocks))

    @lazy
    def redundant_equations(self) -> Mapping[str, int]:
        """Number of redundant equations by loop."""
        counts: dict[str, int] = {}
        for equation in self.plan.redundant:
            loop = equation.loop.name
            counts[loop] = counts.get(loop, 0) + 1
        return MappingProxyType(counts)

    @lazy
    def measured_at_reference(self) -> bool:
        """Whether the lengths of the loops are those at the reference."""
        return measured_at_reference(self.tree, self.description, self.plan.loops)

    @lazy
    def mode_names(self) -> Mapping[str, tuple[str, ...]]:
        """Names of the assembly modes of each loop that has a closed form."""
        return mode_names(self.plan)

    @lazy
    def follows(self) -> bool:
        """Whether a loop has no closed form, so that its mode is that of a nearby state."""
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

        They are the intersection of three ranges: the limits of the description, the
        `closing_range`, and the range in which all joints that follow this one alone are within
        their limits.
        """
        limits = [self.description.joints[name].limits for name in self.active]
        described = np.reshape(limits, (-1, 2))
        ranges = [described, self.closing_range, *self._ranges_from_followers()]
        n = len(self.active)
        from_passive_joints = [limited_range(self.tree, self.plan, k) for k in range(n)]
        ranges.append(np.reshape(from_passive_joints, (-1, 2)))
        lower = np.max([one[:, 0] for one in ranges], axis=0)
        upper = np.min([one[:, 1] for one in ranges], axis=0)
        return frozen(np.stack([lower, upper], axis=1))

    def _ranges_from_followers(self) -> Iterator[Array]:
        """Ranges (n, 2) of the active coordinates [rad, m] from the limits of each follower.

        Only joints that follow a single active joint count.
        """
        for name, mimic in self.description.mimics.items():
            leaders = [joint for joint in mimic.multipliers if mimic.multipliers[joint]]
            if len(leaders) != 1 or leaders[0] not in self.active:
                continue
            leader = leaders[0]
            limits = np.array(self.description.joints[name].limits)
            leader_limits = (limits - mimic.offset) / mimic.multipliers[leader]
            ranges = np.tile([-np.inf, np.inf], (len(self.active), 1))
            # sorted: a negative multiplier swaps the ends
            ranges[self.active.index(leader)] = np.sort(leader_limits)
            yield ranges

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

        The robot closes inside of the range. The other active coordinates are at the reference.

        An end is infinite if there is none, if it depends on other active coordinates, or if the
        loop is closed by iteration.
        """
        ranges = [independent_range(self.tree, self.plan, k) for k in range(len(self.active))]
        return frozen(np.reshape(ranges, (-1, 2)))

    def loop_distances(self, distances: Array) -> Array:
        """Distance to a singularity of each of `loops` (..., loops).

        Args:
            distances: distance of each block of the closure plan (..., blocks).
        """
        order, starts = self._loop_order
        # blocks and loops may be the same
        if not starts or order == starts:
            return distances
        if distances.ndim == 1:
            listed = distances.tolist()  # plain floats are quicker than NumPy here
            return np.array([min([listed[k] for k in blocks]) for blocks in self._loop_blocks])
        by_loop = distances[..., order]
        nearest: Array = np.minimum.reduceat(by_loop, starts, axis=-1)
        return nearest

    @lazy
    def _loop_order(self) -> tuple[list[int], list[int]]:
        """Block indices in the order of `loops`, and the position at which each loop begins."""
        names = [block.name for block in self.plan.blocks]
        order: list[int] = []
        starts: list[int] = []
        for loop in self.loops:
            starts.append(len(order))
            order += [k for k, name in enumerate(names) if name == loop]
        return order, starts

    @lazy
    def _loop_blocks(self) -> list[list[int]]:
        """The blocks of each loop."""
        order, starts = self._loop_order
        ends = [*starts[1:], len(order)]
        return [order[start:end] for start, end in zip(starts, ends, strict=True)]

    @lazy
    def program_model(self) -> Model:
        """The model of programs: tree, and plan from the active coordinates."""
        idle = tuple(self.active.index(name) for name in self.idle)
        return Model(self.tree, self.plan, idle, tuple(self.description.closures))

    def program_model_from(
        self, given: tuple[str, ...], near: Array | None = None, charts: Array | None = None
    ) -> Model:
        """The model of programs for other given coordinates.

        Args:
            given: n names of `coordinates`.
            near: a closed configuration (n_s,) [rad, m], for coordinates that do not determine the
                other ones at the reference.
            charts: charts of ball and free joints there; those of the reference if None.

        Raises:
            InputError: a name is unknown, or the coordinates do not determine the other ones.
        """
        if given not in self._models_by_given:
            self._models_by_given[given] = Model(self.tree, self._plan_near(given, near, charts))
        return self._models_by_given[given]

    def _plan_near(
        self, given: tuple[str, ...], near: Array | None, charts: Array | None
    ) -> ClosurePlan:
        """The plan at the reference; if that fails, at the configuration `near`."""
        try:
            return self._plan_from(given, self.reference_s, self.tree)
        except InputError:
            if near is None:
                raise
        tree = self.tree
        if charts is not None:
            tree = replace(tree, charts=tuple(charts.tolist()))
        return self._plan_from(given, near, tree)

    @lazy
    def _models_by_given(self) -> dict[tuple[str, ...], Model]:
        return {}

    def _plan_from(self, given: tuple[str, ...], s: Array, tree: Tree) -> ClosurePlan:
        for name in given:
            if name not in self.coordinates:
                raise InputError(no_such_name("coordinate", name, self.coordinates))
        names = ", ".join(given) or "no names"
        n = len(self.active)
        if len(given) != n:
            raise InputError(
                f"{names} ({counted(len(given), 'coordinate')}) cannot be given together:"
                f" the mechanism has {counted(n, 'degree')} of freedom; name {n}"
            )
        indices = [self.coordinates.index(name) for name in given]
        near = dict(enumerate(s.tolist()))
        try:
            return build_plan(tree, self.description, indices, near)
        except DescriptionError as error:
            raise InputError(f"{names} cannot be given together: {error.problem}") from error


def _movable_model(description: RobotDescription) -> RobotModel:
    """The model of a description; if it cannot move, bars drawn nearly equal are made equal.

    A second rod beside a parallelogram holds it fast, unless opposite bars are equal.
    """
    exact = with_common_centres(snapped(description))
    try:
        return _model(exact)
    except DescriptionError:
        fitted = with_common_centres(snapped(description, equal_bars=DRAWN_EQUAL))
        if fitted.closures == exact.closures:
            raise
        try:
            return _model(fitted)
        except DescriptionError:
            pass  # the error of the file as it is says more
        raise


def _model(description: RobotDescription) -> RobotModel:
    """The model of a description, with loops made exactly planar."""
    tree = build_tree(description)
    if description.active_set != "motors":
        return _exact_model(description, tree)
    mobility = find_mobility(tree, description)
    description, tree = with_mobility(mobility)
    plan = build_plan(tree, description)
    return RobotModel(description, tree, plan, mobility.dependent)


def _in_better_charts(model: RobotModel) -> RobotDescription | None:
    """The description with ball joints in charts far from singular at the reference.

    None if the charts of the description are good.
    """
    reference = model.reference_s.copy()
    charts = dict(model.description.charts)
    for joint, turns, chart in zip(
        model.description.freely_turning, model.tree.turns, model.tree.charts, strict=True
    ):
        angles = reference[list(turns)]
        if abs(angles[1]) > LEAVE:
            charts[joint.name] = -chart
            reference[list(turns)] = angles_in(angles, chart, -chart)
    if charts == dict(model.description.charts):
        return None
    values = dict(zip(model.coordinates, reference.tolist(), strict=True))
    return replace(model.description, charts=charts, reference=values)


def _exact_model(description: RobotDescription, tree: Tree) -> RobotModel:
    """The model of a description whose active joints are the independent ones."""
    try:
        return _off_singular_places(RobotModel(description, tree, build_plan(tree, description)))
    except UndecidedModeError:
        drawn = [description.reference.get(name, 0.0) for name in tree.coordinates]
        flat = with_parallelograms(tree, description, np.array(drawn))
        if flat.closures == description.closures:
            raise
        return _exact_model(flat, build_tree(flat))
    except DescriptionError:
        # perhaps only the reference is open or singular: another one may be closed and regular
        regular = with_regular_reference(tree, description)
        if regular is None:
            raise
    tree = build_tree(regular)
    return RobotModel(regular, tree, build_plan(tree, regular))


def _off_singular_places(model: RobotModel) -> RobotModel:
    """The model with a regular reference, if the file has none and zero is a singular place."""
    regular = with_regular_reference(model.tree, model.description, model.reference_s)
    if regular is None:
        return model
    try:
        tree = build_tree(regular)
        return RobotModel(regular, tree, build_plan(tree, regular))
    except DescriptionError:
        return model  # what was found is on no mode that the file names
