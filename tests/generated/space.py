"""Poses, loop equations in space and their Jacobian from a description alone, and Newton on them.

Written to share nothing with the library: geometric Jacobians of all links, every closure as
equations in space (more than a planar loop needs), least squares for the redundant ones.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hybrid_dynamics_core.description import Closure, RobotDescription
from tests.generated.assembly import skew, turn


class Space:
    """A description as an open tree with constraint equations; coordinates in the order `names`."""

    def __init__(self, robot: RobotDescription, names: Sequence[str]) -> None:
        self.robot = robot
        self.names = list(names)
        self.size = len(self.names)
        self.order: list[str] = []
        hung = {robot.base}
        while len(self.order) < len(robot.joints):
            ready = [n for n, j in robot.joints.items() if j.parent in hung and n not in self.order]
            self.order += ready
            hung |= {robot.joints[n].child for n in ready}
        self.chain: dict[str, list[str]] = {robot.base: []}
        for name in self.order:
            joint = robot.joints[name]
            self.chain[joint.child] = [*self.chain[joint.parent], name]

    def poses(self, s: np.ndarray) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """(rotation, origin) of every link in the base frame."""
        value = dict(zip(self.names, s, strict=True))
        result = {self.robot.base: (np.eye(3), np.zeros(3))}
        for name in self.order:
            j = self.robot.joints[name]
            r, p = result[j.parent]
            r, p = r @ j.rotation, p + r @ j.translation
            moved = (
                (r @ turn(j.axis, value[name]), p)
                if j.type == "revolute"
                else (r, p + r @ j.axis * value[name])
            )
            result[j.child] = moved
        return result

    def columns(self, poses: dict, link: str, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Jacobians (3, n_s) of the velocity of a point (base frame) carried by the link, and of
        its spin.
        """
        linear, angular = np.zeros((3, self.size)), np.zeros((3, self.size))
        for name in self.chain[link]:
            j = self.robot.joints[name]
            r, p = poses[j.child]
            axis, k = r @ j.axis, self.names.index(name)
            if j.type == "revolute":
                linear[:, k], angular[:, k] = skew(axis) @ (point - p), axis
            else:
                linear[:, k] = axis
        return linear, angular

    def equations(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Residuals and Jacobian of all closures, in metres and radians."""
        poses = self.poses(s)
        parts = [self._closure(poses, c) for c in self.robot.closures]
        if not parts:
            return np.zeros(0), np.zeros((0, self.size))
        return np.concatenate([p[0] for p in parts]), np.vstack([p[1] for p in parts])

    def _closure(self, poses: dict, c: Closure) -> tuple[np.ndarray, np.ndarray]:
        ends = []
        for link, point, rotation in (
            (c.link_a, c.point_a, c.rotation_a),
            (c.link_b, c.point_b, c.rotation_b),
        ):
            r, p = poses[link]
            where = p + r @ point
            ends.append((where, r @ rotation, *self.columns(poses, link, where)))
        (pa, ra, va, wa), (pb, rb, vb, wb) = ends
        residual, rows = [pa - pb], [va - vb]
        columns = {"axis": [2], "frame": [0, 1, 2]}.get(c.kind, [])
        if columns:
            miss, slope = np.zeros(3), np.zeros((3, self.size))
            for k in columns:
                x, y = rb[:, k], ra[:, k]
                miss += skew(x) @ y / 2.0
                dx, dy = -skew(x) @ wb, -skew(y) @ wa  # w x x
                slope += (-skew(y) @ dx + skew(x) @ dy) / 2.0
            residual.append(miss)
            rows.append(slope)
        return np.concatenate(residual), np.vstack(rows)

    def gap(self, s: np.ndarray) -> float:
        """Largest closure error [m or rad]; opposed axes count as open."""
        worst = float(np.abs(self.equations(s)[0]).max(initial=0.0))
        poses = self.poses(s)
        for c in self.robot.closures:
            for k in {"axis": [2], "frame": [0, 1, 2]}.get(c.kind, []):
                a, b = (
                    (poses[c.link_a][0] @ c.rotation_a)[:, k],
                    (poses[c.link_b][0] @ c.rotation_b)[:, k],
                )
                worst = max(worst, 0.0 if a @ b > 0.0 else 2.0)
        return worst

    def close(self, s: np.ndarray, fixed: Sequence[int], tries: int = 40) -> np.ndarray | None:
        """Newton on the coordinates that are not fixed; None where it does not converge."""
        s = s.copy()
        free = [k for k in range(self.size) if k not in set(fixed)]
        if not free or not self.robot.closures:
            return s
        for _ in range(tries):
            residual, jacobian = self.equations(s)
            step = np.linalg.lstsq(jacobian[:, free], -residual, rcond=1e-9)[0]
            s[free] += step * min(1.0, 0.5 / max(float(np.abs(step).max()), 1e-300))
            if np.abs(step).max() < 1e-13:
                break
        return s if self.gap(s) < 1e-11 else None

    def margin(self, s: np.ndarray, fixed: Sequence[int]) -> float:
        """Smallest singular value of the Jacobian of the other coordinates.

        0 where they are not determined.
        """
        free = [k for k in range(self.size) if k not in set(fixed)]
        if not free:
            return 1.0
        jacobian = self.equations(s)[1][:, free]
        if len(jacobian) < len(free):
            return 0.0
        return float(np.linalg.svd(jacobian, compute_uv=False)[-1])

    def velocity_map(self, s: np.ndarray, fixed: Sequence[int]) -> np.ndarray:
        """(n_s, n): rates of all coordinates per rate of the fixed ones, by least squares."""
        fixed = list(fixed)
        free = [k for k in range(self.size) if k not in fixed]
        result = np.zeros((self.size, len(fixed)))
        result[fixed] = np.eye(len(fixed))
        if free:
            jacobian = self.equations(s)[1]
            result[free] = -np.linalg.lstsq(jacobian[:, free], jacobian[:, fixed], rcond=1e-9)[0]
        return result

    def follow(
        self,
        s: np.ndarray,
        fixed: Sequence[int],
        move: np.ndarray,
        floor: float = 0.0,
        far: float = np.inf,
        shortest: float = 0.01,
    ) -> tuple[float, np.ndarray]:
        """Go along `move` of the fixed coordinates in small steps.

        (share of the way, s) where it ended.

        Stops before the margin falls below the floor, and before any coordinate has gone as far as
        `far` [rad or m]. shortest: step, as a share of the way, that is given up.
        """
        fixed = list(fixed)
        start, done, length = s.copy(), 0.0, 0.25
        while done < 1.0 and length > shortest:
            ahead = min(1.0, done + length)
            slopes = self.velocity_map(s, fixed)
            guess = s + slopes @ ((ahead - done) * move)
            guess[fixed] = start[fixed] + ahead * move
            after = self.close(guess, fixed, 8)
            small = np.abs(guess - s).max() < 0.15
            if (
                after is None
                or not small
                or np.abs(after - guess).max() > 0.02
                or self.margin(after, fixed) < floor
            ):
                length /= 2.0
                continue
            if np.abs(after - start).max() > far:
                break
            s, done, length = after, ahead, 1.5 * length
        return done, s
