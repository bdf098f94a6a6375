"""A viewer in the browser: sliders, live closure, efforts, playback.

>>> from hybrid_dynamics_core import load
>>> from hybrid_dynamics_core.view import view
>>> view(load("forging_chu2020"))  # until Ctrl-C

viser is needed only here: the extra `view`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..errors import MissingPackageError
from ..robot.taken import AnyRobot, robot_of

if TYPE_CHECKING:
    from .motion import Motion
    from .viewer import Viewer

__all__ = ["open_viewer", "view"]


def open_viewer(
    robot: AnyRobot,
    motion: Motion | None = None,
    *,
    host: str = "localhost",
    port: int = 8080,
    skeleton: bool = False,
) -> Viewer:
    """Open a viewer at host:port, for use in a `with`; `run` serves it.

    Args:
        robot: the robot to show, or its description.
        motion: motion for playback, from `motion_of` or a recording.
        host: host to listen at.
        port: port to listen at; 0: any free port.
        skeleton: whether to show bars and plates between joints at first, in place of visuals.

    Returns:
        The viewer.

    Raises:
        InputError: the port is not available.
        MissingPackageError: viser is not installed.
    """
    try:
        import viser  # noqa: F401, PLC0415  an extra
    except ImportError as error:
        raise MissingPackageError("viser", "view", "3D views") from error
    from .viewer import Viewer  # noqa: PLC0415  needs viser

    return Viewer(robot_of(robot), motion, host, port, skeleton)


def view(
    robot: AnyRobot,
    motion: Motion | None = None,
    *,
    host: str = "localhost",
    port: int = 8080,
    skeleton: bool = False,
) -> None:
    """Show a robot in the browser until KeyboardInterrupt.

    Args:
        robot: the robot to show, or its description.
        motion: motion for playback, from `motion_of` or a recording.
        host: host to listen at.
        port: port to listen at; 0: any free port.
        skeleton: whether to show bars and plates between joints at first, in place of visuals.

    Raises:
        InputError: the port is not available.
        MissingPackageError: viser is not installed.
    """
    import webbrowser  # noqa: PLC0415  slow to import

    with open_viewer(robot, motion, host=host, port=port, skeleton=skeleton) as viewer:
        webbrowser.open(viewer.url)
        try:
            viewer.run()
        except KeyboardInterrupt:
            return
