"""Chu et al. (2020), the forging robot: every row of the reference values, single and as a batch.

The file beside this test holds values that four independent computations agree on to 1e-11 (see its
`about`). The paper's print differs where docs/errata.md says so.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from hybrid_dynamics_core import IKStatus, Pose, Robot

REFERENCE = json.loads((Path(__file__).parent / "forging_chu2020.json").read_text(encoding="utf-8"))
ROWS = REFERENCE["trajectory"] + REFERENCE["random"]
TOLERANCE = 1e-9  # relative, entry by entry: two digits above what the sources agree to
ROUNDING = 1e-13  # of the largest entry: zeros come out as rounding of what cancels


def close_to(value: np.ndarray, expected: list[float] | np.ndarray) -> bool:
    expected = np.asarray(expected)
    allowed = TOLERANCE * np.abs(expected) + ROUNDING * max(np.abs(expected).max(), 1.0)
    return bool((np.abs(value - expected) <= allowed).all())


def test_names_and_order_are_the_papers(forging: Robot) -> None:
    assert list(forging.active) == REFERENCE["u_names"]
    assert list(forging.passive) == REFERENCE["z_names"]
    assert forging.coordinates == forging.active + forging.passive


def test_masses_and_inertias_are_the_papers(forging: Robot) -> None:
    links = forging.description.links
    assert [links[name].mass for name in REFERENCE["body"]] == REFERENCE["mass"]
    inertias = REFERENCE["inertia_link_frame"]["slender"]
    for name, inertia in zip(REFERENCE["body"], inertias, strict=True):
        # The frames of l1 and l32 lie otherwise on the rod: only moments are compared.
        ours = np.linalg.eigvalsh(links[name].inertia)
        assert ours == pytest.approx(np.linalg.eigvalsh(inertia), rel=1e-12, abs=1e-15)


def label(row: dict) -> str:
    if "t" in row:
        return f"t={row['t']}"
    return f"random {row['index']}"


@pytest.mark.parametrize("row", ROWS, ids=label)
class TestEveryRow:
    def test_passive_coordinates(self, forging: Robot, row: dict) -> None:
        state = forging.close(row["u"], row["ud"])
        assert close_to(state.z, row["z"])
        assert close_to(state.dz, row["zd"])
        assert close_to(forging.accelerations(state, row["udd"])[4:], row["zdd"])
        assert state.residual < 1e-14

    def test_end_effector(self, forging: Robot, row: dict) -> None:
        assert close_to(forging.forward_kinematics(forging.close(row["u"])).position, row["eef"])

    def test_minimal_form(self, forging: Robot, row: dict) -> None:
        mass, bias, gravity = forging.minimal_form(forging.close(row["u"], row["ud"]))
        assert close_to(mass, row["Mbar"])
        assert close_to(bias, row["Cbar_udot"])
        assert close_to(gravity, row["Gbar"])

    def test_inverse_dynamics(self, forging: Robot, row: dict) -> None:
        state = forging.close(row["u"], row["ud"])
        assert close_to(forging.inverse_dynamics(state, row["udd"]), row["tau"])


def test_all_rows_as_one_batch(forging: Robot) -> None:
    columns = {key: np.array([row[key] for row in ROWS]) for key in ("u", "ud", "udd")}
    state = forging.close(columns["u"], columns["ud"])
    position = forging.forward_kinematics(state).position
    tau = forging.inverse_dynamics(state, columns["udd"])
    for k, row in enumerate(ROWS):
        assert close_to(state.z[k], row["z"])
        assert close_to(position[k], row["eef"])
        assert close_to(tau[k], row["tau"])


def test_figure_9_inverse_kinematics_of_the_forward_kinematics(forging: Robot) -> None:
    """The joints come back to 1e-10, each point started from the one before."""
    time = np.linspace(0.0, 10.0, 101)
    u = np.stack(
        [np.deg2rad(10) * time, 0.1 + 0.01 * time, 0.15 + 0.005 * time, np.deg2rad(5) * time],
        axis=1,
    )
    poses = forging.forward_kinematics(forging.close(u))
    seed = u[0]
    for expected, position, rotation in zip(u, poses.position, poses.rotation, strict=True):
        result = forging.inverse_kinematics(Pose(position, rotation), seed=seed)
        assert result.status is IKStatus.SOLVED
        assert result.u == pytest.approx(expected, abs=1e-10)
        assert result.state is not None
        assert result.state.z == pytest.approx(forging.close(expected).z, abs=1e-10)
        alone = forging.inverse_kinematics(position, seed=seed)
        assert alone.u[:3] == pytest.approx(expected[:3], abs=1e-10)
        assert alone.redundant == ("q4",)  # the roll of the gripper does not move its tip
        seed = result.u


def test_level_carrier_stays_level(forging: Robot) -> None:
    """ERRATA: f8, Eq. 33, prints sin for cos; the carrier would tilt by tens of degrees."""
    for row in REFERENCE["trajectory"]:
        rotation = forging.forward_kinematics(forging.close(row["u"]), frame="l42").rotation
        assert rotation[2, 0] == pytest.approx(0.0, abs=1e-14)
        assert rotation[2, 1] == pytest.approx(1.0, abs=1e-14)
