"""Draw every shipped robot into docs/images/robots, and write the page docs/robots.md."""

from __future__ import annotations

from itertools import groupby
from pathlib import Path
from textwrap import fill

from hybrid_dynamics_core import Robot, load, shipped_robots
from hybrid_dynamics_core.description.model import Closure
from hybrid_dynamics_core.drawing import draw, draw_modes
from hybrid_dynamics_core.drawing.options import Names
from hybrid_dynamics_core.drawing.paint.legend import loop_type
from hybrid_dynamics_core.scene.projection import find_plane
from hybrid_dynamics_core.scene.skeleton import place_skeleton

ROOT = Path(__file__).resolve().parents[1]
ROBOTS = "hybrid_dynamics_core/robots"
IMAGES = "images/robots"
LARGEST = 200_000  # bytes of a picture
MODES = ("forging_chu2020",)  # robots whose assembly modes are shown too

TITLE = "# The shipped robots"
BEFORE_COMMAND = """\
Each is one file, taken by name: `load("excavator")`. In the pictures, driven links are
vermilion, with the names of their joints. The arm is grey, and each loop has its own colour. A
robot of yours is drawn with
"""
COMMAND = """\
```bash
python -m hybrid_dynamics_core.drawing excavator excavator.svg     # or the path of your file
```
"""
AFTER_COMMAND = """\
or, from Python, with `draw(robot, path="my_robot.svg")` of `hybrid_dynamics_core.drawing`;
`draw_modes` puts its assembly modes side by side. `tools/make_pictures.py` makes this page and its
pictures.
"""


def page() -> str:
    """The text of docs/robots.md."""
    head = [TITLE, "", wrapped(BEFORE_COMMAND), "", COMMAND, wrapped(AFTER_COMMAND), ""]
    sections = [section(load(name)) for name in shipped_robots()]
    return "\n".join([*head, *sections])


def section(robot: Robot) -> str:
    """One robot: picture, what it is, where its numbers come from, active joints and loops."""
    name = robot.name
    motors = ", ".join(f"`{joint}` ({robot.joint_types[joint]})" for joint in robot.active)
    lines = [
        f"## {name}\n",
        f"![{name}: links, joints and loops]({IMAGES}/{name}.svg)\n",
        f"{wrapped(about(name))}\n",
        wrapped(f"* file: [`{name}.yaml`](../{ROBOTS}/{name}.yaml)"),
        wrapped(f"* numbers: {robot.description.source}"),
        wrapped(f"* active joints: {motors}"),
        wrapped(f"* loops: {loops(robot)}"),
    ]
    if robot.description.visuals:
        lines.append(f"\n![{name}: the visuals of its file]({IMAGES}/{name}_visuals.svg)")
    if name in MODES:
        lines.append(f"\n![{name}: its assembly modes side by side]({IMAGES}/{name}_modes.svg)")
    return "\n".join(lines) + "\n"


def wrapped(text: str) -> str:
    """Text in lines of at most 120 characters; those of a list item stand under it."""
    indent = ""
    if text.startswith("* "):
        indent = "  "
    return fill(text, 120, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)


def about(name: str) -> str:
    """The first paragraph of the comment at the head of a robot's file."""
    lines = (ROOT / ROBOTS / f"{name}.yaml").read_text(encoding="utf-8").splitlines()
    words: list[str] = []
    for line in lines:
        text = line.removeprefix("#").strip()
        if not line.startswith("#") or not text:
            break
        words.append(text)
    return " ".join(words)


def loops(robot: Robot) -> str:
    """Loops by type: names, then what closes them."""

    def kind_of(closure: Closure) -> str:
        return loop_type(robot.description, closure)

    texts = []
    for kind, members in groupby(robot.description.closures, key=kind_of):
        names = ", ".join(f"`{closure.name}`" for closure in members)
        closed_by = kind
        if "Type" not in kind:
            closed_by = f"closed by a {kind}"
        texts.append(f"{names}: {closed_by}")
    return "; ".join(texts)


def pictures(folder: Path) -> None:
    """Draw every robot. Planar ones have room for the names of all joints."""
    for name in shipped_robots():
        robot = load(name)
        names: Names = "active"
        if find_plane(place_skeleton(robot, robot.close(robot.reference))) is not None:
            names = "joints"
        files = [folder / f"{name}.svg"]
        draw(robot, path=files[0], names=names, skeleton=True)
        if robot.description.visuals:
            files.append(folder / f"{name}_visuals.svg")
            draw(robot, path=files[-1], names=names)
        if name in MODES:
            files.append(folder / f"{name}_modes.svg")
            draw_modes(robot, path=files[-1])
        for file in files:
            size = file.stat().st_size
            print(f"{file.relative_to(ROOT)}: {size} bytes")
            if size > LARGEST:
                raise SystemExit(f"{file} is larger than {LARGEST} bytes")


if __name__ == "__main__":
    folder = ROOT / "docs" / IMAGES
    folder.mkdir(parents=True, exist_ok=True)
    pictures(folder)
    (ROOT / "docs" / "robots.md").write_text(page(), encoding="utf-8")
