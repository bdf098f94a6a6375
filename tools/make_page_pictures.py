"""Draw what pages of docs show, into docs/images.

docs/own_robot.md: every robot on the page, and one of them with its dimensions.
docs/architecture.md: the layers as import-linter holds them (pyproject.toml), each with the first
sentence of its docstring. tests/docs/test_pictures.py compares.
"""

from __future__ import annotations

import ast
import re
import tempfile
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.sax.saxutils import escape

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hybrid_dynamics_core import Robot, load
from hybrid_dynamics_core.drawing import draw
from hybrid_dynamics_core.drawing.figure import save
from tools.mode_senses import senses_picture

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "own_robot.md"
ROBOTS = ROOT / "docs" / "images" / "own_robot"
LAYERS = ROOT / "docs" / "images" / "layers.svg"
SENSES = ROOT / "docs" / "images" / "assembly_modes.svg"
FILE = re.compile(
    r"(?:<!-- file: ([\w.]+) -->\n)?```(?:yaml|xml)\n(.*?)^```$", re.DOTALL | re.MULTILINE
)
INK = "#334155"
ARROW = {"arrowstyle": "<->", "color": INK, "linewidth": 0.9, "shrinkA": 0, "shrinkB": 0}
CORE = "hybrid_dynamics_core"
TOP = ("hybrid_dynamics_cli", "hybrid_dynamics_ros")  # above the core
# Of the picture of the layers, in pixels.
ROW = 21
GAP = 7
MARGIN = 8
WIDTH = 860
TOP_COLOUR = "#fdebd8"
COLOURS = ("#f3f6fa", "#e6eef6")  # of the other layers, by turns
STYLE = (
    "text{font:12.5px system-ui,sans-serif;fill:#1e293b}.name{font-weight:600}.head{fill:#475569}"
)


def robots_of_the_page(folder: Path) -> dict[str, Robot]:
    """Write the page's files into a folder; its robots by name, in order."""
    robots = {}
    for file, text in FILE.findall(PAGE.read_text(encoding="utf-8")):
        path = folder / (file or _file_name(text))
        path.write_text(text, encoding="utf-8")
        if path.suffix == ".yaml":
            robots[path.stem] = load(path)
    return robots


def _file_name(text: str) -> str:
    """A file's name from that of its robot; empty where it has none."""
    name = re.search(r"^name: (\w+)$", text, re.MULTILINE)
    if name is None:
        return ""
    return f"{name[1]}.yaml"


def with_dimensions(robot: Robot) -> Figure:
    """The crank and cylinder of the page with the lengths that its file holds."""
    figure = draw(robot, names="none", title="The drawing")
    axes: Axes = figure.axes[0]
    state = robot.close(robot.reference)
    pivot = robot.forward_kinematics(state, "crank").position[[0, 2]]
    foot = robot.forward_kinematics(state, "barrel").position[[0, 2]]
    pin = robot.forward_kinematics(state, "rod").position[[0, 2]]
    tip = robot.forward_kinematics(state).position[[0, 2]]
    below = np.array([pivot[0], foot[1]])
    stroke = float(robot.reference[0])
    length = float(np.linalg.norm(pin - foot)) - stroke
    dimension(axes, pivot, pin, 0.12, f"{np.linalg.norm(pin - pivot):.1f} m")
    dimension(axes, pivot, tip, 0.22, f"{np.linalg.norm(tip - pivot):.1f} m")
    dimension(axes, foot, pin, -0.14, f"{length:.1f} m + stroke")
    dimension(axes, below, foot, -0.12, f"{foot[0] - pivot[0]:.1f} m")
    dimension(axes, below, pivot, 0.12, f"{pivot[1] - foot[1]:.1f} m")
    shape = np.ptp(axes.get_xlim()) / np.ptp(axes.get_ylim())
    low = foot[1] - 0.18
    high = pivot[1] + 0.3
    start = pivot[0] - 0.25
    axes.set(ylim=(low, high), xlim=(start, start + shape * (high - low)))
    return figure


