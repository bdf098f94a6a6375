"""Matching of equations to unknowns, and their order in block-triangular form.

Only the structure is used: which coordinate can occur in which equation.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from .constraints.equations import Equation

Rows = list[list[int]]  # of each equation, columns or other rows


class EquationBlock(NamedTuple):
    """Equations that together determine some unknowns, given the blocks before.

    They are as many as the unknowns, or more where redundant ones are solved with them.
    """

    equations: tuple[Equation, ...]
    unknowns: tuple[int, ...]


class Matching(NamedTuple):
    """Equations matched to unknowns.

    Attributes:
        blocks: blocks in solving order, where every equation and every unknown has its match.
        undetermined: unknowns without an equation.
        surplus: equations without an unknown.
    """

    blocks: list[EquationBlock]
    undetermined: list[int]
    surplus: list[Equation]


def match(
    equations: Sequence[Equation],
    unknowns: Sequence[int],
    ties: Sequence[Sequence[Equation]] = (),
) -> Matching:
    """Match equations to unknowns and order them into the smallest blocks.

    Args:
        equations: the equations.
        unknowns: the coordinates that they determine.
        ties: equations that must stand in one block.
    """
    if not any(equation.involved & set(unknowns) for equation in equations):
        return Matching([], list(unknowns), list(equations))
    incidence = _incidence(equations, unknowns)
    matched = _maximum(incidence)
    surplus = [equation for row, equation in enumerate(equations) if row not in matched]
    undetermined = _undetermined(incidence, matched, len(unknowns))
    if surplus or undetermined:
        return Matching([], [unknowns[k] for k in undetermined], surplus)
    row_of = {column: row for row, column in matched.items()}
    # an equation depends on the equations that its other unknowns are matched to
    depends = [[row_of[column] for column in columns] for columns in incidence]
    index = {equation: row for row, equation in enumerate(equations)}
    for tie in ties:
        tied = [index[equation] for equation in tie]
        for row in tied:
            depends[row] += tied
    blocks: list[EquationBlock] = []
    for rows in _ordered(depends):
        solved = sorted(unknowns[matched[row]] for row in rows)
        of_block = tuple(equations[row] for row in rows)
        blocks.append(EquationBlock(of_block, tuple(solved)))
    return Matching(blocks, [], [])


def _incidence(equations: Sequence[Equation], unknowns: Sequence[int]) -> Rows:
    """For each equation, the columns of the unknowns that it can depend on."""
    column = {coordinate: k for k, coordinate in enumerate(unknowns)}
    incidence: Rows = []
    for equation in equations:
        incidence.append([column[k] for k in sorted(equation.involved) if k in column])
    return incidence


def _maximum(incidence: Rows) -> dict[int, int]:
    """A maximum matching of rows to columns (Kuhn's algorithm); earlier rows are preferred.

    A graph library would take longer to import than most programs take to run.
    """
    matched: dict[int, int] = {}
    row_of: dict[int, int] = {}
    for row in range(len(incidence)):
        _match_one_more(incidence, row, matched, row_of)
    return matched


def _match_one_more(
    incidence: Rows, start: int, matched: dict[int, int], row_of: dict[int, int]
) -> None:
    """Match a row along the shortest alternating path to a free column, if there is one."""
    reached_from: dict[int, int] = {}
    waiting = [start]
    for row in waiting:  # grows while it is walked
        for column in incidence[row]:
            if column in reached_from:
                continue
            reached_from[column] = row
            if column not in row_of:
                _flip(column, reached_from, matched, row_of)
                return
            waiting.append(row_of[column])


def _flip(
    column: int, reached_from: dict[int, int], matched: dict[int, int], row_of: dict[int, int]
) -> None:
    """Match each row along the path to the next column of the path."""
    free: int | None = column
    while free is not None:
        row = reached_from[free]
        previous = matched.get(row)
        matched[row] = free
        row_of[free] = row
        free = previous


def _undetermined(incidence: Rows, matched: dict[int, int], size: int) -> list[int]:
    """Columns without an equation, and those that could be without one in their place.

    Alternating paths connect them.
    """
    has_equation = set(matched.values())
    columns = [c for c in range(size) if c not in has_equation]
    for c in columns:  # grows while it is walked
        for row, others in enumerate(incidence):
            if c in others and row in matched and matched[row] not in columns:
                columns.append(matched[row])
    return sorted(columns)


def _ordered(depends: Rows) -> Rows:
    """The rows of each block, in an order in which each block depends on earlier ones only."""
    needs = [_reached(depends, row) for row in range(len(depends))]
    waiting: Rows = []
    for row, reached in enumerate(needs):
        block = [other for other in sorted(reached) if row in needs[other]]
        if block[0] == row:
            waiting.append(block)
    ordered: Rows = []
    done = set[int]()
    while waiting:
        block = next(block for block in waiting if needs[block[0]] <= done | set(block))
        waiting.remove(block)
        done.update(block)
        ordered.append(block)
    return ordered


def _reached(depends: Rows, start: int) -> set[int]:
    """All rows that a row depends on, directly or through others, and the row itself."""
    reached = {start}
    waiting = [start]
    for row in waiting:  # grows while it is walked
        for other in depends[row]:
            if other not in reached:
                reached.add(other)
                waiting.append(other)
    return reached
