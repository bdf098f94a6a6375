"""A crank lifted by a cylinder: small, with a loop, and what may be measured on it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hybrid_dynamics_core import load
from hybrid_dynamics_core.robot.robot import Robot

TEXT = """\
format: 1
name: crank_and_cylinder
parameters:
  reach: 0.8                            # crank to the tool [m]
links:
  base: {}
  column: {mass: 5}
  crank: {mass: 10, com: [0.4, 0, 0], inertia: {rod: {axis: x, length: reach}}}
  barrel: {mass: 4, com: [0.2, 0, 0], inertia: {rod: {axis: x, length: 0.4}}}
  rod: {mass: 2, com: [-0.2, 0, 0], inertia: {rod: {axis: x, length: 0.4}}}
joints:
  turn: {type: revolute, parent: base, child: column, axis: z}
  lever: {type: revolute, parent: column, child: crank, origin: {rpy: [pi/2, 0, 0]}, axis: z}
  pivot: {type: revolute, parent: column, child: barrel,
       origin: {xyz: [0.3, 0, -0.5], rpy: [pi/2, 0, 0]}, axis: z}
  stroke: {type: prismatic, parent: barrel, child: rod, origin: {xyz: [0.4, 0, 0]}, axis: x,
           limits: [0, 0.35]}
loops:
  lift:
    {type: A, base: column, arm: crank, k1: barrel, k2: rod,
      pin: {rod: [0, 0, 0], crank: [0.6, 0, 0]}, assembly: clockwise}
active: [turn, stroke]
end_effector: {link: crank, xyz: [reach, 0, 0]}
reference: {turn: 0, stroke: 0.1}
frames:
  mark: {link: crank, xyz: [0.3, 0.1, 0.05]}
  stand: {link: base, xyz: [1.0, 0.5, 0]}
"""


def write(folder: Path, text: str = TEXT) -> str:
    """The robot's file in a folder."""
    path = folder / "crank.yaml"
    path.write_text(text, encoding="utf-8")
    return str(path)


def changed(folder: Path, **replaced: str) -> Robot:
    """The robot with other text: `reach="0.801"` for the lines that are named below."""
    text = TEXT
    for name, new in replaced.items():
        old = OLD[name]
        assert old in text
        text = text.replace(old, new)
    path = folder / "true.yaml"
    path.write_text(text, encoding="utf-8")
    return load(str(path))


OLD = {
    "reach": "reach: 0.8 ",
    "pin": "crank: [0.6, 0, 0]",
    "foot": "xyz: [0.3, 0, -0.5]",
    "turn": "child: column, axis: z",
    "tool": "xyz: [reach, 0, 0]}",
    "lever": "rpy: [pi/2, 0, 0]}, axis: z}\n  pivot",
}


def poses(count: int, seed: int = 0):
    """Active coordinates (count, 2) within the limits."""
    rng = np.random.default_rng(seed)
    return np.stack([rng.uniform(-2, 2, count), rng.uniform(0.02, 0.33, count)], axis=1)


def columns(robot: Robot, u, kinds=("points",), noise: float = 0.0, seed: int = 1):
    """What is measured at active coordinates u (N, 2), by column."""
    rng = np.random.default_rng(seed)
    state = robot.close(u)
    data = {"turn": u[:, 0], "stroke": u[:, 1]}
    for kind in kinds:
        for name, values in MEASURED[kind](robot, state).items():
            data[name] = values + noise * rng.standard_normal(len(u))
    return data


def _points(robot, state):
    position = robot.forward_kinematics(state).position
    return {f"tool.{axis}": position[:, k] for k, axis in enumerate("xyz")}


def _turns(robot, state):
    quaternion = robot.forward_kinematics(state).quaternion
    return {f"tool.q{part}": quaternion[:, k] for k, part in enumerate("xyzw")}


def _marks(robot, state):
    position = robot.forward_kinematics(state, "mark").position
    return {f"mark.{axis}": position[:, k] for k, axis in enumerate("xyz")}


def _distances(robot, state):
    stand = np.array([1.0, 0.5, 0.0])
    apart = robot.forward_kinematics(state).position - stand
    return {"distance.tool.stand": np.linalg.norm(apart, axis=1)}


def _inclinations(robot, state):
    rotation = robot.forward_kinematics(state).rotation
    return {"inclination.crank.x": np.arcsin(rotation[:, 2, 0])}


def _encoders(robot, state):
    names = ("lever", "pivot")
    return {name: state.s[:, robot.coordinates.index(name)] for name in names}


MEASURED = {
    "points": _points,
    "turns": _turns,
    "marks": _marks,
    "distances": _distances,
    "inclinations": _inclinations,
    "encoders": _encoders,
}
