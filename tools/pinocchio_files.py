"""URDF, URDF+ and robot.yaml files in Pinocchio, to be compared with the library's robots.

Pinocchio builds the spanning tree from the URDF text. What ties joints or links is read here once
more, from the file: <mimic>, <loop>, <coupling> and pairs of frames, and rotors too. So a wrong
reading of the library's shows as a gap. `difference` compares at one closed state.
"""

from __future__ import annotations

import os
import sys
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import yaml

LOCAL = pin.ReferenceFrame.LOCAL
AXES = {"X": pin.JointModelRX, "Y": pin.JointModelRY, "Z": pin.JointModelRZ}
DRAKE = "{http://drake.mit.edu}"
_STEP = 1e-30  # of a complex step


@dataclass(frozen=True)
class Tie:
    """Two frames of the tree that coincide: "point", "axis" (of x) or "frame"."""

    name: str
    kind: str
    ends: tuple[tuple[int, pin.SE3], tuple[int, pin.SE3]]


class PinocchioFile:
    """Tree, ties and couplings of a file.

    Args:
        file: URDF, or a robot.yaml beside its URDF.

    Raises:
        ValueError: Pinocchio does not take it.
    """

    def __init__(self, file: Path) -> None:
        given = {} if file.suffix == ".urdf" else yaml.safe_load(file.read_text(encoding="utf-8"))
        urdf = file if file.suffix == ".urdf" else urdf_beside(file)
        self.root = ET.fromstring(urdf.read_bytes())  # noqa: S314  a file that the user names
        completed(self.root)
        with Quiet():
            self.model = pin.buildModelFromXML(ET.tostring(self.root, encoding="unicode"))
        kinds = dict(zip(given.get("joint_name") or [], given.get("joint_type") or [], strict=True))
        if kinds:
            self.replace(kinds)
        self.data = self.model.createData()
        self.ties = self.pairs(given) if given else self.loops()
        self.motors = set(given.get("name_mot") or [])

    def replace(self, kinds: dict[str, str]) -> None:
        """Joints become spherical, universal or fixed, as Gepetto's loader makes them."""
        old, new = self.model, pin.Model()
        ends = dict(zip(old.names, old.names, strict=True))  # last joint of each old one
        for k in range(1, old.njoints):
            name = old.names[k]
            parent = new.getJointId(ends[old.names[old.parents[k]]])
            joint, place, kind = old.joints[k], old.jointPlacements[k], kinds.get(name, "")
            if kind == "SPHERICAL":
                joint = pin.JointModelSpherical()
            elif kind.startswith("U"):
                first, second = kind[-2:]
                parent = new.addJoint(parent, AXES[first](), place, f"{name}_{first}")
                joint, place, ends[name] = AXES[second](), pin.SE3.Identity(), f"{name}_{second}"
            made = new.addJoint(parent, joint, place, ends[name])
            new.appendBodyToJoint(made, old.inertias[k], pin.SE3.Identity())
        for frame in list(old.frames)[1:]:
            number = new.getJointId(ends[old.names[frame.parentJoint]])
            new.addFrame(pin.Frame(frame.name, number, frame.placement, frame.type), False)
        fixed = [new.getJointId(name) for name, kind in kinds.items() if kind == "FIXED"]
        self.model = pin.buildReducedModel(new, fixed, pin.neutral(new)) if fixed else new

    def rotors(self) -> Any:
        """Inertia (nv,) of rotors behind gears, seen from the joints."""
        inertia = np.zeros(self.model.nv)
        for transmission in self.root.iter("transmission"):
            name = getattr(transmission.find("joint"), "attrib", {}).get("name", "")
            rotor = transmission.find(f"actuator/{DRAKE}rotor_inertia")
            gear = transmission.find(f"actuator/{DRAKE}gear_ratio")
            if rotor is not None and self.model.existJointName(name):
                ratio = 1.0 if gear is None else float(gear.get("value"))
                joint = self.model.joints[self.model.getJointId(name)]
                inertia[joint.idx_v] = float(rotor.get("value")) * ratio**2
        return inertia

    # -- ties and couplings, from the file

    def pairs(self, given: dict[str, Any]) -> list[Tie]:
        """The pairs of a robot.yaml."""
        pairs = given.get("closed_loop") or []
        kinds = given.get("type") or ["6d"] * len(pairs)
        ties = []
        for k, (names, kind) in enumerate(zip(pairs, kinds, strict=True)):
            ends = tuple(self.frame(name) for name in names)
            what = "point" if kind.lower() == "3d" else "frame"
            ties.append(Tie(f"pair {k + 1}", what, ends))
        return ties

    def loops(self) -> list[Tie]:
        """The loops of a URDF+."""
        kinds = {"revolute": "axis", "continuous": "axis", "fixed": "frame", "spherical": "point"}
        ties = []
        for loop in self.root.iter("loop"):
            axis = loop.find("axis")
            direction = [1.0, 0.0, 0.0] if axis is None else numbers(axis.get("xyz"))
            turned = pin.SE3(x_to(direction), np.zeros(3))
            ends = []
            for tag in ("predecessor", "successor"):
                end = loop.find(tag)
                number, place = self.frame(end.get("link"))
                ends.append((number, place * pose_of(end.find("origin")) * turned))
            ties.append(Tie(loop.get("name"), kinds[loop.get("type")], tuple(ends)))
        return ties

    def couplings(self) -> list[tuple[str, dict[str, float], float]]:
        """Name, coefficient of each joint, and constant of every sum that is zero."""
        sums = []
        for joint in self.root.iter("joint"):
            mimic = joint.find("mimic")
            if mimic is None or joint.get("type") == "fixed" or joint.get("name") in self.motors:
                continue
            name, source = joint.get("name"), mimic.get("joint")
            coefficients = {name: 1.0, source: -float(mimic.get("multiplier", 1.0))}
            sums.append((f"mimic {name}", coefficients, -float(mimic.get("offset", 0.0))))
        for element in self.root.iter("coupling"):
            ratio = float(element.find("ratio").get("value"))
            before, after = (element.find(tag).get("link") for tag in ("predecessor", "successor"))
            coefficients = dict.fromkeys(self.chain(before, after), -ratio)
            for joint in self.chain(after, before):
                coefficients[joint] = coefficients.get(joint, 0.0) + 1.0
            sums.append((f"coupling {element.get('name')}", coefficients, 0.0))
        return sums

    def chain(self, link: str, other: str) -> list[str]:
        """Moving joints from a link to the last that another one shares, or to the base."""
        path = self.to_base(link)
        alone = [joint for joint in path if joint not in self.to_base(other)]
        return alone or path

    def to_base(self, link: str) -> list[str]:
        """Moving joints from a link to the base."""
        number, path = self.frame(link)[0], []
        while number:
            path.append(self.model.names[number])
            number = self.model.parents[number]
        return path

    def frame(self, name: str) -> tuple[int, pin.SE3]:
        """Joint and placement of a link or frame."""
        frame = self.model.frames[self.model.getFrameId(name)]
        return frame.parentJoint, frame.placement


