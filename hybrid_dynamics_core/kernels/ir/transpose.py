"""Tables in registers: rows of states become vectors with a state per lane, and back.

A piece of a row has a power of two of numbers. As many rows as there are lanes are transposed in
squares, by exchanging halves, quarters, and so on.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from .text import Function


def pieces(size: int, width: int) -> Iterator[tuple[int, int]]:
    """(first, length) of the pieces of a row; lengths are powers of two up to the width."""
    first = 0
    while first < size:
        length = width
        while first + length > size:
            length //= 2
        yield first, length
        first += length


def load_columns(
    f: Function, table: str, size: int, piece: tuple[int, int], width: int
) -> list[str]:
    """Load a piece of `width` rows; returns a vector of `width` states for each number in it.

    Args:
        f: the function to write to.
        table: address of the first row.
        size: numbers in a row.
        piece: first number and length of the piece.
        width: number of rows.
    """
    first, length = piece
    rows: list[str] = []
    for row in range(width):
        place = f.at(table, row * size + first)
        rows.append(f.let(f"load <{length} x double>, ptr {place}, align 8"))
    joined = [_joined(f, rows[k::length], length) for k in range(length)]
    return _exchanged(f, joined, width)


def store_rows(
    f: Function, columns: Sequence[str], table: str, size: int, first: int, width: int
) -> None:
    """Store vectors of states as a piece of `width` rows.

    Args:
        f: the function to write to.
        columns: a vector for each number of the piece.
        table: address of the first row.
        size: numbers in a row.
        first: first number of the piece.
        width: number of rows.
    """
    length = len(columns)
    for k, vector in enumerate(_exchanged(f, columns, width)):
        for start in range(0, width, length):
            row = _shuffled(f, vector, vector, width, range(start, start + length))
            place = f.at(table, (start + k) * size + first)
            f.do(f"store <{length} x double> {row}, ptr {place}, align 8")


def _joined(f: Function, parts: Sequence[str], length: int) -> str:
    """Vectors of some length one after the other, as one vector."""
    while len(parts) > 1:
        pairs = zip(parts[::2], parts[1::2], strict=True)
        parts = [_shuffled(f, a, b, length, range(2 * length)) for a, b in pairs]
        length *= 2
    return parts[0]


def _exchanged(f: Function, vectors: Sequence[str], width: int) -> list[str]:
    """Transpose each square of the vectors, as many lanes as there are vectors."""
    result = list(vectors)
    step = 1
    while step < len(result):
        for k in range(len(result)):
            if not k & step:
                a, b = result[k], result[k + step]
                low: list[int] = []
                high: list[int] = []
                for lane in range(width):
                    is_second = bool(lane & step)
                    low.append(width + lane - step if is_second else lane)
                    high.append(width + lane if is_second else lane + step)
                result[k] = _shuffled(f, a, b, width, low)
                result[k + step] = _shuffled(f, a, b, width, high)
        step *= 2
    return result


def _shuffled(f: Function, a: str, b: str, length: int, lanes: Sequence[int]) -> str:
    kind = f"<{length} x double>"
    mask = ", ".join(f"i32 {lane}" for lane in lanes)
    return f.let(f"shufflevector {kind} {a}, {kind} {b}, <{len(lanes)} x i32> <{mask}>")
