"""How often the modes of random mechanisms are proved to be all: python tools/count_modes.py [N].

Each list is compared with another method: Newton's from random starts may reach no pose that a
list lacks. Prints times, numbers of modes, and what was not proved.
"""

from __future__ import annotations

import sys
import time
from collections import Counter
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from hybrid_dynamics_core.certified.complex_ball import Ball
from hybrid_dynamics_core.certified.planar.planar_poses import PlanarLegs, planar_poses
from tests.certified.geometries import random_legs, random_planar_legs, solved
from tests.hard_cases.multistart import platform_poses

STARTS = 300  # of the other method
COMPARED = 20  # every so many lists


def count_platforms(number: int) -> None:
    """Random platforms on six legs."""
    times, counts = [], Counter[int]()
    missing, unproved = 0, 0
    for seed in range(number):
        feet, tips, lengths = random_legs(np.random.default_rng(seed))
        begin = time.perf_counter()
        poses = solved(feet, tips, lengths)
        times.append(time.perf_counter() - begin)
        counts[len(poses.origins)] += 1
        unproved += not poses.complete
        if seed % COMPARED:
            continue
        for rotation, _ in platform_poses(feet, tips, lengths, STARTS, seed):
            apart = np.abs(poses.rotations - rotation).max(axis=(1, 2))
            missing += not (apart < 1e-6).any()
    shares = ", ".join(f"{n}: {counts[n]}" for n in sorted(counts))
    print(f"platforms on six legs: {number}, not proved {unproved}, poses missing {missing}")
    print(f"  numbers of modes {shares}")
    print(f"  time: median {np.median(times):.3f} s, longest {max(times):.3f} s")


def count_planar(number: int) -> None:
    """Random planar platforms on three legs, all at once."""
    feet, tips, squares, _, turn = random_planar_legs(np.random.default_rng(0), number)
    balls = [Ball(x.astype(complex), 1e-16 * np.abs(x)) for x in (feet, tips, squares)]
    begin = time.perf_counter()
    poses = planar_poses(PlanarLegs(*balls))
    wall = time.perf_counter() - begin
    counts = Counter(poses.real.sum(axis=1).tolist())
    apart = np.where(poses.real, np.abs(poses.turns - turn), 1.0).min(axis=1)
    missing = np.count_nonzero(poses.complete & (apart > 1e-4))
    shares = ", ".join(f"{n}: {counts[n]}" for n in sorted(counts))
    unproved = number - np.count_nonzero(poses.complete)
    print(f"planar platforms: {number}, not proved {unproved}, poses missing {missing}")
    print(f"  numbers of modes {shares}")
    print(f"  time: {wall:.2f} s in all")


if __name__ == "__main__":
    count_planar(10000)
    count_platforms(int(sys.argv[1]) if len(sys.argv) > 1 else 100)
