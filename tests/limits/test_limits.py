"""Limits of drives: read, kept, judged by name and margin, and kept by simulations."""

from __future__ import annotations

import json

import numpy as np
import pytest

from hybrid_dynamics_core import DescriptionError, Robot
from hybrid_dynamics_core.description.actuators import EffortTable, Pump
from hybrid_dynamics_core.export import to_mjcf, to_sdf, to_urdf_plus, to_yaml
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.limits import LimitMargins
from hybrid_dynamics_core.simulation import Settings, simulate
from tests.cli.calling import call
from tests.limits.machines import CRANE, crane

LITRE_A_MINUTE = 1e-3 / 60.0
ARM = "arm_pitch: {type: revolute,"
ARM_LIMITED = (
    "arm_pitch: {type: revolute, acceleration_limit: 3*rad/s/s,"
    " effort_table: {rate: [0, 1], position: [-1, 1], effort: [[10, 8], [12, 9]]},"
)


@pytest.fixture(scope="module")
def machine() -> Robot:
    return crane((ARM, ARM_LIMITED))


def test_limits_of_drives_are_read_with_their_units(machine: Robot) -> None:
    description = machine.description
    lift, boom = (description.actuators[f"{name}_cylinder"] for name in ("lift", "boom"))
    assert lift.flow_limit == pytest.approx(80.0 * LITRE_A_MINUTE)
    assert (lift.highest_pressure, boom.highest_pressure) == (210e5, 210e5)
    cylinders = ("lift_cylinder", "boom_cylinder")
    assert description.pumps == {"main": Pump(cylinders, 100.0 * LITRE_A_MINUTE, 5e3)}
    joint = description.joints["arm_pitch"]
    assert joint.acceleration_limit == 3.0
    assert joint.effort_limit == 12.0  # the largest of the table


def test_a_table_is_linear_between_its_entries_and_constant_beyond() -> None:
    table = EffortTable(
        np.array([0.0, 2.0]), np.array([-1.0, 1.0]), np.array([[10.0, 6.0], [20.0, 8.0]])
    )
    assert table.at([-1, 1, 0, 0, -9, 9], [0, -2, 0, 1, -5, 5]) == pytest.approx(
        [10.0, 8.0, 15.0, 11.0, 6.0, 8.0]
    )
    single = EffortTable(np.array([0.0]), np.array([0.0]), np.array([[3.0]]))
    assert single.at([-4.0, 4.0], [1.0, 9.0]).tolist() == [3.0, 3.0]


@pytest.mark.parametrize("write", [to_yaml, to_urdf_plus, to_sdf, to_mjcf])
def test_every_format_keeps_them(machine: Robot, write, tmp_path) -> None:
    suffix = {to_yaml: "yaml", to_sdf: "sdf", to_mjcf: "xml"}.get(write, "urdf")
    file = tmp_path / f"crane.{suffix}"
    file.write_text(write(machine.description))
    from hybrid_dynamics_core import load

    back = load(file).description
    one = machine.description
    assert back.pumps == one.pumps
    assert back.actuators == one.actuators
    joint, other = one.joints["arm_pitch"], back.joints["arm_pitch"]
    assert other.acceleration_limit == joint.acceleration_limit
    assert other.effort_limit == joint.effort_limit
    for part in ("rates", "positions", "efforts"):
        kept = getattr(other.effort_table, part)
        np.testing.assert_array_equal(kept, getattr(joint.effort_table, part))


BAD = {
    "no such cylinder": (
        ("cylinders: [lift_cylinder, ", "cylinders: [lift_cylindr, "),
        r"pumps.main.cylinders: .*lift_cylindr.*lift_cylinder",
    ),
    "power of a torque": (("power_limit: 5*kW", "power_limit: 5*kN*m"), "power_limit: .*torque"),
    "negative flow": (("flow_limit: 80*l/min", "flow_limit: -80*l/min"), "flow_limit: .*above"),
    "rates that fall": ((ARM, ARM_LIMITED.replace("[0, 1]", "[1, 0]")), "rate: .*ascending"),
    "rows that lack": (
        (ARM, ARM_LIMITED.replace("[12, 9]", "[12]")),
        "effort: row 2 has 1 numbers; expected 2",
    ),
    "no positions": ((ARM, ARM_LIMITED.replace("position: [-1, 1], ", "")), "position"),
}


@pytest.mark.parametrize("name", BAD)
def test_what_is_wrong_is_named(name: str) -> None:
    change, message = BAD[name]
    with pytest.raises(DescriptionError, match=message):
        crane(change)


def test_a_relief_pressure_in_bar_is_warned_of() -> None:
    machine = crane(("relief_pressure: 210*bar", "relief_pressure: 210"))
    (warning,) = machine.description.warnings
    assert "relief_pressure" in warning
    assert "210*bar" in warning
    description = parse_description(CRANE.replace("flow_limit: 100*l/min", "flow_limit: 100"))
    assert "l/min" in description.warnings[0]


