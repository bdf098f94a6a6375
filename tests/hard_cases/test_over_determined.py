"""Loops with more equations than they need.

Planar ones closed by whole frames, and linkages that only just move.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from hybrid_dynamics_core import ClosureError, DescriptionError, Robot
from hybrid_dynamics_core.closure import mobility
from hybrid_dynamics_core.closure.constraints.from_description import loop_equations
from hybrid_dynamics_core.closure.loop_gap import describe_gap
from hybrid_dynamics_core.description import RobotDescription
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.mechanism.configuration import given_configuration
from hybrid_dynamics_core.mechanism.tree import build_tree
from tests.generated.assembly import BASE, Assembly, turn, unit
from tests.generated.space import Space
from tests.hard_cases.linkages import four_bar, robot

TWISTS = 0.6, 1.3  # [rad] of the two kinds of links of Bennett's linkage
LENGTH = 0.4  # [m] of the first kind; the second follows
START = 0.9  # [rad] the first angle at the reference
X, Z = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])


def bennett(kind: str, seed: int, spoilt: float = 0.0) -> RobotDescription:
    """Bennett's linkage: four skew revolute axes, which move only because length / sin(twist) is
    one for all links.

    kind 'axis': cut at the third joint; 'frame': cut through the link behind it. spoilt: [m] one
    pivot is off.
    """
    first, second = TWISTS
    links = ((LENGTH, first), (LENGTH * np.sin(second) / np.sin(first), second)) * 2
    rotation, point = np.eye(3), np.zeros(3)
    axes, points = [], []
    for angle, (length, twist) in zip(bennett_angles(START), links, strict=True):
        axes.append(rotation[:, 2])
        points.append(point)
        rotation = rotation @ turn(Z, angle)
        point = point + rotation @ (length * X)
        rotation = rotation @ turn(X, twist)
    assert np.abs(rotation - np.eye(3)).max() < 1e-14
    assert np.abs(point).max() < 1e-14
    a = Assembly(np.random.default_rng(seed))
    mount = turn(unit(a.rng.normal(size=3)), 1.1)
    axes, points = [mount @ v for v in axes], [mount @ v for v in points]
    points[2] = points[2] + spoilt * np.array([0.6, 0.0, 0.8])
    one = a.hang(BASE, "revolute", axes[0], points[0], name="l1")
    two = a.hang(one, "revolute", axes[1], points[1], name="l2")
    four = a.hang(BASE, "revolute", axes[3], points[3], name="l4")
    if kind == "axis":
        a.tie(two, four, points[2], "axis", axes[2], name="cut")
    else:
        three = a.hang(four, "revolute", axes[2], points[2], name="l3")
        a.tie(two, three, points[2] + 0.1, "frame", name="cut")
    return a.description(("q_l1",), two)


def bennett_angles(first: float) -> list[float]:
    """tan(first / 2) tan(second / 2) = sin((b + a) / 2) / sin((b - a) / 2).

    Opposite angles are opposite.
    """
    a, b = TWISTS
    second = 2.0 * np.arctan(np.sin((b + a) / 2.0) / np.sin((b - a) / 2.0) / np.tan(first / 2.0))
    return [first, second, -first, -second]


@pytest.mark.parametrize("kind", ["axis", "frame"])
class TestBennettLinkage:
    def test_it_moves_and_every_equation_holds(self, kind: str) -> None:
        """Three equations of five or six are solved.

        The others follow, and so does the relation of the angles.
        """
        description = bennett(kind, seed=1)
        linkage = Robot(description)
        space = Space(description, linkage.coordinates)
        start = linkage.close(linkage.reference)
        near, index = start, linkage.coordinates.index("q_l2")
        for u in np.linspace(0.0, 0.6, 13):
            near = linkage.close(linkage.reference + u, near=near)
            assert space.gap(near.s) < 1e-11
            assert near.residual < 1e-11
            turned = near.s[index] - start.s[index]
            assert turned == pytest.approx(
                bennett_angles(START + u)[1] - bennett_angles(START)[1], abs=1e-10
            )

    def test_a_pivot_off_by_a_tenth_of_a_millimetre_holds_it_fast(self, kind: str) -> None:
        with pytest.raises(DescriptionError, match=r"nothing can move|does not close"):
            Robot(bennett(kind, seed=1, spoilt=1e-4))

    def test_singular_only_where_the_full_jacobian_is(self, kind: str) -> None:
        """The linkage is regular all along this way.

        Which of its equations are solved must not matter.
        """
        for seed in range(2):
            description = bennett(kind, seed)
            linkage = Robot(description)
            space = Space(description, linkage.coordinates)
            near = linkage.close(linkage.reference)
            for u in np.linspace(0.0, 2.0, 150):
                near = linkage.close(linkage.reference - u, near=near)
                sizes = np.linalg.svd(space.equations(near.s)[1][:, 1:], compute_uv=False)
                whole = len(sizes) / (np.linalg.norm(sizes) * np.linalg.norm(1.0 / sizes))
                assert float(near.singularity) > 0.05 * whole


CRANKS = """
format: 1
name: cranks
links: {base: {}, one: {mass: 1}, two: {mass: 2}, three: {mass: 1}, plate: {mass: 3}}
joints:
  a: {type: revolute, parent: base, child: one, axis: z}
  r: {type: revolute, parent: one, child: plate, axis: z, origin: {xyz: [0.2, 0, 0]}}
  b: {type: revolute, parent: base, child: two, axis: z, origin: {xyz: [0.5, 0, 0]}}
  c: {type: revolute, parent: base, child: three, axis: z, origin: {xyz: [0.2, 0.3, 0]}}
