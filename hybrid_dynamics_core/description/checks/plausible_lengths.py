"""Lengths that are hardly metres, by the reach of the robot, and inertias that are hardly kg m^2, by the same."""

from __future__ import annotations

import numpy as np

from ...ground.arrays import Array
from ..document import Document, Path_
from ..model import RobotDescription

SLIDE = (
    40.0,
    20.0,
)  # [m] a stroke that long, and so many times longer than the robot reaches, is written in millimetres
OUTSIDE = 4.0  # times the reach of the robot, that no link's mass is from its centre of mass
LONGEST = (
    250.0  # [m] the longest machine that moves on land, a bucket-wheel excavator, is 225 m long
)
Part = tuple[float, Path_]  # a length [m], and where it is written


def doubt_lengths(document: Document, robot: RobotDescription) -> None:
    """Note the largest length of a robot that reaches beyond `LONGEST`; strokes and inertias of another size."""
    farthest = _farthest(robot)
    reach = _reach(farthest)
    _doubt_strokes(document, robot, reach)
    _doubt_inertias(document, robot, reach)
    if reach > LONGEST:
        length, path = max(farthest, key=lambda part: part[0])
        told = (
            f"{length:.4g} m, and the robot reaches {reach:.4g} m from its base: are these"
            " millimetres?"
        )
        document.doubt(
            path, f"{told} Lengths are in metres: {length:.4g} mm are written {length / 1000.0:.4g}"
        )


def _farthest(robot: RobotDescription) -> list[Part]:
    """The lengths from the base to what is farthest, slides at zero."""
    joints = {joint.child: joint for joint in robot.joints.values()}

    def way(link: str) -> list[Part]:
        """The lengths from the base to a link."""
        parts: list[Part] = []
        while link in joints:
            joint = joints[link]
            parts.append(_part(joint.translation, ("joints", joint.name, "origin")))
            link = joint.parent
        return parts

    ends = [
        [_part(link.com, ("links", name, "com")), *way(name)] for name, link in robot.links.items()
    ]
    for name, frame in robot.frames.items():
        path: Path_ = ("end_effector",) if name == robot.end_effector else ("frames", name)
        ends.append([_part(frame.translation, path), *way(frame.link)])
    for closure in robot.closures:
        path = ("loops" if closure.name in robot.loops else "closures", closure.name)
        ends.append([_part(closure.point_a, path), *way(closure.link_a)])
        ends.append([_part(closure.point_b, path), *way(closure.link_b)])
    return max(ends, key=_reach, default=[])


def _doubt_inertias(document: Document, robot: RobotDescription, reach: float) -> None:
    """Note inertias whose mass would have to be far outside of the robot."""
    for name, link in robot.links.items():
        moment = float(np.trace(link.inertia)) / 2.0
        away = np.sqrt(moment / link.mass) if link.mass else 0.0
        if (
            reach > 0.0
            and away > OUTSIDE * reach
            and "inertia" in (document.data["links"].get(name) or {})
        ):
            told = (
                f"its {link.mass:.4g} kg would have to be {away:.3g} m from its centre of mass, and"
                " the robot reaches"
            )
            document.doubt(
                ("links", name, "inertia"),
                f"{told} {reach:.3g} m: are these g mm^2 or kg mm^2? Inertias are in kg m^2: 1 kg"
                " mm^2 is 1e-6, 1 g mm^2 is 1e-9",
            )


def _doubt_strokes(document: Document, robot: RobotDescription, reach: float) -> None:
    """Note slides whose limits have nothing to do with the size of the robot."""
    least, times = SLIDE
    for name, joint in robot.joints.items():
        limit = max((abs(end) for end in joint.limits if np.isfinite(end)), default=0.0)
        if (
            joint.type == "prismatic"
            and limit >= least
            and limit > times * reach
            and not _stands_for_none(limit)
        ):
            told = (
                f"{limit:g} m, and the robot reaches {reach:.4g} m from its base: are these"
                " millimetres?"
            )
            document.doubt(
                ("joints", name, "limits"), f"{told} {limit:g} mm are written {limit / 1000.0:g}"
            )


def _stands_for_none(limit: float) -> bool:
    """Whether a limit is a power of ten, which URDFs and the like have where there is none."""
    return float(np.log10(limit)).is_integer()


def _part(vector: Array, path: Path_) -> Part:
    return float(np.linalg.norm(vector)), path


def _reach(parts: list[Part]) -> float:
    return sum(length for length, _ in parts)