class Motion:
    """Positions, velocities and accelerations of a robot's state in Pinocchio.

    Attributes:
        q: (nq,) configuration.
        rates: (nv, n_s) velocity from the rates of the robot's coordinates.
        drift: (nv,) acceleration without those of the coordinates.
    """

    def __init__(self, robot: Any, file: PinocchioFile, state: Any) -> None:
        self.robot, self.model = robot, file.model
        self.columns = {name: k for k, name in enumerate(robot.coordinates)}
        self.s, self.ds = state.s, state.ds
        self.q = pin.neutral(self.model)
        self.rates = np.zeros((self.model.nv, len(state.s)))
        self.drift = np.zeros(self.model.nv)
        self.poses = {}
        for joint in robot.description.freely_turning:
            self.poses[joint.name] = robot.joint_pose(state, joint.name)
        for number in range(1, self.model.njoints):
            self.place(self.model.names[number], self.model.joints[number])

    def place(self, name: str, joint: Any) -> None:
        """Set the coordinates of one joint."""
        if joint.nv == 1:
            self.place_one(name, joint)
        elif joint.nv == 6:
            self.place_free(name, joint)
        elif joint.shortname() == "JointModelSpherical":
            turns = [self.columns[f"{name}_{letter}"] for letter in "XYZ"]
            self.place_turns(joint.idx_q, joint.idx_v, turns)
        else:
            raise NotComparedError(f"{joint.shortname()} is not compared")

    def place_one(self, name: str, joint: Any) -> None:
        """A joint of one freedom, whose angle may be a pair of cosine and sine."""
        if name not in self.columns:
            raise NotComparedError(f"there is no coordinate {name}")
        value = self.s[self.columns[name]]
        if joint.nq == 2:
            self.q[joint.idx_q : joint.idx_q + 2] = np.cos(value), np.sin(value)
        else:
            self.q[joint.idx_q] = value
        self.rates[joint.idx_v, self.columns[name]] = 1.0

    def place_free(self, name: str, joint: Any) -> None:
        """A free joint: its velocity is the child's twist in its own axes."""
        slides = [self.columns[f"{name}_{letter}"] for letter in "xyz"]
        turns = [self.columns[f"{name}_r{letter}"] for letter in "xyz"]
        pose = self.poses[name]
        self.q[joint.idx_q : joint.idx_q + 3] = pose.position
        omega = self.place_turns(joint.idx_q + 3, joint.idx_v + 3, turns)
        linear = slice(joint.idx_v, joint.idx_v + 3)
        self.rates[linear, slides] = pose.rotation.T
        self.drift[linear] = -np.cross(omega, pose.rotation.T @ self.ds[slides])

    def place_turns(self, position: int, velocity: int, turns: list[int]) -> Any:
        """Turns about x, y and z in a row as a quaternion; their angular velocity."""
        angles, rates = self.s[turns], self.ds[turns]
        rotation = about(0, angles[0]) @ about(1, angles[1]) @ about(2, angles[2])
        quaternion = pin.Quaternion(np.real(rotation))
        self.q[position : position + 4] = quaternion.coeffs()
        angular = slice(velocity, velocity + 3)
        self.rates[angular, turns] = np.real(velocity_map(angles))
        change = np.imag(velocity_map(angles + 1j * _STEP * rates)) / _STEP
        self.drift[angular] = change @ rates
        return self.rates[angular, turns] @ rates


