"""All solutions of a block that closes by iteration, where they can be proved to be all."""

from __future__ import annotations

import numpy as np

from ..closure.blocks.block_solver import BlockSolver
from ..ground.wording import counted
from .planar.planar_platform import PlanarPlatform, planar_platform
from .planar.planar_poses import planar_poses
from .platforms.leg_platform import CLEAR, LegPlatform, leg_platform
from .platforms.platform import platform_poses
from .platforms.spherical import orientations
from .setting import BlockModes, Setting
from .subdivided import subdivided


def certified_modes(block: BlockSolver, setting: Setting) -> BlockModes | None:
    """Certified solutions of a block; None if its kind has no such method."""
    platform = leg_platform(block)
    if platform is not None:
        return _modes_of_platform(platform, block, setting)
    planar = planar_platform(block)
    if planar is not None:
        return _modes_in_plane(planar, block, setting)
    return subdivided(block, setting)


def _modes_in_plane(platform: PlanarPlatform, block: BlockSolver, setting: Setting) -> BlockModes:
    legs = platform.balls(setting.tree, setting.configuration, setting.given)
    poses = planar_poses(legs)
    real = poses.real[0]
    solutions: list[list[float]] = []
    for turn, place in zip(
        poses.turns[0, real],
        poses.places[0, real],
        strict=True,
    ):
        placed = platform.placed(
            complex(turn), complex(place), setting.configuration, setting.guess
        )
        if placed is not None:
            solutions.append([float(placed.q[k]) for k in block.unknowns])
    values = np.reshape(
        solutions,
        (len(solutions), len(block.unknowns)),
    )
    complete = bool(poses.complete[0]) and len(solutions) == np.count_nonzero(real)
    number = counted(len(solutions), "certified root")
    reason = f"{number} of its resultant on the unit circle"
    if complete:
        reason = f"{reason}, and it is proved to have no other"
    return BlockModes(values, complete, reason)


def _modes_of_platform(platform: LegPlatform, block: BlockSolver, setting: Setting) -> BlockModes:
    legs = platform.intervals(setting.tree, setting.configuration, setting.given)
    poses = orientations(legs) if platform.carrier.is_fixed else platform_poses(legs)
    solutions: list[list[float]] = []
    complete, reason = poses.complete, poses.reason
    for rotation, origin in zip(
        poses.rotations,
        poses.origins,
        strict=True,
    ):
        placed, margin = platform.carrier.placed(
            rotation, origin, setting.configuration, setting.guess
        )
        for hinge in platform.hinges:
            hinge.aim(placed, setting.guess)
        if margin > CLEAR:
            solutions.append([float(placed.q[k]) for k in block.unknowns])
        elif margin > -CLEAR:
            complete = False
            reason = f"{reason}; one is singular for the joints that carry the platform"
    values = np.reshape(
        solutions,
        (len(solutions), len(block.unknowns)),
    )
    return BlockModes(values, complete, reason)
