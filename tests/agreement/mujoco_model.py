"""The same robot in MuJoCo: its tree, and its closures as equality constraints between sites."""

from __future__ import annotations

import mujoco
import numpy as np

from hybrid_dynamics_core.description import Closure, Joint, RobotDescription

ARM = 0.5  # [m] between the two connected points of a closure that ties axes
KINDS = {"revolute": "hinge", "prismatic": "slide"}


class MujocoRobot:
    """Open tree in MuJoCo, with Newton on the violation of its equality constraints.

    A pin or ball is a `connect`; a weld a `weld`; tied axes are two `connect` on the axis; a named
    parallelogram with three joints in the tree is two `joint` constraints. Coordinates s in the
    order `names`.
    """

    def __init__(self, robot: RobotDescription, names: tuple[str, ...]) -> None:
        self.robot = robot
        self.model = mujoco.MjModel.from_xml_string(as_mjcf(robot))
        self.data = mujoco.MjData(self.model)
        self.index = np.array([self.model.joint(n).dofadr[0] for n in names])
        self.size = len(names)

    def place(self, s: np.ndarray, ds: np.ndarray | None = None) -> None:
        """Put the model into a configuration, with rates."""
        self.data.qpos[self.index] = s
        self.data.qvel[self.index] = 0.0
        if ds is not None:
            self.data.qvel[self.index] = ds
        mujoco.mj_fwdPosition(self.model, self.data)
        mujoco.mj_fwdVelocity(self.model, self.data)

    def gaps(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """MuJoCo's violation of the equality constraints and their Jacobian (rows, n_s)."""
        self.place(s)
        rows = self.data.nefc
        if not rows:
            return np.zeros(0), np.zeros((0, self.size))
        jacobian = np.array(self.data.efc_J).reshape(rows, self.model.nv)
        return np.array(self.data.efc_pos[:rows]), jacobian[:, self.index]

    def close(self, s: np.ndarray, n_active: int) -> np.ndarray:
        """Newton on the passive coordinates from s, to rounding."""
        s = s.copy()
        for _ in range(50):
            gap, jacobian = self.gaps(s)
            step = np.linalg.lstsq(jacobian[:, n_active:], -gap, rcond=1e-9)[0]
            s[n_active:] += step
            if np.abs(step).max(initial=0.0) < 1e-14:
                break
        return s

    def velocity_map(self, s: np.ndarray, n_active: int) -> np.ndarray:
        """R = [E; -J_z^-1 J_u] of MuJoCo's constraint Jacobian, by least squares."""
        _, jacobian = self.gaps(s)
        passive = -np.linalg.lstsq(jacobian[:, n_active:], jacobian[:, :n_active], rcond=1e-9)[0]
        return np.vstack([np.eye(n_active), passive])

    def pose(self, s: np.ndarray, link: str) -> tuple[np.ndarray, np.ndarray]:
        """Rotation and origin of a link in the base frame."""
        self.place(s)
        body = self.data.body(link)
        return np.array(body.xmat).reshape(3, 3), np.array(body.xpos)

    def velocity(self, s: np.ndarray, ds: np.ndarray, link: str) -> tuple[np.ndarray, np.ndarray]:
        """Linear velocity of a link's origin and its angular velocity, base axes."""
        self.place(s, ds)
        twist = np.zeros(6)
        body = self.model.body(link).id
        mujoco.mj_objectVelocity(self.model, self.data, mujoco.mjtObj.mjOBJ_XBODY, body, twist, 0)
        return twist[3:], twist[:3]

    def tree_forces(self, s: np.ndarray, ds: np.ndarray, dds: np.ndarray) -> np.ndarray:
        """M s'' + C s' + g of the open tree (n_s,)."""
        self.place(s, ds)
        self.data.qacc[self.index] = dds
        forces = np.zeros(self.model.nv)
        mujoco.mj_rne(self.model, self.data, 1, forces)
        return forces[self.index]


def as_mjcf(robot: RobotDescription) -> str:
    """The robot as MJCF. Links without mass get next to none: MuJoCo wants some."""
    hung: dict[str, list[Joint]] = {}
    for joint in robot.joints.values():
        hung.setdefault(joint.parent, []).append(joint)
    ties = [_tie(robot, c) for c in robot.closures]
    return (
        '<mujoco><compiler angle="radian" boundmass="1e-12" boundinertia="1e-12"/>'
        f'<option gravity="{_text(robot.gravity)}" jacobian="dense"><flag'
        ' contact="disable"/></option>'
        f"<worldbody>{_sites(robot, robot.base)}{_bodies(robot, hung, robot.base)}</worldbody>"
        f"<equality>{''.join(ties)}</equality></mujoco>"
    )


def _bodies(robot: RobotDescription, hung: dict[str, list[Joint]], parent: str) -> str:
    text = ""
    for joint in hung.get(parent, []):
        link = robot.links[joint.child]
        i = link.inertia
        inertia = [1e-12] * 3 + [0.0] * 3
        if link.mass:
            inertia = [i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]]
        kind = KINDS[joint.type]
        text += (
            f'<body name="{link.name}" pos="{_text(joint.translation)}"'
            f' quat="{_text(_quaternion(joint.rotation))}">'
            f'<inertial pos="{_text(link.com)}" mass="{max(link.mass, 1e-12)!r}"'
            f' fullinertia="{_text(inertia)}"/>'
            f'<joint name="{joint.name}" type="{kind}" axis="{_text(joint.axis)}"/>'
            f"{_sites(robot, link.name)}{_bodies(robot, hung, link.name)}</body>"
        )
    return text


