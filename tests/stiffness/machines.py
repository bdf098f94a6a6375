"""Small machines whose stiffness is known by hand."""

from __future__ import annotations

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.formats.reader import parse_description


def machine(text: str, **numbers: object) -> Robot:
    """The robot of a description in which names in angle brackets are replaced."""
    for name, value in numbers.items():
        text = text.replace(f"<{name}>", str(value))
    return Robot(parse_description(text, file="machine.yaml"))


CANTILEVER = """
format: 1
name: cantilever
gravity: [0, 0, 0]
links: {boom: {mass: 200, com: [2, 0, 0]}}
joints: {q: {type: revolute, parent: base, child: boom, axis: y}}
active: [q]
end_effector: {link: boom, xyz: [4, 0, 0]}
stiffness:
  links:
    boom:
      E: 210e9
      G: 81e9
      to: end_effector
      section: {A: 0.01, Iy: 2e-5, Iz: 1e-5, J: 3e-5, <shear>}
"""

# a boom that one cylinder holds: foot at the origin, lug 1.5 m along it, other end of the
# cylinder 2 m below the foot
CRANE = """
format: 1
name: crane
links:
  boom: {mass: 300, com: [2.5, 0, 0]}
  barrel: {}
  rod: {}
joints:
  luff: {type: revolute, parent: base, child: boom, axis: -y}
  foot: {type: revolute, parent: base, child: barrel, axis: -y, origin: {xyz: [0, 0, -2]}}
  cylinder: {type: prismatic, parent: barrel, child: rod, axis: x, limits: [1.5, 3.4]}
closures:
  lug: {kind: planar, between: {boom: [1.5, 0, 0], rod: [0, 0, 0]}}
active: [cylinder]
end_effector: {link: boom, xyz: [5, 0, 0]}
reference: {cylinder: 2.5, luff: 0, foot: 0.927}
actuators:
  cylinder: {kind: hydraulic_cylinder, bore: 0.1, rod: 0.06, stroke: [1.4, 3.4]}
stiffness:
  drives:
    cylinder: {oil: {bulk_modulus: 1.2e9, dead_volume: [1e-3, 2e-3]}}
"""
