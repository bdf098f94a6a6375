"""The loads on the tree besides its actuators, as inputs of programs.

A pattern determines the kinds of loads. Their values are inputs, which may change from call to
call. Payloads and counterweights add to the inertia of a link. Wrenches act on links. Friction,
rotors behind gears and springs act along the joints.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from ..algebra.scalar import Scalar, Scalars, sqrt
from ..algebra.vector import ZERO3, Rotation, Vector, add, cross, transposed_matvec
from ..mechanism.configuration import Configuration
from ..mechanism.joint_velocity import (
    forces_along,
    joint_accelerations,
    joint_stretches,
    joint_velocities,
)
from ..mechanism.tree import Body, Tree
from .grouped import GroupedDynamics
from .parallel_axes import Layout
from .spanning import TreeDynamics, Wrench, total

FRICTION = ("viscous", "coulomb", "smoothing")
SPRINGS = ("stiffness", "rest", "preload")
# parameters of a body: m, m c (3), Jxx, Jxy, Jxz, Jyy, Jyz, Jzz about the link origin
INERTIAL = 10
WRENCH = 6  # force (3), moment (3)
ANY_GRAVITY = (True, True, True)


@dataclass(frozen=True)
class LoadPattern:
    """Pattern of the loads of a program.

    Attributes:
        payloads: indices of bodies with payloads.
        frames: (body, place on it (3,) [m]) where a wrench in base axes acts.
        links: bodies with a wrench in link axes about the link origin.
        friction: whether friction acts along the joints.
        drives: whether the joints turn rotors.
        springs: whether springs act along the joints.
        gravity: which components of gravity, in base axes, may differ from zero. Where it is along
            the first axis, code needs no angle of the first joint.
    """

    payloads: tuple[int, ...] = ()
    frames: tuple[tuple[int, Vector], ...] = ()
    links: tuple[int, ...] = ()
    friction: bool = False
    drives: bool = False
    springs: bool = False
    gravity: tuple[bool, bool, bool] = ANY_GRAVITY

    @property
    def sizes(self) -> dict[str, int]:
        """Lengths of the inputs that depend on the pattern."""
        sizes = {
            "payloads": INERTIAL * len(self.payloads),
            "frame_wrenches": WRENCH * len(self.frames),
            "link_wrenches": WRENCH * len(self.links),
        }
        return {name: size for name, size in sizes.items() if size}

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the inputs, in order."""
        names = tuple(self.sizes)
        if self.friction:
            names += FRICTION
        if self.drives:
            names += ("armature",)
        if self.springs:
            names += SPRINGS
        return names

    def under_any_gravity(self) -> LoadPattern:
        """The same pattern, with gravity along any axis."""
        return replace(self, gravity=ANY_GRAVITY)

    def gravity_of(self, values: Scalars) -> Vector:
        """Gravity (3,) [m/s^2] of an input, with constant zeros where the pattern has them.

        Programs without this input have no gravity.
        """
        if not values:
            return ZERO3
        along_x, along_y, along_z = self.gravity
        x, y, z = values
        return (x if along_x else 0.0, y if along_y else 0.0, z if along_z else 0.0)

    def key(self, program: str) -> str:
        """The cache key of a program with this pattern."""
        if self == NOTHING:
            return program
        return f"{program} {self}"


NOTHING = LoadPattern()


@dataclass(frozen=True)
class LoadValues:
    """The input vectors of a LoadPattern; those along s have one entry for each coordinate."""

    payloads: Scalars = ()
    frame_wrenches: Scalars = ()
    link_wrenches: Scalars = ()
    viscous: Scalars = ()
    coulomb: Scalars = ()
    smoothing: Scalars = ()
    armature: Scalars = ()
    stiffness: Scalars = ()
    rest: Scalars = ()
    preload: Scalars = ()


