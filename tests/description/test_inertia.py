"""Inertia as components, principal moments and shapes, in any axes; and what cannot be."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import DescriptionError
from hybrid_dynamics_core.description import RobotDescription
from hybrid_dynamics_core.description.geometry import rotation_from_rpy
from tests.description.robots import HEAD, parse


def body(link: str) -> RobotDescription:
    text = HEAD + f"parameters: {{r: 0.2}}\nlinks:\n  l1: {link}\n"
    text += "joints: {q1: {type: revolute, parent: base, child: l1, axis: z}}\n"
    return parse(text + "active: [q1]\nend_effector: {link: l1}\n")


def inertia(entry: str, mass: float = 6.0) -> np.ndarray:
    return body(f"{{mass: {mass}, inertia: {entry}}}").links["l1"].inertia


SHAPES = {
    "{rod: {axis: y, length: 2}}": [2.0, 0.0, 2.0],
    "{box: {size: [1, 2, 3]}}": [6.5, 5.0, 2.5],
    "{cylinder: {axis: z, radius: 1, length: 3}}": [6.0, 6.0, 3.0],
    "{cylinder: {axis: x, radius: 1, inner: 0.5, length: 3}}": [3.75, 6.375, 6.375],
    "{sphere: {radius: 5*r}}": [2.4, 2.4, 2.4],
    "{principal: [1, 2, 3]}": [1.0, 2.0, 3.0],
    "{xx: 1, yy: 2, zz: 3}": [1.0, 2.0, 3.0],
    "[[1, 0, 0], [0, 2, 0], [0, 0, 3]]": [1.0, 2.0, 3.0],
}


@pytest.mark.parametrize(("entry", "moments"), SHAPES.items())
def test_moments_about_the_centre(entry: str, moments: list[float]) -> None:
    """Textbook moments of uniform bodies of 6 kg."""
    assert inertia(entry) == pytest.approx(np.diag(moments), abs=1e-15)


def test_a_shape_is_the_integral_of_the_body() -> None:
    """The tube, summed over a fine grid."""
    grid = (np.arange(400) + 0.5) / 200 - 1.0
    y, z = np.meshgrid(grid, grid)
    inside = (y**2 + z**2 < 1.0) & (y**2 + z**2 > 0.25)
    about_axis = 6.0 * (y**2 + z**2)[inside].mean()
    assert inertia("{cylinder: {axis: x, radius: 1, inner: 0.5, length: 3}}")[
        0, 0
    ] == pytest.approx(about_axis, rel=1e-3)


def test_products_are_entries_of_the_matrix() -> None:
    assert inertia("{xx: 1, yy: 1, zz: 1, xy: 0.1, xz: -0.2, yz: 0.3}")[0] == pytest.approx(
        [1, 0.1, -0.2]
    )
    assert inertia("{xx: 1, yy: 1, zz: 1, xy: 0.1, xz: -0.2, yz: 0.3}")[2] == pytest.approx(
        [-0.2, 0.3, 1]
    )


@given(st.tuples(*[st.floats(-3, 3)] * 3))
def test_any_axes(rpy: tuple[float, float, float]) -> None:
    turned = inertia(f"{{principal: [1, 2, 2.5], frame: {{rpy: {list(rpy)}}}}}")
    rotation = rotation_from_rpy(*rpy)
    assert turned == pytest.approx(rotation @ np.diag([1, 2, 2.5]) @ rotation.T, abs=1e-14)
    assert np.array_equal(turned, turned.T)


def test_a_rod_along_any_direction() -> None:
    across = inertia("{rod: {axis: x, length: 1}, frame: {rpy: [0, 0, pi/2]}}")
    assert across == pytest.approx(inertia("{rod: {axis: y, length: 1}}"), abs=1e-15)


def test_mass_without_inertia_is_reported() -> None:
    robot = body("{mass: 2}")
    assert not robot.links["l1"].inertia.any()
    assert robot.notes == ("l1: no inertia given; its 2 kg are taken as a point at its com",)
    assert body("{mass: 2, inertia: {sphere: {radius: 0.1}}}").notes == ()


WRONG = {
    "two shapes": (
        "{rod: {axis: x, length: 1}, sphere: {radius: 1}}",
        "inertia",
        "gives rod and sphere; give one of",
    ),
    "shape and components": (
        "{xx: 1, box: {size: [1, 1, 1]}}",
        "inertia",
        "gives box and components",
    ),
    "axes alone": (
        "{frame: {rpy: [0, 0, 1]}}",
        "inertia",
        "gives nothing; give one of: components",
    ),
    "axes without angles": ("{xx: 1, frame: {}}", "inertia.frame", "expected 1"),
    "not symmetric": ("[[1, 0, 0.1], [0, 1, 0], [0, 0, 1]]", "inertia", "not symmetric"),
    "negative radius": (
        "{sphere: {radius: -1}}",
        "inertia.sphere.radius",
        "is -1 m; a dimension is positive",
    ),
    "no length": (
        "{rod: {axis: x, length: 0}}",
        "inertia.rod.length",
        "is 0 m; a dimension is positive",
    ),
    "thick tube": (
        "{cylinder: {axis: x, radius: 0.1, inner: 0.1, length: 1}}",
        "inertia.cylinder.inner",
        "expected 0 up to the radius, 0.1 m",
    ),
    "flat box": ("{box: {size: [1, 0, 1]}}", "inertia.box.size[1]", "a dimension is positive"),
    "box of two": ("{box: {size: [1, 1]}}", "inertia.box.size", "2 entries; expected 3"),
    "unknown shape": ("{cone: {radius: 1}}", "inertia.cone", "unknown key; known keys: frame, xx"),
    "no radius": ("{cylinder: {axis: x, length: 1}}", "inertia.cylinder", "missing 'radius'"),
    "a number": ("3", "inertia", "expected a mapping or a list (about the centre of mass"),
    "axis in space": (
        "{rod: {axis: w, length: 1}}",
        "inertia.rod.axis",
        "is 'w'; expected one of x, y, z",
    ),
}


@pytest.mark.parametrize(("entry", "key", "words"), WRONG.values(), ids=WRONG.keys())
def test_impossible_inertia(entry: str, key: str, words: str) -> None:
    with pytest.raises(DescriptionError) as caught:
        inertia(entry)
    assert caught.value.key == f"links.l1.{key}"
    assert words in str(caught.value)
    assert caught.value.line == 6


def test_inertia_without_mass() -> None:
    with pytest.raises(DescriptionError, match=r"links\.l1: inertia needs 'mass' beside it"):
        body("{inertia: {sphere: {radius: 1}}}")
    with pytest.raises(
        DescriptionError, match=r"links\.l1: com and inertia need 'mass' beside them"
    ):
        body("{com: [0, 0, 0], inertia: {sphere: {radius: 1}}}")
    (note,) = body("{mass: 0, inertia: {xx: 1, yy: 1, zz: 1}}").notes
    assert note.startswith("small.yaml:6: links.l1.inertia: it belongs to a link without a mass")


def test_links_fixed_to_others_are_one_body() -> None:
    """Two half rods fixed end to end are one rod; the fixed link stays as a frame."""
    text = (
        HEAD
        + "links:\n  whole: {mass: 2, com: [0, 0.5, 0], inertia: {rod: {axis: y, length: 1}}}\n"
    )
    text += "  a: {mass: 1, com: [0.25, 0, 0], inertia: {rod: {axis: x, length: 0.5}}}\n"
    text += "  b: {mass: 1, com: [0, 0, 0.25], inertia: {rod: {axis: z, length: 0.5}}}\n"
    text += "joints:\n  q1: {type: revolute, parent: base, child: whole, axis: z}\n"
    text += "  q2: {type: revolute, parent: base, child: a, origin: {rpy: [0, 0, pi/2]}, axis: z}\n"
    text += (
        "  f: {type: fixed, parent: a, child: b, origin: {xyz: [0.5, 0, 0], rpy: [0, pi/2, 0]}}\n"
    )
    robot = parse(text + "active: [q1, q2]\nend_effector: {link: b}\n")
    single, joined = robot.links["whole"], robot.links["a"]
    assert "b" not in robot.links
    assert "f" not in robot.joints
    assert joined.mass == single.mass
    assert joined.com == pytest.approx([0.5, 0, 0], abs=1e-15)
    assert np.linalg.eigvalsh(joined.inertia) == pytest.approx(
        np.linalg.eigvalsh(single.inertia), abs=1e-15
    )
    assert robot.frames["b"].translation == pytest.approx([0.5, 0, 0])
    assert robot.frames["end_effector"].link == "a"


def test_fixed_joints_in_a_circle() -> None:
    text = HEAD + "links: {a: {}, b: {}}\njoints:\n  f: {type: fixed, parent: b, child: a}\n"
    text += "  g: {type: fixed, parent: a, child: b}\nactive: [f]\nend_effector: {link: a}\n"
    with pytest.raises(DescriptionError, match="cycle"):
        parse(text)
    frames = (
        HEAD + "links: {a: {}}\njoints: {q: {type: revolute, parent: base, child: a, axis: z}}\n"
    )
    frames += "frames: {f: {link: g}, g: {link: f}}\nactive: [q]\nend_effector: {link: a}\n"
    with pytest.raises(DescriptionError, match=r"frames\.f: stands on itself: f on g on f"):
        parse(frames)
