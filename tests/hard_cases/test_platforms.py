"""Platforms: all assembly modes, counted by other means.

Mirror images; places where a platform gives way.
"""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core import (
    ClosedState,
    DescriptionError,
    InputError,
    Robot,
    SingularityError,
    load,
)
from hybrid_dynamics_core.closed_state import mode_search
from hybrid_dynamics_core.closed_state.assembly_modes import Completeness
from hybrid_dynamics_core.errors import StateError
from tests.generated.assembly import turn, unit
from tests.hard_cases.multistart import platform_poses
from tests.hard_cases.platforms import own_pose, platform
from tests.hard_cases.quadrics import rotations_at_distances
from tests.sampling import swept

Pose = tuple[np.ndarray, np.ndarray]
SAME = 1e-6  # poses nearer than this are one


def same_sets(one: list[Pose], other: list[Pose]) -> bool:
    """Whether two lists hold the same poses, each once."""

    def apart(a: Pose, b: Pose) -> float:
        return max(float(np.abs(x - y).max()) for x, y in zip(a, b, strict=True))

    found = [sum(apart(a, b) < SAME for b in other) for a in one]
    return len(one) == len(other) and found == [1] * len(one)


def poses_of_modes(robot: Robot, link: str, u: np.ndarray, reference: Pose) -> list[Pose]:
    """Rotation of the platform and place of its centre, for every mode; all closed."""
    turned, offset = own_pose(robot, link, reference)
    modes = robot.assembly_modes(u)
    assert all(mode.state.residual < 1e-12 for mode in modes)
    poses = [robot.forward_kinematics(mode.state, frame=link) for mode in modes]
    return [(pose.rotation @ turned, pose.position + pose.rotation @ offset) for pose in poses]