class LoadedTree:
    """The spanning tree at a configuration, with its loads.

    Attributes:
        pattern: pattern of the loads.
        values: values of the loads.
        configuration: all coordinates.
        tree: the tree, with payloads added to its links.
        applied: wrenches that act on bodies, by body.
    """

    def __init__(
        self,
        tree: Tree,
        pattern: LoadPattern,
        values: LoadValues,
        configuration: Configuration,
        layout: Layout | None = None,
    ) -> None:
        """Load the tree.

        Args:
            tree: the tree.
            pattern: pattern of the loads.
            values: values of the loads.
            configuration: all coordinates.
            layout: axes in which links have common ones. Forces along s then have the right
                projection R^T f, and are not those of the open tree.
        """
        self.pattern = pattern
        self.values = values
        self.configuration = configuration
        self.tree = TreeDynamics(_with_payloads(tree, pattern, values.payloads), configuration)
        self.applied = self._applied()
        self._grouped: GroupedDynamics | None = None
        if layout is not None:
            self._grouped = GroupedDynamics(self.tree.tree, layout, configuration)

    def forces(self, gravity: Vector, ds: Scalars, dds: Scalars) -> list[Scalar]:
        """Forces along s (n_s,) for the motion: inertia, gravity and all loads."""
        return self.with_joint_effects(self._of_bodies(gravity, ds, dds, self.applied), ds, dds)

    def without_loads(self, gravity: Vector, ds: Scalars, dds: Scalars) -> list[Scalar]:
        """Forces along s (n_s,) of inertia and gravity, payloads included."""
        return self._of_bodies(gravity, ds, dds, {})

    def _of_bodies(
        self, gravity: Vector, ds: Scalars, dds: Scalars, applied: Mapping[int, Wrench]
    ) -> list[Scalar]:
        if self._grouped is not None:
            return self._grouped.forces(gravity, ds, dds, applied)
        needed = self.tree.body_wrenches(gravity, ds, dds)
        return self.tree.along_joints(self.tree.transmitted(needed, applied))

    def joint_wrenches(self, gravity: Vector, ds: Scalars, dds: Scalars) -> list[Wrench]:
        """The wrenches that the joints of the open tree transmit to their bodies."""
        needed = self.tree.body_wrenches(gravity, ds, dds)
        return self.tree.transmitted(needed, self.applied)

    def inertial_forces(self, dds: Scalars) -> list[Scalar]:
        """M(s) s'', rotors included."""
        still = [0.0] * len(dds)
        return self.with_rotors(self.without_loads(ZERO3, still, dds), dds, still, still)

    def with_rotors(
        self, forces: Scalars, dds: Scalars, ds: Scalars, other: Scalars
    ) -> list[Scalar]:
        """Forces along s, plus those that accelerate the rotors.

        Args:
            forces: forces along s (n_s,).
            dds: s''.
            ds: s', for the bilinear term of ball and free joints.
            other: the second rates in that term: s' again, or those of a matrix column.
        """
        if not self.pattern.drives:
            return list(forces)
        accelerations = self._joint_accelerations(dds, ds, other)
        rotors = [self._rotor(k, value) for k, value in enumerate(accelerations)]
        return list(add(forces, self._along(rotors)))

    def with_joint_effects(self, forces: Scalars, ds: Scalars, dds: Scalars) -> list[Scalar]:
        """Forces along s, plus those for friction, rotors and springs."""
        velocities = joint_velocities(self.tree.tree, self.configuration, ds)
        accelerations = self._joint_accelerations(dds, ds, ds)
        effects: list[Scalar] = []
        for k, (velocity, value) in enumerate(zip(velocities, accelerations, strict=True)):
            effects.append(self._friction(k, velocity) + self._rotor(k, value))
        result: list[Scalar] = []
        terms = zip(forces, self._along(effects), self._spring_forces(), strict=True)
        for force, effect, spring in terms:
            result.append(force + effect + spring)
        return result

    def passive_forces(self, ds: Scalars) -> list[Scalar]:
        """Forces along s (n_s,) of the loads alone, at rates s'.

        Friction and springs, less the work of the wrenches.
        """
        forces = self.dissipative_forces(ds)
        return list(add(forces, self._spring_forces()))

    def dissipative_forces(self, ds: Scalars) -> list[Scalar]:
        """Forces along s (n_s,) of friction and wrenches, which change the energy of the robot."""
        nothing: list[Wrench] = [(ZERO3, ZERO3) for _ in self.tree.tree.bodies]
        forces = self.tree.along_joints(self.tree.transmitted(nothing, self.applied))
        velocities = joint_velocities(self.tree.tree, self.configuration, ds)
        friction = [self._friction(k, velocity) for k, velocity in enumerate(velocities)]
        return list(add(forces, self._along(friction)))

    def rotor_energy(self, ds: Scalars) -> Scalar:
        """Kinetic energy of the rotors."""
        energy: Scalar = 0.0
        velocities = joint_velocities(self.tree.tree, self.configuration, ds)
        for armature, velocity in zip(self.values.armature, velocities, strict=False):
            energy = energy + 0.5 * armature * velocity * velocity
        return energy

    def spring_energy(self) -> Scalar:
        """Energy stored in the springs, zero at rest position."""
        values = self.values
        energy: Scalar = 0.0
        if not self.pattern.springs:
            return energy
        stretches = joint_stretches(self.tree.tree, self.configuration)
        for k, stiffness in enumerate(values.stiffness):
            stretch = stretches[k] - values.rest[k]
            energy = energy + stretch * (0.5 * stiffness * stretch + values.preload[k])
        return energy

    def _joint_accelerations(self, dds: Scalars, ds: Scalars, other: Scalars) -> list[Scalar]:
        """Accelerations of the rotors: s'', or the angular acceleration in ball and free joints."""
        return joint_accelerations(self.tree.tree, self.configuration, dds, ds, other)

    def _along(self, forces: Scalars) -> list[Scalar]:
        """Forces along s from forces along joint velocities."""
        return forces_along(self.tree.tree, self.configuration, forces)

    def _friction(self, k: int, rate: Scalar) -> Scalar:
        """b q' + f sign(q'), the sign made smooth."""
        if not self.pattern.friction:
            return 0.0
        values = self.values
        sign = smooth_sign(rate, values.smoothing[k])
        return rate * values.viscous[k] + values.coulomb[k] * sign

    def _rotor(self, k: int, acceleration: Scalar) -> Scalar:
        if not self.pattern.drives:
            return 0.0
        return self.values.armature[k] * acceleration

    def _spring_forces(self) -> list[Scalar]:
        """Forces along s of the springs."""
        if not self.pattern.springs:
            return [0.0] * len(self.tree.tree.coordinates)
        values = self.values
        forces: list[Scalar] = []
        for k, coordinate in enumerate(joint_stretches(self.tree.tree, self.configuration)):
            stretch = coordinate - values.rest[k]
            forces.append(values.stiffness[k] * stretch + values.preload[k])
        return self._along(forces)

    def _applied(self) -> dict[int, Wrench]:
        """The wrenches, summed per body."""
        applied: dict[int, Wrench] = {}
        for n, body in enumerate(self.pattern.links):
            _add_to(applied, body, _wrench(self.values.link_wrenches, n))
        for n, (body, place) in enumerate(self.pattern.frames):
            force, moment = _wrench(self.values.frame_wrenches, n)
            rotation, _ = self.tree.pose(body)
            force = transposed_matvec(rotation, force)
            moment = transposed_matvec(rotation, moment)
            _add_to(applied, body, (force, add(moment, cross(place, force))))
        return applied


