"""Stiffness of a frame at a state: compliance, deflections and who contributes how much."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from ..closed_state.state import ClosedState
from ..description.elasticity import Elasticity
from ..dynamics.loads import Loads
from ..errors import InputError, SingularityError
from ..ground.arrays import Array
from ..ground.check_arguments import require_type
from ..ground.check_arrays import real_array
from ..ground.suggestions import no_such_name
from .check_names import check_names
from .equilibrium import Equilibrium, equilibrium
from .load_columns import acting_wrenches, load_column
from .loaded.stiffness import LoadedStiffness, loaded_compliance
from .modes import Modes, modes_of
from .posed_tree import pose_tree
from .robot_interface import ElasticRobot
from .structure import build_structure

RIGID = 1e-18  # compliance over the largest one, at one length, below which a direction is rigid

MOVES = 1e-7  # share of a load's work that a free motion may do by rounding


@dataclass(frozen=True, eq=False)
class Deflection:
    """Displacement of a frame under loads, to first order.

    Attributes:
        displacement: (6,) of the frame's origin and its turn, base axes [m, rad].
        by_element: (6,) the part of each element in it.
        energy: stored [J].
        energy_by_element: stored in each element [J].
        links: displacement (6,) of each link's origin and its turn, base axes [m, rad].
    """

    displacement: Array
    by_element: Mapping[str, Array]
    energy: float
    energy_by_element: Mapping[str, float]
    links: Mapping[str, Array]

    @property
    def distance(self) -> float:
        """Distance by which the origin of the frame moves [m]."""
        return float(np.linalg.norm(self.displacement[:3]))


class Stiffness:
    """Stiffness of a frame at one state, with drives locked.

    Compliances are those to first order about the unloaded state: loads do not change the geometry
    that they act on; in `loaded` they do. Wrenches and displacements are those of the frame's
    origin in base axes, linear before angular.
    """

    def __init__(
        self,
        robot: ElasticRobot,
        state: ClosedState,
        elasticity: Elasticity | None = None,
        frame: str | None = None,
    ) -> None:
        """Stiffness of a robot at a state.

        Args:
            robot: the robot.
            state: one closed state.
            elasticity: compliance of drives, pins and links; that of the description if None.
            frame: name of the frame; the end effector if None.

        Raises:
            InputError: a name is unknown, the state is a batch or of another robot, or nothing is
                elastic.
            SingularityError: the drives do not hold the frame at this state.
        """
        require_type("state", state, ClosedState, "robot.close(u)")
        if not robot.owns(state):
            raise InputError("the state belongs to another robot; close the loops of this one")
        if state.u.ndim != 1:
            raise InputError("stiffness is that of one state; expected no batch")
        elasticity = robot.description.stiffness if elasticity is None else elasticity
        require_type("elasticity", elasticity, Elasticity, "Elasticity(drives={...})")
        if not elasticity:
            raise InputError(
                "nothing of the robot is elastic; give a section `stiffness` in its file,"
                " Elasticity(drives={...}) in Python, or --drive NAME=STIFFNESS on the command line"
            )
        check_names(robot, elasticity)
        self.frame = robot.end_effector if frame is None else frame
        if self.frame not in robot.frames:
            raise InputError(no_such_name("frame", self.frame, robot.frames))
        self._robot = robot
        self._state = state
        posed = pose_tree(robot.description, state)
        structure = build_structure(robot, posed, elasticity)
        self._solved = equilibrium(structure)
        self._pose, self._twists = structure.twists(self.frame)
        unit = self._pose.displacements(self._twists).T
        for column in unit.T:
            self._require_held(column, f"a force on {self.frame}")
        self._unit = self._solved.deformations(unit)

    @property
    def elements(self) -> tuple[str, ...]:
        """Names of the elastic elements, as `drives.q1`, in the order of the description."""
        return tuple(dict.fromkeys(self._solved.structure.springs))

    @property
    def position(self) -> Array:
        """Origin (3,) of the frame without load, base axes [m]."""
        return self._pose.origin

    @property
    def compliance(self) -> Array:
        """Displacement (6, 6) of the frame per wrench on it [m/N, rad/N, rad/(N m)]."""
        product: Array = self._unit.T @ self._unit
        return product

    @property
    def shares(self) -> Mapping[str, Array]:
        """The part (6, 6) of each element in the compliance; their sum is the compliance."""
        parts = {name: self._unit[rows] for name, rows in self._rows().items()}
        return MappingProxyType({name: part.T @ part for name, part in parts.items()})

    @property
    def stiffness(self) -> Array:
        """Wrench (6, 6) per displacement of the frame, the inverse of the compliance.

        Raises:
            SingularityError: the frame is rigid in some direction.
        """
        rigid = self.rigid_directions
        if len(rigid):
            raise SingularityError(
                f"{self.frame} is rigid in {len(rigid)} of 6 directions, so its stiffness is not"
                " finite; `compliance` and `stiffness_along` have an answer",
                loop="",
                distance=0.0,
            )
        scale = self._scale()
        scaled = self.compliance * np.outer(scale, scale)
        inverse: Array = np.linalg.inv(scaled) * np.outer(scale, scale)
        return 0.5 * (inverse + inverse.T)

    @property
    def rigid_directions(self) -> Array:
        """Wrenches (k, 6) of one unit [N, N m] that do not move the frame at all."""
        scale = self._scale()
        _, values, vectors = np.linalg.svd(self._unit * scale)
        values = np.concatenate([values, np.zeros(6 - len(values))]) ** 2
        rigid = vectors[values <= RIGID * values.max(initial=0.0)] * scale
        sizes = np.linalg.norm(rigid, axis=1, keepdims=True)
        directions: Array = rigid / sizes
        return directions

    def stiffness_along(self, direction: ArrayLike) -> float:
        """Force along a direction, or moment about it, per displacement along it.

        Args:
            direction: (3,) of a force, or (6,) of a force or a moment, in base axes; its length
                does not matter.

        Returns:
            [N/m] or [N m/rad]; infinity where the frame does not give way.
        """
        unit = np.zeros(6)
        values = real_array("direction", direction)
        if values.shape not in ((3,), (6,)) or not np.isfinite(values).all() or not values.any():
            raise InputError("direction: expected 3 or 6 finite numbers, not all zero")
        unit[: len(values)] = values / np.linalg.norm(values)
        scale = self._scale()
        largest = np.linalg.norm(self._unit * scale, ord=2) ** 2
        along = float(np.linalg.norm(self._unit @ unit) ** 2)
        if along <= RIGID * largest * float(np.linalg.norm(unit / scale)) ** 2:
            return float("inf")
        return 1.0 / along

    def under(self, wrench: ArrayLike) -> Deflection:
        """Deflection under a wrench on the frame alone.

        Args:
            wrench: (3,) a force, or (6,) with a moment about the frame's origin, base axes
                [N, N m].

        Raises:
            InputError: the wrench is not 3 or 6 finite numbers.
        """
        values = real_array("wrench", wrench)
        if values.shape not in ((3,), (6,)) or not np.isfinite(values).all():
            raise InputError(
                f"wrench has shape {values.shape}; expected 3 or 6 finite numbers, force then"
                " moment"
            )
        full = np.zeros(6)
        full[: len(values)] = values
        return self._deflection(self._unit @ full)

    def deflection(self, loads: Loads | None = None) -> Deflection:
        """Deflection under weights, payloads, wrenches and springs.

        Args:
            loads: the loads; those of the description if None.

        Raises:
            InputError: a load is a batch, or on a frame that is not there.
            SingularityError: the drives do not hold the loads.
        """
        loads = self._robot.loads if loads is None else loads
        require_type("loads", loads, Loads, "robot.loads")
        column = load_column(self._robot, self._solved.structure, loads)
        self._require_held(column, "the load")
        return self._deflection(self._solved.deformations(column[:, None])[:, 0])

    def modes(self, loads: Loads | None = None) -> Modes:
        """Natural frequencies and modes with drives locked.

        Args:
            loads: only payloads count; those of the description if None.

        Raises:
            InputError: nothing that moves has a mass.
        """
        loads = self._robot.loads if loads is None else loads
        require_type("loads", loads, Loads, "robot.loads")
        return modes_of(self._robot, self._solved, loads)

    def loaded(self, loads: Loads | None = None) -> LoadedStiffness:
        """Compliance about this state as the state under loads: their levers turn as it moves.

        The state is the pose that the robot has under the loads. They strain drives, pins and
        links. Chen and Kao (2000); Klimchik and Pashkevich (2017).

        Args:
            loads: weights, payloads and wrenches; those of the description if None.

        Raises:
            InputError: a load is a batch, or on a frame that is not there.
            SingularityError: the drives do not hold the loads, or the robot tips or buckles.
        """
        loads = self._robot.loads if loads is None else loads
        require_type("loads", loads, Loads, "robot.loads")
        structure = self._solved.structure
        column = load_column(self._robot, structure, loads)
        self._require_held(column, "the load")
        acting = acting_wrenches(self._robot, structure, loads)
        frame = self._pose.displacements(self._twists)
        return loaded_compliance(self._solved, acting, column, frame)

    def _deflection(self, deformations: Array) -> Deflection:
        """The deflection of deformations (n_e,) in coordinates of unit stiffness."""
        parts: dict[str, Array] = {}
        energies: dict[str, float] = {}
        for name, rows in self._rows().items():
            parts[name] = self._unit[rows].T @ deformations[rows]
            energies[name] = float(0.5 * deformations[rows] @ deformations[rows])
        return Deflection(
            displacement=self._unit.T @ deformations,
            by_element=MappingProxyType(parts),
            energy=float(0.5 * deformations @ deformations),
            energy_by_element=MappingProxyType(energies),
            links=MappingProxyType(link_displacements(self._solved, deformations)),
        )

    def _rows(self) -> dict[str, list[int]]:
        """Deformations of each element."""
        rows: dict[str, list[int]] = {}
        for k, name in enumerate(self._solved.structure.springs):
            rows.setdefault(name, []).append(k)
        return rows

    def _scale(self) -> Array:
        """Units (6,) of wrenches that are of one size: forces, and moments over a length."""
        length = self._solved.structure.length
        return np.array([1.0] * 3 + [length] * 3)

    def _require_held(self, load: Array, what: str) -> None:
        """Raise if a load does work on a motion that nothing holds."""
        if not self._solved.unheld(load) > MOVES:
            return
        free = self._solved.free
        moving = np.abs(free / self._solved.scale[:, None]).max(axis=1)
        names = [
            name for name, size in zip(self._robot.coordinates, moving, strict=True) if size > MOVES
        ]
        raise SingularityError(
            f"the drives do not hold {what} here: {', '.join(names)} move without any spring;"
            " expected drives on all of them, and a state that is not singular",
            loop="",
            distance=0.0,
        )


def link_displacements(solved: Equilibrium, deformations: Array) -> dict[str, Array]:
    """Displacement (6,) of the origin of each link and its turn, base axes [m, rad]."""
    structure = solved.structure
    full = np.concatenate([solved.joint_displacements(deformations), deformations])
    moved: dict[str, Array] = {}
    for link in structure.posed.description.links:
        pose, twists = structure.twists_of_link(link)
        moved[link] = pose.displacements(twists @ full[:, None])[:, 0]
    return moved


def stiffness_at(
    robot: ElasticRobot,
    state: ClosedState,
    elasticity: Elasticity | None = None,
    frame: str | None = None,
) -> Stiffness:
    """Stiffness of a frame at a state, with drives locked.

    Args:
        robot: the robot.
        state: one closed state.
        elasticity: compliance of drives, pins and links; that of the description if None.
        frame: name in `frames`; the end effector if None.

    Returns:
        Compliance, deflections and modes, computed when asked for.

    Raises:
        InputError: a name is unknown, the state is a batch or of another robot, or nothing is
            elastic.
        SingularityError: the drives do not hold the frame at this state.
    """
    return Stiffness(robot, state, elasticity, frame)
