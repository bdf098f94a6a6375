"""Forward dynamics where it has no answer, and loads that make no sense."""

from __future__ import annotations

from dataclasses import replace
from importlib import resources

import numpy as np
import pytest

from hybrid_dynamics_core import InputError, MassSingularityError, Payload, Robot
from hybrid_dynamics_core.control import (
    ComputedTorque,
    FeedForward,
    GravityCompensation,
    JointTrajectory,
)
from hybrid_dynamics_core.dynamics.mass import mass_singularity
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.simulation import Settings, simulate
from tests.mechanisms import mechanism

FILE = (
    resources.files("hybrid_dynamics_core")
    .joinpath("robots/forging_chu2020.yaml")
    .read_text(encoding="utf-8")
)
U = [0.3, 0.15, 0.175, 0.4]


@pytest.fixture(scope="module")
def slender() -> Robot:
    """The forging robot of slender rods only: nothing resists the roll of the gripper."""
    text = FILE.replace("inertia: {xx: m4*r4*r4/2, yy:", "inertia: {xx: 0, yy:")
    assert text != FILE
    return Robot(parse_description(text))


def test_gripper_without_axial_inertia_is_refused_with_evidence(slender: Robot) -> None:
    state = slender.close(U)
    with pytest.raises(
        MassSingularityError, match=r"accelerating q4 \(\+1\) takes no force"
    ) as caught:
        slender.forward_dynamics(state, np.ones(4))
    error = caught.value
    assert error.joint == "q4"
    assert np.abs(error.direction) == pytest.approx([0, 0, 0, 1])
    assert error.eigenvalues[0] == pytest.approx(0.0, abs=1e-9)
    assert error.index is None


def test_so_is_every_other_call_that_needs_the_inverse(slender: Robot) -> None:
    state, still = slender.close(U), np.zeros(4)
    path = JointTrajectory.between(U, np.add(U, [0.1, 0.01, 0.01, 0.1]), 1.0)
    calls = [
        lambda: slender.forward_dynamics_derivatives(state, still),
        lambda: slender.forward_dynamics(
            state, slender.generalised_forces(state, {"q12": 1e3, "q22": -2e3})
        ),
        lambda: slender.motion_near(state)(state.u, state.du, still),
        *(
            lambda m=m: simulate(slender, U, settings=Settings(method=m))
            for m in ("DOP853", "RK45", "Radau", "LSODA")
        ),
        lambda: simulate(slender, U, settings=Settings(hold=0.01)),
        lambda: simulate(slender, U, None, ComputedTorque(slender, path, 10.0, 5.0)),
        lambda: simulate(slender, U, None, GravityCompensation(slender)),
        lambda: simulate(slender, U, None, FeedForward(slender, path)),
    ]
    for call in calls:
        with pytest.raises(MassSingularityError, match=r"accelerating q4 \(\+1\) takes no force"):
            call()


@pytest.mark.parametrize(
    ("inertias", "is_definite"), [((-1.0, 0.0, 2.0), False), ((1e-8, 2.0, 3.0), True)]
)
def test_the_motion_at_fault_is_the_one_of_least_inertia(
    inertias: tuple[float, ...], is_definite: bool
) -> None:
    """Also before one that moves no mass, and where none is without mass."""
    error = mass_singularity(np.diag(inertias), np.array(True), ("a", "b", "c"))
    assert np.abs(error.direction) == pytest.approx([1.0, 0.0, 0.0])
    assert error.joint == "a"
    assert ("not positive definite" in str(error)) != is_definite


def test_of_motions_without_mass_the_driven_one_is_at_fault() -> None:
    inertias = np.diag([-1e-13, 0.0, 2.0])  # the first is rounding
    error = mass_singularity(inertias, np.array(True), ("a", "b", "c"), {"a"})
    assert np.abs(error.direction) == pytest.approx([0.0, 1.0, 0.0])
    assert error.joint == "b"


def test_row_of_a_batch_is_named(slender: Robot) -> None:
    with pytest.raises(MassSingularityError, match="row 0:"):
        slender.forward_dynamics(slender.close([U, U]), np.ones((2, 4)))


def test_row_that_does_not_close_is_not_taken_for_it(slender: Robot) -> None:
    state = slender.close([[0, 0.9, 0.1, 0], U], check=False)
    with pytest.raises(MassSingularityError, match=r"row 1: .*accelerating q4") as caught:
        slender.forward_dynamics(state, np.ones((2, 4)))
    assert caught.value.index == 1


def test_rotor_mends_it(slender: Robot) -> None:
    state = slender.close(U)
    loads = slender.loads.with_effects(
        armature=[0.01 if name == "q4" else 0.0 for name in slender.coordinates]
    )
    assert slender.forward_dynamics(state, [0, 0, 0, 1.0], loads)[3] == pytest.approx(
        100.0, rel=1e-9
    )


