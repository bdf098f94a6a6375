"""Calibrating an excavator: lengths, pins and cylinder zeros from 40 points of its teeth.

python examples/calibrating_excavator.py [--plot FILE]

A laser tracker measures the teeth of the bucket with 0.05 mm of noise. The machine differs from its
file by millimetres: boom, stick, a pin of each of two loops, the zero of a cylinder and of the
slewing encoder. The machine and its errors are assumed.
"""

from __future__ import annotations

import argparse

import numpy as np

from hybrid_dynamics_core import load
from hybrid_dynamics_core.calibration import Calibration, calibrate

NOISE = 5e-5  # [m]
TRUTH = {  # the machine as it is [m], [rad]
    "boom": 5.7021,
    "stick": 2.8987,
    "loops.boom_loop.pin.boom[0]": 2.2992,
    "loops.bucket_bars.pin.bucket[0]": -0.1013,
    "joints.boom_cylinder.offset": 0.0008,
    "joints.slew.offset": -0.0012,
}
LOW = [-2.0, 0.15, 0.45, 0.25]  # of the poses: slewing [rad], cylinders [m]
HIGH = [2.0, 1.0, 1.25, 0.9]


def measured() -> dict[str, np.ndarray]:
    """Columns of the measurements."""
    true = load("excavator").with_parameters(TRUTH)
    rng = np.random.default_rng(8)
    u = rng.uniform(LOW, HIGH, (40, 4))
    place = true.forward_kinematics(true.close(u)).position
    place = place + rng.normal(0.0, NOISE, place.shape)
    columns = dict(zip(true.active, u.T, strict=True))
    return columns | dict(zip(("tool.x", "tool.y", "tool.z"), place.T, strict=True))


def residuals_before(columns: dict[str, np.ndarray]) -> np.ndarray:
    """Model of the file less measurement (N, 3) [m]."""
    robot = load("excavator")
    u = np.stack([columns[name] for name in robot.active], axis=1)
    place = robot.forward_kinematics(robot.close(u)).position
    return place - np.stack([columns[f"tool.{axis}"] for axis in "xyz"], axis=1)


def calibrated() -> tuple[Calibration, np.ndarray]:
    """The result, and the residuals with the file as it is (N, 3) [m]."""
    columns = measured()
    return calibrate("excavator", columns, list(TRUTH), sigma=NOISE), residuals_before(columns)


def plot(result: Calibration, before: np.ndarray, path: str) -> None:
    """Residuals of all points, before and after."""
    # Matplotlib is an extra.
    from hybrid_dynamics_core.drawing.page import entitled, written_page  # noqa: PLC0415
    from hybrid_dynamics_core.drawing.style import LOOPS  # noqa: PLC0415

    about = "teeth of an excavator at 40 poses, model less measurement"
    with written_page(path, "Calibrating an excavator", about, height=5.2) as figure:
        upper, lower = figure.subplots(2, 1)
        for axes, residuals, name in (
            (upper, before, "with the file"),
            (lower, result.residuals, "with the estimates"),
        ):
            for k, axis in enumerate("xyz"):
                rows = np.arange(1, len(residuals) + 1)
                axes.plot(rows, 1e3 * residuals[:, k], ".", color=LOOPS[k], label=f"along {axis}")
            axes.set(xlabel="number of pose", ylabel="residual [mm]")
            entitled(axes, name, 3)


def main() -> None:
    """Print the estimates; draw if asked."""
    parser = argparse.ArgumentParser(description="Calibrating an excavator.")
    parser.add_argument("--plot", metavar="FILE", help="write a figure (.svg or .png)")
    options = parser.parse_args()
    result, before = calibrated()
    for name, one in result.parameters.items():
        error = 1e3 * (one.value - TRUTH[name])
        print(f"{name:>32}: {one.value:+.6f}, off by {error:+.3f}e-3, +- {1e3 * one.half:.3f}e-3")
    rms = 1e3 * np.sqrt(np.mean(before**2))
    misfit = result.misfits["tool"]
    print(f"residuals: {rms:.2f} mm before, {1e3 * misfit.after:.3f} mm after")
    print(f"reduced chi-squared {result.chi2:.3f}")
    if options.plot:
        plot(result, before, options.plot)


if __name__ == "__main__":
    main()
