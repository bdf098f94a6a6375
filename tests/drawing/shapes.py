"""Robots of many shapes as texts: serial arms, rails, sliders, spatial loops, a single point."""

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.formats.reader import parse_description

SHAPES = {
    "wrist": (
        """
links: {base: {}, a: {}, b: {}, c: {}, d: {}, e: {}, f: {}}
joints:
  q1: {type: revolute, parent: base, child: a, axis: z}
  q2: {type: revolute, parent: a, child: b, origin: {xyz: [0.1, 0, 0.4]}, axis: y}
  q3: {type: revolute, parent: b, child: c, origin: {xyz: [0, 0, 0.45]}, axis: y}
  q4: {type: revolute, parent: c, child: d, origin: {xyz: [0.2, 0, 0.04]}, axis: x}
  q5: {type: revolute, parent: d, child: e, origin: {xyz: [0.22, 0, 0]}, axis: y}
  q6: {type: revolute, parent: e, child: f, origin: {xyz: [0.09, 0, 0]}, axis: x}
active: [q1, q2, q3, q4, q5, q6]
end_effector: {link: f, xyz: [0.05, 0, 0]}
reference: {q1: 0.5, q2: -0.3, q3: 0.5, q4: 0, q5: 0.5, q6: 0}
"""
    ),
    "gantry": (
        """
links: {base: {}, a: {mass: 1}, b: {mass: 1}, c: {mass: 1}}
joints:
  x: {type: prismatic, parent: base, child: a, origin: {xyz: [0, 0, 1]}, axis: x, limits: [0, 1]}
  y: {type: prismatic, parent: a, child: b, origin: {xyz: [0, 0, 0.1]}, axis: y, limits: [0, 1]}
  z: {type: prismatic, parent: b, child: c, origin: {xyz: [0.1, 0, 0]}, axis: z, limits: [-0.6, 0]}
active: [x, y, z]
end_effector: {link: c, xyz: [0, 0, -0.3]}
reference: {x: 0.4, y: 0.3, z: -0.2}
"""
    ),
    "slider_crank": (
        """
links: {base: {}, crank: {}, rod: {}, piston: {}}
joints:
  q1: {type: revolute, parent: base, child: crank, axis: y}
  q2: {type: revolute, parent: crank, child: rod, origin: {xyz: [0.1, 0, 0]}, axis: y}
  q3: {type: prismatic, parent: base, child: piston, axis: x, limits: [0.15, 0.45]}
closures:
  wrist: {kind: planar, between: {rod: [0.3, 0, 0], piston: [0, 0, 0]}}
active: [q1]
end_effector: {link: piston, xyz: [0.05, 0, 0]}
reference: {q1: -0.8, q2: 1.0, q3: 0.36}
"""
    ),
    "rssr": (
        """
links: {base: {}, crank: {}, cross: {}, rod: {}, rocker: {}}
joints:
  q1: {type: revolute, parent: base, child: crank, axis: z}
  q2: {type: revolute, parent: base, child: rocker, origin: {xyz: [0.5, 0, 0.2]}, axis: y}
  a: {type: revolute, parent: crank, child: cross, origin: {xyz: [0.15, 0, 0]}, axis: z}
  b: {type: revolute, parent: cross, child: rod, axis: y}
closures:
  ball: {kind: point, between: {rod: [0.5, 0, 0], rocker: [0, 0, 0.25]}}
active: [q1]
end_effector: {link: rocker, xyz: [0, 0, 0.3]}
reference: {q1: 1.0, q2: 0.1, a: -1.2, b: -0.9}
"""
    ),
    "hinge_and_weld": (
        """
links: {base: {}, a: {}, b: {}, c: {}}
joints:
  q1: {type: revolute, parent: base, child: a, axis: z}
  q2: {type: revolute, parent: a, child: b, origin: {xyz: [0.1, 0, 0]}, axis: z}
  q3: {type: revolute, parent: base, child: c, origin: {xyz: [0.3, 0, 0]}, axis: z}
closures:
  pin: {kind: axis, between: {b: [0.3, 0, 0], c: [0.2, 0, 0]}}
active: [q1]
end_effector: {link: c, xyz: [0.2, 0.1, 0]}
reference: {q1: 1.0, q2: -0.5, q3: 1.6}
"""
    ),
    "pendulum": (
        """
links: {base: {}, a: {}}
joints:
  q: {type: revolute, parent: base, child: a, axis: y}
active: [q]
end_effector: {link: a, xyz: [0, 0, -1]}
reference: {q: 0.3}
"""
    ),
    "point": (
        """
links: {base: {}, a: {}}
joints:
  q: {type: revolute, parent: base, child: a, axis: y}
active: [q]
end_effector: {link: a}
"""
    ),
}


def shape(name: str) -> Robot:
    """One of the robots above."""
    text = f"format: 1\nname: {name}\nsource: invented\n{SHAPES[name]}"
    return Robot(parse_description(text, file=f"{name}.yaml"))
