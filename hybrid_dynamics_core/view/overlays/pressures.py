"""Pressures and flows of the cylinders, as numbers."""

from __future__ import annotations

from html import escape
from typing import Final

import viser

from ...errors import HybridDynamicsError
from ...scene.style import RED
from ..panel_html import number, table
from ..session import ViewSession

_BAR: Final = 1e5  # [Pa]
_LITRES: Final = 6e4  # [l/min] in a m^3/s
_HEAD: Final = (
    "<td></td><td class='n q'>cap bar</td><td class='n q'>rod bar</td><td class='n q'>l/min</td>"
)


class PressuresOverlay:
    """A table of the chambers' pressures and the pump's flow.

    Args:
        server: the server of viser.
        session: the session to show.
    """

    def __init__(self, server: viser.ViserServer, session: ViewSession) -> None:
        self.session = session
        with server.gui.add_folder("Pressures", expand_by_default=False):
            self.html = server.gui.add_html("")

    def refresh(self) -> None:
        """Show the pressures of the present state."""
        try:
            self.html.content = pressures_html(self.session)
        except HybridDynamicsError as error:
            self.html.content = table([f"<td>{escape(str(error))}</td>"])


def pressures_html(session: ViewSession) -> str:
    """A row for each cylinder, red beyond its supply pressure."""
    rows = [_HEAD]
    for name, cylinder in session.hydraulics().items():
        style = f" style='color:{RED}'" if cylinder.overloaded else ""
        numbers = (
            float(cylinder.cap_pressure) / _BAR,
            float(cylinder.rod_pressure) / _BAR,
            float(cylinder.demand) * _LITRES,
        )
        cells = "".join(f"<td class=n{style}>{number(value)}</td>" for value in numbers)
        rows.append(f"<td>{escape(name)}</td>{cells}")
    return table(rows)