def test_margins_are_those_of_the_hydraulics(machine: Robot) -> None:
    rng = np.random.default_rng(3)
    state = machine.close(rng.uniform(0.05, 0.5, (50, 2)), rng.normal(0.0, 0.3, (50, 2)))
    ddu = rng.normal(size=(50, 2))
    margins = machine.limit_margins(state, ddu)
    columns = {(row.kind, row.name): k for k, row in enumerate(margins.rows)}
    cylinders = machine.hydraulics(state, machine.inverse_dynamics(state, ddu))
    flow, power = np.zeros(50), np.zeros(50)
    for name, one in cylinders.items():
        highest = np.maximum(one.cap_pressure, one.rod_pressure)
        assert margins.values[:, columns["pressure", name]] == pytest.approx(highest)
        filling = np.where(one.cap_flow > 0.0, one.cap_pressure, one.rod_pressure)
        power = np.maximum(power, filling)
        flow = flow + one.demand
    assert margins.values[:, columns["pump_flow", "main"]] == pytest.approx(flow)
    assert margins.values[:, columns["pump_power", "main"]] == pytest.approx(flow * power)
    place = machine.coordinates.index("arm_pitch")
    dds = machine.accelerations(state, ddu)[:, place]
    assert margins.values[:, columns["acceleration", "arm_pitch"]] == pytest.approx(dds)
    worst = {one.name: one for one in margins.beyond}["main"]
    assert worst.margin == pytest.approx(margins.margins[worst.index].min(), rel=1.0)
    assert "the pump 'main' gives" in worst.text


def test_a_table_counts_at_the_state_of_a_capability() -> None:
    lift = "lift_cylinder: {type: prismatic,"
    table = "effort_table: {rate: [0], position: [0.1, 0.5], effort: [[20000], [9000]]},"
    machine, plain = crane((lift, f"{lift} {table}")), crane()
    for stroke, largest in ((0.1, 20e3), (0.3, 14.5e3), (0.6, 9e3)):
        state = machine.close([stroke, 0.2])
        limited = machine.capability(state).lifted_mass()
        efforts = {"lift_cylinder": largest}
        assert limited.value == pytest.approx(
            plain.capability(state, efforts=efforts).lifted_mass().value, rel=1e-9
        )


def test_one_state_has_the_margins_of_its_row_in_a_batch(machine: Robot) -> None:
    batch = machine.close([[0.3, 0.2], [0.1, 0.5]], [[0.2, 0.1], [-0.3, 0.2]])
    together = machine.limit_margins(batch)
    for k in range(2):
        alone = machine.limit_margins(machine.close(batch.u[k], batch.du[k]))
        assert alone.margins == pytest.approx(together.margins[k], rel=1e-9)


def test_the_command_line_tells_what_is_beyond(tmp_path) -> None:
    file = tmp_path / "crane.yaml"
    file.write_text(CRANE)
    result = call("id", str(file), "--du", "0.6,0.3")
    assert "beyond: the pump 'main' gives a flow of" in result.stdout
    data = json.loads(call("fd", str(file), "--du", "0.6,0.3", "--json").stdout)["limits"]
    kinds = {(entry["kind"], entry["name"]) for entry in data["beyond"]}
    assert ("flow", "lift_cylinder") in kinds
    assert all(entry["margin"] < 0.0 for entry in data["beyond"])
    file.write_text(CRANE.replace("supply_pressure: 210*bar", "supply_pressure: 21*bar"))
    assert "held at rest at the reference, beyond: the cylinder" in call("check", str(file)).stdout


def test_a_saturated_simulation_keeps_pressures_flows_and_powers() -> None:
    machine = crane()
    settings = Settings(saturate=True, method="BDF", rtol=1e-5, atol=1e-7, rate=50.0)
    motion = simulate(machine, [0.1, 0.1], tau=[9e4, 9e4], t_span=(0.0, 0.1), settings=settings)
    margins = machine.limit_margins(motion.state, motion.ddu, motion.tau)
    assert motion.completed
    for row, share in zip(margins.rows, margins.shares.min(axis=0), strict=True):
        allowed = {"flow": 0.11, "pump_flow": 0.11, "pump_power": 0.11}.get(row.kind, 1e-9)
        assert share > -allowed, row
    assert motion.tau[0, 0] < 66e3  # 210 bar on the bore


def test_shares_of_margins_do_not_depend_on_the_zero_of_a_joint(machine: Robot) -> None:
    state = machine.close(machine.reference)
    margins = machine.limit_margins(state)
    row = next(row for row in margins.rows if row.kind == "position")
    for lower, upper in ((0.0, 0.6), (-0.6, 0.0), (1.0, 1.6)):
        for value, share in ((lower + 3e-3, 0.01), (upper + 3e-3, -0.01)):
            ends = np.array([lower]), np.array([upper])
            one = LimitMargins((row,), np.array([value]), *ends)
            assert one.shares == pytest.approx([share])
    near = LimitMargins((row, row), np.array([1e-3, 0.3]), np.zeros(2), np.array([0.6, 0.31]))
    assert near.nearest is not None
    assert near.nearest.value == 1e-3
