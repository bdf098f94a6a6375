"""Take the pictures of the 3D view for docs/view.md.

python -m tools.view_screenshot [FOLDER]

Needs viser, playwright and a Chromium (tools/browser.py). FOLDER is docs/images unless given.
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from PIL import Image  # comes with Matplotlib

from hybrid_dynamics_core import Robot, load
from hybrid_dynamics_core.control import JointTrajectory
from hybrid_dynamics_core.view import open_viewer
from hybrid_dynamics_core.view.motion import Motion, motion_of
from hybrid_dynamics_core.view.viewer import Viewer
from tools.browser import NoBrowserError, opened_page

ROOT = Path(__file__).resolve().parents[1]
WIDTH = 1280  # pixels of the window
HEIGHT = 800
SETTLE = 4000  # [ms] until the light and the shadows are there
PATIENCE = 180_000  # [ms] rendering in software takes its time
COLOURS = 256  # a third of the bytes, and no difference to the eye
LARGEST = 200_000  # bytes of a picture


@contextmanager
def running(robot: Robot, motion: Motion | None = None) -> Iterator[Viewer]:
    """A viewer that works in a thread."""
    with open_viewer(robot, motion, port=0) as viewer:
        work = threading.Thread(target=viewer.run)
        work.start()
        try:
            yield viewer
        finally:
            viewer.end()
            work.join()


def take(
    robot: Robot, path: Path, change: Callable[[Viewer], None], motion: Motion | None = None
) -> None:
    """Take one picture of the page.

    Args:
        robot: what the viewer shows.
        path: of the picture.
        change: what is done before.
        motion: to be played back.
    """
    with running(robot, motion) as viewer, opened_page(viewer.url, WIDTH, HEIGHT) as page:
        viewer.ask("picture", lambda: change(viewer))
        page.wait_for_timeout(SETTLE)
        page.screenshot(path=path, timeout=PATIENCE)
    Image.open(path).convert("RGB").quantize(COLOURS, kmeans=2).save(path, optimize=True)
    print(f"{path}: {path.stat().st_size} bytes")
    if path.stat().st_size > LARGEST:
        raise SystemExit(f"{path} is larger than {LARGEST} bytes")


def turned(viewer: Viewer) -> None:
    """A pose in which the efforts differ, with a load."""
    viewer.session.move(np.add(viewer.session.state.u, [0.35, 0.06, 0.02, 0.4]))
    viewer.session.payload = 40.0


def raised(viewer: Viewer) -> None:
    """All legs a little longer."""
    viewer.session.move(viewer.session.state.u + 0.02)


def dig(robot: Robot) -> Motion:
    """A second of digging."""
    end = np.add(robot.reference, [0.5, 0.15, -0.2, 0.2])
    return motion_of(robot, JointTrajectory.between(robot.reference, end, 2.0), "dig.csv")


def half_way(viewer: Viewer) -> None:
    """The middle of the motion."""
    if viewer.panel.playback is not None:
        viewer.panel.playback.seek(0.8)


def main(folder: Path) -> None:
    """Take all pictures."""
    take(load("forging_chu2020"), folder / "view_forging.png", turned)
    excavator = load("excavator")
    take(excavator, folder / "view_excavator.png", half_way, dig(excavator))
    take(load("gough"), folder / "view_gough.png", raised)


if __name__ == "__main__":
    if len(sys.argv) > 2:
        sys.exit(__doc__)
    folder = ROOT / "docs" / "images"
    if len(sys.argv) == 2:
        folder = Path(sys.argv[1])
    try:
        main(folder)
    except NoBrowserError as problem:
        sys.exit(str(problem))
