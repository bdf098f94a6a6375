"""What acts on the tree besides its actuators, as a program sees it: which loads there are is fixed, their values not.

Payloads and counterweights add to the inertia of a link; wrenches act on links; friction, rotors
behind gears and springs act along the joints. Every number is an input of the program, so that it
can change from call to call.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from ..algebra.scalar import Scalar, sqrt
from ..algebra.vector import Rotation, Vector, add, cross, transposed_matvec
from ..mechanism.configuration import Configuration
from ..mechanism.tree import Body, Tree
from .spanning import TreeDynamics, Wrench

FRICTION = ("viscous", "coulomb", "smoothing")
SPRINGS = ("stiffness", "rest", "preload")
INERTIAL = (
    10  # parameters of a body: m, m c (3), Jxx, Jxy, Jxz, Jyy, Jyz, Jzz about the link origin
)


@dataclass(frozen=True)
class LoadPattern:
    """Which loads a program takes.

    `payloads`: bodies with something fixed to them; `frames`: (body, place on it [m]) where a
    wrench in base axes acts; `links`: bodies with a wrench in link axes about the link origin; then
    what acts along the joints.
    """

    payloads: tuple[int, ...] = ()
    frames: tuple[tuple[int, Vector], ...] = ()
    links: tuple[int, ...] = ()
    friction: bool = False
    drives: bool = False
    springs: bool = False

    @property
    def sizes(self) -> dict[str, int]:
        """Lengths of the inputs that depend on the pattern."""
        counted = {
            "payloads": INERTIAL * len(self.payloads),
            "frame_wrenches": 6 * len(self.frames),
            "link_wrenches": 6 * len(self.links),
        }
        return {name: size for name, size in counted.items() if size}

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the inputs, in order."""
        names = tuple(self.sizes)
        names += FRICTION if self.friction else ()
        names += ("armature",) if self.drives else ()
        return names + (SPRINGS if self.springs else ())

    def key(self, program: str) -> str:
        """The name under which a program with this pattern is kept."""
        return program if self == NOTHING else f"{program} {self}"


NOTHING = LoadPattern()


@dataclass(frozen=True)
class LoadValues:
    """The inputs of a LoadPattern, each as long as it says (along s: one a coordinate)."""

    payloads: Sequence[Scalar] = ()
    frame_wrenches: Sequence[Scalar] = ()
    link_wrenches: Sequence[Scalar] = ()
    viscous: Sequence[Scalar] = ()
    coulomb: Sequence[Scalar] = ()
    smoothing: Sequence[Scalar] = ()
    armature: Sequence[Scalar] = ()
    stiffness: Sequence[Scalar] = ()
    rest: Sequence[Scalar] = ()
    preload: Sequence[Scalar] = ()


