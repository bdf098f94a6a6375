"""Linkages whose errors are known by hand."""

from __future__ import annotations

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.formats.reader import parse_description

TWO_BAR = """\
format: 1
name: two_bar
parameters: {L1: 0.5, L2: 0.3}
links: {base: {}, upper: {mass: 2}, lower: {mass: 1}}
joints:
  q1: {type: revolute, parent: base, child: upper, axis: z}
  q2: {type: revolute, parent: upper, child: lower, origin: {xyz: [L1, 0, 0]}, axis: z}
active: [q1, q2]
end_effector: {link: lower, xyz: [L2, 0, 0]}
reference: {q1: 0.4, q2: 0.9}
"""
SLIDER_CRANK = """\
format: 1
name: slider_crank
parameters: {crank: 0.1, rod: 0.3, height: 0}
links: {base: {}, disc: {mass: 2}, bar: {mass: 1}, piston: {mass: 1}}
joints:
  turn: {type: revolute, parent: base, child: disc, axis: z}
  big_end: {type: revolute, parent: disc, child: bar, origin: {xyz: [crank, 0, 0]}, axis: z}
  slide: {type: prismatic, parent: base, child: piston, origin: {xyz: [0, height, 0]}, axis: x}
closures:
  small_end: {kind: planar, between: {bar: {xyz: [rod, 0, 0]}, piston: {xyz: [0, 0, 0]}}}
active: [turn]
end_effector: {link: piston}
reference: {turn: 0.8, big_end: -1.04, slide: 0.36}
"""


def robot(text: str) -> Robot:
    """The robot of a text."""
    return Robot(parse_description(text))
