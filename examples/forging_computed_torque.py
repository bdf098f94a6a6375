"""The forging robot follows a motion under computed torque, with and without knowing what it holds.

python examples/forging_computed_torque.py [--plot FILE]

The gripper holds a billet of 150 kg. The controller runs every four milliseconds and starts one
centimetre off. Knowing the billet, the error dies out as e'' + kd e' + kp e = 0 says. Not knowing
it, the cylinders sag by millimetres: no better than springs and dampers of the same stiffness
without any model.
"""

from __future__ import annotations

import argparse

import numpy as np

from hybrid_dynamics_core import Payload, load
from hybrid_dynamics_core.control import ComputedTorque, FeedForward, JointTrajectory
from hybrid_dynamics_core.simulation import Settings, Simulation, simulate

BILLET = Payload(150.0, com=[0.15, 0.0, 0.0])  # from the end of the gripper [kg], [m]
KP = 400.0  # [1/s^2] with KD: both roots at -20/s
KD = 40.0  # [1/s]
START = [0.0, 0.10, 0.15, 0.0]  # q1 [rad], q12 [m], q22 [m], q4 [rad]
END = [0.8, 0.20, 0.12, 0.5]
OFF = [0.0, 0.01, 0.0, 0.0]  # where the robot stands beside the start of the motion


def follow() -> dict[str, Simulation]:
    """Motions of one and a half seconds by controller; the last half second holds the end."""
    robot = load("forging_chu2020")
    path = JointTrajectory.between(START, END, 1.0)
    truth = robot.loads.with_payload(BILLET)
    mass_matrix = robot.minimal_form(robot.close(START), truth)[0]
    stiffness = KP * np.diag(mass_matrix)  # at the start, joint by joint
    damping = KD / KP * stiffness
    controllers = {
        "computed torque, billet known": ComputedTorque(robot, path, KP, KD, truth),
        "computed torque, billet unknown": ComputedTorque(robot, path, KP, KD),
        "springs and dampers alone": FeedForward(robot, path, stiffness, damping, model=False),
    }
    settings = Settings(loads=truth, method="RK45", hold=4e-3, rate=100.0, rtol=1e-6, atol=1e-8)
    start = np.add(START, OFF)
    motions = {}
    for name, tau in controllers.items():
        motions[name] = simulate(robot, start, None, tau, (0.0, 1.5), settings)
    return motions


def errors(motion: Simulation) -> np.ndarray:
    """How far the joints are from the motion (N, 4) [rad, m]."""
    return motion.u - JointTrajectory.between(START, END, 1.0)(motion.t).u


def plot(motions: dict[str, Simulation], path: str) -> None:
    """Errors of both cylinders."""
    # Matplotlib is an extra.
    from hybrid_dynamics_core.drawing.page import written_page  # noqa: PLC0415

    offset = f"cylinder 1 starts {1e3 * OFF[1]:.0f} mm beside its path"
    about = f"the gripper holds {BILLET.mass:.0f} kg; {offset}"
    title = "The forging robot under three controllers"
    with written_page(path, title, about, height=3.5) as figure:
        panels = figure.subplots(1, 2, sharex=True)
        for axes, cylinder, joint in zip(panels, (1, 2), ("q12", "q22"), strict=True):
            for name, motion in motions.items():
                axes.plot(motion.t, 1e3 * errors(motion)[:, cylinder], label=name)
            axes.set(xlabel="t [s]", ylabel=f"error of {joint} [mm]")
            axes.set_title(f"cylinder {cylinder}: {joint}")
        lines, labels = panels[0].get_legend_handles_labels()
        figure.legend(lines, labels, loc="outside lower left", ncols=3, fontsize=8)


def main() -> None:
    """Print the errors at the end; draw if asked."""
    parser = argparse.ArgumentParser(description="Computed torque on the forging robot.")
    parser.add_argument("--plot", metavar="FILE", help="write a figure (.svg or .png)")
    options = parser.parse_args()
    motions = follow()
    print("error of the cylinders at the end:")
    for name, motion in motions.items():
        last = 1e3 * errors(motion)[-1]
        print(f"  {name:<32} q12 {last[1]:9.4f} mm, q22 {last[2]:9.4f} mm   ({motion.message})")
    if options.plot:
        plot(motions, options.plot)


if __name__ == "__main__":
    main()
