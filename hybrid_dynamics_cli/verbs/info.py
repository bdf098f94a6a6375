"""Properties of a robot: its coordinates, loops and links."""

from __future__ import annotations

from typing import Any

import click

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.ground.units import coordinate_unit
from hybrid_dynamics_core.ground.wording import counted, singular_or_plural

from ..drive_limits import hydraulic_facts, joint_facts, limit_tables, limit_text
from ..limits import narrowed
from ..output import ROUNDING, number, plain, show, table
from ..parameters import json_option, loaded, robot_argument

EPILOG = """\b
Examples:
  hybrid-dynamics info forging_chu2020
  hybrid-dynamics info my_robot.yaml --json
"""
INERTIAS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))  # moments and products


@click.command(epilog=EPILOG)
@robot_argument
@json_option
def command(robot: str, as_json: bool) -> None:
    """Show coordinates, limits, loops, joints, masses and inertias of a robot."""
    machine = loaded(robot)
    notes = narrowed(machine)
    data = {**facts(machine), "notes": notes}
    tables = [text(machine, data), tree(machine), masses(machine), *inertias(machine)]
    note_lines = [f"note: {note}" for note in notes]
    lines = ["\n\n".join(tables), "", *note_lines]
    show(data, as_json, "\n".join(lines))


def facts(machine: Robot) -> dict[str, Any]:
    """The properties of a robot as plain data.

    Returns:
        For each link `mass` [kg], and in the frame of the link `com` (3,) [m] and `inertia` (3, 3)
        [kg m^2] about it. For each loop its `distance_to_singularity` at the reference, 0 to 1.
        `gravity` (3,) [m/s^2] in the base frame. Other properties by name.
    """
    description = machine.description
    state = machine.close(machine.reference)
    loops = []
    for loop, distance in zip(state.loops, state.distances, strict=True):
        branch = state.branch.get(loop)
        entry = {"name": loop, "branch": branch, "distance_to_singularity": float(distance)}
        loops.append(entry)
    links = {}
    for name, link in description.links.items():
        if name not in description.links_in_rows:
            links[name] = {"mass": link.mass, "com": link.com, "inertia": link.inertia}
    multi_dof = {}
    for name, joint in description.multi_dof.items():
        multi_dof[name] = {"type": joint.type, "coordinates": list(joint.joints)}
    parts = {}
    for name, part in description.parts.items():
        parts[name] = {"part_of": description.body_of(name), "mass": part.mass}
    return {
        "name": machine.name,
        "base": machine.base_frame,
        "end_effector": machine.end_effector,
        "active": list(machine.description.motors),
        "idle": list(machine.idle),
        "coordinates": _coordinates(machine, state.s.tolist()),
        "multi_dof": multi_dof,
        **hydraulic_facts(description),
        "loops": loops,
        "redundant_equations": dict(machine.redundant_equations),
        "links": links,
        "parts": parts,
        "gravity": plain(description.gravity),
        "frames": list(machine.frames),
    }


def _coordinates(machine: Robot, reference: list[float]) -> list[dict[str, Any]]:
    """Type, links, reference and limits [rad or m] of every coordinate.

    Args:
        machine: the robot.
        reference: values of all coordinates at the reference (n_s,) [rad or m].
    """
    active_limits = dict(zip(machine.active, machine.limits, strict=True))
    coordinates = []
    for name, value in zip(machine.coordinates, reference, strict=True):
        joint = machine.description.joints[name]
        limits = active_limits.get(name, list(joint.limits))
        entry = {
            "name": name,
            "type": machine.joint_types[name],
            "active": name in machine.description.motors,
            "idle": name in machine.idle,
            "parent": joint.parent,
            "child": joint.child,
            "reference": value,
            "limits": plain(limits),
            **joint_facts(joint),
        }
        coordinates.append(entry)
    return coordinates