def dimension(axes: Axes, start: np.ndarray, end: np.ndarray, away: float, text: str) -> None:
    """A dimension line beside the way from start to end.

    Args:
        axes: to draw on.
        start: (2,) [m].
        end: (2,) [m].
        away: distance from the way, to its left [m].
        text: the dimension.
    """
    along = (end - start) / np.linalg.norm(end - start)
    normal = np.array([-along[1], along[0]])
    a = start + away * normal
    b = end + away * normal
    overhang = 0.02 * np.sign(away) * normal
    for point, foot in ((start, a), (end, b)):
        axes.plot(*np.transpose([point, foot + overhang]), color=INK, linewidth=0.6)
    axes.annotate("", a, b, arrowprops=ARROW)
    angle = (np.degrees(np.arctan2(along[1], along[0])) + 90.0) % 180.0 - 90.0
    label = axes.text(*(a + b) / 2, text, rotation=angle, ha="center", va="center")
    label.set(fontsize=9, color=INK, bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.5})


def layers() -> list[list[str]]:
    """The layers of the library from the top, as import-linter holds them."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = settings["tool"]["importlinter"]["contracts"]
    (order,) = (c["layers"] for c in contracts if c.get("containers") == [CORE])
    return [[f"{CORE}.{name.strip()}" for name in layer.split("|")] for layer in order]


def about(module: str) -> str:
    """The first sentence of a module's docstring."""
    path = ROOT.joinpath(*module.split(".")).with_suffix(".py")
    if not path.exists():
        path = path.with_suffix("") / "__init__.py"
    text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
    sentence = re.split(r"(?<=\w)[.:;] |\.$|\n\n", " ".join(text.split()), maxsplit=1)[0]
    return sentence.replace("`", "")


def layers_picture() -> str:
    """The layers as an SVG: one row a module, one band a layer, the top ones import the lower."""
    y = 46
    bands = []
    for index, layer in enumerate([list(TOP), *layers()]):
        colour = TOP_COLOUR
        if index:
            colour = COLOURS[index % 2]
        height = ROW * len(layer) + 6
        bands += _band(layer, y, height, colour)
        y += height + GAP
    head = "Each band may import from the bands below it, never from those above."
    body = "\n".join(bands)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {y + 6}"'
        f' role="img">\n<title>Layers</title>\n<style>{STYLE}</style>\n<rect width="{WIDTH}"'
        f' height="{y + 6}" fill="#ffffff"/>\n<text x="{MARGIN}" y="28"'
        f' class="head">{head}</text>\n{body}\n</svg>\n'
    )


def _band(layer: Sequence[str], y: int, height: int, colour: str) -> list[str]:
    """The elements of one layer, from a height on."""
    width = WIDTH - 2 * MARGIN
    elements = [
        f'<rect x="{MARGIN}" y="{y}" width="{width}" height="{height}" rx="4" fill="{colour}"/>'
    ]
    for k, module in enumerate(layer):
        line = y + 18 + ROW * k
        name = escape(module.removeprefix(f"{CORE}."))
        elements.append(f'<text x="{MARGIN + 10}" y="{line}" class="name">{name}</text>')
        elements.append(f'<text x="{MARGIN + 178}" y="{line}">{escape(about(module))}</text>')
    return elements


def pictures(robots: Mapping[str, Robot]) -> dict[str, Figure]:
    """The figures of docs/own_robot.md by file name."""
    figures = {f"{name}.svg": draw(robot, names="all") for name, robot in robots.items()}
    return {
        **figures,
        "crank_and_cylinder_drawing.svg": with_dimensions(robots["crank_and_cylinder"]),
    }


if __name__ == "__main__":
    ROBOTS.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        for name, figure in pictures(robots_of_the_page(Path(folder))).items():
            save(figure, ROBOTS / name)
            print(f"{name}: {(ROBOTS / name).stat().st_size} bytes")
    save(senses_picture(), SENSES)
    LAYERS.write_text(layers_picture(), encoding="utf-8")
