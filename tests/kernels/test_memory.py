"""A batch needs little more memory than its input and output."""

from __future__ import annotations

import subprocess
import sys

import pytest

pytest.importorskip("resource")

SCRIPT = """
import resource
import numpy as np
from hybrid_dynamics_core import load

robot = load("forging_chu2020")
u = np.tile(robot.reference, (500_000, 1))
du, ddu = np.zeros_like(u), np.zeros_like(u)
robot.kernels.inverse_dynamics(u[:10], du[:10], ddu[:10])
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
tau = robot.kernels.inverse_dynamics(u, du, ddu)
more = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024
print(more / (3 * u.nbytes + tau.nbytes))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="the unit of ru_maxrss differs between systems")
def test_a_batch_takes_less_than_its_arrays_again() -> None:
    """The output is a quarter of the arrays; the other room is for rows at work."""
    answer = subprocess.run(
        [sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=True
    )
    assert float(answer.stdout) < 1.0
