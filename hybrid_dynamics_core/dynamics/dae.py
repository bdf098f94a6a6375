"""The equations of motion of the spanning tree with its loops as constraints.

For teaching and as an oracle.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..ground.arrays import Array


@dataclass(frozen=True, eq=False)
class SpanningTerms:
    """Terms of  M s'' + C s' + g + extra + J^T lambda = [tau; 0],  J s'' + bias = 0.

    The DAE of Chu (2020), Eq. 10, with J the J_s of Eq. 16, in the order of `robot.coordinates`. A
    batch has a leading N.

    Attributes:
        M: (n_s, n_s) mass matrix of the open tree, rotors and payloads included.
        C: (n_s, n_s) matrix of its Christoffel symbols: M' - 2 C is skew.
        g: (n_s,) gravity.
        extra: (n_s,) friction, springs and applied wrenches.
        J: (n_z, n_s) Jacobian of the loop equations that are solved; lengths are divided by the
            loop's length. A parallelogram has two equations between angles. Of an over-determined
            loop they are A^T times all of its equations, where A is their Jacobian.
        bias: (n_z,) J' s' [1/s^2].
        multipliers: (n_z,) lambda of the rows [N m]. `robot.reactions` converts them to wrenches at
            the pins.
        loops: the loop of each row.
    """

    M: Array
    C: Array
    g: Array
    extra: Array
    J: Array
    bias: Array
    multipliers: Array
    loops: tuple[str, ...]
