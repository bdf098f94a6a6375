"""Make the pictures of docs/examples.md: run examples, figure scripts and verbs that draw maps."""

from __future__ import annotations

import os
import runpy
import sys
from contextlib import chdir
from pathlib import Path

import matplotlib as mpl

from hybrid_dynamics_cli.app import app

ROOT = Path(__file__).resolve().parents[1]
IMAGES = ROOT / "docs" / "images" / "examples"
LARGEST = 250_000  # bytes of a picture
MAPS = {
    "workspace_forging.png": "workspace forging_chu2020 --draw",
    "workspace_delta.png": "workspace delta --draw",
    "margins_forging.png": "workspace forging_chu2020 --samples 1000 --over q12,q22 --draw",
    "lifting_chart_excavator.png": "capability excavator --frame bucket --share 0.87 --draw",
    "stiffness_excavator.png": (
        "stiffness excavator --drive boom_cylinder=30e6*N/m --drive stick_cylinder=30e6*N/m"
        " --wrench 0,0,-10*kN --over boom_cylinder,stick_cylinder --draw"
    ),
    "sag_excavator.svg": (
        "stiffness excavator --drive boom_cylinder=30e6*N/m --drive stick_cylinder=30e6*N/m"
        " --payload 1000 --draw"
    ),
    "modes_five_bar.svg": "branches five_bar --draw",
}


def run(script: Path, *arguments: str) -> None:
    """A script as on the command line."""
    sys.argv = [script.name, *arguments]
    sys.path.insert(0, str(script.parent))
    try:
        runpy.run_path(str(script), run_name="__main__")
    finally:
        sys.path.pop(0)


def main() -> None:
    """Write all pictures."""
    IMAGES.mkdir(parents=True, exist_ok=True)
    os.environ["SOURCE_DATE_EPOCH"] = "0"  # the same picture gives the same file
    mpl.rcParams.update({"svg.hashsalt": "hybrid_dynamics", "svg.fonttype": "none"})
    with chdir(IMAGES):
        for script in sorted((ROOT / "examples").glob("*.py")):
            run(script, "--plot", f"{script.stem}.svg")
        for script in sorted((ROOT / "examples" / "figures").glob("*_figure_*.py")):
            run(script)
        for name, words in MAPS.items():
            app([*words.split(), name, "--overwrite"], standalone_mode=False)
        for place in sorted(Path().iterdir()):
            size = place.stat().st_size
            print(f"{place}: {size} bytes")
            if size > LARGEST:
                raise SystemExit(f"{place} is larger than {LARGEST} bytes")


if __name__ == "__main__":
    main()
