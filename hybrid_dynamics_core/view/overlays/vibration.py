"""Natural modes of an elastic robot: a list of frequencies, and one that the robot swings in."""

from __future__ import annotations

from html import escape
from typing import Final

import numpy as np
import viser

from ...errors import HybridDynamicsError
from ...ground.arrays import Array
from ...robot.robot import Robot
from ...scene.displaced import Displacements, displaced
from ...scene.skeleton import place_skeleton
from ...stiffness import Modes
from ..gui_events import Enqueue, in_order, set_value
from ..panel_html import number, table
from ..scene_view import SceneView
from ..session import ViewSession

_MOST: Final = 8  # modes in the list
_SWING: Final = 0.06  # of the robot's size, by which its farthest place swings to a side
_PERIOD: Final = 2.0  # [s] of a swing, whatever its frequency
_STILL: Final = "none"


class VibrationOverlay:
    """Natural frequencies at the present state; the robot swings slowly in the chosen mode.

    Args:
        server: the server of viser.
        session: the session to show.
        view: the scene of the robot.
        enqueue: receives actions of users.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        session: ViewSession,
        view: SceneView,
        enqueue: Enqueue,
    ) -> None:
        self.session = session
        self.view = view
        self.modes: Modes | None = None
        self.reason = ""
        self.phase = 0.0
        names = [_STILL, *(str(k + 1) for k in range(_MOST))]
        with server.gui.add_folder("Natural modes", expand_by_default=False):
            self.chosen = server.gui.add_dropdown("swing in", names, initial_value=_STILL)
            self.html = server.gui.add_html("")
        self.chosen.on_update(in_order(lambda _: enqueue("vibration", lambda: None)))

    @staticmethod
    def has_use_for(robot: Robot) -> bool:
        """Whether something of a robot is elastic."""
        return bool(robot.description.stiffness)

    @property
    def moving(self) -> bool:
        """Whether the robot swings."""
        return self._shape() is not None

    def refresh(self) -> None:
        """Find the modes of the present state, and list them."""
        self.modes = None
        try:
            self.modes = self.session.natural_modes()
            self.html.content = modes_html(self.modes)
        except HybridDynamicsError as error:
            self.html.content = table([f"<td>{escape(str(error))}</td>"])
            set_value(self.chosen, _STILL)

    def tick(self, elapsed: float) -> None:
        """Swing on.

        Args:
            elapsed: real time since the last tick [s].
        """
        shape = self._shape()
        if shape is None:
            return
        turns = self.phase + elapsed / _PERIOD
        self.phase = turns % 1.0
        state = self.session.state
        moves = Displacements(place_skeleton(self.session.robot, state), shape)
        shifts = np.linalg.norm(moves.of_points(), axis=1)
        largest = float(shifts.max(initial=0.0))
        if not largest:
            return
        side = float(np.sin(2.0 * np.pi * self.phase))
        scale = side * _SWING * self.view.shape.size / largest
        poses = self.view.shape.poses(state)
        self.view.show_poses(displaced(poses, shape, scale))

    def _shape(self) -> dict[str, Array] | None:
        """Displacement (6,) of each link in the chosen mode; None without one."""
        if self.chosen.value == _STILL or self.modes is None:
            return None
        k = int(self.chosen.value) - 1
        if k >= len(self.modes.frequencies):
            return None
        return {name: shapes[k] for name, shapes in self.modes.links.items()}


def modes_html(modes: Modes) -> str:
    """A row for each of the lowest modes: frequency, and the element with most energy."""
    rows: list[str] = []
    shares = modes.energy_by_element
    for k, frequency in enumerate(modes.frequencies[:_MOST].tolist()):
        here = {name: float(share[k]) for name, share in shares.items()}
        most = max(here, key=here.__getitem__)
        rows.append(
            f"<td>{k + 1}</td><td class=n>{number(frequency)} Hz</td>"
            f"<td class=q>{escape(most)}</td>"
        )
    return table(rows)