class NotComparedError(Exception):
    """Pinocchio means something else by the file, or has no word for it."""


def difference(robot: Any, file: PinocchioFile, state: Any) -> tuple[float, float]:
    """Largest relative difference of mass matrix, weight and inverse dynamics, and largest gap."""
    motion = Motion(robot, file, state)
    model, data, q = file.model, file.data, motion.q
    to_u = motion.rates @ state.R
    upper = np.triu(pin.crba(model, data, q))
    mass = upper + np.triu(upper, 1).T + np.diag(file.rotors())
    differences = [relative(robot.minimal_form(state)[0], to_u.T @ mass @ to_u)]
    still = robot.close(state.u, near=state)
    held = robot.inverse_dynamics(still, np.zeros(len(state.u)))
    weight = pin.computeGeneralizedGravity(model, data, q)
    differences.append(relative(held, to_u.T @ weight))
    velocity = motion.rates @ state.ds
    given = np.ones(len(state.u))
    acceleration = motion.rates @ robot.accelerations(state, given) + motion.drift
    forces = pin.rnea(model, data, q, velocity, acceleration) + file.rotors() * acceleration
    forces += np.array(model.damping).ravel() * velocity
    efforts = robot.inverse_dynamics(state, given)
    differences.append(relative(efforts, to_u.T @ forces))
    gaps = [0.0]
    for tie in file.ties:
        gaps.extend(gaps_of(file, tie, q, velocity, acceleration))
    for _, coefficients, constant in file.couplings():
        gaps.append(gap_of_sum(motion, coefficients, constant))
    return max(differences), max(gaps)


def gap_of_sum(motion: Motion, coefficients: Any, constant: float) -> float:
    """What a coupling misses in positions and rates."""
    values, rates = constant, 0.0
    for name, coefficient in coefficients.items():
        values += coefficient * motion.s[motion.columns[name]]
        rates += coefficient * motion.ds[motion.columns[name]]
    return max(abs(values), abs(rates))


def gaps_of(file: PinocchioFile, tie: Tie, q: Any, velocity: Any, acceleration: Any) -> list[float]:
    """What a tie misses in position, velocity and acceleration, over its size there."""
    model, data = file.model, file.data
    pin.forwardKinematics(model, data, q, velocity, acceleration)
    one, other = (moving_frame(data, *end) for end in tie.ends)
    rows = [one.point - other.point]
    if tie.kind != "point":
        rows.append(one.x - other.x)
    if tie.kind == "frame":
        rows.append(one.y - other.y)
    scale = np.maximum(1.0, np.abs(one.point).max(axis=1))
    gaps = [np.abs(row).max(axis=1) / scale for row in rows]
    return np.ravel(gaps).tolist()


