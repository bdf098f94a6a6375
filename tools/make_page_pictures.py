"""Draw what pages of docs show of the robots written in them, and the layers of the library, into docs/images.

docs/own_robot.md: every robot on the page, and one of them with its dimensions.
docs/architecture.md: the layers as import-linter holds them (pyproject.toml), each with what its
own docstring says. tests/docs/test_pictures.py compares.
"""

from __future__ import annotations

import ast
import re
import tempfile
import tomllib
from collections.abc import Mapping
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


def robots_of_the_page(folder: Path) -> dict[str, Robot]:
    """Write the page's files into a folder; its robots by name, in order."""
    robots = {}
    for file, text in FILE.findall(PAGE.read_text(encoding="utf-8")):
        name = re.search(r"^name: (\w+)$", text, re.MULTILINE)
        path = folder / (file or f"{name[1]}.yaml" if name else file)
        path.write_text(text, encoding="utf-8")
        if path.suffix == ".yaml":
            robots[path.stem] = load(path)
    return robots


def with_dimensions(robot: Robot) -> Figure:
    """The crank and cylinder of the page with the lengths that its file holds."""
    figure = draw(robot, names="none", title="The drawing")
    axes: Axes = figure.axes[0]
    state = robot.close(robot.reference)
    places = {
        link: robot.forward_kinematics(state, link).position[[0, 2]]
        for link in ("crank", "barrel", "rod")
    }
    tip = robot.forward_kinematics(state).position[[0, 2]]
    pivot, foot, pin = places["crank"], places["barrel"], places["rod"]
    stroke = float(robot.reference[0])
    length = float(np.linalg.norm(pin - foot)) - stroke
    dimension(axes, pivot, pin, 0.12, f"{np.linalg.norm(pin - pivot):.1f} m")
    dimension(axes, pivot, tip, 0.22, f"{np.linalg.norm(tip - pivot):.1f} m")
    dimension(axes, foot, pin, -0.14, f"{length:.1f} m + stroke")
    dimension(axes, np.array([pivot[0], foot[1]]), foot, -0.12, f"{foot[0] - pivot[0]:.1f} m")
    dimension(axes, np.array([pivot[0], foot[1]]), pivot, 0.12, f"{pivot[1] - foot[1]:.1f} m")
    shape = np.ptp(axes.get_xlim()) / np.ptp(axes.get_ylim())
    low, high = foot[1] - 0.18, pivot[1] + 0.3
    axes.set(ylim=(low, high), xlim=(pivot[0] - 0.25, pivot[0] - 0.25 + shape * (high - low)))
    return figure


def dimension(axes: Axes, start: np.ndarray, end: np.ndarray, away: float, text: str) -> None:
    """A dimension line beside the way from start to end, `away` [m] to its left."""
    along = (end - start) / np.linalg.norm(end - start)
    left = np.array([-along[1], along[0]])
    a, b = start + away * left, end + away * left
    for point, foot in ((start, a), (end, b)):
        axes.plot(
            *np.transpose([point, foot + 0.02 * np.sign(away) * left]), color=INK, linewidth=0.6
        )
    axes.annotate(
        "",
        a,
        b,
        arrowprops={
            "arrowstyle": "<->",
            "color": INK,
            "linewidth": 0.9,
            "shrinkA": 0,
            "shrinkB": 0,
        },
    )
    angle = (np.degrees(np.arctan2(along[1], along[0])) + 90.0) % 180.0 - 90.0
    middle = (a + b) / 2
    box = {"facecolor": "white", "edgecolor": "none", "pad": 1.5}
    axes.text(
        *middle, text, rotation=angle, ha="center", va="center", fontsize=9, color=INK, bbox=box
    )


def layers() -> list[list[str]]:
    """The layers of the library from the top, as import-linter holds them."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"][
        "importlinter"
    ]["contracts"]
    core = "hybrid_dynamics_core"
    (order,) = (c["layers"] for c in contracts if c.get("containers") == [core])
    return [[f"{core}.{name.strip()}" for name in layer.split("|")] for layer in order]


def about(module: str) -> str:
    """The first sentence of a module's docstring."""
    path = ROOT.joinpath(*module.split("."))
    path = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
    return re.split(r"(?<=\w)[.:;] |\.$|\n\n", " ".join(text.split()), maxsplit=1)[0].replace(
        "`", ""
    )


def layers_picture() -> str:
    """The layers as an SVG: one row a module, one band a layer, the top ones import the lower ones."""
    top = [["hybrid_dynamics_cli", "hybrid_dynamics_ros"]]
    row, gap, left, width = 21, 7, 8, 860
    y, parts = 46, []
    for index, layer in enumerate([*top, *layers()]):
        height = row * len(layer) + 6
        fill = "#fdebd8" if index == 0 else ("#e6eef6" if index % 2 else "#f3f6fa")
        parts.append(
            f'<rect x="{left}" y="{y}" width="{width - 2 * left}" height="{height}" rx="4"'
            f' fill="{fill}"/>'
        )
        for k, module in enumerate(layer):
            line = y + 18 + row * k
            name = module.removeprefix("hybrid_dynamics_core.")
            parts.append(f'<text x="{left + 10}" y="{line}" class="name">{escape(name)}</text>')
            parts.append(f'<text x="{left + 178}" y="{line}">{escape(about(module))}</text>')
        y += height + gap
    head = "Each band may import from the bands below it, never from those above."
    style = (
        "text{font:12.5px"
        " system-ui,sans-serif;fill:#1e293b}.name{font-weight:600}.head{fill:#475569}"
    )
    body = "\n".join(parts)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {y + 6}"'
        f' role="img">\n<title>Layers</title>\n<style>{style}</style>\n<rect width="{width}"'
        f' height="{y + 6}" fill="#ffffff"/>\n<text x="{left}" y="28"'
        f' class="head">{head}</text>\n{body}\n</svg>\n'
    )


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
