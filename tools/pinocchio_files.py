"""URDF, URDF+ and robot.yaml files in Pinocchio, to be compared with the library's robots.

Pinocchio builds the spanning tree from the URDF text. What ties joints or links is read here once
more, from the file: <mimic>, <loop>, <coupling> and pairs of frames, and rotors too. So a wrong
reading of the library's shows as a gap. `pinocchio_motion` compares at one closed state.
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
        if file.suffix == ".urdf":
            urdf, given = file, {}
        else:
            urdf = urdf_beside(file)
            given = yaml.safe_load(file.read_text(encoding="utf-8"))
        self.root = ET.fromstring(urdf.read_bytes())  # noqa: S314  a file that the user names
        completed(self.root)
        text = ET.tostring(self.root, encoding="unicode")
        with Quiet():
            self.model = pin.buildModelFromXML(text)
        names = given.get("joint_name") or []
        types = given.get("joint_type") or []
        kinds = dict(zip(names, types, strict=True))
        if kinds:
            self.replace(kinds)
        self.data = self.model.createData()
        self.ties = self.pairs(given) if given else self.loops()
        self.motors = set(given.get("name_mot") or [])

    def replace(self, kinds: dict[str, str]) -> None:
        """Joints become spherical, universal or fixed, as Gepetto's loader makes them."""
        old = self.model
        new = pin.Model()
        ends = dict(zip(old.names, old.names, strict=True))  # last joint of each old one
        for k in range(1, old.njoints):
            name = old.names[k]
            base = old.names[old.parents[k]]
            parent = new.getJointId(ends[base])
            joint = old.joints[k]
            place = old.jointPlacements[k]
            kind = kinds.get(name, "")
            if kind == "SPHERICAL":
                joint = pin.JointModelSpherical()
            elif kind.startswith("U"):
                first, second = kind[-2:]
                parent = new.addJoint(parent, AXES[first](), place, f"{name}_{first}")
                joint = AXES[second]()
                place = pin.SE3.Identity()
                ends[name] = f"{name}_{second}"
            made = new.addJoint(parent, joint, place, ends[name])
            new.appendBodyToJoint(made, old.inertias[k], pin.SE3.Identity())
        for frame in list(old.frames)[1:]:
            end = ends[old.names[frame.parentJoint]]
            number = new.getJointId(end)
            moved_frame = pin.Frame(frame.name, number, frame.placement, frame.type)
            new.addFrame(moved_frame, False)
        fixed = [new.getJointId(name) for name, kind in kinds.items() if kind == "FIXED"]
        if fixed:
            new = pin.buildReducedModel(new, fixed, pin.neutral(new))
        self.model = new

    def rotors(self) -> Any:
        """Inertia (nv,) of rotors behind gears, seen from the joints."""
        inertia = np.zeros(self.model.nv)
        for transmission in self.root.iter("transmission"):
            joint = transmission.find("joint")
            name = getattr(joint, "attrib", {}).get("name", "")
            rotor = transmission.find(f"actuator/{DRAKE}rotor_inertia")
            gear = transmission.find(f"actuator/{DRAKE}gear_ratio")
            if rotor is None or not self.model.existJointName(name):
                continue
            ratio = 1.0
            if gear is not None:
                ratio = float(gear.get("value"))
            number = self.model.getJointId(name)
            row = self.model.joints[number].idx_v
            inertia[row] = float(rotor.get("value")) * ratio**2
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
            direction = [1.0, 0.0, 0.0]
            if axis is not None:
                direction = numbers(axis.get("xyz"))
            turned = pin.SE3(x_to(direction), np.zeros(3))
            ends = []
            for tag in ("predecessor", "successor"):
                end = loop.find(tag)
                number, place = self.frame(end.get("link"))
                origin = pose_of(end.find("origin"))
                ends.append((number, place * origin * turned))
            kind = kinds[loop.get("type")]
            ties.append(Tie(loop.get("name"), kind, tuple(ends)))
        return ties

    def couplings(self) -> list[tuple[str, dict[str, float], float]]:
        """Name, coefficient of each joint, and constant of every sum that is zero."""
        sums = []
        for joint in self.root.iter("joint"):
            name = joint.get("name")
            mimic = joint.find("mimic")
            if mimic is None or joint.get("type") == "fixed" or name in self.motors:
                continue
            multiplier = float(mimic.get("multiplier", 1.0))
            offset = float(mimic.get("offset", 0.0))
            coefficients = {name: 1.0, mimic.get("joint"): -multiplier}
            sums.append((f"mimic {name}", coefficients, -offset))
        for element in self.root.iter("coupling"):
            ratio = float(element.find("ratio").get("value"))
            before = element.find("predecessor").get("link")
            after = element.find("successor").get("link")
            coefficients = dict.fromkeys(self.chain(before, after), -ratio)
            for joint in self.chain(after, before):
                coefficients[joint] = coefficients.get(joint, 0.0) + 1.0
            sums.append((f"coupling {element.get('name')}", coefficients, 0.0))
        return sums

    def chain(self, link: str, other: str) -> list[str]:
        """Moving joints from a link to the last that another one shares, or to the base."""
        path = self.to_base(link)
        shared = self.to_base(other)
        alone = [joint for joint in path if joint not in shared]
        return alone or path

    def to_base(self, link: str) -> list[str]:
        """Moving joints from a link to the base."""
        number, _ = self.frame(link)
        path = []
        while number:
            path.append(self.model.names[number])
            number = self.model.parents[number]
        return path

    def frame(self, name: str) -> tuple[int, pin.SE3]:
        """Joint and placement of a link or frame."""
        number = self.model.getFrameId(name)
        frame = self.model.frames[number]
        return frame.parentJoint, frame.placement


