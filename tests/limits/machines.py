"""A crane with two cylinders on one pump, as a data sheet gives it."""

from __future__ import annotations

import textwrap

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.formats.reader import parse_description

CRANE = """
    format: 1
    name: crane
    base: column
    parameters: {retracted: 0.9}
    links:
      column: {}
      arm: {mass: 180, com: [1.0, 0.05, 0], inertia: {rod: {axis: x, length: 2.2}}}
      boom: {mass: 110, com: [0.9, 0.05, 0], inertia: {rod: {axis: x, length: 2.0}}}
      barrel_1: {mass: 25, com: [0.45, 0, 0], inertia: {rod: {axis: x, length: 0.9}}}
      rod_1: {mass: 15, com: [-0.4, 0, 0], inertia: {rod: {axis: x, length: 0.9}}}
      barrel_2: {mass: 18, com: [0.45, 0, 0], inertia: {rod: {axis: x, length: 0.9}}}
      rod_2: {mass: 11, com: [-0.4, 0, 0], inertia: {rod: {axis: x, length: 0.9}}}
    joints:
      arm_pitch: {type: revolute, parent: column, child: arm,
        origin: {xyz: [0, 0, 2.0], rpy: [pi/2, 0, 0]}, axis: z}
      boom_pitch: {type: revolute, parent: arm, child: boom, origin: {xyz: [2.2, 0, 0]}, axis: z}
      barrel_1_pitch: {type: revolute, parent: column, child: barrel_1,
        origin: {xyz: [0.25, 0, 0.9], rpy: [pi/2, 0, 0]}, axis: z}
      lift_cylinder: {type: prismatic, parent: barrel_1, child: rod_1,
        origin: {xyz: [retracted, 0, 0]}, axis: x, limits: [0, 0.6]}
      barrel_2_pitch: {type: revolute, parent: arm, child: barrel_2,
        origin: {xyz: [1.1, 0.3, 0]}, axis: z}
      boom_cylinder: {type: prismatic, parent: barrel_2, child: rod_2,
        origin: {xyz: [retracted, 0, 0]}, axis: x, limits: [0, 0.6]}
    loops:
      lift: {type: A, base: column, arm: arm, k1: barrel_1, k2: rod_1,
        pin: {rod_1: [0, 0, 0], arm: [0.9, -0.1, 0]}}
      fold: {type: A, base: arm, arm: boom, k1: barrel_2, k2: rod_2,
        pin: {rod_2: [0, 0, 0], boom: [-0.2, 0.35, 0]}}
    actuators:
      lift_cylinder: {kind: hydraulic_cylinder, bore: 63*mm, rod: 40*mm, stroke: [0, 0.6],
        supply_pressure: 210*bar, flow_limit: 80*l/min}
      boom_cylinder: {kind: hydraulic_cylinder, bore: 80*mm, rod: 50*mm, stroke: [0, 0.6],
        supply_pressure: 230*bar, relief_pressure: 210*bar}
    pumps:
      main: {cylinders: [lift_cylinder, boom_cylinder], flow_limit: 100*l/min, power_limit: 5*kW}
    active: [lift_cylinder, boom_cylinder]
    end_effector: {link: boom, xyz: [2.0, 0, 0]}
    reference: {lift_cylinder: 0.3, boom_cylinder: 0.2, arm_pitch: 0, barrel_1_pitch: 1,
      boom_pitch: -0.5, barrel_2_pitch: 0}
"""


def crane(*changes: tuple[str, str]) -> Robot:
    """The crane, with parts of its text replaced."""
    text = textwrap.dedent(CRANE)
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return Robot(parse_description(text))
