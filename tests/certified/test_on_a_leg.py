"""A platform that is carried by one of its six legs, as in files of trees."""

from __future__ import annotations

import pytest

from tests.hard_cases.linkages import robot

# Dietmaier (1998), with all forty poses real
ON_A_LEG = """
format: 1
name: on_a_leg
links:
  base: {}
  bar0: {mass: 1}
  rod0: {mass: 1}
  mid0: {}
  g1: {}
  g2: {}
  plat: {mass: 10, inertia: {sphere: {radius: 0.3}}}
joints:
  f0: {type: revolute, parent: base, child: bar0, axis: x, origin: {xyz: [1.0, 1.0, 0.0]}}
  t0: {type: revolute, parent: bar0, child: mid0, axis: y}
  l0: {type: prismatic, parent: mid0, child: rod0, axis: z}
  a1: {type: revolute, parent: rod0, child: g1, axis: x}
  a2: {type: revolute, parent: g1, child: g2, axis: y}
  a3: {type: revolute, parent: g2, child: plat, axis: z}
legs:
  leg1:
    joints:
      - {name: f1, type: revolute, axis: x, origin: {xyz: [2.107915, 1.0, 0.0]}}
      - {name: t1, type: revolute, axis: y, link: bar1, body: {mass: 1, com: [0,0,0.2]}}
      - {name: l1, type: prismatic, axis: z, link: rod1, body: {mass: 1, com: [0,0,-0.2]}}
    to: {plat: [0.542805, 0.0, 0.0]}
  leg2:
    joints:
      - {name: f2, type: revolute, axis: x, origin: {xyz: [1.549094, 1.756063, 0.0]}}
      - {name: t2, type: revolute, axis: y, link: bar2, body: {mass: 1, com: [0,0,0.2]}}
      - {name: l2, type: prismatic, axis: z, link: rod2, body: {mass: 1, com: [0,0,-0.2]}}
    to: {plat: [0.956919, -0.528915, 0.0]}
  leg3:
    joints:
      - {name: f3, type: revolute, axis: x, origin: {xyz: [1.735077, 0.776065, 0.525991]}}
      - {name: t3, type: revolute, axis: y, link: bar3, body: {mass: 1, com: [0,0,0.2]}}
      - {name: l3, type: prismatic, axis: z, link: rod3, body: {mass: 1, com: [0,0,-0.2]}}
    to: {plat: [0.665885, -0.353482, 1.402538]}
  leg4:
    joints:
      - {name: f4, type: revolute, axis: x, origin: {xyz: [1.514188, 0.473937, -0.368418]}}
      - {name: t4, type: revolute, axis: y, link: bar4, body: {mass: 1, com: [0,0,0.2]}}
      - {name: l4, type: prismatic, axis: z, link: rod4, body: {mass: 1, com: [0,0,-0.2]}}
    to: {plat: [0.478359, 1.158742, 0.107672]}
  leg5:
    joints:
      - {name: f5, type: revolute, axis: x, origin: {xyz: [1.590473, 1.094733, -0.205018]}}
      - {name: t5, type: revolute, axis: y, link: bar5, body: {mass: 1, com: [0,0,0.2]}}
      - {name: l5, type: prismatic, axis: z, link: rod5, body: {mass: 1, com: [0,0,-0.2]}}
    to: {plat: [-0.137087, -0.235121, 0.353913]}
active: [l0, l1, l2, l3, l4, l5]
end_effector: {link: plat}

reference:
  l0: 1.0
  l1: 0.6452749999999998
  l2: 1.0862840000000005
  l3: 1.5034389999999993
  l4: 1.281933
  l5: 0.771071
  f0: -1.7006005967344404
  t0: 0.7308892937317576
  f1: -1.244102360979618
  t1: -1.1518092128429847
  f2: 1.0707597790792138
  t2: 0.28397514134701474
  f3: 2.9464413366241677
  t3: 0.4724880596212923
  f4: -1.8659540467105045
  t4: -0.7919180994434382
  f5: -1.7203339594383849
  t5: 0.662624318244188
  a1: -1.4956696736792159
  a2: 0.5844100993656531
  a3: 1.041127914862174
"""


@pytest.mark.sweep(sample="test_all_modes_are_listed_and_closed")
def test_forty_modes_of_a_platform_on_a_leg() -> None:
    machine = robot(ON_A_LEG)
    modes = machine.assembly_modes(machine.reference)
    assert len(modes) == 40
    assert modes.complete
    assert max(mode.state.residual for mode in modes) < 1e-12
