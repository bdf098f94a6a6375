"""What a robot is: its coordinates, loops, links."""

from __future__ import annotations

from typing import Any

import click

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.ground.units import coordinate_unit
from hybrid_dynamics_core.ground.wording import counted, singular_or_plural

from ..limits import narrowed
from ..output import ROUNDING, number, plain, show, table
from ..parameters import json_option, loaded, robot_argument

EPILOG = """\b
Examples:
  hybrid-dynamics info forging_chu2020
  hybrid-dynamics info my_robot.yaml --json
"""


@click.command(epilog=EPILOG)
@robot_argument
@json_option
def command(robot: str, as_json: bool) -> None:
    """Show coordinates, limits, loops, joints, masses and inertias of a robot."""
    machine = loaded(robot)
    notes = narrowed(machine)
    told = {**facts(machine), "notes": notes}
    tables = [text(machine, told), tree(machine), masses(machine), *inertias(machine)]
    lines = ["\n\n".join(tables), "", *(f"note: {note}" for note in notes)]
    show(told, as_json, "\n".join(lines))


def facts(machine: Robot) -> dict[str, Any]:
    """What is to be known of a robot, as plain data."""
    state = machine.close(machine.reference)
    limits = {name: plain(machine.limits[k]) for k, name in enumerate(machine.active)}
    coordinates = [
        {
            "name": name,
            "type": machine.joint_types[name],
            "active": name in machine.active,
            "parent": machine.description.joints[name].parent,
            "child": machine.description.joints[name].child,
            "reference": float(state.s[k]),
            "limits": limits.get(name, plain(list(machine.description.joints[name].limits))),
        }
        for k, name in enumerate(machine.coordinates)
    ]
    return {
        "name": machine.name,
        "base": machine.base_frame,
        "end_effector": machine.end_effector,
        "active": list(machine.active),
        "coordinates": coordinates,
        "loops": [
            {
                "name": loop,
                "branch": state.branch.get(loop),
                "distance_to_singularity": float(distance),
            }
            for loop, distance in zip(state.loops, state.distances, strict=True)
        ],
        "redundant_equations": dict(machine.redundant_equations),
        "links": {
            name: {"mass": link.mass, "com": link.com, "inertia": link.inertia}
            for name, link in machine.description.links.items()
        },
        "parts": {
            name: {"part_of": machine.description.body_of(name), "mass": part.mass}
            for name, part in machine.description.parts.items()
        },
        "gravity": plain(machine.description.gravity),
        "frames": list(machine.frames),
    }


def text(machine: Robot, told: dict[str, Any]) -> str:
    """The facts as tables."""
    rows = []
    for entry in told["coordinates"]:
        lower, upper = (number(float("nan") if v is None else v) for v in entry["limits"])
        kind = coordinate_unit(entry["type"])
        rows.append(
            [
                entry["name"],
                "active" if entry["active"] else "",
                entry["type"],
                entry["reference"],
                lower,
                upper,
                kind,
            ]
        )
    mass = sum(link["mass"] for link in told["links"].values())
    title = (
        f"{machine.name}: {len(machine.active)} active of"
        f" {counted(len(machine.coordinates), 'coordinate')},"
        f" {counted(len(told['loops']), 'loop')}, {_links(told)}, {number(mass)} kg"
    )
    lines = [
        title,
        f"end effector: {machine.end_effector}",
        "",
        table(["coordinate", "", "type", "reference", "lower", "upper", "unit"], rows),
    ]
    if told["loops"]:
        loops = [
            [e["name"], e["branch"] or "", e["distance_to_singularity"]] for e in told["loops"]
        ]
        lines += ["", table(["loop", "assembly mode", "to singularity (0..1)"], loops)]
    for loop, count in told["redundant_equations"].items():
        lines.append(
            f"{loop}: {counted(count, 'equation')} of it {singular_or_plural(count, 'follows', 'follow')} from"
            " the others"
        )
    if told["parts"]:
        lines += ["", *parts(told)]
    return "\n".join(lines)


def _links(told: dict[str, Any]) -> str:
    bodies, fixed = len(told["links"]), len(told["parts"])
    return counted(bodies + fixed, "link") + (
        f" in {counted(bodies, 'body', 'bodies')}" if fixed else ""
    )


def parts(told: dict[str, Any]) -> list[str]:
    """Of which body the links are that are fixed to others, a line a body."""
    bodies: dict[str, list[str]] = {}
    for name, part in told["parts"].items():
        bodies.setdefault(part["part_of"], []).append(
            name if part["mass"] else f"{name} (without a mass)"
        )
    return [
        f"{', '.join(on)} {'is' if len(on) == 1 else 'are'} part of {body}"
        for body, on in bodies.items()
    ]


def tree(machine: Robot) -> str:
    """Which link every joint moves, and on which."""
    joints = [machine.description.joints[name] for name in machine.coordinates]
    return table(
        ["joint", "parent", "child"], [[joint.name, joint.parent, joint.child] for joint in joints]
    )


def masses(machine: Robot) -> str:
    """Mass and centre of mass of every body, what is fixed to it included."""
    head = ["link", "mass [kg]", *(f"com {axis} [m]" for axis in "xyz")]
    return table(
        head,
        [[name, link.mass, *link.com.tolist()] for name, link in machine.description.links.items()],
    )


def inertias(machine: Robot) -> list[str]:
    """Moments and products of inertia of the bodies that have any; products where not all of them are zero."""
    links = {
        name: link.inertia for name, link in machine.description.links.items() if link.inertia.any()
    }
    parts = [
        (f"I{'xyz'[i]}{'xyz'[k]}", i, k)
        for i, k in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
        if i == k or any(abs(inertia[i, k]) > ROUNDING for inertia in links.values())
    ]
    rows = [[name, *(float(inertia[i, k]) for _, i, k in parts)] for name, inertia in links.items()]
    title = "inertia about the centre of mass, along the axes of the link [kg m^2]"
    return [f"{title}\n\n{table(['link', *(head for head, _, _ in parts)], rows)}"] if rows else []
