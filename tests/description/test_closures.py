"""Loops of Type A to D and closures of every kind: what they become, and errors in them."""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core import DescriptionError
from tests.description.oracle import close, freedom, gaps, link_pose
from tests.description.robots import FOUR_BAR_LINKS, HEAD, four_bar, parse

NEAR = {"q1": 1.0, "q2": -0.5, "q3": 1.6}


@pytest.mark.parametrize("letter", "ABCD")
def test_four_bar_of_every_type_is_one_planar_pin(letter: str) -> None:
    robot = parse(four_bar(letter))
    (pin,) = robot.closures
    assert (pin.name, pin.kind, pin.assembly) == ("bar", "planar", "counterclockwise")
    assert robot.loops["bar"].type == letter
    near = NEAR if letter in "AD" else {"q1": 1.0, "q2": 1.8, "q3": 1.6}
    s = close(robot, {"q1": 1.0, "q4": 0.0}, near)
    assert np.abs(gaps(robot, s)).max() < 1e-13
    assert freedom(robot, s) == 2


def test_the_four_types_are_the_same_linkage() -> None:
    """The rocker's pin stands at the same place wherever the loop is cut."""
    places = []
    for letter in "ABCD":
        robot = parse(four_bar(letter))
        near = NEAR if letter in "AD" else {"q1": 1.0, "q2": 1.8, "q3": 1.6}
        s = close(robot, {"q1": 1.0, "q4": 0.0}, near)
        places.append(link_pose(robot, "rocker", s) @ [0.2, 0, 0, 1])
    assert np.ptp(places, axis=0).max() < 1e-12


@pytest.mark.parametrize("letter", "ABCD")
@pytest.mark.parametrize("claimed", "ABCD")
def test_wrong_letter_is_refused_and_the_right_one_named(letter: str, claimed: str) -> None:
    text = four_bar(letter).replace(f"type: {letter}, base", f"type: {claimed}, base")
    if letter == claimed:
        parse(text)
        return
    with pytest.raises(DescriptionError, match=r"loops\.bar") as caught:
        parse(text)
    assert f"in a loop of Type {claimed}" in str(caught.value)
    assert f"as given form Type {letter}" in str(caught.value)


def test_arm_that_goes_on_from_another_link_is_refused() -> None:
    text = four_bar("A").replace("parent: rocker, child: tool", "parent: coupler, child: tool")
    with pytest.raises(
        DescriptionError, match=r"loops\.bar\.type: .* goes on from 'rocker', but .* on 'coupler'"
    ):
        parse(text)


SHARED = (([0, 0, 0], "z"), ([0, 0, 0.2], "z"), ([0, 0, 0], "-z"), ([2e-6, 0, 0], "z"))
SEPARATE = (([1e-4, 0, 0], "z"), ([0, 0.02, 0], "z"), ([0, 0, 0], "[0, 0.001, 1]"))


@pytest.mark.parametrize(("place", "axis"), [*SHARED, *SEPARATE])
def test_a_crank_beside_the_base_of_its_loop_turns_about_the_same_line(
    place: list[float], axis: str
) -> None:
    """Both hang on one link, by two pivots that are one, wherever along it they stand."""
    text = (
        four_bar("A")
        .replace("links:\n", "links:\n  plate: {mass: 1}\n")
        .replace("q3: {type: revolute, parent: base", "q3: {type: revolute, parent: plate")
        .replace("base: base", "base: plate")
        .replace("active: [", "active: [q0, ")
    )
    crank = "q1: {type: revolute, parent: base, child: crank, axis: "
    plate = "q0: {type: revolute, parent: base, child: plate, axis: z}\n  "
    turned = crank.replace("axis", f"origin: {{xyz: {place}}}, axis") + f"{axis}}}"
    text = text.replace(f"{crank}z}}", plate + turned)
    if (place, axis) in SHARED:
        assert parse(text).loops["bar"].base == "plate"
    else:
        with pytest.raises(DescriptionError, match=r"loops\.bar\.k1: .* that of `base`, but"):
            parse(text)


def test_one_link_in_two_roles_is_refused() -> None:
    with pytest.raises(DescriptionError, match=r"loops\.bar\.k2: 'crank' is also k1"):
        parse(four_bar("A").replace("k2: coupler", "k2: crank"))


JOINTS = """\
joints:
  q1: {type: revolute, parent: base, child: crank, axis: z}
  q2: {type: revolute, parent: crank, child: coupler, origin: {xyz: [0.1, 0, 0]}, axis: z}
  q3: {type: revolute, parent: base, child: rocker, origin: {xyz: [0.3, 0, 0]}, axis: z}
  q4: {type: revolute, parent: rocker, child: tool, origin: {xyz: [0.25, 0, 0]}, axis: x}
"""
TAIL = "active: [q1, q4]\nend_effector: {link: tool}\n"


def with_closure(closure: str) -> str:
    return HEAD + FOUR_BAR_LINKS + JOINTS + f"closures:\n  bar: {closure}\n" + TAIL


PLANAR = (
    "{kind: planar, between: {coupler: [0.3, 0, 0], rocker: [0.2, 0, 0]}, assembly:"
    " counterclockwise}"
)


@pytest.mark.parametrize("kind", ["planar", "point", "axis"])
def test_every_kind_that_fits_a_pin_closes_it_alike(kind: str) -> None:
    """A point and an axis have more equations than a planar loop needs; they agree."""
    robot = parse(with_closure(PLANAR.replace("planar", kind)))
    s = close(robot, {"q1": 1.0, "q4": 0.0}, NEAR)
    assert robot.closures[0].kind == kind
    assert np.abs(gaps(robot, s)).max() < 1e-13
    assert freedom(robot, s) == 2


