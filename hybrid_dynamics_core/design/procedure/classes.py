"""Description files of Class I, II and III, Chu et al. (2020), Section 2, from a few words.

Class I: parallel modules in series. Class II: parallel modules under a serial arm. Class III: local
closed loops appended to a serial arm.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import yaml

from ...errors import InputError
from ...ground.suggestions import no_such_name
from .arm import Arm, ArmLink, parse_links
from .loop_types import add_with_loops
from .loops import ArmLoop, parse_loops
from .modules import add_modules

RobotClass = Literal["I", "II", "III"]
CLASSES: tuple[RobotClass, ...] = ("I", "II", "III")
_COMMENT = "# Masses that were not given are those of slender rods of 20 kg/m (assumed)."
_SECTIONS = ("modules", "links", "joints", "loops")
_WIDE = 10_000  # characters of a line
_PARTS = {"I": ("modules",), "II": ("modules", "links"), "III": ("links", "loops")}


def robot_text(
    robot_class: RobotClass,
    links: str = "",
    loops: str = "",
    modules: str = "",
    name: str = "robot",
) -> str:
    """A description file from the structure of a robot and its dimensions.

    Args:
        robot_class: I, II or III.
        links: number of links of the arm, or a phrase for each: `yaw: length=0.3; pitch: ...`.
        loops: a phrase for each loop: `A: joint=q2 pivot=-0.7,0.3 pin=0.4,0 barrel=0.4; B: ...`.
        modules: a phrase for each module: `3-UPU: base_radius=0.4 platform_radius=0.2 ...`.
        name: name of the robot.

    Returns:
        YAML. Masses that are not given are those of rods of 20 kg/m; a comment says so.

    Raises:
        InputError: a part is missing, or is not of this class, or has another form; a loop does not
            close at the reference.
    """
    if robot_class not in CLASSES:
        raise InputError(no_such_name("class", robot_class, CLASSES))
    given = {"links": links, "loops": loops, "modules": modules}
    for part, text in given.items():
        is_part = part in _PARTS[robot_class]
        if is_part and not text.strip():
            raise InputError(f"Class {robot_class} has {part}: give them")
        if text.strip() and not is_part:
            raise InputError(f"Class {robot_class} has no {part}")
    arm = Arm(_empty(name, robot_class))
    if modules:
        add_modules(arm, modules)
    if links:
        parts = parse_links(links)
        _add_arm(arm, parts, parse_loops(loops, parts) if loops else ())
    _end(arm)
    lines = [_COMMENT]
    for section, entries in arm.data.items():
        lines += _lines(section, entries)
    return "\n".join(lines) + "\n"


def _lines(section: str, entries: Any) -> list[str]:
    """A section of a description file, with a line for each entry."""
    if section not in _SECTIONS:
        return [f"{section}: {_flow(entries)}"]
    if not entries:
        return []
    return [f"{section}:", *(f"  {name}: {_flow(entry)}" for name, entry in entries.items())]


def _flow(entry: Any) -> str:
    """YAML in one line."""
    text = yaml.dump(entry, Dumper=_Plain, default_flow_style=True, sort_keys=False, width=_WIDE)
    return text.removesuffix("...\n").strip()


class _Plain(yaml.SafeDumper):
    """Writes equal lists out, without references."""

    def ignore_aliases(self, data: Any) -> bool:  # noqa: ARG002
        """Whether to write a value out."""
        return True


def _empty(name: str, robot_class: str) -> dict[str, Any]:
    source = f"designed as Class {robot_class} of Chu et al. (2020), Section 2"
    data: dict[str, Any] = {"format": 1, "name": name, "source": source}
    data["modules"] = {}
    data["links"] = {"base": {}}
    for section in ("joints", "loops"):
        data[section] = {}
    data["active"] = []
    data["end_effector"] = {}
    data["reference"] = {}
    return data


def _add_arm(arm: Arm, links: Sequence[ArmLink], loops: Sequence[ArmLoop]) -> None:
    for link in links:
        add_with_loops(arm, link, [loop for loop in loops if loop.joint == link.joint])


def _end(arm: Arm) -> None:
    """Add the end effector, and put the loops in order."""
    xyz = arm.xyz_on(arm.tip, arm.end_of(arm.tip))
    arm.data["end_effector"] = {"link": arm.tip, "xyz": xyz}
    loops = arm.data["loops"]
    arm.data["loops"] = {name: loops[name] for name in sorted(loops)}
