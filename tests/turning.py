"""Random linkages whose passive joints go round with the crank, with springs on all of them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from hypothesis import strategies as st

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.algebra.rotations import rotation_matrix
from hybrid_dynamics_core.formats.reader import parse_description
from tests.generated.robots import moved

RATIO = -2.5  # of the gear that follows the coupler: half a turn is another place of it

JOINTS = """\
format: 1
name: turning
gravity: [0, 0, 0]
links:
  base: {{}}
  crank: {{mass: 1, com: [0.05, 0, 0]}}
  coupler: {{mass: 1, com: [0.1, 0.02, 0]}}
  output: {{mass: 1, com: [0.1, 0, 0]}}
  disc: {{mass: 0.3, com: [0.02, 0, 0]}}
joints:
  a: {{type: revolute, parent: base, child: crank, axis: z}}
  b: {{type: revolute, parent: crank, child: coupler, axis: z, origin: {{xyz: [{crank}, 0, 0]}},
      spring: {{stiffness: {kb}, rest: {rest}}}}}
  c: {{type: {kind}, parent: base, child: output, axis: {axis}, origin: {{xyz: [{ground}, 0, 0]}},
      spring: {{stiffness: {kc}, rest: {rest}}}}}
  g: {{type: revolute, parent: output, child: disc, axis: z,
      mimic: {{joint: b, multiplier: -2.5, offset: 0.3}},
      spring: {{stiffness: {kg}, rest: 0.1}}}}
closures:
  bar: {{kind: planar, between: {{coupler: [{rod}, 0, 0], output: [{out}, 0, 0]}},
        assembly: {mode}}}
active: [a]
end_effector: {{link: disc}}
reference: {{a: {start}}}
"""


class Turning(NamedTuple):
    """A linkage in the plane: its lengths [m], and which way it closes.

    Attributes:
        kind: "revolute" for a four-bar, "prismatic" for a slider-crank.
        lengths: ground, crank, rod, output.
        sign: +1 counterclockwise or extended, -1 clockwise or retracted.
        stiffness: of b, c, g.
        rest: of the springs of b and c.
        start: reference of the crank.
    """

    kind: str
    lengths: tuple[float, float, float, float]
    sign: int
    stiffness: tuple[float, float, float]
    rest: float
    start: float

    def robot(self, seed: int = 0) -> Robot:
        """The library's robot, mounted somewhere by a seed."""
        ground, crank, rod, out = self.lengths
        kb, kc, kg = self.stiffness
        is_bar = self.kind == "revolute"
        modes = ("counterclockwise", "clockwise") if is_bar else ("extended", "retracted")
        text = JOINTS.format(
            kind=self.kind,
            axis="z" if is_bar else "x",
            ground=ground,
            crank=crank,
            rod=rod,
            out=out,
            kb=kb,
            kc=kc,
            kg=kg,
            rest=self.rest,
            mode=modes[0] if self.sign > 0 else modes[1],
            start=self.start,
        )
        description = parse_description(text, file="turning.yaml")
        if seed:
            rng = np.random.default_rng(seed)
            quaternion = rng.normal(size=4)
            rotation = rotation_matrix(quaternion / np.linalg.norm(quaternion))
            description = moved(description, rotation, rng.normal(size=3))
        return Robot(description)

    def passive(self, a: np.ndarray, first: float) -> np.ndarray:
        """Passive coordinates b, c, g (N, 3) of crank angles (N,) along a motion, by circles.

        b begins where it is nearest to `first`, and all go on without a jump.
        """
        ground, crank, rod, out = self.lengths
        pin = crank * np.stack([np.cos(a), np.sin(a)], axis=1)
        if self.kind == "prismatic":
            ahead = self.sign * np.sqrt(rod**2 - pin[:, 1] ** 2)
            c = pin[:, 0] + ahead - ground - out
            end = np.stack([pin[:, 0] + ahead, np.zeros_like(a)], axis=1)
        else:
            foot = np.array([ground, 0.0]) - pin
            far = np.linalg.norm(foot, axis=1)
            along = (rod**2 - out**2 + far**2) / (2.0 * far)
            off = self.sign * np.sqrt(rod**2 - along**2)
            unit = foot / far[:, None]
            normal = np.stack([-unit[:, 1], unit[:, 0]], axis=1)
            end = pin + along[:, None] * unit + off[:, None] * normal
            c = np.unwrap(np.arctan2(end[:, 1], end[:, 0] - ground))
        way = end - pin
        b = np.unwrap(np.arctan2(way[:, 1], way[:, 0]) - a)
        b += 2.0 * np.pi * np.rint((first - b[0]) / (2.0 * np.pi))
        return np.stack([b, c, RATIO * b + 0.3], axis=1)

    def torque(self, a: np.ndarray, first: float) -> np.ndarray:
        """Holding torque (N,) against the springs, the energy differentiated [N m]."""
        step = 1e-5

        def energy(angles: np.ndarray) -> np.ndarray:
            stretched = self.passive(angles, first) - np.array([self.rest, self.rest, 0.1])
            return 0.5 * np.sum(np.array(self.stiffness) * stretched**2, axis=1)

        return (energy(a + step) - energy(a - step)) / (2.0 * step)


@st.composite
def turning_linkages(draw: st.DrawFn) -> Turning:
    """Drag links, crank-rockers and slider-cranks whose crank goes all the way round."""
    kind = draw(st.sampled_from(["drag", "rocker", "slider"]))
    short = draw(st.floats(0.1, 0.25))
    p, q = draw(st.floats(0.35, 0.6)), draw(st.floats(0.35, 0.6))
    longest = p + q - short - 0.05  # Grashof: short + longest < p + q
    third = draw(st.floats(max(abs(p - q) + short + 0.05, 0.3), longest))
    lengths = {
        "drag": (short, p, q, third),
        "rocker": (p, short, third, q),
        "slider": (0.0, short, p, 0.0),
    }[kind]
    numbers = st.floats(0.2, 5.0)
    return Turning(
        "prismatic" if kind == "slider" else "revolute",
        lengths,
        draw(st.sampled_from([1, -1])),
        (draw(numbers), draw(numbers), draw(numbers)),
        draw(st.floats(-1.0, 1.0)),
        draw(st.floats(-0.6, 0.6)),
    )
