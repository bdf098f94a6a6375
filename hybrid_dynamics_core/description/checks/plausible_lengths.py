"""Warnings of lengths and inertias that do not fit the reach of the robot, hence wrong units."""

from __future__ import annotations

import math

import numpy as np

from ...ground.arrays import Array
from ..document import Document, KeyPath
from ..model import Joint, RobotDescription
from .plausible_cylinders import warn_of_cylinders

# A bucket-wheel excavator, the longest machine that moves on land, is 225 m long.
_LONGEST_REACH = 250.0  # [m]
# A stroke above this length, and above this ratio to the reach, is likely in millimetres.
_LONG_STROKE = 40.0  # [m]
_STROKE_RATIO = 20.0  # largest ratio of a stroke to the reach
_GYRATION_RATIO = 4.0  # of a radius of gyration to the reach: no mass is so far away

_Length = tuple[float, KeyPath]  # a length [m], and where it is written


def warn_of_lengths(document: Document, robot: RobotDescription) -> None:
    """Warn of strokes, inertias, cylinders and lengths that do not fit the size of a robot."""
    lengths = _longest_path(robot)
    reach = _total(lengths)
    _warn_of_strokes(document, robot, reach)
    _warn_of_inertias(document, robot, reach)
    warn_of_cylinders(document, robot, reach)
    if reach > _LONGEST_REACH:
        length, path = max(lengths, key=lambda item: item[0])
        document.warn(
            path,
            f"{length:.4g} m, and the robot reaches {reach:.4g} m from its base: are these"
            f" millimetres? Lengths are in metres: {length:.4g} mm are written"
            f" {length / 1000.0:.4g}",
        )


def _longest_path(robot: RobotDescription) -> list[_Length]:
    """The lengths from the base to the farthest point, with slides at zero."""
    joint_to = robot.joint_to()
    paths: list[list[_Length]] = []
    for point, key_path, link in _ends(robot):
        last = (_norm(point), key_path)
        paths.append([last, *_path_to(link, joint_to)])
    return max(paths, key=_total, default=[])


def _ends(robot: RobotDescription) -> list[tuple[Array, KeyPath, str]]:
    """Points on links [m]: centres of mass, frames and closures, with key and link."""
    ends: list[tuple[Array, KeyPath, str]] = []
    for name, link in robot.links.items():
        ends.append((link.com, ("links", name, "com"), name))
    for name, frame in robot.frames.items():
        path: KeyPath = ("frames", name)
        if name == robot.end_effector:
            path = ("end_effector",)
        ends.append((frame.translation, path, frame.link))
    for closure in robot.closures:
        section = "loops" if closure.name in robot.loops else "closures"
        path = (section, closure.name)
        ends.append((closure.point_a, path, closure.link_a))
        ends.append((closure.point_b, path, closure.link_b))
    return ends


def _path_to(link: str, joint_to: dict[str, Joint]) -> list[_Length]:
    """The lengths from the base to a link."""
    lengths: list[_Length] = []
    while link in joint_to:
        joint = joint_to[link]
        key_path = ("joints", joint.name, "origin")
        lengths.append((_norm(joint.translation), key_path))
        link = joint.parent
    return lengths


def _warn_of_strokes(document: Document, robot: RobotDescription, reach: float) -> None:
    """Warn of slides whose limits are far larger than the robot."""
    for name, joint in robot.joints.items():
        ends = [abs(end) for end in joint.limits if math.isfinite(end)]
        limit = max(ends, default=0.0)
        if joint.type != "prismatic" or limit < _LONG_STROKE or limit <= _STROKE_RATIO * reach:
            continue
        if _stands_for_none(limit):
            continue
        document.warn(
            ("joints", name, "limits"),
            f"{limit:g} m, and the robot reaches {reach:.4g} m from its base: are these"
            f" millimetres? {limit:g} mm are written {limit / 1000.0:g}",
        )


def _warn_of_inertias(document: Document, robot: RobotDescription, reach: float) -> None:
    """Warn of inertias with a radius of gyration far larger than the robot."""
    for name, link in robot.links.items():
        if name == robot.base or not link.mass or reach <= 0.0:
            continue
        moment = max(0.0, float(np.trace(link.inertia))) / 2.0
        gyration = np.sqrt(moment / link.mass)
        entry = document.data["links"].get(name) or {}
        if gyration > _GYRATION_RATIO * reach and "inertia" in entry:
            document.warn(
                ("links", name, "inertia"),
                f"its {link.mass:.4g} kg would have to be {gyration:.3g} m from its centre of mass,"
                f" and the robot reaches {reach:.3g} m: are these g mm^2 or kg mm^2? Inertias are"
                " in kg m^2: 1 kg mm^2 is 1e-6, 1 g mm^2 is 1e-9",
            )


def _stands_for_none(limit: float) -> bool:
    """Whether a limit is a power of ten, which many URDFs have in place of no limit."""
    return float(np.log10(limit)).is_integer()


def _norm(vector: Array) -> float:
    return float(np.linalg.norm(vector))


def _total(lengths: list[_Length]) -> float:
    return sum(length for length, _ in lengths)
