"""Andrews' squeezing mechanism, a planar one of seven bodies: the published initial value problem.

Schiehlen's multibody handbook, and the test set of initial value problems (Mazzia, Magherini),
problem Andrews: data, accelerations at the start, and the angles at 0.03 s. theta has gone round
more than twice by then.
"""

from __future__ import annotations

import pytest

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.simulation import Settings, simulate

TEXT = """\
format: 1
name: andrews
gravity: [0, 0, 0]
links:
  base: {}
  K1: {mass: 0.04325, com: [0.00092, 0, 0], inertia: {zz: 2.194e-06, xx: 1.097e-06, yy: 1.097e-06}}
  K2: {mass: 0.00365, com: [-0.0115, 0, 0], inertia: {zz: 4.41e-07, xx: 2.205e-07, yy: 2.205e-07}}
  K3: {mass: 0.02373, com: [0.01043, -0.01874, 0], inertia: {zz: 5.255e-06, xx: 2.6275e-06,
      yy: 2.6275e-06}}
  K4: {mass: 0.00706, com: [0, -0.00579, 0], inertia: {zz: 5.667e-07, xx: 2.8335e-07,
      yy: 2.8335e-07}}
  K5: {mass: 0.0705, com: [0.00916, -0.02308, 0], inertia: {zz: 1.169e-05, xx: 5.845e-06,
      yy: 5.845e-06}}
  K6: {mass: 0.00706, com: [0.00579, 0, 0], inertia: {zz: 5.667e-07, xx: 2.8335e-07,
      yy: 2.8335e-07}}
  K7: {mass: 0.05498, com: [0.01228, -0.00449, 0], inertia: {zz: 1.912e-05, xx: 9.56e-06,
      yy: 9.56e-06}}
  S1: {}
  S2: {}
joints:
  beta: {type: revolute, parent: base, child: K1, axis: z}
  theta: {type: revolute, parent: K1, child: K2, axis: z, origin: {xyz: [0.007, 0, 0]}}
  gamma: {type: revolute, parent: base, child: K3, axis: z, origin: {xyz: [-0.03635, 0.03273, 0]}}
  delta: {type: revolute, parent: base, child: K5, axis: z, origin: {xyz: [-0.06934, -0.00227, 0]}}
  phi: {type: revolute, parent: K5, child: K4, axis: z, origin: {xyz: [0.04, 0, 0]}}
  epsilon: {type: revolute, parent: base, child: K7, axis: z, origin: {xyz: [-0.06934, -0.00227,
      0]}}
  Omega: {type: revolute, parent: K7, child: K6, axis: z, origin: {xyz: [0, -0.04, 0]}}
  sa: {type: revolute, parent: base, child: S1, axis: z, origin: {xyz: [0.014, 0.072, 0]}}
  sl: {type: prismatic, parent: S1, child: S2, axis: x, spring: {stiffness: 4530.0, rest: 0.07785}}
closures:
  F3: {kind: planar, between: {K2: [-0.028, 0, 0], K3: [0, -0.035, 0]}}
  F4: {kind: planar, between: {K2: [-0.028, 0, 0], K4: [0, -0.02, 0]}}
  F6: {kind: planar, between: {K2: [-0.028, 0, 0], K6: [0.02, 0, 0]}}
  D: {kind: planar, between: {S2: [0, 0, 0], K3: [0.02, -0.018, 0]}}
active: [beta]
end_effector: {link: K2, xyz: [-0.028, 0, 0]}
reference: {beta: -0.06171389001427645, theta: 0.0, gamma: 0.45527981916307037,
    phi: 0.22266839016588588, delta: 0.48736497954384256, Omega: -0.22266839016588588,
        epsilon: 1.2305474445498212, sa: -2.0539951004530517, sl: 0.052672516110736665}
"""
TORQUE = 0.033  # [N m] on the crank, from rest
END = 0.03  # [s]
ANGLES = {  # [rad] at the end
    "beta": 15.81077119629904,
    "theta": -15.75637105984298,
    "gamma": 0.04082224013073101,
    "phi": -0.5347301163226948,
    "delta": 0.5244099658805304,
    "Omega": 0.5347301163226948,
    "epsilon": 1.048080741042263,
}


@pytest.fixture(scope="module")
def mechanism() -> Robot:
    return Robot(parse_description(TEXT, file="andrews.yaml"))


def test_accelerations_at_the_start(mechanism: Robot) -> None:
    state = mechanism.close(mechanism.reference)
    ddu = mechanism.forward_dynamics(state, [TORQUE])
    values = mechanism.accelerations(state, ddu).tolist()
    by_name = dict(zip(mechanism.coordinates, values, strict=True))
    assert by_name["beta"] == pytest.approx(14222.443919954, rel=1e-9)
    assert by_name["theta"] == pytest.approx(-10666.832939966, rel=1e-9)


@pytest.mark.sweep(sample="test_accelerations_at_the_start")
def test_all_angles_at_the_end_with_their_turns(mechanism: Robot) -> None:
    start = mechanism.close(mechanism.reference)
    motion = simulate(mechanism, start, None, [TORQUE], (0.0, END), Settings(rate=1000.0))
    by_name = dict(zip(mechanism.coordinates, motion.state.s[-1].tolist(), strict=True))
    assert {name: by_name[name] for name in ANGLES} == pytest.approx(ANGLES, abs=1e-6)
    assert motion.state.turns["theta"][-1] == -3
