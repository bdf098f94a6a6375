"""A bound on the reach of the end effector, for all joint values."""

from __future__ import annotations

import heapq
import math
from collections import defaultdict

from ..algebra.independence import norm
from ..description.model import Joint
from .closed_kinematics import ClosedKinematics

# by link: links that it is joined to, each with the largest distance [m]
Neighbours = dict[str, list[tuple[str, float]]]


def farthest_reach(robot: ClosedKinematics) -> float:
    """A bound on the distance of the end effector from the base origin [m].

    It is the length of the shortest path over joints and closures, stretched into a line. It is
    infinite if every path has a slide without limits.
    """
    description = robot.description
    frame = description.frames[robot.end_effector]
    distances = _distances(_neighbours(robot), description.base)
    return distances.get(frame.link, math.inf) + norm(frame.translation)


def _neighbours(robot: ClosedKinematics) -> Neighbours:
    neighbours: Neighbours = defaultdict(list)
    for joint in robot.description.joints.values():
        length = norm(joint.translation) + _longest_slide(robot, joint)
        neighbours[joint.parent].append((joint.child, length))
        neighbours[joint.child].append((joint.parent, length))
    for closure in robot.description.closures:
        length = norm(closure.point_a) + norm(closure.point_b)
        neighbours[closure.link_a].append((closure.link_b, length))
        neighbours[closure.link_b].append((closure.link_a, length))
    return neighbours


def _longest_slide(robot: ClosedKinematics, joint: Joint) -> float:
    if joint.type == "revolute":
        return 0.0
    lower, upper = joint.limits
    if joint.name in robot.active:
        lower, upper = robot.limits[robot.active.index(joint.name)].tolist()
    return max(abs(lower), abs(upper))


def _distances(neighbours: Neighbours, start: str) -> dict[str, float]:
    """Shortest paths to all links (Dijkstra)."""
    distances: dict[str, float] = {}
    waiting = [(0.0, start)]
    while waiting:
        length, link = heapq.heappop(waiting)
        if link in distances:
            continue
        distances[link] = length
        for other, step in neighbours[link]:
            if other not in distances:
                heapq.heappush(waiting, (length + step, other))
    return distances
