"""All solutions of a block whose unknowns have bounds, by subdivision of these."""

from __future__ import annotations

import numpy as np

from ..closure.blocks.block_solver import BlockSolver
from ..closure.constraints.equations import loops_of
from ..ground.wording import counted
from .boxes.all_solutions import Region, all_solutions
from .boxes.loop_graph import LoopGraph
from .boxes.slide_bounds import slide_bounds
from .rounding import up
from .setting import BlockModes, Setting

ROUNDED = 1e-11  # [rad or m] what rounding of given values and of the file's numbers may decide
HALF_TURN = float(up(np.asarray(np.pi)))  # [rad]


def subdivided(block: BlockSolver, setting: Setting) -> BlockModes | None:
    """Certified solutions of a block.

    None if its unknowns have no bounds, if their whole turns count, or if its loops have equations
    besides those of the block.
    """
    tree, before = setting.tree, setting.configuration
    if len(block.equations) != len(block.unknowns) or block.counted_turns & set(block.unknowns):
        return None
    if sum(loop.size for loop in loops_of(block.equations)) != len(block.equations):
        return None  # the loop has further equations, which solutions of these need not meet
    bounds = slide_bounds(block, setting)
    if bounds is None:
        return None
    graph = LoopGraph(tree, [block], block.inputs, before.charts)
    if not graph.is_smooth:
        return None
    given = np.array([float(before.q[k]) for k in block.inputs])
    uncertainty = np.full(len(given), ROUNDED)
    turns = np.array([tree.is_revolute(k) for k in block.unknowns])
    reach = np.array([bounds.get(k, HALF_TURN) for k in block.unknowns])
    solutions = all_solutions(
        graph, Region(given - uncertainty, given + uncertainty, -reach, reach, turns)
    )
    number = counted(len(solutions.middle), "certified solution")
    reason = f"{number}, by subdivision of all values into {solutions.boxes} boxes"
    if solutions.complete:
        return BlockModes(solutions.middle, True, f"{reason}, and it is proved to have no other")
    return BlockModes(solutions.middle, False, f"{reason}, of which some were not decided")