class TestSphericalPlatform:
    """3-UPS/S: three legs turn a platform about a point; up to eight modes."""

    def test_eight_modes_known_in_closed_form_are_all_found(self) -> None:
        """Feet and tips on three axes at right angles.

        The legs give the diagonal of R, and with a quaternion

        4 w^2 = 1 + R11 + R22 + R33, 4 x^2 = 1 + R11 - R22 - R33 and so on: sixteen choices of
        signs, eight rotations.
        """
        start = turn(unit(np.array([1.0, -2.0, 0.5])), 1.9)
        w, x, y, z = (
            0.5 * np.sqrt(1.0 + np.diag(start) @ signs)
            for signs in np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
        )
        expected = []
        for sx, sy, sz in np.ndindex(2, 2, 2):
            vector = np.array([x, y, z]) * (1.0 - 2.0 * np.array([sx, sy, sz]))
            expected.append(
                (
                    turn(unit(vector), 2.0 * np.arctan2(float(np.linalg.norm(vector)), w)),
                    np.zeros(3),
                )
            )
        feet, tips = 0.8 * np.eye(3), 0.3 * np.eye(3)
        robot, legs, link = platform(feet, tips, (start, np.zeros(3)), freedoms="abc")
        found = poses_of_modes(robot, link, legs, (start, np.zeros(3)))
        assert same_sets(found, expected)

    @pytest.mark.parametrize("seed", swept(range(8), range(3)))
    def test_modes_are_those_of_elimination(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        feet = 0.8 * np.eye(3) + 0.3 * rng.normal(size=(3, 3))
        tips = 0.4 * np.eye(3) + 0.15 * rng.normal(size=(3, 3))
        start = turn(unit(rng.normal(size=3)), rng.uniform(0.0, 3.0))
        lengths = np.linalg.norm(tips @ start.T - feet, axis=1)
        expected = [(r, np.zeros(3)) for r in rotations_at_distances(feet, tips, lengths)]
        robot, legs, link = platform(feet, tips, (start, np.zeros(3)), freedoms="abc")
        found = poses_of_modes(robot, link, legs, (start, np.zeros(3)))
        assert len(expected) in (2, 4, 6, 8)
        assert robot.assembly_modes(legs).complete
        assert same_sets(found, expected)

    def test_staicus_upper_module_has_its_modes(self) -> None:
        """In the central configuration; feet and tips from the paper's geometry."""
        robot = load("staicu2015")
        radius, height = 0.75 / np.sqrt(3.0), np.sqrt(1.5**2 - 0.75**2 / 3.0)
        angles = np.array([0.0, 2.0, -2.0]) * np.pi / 3.0
        ring = [
            np.column_stack([np.cos(angles + t), np.sin(angles + t), 0 * angles])
            for t in (0.0, np.pi / 3.0)
        ]
        feet, tips = radius * ring[0] - [0.0, 0.0, height], radius * ring[1]
        u = robot.reference.copy()
        u[3:] += [0.01, 0.02, -0.015]  # off the symmetric place, where modes fall together
        lengths = 1.5 + u[3:] if abs(robot.close(u).s[3] - u[3]) < 1e-12 else u[3:]
        expected = rotations_at_distances(feet, tips, np.asarray(lengths))
        modes = robot.assembly_modes(u)
        frames = [robot.forward_kinematics(m.state, frame="upper_platform").rotation for m in modes]
        upper = [
            f for k, f in enumerate(frames) if all(np.abs(f - g).max() > SAME for g in frames[:k])
        ]
        assert len(upper) == len(expected)
        assert len(modes) == 2 * len(expected)  # the lower platform above or below


SIXTEEN = (
    [
        [0.51, -0.92, 0.37],
        [0.1, 0.84, 0.43],
        [-0.55, -0.22, -0.4],
        [0.37, 0.26, -0.78],
        [-0.77, -0.94, 0.72],
        [0.1, 0.48, -0.73],
    ],
    [
        [0.14, 0.8, -0.46],
        [-0.05, 0.43, -0.24],
        [-0.25, -0.64, 0.14],
        [0.48, -0.67, -0.43],
        [0.69, 0.5, 0.71],
        [0.24, -0.61, 0.96],
    ],
    [1.72, 1.25, 1.21, 1.21, 2.3, 1.58],
)
TWELVE = (
    [
        [0.86, 0.5, 0],
        [-0.73, 0.29, 0],
        [-0.63, -0.86, 0],
        [0.21, -0.98, 0],
        [-0.89, -0.22, 0],
        [-0.64, 0.33, 0],
    ],
    [
        [-0.44, -0.52, 0],
        [0.1, 0.05, 0],
        [0.69, 0.64, 0],
        [0.87, -0.78, 0],
        [-0.89, 0.5, 0],
        [-0.2, -0.89, 0],
    ],
    [1.5, 1.04, 1.73, 1.31, 2.11, 1.45],
)

# anchor points and squared lengths of Dietmaier (1998): forty modes, all real
FORTY = (
    [
        [0.0, 0.0, 0.0],
        [1.107915, 0.0, 0.0],
        [0.549094, 0.756063, 0.0],
        [0.735077, -0.223935, 0.525991],
        [0.514188, -0.526063, -0.368418],
        [0.590473, 0.094733, -0.205018],
    ],
    [
        [0.0, 0.0, 0.0],
        [0.542805, 0.0, 0.0],
        [0.956919, -0.528915, 0.0],
        [0.665885, -0.353482, 1.402538],
        [0.478359, 1.158742, 0.107672],
        [-0.137087, -0.235121, 0.353913],
    ],
    [1.0, 0.645275, 1.086284, 1.503439, 1.281933, 0.771071],
)


class TestGoughPlatform:
    @pytest.mark.parametrize(
        ("geometry", "count"),
        swept([(SIXTEEN, 16), (TWELVE, 12)], [SIXTEEN]),
        ids=["in space", "flat"],
    )
    def test_modes_are_those_of_brute_force(self, geometry: tuple, count: int) -> None:
        """Six thousand starts of another iteration, on rotations and not on angles."""
        feet, tips, lengths = (np.array(part) for part in geometry)
        expected = platform_poses(feet, tips, lengths, 6000)
        assert len(expected) == count
        robot, legs, link = platform(feet, tips, expected[0])
        assert same_sets(poses_of_modes(robot, link, legs, expected[0]), expected)

    @pytest.mark.sweep(sample="test_modes_are_those_of_brute_force")
    def test_forty_modes_are_listed_and_proved_to_be_all(self) -> None:
        """The published number for this platform, met by few starts each."""
        feet, tips, lengths = (np.array(part) for part in FORTY)
        expected = platform_poses(feet, tips, lengths, 6000)
        robot, legs, link = platform(feet, tips, expected[0])
        modes = robot.assembly_modes(legs)
        assert len(modes) == 40
        assert modes.complete
        listed = poses_of_modes(robot, link, legs, expected[0])
        assert all(any(same_sets([pose], [one]) for one in listed) for pose in expected)

    def test_a_short_search_says_so(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(mode_search, "STARTS", 20)
        monkeypatch.setattr(mode_search, "MOST_STARTS", 20)
        monkeypatch.setattr(mode_search, "certified_modes", lambda *_: None)
        feet, tips, lengths = (np.array(part) for part in SIXTEEN)
        robot, legs, _ = platform(feet, tips, platform_poses(feet, tips, lengths, 600)[0])
        modes = robot.assembly_modes(legs)
        assert len(modes) < 16
        assert modes.completeness is Completeness.UNLIKELY
        assert "of 20 starts only 1 came to one of the modes" in modes.reason

    def test_a_numbered_mode_is_given_by_its_state(self) -> None:
        robot = load("gough")
        mode = robot.assembly_modes(robot.reference)[1]
        with pytest.raises(InputError, match=r"give close\(u, near=mode\.state\)"):
            robot.close(robot.reference, branch=mode.branch)
        state = robot.close(robot.reference, near=mode.state)
        np.testing.assert_allclose(state.s, mode.state.s, atol=1e-9)

    def test_modes_of_a_flat_platform_are_mirror_images_in_pairs(self) -> None:
        feet, tips, lengths = (np.array(part) for part in TWELVE)
        poses = platform_poses(feet, tips, lengths, 6000)
        robot, legs, link = platform(feet, tips, poses[0])
        found = poses_of_modes(robot, link, legs, poses[0])
        mirror = np.diag([1.0, 1.0, -1.0])
        assert same_sets([(mirror @ r @ mirror, mirror @ t) for r, t in found], found)

    def test_forward_kinematics_finds_the_pose_that_gave_the_legs(self) -> None:
        """Pose to legs and back, with rates and accelerations, on the shipped platform, along a
        motion.
        """
        robot = load("gough")
        pose = ("x", "y", "z", "alpha_1", "alpha_2", "alpha_3")
        place = [next(n for n in robot.coordinates if n == p or n.endswith(p)) for p in pose]
        rng = np.random.default_rng(2)
        near = None
        for _ in range(10):
            values, rates, push = (
                dict(zip(place, 0.08 * rng.uniform(-1, 1, 6), strict=True)) for _ in range(3)
            )
            state = robot.close_given(values, rates, push, near=near)
            back = robot.close(state.u, state.du, near=near)
            index = [robot.coordinates.index(n) for n in place]
            assert back.s[index] == pytest.approx(list(values.values()), abs=1e-10)
            assert back.ds[index] == pytest.approx(list(rates.values()), abs=1e-9)
            assert state.dds is not None
            accelerations = robot.accelerations(back, state.dds[: len(state.u)])
            assert accelerations[index] == pytest.approx(list(push.values()), abs=1e-8)
            near = back

    @staticmethod
    def hexagons(spread: float) -> tuple[np.ndarray, np.ndarray]:
        """Feet and tips in three pairs each.

        The tips spread so far from the middle of their pair.
        """
        pairs = np.repeat([0.0, 2.0 * np.pi / 3.0, -2.0 * np.pi / 3.0], 2)
        sides = np.tile([-1.0, 1.0], 3)

        def ring(radius: float, angle: float) -> np.ndarray:
            angles = pairs + angle * sides
            return radius * np.column_stack([np.cos(angles), np.sin(angles), 0.0 * angles])

        return ring(0.6, 0.2), ring(0.4, spread)

    @staticmethod
    def closed(feet: np.ndarray, tips: np.ndarray, pose: Pose) -> ClosedState:
        robot, legs, _ = platform(feet, tips, pose)
        return robot.close(legs)

    def test_similar_platforms_give_way_everywhere(self) -> None:
        """Base and platform alike but for size.

        Six legs leave a freedom in every pose (architecture singularity).
        """
        rng = np.random.default_rng(0)
        for _ in range(3):
            pose = (turn(unit(rng.normal(size=3)), 0.3), np.array([0.05, -0.02, 0.7]))
            with pytest.raises((DescriptionError, StateError), match=r"singular|cannot close"):
                self.closed(*self.hexagons(0.2), pose)

    def test_level_platform_turned_by_a_right_angle_is_singular_and_told_before(self) -> None:
        """Fichter (1986): three pairs of legs cannot hold the level platform at a quarter turn."""
        feet, tips = self.hexagons(0.8)
        distances = []
        for left in (0.9, 0.3, 0.1, 0.03, 0.01):
            pose = (turn(np.array([0.0, 0.0, 1.0]), np.pi / 2.0 - left), np.array([0.0, 0.0, 0.7]))
            state = self.closed(feet, tips, pose)
            distances.append(float(state.singularity))
            assert "c" in state.singular_loop  # the block of six legs, not one of their joints
        assert np.all(np.diff(distances) < 0.0)
        assert distances[-1] == pytest.approx(
            distances[-2] / 3.0, rel=0.1
        )  # in proportion to what is left
        with pytest.raises((DescriptionError, SingularityError), match="singular"):
            self.closed(
                feet,
                tips,
                (turn(np.array([0.0, 0.0, 1.0]), np.pi / 2.0), np.array([0.0, 0.0, 0.7])),
            )


@pytest.mark.sweep(sample="test_no_step_crosses_a_change_point")
def test_way_of_a_platform_is_the_same_there_and_back() -> None:
    """Legs to random lengths from one pose.

    Refused where the way meets a singular pose, otherwise it leads back.
    """
    pose = (turn(unit(np.array([1.0, -2.0, 0.5])), 1.9), np.zeros(3))
    robot, legs, _ = platform(0.8 * np.eye(3), 0.3 * np.eye(3), pose, freedoms="abc")
    state = robot.close(legs)
    rng = np.random.default_rng(3)
    refused = 0
    for _ in range(12):
        try:
            there = robot.close(legs + 0.1 * rng.uniform(-1.0, 1.0, size=3), near=state)
        except StateError:
            refused += 1
            continue
        assert robot.close(legs, near=there).s == pytest.approx(state.s, abs=1e-9)
    assert 0 < refused < 12
