"""Idle joints as the command shows them."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.calling import call, data_of
from tests.export.test_round_trip import CART
from tests.laws.test_idle import ROD


@pytest.fixture(name="cart")
def _cart(tmp_path: Path) -> str:
    place = tmp_path / "cart.yaml"
    place.write_text(CART, encoding="utf-8")
    return str(place)


@pytest.mark.parametrize("verb", ["info", "check"])
def test_idle_joints_are_not_active(verb: str, cart: str) -> None:
    answer = data_of(verb, cart)
    assert (answer["active"], answer["idle"]) == (["x"], ["th"])
    kinds = {entry["name"]: (entry["active"], entry["idle"]) for entry in answer["coordinates"]}
    assert kinds == {"x": (True, False), "th": (False, True)}
    text = call(verb, cart).output
    assert "1 active and 1 idle of 2 coordinates" in text
    row = next(line for line in text.splitlines() if line.startswith("th "))
    assert "idle" in row
    assert "active" not in row


def test_forward_and_inverse_dynamics_say_so(cart: str) -> None:
    row = next(line for line in call("fd", cart).output.splitlines() if line.startswith("th "))
    assert "idle" in row
    assert "th is idle: nobody gives the effort along it" in call("id", cart).output


def test_a_spin_without_mass_is_told(tmp_path: Path) -> None:
    place = tmp_path / "rod.yaml"
    place.write_text(ROD.replace("SPIN", "0"), encoding="utf-8")
    notes = data_of("check", str(place))["notes"]
    assert "w is idle and moves no mass: forward dynamics leaves it out" in notes
    assert not any("condition" in note or "no forward dynamics" in note for note in notes)


def test_weight_is_held_by_drives_only(cart: str) -> None:
    """The pole falls: nobody holds it."""
    answer = data_of("simulate", cart, "-u", "th=0.3", "--tau", "weight", "--seconds", "0.1")
    assert answer["u"]["th"] > 0.31
