"""Messages for people: examples of entries, and several lines told in one."""

from __future__ import annotations

import pytest

from hybrid_dynamics_core.description.checks.examples import example
from hybrid_dynamics_core.ground.suggestions import MAX_NAMES, no_such_name, with_warnings
from hybrid_dynamics_core.ground.wording import one_line

JOINT = ("joints", "a")


@pytest.mark.parametrize(
    ("path", "value", "shown"),
    [
        (("gravity",), 9.81, "; as in gravity: [0, 0, -9.81]"),
        (("gravity",), "down", "; as in gravity: [0, 0, -9.81]"),
        ((*JOINT, "origin"), 0.6, "; as in origin: {xyz: [0.6, 0, 0], rpy: [0, 0, pi/2]}"),
        ((*JOINT, "origin", 0), 0.6, "; as in origin: {xyz: [0.6, 0, 0], rpy: [0, 0, pi/2]}"),
        ((*JOINT, "origin", "rpy"), "pi/2", "; as in rpy: [0, 0, pi/2]"),
        ((*JOINT, "origin", "rpy"), "90*deg", "; as in rpy: [0, 0, 90*deg]"),
        ((*JOINT, "limits"), 0.15, "; as in limits: [-0.15, 0.15]"),
        (("loops", "l", "pin"), "rod", "; as in pin: {rod: [0, 0, 0], OTHER_LINK: [0.1, 0, 0]}"),
        (("links", "l", "com", 1), True, ""),
        (("links", "l", "com"), {}, ""),
        (("name",), 3, ""),
        ((), 3, ""),
    ],
)
def test_an_entry_is_shown_as_it_may_stand(
    path: tuple[str | int, ...], value: object, shown: str
) -> None:
    assert example(path, value) == shown


def test_lines_joined_in_one_are_parted() -> None:
    message = with_warnings("give a reference that closes", ["robot.yaml:3: 90 rad is 14.3 turns"])
    assert (
        one_line(message)
        == "give a reference that closes; perhaps for this reason: robot.yaml:3: 90 rad is 14.3"
        " turns"
    )
    assert one_line("is wrong:\n   line 3,\n\n  line 4\n") == "is wrong: line 3, line 4"
    assert not one_line("")


def test_a_name_that_there_is_not_is_reported_with_those_that_there_are() -> None:
    assert (
        no_such_name("frame", "carier", ["base", "carrier"])
        == "there is no frame 'carier' (did you mean 'carrier'?); known: base, carrier"
    )
    assert no_such_name("loop", "x", []) == "there is no loop 'x'; known: none"
    listed = no_such_name("link", "x", (f"l{k}" for k in range(MAX_NAMES + 1)))
    assert listed.endswith(f"l{MAX_NAMES - 1}, ...")
