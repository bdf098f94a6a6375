"""Four-bars from what they have to do: five poses of a body, or a straight line.

python examples/four_bars.py [--plot FILE]

On the left, a body is guided through five poses by two of the dyads of Burmester's theory. On the
right, coupler points go along a line: that of Chebyshev's lambda mechanism on half a turn of the
crank, and that of the straightest symmetric four-bar.
"""

from __future__ import annotations

import argparse

import numpy as np

from hybrid_dynamics_core.design import (
    Dyad,
    StraightLine,
    burmester,
    chebyshev_lambda,
    straight_line,
    through_poses,
)

CRANKS = (0.3, 0.9, 1.6, 2.2, 2.9)  # [rad] of a four-bar that gives the poses
LENGTHS = (1.0, 0.4, 0.9, 0.8)  # its ground, crank, coupler, rocker [m]
BODY = np.array([[0.0, 0.0], [0.9, 0.0], [0.45, 0.3], [0.0, 0.0]])  # outline [m]


def poses() -> np.ndarray:
    """Five poses of a body: x, y [m] and angle [rad] (5, 3)."""
    ground, crank, coupler, rocker = LENGTHS
    rows: list[list[float]] = []
    for angle in CRANKS:
        start = crank * np.exp(1j * angle)
        way = ground - start
        size = abs(way)
        cosine = (size**2 + coupler**2 - rocker**2) / (2.0 * coupler * size)
        turn = np.angle(way) + np.arccos(cosine)
        rows.append([start.real, start.imag, float(turn)])
    return np.array(rows)


def guided() -> list[Dyad]:
    """The dyads that guide the body, those with pivots near its corner first."""
    return sorted(burmester(poses()), key=lambda dyad: float(np.linalg.norm(dyad.moving)))


def lines() -> dict[str, StraightLine]:
    """Two straight lines on half a turn of a crank of 1 m."""
    return {"Chebyshev's lambda": chebyshev_lambda(), "the straightest": straight_line(np.pi)}


def plot(file: str) -> None:
    """Draw the five poses with two dyads, and deviations of the lines."""
    # Matplotlib is an extra.
    from hybrid_dynamics_core.drawing.page import entitled, written_page  # noqa: PLC0415
    from hybrid_dynamics_core.drawing.style import INK, QUIET, RED  # noqa: PLC0415

    about = (
        "left: a body in five poses on two dyads; right: height along the line, in lengths of it"
    )
    with written_page(file, "Four-bars from what they have to do", about, height=4.0) as figure:
        left, right = figure.subplots(1, 2)
        words = {"body": "body", "dyads": "dyads"}  # each is named once
        for x, y, angle in poses():
            turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
            outline = BODY @ turn.T + [x, y]
            left.plot(*outline.T, color=QUIET, linewidth=1.0, label=words.pop("body", None))
            for dyad in guided()[:2]:
                moving = turn @ dyad.moving + [x, y]
                ends = np.array([dyad.fixed, moving])
                left.plot(*ends.T, color=RED, marker="o", label=words.pop("dyads", None))
        left.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
        entitled(left, "five poses", 2)
        for colour, (name, line) in zip((INK, RED), lines().items(), strict=True):
            path = line.bar.coupler_path(line.point, line.crank)
            length = np.ptp(path[:, 0])
            along = 100.0 * (path[:, 0] - path[:, 0].min()) / length
            height = 100.0 * (path[:, 1] - path[:, 1].mean()) / length
            right.plot(along, height, color=colour, label=name)
        right.set(xlabel="way along the line [%]", ylabel="height [%]")
        entitled(right, "straight lines", 2)


def main() -> None:
    """Print dyads and lines; draw if asked."""
    parser = argparse.ArgumentParser(description="Four-bars from what they have to do.")
    parser.add_argument("--plot", metavar="FILE", help="write a figure (.svg or .png)")
    options = parser.parse_args()
    dyads = guided()
    print(f"dyads through five poses: {len(dyads)}")
    for dyad in dyads:
        x, y = dyad.fixed
        print(f"  fixed pivot at ({x:.3f}, {y:.3f}) m, length {dyad.length:.3f} m")
    bar = through_poses(dyads[:2], poses())
    print(f"  four-bar: {bar.ground:.3f}, {bar.crank:.3f}, {bar.coupler:.3f}, {bar.rocker:.3f} m")
    for name, line in lines().items():
        found = line.straightness()
        bars = f"ground {line.bar.ground:.3f}, coupler {line.bar.coupler:.3f} cranks"
        print(f"{name}: {bars}, {found.length:.3f} cranks straight to {100 * found.ratio:.3f} %")
    if options.plot:
        plot(options.plot)


if __name__ == "__main__":
    main()