def _sites(robot: RobotDescription, link: str) -> str:
    """Two sites for each end of a closure on the link: at its point, and along its z axis."""
    text = ""
    for c in robot.closures:
        if c.link_a == link:
            text += _sites_of(f"{c.name}_a", c.point_a, c.rotation_a)
        if c.link_b == link:
            text += _sites_of(f"{c.name}_b", c.point_b, c.rotation_b)
    return text


def _sites_of(name: str, point: np.ndarray, rotation: np.ndarray) -> str:
    quaternion = _text(_quaternion(rotation))
    far = point + ARM * rotation[:, 2]
    return (
        f'<site name="{name}_near" pos="{_text(point)}" quat="{quaternion}"/>'
        f'<site name="{name}_far" pos="{_text(far)}" quat="{quaternion}"/>'
    )


def _tie(robot: RobotDescription, c: Closure) -> str:
    joints = _parallelogram(robot, c)
    if joints:
        return joints
    kind = "weld" if c.kind == "frame" else "connect"
    places = ("near", "far") if c.kind == "axis" else ("near",)
    return "".join(f'<{kind} site1="{c.name}_a_{p}" site2="{c.name}_b_{p}"/>' for p in places)


def _parallelogram(robot: RobotDescription, c: Closure) -> str:
    """A parallelogram whose tree has a stub, a first link and a coupler on it.

    Its angles are equal or opposite.
    """
    if c.assembly != "parallelogram":
        return ""
    hung = {j.child: j for j in robot.joints.values()}
    ends = [hung[link] for link in (c.link_a, c.link_b) if link in hung]
    if len(ends) != 2:
        return ""
    for coupler, stub in (ends, ends[::-1]):
        first = hung.get(coupler.parent)
        if first is not None and first.parent == stub.parent:
            return _equal(robot, first, stub, -1.0) + _equal(robot, first, coupler, 1.0)
    return ""


def _equal(robot: RobotDescription, one: Joint, other: Joint, way: float) -> str:
    """one + way * other stays, in turns about the common axis; the constant from the reference."""
    axis = one.axis  # in the frame that other's parent has
    if one.child != other.parent:
        axis = one.rotation @ one.axis
    sign = -1.0
    if axis @ (other.rotation @ other.axis) > 0.0:
        sign = 1.0
    slope = -way * sign
    constant = robot.reference[other.name] - slope * robot.reference[one.name]
    return (
        f'<joint joint1="{other.name}" joint2="{one.name}" polycoef="{constant!r} {slope!r} 0 0'
        ' 0"/>'
    )


def _quaternion(rotation: np.ndarray) -> np.ndarray:
    """(w, x, y, z), from the largest of the four."""
    r = rotation
    squares = np.array([1 + r[0, 0] + r[1, 1] + r[2, 2], 1 + r[0, 0] - r[1, 1] - r[2, 2]])
    squares = np.append(squares, [1 - r[0, 0] + r[1, 1] - r[2, 2], 1 - r[0, 0] - r[1, 1] + r[2, 2]])
    k = int(np.argmax(squares))
    rows = (
        [squares[0], r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]],
        [r[2, 1] - r[1, 2], squares[1], r[1, 0] + r[0, 1], r[0, 2] + r[2, 0]],
        [r[0, 2] - r[2, 0], r[1, 0] + r[0, 1], squares[2], r[2, 1] + r[1, 2]],
        [r[1, 0] - r[0, 1], r[0, 2] + r[2, 0], r[2, 1] + r[1, 2], squares[3]],
    )
    return np.array(rows[k]) / np.linalg.norm(rows[k])


def _text(values: np.ndarray | list[float]) -> str:
    return " ".join(repr(float(v)) for v in values)
