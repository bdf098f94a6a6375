"""Small URDF, URDF+ and robot.yaml files beside Pinocchio: the short form of tools/public_files.py.

Ties, couplings and rotors are read once more by the tool, so both readings have to agree.
"""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from hybrid_dynamics_core import load
from tests.docs.blocks import ROOT

SAME = 1e-9


def tool(name: str) -> ModuleType:
    """A module of tools/, which is no package."""
    folder = str(ROOT / "tools")
    if folder not in sys.path:
        sys.path.append(folder)
    return importlib.import_module(name)


def link(name: str, mass: float) -> str:
    """A link with an inertia that belongs to no symmetric body."""
    return (
        f'<link name="{name}"><inertial><origin xyz="0.11 0.02 -0.03" rpy="0.1 0.2 0.3"/>'
        f'<mass value="{mass}"/><inertia ixx="0.02" iyy="0.03" izz="0.035" ixy="0.001"'
        ' ixz="0.002" iyz="-0.001"/></inertial></link>\n'
    )


def joint(
    name: str, ends: str, place: str = "0 0 0", more: str = "", kind: str = "continuous"
) -> str:
    """A joint about y, or of another type; `ends` are parent and child."""
    parent, child = ends.split()
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{place}" rpy="0.1 0 0"/><axis xyz="0 1 0"/>{more}</joint>\n'
    )


def flat(name: str, ends: str, place: str, independent: str = "true") -> str:
    """A joint of a planar loop."""
    text = joint(name, ends, place).replace('rpy="0.1 0 0"', 'rpy="0 0 0"')
    return text.replace("<joint ", f'<joint independent="{independent}" ')


TREE = (
    '<robot name="tree" xmlns:drake="http://drake.mit.edu"><link name="base"/>\n'
    + "".join(link(name, mass) for name, mass in (("a", 2), ("b", 1.5), ("c", 1), ("d", 0.5)))
    + joint("p", "base a", "0 0 0.2", '<dynamics damping="0.7"/>')
    + joint("q", "a b", "0.3 0 0", '<mimic joint="p" multiplier="-0.5" offset="0.2"/>')
    + joint("r", "b c", "0.2 0.1 0", '<mimic joint="q" multiplier="2" offset="-0.1"/>')
)
FOUR_BAR = (
    '<robot name="bars"><link name="base"/>\n'
    + "".join(link(name, mass) for name, mass in (("a", 2), ("b", 1.5), ("c", 1)))
    + flat("p", "base a", "0 0 0")
    + flat("q", "a b", "0 0 0.2", "false")
    + flat("r", "base c", "0.4 0 0", "false")
    + '<loop name="shut" type="revolute"><predecessor link="b"><origin xyz="0.4 0 0.1"/>'
    '</predecessor><successor link="c"><origin xyz="0 0 0.3"/></successor>'
    '<axis xyz="0 1 0"/></loop>'
)
FILES = {
    "followers of followers": TREE + joint("s", "c d", "0.1 0 0", kind="fixed"),
    "a free body on an arm": TREE + joint("s", "c d", "0.1 0 0", kind="floating"),
    "a rotor behind a gear": TREE
    + joint("s", "c d", "0.1 0 0")
    + '<transmission><joint name="s"/><actuator name="m"><drake:rotor_inertia value="0.001"/>'
    '<drake:gear_ratio value="-30"/></actuator></transmission>',
    "a coupling": TREE
    + joint("s", "c d", "0.1 0 0")
    + '<coupling name="belt"><predecessor link="a"/><successor link="d"/><ratio value="-1"/>'
    "</coupling>",
    "a loop": FOUR_BAR,
}


def compared(file: Path, moves: tuple[float, float] = (-0.2, 0.2)) -> None:
    """The same numbers at three states, and no gaps."""
    robot = load(file)
    other = tool("pinocchio_files").PinocchioFile(file)
    rng = np.random.default_rng(2)
    for _ in range(3):
        u = robot.reference + rng.uniform(*moves, len(robot.active))
        state = robot.close(u, rng.uniform(-1.0, 1.0, len(u)))
        different, gap = tool("pinocchio_motion").difference(robot, other, state)
        assert different < SAME
        assert gap < SAME


@pytest.mark.parametrize("text", FILES.values(), ids=FILES.keys())
def test_a_urdf_is_what_pinocchio_reads(tmp_path: Path, text: str) -> None:
    file = tmp_path / "robot.urdf"
    file.write_text(text + "</robot>")
    compared(file)


PAIRS = """closed_loop: [['end_b', 'end_c']]
type: ['3d']
name_mot: ['p']
joint_name: ['q', 'r']
joint_type: ['SPHERICAL', 'UJOINT_YX']
"""


def test_pairs_of_frames_and_joints_of_other_types(tmp_path: Path) -> None:
    bars = FOUR_BAR.partition("<loop ")[0] + '<link name="end_b"/><link name="end_c"/>'
    bars += joint("at_b", "b end_b", "0.4 0 0.1", kind="fixed")
    bars += joint("at_c", "c end_c", "0 0 0.3", kind="fixed")
    (tmp_path / "robot.urdf").write_text(bars + "</robot>")
    (tmp_path / "robot.yaml").write_text(PAIRS)
    compared(tmp_path / "robot.yaml", moves=(0.05, 0.1))


def test_a_wrong_reading_shows(tmp_path: Path) -> None:
    """The tool finds another ratio of a coupling, and another place of a pin."""
    file = tmp_path / "robot.urdf"
    file.write_text(FOUR_BAR + "</robot>")
    robot = load(file)
    state = robot.close(robot.reference, [1.0])
    file.write_text(FOUR_BAR.replace("0 0 0.3", "0 0 0.301") + "</robot>")
    assert (
        tool("pinocchio_motion").difference(
            robot, tool("pinocchio_files").PinocchioFile(file), state
        )[1]
        > 1e-4
    )
    file.write_text(FOUR_BAR.replace('value="1.5"', 'value="1.6"') + "</robot>")
    assert (
        tool("pinocchio_motion").difference(
            robot, tool("pinocchio_files").PinocchioFile(file), state
        )[0]
        > 1e-4
    )
