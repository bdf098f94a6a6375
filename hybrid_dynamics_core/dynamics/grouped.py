"""Inverse dynamics of the spanning tree for closed loops, in axes that links have in common.

A moment about z of common axes acts along the coordinates of the link's absolute angle. These leave
out coordinates that follow from others. So forces f along s are not those of the open tree. Their
projection R^T f is the same. `TreeDynamics` has the plain equations; tests compare the two.

Axes turn with omega, and have the acceleration map U. A link that turns about their z at a rate p
relative to them has

    omega + p z,   U + 2 p omega~ z~ + p' z~ + p^2 z~ z~,

where ~ makes a vector the matrix of its cross product. Only a few entries of U change. Positions,
forces and moments need no rotation from link to link.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from ..algebra.scalar import Scalar, Scalars
from ..algebra.vector import (
    ZERO3,
    Rotation,
    Vector,
    add,
    cross,
    dot,
    matmul,
    matvec,
    scale,
    transpose,
    transposed_matvec,
    turn,
)
from ..mechanism.configuration import Configuration
from ..mechanism.joint_transform import joint_transform
from ..mechanism.tree import Tree
from .parallel_axes import BASE, Angle, Layout, Place
from .spanning import Wrench, acceleration_map, difference, total

_NOTHING: Wrench = (ZERO3, ZERO3)


class Motion(NamedTuple):
    """The motion of a link, in its axes.

    Attributes:
        omega: angular velocity (3,) [rad/s].
        alpha: angular acceleration (3,) [rad/s^2].
        change: acceleration map U (3, 3) [1/s^2]: a point at r from the origin accelerates by U r
            more than the origin.
        accel: acceleration of the link origin (3,) [m/s^2], gravity subtracted.
    """

    omega: Vector
    alpha: Vector
    change: Rotation
    accel: Vector


class GroupedDynamics:
    """The spanning tree at a configuration, its links in common axes.

    Attributes:
        tree: the tree.
        layout: axes, and places of the links in them.
    """

    def __init__(self, tree: Tree, layout: Layout, configuration: Configuration) -> None:
        self.tree = tree
        self.layout = layout
        self._configuration = configuration
        self._directions: dict[Angle, Vector] = {(): (1.0, 0.0)}

    def forces(
        self,
        gravity: Vector,
        ds: Scalars,
        dds: Scalars,
        applied: Mapping[int, Wrench] | None = None,
    ) -> list[Scalar]:
        """Forces along s whose projection is R^T (M s'' + C s' + g - those of applied wrenches).

        Args:
            gravity: (3,) [m/s^2], base axes.
            ds: s' (n_s,) [rad/s, m/s], which the closed loops allow.
            dds: s'' (n_s,) [rad/s^2, m/s^2], likewise.
            applied: wrenches that act on bodies about their origins, in link axes, by body.

        Returns:
            Forces (n_s,) [N m, N].
        """
        motions = self._motions(gravity, ds, dds)
        wrenches: list[Wrench] = []
        for k, motion in enumerate(motions):
            wrenches.append(self._needed(k, motion))
        for k, wrench in (applied or {}).items():
            in_axes = self._wrench_in_axes(k, wrench)
            wrenches[k] = difference(wrenches[k], in_axes)
        if any(body.is_compensated for body in self.tree.bodies):
            self._add_compensated(wrenches, gravity)
        return self._along_joints(wrenches)

    def _motions(self, gravity: Vector, ds: Scalars, dds: Scalars) -> list[Motion]:
        """The motions of all bodies, each in its axes."""
        base = Motion(ZERO3, ZERO3, (ZERO3, ZERO3, ZERO3), scale(-1.0, gravity))
        carried: dict[int, Motion] = {}  # motions of carriers, in the axes that they carry
        motions: list[Motion] = []
        for k, body in enumerate(self.tree.bodies):
            index = self.layout.places[k].axes
            axes = self.layout.axes[index]
            before = [base, *motions]  # the base is body -1
            parent = before[body.parent + 1]
            if axes.link == k:
                motions.append(self._in_link_axes(k, parent, ds, dds))
                continue
            if axes.is_common and index not in carried:
                carried[index] = self._entering(index, before[axes.carrier + 1])
            if self.layout.place(body.parent).axes != index:
                parent = carried[index]
            if body.is_revolute:
                motions.append(self._turning(k, parent, carried[index], ds, dds))
            else:
                motions.append(self._sliding(k, parent, ds, dds))
        return motions

    def _in_link_axes(self, k: int, parent: Motion, ds: Scalars, dds: Scalars) -> Motion:
        """The motion of a link that has axes of its own."""
        body = self.tree.bodies[k]
        index = self.layout.places[k].axes
        omega = self._into(index, parent.omega)
        alpha = self._into(index, parent.alpha)
        accel = self._into(index, self._at_joint(k, parent))
        rate = scale(ds[body.coordinate], body.axis)
        acceleration = scale(dds[body.coordinate], body.axis)
        carried = cross(omega, rate)
        alpha = add(alpha, add(acceleration, carried))
        omega = add(omega, rate)
        change = acceleration_map(omega, alpha)
        return Motion(omega, alpha, change, accel)

    def _entering(self, index: int, carrier: Motion) -> Motion:
        """The motion of a carrier, in axes that are fixed to it."""
        omega = self._into(index, carrier.omega)
        alpha = self._into(index, carrier.alpha)
        accel = self._into(index, carrier.accel)
        change = acceleration_map(omega, alpha)
        return Motion(omega, alpha, change, accel)

    def _turning(self, k: int, parent: Motion, axes: Motion, ds: Scalars, dds: Scalars) -> Motion:
        """The motion of a link that turns about z of its axes.

        Args:
            k: index of the link.
            parent: motion of its parent.
            axes: motion of the axes.
            ds: s' (n_s,) [rad/s, m/s].
            dds: s'' (n_s,) [rad/s^2, m/s^2].
        """
        angle = self.layout.places[k].angle
        rate = _along(angle, ds)
        acceleration = _along(angle, dds)
        x, y, z = axes.omega
        ax, ay, az = axes.alpha
        omega = (x, y, z + rate)
        alpha = (ax + rate * y, ay - rate * x, az + acceleration)
        inward = rate * (2.0 * z + rate)
        (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = axes.change
        change = (
            (xx - inward, xy - acceleration, xz),
            (yx + acceleration, yy - inward, yz),
            (zx + rate * (2.0 * x), zy + rate * (2.0 * y), zz),
        )
        accel = self._at_joint(k, parent)
        return Motion(omega, alpha, change, accel)

    def _sliding(self, k: int, parent: Motion, ds: Scalars, dds: Scalars) -> Motion:
        """The motion of a link that slides on its parent."""
        body = self.tree.bodies[k]
        axis = self._in_axes(k, body.axis)
        rate = scale(ds[body.coordinate], axis)
        coriolis = scale(2.0, cross(parent.omega, rate))
        acceleration = scale(dds[body.coordinate], axis)
        accel = add(acceleration, coriolis)
        at_joint = self._at_joint(k, parent)
        return parent._replace(accel=add(at_joint, accel))

    def _at_joint(self, k: int, parent: Motion) -> Vector:
        """The acceleration (3,) [m/s^2] of a parent at the origin of body k."""
        offset = self._offset(k)
        return add(parent.accel, matvec(parent.change, offset))

    def _offset(self, k: int) -> Vector:
        """The vector (3,) [m] from the parent's origin to that of body k, in axes of its seat."""
        body = self.tree.bodies[k]
        seat = self._seat(k)
        offset = matvec(seat.zero, body.translation)
        if not body.is_revolute:
            slide = self._configuration.q[body.coordinate]
            axis = matvec(self.layout.places[k].zero, body.axis)
            offset = add(offset, scale(slide, axis))
        return self._turned(seat, offset)

    def _seat(self, k: int) -> Place:
        """The place of the parent of body k, in the axes of k if they are common ones."""
        parent = self.tree.bodies[k].parent
        if self.layout.axes[self.layout.places[k].axes].link == k:
            return self.layout.place(parent)
        return self.layout.seat(k, parent)

    def _needed(self, k: int, motion: Motion) -> Wrench:
        """The wrench that a body needs for its motion, about its origin and in its axes.

        As in `spanning`, with the moment about z by itself. There the sum of the second moments
        about x and y counts, which no turn about z changes. Their difference counts only where the
        axes turn about x and y.
        """
        body = self.tree.bodies[k]
        h = self._in_axes(k, body.first_moment)
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = self._second_moments(k)
        wx, wy, _ = motion.omega
        _, _, az = motion.alpha
        u_x, u_y, u_z = motion.change
        of_origin = scale(body.mass, motion.accel)
        of_change = matvec(motion.change, h)
        force = add(of_origin, of_change)
        polar = self._polar(k)
        about_z = az * polar + wx * wy * (xx - yy) + (wy * wy - wx * wx) * xy
        moment = (
            dot(u_z, (xy, yy, yz)) - dot(u_y, (xz, yz, zz)),
            dot(u_x, (xz, yz, zz)) - dot(u_z, (xx, xy, xz)),
            about_z + u_y[2] * xz - u_x[2] * yz,
        )
        return force, add(moment, cross(h, motion.accel))

    def _second_moments_at_zero(self, k: int) -> Rotation:
        """Second moments of a body (3, 3) in its axes, at angle zero [kg m^2]."""
        zero = self.layout.places[k].zero
        about_origin = self.tree.bodies[k].about_origin
        half_turned = matmul(zero, about_origin)
        return matmul(half_turned, transpose(zero))

    def _polar(self, k: int) -> Scalar:
        """The moment of inertia of a body about z of its axes [kg m^2]."""
        (xx, _, _), (_, yy, _), _ = self._second_moments_at_zero(k)
        return xx + yy

    def _second_moments(self, k: int) -> Rotation:
        """Second moments of a body (3, 3) in its axes, at its angle [kg m^2]."""
        angle = self.layout.places[k].angle
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = at_zero = self._second_moments_at_zero(k)
        if not angle:
            return at_zero
        c, s = self._direction(angle)
        across = (xx - yy) * c - 2.0 * xy * s
        first = yy + across * c
        mixed = xy + across * s
        xz, yz = turn(c, s, (xz, yz))
        return (first, mixed, xz), (mixed, xx + yy - first, yz), (xz, yz, zz)

    def _add_compensated(self, wrenches: list[Wrench], gravity: Vector) -> None:
        """Cancel the compensated weight, since the accelerations include gravity for all mass."""
        directions = {0: gravity}
        for index in range(1, len(self.layout.axes)):
            axes = self.layout.axes[index]
            carrier = self.layout.place(axes.carrier)
            in_carrier = directions[carrier.axes]
            directions[index] = self._into(index, in_carrier)
        for k, body in enumerate(self.tree.bodies):
            if body.is_compensated:
                local = directions[self.layout.places[k].axes]
                first_moment = self._in_axes(k, body.compensated_moment)
                moment = cross(first_moment, local)
                weight = scale(body.compensated_mass, local), moment
                wrenches[k] = total(wrenches[k], weight)

    def _along_joints(self, wrenches: list[Wrench]) -> list[Scalar]:
        """Forces along s (n_s,) [N m, N] from the wrenches that bodies need; changes the list."""
        forces: list[Scalar] = [0.0] * len(self.tree.coordinates)
        on_carriers: dict[int, Wrench] = {}
        for k in range(len(wrenches) - 1, -1, -1):
            for index, wrench in on_carriers.items():
                if self.layout.axes[index].carrier == k:
                    out = self._wrench_out_of(index, wrench)
                    wrenches[k] = total(wrenches[k], out)
            self._add_forces(k, wrenches[k], forces)
            self._pass_on(k, wrenches, on_carriers)
        return forces

    def _add_forces(self, k: int, wrench: Wrench, forces: list[Scalar]) -> None:
        """Add the force or moment of a joint to those along s."""
        body = self.tree.bodies[k]
        place = self.layout.places[k]
        force, moment = wrench
        if place.turns:
            for coordinate, sign in place.angle:
                forces[coordinate] = forces[coordinate] + sign * moment[2]
            return
        transmitted = force
        if body.is_revolute:
            transmitted = moment
        along = dot(self._in_axes(k, body.axis), transmitted)
        forces[body.coordinate] = forces[body.coordinate] + along

    def _pass_on(self, k: int, wrenches: list[Wrench], on_carriers: dict[int, Wrench]) -> None:
        """Add the wrench of body k to that of its parent.

        The moment about z of common axes goes to their carrier at once: the drives of the angle
        hold it, whatever the links in between.
        """
        place = self.layout.places[k]
        parent = self.tree.bodies[k].parent
        force, moment = wrenches[k]
        if self.layout.axes[place.axes].link == k:
            force, moment = self._wrench_out_of(place.axes, (force, moment))
        before = on_carriers.get(place.axes, _NOTHING)
        if place.turns:
            x, y, z = moment
            moment = (x, y, 0.0)
            about_z = (0.0, 0.0, z)
            before = total(before, (ZERO3, about_z))
            on_carriers[place.axes] = before
        lever = cross(self._offset(k), force)
        passed = force, add(moment, lever)
        if self._seat(k).axes != self.layout.place(parent).axes:
            on_carriers[place.axes] = total(before, passed)
        elif parent != BASE:
            wrenches[parent] = total(wrenches[parent], passed)

    def _into(self, index: int, v: Vector) -> Vector:
        """A vector in axes of a carrier, in the axes that it carries."""
        axes = self.layout.axes[index]
        in_link = self._in_link(axes.carrier, v)
        if axes.link is None:
            return matvec(axes.rotation, in_link)
        rotation, _ = joint_transform(self.tree.bodies[axes.link], self._configuration)
        return transposed_matvec(rotation, in_link)

    def _out_of(self, index: int, v: Vector) -> Vector:
        """A vector in some axes, in those of their carrier."""
        axes = self.layout.axes[index]
        if axes.link is None:
            in_link = transposed_matvec(axes.rotation, v)
        else:
            rotation, _ = joint_transform(self.tree.bodies[axes.link], self._configuration)
            in_link = matvec(rotation, v)
        return self._in_axes(axes.carrier, in_link)

    def _wrench_out_of(self, index: int, wrench: Wrench) -> Wrench:
        """A wrench in some axes, in those of their carrier."""
        force, moment = wrench
        return self._out_of(index, force), self._out_of(index, moment)

    def _in_axes(self, k: int, v: Vector) -> Vector:
        """A vector in link axes of a body, in its axes."""
        place = self.layout.place(k)
        return self._turned(place, matvec(place.zero, v))

    def _wrench_in_axes(self, k: int, wrench: Wrench) -> Wrench:
        """A wrench in link axes of a body, in its axes."""
        force, moment = wrench
        return self._in_axes(k, force), self._in_axes(k, moment)

    def _in_link(self, k: int, v: Vector) -> Vector:
        """A vector in the axes of a body, in link axes."""
        place = self.layout.place(k)
        c, s = self._direction(place.angle)
        x, y, z = v
        x, y = turn(c, -s, (x, y))
        return transposed_matvec(place.zero, (x, y, z))

    def _turned(self, place: Place, v: Vector) -> Vector:
        """A vector turned about z by the angle of a place."""
        x, y, z = v
        c, s = self._direction(place.angle)
        x, y = turn(c, s, (x, y))
        return x, y, z

    def _direction(self, angle: Angle) -> Vector:
        """Cosine and sine of an absolute angle."""
        if angle not in self._directions:
            *before, (k, sign) = angle
            direction = self._direction(tuple(before))
            c = self._configuration.c[k]
            s = self._configuration.s[k]
            if sign < 0:
                s = -s
            for _ in range(abs(sign)):
                direction = turn(c, s, direction)
            self._directions[angle] = direction
        return self._directions[angle]


def _along(angle: Angle, values: Scalars) -> Scalar:
    """The rate of an absolute angle from those of the coordinates; accelerations likewise."""
    result: Scalar = 0.0
    for k, sign in angle:
        result = result + sign * values[k]
    return result
