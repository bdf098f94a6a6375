"""Closed configurations from which samples are followed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...closed_state.state import ClosedState
from ...ground.arrays import Array


class Anchors(NamedTuple):
    """N closed configurations.

    Attributes:
        s: all coordinates (N, n_s) [rad, m].
        R: (N, n_s, n).
        signs: of their branches (N, n_b).
    """

    s: Array
    R: Array
    signs: Array

    @classmethod
    def of(cls, states: Sequence[ClosedState]) -> Anchors:
        """Those of single states."""
        fields = zip(*[(state.s, state.R, state.signs) for state in states], strict=True)
        return cls(*[np.array(field) for field in fields])

    @classmethod
    def joined(cls, parts: Sequence[Anchors]) -> Anchors:
        """All in one."""
        return cls(*[np.concatenate(fields) for fields in zip(*parts, strict=True)])

    def as_near(self, state: ClosedState) -> ClosedState:
        """The batch that `close(near=)` follows from; `state` is any state of the robot."""
        signs = self.signs
        if (signs == signs[0]).all():
            signs = signs[0]
        return replace(state, s=self.s, R=self.R, signs=signs)
