"""The motion of Chu et al. (2020), Section 3, that their Figures 8, 9 and 10 are about."""

from __future__ import annotations

import numpy as np

from hybrid_dynamics_core.control import JointTrajectory

START = np.array([0.0, 0.10, 0.15, 0.0])  # q1 [rad], q12 [m], q22 [m], q4 [rad]
# Per second, constant for 10 s: u'' = 0.
RATES = np.array([np.deg2rad(10.0), 0.01, 0.005, np.deg2rad(5.0)])
MOTION = JointTrajectory([0.0, 10.0], [START, START + 10.0 * RATES], [RATES, RATES])
LAW = "q1 = 10 deg/s t, q12 = 0.1 m + 0.01 m/s t, q22 = 0.15 m + 0.005 m/s t, q4 = 5 deg/s t"