@dataclass(frozen=True)
class MovingFrame:
    """Origin and two axes of a frame in the world, with two derivatives each: (3, 3)."""

    point: Any
    x: Any
    y: Any


def moving_frame(data: Any, number: int, place: pin.SE3) -> MovingFrame:
    """A frame of a moving body."""
    body = data.oMi[number]
    turn = body.rotation
    if number:
        omega = turn @ data.v[number].angular
        alpha = turn @ data.a[number].angular
        rate = turn @ data.v[number].linear
        change = turn @ data.a[number].linear + np.cross(omega, rate)
    else:
        omega = alpha = rate = change = np.zeros(3)
    arm = turn @ place.translation
    turned = turn @ place.rotation
    point = moved(arm, omega, alpha) + np.array([body.translation, rate, change])
    axes = [moved(turned[:, k], omega, alpha) for k in range(2)]
    return MovingFrame(point, *axes)


def moved(arm: Any, omega: Any, alpha: Any) -> Any:
    """A vector fixed in a body, with two derivatives: (3, 3)."""
    rate = np.cross(omega, arm)
    return np.array([arm, rate, np.cross(alpha, arm) + np.cross(omega, rate)])


# -- rotations and texts


def completed(root: Any) -> None:
    """What URDF asks for and people leave out: links that joints name, and limits."""
    links = {link.get("name") for link in root.findall("link")}
    for joint in root.findall("joint"):
        parent = joint.find("parent")
        if parent is not None and parent.get("link") not in links:
            links.add(parent.get("link"))
            ET.SubElement(root, "link", name=parent.get("link"))
        limit = joint.find("limit")
        if limit is None:
            limit = ET.SubElement(joint, "limit")
        for name, value in (("effort", "1e9"), ("velocity", "1e9")):
            limit.attrib.setdefault(name, value)


def about(axis: int, angle: Any) -> Any:
    """A turn about a coordinate axis, also by a complex angle."""
    c, s = np.cos(angle), np.sin(angle)
    rows = [[1, 0, 0], [0, c, -s], [0, s, c]]
    return np.roll(np.roll(np.array(rows), axis, 0), axis, 1)


def velocity_map(angles: Any) -> Any:
    """From rates of turns about x, y and z in a row to the angular velocity in child axes."""
    y, z = about(1, angles[1]), about(2, angles[2])
    unit = np.eye(3)
    return np.column_stack([z.T @ y.T @ unit[0], z.T @ unit[1], unit[2]])


def x_to(direction: Any) -> Any:
    """A rotation that takes x to a direction."""
    x = np.asarray(direction) / np.linalg.norm(direction)
    return pin.Quaternion.FromTwoVectors(np.eye(3)[0], x).matrix()


def pose_of(origin: Any) -> pin.SE3:
    """The pose of an <origin>."""
    if origin is None:
        return pin.SE3.Identity()
    rotation = pin.rpy.rpyToMatrix(np.array(numbers(origin.get("rpy", "0 0 0"))))
    return pin.SE3(rotation, np.array(numbers(origin.get("xyz", "0 0 0"))))


def numbers(text: str) -> list[float]:
    """Numbers between spaces."""
    return [float(word) for word in text.split()]


def urdf_beside(file: Path) -> Path:
    """The URDF of a robot.yaml."""
    beside = file.with_suffix(".urdf")
    return beside if beside.is_file() else next(iter(file.parent.glob("*.urdf")))


def relative(one: Any, other: Any) -> float:
    """The largest difference over the largest number."""
    size = max(1e-3, float(np.abs(other).max(initial=0.0)))
    return float(np.abs(np.asarray(one) - other).max(initial=0.0)) / size


class Quiet:
    """Keeps what the parser of URDF says of geometry from the terminal."""

    def __enter__(self) -> None:
        sys.stderr.flush()
        self.kept, self.null = os.dup(2), os.open(os.devnull, os.O_WRONLY)
        os.dup2(self.null, 2)

    def __exit__(self, *_: object) -> None:
        os.dup2(self.kept, 2)
        os.close(self.kept)
        os.close(self.null)