class LoadedTree:
    """The spanning tree at a configuration, with its loads."""

    def __init__(
        self, tree: Tree, pattern: LoadPattern, values: LoadValues, configuration: Configuration
    ) -> None:
        self.pattern, self.values, self.configuration = pattern, values, configuration
        self.tree = TreeDynamics(_laden(tree, pattern, values.payloads), configuration)
        self.applied = self._applied()

    def forces(self, gravity: Vector, ds: Sequence[Scalar], dds: Sequence[Scalar]) -> list[Scalar]:
        """Forces along s for the motion: inertia, gravity and all loads."""
        return self.added(self.tree.along_joints(self.joint_wrenches(gravity, ds, dds)), ds, dds)

    def joint_wrenches(
        self, gravity: Vector, ds: Sequence[Scalar], dds: Sequence[Scalar]
    ) -> list[Wrench]:
        """What the joints of the open tree pass on to their bodies."""
        return self.tree.transmitted(self.tree.body_wrenches(gravity, ds, dds), self.applied)

    def inertial_forces(self, dds: Sequence[Scalar]) -> list[Scalar]:
        """M(s) s'', rotors included."""
        still = [0.0] * len(dds)
        return self.with_rotors(self.tree.inverse_dynamics((0.0, 0.0, 0.0), still, dds), dds)

    def with_rotors(self, forces: Sequence[Scalar], dds: Sequence[Scalar]) -> list[Scalar]:
        """Forces along s with what the rotors take for s''."""
        return [f + self._rotor(k, dds[k]) for k, f in enumerate(forces)]

    def added(
        self, forces: Sequence[Scalar], ds: Sequence[Scalar], dds: Sequence[Scalar]
    ) -> list[Scalar]:
        """Forces along s with what friction, rotors and springs take."""
        result = []
        for k, force in enumerate(forces):
            result.append(
                force + self._friction(k, ds[k]) + self._rotor(k, dds[k]) + self._spring(k)
            )
        return result

    def passive_forces(self, ds: Sequence[Scalar]) -> list[Scalar]:
        """What the loads alone take along s, at rates s': friction, springs, less the work of the wrenches."""
        return [force + self._spring(k) for k, force in enumerate(self.dissipative_forces(ds))]

    def dissipative_forces(self, ds: Sequence[Scalar]) -> list[Scalar]:
        """Those of them that take energy out of the robot, or bring it in: friction and wrenches."""
        nothing: list[Wrench] = [((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)) for _ in self.tree.tree.bodies]
        wrenches = self.tree.along_joints(self.tree.transmitted(nothing, self.applied))
        return [force + self._friction(k, ds[k]) for k, force in enumerate(wrenches)]

    def rotor_energy(self, ds: Sequence[Scalar]) -> Scalar:
        """Kinetic energy of the rotors."""
        total: Scalar = 0.0
        for armature, rate in zip(self.values.armature, ds, strict=False):
            total = total + 0.5 * armature * rate * rate
        return total

    def spring_energy(self) -> Scalar:
        """Energy stored in the springs, zero at rest position."""
        v, total = self.values, 0.0
        for k, stiffness in enumerate(v.stiffness):
            stretch = self.configuration.q[k] - v.rest[k]
            total = total + stretch * (0.5 * stiffness * stretch + v.preload[k])
        return total

    def _friction(self, k: int, rate: Scalar) -> Scalar:
        """b q' + f sign(q'), the sign made smooth."""
        if not self.pattern.friction:
            return 0.0
        v = self.values
        return rate * v.viscous[k] + v.coulomb[k] * smooth_sign(rate, v.smoothing[k])

    def _rotor(self, k: int, acceleration: Scalar) -> Scalar:
        return self.values.armature[k] * acceleration if self.pattern.drives else 0.0

    def _spring(self, k: int) -> Scalar:
        if not self.pattern.springs:
            return 0.0
        v = self.values
        return v.stiffness[k] * (self.configuration.q[k] - v.rest[k]) + v.preload[k]

    def _applied(self) -> dict[int, Wrench]:
        """The wrenches, summed per body."""
        applied: dict[int, Wrench] = {}

        def put(body: int, force: Vector, moment: Vector) -> None:
            if body in applied:
                force, moment = add(applied[body][0], force), add(applied[body][1], moment)
            applied[body] = (force, moment)

        for n, body in enumerate(self.pattern.links):
            put(body, *_wrench(self.values.link_wrenches, n))
        for n, (body, place) in enumerate(self.pattern.frames):
            force, moment = _wrench(self.values.frame_wrenches, n)
            rotation, _ = self.tree.pose(body)
            force, moment = transposed_matvec(rotation, force), transposed_matvec(rotation, moment)
            put(body, force, add(moment, cross(place, force)))
        return applied


def smooth_sign(rate: Scalar, smoothing: Scalar) -> Scalar:
    """q' / sqrt(q'^2 + v^2): the sign of a rate, made smooth over rates of about v."""
    return rate / sqrt(rate * rate + smoothing * smoothing)


def _wrench(values: Sequence[Scalar], n: int) -> Wrench:
    return tuple(values[6 * n : 6 * n + 3]), tuple(values[6 * n + 3 : 6 * n + 6])


def _laden(tree: Tree, pattern: LoadPattern, values: Sequence[Scalar]) -> Tree:
    bodies = list(tree.bodies)
    for n, body in enumerate(pattern.payloads):
        bodies[body] = add_inertia(bodies[body], values[INERTIAL * n : INERTIAL * (n + 1)])
    return replace(tree, bodies=tuple(bodies))


def add_inertia(body: Body, values: Sequence[Scalar]) -> Body:
    """The body with inertial parameters (10) added to its own."""
    mass, moment, inertia = unpack_inertia(values)
    total: Rotation = tuple(add(a, b) for a, b in zip(body.inertia, inertia, strict=True))  # type: ignore[assignment]
    return replace(
        body, mass=body.mass + mass, first_moment=add(body.first_moment, moment), inertia=total
    )


def unpack_inertia(values: Sequence[Scalar]) -> tuple[Scalar, Vector, Rotation]:
    """Mass, first moment and inertia about the origin from the ten parameters."""
    mass, hx, hy, hz, xx, xy, xz, yy, yz, zz = values
    return mass, (hx, hy, hz), ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
