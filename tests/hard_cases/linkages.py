"""Planar linkages with the dimensions that a test wants, as description files."""

from __future__ import annotations

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.formats.reader import parse_description

HEAD = "format: 1\nname: linkage\n"


def robot(text: str) -> Robot:
    """A robot from the text of a file."""
    return Robot(parse_description(text, file="linkage.yaml"))


def four_bar(
    ground: float,
    crank: float,
    coupler: float,
    rocker: float,
    assembly: str = "counterclockwise",
    active: str = "q1",
    reference: str = "q1: 1",
) -> str:
    """Type A: crank q1 and coupler q2 on it, rocker q3.

    All angles counterclockwise, q2 from the crank.
    """
    named = f", assembly: {assembly}" if assembly else ""
    return (
        HEAD + "links: {base: {}, crank: {mass: 1}, coupler: {mass: 1, com: [0.1, 0, 0]},"
        " rocker: {mass: 1}}\njoints:\n  q1: {type: revolute, parent: base, child: crank,"
        " axis: z}\n  q2: {type: revolute, parent: crank, child: coupler, origin: {xyz:"
        f" [{crank!r}, 0, 0]}}, axis: z}}\n  q3: {{type: revolute, parent: base, child: rocker,"
        f" origin: {{xyz: [{ground!r}, 0, 0]}}, axis: z}}\nloops:\n  bar: {{type: A, base: base,"
        f" arm: rocker, k1: crank, k2: coupler, pin: {{coupler: [{coupler!r}, 0, 0], rocker:"
        f" [{rocker!r}, 0, 0]}}{named}}}\nactive: [{active}]\nend_effector: {{link:"
        f" rocker}}\nreference: {{{reference}}}\n"
    )


def cylinder(
    distance: float, radius: float, active: str = "stroke", assembly: str = "counterclockwise"
) -> str:
    """A cylinder that turns a lever of some radius.

    Its foot stands at a distance to the left of the lever's pivot.

    stroke: distance from foot to pin; lever: its angle from straight ahead, tilt: that of the
    cylinder.
    """
    return (
        HEAD + "links: {base: {}, barrel: {mass: 1}, rod: {mass: 1}, lever: {mass: 1, com:"
        " [0.1, 0, 0]}}\njoints:\n  tilt: {type: revolute, parent: base, child: barrel,"
        f" origin: {{xyz: [{-distance!r}, 0, 0]}}, axis: z}}\n  stroke: {{type: prismatic,"
        " parent: barrel, child: rod, axis: x}\n  lever: {type: revolute, parent: base, child:"
        " lever, axis: z}\nloops:\n  lift: {type: A, base: base, arm: lever, k1: barrel, k2:"
        f" rod, pin: {{rod: [0, 0, 0], lever: [{radius!r}, 0, 0]}}, assembly:"
        f" {assembly}}}\nactive: [{active}]\nend_effector: {{link: lever}}\nreference: {{stroke:"
        f" {distance!r}, lever: 1.2, tilt: 0.4}}\n"
    )