closures:
  front: {kind: planar, between: {plate: [0.5, 0, 0], two: [0.2, 0, 0]}}
  back: {kind: planar, between: {plate: [0.2, 0.3, 0], three: [0.2, 0, 0]}}
active: [a]
end_effector: {link: plate}
reference: {a: 0.7, r: -0.7}
"""


class TestThreeCranks:
    """A third crank carries a parallelogram through the place where it lies flat."""

    @pytest.mark.parametrize("start", ["a: 0.7, r: -0.7", "a: 0, r: 0", "a: 0"])
    def test_it_passes_where_two_cranks_alone_do_not(self, start: str) -> None:
        """Every angle is that of the crank."""
        cranks = robot(CRANKS.replace("a: 0.7, r: -0.7", start))
        near = cranks.close(cranks.reference)
        for u in np.linspace(cranks.reference[0], -0.7, 12):
            near = cranks.close([u], [1.0], near=near)
            np.testing.assert_allclose(near.s, [u, -u, u, u], atol=1e-12)
            np.testing.assert_allclose(near.ds, [1.0, -1.0, 1.0, 1.0], atol=1e-12)
            assert float(near.singularity) > 0.3

    def test_compiled_calls_and_forces_are_those_of_a_point_on_a_circle(self) -> None:
        """No weight does work but along z, so effort is inertia alone, and reactions balance it."""
        cranks = robot(CRANKS)
        near = cranks.close([0.1])
        state = cranks.close([0.0], [2.0], near=near)
        efforts = cranks.inverse_dynamics(state, [3.0])
        np.testing.assert_allclose(efforts, [3 * 0.2**2 * 3.0], atol=1e-12)
        compiled = cranks.kernels.inverse_dynamics([0.0], [2.0], [3.0], guess=near.s)
        np.testing.assert_allclose(compiled, efforts, atol=1e-12)
        terms = cranks.spanning_terms(state, [3.0])
        assert terms.J.shape == (3, 4)
        assert len(terms.loops) == 3
        dds = cranks.accelerations(state, [3.0])
        np.testing.assert_allclose(terms.J @ dds + terms.bias, 0.0, atol=1e-12)
        forces = terms.M @ dds + terms.C @ state.ds + terms.g + terms.J.T @ terms.multipliers
        np.testing.assert_allclose(forces, [*efforts, 0.0, 0.0, 0.0], atol=1e-12)

    def test_modes_are_those_of_all_equations(self) -> None:
        """The crossed four-bar does not close the third crank."""
        modes = robot(CRANKS).assembly_modes([0.3])
        assert len(modes) == 1

    def test_a_named_mode_says_where_iterations_start(self) -> None:
        one = "front: {kind: planar, assembly: {}, "
        for mode, closes in (("counterclockwise", True), ("clockwise", False)):
            text = CRANKS.replace("front: {kind: planar, ", one.replace("{}", mode))
            if closes:
                assert robot(text).close([0.7]).s[1] == pytest.approx(-0.7)
            else:
                with pytest.raises(DescriptionError):
                    robot(text)


def framed(rpy: str, other: str) -> str:
    """The four-bar cut behind its coupler and closed by a whole frame, which lies as the two angles
    say.
    """
    text = four_bar(0.3, 0.1, 0.3, 0.2, assembly="", reference="q1: 1, q2: -0.6, q3: 1.4, q4: -1")
    head, tail = text[: text.index("loops:")], text[text.index("active:") :]
    head = head.replace("rocker: {mass: 1}}", "rocker: {mass: 1}, half: {mass: 1}}")
    ends = f"{{coupler: {{xyz: [0.3, 0, 0], rpy: {rpy}}}, half: {{rpy: {other}}}}}"
    return (
        f"{head}  q4: {{type: revolute, parent: rocker, child: half, origin: {{xyz: [0.2, 0, 0]}},"
        f" axis: z}}\nclosures:\n  bar: {{kind: frame, between: {ends}}}\n{tail}"
    )


class TestPlanarLoopClosedByAFrame:
    @pytest.mark.parametrize("rpy", ["[0, 0, 0]", "[0, pi/2, 0]", "[pi/2, 0, 0]", "[0.3, -1.2, 2]"])
    def test_it_is_the_four_bar_however_the_frame_lies(self, rpy: str) -> None:
        """Six equations, three of them count.

        Also where an axis of the tied frames is normal to the plane.
        """
        plain, welded = robot(four_bar(0.3, 0.1, 0.3, 0.2)), robot(framed(rpy, rpy))
        for u in np.linspace(-3.0, 3.0, 9):
            one, two = plain.close([u], [1.0]), welded.close([u], [1.0])
            for k, name in enumerate(plain.coordinates):
                other = welded.coordinates.index(name)
                assert np.cos(two.s[other] - one.s[k]) == pytest.approx(1.0, abs=1e-14)
                assert np.sin(two.s[other] - one.s[k]) == pytest.approx(0.0, abs=1e-12)
                assert two.ds[other] == pytest.approx(one.ds[k], abs=1e-11)

    def test_frames_tilted_against_each_other_are_refused(self) -> None:
        with pytest.raises(DescriptionError) as caught:
            robot(framed("[0, 0, 0]", "[0.1, 0, 0]"))
        assert caught.value.line is not None


class TestLoopsThatDoNotClose:
    def test_a_leg_that_does_not_reach_is_described(self) -> None:
        text = (
            "format: 1\nname: leg\nlinks: {base: {}, foot: {mass: 1}, leg: {mass: 1}, arm: {mass:"
            " 1}}\njoints:\n  a: {type: revolute, parent: base, child: foot, axis: x}\n  b: {type:"
            " revolute, parent: foot, child: leg, axis: y}\n  c: {type: prismatic, parent: base,"
            " child: arm, origin: {xyz: [2, 0, 0]}, axis: y}\nclosures:\n  ball: {kind: point,"
            " between: {leg: [0, 0, 0.5], arm: [0.1, 0, 0.2]}}\nactive: [a]\nend_effector: {link:"
            " arm}\n"
        )
        with pytest.raises(DescriptionError) as caught:
            robot(text)
        assert caught.value.key == "closures.ball"
        assert caught.value.line is not None
        assert f"its ends on leg and arm stay {np.hypot(2.1, 0.2) - 0.5:.3g} m apart" in str(
            caught.value
        )

    def test_motors_that_cannot_close_are_described_the_same(self) -> None:
        """The foot's pin is 0.3 m from the wall, whose slide keeps 0.5 m away.

        0.2 m are missing.
        """
        text = (
            "format: 1\nname: leg\nlinks: {base: {}, foot: {mass: 1}, arm: {mass: 1}}\njoints:\n "
            " a: {type: revolute, parent: base, child: foot, axis: z}\n  c: {type: prismatic,"
            " parent: base, child: arm, origin: {xyz: [0.5, 0, 0]}, axis: y}\nclosures:\n  pin:"
            " {kind: planar, between: {foot: [0.3, 0, 0], arm: [0, 0, 0]}}\nactive:"
            " [a]\nend_effector: {link: arm}\n"
        )
        description = replace(parse_description(text, file="leg.yaml"), active_set="motors")
        with pytest.raises(
            DescriptionError, match=r"closures\.pin: does not close: .* stay 0\.2 m apart"
        ) as caught:
            Robot(description)
        assert caught.value.line == 8

    def test_a_truss_is_described(self) -> None:
        """Two bars pinned together and to the ground: a triangle, which moves nowhere."""
        text = (
            "format: 1\nname: truss\nlinks: {base: {}, left: {mass: 1}, right: {mass:"
            " 1}}\njoints:\n  a: {type: revolute, parent: base, child: left, axis: z}\n  b: {type:"
            " revolute, parent: base, child: right, origin: {xyz: [1, 0, 0]}, axis: z}\nclosures:\n"
            "  top: {kind: planar, between: {left: [1, 0, 0], right: [1, 0, 0]}}\nactive:"
            " [a]\nend_effector: {link: left}\nreference: {a: 1.0471975511965976, b:"
            " 2.0943951023931953}\n"
        )
        description = replace(parse_description(text, file="truss.yaml"), active_set="motors")
        with pytest.raises(
            DescriptionError, match=r"hold every joint fast: .* take out one of top, or mend"
        ) as caught:
            Robot(description)
        assert caught.value.line == 8

    def test_a_tilt_is_described_in_radians(self) -> None:
        """Two frames of a planar loop, tilted by 0.1 rad against each other.

        Least squares leave metres too.
        """
        with pytest.raises(
            DescriptionError, match=r"its ends on coupler and half stay .* m and 0\.1 rad apart"
        ):
            robot(framed("[0, 0, 0]", "[0.1, 0, 0]"))

    def test_a_follower_off_its_course_is_described_in_its_unit(self) -> None:
        origin = "origin: {xyz: [0.3, 0, 0]}, axis: z"
        text = four_bar(0.3, 0.1, 0.3, 0.2).replace(origin, f"{origin}, mimic: {{joint: q1}}")
        description = parse_description(text)
        tree = build_tree(description)
        values = {
            tree.coordinates.index(name): value
            for name, value in (("q1", 1.0), ("q2", 0.3), ("q3", 1.25))
        }
        told = describe_gap(tree, description, "q3", given_configuration(tree, values))
        assert told == "it stays 0.25 rad off what it follows, q1"

    def test_an_opened_loop_is_never_returned_as_closed(self) -> None:
        """Alone, in a batch and followed."""
        bar = robot(four_bar(0.3, 0.1, 0.3, 0.2, active="q3", reference="q3: 1.6"))
        near = bar.close([1.6])
        for value in (0.5, 3.0, 1.3):
            with pytest.raises(ClosureError):
                bar.close([value])
            with pytest.raises(ClosureError):
                bar.close([value], near=near)
            state = bar.close([[1.6], [value]], check=False)
            assert [int(status) for status in state.status] == [0, 1]
            assert np.isnan(state.s[1]).all()

    def test_three_slides_are_no_planar_loop(self) -> None:
        """Nothing tells the plane of a loop without a revolute joint: the message says so."""
        text = (
            "format: 1\nname: wedge\nlinks: {base: {}, one: {mass: 1}, two: {mass: 1}, three:"
            " {mass: 1}}\njoints:\n  a: {type: prismatic, parent: base, child: one, axis: x}\n  b:"
            " {type: prismatic, parent: one, child: two, axis: y}\n  c: {type: prismatic, parent:"
            " base, child: three, axis: [1, 1, 0]}\nclosures:\n  wedge: {kind: planar, between:"
            " {two: [0, 0, 0], three: [0, 0, 0]}}\nactive: [a]\nend_effector: {link: three}\n"
        )
        with pytest.raises(DescriptionError, match=r"closures\.wedge: .*no revolute joint"):
            robot(text)


TWICE = """
format: 1
name: twice
links: {base: {}, crank: {mass: 1}, rocker: {mass: 1}, rod: {mass: 1}}
joints:
  a: {type: revolute, parent: base, child: crank, axis: z}
  r: {type: revolute, parent: crank, child: rod, axis: z, origin: {xyz: [0.2, 0, 0]}}
  b: {type: revolute, parent: base, child: rocker, axis: z, origin: {xyz: [0.5, 0, 0]}}
