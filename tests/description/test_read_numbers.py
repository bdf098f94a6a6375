"""Numbers of files that could be read in two ways, or that are missing."""

from __future__ import annotations

from pathlib import Path

import pytest

from hybrid_dynamics_core import DescriptionError, Robot, load
from hybrid_dynamics_core.formats.reader import parse_description

ARM = """\
format: 1
name: arm
links: {{base: {{}}, a: {{mass: {mass}, com: [{com}, 0, 0]}}}}
joints:
  q: {{type: revolute, parent: base, child: a, axis: y}}
active: [q]
end_effector: {{link: a}}
"""
URDF = """\
<robot name="x"><link name="w"/>
<link name="a"><inertial><mass value="1"/>{inertia}</inertial></link>
<joint name="q" type="continuous"><parent link="w"/><child link="a"/><axis xyz="0 1 0"/></joint>
</robot>
"""
ENTRIES = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def test_integers_are_decimal_as_yaml_1_2_has_them() -> None:
    machine = Robot(parse_description(ARM.format(mass="012", com=0.1), file="arm.yaml"))
    assert machine.description.links["a"].mass == 12.0


def test_pi_is_no_name_for_a_parameter() -> None:
    text = ARM.format(mass=1, com="pi") + "parameters: {pi: 3}\n"
    with pytest.raises(DescriptionError, match=r"parameters\.pi: is the number 3\.14159"):
        parse_description(text, file="arm.yaml")


@pytest.mark.parametrize("missing", ENTRIES)
def test_an_inertia_of_urdf_has_six_numbers(missing: str, tmp_path: Path) -> None:
    present = [name for name in ENTRIES if name != missing]
    numbers = [f'{name}="{0.1 * (name[1] == name[2])}"' for name in present]
    file = tmp_path / "x.urdf"
    text = URDF.format(inertia=f"<inertia {' '.join(numbers)}/>")
    file.write_text(text, encoding="utf-8")
    if missing[1] == missing[2]:
        with pytest.raises(DescriptionError, match=f"{missing} is missing"):
            load(file)
        return
    assert any(
        f"<inertia> has no {missing}; taken: 0" in note for note in load(file).description.notes
    )
