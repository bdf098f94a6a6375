"""A digging cycle of an excavator: pressure, flow and power of its three cylinders.

python examples/excavator_digging.py [--plot FILE]

The bucket reaches out, digs against the soil, lifts the load while the house slews, dumps it and
comes back. While it digs, the soil pulls at the teeth and the bucket fills. Efforts are linear in
the mass of the load: the filling bucket needs two evaluations, empty and full. Soil, load and times
are assumed, typical of a machine of 20 t.
"""

from __future__ import annotations

import argparse

import numpy as np

from hybrid_dynamics_core import Payload, load
from hybrid_dynamics_core.control import JointTrajectory

EARTH = Payload(1100.0, com=[-0.6, 0.35, 0.0])  # in the full bucket, from the teeth [kg], [m]
# The soil holds the teeth while they dig: outward and up [N].
SOIL = np.array([24e3, 0.0, 12e3])
TIMES = [0.0, 2.5, 5.5, 8.0, 10.0, 13.0]  # [s] at the points below
POINTS = [  # slewing q1 [rad], cylinders of boom, stick and bucket [m]
    [0.0, 0.70, 0.70, 0.60],  # ready
    [0.0, 0.35, 0.45, 0.45],  # reached out, on the ground
    [0.0, 0.38, 1.10, 0.85],  # dug
    [1.2, 0.85, 0.95, 0.90],  # lifted and slewed
    [1.2, 0.90, 0.60, 0.30],  # dumped
    [0.0, 0.70, 0.70, 0.60],  # ready again
]
QUANTITIES = (
    "cap_pressure",
    "rod_pressure",
    "demand",
    "power",
    "to_lower",
    "to_upper",
    "force",
)
CYLINDERS = ("boom", "stick", "bucket")


def cycle() -> dict[str, np.ndarray]:
    """The motion and what the cylinders give.

    Returns:
        `t` (N,) [s], `tip` (N, 3) [m], `filled` (N,) the share of the earth in the bucket, and
        (N, 3) by cylinder: `cap_pressure` and `rod_pressure` [Pa], `demand` [m^3/s], `power` [W],
        `to_lower` and `to_upper` [m], `force` [N].
    """
    robot = load("excavator")
    t = np.linspace(0.0, TIMES[-1], 651)
    stop = np.zeros_like(POINTS)
    goal = JointTrajectory(TIMES, POINTS, stop, stop)(t)  # quintics that stop at every point
    state = robot.close_path(goal.u, goal.du)

    # Shares of the earth in the bucket, and of the soil's resistance.
    filled = np.interp(t, [2.5, 5.5, 8.5, 10.0], [0.0, 1.0, 1.0, 0.0])
    digging = np.interp(t, [2.5, 3.3, 4.7, 5.5], [0.0, 1.0, 1.0, 0.0])
    force = np.hstack([digging[:, None] * SOIL, np.zeros((len(t), 3))])
    empty = robot.loads.with_wrench(force)
    tau_empty = robot.inverse_dynamics(state, goal.ddu, empty)
    tau_full = robot.inverse_dynamics(state, goal.ddu, empty.with_payload(EARTH))
    tau = tau_empty + filled[:, None] * (tau_full - tau_empty)

    result = {"t": t, "tip": robot.forward_kinematics(state).position, "filled": filled}
    cylinders = robot.hydraulics(state, tau).values()
    for name in QUANTITIES:
        columns = [getattr(cylinder, name) for cylinder in cylinders]
        result[name] = np.stack(columns, axis=1)
    return result


def plot(result: dict[str, np.ndarray], path: str) -> None:
    """Pressures and flows over the cycle."""
    # Matplotlib is an extra.
    from hybrid_dynamics_core.drawing.page import entitled, written_page  # noqa: PLC0415
    from hybrid_dynamics_core.drawing.style import GRID, LOOPS, QUIET  # noqa: PLC0415

    about = "reach out, dig, lift and slew, dump, come back"
    with written_page(path, "A digging cycle of the excavator", about, height=5.4) as figure:
        pressure, flow = figure.subplots(2, 1, sharex=True)
        for k, name in enumerate(CYLINDERS):
            colour = LOOPS[k]
            cap = result["cap_pressure"][:, k] / 1e5
            rod = result["rod_pressure"][:, k] / 1e5
            pressure.plot(result["t"], cap, color=colour, label=f"{name}, cap side")
            pressure.plot(result["t"], rod, "--", color=colour, label=f"{name}, rod side")
            flow.plot(result["t"], 6e4 * result["demand"][:, k], color=colour, label=name)
        pressure.set(ylabel="pressure [bar]")
        flow.set(xlabel="t [s]", ylabel="flow [l/min]")
        for axes in (pressure, flow):
            axes.axvspan(2.5, 5.5, color=GRID, alpha=0.6, linewidth=0.0, zorder=0)
            axes.set_xlim(result["t"][0], result["t"][-1])
        flow.text(2.6, 0.97 * flow.get_ylim()[1], "digging", va="top", color=QUIET)
        entitled(pressure, "pressures of the cylinders", 3)
        entitled(flow, "what the pump delivers to them", 3)


def main() -> None:
    """Print the peaks; draw if asked."""
    parser = argparse.ArgumentParser(description="Digging cycle of an excavator.")
    parser.add_argument("--plot", metavar="FILE", help="write a figure (.svg or .png)")
    options = parser.parse_args()
    result = cycle()
    for k, name in enumerate(CYLINDERS):
        cap = result["cap_pressure"][:, k].max() / 1e5
        rod = result["rod_pressure"][:, k].max() / 1e5
        print(f"{name:>6}: cap side up to {cap:5.0f} bar, rod side up to {rod:5.0f} bar")
    flow = 6e4 * result["demand"].sum(axis=1).max()
    power = result["power"].sum(axis=1).max() / 1e3
    print(f"  pump: up to {flow:.0f} l/min, {power:.0f} kW at the cylinders")
    if options.plot:
        plot(result, options.plot)


if __name__ == "__main__":
    main()