# -- rotations and texts


def completed(root: Any) -> None:
    """What URDF asks for and people leave out: links that joints name, limits, tidy numbers."""
    for element in root.iter():
        for name, text in element.attrib.items():
            element.set(name, text.strip())
    links = {link.get("name") for link in root.findall("link")}
    for joint in root.findall("joint"):
        parent = joint.find("parent")
        link = None if parent is None else parent.get("link")
        if link is not None and link not in links:
            links.add(link)
            ET.SubElement(root, "link", name=link)
        limit = joint.find("limit")
        if limit is None:
            limit = ET.SubElement(joint, "limit")
        limit.attrib.setdefault("effort", "1e9")
        limit.attrib.setdefault("velocity", "1e9")


def x_to(direction: Any) -> Any:
    """A rotation that takes x to a direction."""
    x = np.asarray(direction) / np.linalg.norm(direction)
    return pin.Quaternion.FromTwoVectors(np.eye(3)[0], x).matrix()


def pose_of(origin: Any) -> pin.SE3:
    """The pose of an <origin>."""
    if origin is None:
        return pin.SE3.Identity()
    angles = np.array(numbers(origin.get("rpy", "0 0 0")))
    position = np.array(numbers(origin.get("xyz", "0 0 0")))
    return pin.SE3(pin.rpy.rpyToMatrix(angles), position)


def numbers(text: str) -> list[float]:
    """Numbers between spaces."""
    return [float(word) for word in text.split()]


def urdf_beside(file: Path) -> Path:
    """The URDF of a robot.yaml."""
    beside = file.with_suffix(".urdf")
    if beside.is_file():
        return beside
    return next(iter(file.parent.glob("*.urdf")))


class Quiet:
    """Keeps what the parser of URDF says of geometry from the terminal."""

    def __enter__(self) -> None:
        sys.stderr.flush()
        self.kept = os.dup(2)
        self.null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(self.null, 2)

    def __exit__(self, *_: object) -> None:
        os.dup2(self.kept, 2)
        os.close(self.kept)
        os.close(self.null)
