"""Forces in the pins of loops, as numbers and arrows."""

from __future__ import annotations

from html import escape
from typing import Final

import numpy as np
import viser

from ...dynamics.reactions import PinReaction
from ...errors import HybridDynamicsError
from ...scene.style import PURPLE
from .. import meshes
from ..bodies import RobotShape
from ..camera import Camera
from ..gui_events import Enqueue, in_order
from ..panel_html import breakable, number, table
from ..ranges import round_above
from ..scene_view import node, rgb, wxyz
from ..session import ViewSession

_LONGEST: Final = 0.25  # length of the longest arrow, as a share of the robot's size
_ASIDE: Final = 9.0  # offset of an arrow toward the camera, so that no body hides it
_FAINT: Final = 0.02  # share of the longest arrow below which there is none


class PinsOverlay:
    """A table of pin forces, and an arrow on the first link of each pin.

    The longest arrow is a round force above the largest one so far.

    Args:
        server: the server of viser.
        session: the session to show.
        shape: geometry of the robot.
        camera: camera of new browsers; arrows stand on its side of the robot.
        enqueue: receives actions of users.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        session: ViewSession,
        shape: RobotShape,
        camera: Camera,
        enqueue: Enqueue,
    ) -> None:
        self.scene = server.scene
        self.session = session
        self.size = shape.size
        toward = camera.position - camera.look_at
        self.aside = _ASIDE * shape.unit * toward / np.linalg.norm(toward)
        self.full = 0.0  # [N] force of the longest arrow
        self.arrows: dict[str, viser.MeshHandle] = {}
        with server.gui.add_folder("Pins", expand_by_default=False):
            self.shown = server.gui.add_checkbox("forces", initial_value=False)
            self.html = server.gui.add_html("")
        self.shown.on_update(in_order(lambda _: enqueue("pins", lambda: None)))

    def refresh(self) -> None:
        """Show the forces of the present state, if they are requested."""
        if not self.shown.value:
            self._hide()
            return
        try:
            pins = self.session.pins()
        except HybridDynamicsError as error:
            self._hide()
            self.html.content = table([f"<td>{escape(str(error))}</td>"])
            return
        sizes = {name: float(np.linalg.norm(pin.force)) for name, pin in pins.items()}
        largest = np.nanmax([*sizes.values(), 0.0])
        if largest > self.full:
            self.full = round_above(float(largest))
        for name, pin in pins.items():
            self._point(name, pin, sizes[name])
        self.html.content = pins_html(sizes, self.full)

    def _hide(self) -> None:
        self.html.content = ""
        for arrow in self.arrows.values():
            arrow.visible = False

    def _point(self, name: str, pin: PinReaction, size: float) -> None:
        """Turn and scale the arrow of a pin."""
        share = size / self.full if self.full else 0.0
        arrow = self.arrows.get(name)
        if arrow is None:
            arrow = self._add(name)
            self.arrows[name] = arrow
        arrow.visible = share > _FAINT  # not for undetermined forces
        if not arrow.visible:
            return
        arrow.position = pin.place + self.aside
        arrow.wxyz = wxyz(meshes.frame_along(pin.force / size))
        arrow.scale = self._scale(share)

    def _scale(self, share: float) -> tuple[float, float, float]:
        width = self.size * min(1.0, 0.35 + 0.65 * share)
        return width, width, share * _LONGEST * self.size

    def _add(self, name: str) -> viser.MeshHandle:
        mesh = meshes.arrow(0.008)
        return self.scene.add_mesh_simple(
            node("pins", name),
            mesh.vertices,
            mesh.faces,
            color=rgb(PURPLE),
            cast_shadow=False,
        )


def pins_html(sizes: dict[str, float], full: float) -> str:
    """A row for each pin, and the force of the longest arrow."""
    rows = []
    for name, size in sizes.items():
        value = "undetermined" if np.isnan(size) else f"{number(size)} N"
        rows.append(f"<td>{breakable(name)}</td><td class=n>{value}</td>")
    note = f"<div class='hd q'>Longest arrow: {number(full)} N, on the first link of the pin.</div>"
    return table(rows) + note