closures:
  front: {kind: KIND, between: {rod: [0.45, 0, 0], rocker: [0.35, 0, 0]}}
  back: {kind: KIND, between: {rod: [0.45, 0, 0.05], rocker: [PIN, 0, 0.05]}}
active: [a]
end_effector: {link: rod}
reference: {a: 0.7, r: 0.2, b: 1.5}
"""


class TestRoundedNumbers:
    """A pin written twice, once with fewer digits: the nearest place shares the misfit."""

    @pytest.mark.parametrize("kind", ["planar", "point"])
    @pytest.mark.parametrize("misfit", [1e-8, 3e-7, 1e-5, 1e-3])
    def test_the_error_says_by_how_much_which_closure_and_what_is_allowed(
        self, kind: str, misfit: float
    ) -> None:
        with pytest.raises(DescriptionError) as caught:
            robot(TWICE.replace("KIND", kind).replace("PIN", f"{0.35 + misfit:.10f}"))
        problem = str(caught.value)
        assert caught.value.key in ("closures.front", "closures.back")
        (gap,) = re.findall(r"its ends on rod and rocker stay (\S+) m apart", problem)
        assert float(gap) == pytest.approx(misfit / 2, rel=0.03)
        assert " is allowed" in problem
        assert ("moved by 0.02" in problem) == (misfit < 1e-6)
        assert "more digits" in problem or "mend the geometry" in problem

    def test_one_in_the_file_is_one_in_motion(self) -> None:
        assert robot(TWICE.replace("KIND", "point").replace("PIN", "0.35")).close([1.2])


def test_more_loops_than_can_be_solved_in_seconds_are_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Files of others may hold a cloth of hundreds of springs. Couplings of joints do not count."""
    description = replace(robot(four_bar(0.4, 0.1, 0.5, 0.3)).description, active_set="motors")
    loops = loop_equations(build_tree(description), description, frozenset(range(3)))
    size = sum(loop.size for loop in loops)
    monkeypatch.setattr(mobility, "MAX_EQUATIONS", size)
    assert Robot(description).active == ("q1",)
    monkeypatch.setattr(mobility, "MAX_EQUATIONS", size - 1)
    with pytest.raises(DescriptionError, match=f"1 loops with {size} equations; at most"):
        Robot(description)
