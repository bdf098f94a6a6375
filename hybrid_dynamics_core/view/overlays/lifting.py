"""What the drives lift at the end effector's height, over reach."""

from __future__ import annotations

from html import escape
from typing import Final

import numpy as np
import viser

from ...capability import LiftingChart, lifting_chart
from ...errors import HybridDynamicsError
from ...ground.arrays import Array
from ...robot.robot import Robot
from ...scene.style import GRID, INK, RED
from ..gui_events import Enqueue, in_order
from ..panel_html import number, table
from ..session import ViewSession

_WIDTH: Final = 280.0  # [px] of the diagram
_HEIGHT: Final = 110.0  # [px] of the diagram
_TON: Final = 1000.0  # [kg]


class LiftingOverlay:
    """A diagram of the lifted mass over reach, at the end effector's height.

    The chart is computed when it is requested, which takes seconds.

    Args:
        server: the server of viser.
        session: the session to show.
        enqueue: receives actions of users.
    """

    def __init__(self, server: viser.ViserServer, session: ViewSession, enqueue: Enqueue) -> None:
        self.session = session
        self.chart: LiftingChart | None = None
        self.reason = ""
        with server.gui.add_folder("Lifting chart", expand_by_default=False):
            self.shown = server.gui.add_checkbox("at the tool's height", initial_value=False)
            self.html = server.gui.add_html("")
        self.shown.on_update(in_order(lambda _: enqueue("lifting", self._compute)))

    @staticmethod
    def has_use_for(robot: Robot) -> bool:
        """Whether a robot has two joints that lift, and a drive with a limit."""
        limits = np.array(list(robot.effort_ranges.values()))
        return len(robot.active) > 1 and bool(np.isfinite(limits).any())

    def _compute(self) -> None:
        if self.chart is not None or self.reason:
            return
        try:
            self.chart = lifting_chart(self.session.robot)
        except HybridDynamicsError as error:
            self.reason = str(error)

    def refresh(self) -> None:
        """Show the masses at the present height, if they are requested."""
        self.html.content = self._content() if self.shown.value else ""

    def _content(self) -> str:
        if self.chart is None:
            return table([f"<td>{escape(self.reason or 'computing')}</td>"])
        x, y, height = self.session.tool().tolist()
        reach, mass = section(self.chart, height)
        if not len(reach):
            return table([f"<td>The chart does not reach {height:.2f} m.</td>"])
        return diagram(reach, mass, float(np.hypot(x, y)), height)


def section(chart: LiftingChart, height: float) -> tuple[Array, Array]:
    """Masses of a chart at a height, in order of reach.

    They are interpolated along the lines of the chart's grid.

    Args:
        chart: the chart.
        height: [m].

    Returns:
        Reach (k,) [m] and mass (k,) [kg].
    """
    values = np.stack([chart.radius, chart.height, chart.mass], axis=-1)
    along_rows = _crossings(values[:-1], values[1:], height)
    along_columns = _crossings(values[:, :-1], values[:, 1:], height)
    points = np.concatenate([along_rows, along_columns])
    points = points[np.isfinite(points).all(axis=1)]
    order = np.argsort(points[:, 0])
    return points[order, 0], points[order, 1]


def _crossings(starts: Array, ends: Array, height: float) -> Array:
    """Reach and mass (k, 2) where lines of a grid cross a height."""
    starts = starts.reshape(-1, 3)
    ends = ends.reshape(-1, 3)
    below = starts[:, 1] - height
    above = ends[:, 1] - height
    crossing = (below < 0.0) != (above < 0.0)
    below, above = below[crossing], above[crossing]
    share = (below / (below - above))[:, None]
    points = (1.0 - share) * starts[crossing] + share * ends[crossing]
    return np.asarray(points[:, [0, 2]])


def diagram(reach: Array, mass: Array, tool: float, height: float) -> str:
    """The masses over reach as a picture, with the tool's reach in red."""
    most = max(float(mass.max()), 1e-9)
    far = max(float(reach.max()), tool)
    x = _WIDTH * reach / far
    y = _HEIGHT * (1.0 - mass / most)
    corners = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x.tolist(), y.tolist(), strict=True))
    at = _WIDTH * tool / far
    lifted = "outside the chart"
    if reach[0] <= tool <= reach[-1]:
        lifted = mass_text(float(np.interp(tool, reach, mass)))
    picture = (
        f"<svg viewBox='-4 -4 {_WIDTH + 8:.0f} {_HEIGHT + 8:.0f}' width='100%'>"
        f"<rect width='{_WIDTH}' height='{_HEIGHT}' fill='none' stroke='{GRID}'/>"
        f"<polyline points='{corners}' fill='none' stroke='{INK}' stroke-width='1.5'/>"
        f"<line x1='{at:.1f}' x2='{at:.1f}' y1='0' y2='{_HEIGHT}' stroke='{RED}'/></svg>"
    )
    rows = [
        f"<td class=q>height</td><td class=n>{height:.2f} m</td>",
        f"<td class=q>lifted at {tool:.2f} m</td><td class=n>{lifted}</td>",
        f"<td class=q>top of the picture</td><td class=n>{mass_text(most)}</td>",
    ]
    return f"<div class=hd>{picture}</div>{table(rows)}"


def mass_text(mass: float) -> str:
    """A mass in kilograms or tons."""
    if mass >= _TON:
        return f"{mass / _TON:.2f} t"
    return f"{number(mass)} kg"
