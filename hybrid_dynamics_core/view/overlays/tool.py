"""The end effector dragged by the mouse, and the trace that it leaves."""

from __future__ import annotations

from functools import partial
from typing import Final

import numpy as np
import viser

from ...ground.arrays import Array
from ...scene.style import PURPLE
from ..bodies import RobotShape
from ..gui_events import Enqueue, in_order
from ..scene_view import rgb
from ..session import ViewSession

_MOST: Final = 4000  # points of a trace
_STEP: Final = 1e-3  # least way between points of a trace, as a share of the robot's size
_JUMP: Final = 0.2  # way at which a trace is interrupted, as a share of the robot's size
_HANDLE: Final = 0.14  # length of the arrows to drag, as a share of the robot's size


class Trace:
    """The latest places of a point, with gaps where it jumps.

    Args:
        size: size of the robot [m].
    """

    def __init__(self, size: float) -> None:
        self.step = _STEP * size
        self.jump = _JUMP * size
        self.last: Array | None = None
        self.lines: list[Array] = []

    def clear(self) -> None:
        """Forget all places."""
        self.last = None
        self.lines.clear()

    def add(self, point: Array) -> bool:
        """Add a place (3,) [m].

        Returns:
            Whether there is a new line.
        """
        if self.last is None:
            self.last = point
            return False
        way = float(np.linalg.norm(point - self.last))
        if way < self.step:
            return False
        is_line = way < self.jump
        if is_line:
            self.lines.append(np.stack([self.last, point]))
            del self.lines[:-_MOST]
        self.last = point
        return is_line

    @property
    def segments(self) -> Array:
        """Lines (k, 2, 3) between neighbouring places [m]."""
        if not self.lines:
            return np.zeros((0, 2, 3))
        return np.stack(self.lines)


class ToolOverlay:
    """Arrows that drag the end effector, and its trace.

    Args:
        server: the server of viser.
        session: the session to show and control.
        shape: geometry of the robot.
        enqueue: receives actions of users.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        session: ViewSession,
        shape: RobotShape,
        enqueue: Enqueue,
    ) -> None:
        self.scene = server.scene
        self.session = session
        self.enqueue = enqueue
        self.dragging = False
        self.trace = Trace(shape.size)
        self.line: viser.LineSegmentsHandle | None = None
        self.thickness = 0.5 * shape.unit
        with server.gui.add_folder("Tool", expand_by_default=False):
            self.dragged = server.gui.add_checkbox("drag with the mouse", initial_value=False)
            self.traced = server.gui.add_checkbox("trace", initial_value=False)
        self.handle = self.scene.add_transform_controls(
            "/tool",
            scale=_HANDLE * shape.size,
            disable_rotations=True,
            disable_sliders=True,
            depth_test=False,
            visible=False,
        )
        self._listen()

    def _listen(self) -> None:
        self.dragged.on_update(in_order(lambda _: self.enqueue("drag", self._switch_handle)))
        self.traced.on_update(in_order(lambda _: self.enqueue("trace", self._switch_trace)))

        @self.handle.on_update
        async def _(event: viser.TransformControlsEvent) -> None:
            self.dragging = event.phase != "end"
            target = np.array(self.handle.position)
            self.enqueue("tool", partial(self._reach, target))

    def _reach(self, target: Array) -> None:
        self.session.reach(target)

    def _switch_handle(self) -> None:
        self.handle.visible = bool(self.dragged.value)

    def _switch_trace(self) -> None:
        self.trace.clear()
        self._draw()

    def refresh(self) -> None:
        """Show the arrows at the end effector, and its trace."""
        if not (self.handle.visible or self.traced.value):
            return
        position = self.session.tool()
        if not self.dragging:
            self.handle.position = position
        if self.traced.value and self.trace.add(position):
            self._draw()

    def _draw(self) -> None:
        if self.line is not None:
            self.line.remove()
            self.line = None
        if self.trace.lines:
            self.line = self.scene.add_line_segments(
                "/trace",
                self.trace.segments,
                rgb(PURPLE),
                thickness=self.thickness,
            )
