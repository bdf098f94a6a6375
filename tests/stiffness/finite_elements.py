"""The same structure by finite elements: nodes of six freedoms, beams, ties with multipliers.

It shares nothing with the library but poses of links. Each link has a node at its joint and one
at each cut of its beams. Elements are the textbook beam of 12 freedoms. Joints, pins and drives
are springs or multipliers between nodes.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import scipy.linalg

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.description.model import Closure, Joint
from hybrid_dynamics_core.stiffness import Beam, Elasticity

UNIT = 1e8  # [N/m] by which stiffnesses are divided, so that ties and springs are of one size


def cross(r: np.ndarray) -> np.ndarray:
    return np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])


def at(r: np.ndarray) -> np.ndarray:
    """Displacement (6, 6) at an arm r of a rigid body, from that of its node."""
    moved = np.eye(6)
    moved[:3, 3:] = -cross(r)
    return moved


@dataclass
class Frame:
    """Nodes, springs and ties that are assembled."""

    nodes: list[np.ndarray] = field(default_factory=list)  # places
    springs: list[tuple[np.ndarray, dict]] = field(default_factory=list)  # matrix, parts by node
    ties: list[dict] = field(default_factory=list)  # row (6,) by node
    masses: list[tuple[np.ndarray, int, np.ndarray]] = field(default_factory=list)

    def node(self, place: np.ndarray) -> int:
        self.nodes.append(place)
        return len(self.nodes) - 1

    def spread(self, parts: dict) -> np.ndarray:
        """Rows over all freedoms, from parts (k, 6) by node; the ground is node -1."""
        rows = np.zeros((len(next(iter(parts.values()))), 6 * len(self.nodes)))
        for node, part in parts.items():
            if node >= 0:
                rows[:, 6 * node : 6 * node + 6] += part
        return rows

    def stiffness(self) -> np.ndarray:
        size = 6 * len(self.nodes)
        total = np.zeros((size, size))
        for matrix, parts in self.springs:
            rows = self.spread(parts)
            total += rows.T @ (matrix / UNIT) @ rows
        return total

    def constraints(self) -> np.ndarray:
        if not self.ties:
            return np.zeros((0, 6 * len(self.nodes)))
        return np.vstack([self.spread(parts) for parts in self.ties])

    def mass(self) -> np.ndarray:
        total = np.zeros((6 * len(self.nodes),) * 2)
        for matrix, node, arm in self.masses:
            rows = self.spread({node: at(arm)})
            total += rows.T @ matrix @ rows
        return total


class Model:
    """A robot at a state, with beams, drives and pins (radial, axial, tilt) of an Elasticity."""

    def __init__(self, robot: Robot, state, elasticity: Elasticity) -> None:
        self.robot = robot
        self.state = state
        self.elastic = elasticity
        self.frame = Frame()
        self.spots: dict[tuple[str, str], tuple[int, np.ndarray]] = {}  # node and arm
        description = robot.description
        self.pose = {description.base: (np.eye(3), np.zeros(3))}
        for link in description.links:
            pose = robot.forward_kinematics(state, link)
            self.pose[link] = (pose.rotation, pose.position)
        self._links()
        self._joints()
        for closure in description.closures:
            self._closure(closure)

    # -- links

    def _attachments(self, link: str) -> dict[tuple[str, str], np.ndarray]:
        description = self.robot.description
        found = {
            ("joint", j.name): j.translation
            for j in description.joints.values()
            if j.parent == link
        }
        for c in description.closures:
            for f in c.frames():
                if f.link == link:
                    found["closure", c.name] = f.translation
        found |= {
            ("frame", n): f.translation for n, f in description.frames.items() if f.link == link
        }
        if link in description.links:
            found["mass", ""] = description.links[link].com
        return found

    def _links(self) -> None:
        description = self.robot.description
        for link in (description.base, *description.links):
            rotation, origin = self.pose[link]
            root = -1 if link == description.base else self.frame.node(origin)
            self.spots[link, "root"] = (root, np.zeros(3))
            beam = self.elastic.links.get(link)
            for key, local in self._attachments(link).items():
                place = origin + rotation @ local
                self.spots[link, "/".join(key)] = (root, place - origin)
            if beam is not None:
                self._beam(link, beam, root)
            if link == description.base:
                continue
            data = description.links[link]
            node, arm = self.spots[link, "mass/"]
            matrix = np.zeros((6, 6))
            matrix[:3, :3] = data.mass * np.eye(3)
            matrix[3:, 3:] = rotation @ data.inertia @ rotation.T
            self.frame.masses.append((matrix, node, arm))

    def _beam(self, link: str, beam: Beam, root: int) -> None:
        """A beam from the origin, cut at the feet of all attachments."""
        rotation, origin = self.pose[link]
        tip = np.asarray(beam.to)
        length = np.linalg.norm(tip)
        x = tip / length
        y = np.cross(np.asarray(beam.z) / np.linalg.norm(beam.z), x)
        y /= np.linalg.norm(y)
        axes = rotation @ np.column_stack([x, y, np.cross(x, y)])
        shares = {}
        for key, local in self._attachments(link).items():
            shares[key] = round(min(max(local @ x / length, 0.0), 1.0), 12)
        node, last = root, 0.0
        for share in sorted({*shares.values(), 1.0}):
            if share > last:
                place = origin + rotation @ (share * tip)
                further = self.frame.node(place)
                self._element(node, further, axes, beam, (share - last) * length)
                node, last = further, share
            for key, own in shares.items():
                if own == share:
                    local = self._attachments(link)[key]
                    arm = rotation @ (local - share * tip)
                    self.spots[link, "/".join(key)] = (node, arm)

    def _element(self, i: int, j: int, axes: np.ndarray, beam: Beam, length: float) -> None:
        """The beam of 12 freedoms, Euler and Bernoulli."""
        s, L = beam.section, length
        k = np.zeros((12, 12))
        for a, b, axial in ((0, 6, beam.E * s.A / L), (3, 9, beam.G * s.J / L)):
            k[np.ix_([a, b], [a, b])] += axial * np.array([[1, -1], [-1, 1]])
        for v, t, sign, second in ((1, 5, 1, s.Iz), (2, 4, -1, s.Iy)):
            bend = (
                beam.E
                * second
                / L**3
                * np.array(
                    [
                        [12, 6 * L, -12, 6 * L],
                        [6 * L, 4 * L * L, -6 * L, 2 * L * L],
                        [-12, -6 * L, 12, -6 * L],
                        [6 * L, 2 * L * L, -6 * L, 4 * L * L],
                    ]
                )
            )
            turn = np.diag([1, sign, 1, sign])
            index = [v, t, v + 6, t + 6]
            k[np.ix_(index, index)] += turn @ bend @ turn
        to_local = scipy.linalg.block_diag(axes.T, axes.T)
        zero = np.zeros((6, 6))
        parts = {i: np.vstack([to_local, zero]), j: np.vstack([zero, to_local])}
        self.frame.springs.append((k, parts))

    # -- joints and closures

    def _gap(self, a: tuple[int, np.ndarray], b: tuple[int, np.ndarray], axes: np.ndarray) -> dict:
        """Displacement (6) of a against b in axes, by node."""
        turned = scipy.linalg.block_diag(axes.T, axes.T)
        parts: dict[int, np.ndarray] = {}
        for sign, (node, arm) in ((1.0, a), (-1.0, b)):
            parts[node] = parts.get(node, np.zeros((6, 6))) + sign * turned @ at(arm)
        return parts

    def _hold(self, gap: dict, stiffnesses: list) -> None:
        """Springs, ties (infinite) and free directions (zero) along and about three axes."""
        for direction, stiffness in enumerate(stiffnesses):
            row = {node: part[direction : direction + 1] for node, part in gap.items()}
            if stiffness == np.inf:
                self.frame.ties.append(row)
            elif stiffness:
                self.frame.springs.append((np.array([[stiffness]]), row))

    def _with_bearing(self, name: str, stiffnesses: list) -> list:
        bearing = self.elastic.pins.get(name)
        if bearing is None:
            return stiffnesses
        given = (bearing.radial, bearing.radial, bearing.axial, bearing.tilt, bearing.tilt, None)
        return [s if g is None else g for s, g in zip(stiffnesses, given, strict=True)]

    def _joints(self) -> None:
        description = self.robot.description
        for joint in description.joints.values():
            rotation, origin = self.pose[joint.child]
            axis = rotation @ joint.axis
            side = np.linalg.svd(axis[None])[2][1]
            axes = np.column_stack([side, np.cross(axis, side), axis])
            node, arm = self.spots[joint.parent, f"joint/{joint.name}"]
            place = (self.frame.nodes[node] if node >= 0 else np.zeros(3)) + arm
            parent = (node, arm + origin - place)  # of a slide: carried to where the child is
            gap = self._gap(self.spots[joint.child, "root"], parent, axes)
            own = 5 if joint.type == "revolute" else 2
            stiffnesses = self._with_bearing(joint.name, [np.inf] * 6)
            drive = self.elastic.drive(joint.name)
            stiffnesses[own] = 0.0
            if joint.name in self.robot.all_drives:
                stiffnesses[own] = np.inf if drive is None else drive.stiffness
            self._hold(gap, stiffnesses)

    def _closure(self, closure: Closure) -> None:
        rotation, origin = self.pose[closure.link_a]
        axes = rotation @ closure.rotation_a
        held = {"planar": 2, "point": 3, "axis": 5, "frame": 6}[closure.kind]
        if closure.kind == "planar":
            joint = self._turning_in(closure)
            normal = self.pose[joint.child][0] @ joint.axis
            side = np.linalg.svd(normal[None])[2][1]
            axes = np.column_stack([side, np.cross(normal, side), normal])
        place = origin + rotation @ closure.point_a
        a = self.spots[closure.link_a, f"closure/{closure.name}"]
        node, _ = self.spots[closure.link_b, f"closure/{closure.name}"]
        b = (node, place - (self.frame.nodes[node] if node >= 0 else np.zeros(3)))
        stiffnesses = [np.inf] * held + [0.0] * (6 - held)
        self._hold(self._gap(a, b, axes), self._with_bearing(closure.name, stiffnesses))

    def _turning_in(self, closure: Closure) -> Joint:
        """A revolute joint of the loop of a closure."""
        to = self.robot.description.joint_to()
        paths = []
        for end in (closure.link_a, closure.link_b):
            path = []
            link = end
            while link in to:
                path.append(to[link])
                link = to[link].parent
            paths.append(path)
        a, b = paths
        return next(j for j in (*a, *b) if j.type == "revolute" and not (j in a and j in b))

    # -- answers

    def compliance(self) -> np.ndarray:
        """Displacement (6, 6) of the end effector per wrench on it."""
        frame = self.robot.description.frames["end_effector"]
        node, arm = self.spots[frame.link, "frame/end_effector"]
        return self.displacements(self.frame.spread({node: at(arm)}))

    def displacements(self, rows: np.ndarray) -> np.ndarray:
        stiffness, ties = self.frame.stiffness(), self.frame.constraints()
        count = len(ties)
        system = np.block([[stiffness, ties.T], [ties, np.zeros((count, count))]])
        loads = np.vstack([rows.T, np.zeros((count, len(rows)))])
        moved = np.linalg.lstsq(system, loads, rcond=1e-13)[0]
        return rows @ moved[: rows.shape[1]] / UNIT

    def frequencies(self) -> np.ndarray:
        """Natural frequencies [Hz], those of finite size."""
        ties = self.frame.constraints()
        basis = scipy.linalg.null_space(ties, rcond=1e-10) if len(ties) else np.eye(ties.shape[1])
        mass = basis.T @ self.frame.mass() @ basis
        stiffness = basis.T @ self.frame.stiffness() @ basis
        values = scipy.linalg.eigh(mass, stiffness, eigvals_only=True)[::-1]
        values = values[values > 1e-9 * values[0]]
        return np.sqrt(UNIT / values) / (2 * np.pi)