def test_a_weld_takes_the_freedom_away() -> None:
    text = with_closure(
        "{kind: frame, between: {coupler: {xyz: [0.3, 0, 0]}, rocker: {xyz: [0.2, 0, 0], rpy: [0,"
        " 0, a]}}}"
    )
    shut = close(parse(with_closure(PLANAR)), {"q1": 1.0, "q4": 0.0}, NEAR)
    angle = shut["q1"] + shut["q2"] - shut["q3"]
    robot = parse(
        text.replace("source: invented\n", f"source: invented\nparameters: {{a: {angle!r}}}\n")
    )
    assert np.abs(gaps(robot, shut)).max() < 1e-12
    assert freedom(robot, shut) == 1


def test_loop_and_planar_closure_expand_to_the_same() -> None:
    loop, closure = parse(four_bar("A")).closures[0], parse(with_closure(PLANAR)).closures[0]
    for field in ("name", "kind", "link_a", "link_b", "assembly"):
        assert getattr(loop, field) == getattr(closure, field)
    assert np.array_equal(loop.point_a, closure.point_a)
    assert np.array_equal(loop.point_b, closure.point_b)


def test_axis_gives_the_z_axis_of_the_tied_frame() -> None:
    robot = parse(
        with_closure(
            "{kind: axis, between: {coupler: {xyz: [0.3, 0, 0], axis: -y}, rocker: {axis: [3, 0,"
            " 4]}}}"
        )
    )
    closure = robot.closures[0]
    assert closure.rotation_a[:, 2] == pytest.approx([0, -1, 0])
    assert closure.rotation_b[:, 2] == pytest.approx([0.6, 0, 0.8])
    for rotation in (closure.rotation_a, closure.rotation_b):
        assert rotation.T @ rotation == pytest.approx(np.eye(3), abs=1e-15)
        assert np.linalg.det(rotation) == pytest.approx(1.0)


def test_a_place_may_be_a_list_of_poses() -> None:
    robot = parse(
        with_closure(
            "{kind: point, between: {coupler: [{rpy: [0, 0, pi/2]}, {xyz: [0.3, 0, 0]}], rocker:"
            " {}}}"
        )
    )
    assert robot.closures[0].point_a == pytest.approx([0, 0.3, 0])


WRONG = {
    "unknown kind": (
        "kind: planar",
        "kind: ball",
        "closures.bar.kind",
        "is 'ball'; expected one of planar",
    ),
    "missing link": (
        "rocker: [0.2",
        "rockr: [0.2",
        "closures.bar.between.rockr",
        "did you mean 'rocker'",
    ),
    "three links": (
        "{coupler:",
        "{crank: [0, 0, 0], coupler:",
        "closures.bar.between",
        "3 entries; expected 2",
    ),
    "one link": ("coupler: [0.3, 0, 0], ", "", "closures.bar.between", "1 entry; expected 2"),
    "two numbers": (
        "rocker: [0.2, 0, 0]",
        "rocker: [0.2, 0]",
        "closures.bar.between.rocker",
        "2 entries; expected 3",
    ),
    "rpy and axis": (
        "rocker: [0.2, 0, 0]",
        "rocker: {rpy: [0, 0, 1], axis: z}",
        "closures.bar.between.rocker",
        "exclude each other",
    ),
    "unknown key": (
        "rocker: [0.2, 0, 0]",
        "rocker: {xzy: [0, 0, 1]}",
        "rocker.xzy",
        "did you mean 'xyz'",
    ),
    "no axis": ("rocker: [0.2, 0, 0]", "rocker: {axis: [0, 0, 0]}", "rocker.axis", "no length"),
    "no kind": ("kind: planar, ", "", "closures.bar", "missing 'kind'"),
    "slip in an expression": (
        "rocker: [0.2, 0, 0]",
        "rocker: [b3, 0, 0]",
        "rocker[0]",
        "'b3' is not one of the",
    ),
    "a joint that ties a link again": (
        "closures:",
        "  q5: {type: fixed, parent: base, child: tool}\nclosures:",
        "joints.q5.child",
        "already hangs on joint 'q4'",
    ),
}


@pytest.mark.parametrize(("old", "new", "key", "words"), WRONG.values(), ids=WRONG.keys())
def test_wrong_closures(old: str, new: str, key: str, words: str) -> None:
    text = with_closure(PLANAR)
    assert old in text
    changed = text.replace(old, new, 1)
    with pytest.raises(DescriptionError) as caught:
        parse(changed)
    assert words in str(caught.value)
    assert key in caught.value.key
    assert caught.value.line == changed[: text.index(old)].count("\n") + 1


def test_name_of_loop_and_closure() -> None:
    text = four_bar("A").replace("active:", f"closures:\n  bar: {PLANAR}\nactive:")
    with pytest.raises(
        DescriptionError,
        match=r"loops\.bar: the name 'bar' is given twice in closures \(first in line 18",
    ):
        parse(text)


def test_both_ends_on_one_body() -> None:
    text = with_closure("{kind: point, between: {tip: [0, 0, 0], rocker: [0.2, 0, 0]}}")
    text = text.replace("active:", "frames: {tip: {link: rocker}}\nactive:")
    with pytest.raises(
        DescriptionError, match=r"closures\.bar: both ends are on the link 'rocker'"
    ):
        parse(text)


def test_key_of_a_closure() -> None:
    assert parse(four_bar("A")).closure_key("bar") == "loops.bar"
    assert parse(with_closure(PLANAR)).closure_key("bar") == "closures.bar"
    error = parse(with_closure(PLANAR)).error("closures.bar", "does not close")
    assert error.line == 16
