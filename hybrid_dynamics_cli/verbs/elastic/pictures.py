"""Pictures of elastic robots; Matplotlib is an extra, so it is imported when used."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from hybrid_dynamics_core import ClosedState, Robot
from hybrid_dynamics_core.ground.arrays import Array
from hybrid_dynamics_core.stiffness import StiffnessMap


def draw_links(
    machine: Robot,
    state: ClosedState,
    links: Mapping[str, Array],
    title: str,
    place: Path,
) -> None:
    """Draw a robot with displaced links."""
    from hybrid_dynamics_core.drawing import draw_displaced  # noqa: PLC0415

    draw_displaced(machine, state, links, place, title=title)


def draw_map(machine: Robot, chart: StiffnessMap, place: Path) -> None:
    """Draw a map of deflections."""
    from hybrid_dynamics_core.drawing import draw_stiffness  # noqa: PLC0415

    draw_stiffness(machine, chart, place)