def _add_to(applied: dict[int, Wrench], body: int, wrench: Wrench) -> None:
    if body in applied:
        wrench = total(applied[body], wrench)
    applied[body] = wrench


def smooth_sign(rate: Scalar, smoothing: Scalar) -> Scalar:
    """q' / sqrt(q'^2 + v^2): the sign of a rate, made smooth over rates of about v."""
    return rate / sqrt(rate * rate + smoothing * smoothing)


def _wrench(values: Scalars, n: int) -> Wrench:
    """The n-th wrench of flat values."""
    fx, fy, fz, mx, my, mz = values[WRENCH * n : WRENCH * (n + 1)]
    return (fx, fy, fz), (mx, my, mz)


def _with_payloads(tree: Tree, pattern: LoadPattern, values: Scalars) -> Tree:
    bodies = list(tree.bodies)
    for n, body in enumerate(pattern.payloads):
        parameters = values[INERTIAL * n : INERTIAL * (n + 1)]
        bodies[body] = add_inertia(bodies[body], parameters)
    return replace(tree, bodies=tuple(bodies))


def add_inertia(body: Body, values: Scalars) -> Body:
    """The body with ten inertial parameters added to its own."""
    mass, moment, inertia = unpack_inertia(values)
    added = replace(body, mass=mass, first_moment=moment, inertia=inertia, second_moments=None)
    return replace(
        body,
        mass=body.mass + mass,
        first_moment=add(body.first_moment, moment),
        inertia=_sum(body.inertia, inertia),
        second_moments=_sum(body.about_origin, added.about_origin),
    )


def _sum(a: Rotation, b: Rotation) -> Rotation:
    x, y, z = (add(row_a, row_b) for row_a, row_b in zip(a, b, strict=True))
    return x, y, z


def unpack_inertia(values: Scalars) -> tuple[Scalar, Vector, Rotation]:
    """Mass, first moment and inertia about the origin from the ten parameters."""
    mass, hx, hy, hz, xx, xy, xz, yy, yz, zz = values
    inertia = (
        (xx, xy, xz),
        (xy, yy, yz),
        (xz, yz, zz),
    )
    return mass, (hx, hy, hz), inertia
