"""The pictures of certified cells in docs/certified.md: python tools/make_cells.py."""

from __future__ import annotations

import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from hybrid_dynamics_core import load
from hybrid_dynamics_core.certified.boxes.cells import CellKind
from hybrid_dynamics_core.drawing import draw_cells

IMAGES = Path(__file__).parents[1] / "docs" / "images"
DEPTH = 14
RANGES = {
    "five_bar": {"q_L": (0.2, 3.0), "q_R": (0.0, 2.8)},
    "delta": {"theta_A": (-1.2, 1.8), "theta_B": (-1.2, 1.8)},
    "forging_chu2020": {"q12": (-0.3, 0.9), "q22": (-0.3, 0.5)},
}


def main() -> None:
    """Certify the cells of each robot, draw them, and print shares and times."""
    for name, ranges in RANGES.items():
        robot = load(name)
        begin = time.perf_counter()
        cells = robot.certify_cells(ranges, depth=DEPTH)
        wall = time.perf_counter() - begin
        draw_cells(robot, cells, IMAGES / f"certified_{name}.png")
        shares = ", ".join(f"{kind.name.lower()} {cells.share(kind):.4f}" for kind in CellKind)
        print(f"{name}: {len(cells.kind)} cells in {wall:.2f} s; {shares}")


if __name__ == "__main__":
    main()