def text(machine: Robot, data: dict[str, Any]) -> str:
    """The properties as tables.

    Args:
        machine: the robot.
        data: result of `facts`.
    """
    active = _freedoms(machine)
    mass = sum(link["mass"] for link in data["links"].values())
    loops = counted(len(data["loops"]), "loop")
    rows = [_coordinate_row(entry) for entry in data["coordinates"]]
    lines = [
        f"{machine.name}: {active}, {loops}, {_link_count(data)}, {number(mass)} kg",
        f"end effector: {machine.end_effector}",
        "",
        table(["coordinate", "", "type", "reference", "lower", "upper", "unit"], rows),
    ]
    if data["multi_dof"]:
        lines.append("")
    for name, joint in data["multi_dof"].items():
        lines.append(f"{name}: {joint['type']} joint, {', '.join(joint['coordinates'])}")
    lines += limit_tables(data["coordinates"], data)
    if data["loops"]:
        lines += ["", _loop_table(data["loops"])]
    for loop, count in data["redundant_equations"].items():
        equations = counted(count, "equation")
        follow = singular_or_plural(count, "follows", "follow")
        lines.append(f"{loop}: {equations} of it {follow} from the others")
    if data["parts"]:
        lines += ["", *part_lines(data)]
    return "\n".join(lines)


def _freedoms(machine: Robot) -> str:
    """The numbers of independent, driven and idle coordinates."""
    parts = [f"{len(machine.description.motors)} active"]
    if machine.idle:
        parts.append(f"{len(machine.idle)} idle")
    return f"{' and '.join(parts)} of {counted(len(machine.coordinates), 'coordinate')}"


def _coordinate_row(entry: dict[str, Any]) -> list[object]:
    lower, upper = map(limit_text, entry["limits"])
    active = "idle" if entry["idle"] else ""
    if entry["active"]:
        active = "active"
    row = [entry["name"], active, entry["type"], entry["reference"]]
    return [*row, lower, upper, coordinate_unit(entry["type"])]


def _loop_table(loops: list[dict[str, Any]]) -> str:
    rows = [[loop["name"], loop["branch"] or "", loop["distance_to_singularity"]] for loop in loops]
    return table(["loop", "assembly mode", "to singularity (0..1)"], rows)


def _link_count(data: dict[str, Any]) -> str:
    bodies = len(data["links"])
    fixed = len(data["parts"])
    links = counted(bodies + fixed, "link")
    if not fixed:
        return links
    return f"{links} in {counted(bodies, 'body', 'bodies')}"


def part_lines(data: dict[str, Any]) -> list[str]:
    """A line for each body with fixed links, with their names."""
    bodies: dict[str, list[str]] = {}
    for name, part in data["parts"].items():
        entry = name
        if not part["mass"]:
            entry += " (without a mass)"
        bodies.setdefault(part["part_of"], []).append(entry)
    lines = []
    for body, entries in bodies.items():
        verb = singular_or_plural(len(entries), "is", "are")
        lines.append(f"{', '.join(entries)} {verb} part of {body}")
    return lines


def tree(machine: Robot) -> str:
    """A table of the joints with their parent and child links."""
    joints = [machine.description.joints[name] for name in machine.coordinates]
    rows = [[joint.name, joint.parent, joint.child] for joint in joints]
    return table(["joint", "parent", "child"], rows)


def masses(machine: Robot) -> str:
    """A table of mass and centre of mass (in the link's frame) of every body.

    Links that are fixed to a body count as part of it.
    """
    centres = [f"com {axis} [m]" for axis in "xyz"]
    rows = []
    for name, link in machine.description.links.items():
        rows.append([name, link.mass, *link.com.tolist()])
    return table(["link", "mass [kg]", *centres], rows)


def inertias(machine: Robot) -> list[str]:
    """A table of moments and products of inertia; empty if all bodies are point masses.

    They are about the centre of mass, along the axes of the link. Products that are zero for all
    bodies have no column.
    """
    links = {}
    for name, link in machine.description.links.items():
        if link.inertia.any():
            links[name] = link.inertia
    if not links:
        return []
    columns = []
    for i, k in INERTIAS:
        largest = max(abs(inertia[i, k]) for inertia in links.values())
        if i == k or largest > ROUNDING:
            columns.append((i, k))
    heads = [f"I{'xyz'[i]}{'xyz'[k]}" for i, k in columns]
    rows: list[list[object]] = []
    for name, inertia in links.items():
        values = [float(inertia[i, k]) for i, k in columns]
        rows.append([name, *values])
    title = "inertia about the centre of mass, along the axes of the link [kg m^2]"
    return [f"{title}\n\n{table(['link', *heads], rows)}"]
