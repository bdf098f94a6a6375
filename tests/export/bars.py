"""A four-bar as a URDF with a robot.yaml, whose loop closes beyond the limits of its hinge only."""

from __future__ import annotations

INERTIAL = '<inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01"/></inertial>'
LIMITED = f"""<robot name="bars">
  <link name="ground"/>
  <link name="crank">{INERTIAL}</link>
  <link name="coupler">{INERTIAL}</link>
  <link name="rocker">{INERTIAL}</link>
  <link name="end_A"/>
  <link name="end_B"/>
  <joint name="motor" type="continuous">
    <parent link="ground"/><child link="crank"/><axis xyz="0 0 1"/></joint>
  <joint name="knee" type="continuous">
    <origin xyz="0.1 0 0" rpy="0 0 -1"/>
    <parent link="crank"/><child link="coupler"/><axis xyz="0 0 1"/></joint>
  <joint name="hinge" type="revolute">
    <origin xyz="0.3 0 0" rpy="0 0 2"/>
    <parent link="ground"/><child link="rocker"/><axis xyz="0 0 1"/>
    <limit lower="-0.01" upper="0.01" effort="1" velocity="1"/></joint>
  <joint name="A" type="fixed">
    <origin xyz="0.3 0 0"/><parent link="coupler"/><child link="end_A"/></joint>
  <joint name="B" type="fixed">
    <origin xyz="0.2 0 0"/><parent link="rocker"/><child link="end_B"/></joint>
</robot>
"""
PAIR = "closed_loop: [['end_A', 'end_B']]\ntype: ['3d']\nname_mot: ['motor']\n"