def test_tilted_axes_hide_no_singularity() -> None:
    """Where M-bar[q4, q4] is rounding, not an exact zero."""
    machine = mechanism("serial")
    rod = machine.description.links["l4"]
    axis = np.array([1.0, 0.0, 0.0])
    line = replace(rod, com=0.1 * axis, inertia=np.diag([0.0, 0.2, 0.2]))
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    turned = replace(line, com=turn @ line.com, inertia=turn @ line.inertia @ turn.T)
    joint = machine.description.joints["d"]
    joints = {**machine.description.joints, "d": replace(joint, axis=turn @ axis)}
    links = {**machine.description.links, "l4": turned}
    other = Robot(replace(machine.description, links=links, joints=joints))
    state = other.close(other.reference)
    assert abs(other.minimal_form(state)[0][3, 3]) < 1e-12
    with pytest.raises(MassSingularityError):
        other.forward_dynamics(state, np.zeros(4))


def test_unchecked_rows_stay_nan(forging: Robot) -> None:
    state = forging.close([U, [0, 0.9, 0.1, 0]], check=False)
    ddu = forging.forward_dynamics(state, np.ones((2, 4)))
    assert np.isfinite(ddu[0]).all()
    assert np.isnan(ddu[1]).all()


class TestBadLoads:
    def test_shapes_and_numbers(self, forging: Robot) -> None:
        with pytest.raises(InputError, match=r"wrench on 'l4' has shape \(5,\)"):
            forging.loads.with_wrench(np.ones(5), "l4")
        with pytest.raises(InputError, match="6 finite numbers"):
            forging.loads.with_wrench([np.nan] * 6)
        with pytest.raises(InputError, match="axes is 'world'"):
            forging.loads.with_wrench(np.ones(6), axes="world")  # type: ignore[arg-type]
        with pytest.raises(InputError, match="gravity"):
            forging.loads.with_gravity([0, 0])
        with pytest.raises(InputError, match="viscous has a negative"):
            forging.loads.with_effects(viscous=-np.ones(12))
        with pytest.raises(InputError, match="smoothing has to be above zero"):
            forging.loads.with_effects(smoothing=np.zeros(12))
        with pytest.raises(InputError, match=r"coulomb has shape \(4,\); expected \(12,\)"):
            forging.loads.with_effects(coulomb=np.zeros(4))

    def test_bodies_that_cannot_be(self) -> None:
        with pytest.raises(InputError, match="not -1 kg"):
            Payload(-1)
        with pytest.raises(InputError, match="at least the third"):
            Payload(1, inertia=np.diag([1, 1, 3]))
        with pytest.raises(InputError, match=r"not \(2,\)"):
            Payload(1, [0, 0])

    def test_names_and_rows(self, forging: Robot) -> None:
        state = forging.close(U)
        with pytest.raises(InputError, match="no frame 'l99'"):
            forging.inverse_dynamics(
                state, np.zeros(4), forging.loads.with_wrench(np.ones(6), "l99")
            )
        with pytest.raises(InputError, match="3 rows; it acts on 1 state"):
            forging.inverse_dynamics(state, np.zeros(4), forging.loads.with_wrench(np.ones((3, 6))))
        many = forging.close([U] * 3)
        with pytest.raises(InputError, match="2 rows; it acts on 3 states"):
            forging.inverse_dynamics(
                many, np.zeros((3, 4)), forging.loads.with_wrench(np.ones((2, 6)))
            )
        with pytest.raises(InputError, match=r"tau has shape \(3,\)"):
            forging.forward_dynamics(state, np.zeros(3))

    def test_what_acts_on_the_base_has_no_effect(self, forging: Robot) -> None:
        state = forging.close(U)
        loads = forging.loads.with_wrench(np.ones(6), "base").with_payload(Payload(5.0), "base")
        assert np.array_equal(
            forging.inverse_dynamics(state, np.ones(4), loads),
            forging.inverse_dynamics(state, np.ones(4)),
        )


@pytest.mark.parametrize("rows", [1, 3])
def test_a_point_on_its_own_axis_takes_no_force(rows: int) -> None:
    """Nothing in that robot has a length or an inertia.

    There is no size to hold a pivot against.
    """
    text = (
        "format: 1\nname: point\nlinks: {base: {}, a: {mass: 1}}\nend_effector: {link: a}\n"
        "joints: {q: {type: revolute, parent: base, child: a, axis: z}}\nactive: [q]\n"
    )
    point = Robot(parse_description(text))
    with pytest.raises(MassSingularityError, match=r"accelerating q \(\+1\) takes no force"):
        point.forward_dynamics(point.close(np.zeros((rows, 1))), np.ones((rows, 1)))
