"""Small robots as texts, for tests of the format."""

from __future__ import annotations

from hybrid_dynamics_core.description import RobotDescription
from hybrid_dynamics_core.formats.reader import parse_description

HEAD = "format: 1\nname: small\nsource: invented\n"

FOUR_BAR_LINKS = """\
links:
  base: {}
  crank: {mass: 1, com: [0.05, 0, 0], inertia: {rod: {axis: x, length: 0.1}}}
  coupler: {mass: 2, com: [0.15, 0, 0], inertia: {rod: {axis: x, length: 0.3}}}
  rocker: {mass: 1.5, com: [0.1, 0, 0], inertia: {rod: {axis: x, length: 0.2}}}
  tool: {mass: 0.5}
"""


def four_bar(letter: str) -> str:
    """One four-bar of a 0.1 m crank, 0.3 m coupler and 0.2 m rocker on a 0.3 m base, cut by type.

    The roles: the crank is l_k1; a tool hangs on the link from which the arm goes on.
    """
    crank = "  q1: {type: revolute, parent: base, child: crank, axis: z}\n"
    rocker = (
        "  q3: {type: revolute, parent: base, child: rocker, origin: {xyz: [0.3, 0, 0]}, axis: z}\n"
    )
    on_crank = (
        "  q2: {type: revolute, parent: crank, child: coupler, origin: {xyz: [0.1, 0, 0]}, axis:"
        " z}\n"
    )
    on_rocker = (
        "  q2: {type: revolute, parent: rocker, child: coupler, origin: {xyz: [0.2, 0, 0]}, axis:"
        " z}\n"
    )
    to_rocker, to_crank = (
        "{coupler: [0.3, 0, 0], rocker: [0.2, 0, 0]}",
        "{coupler: [0.3, 0, 0], crank: [0.1, 0, 0]}",
    )
    coupler, pin, arm, k2, output = {
        "A": (on_crank, to_rocker, "rocker", "coupler", "rocker"),
        "B": (on_rocker, to_crank, "rocker", "coupler", "coupler"),
        "C": (on_rocker, to_crank, "coupler", "rocker", "coupler"),
        "D": (on_crank, to_rocker, "coupler", "rocker", "rocker"),
    }[letter]
    return (
        HEAD
        + FOUR_BAR_LINKS
        + "joints:\n"
        + crank
        + rocker
        + coupler
        + f"  q4: {{type: revolute, parent: {output}, child: tool, origin: {{xyz: [0.25, 0, 0]}},"
        " axis: x}\n"
        + f"loops:\n  bar: {{type: {letter}, base: base, arm: {arm}, k1: crank, k2: {k2}, pin:"
        f" {pin}, "
        + "assembly: counterclockwise}\n"
        + "active: [q1, q4]\nend_effector: {link: tool}\nreference: {q1: 1}\n"
    )


def parse(text: str) -> RobotDescription:
    """A description from text."""
    return parse_description(text, file="small.yaml")
