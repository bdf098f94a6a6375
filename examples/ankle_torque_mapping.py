"""The ankle of a legged robot: torques of the foot become torques of two motors, and back, by one matrix.

python examples/ankle_torque_mapping.py [--plot FILE]

Two cranks move the foot by push rods. With J = d(pitch, roll)/d(q_L, q_R), rows of R, the rates of
the foot are J u', and what the motors must give for foot torques m is J^T m: both sides do the same
power. Where the foot stands, and so J, is found by giving pitch and roll and closing the loops from
there.
"""

from __future__ import annotations

import argparse

import numpy as np

from hybrid_dynamics_core import ClosedState, Robot, load

LARGEST = 60.0  # torque of a motor [N m]
PUSH_OFF = {"pitch": 80.0, "roll": 5.0}  # torques of the foot at push-off [N m]
FOOT = ("pitch", "roll")


def foot_jacobian(robot: Robot, state: ClosedState) -> np.ndarray:
    """J (2, 2) or (N, 2, 2): rates of pitch and roll from those of q_L and q_R."""
    return state.R[..., [robot.coordinates.index(name) for name in FOOT], :]


def push_off(pitches: np.ndarray) -> dict[str, np.ndarray]:
    """At pitch angles (N,) [rad], no roll: J (N, 2, 2), motor torques (N, 2) [N m], power at both ends (N,) [W]."""
    robot = load("ankle")
    states = [robot.close_given({"pitch": float(pitch), "roll": 0.0}) for pitch in pitches]
    cranks = np.array([state.u for state in states])
    rates = np.tile([1.0, 0.6], (len(pitches), 1))  # of the cranks [rad/s]
    state = robot.close(cranks, rates)
    torques = robot.generalised_forces(state, PUSH_OFF)  # J^T m, by name
    foot_rates = state.ds[:, [robot.coordinates.index(name) for name in FOOT]]
    return {
        "cranks": cranks,
        "jacobian": foot_jacobian(robot, state),
        "torques": torques,
        "motor_power": np.einsum("ni,ni->n", torques, rates),
        "foot_power": foot_rates @ np.array(list(PUSH_OFF.values())),
    }


def available(jacobian: np.ndarray) -> np.ndarray:
    """(5, 2) corners, the first one again at the end, of the foot torques that motors up to LARGEST can give [N m]."""
    square = LARGEST * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1], [1, 1]])
    return np.linalg.solve(jacobian.T, square.T).T


def plot(pitches: np.ndarray, result: dict[str, np.ndarray], path: str) -> None:
    """Motor torques over the pitch, and the torques that the foot can have."""
    from hybrid_dynamics_core.drawing.page import (  # noqa: PLC0415  needs Matplotlib
        entitled,
        written_page,
    )
    from hybrid_dynamics_core.drawing.style import INK  # noqa: PLC0415

    pitch, roll = PUSH_OFF.values()
    about = (
        f"push-off takes {pitch:.0f} N m about the pitch axis and {roll:.0f} N m about the roll"
        " axis of the foot"
    )
    with written_page(
        path, "Torques of an ankle and of its two motors", about, height=3.4
    ) as figure:
        over, region = figure.subplots(1, 2)
        over.plot(np.degrees(pitches), result["torques"], label=["motor q_L", "motor q_R"])
        over.set(xlabel="pitch of the foot, toes down [deg]", ylabel="torque of a motor [N m]")
        for k in (0, len(pitches) // 2, -1):
            corners = available(result["jacobian"][k])
            region.plot(*corners.T, label=f"pitch {np.degrees(pitches[k]):.0f} deg")
        region.plot(*PUSH_OFF.values(), "*", color=INK, markersize=9, label="push-off")
        region.set(xlabel="pitch torque of the foot [N m]", ylabel="roll torque of the foot [N m]")
        entitled(over, "what the motors need for it", 1)
        entitled(region, f"what motors of {LARGEST:.0f} N m can give", 2)


def main() -> None:
    """Print the mapping at three angles; draw if asked."""
    parser = argparse.ArgumentParser(description="Torques of an ankle.")
    parser.add_argument("--plot", metavar="FILE", help="write a figure (.svg or .png)")
    options = parser.parse_args()
    pitches = np.radians(np.linspace(-30.0, 30.0, 13))
    result = push_off(pitches)
    print(
        f"foot: pitch {PUSH_OFF['pitch']:.0f} N m, roll {PUSH_OFF['roll']:.0f} N m; the motors need"
    )
    for k in (0, 6, 12):
        left, right = result["torques"][k]
        print(f"  at {np.degrees(pitches[k]):+4.0f} deg: q_L {left:6.2f} N m, q_R {right:6.2f} N m")
    lost = np.abs(result["motor_power"] - result["foot_power"]).max()
    print(
        f"power of motors and foot differ by at most {lost:.0e} W of"
        f" {np.abs(result['foot_power']).max():.0f} W"
    )
    if options.plot:
        plot(pitches, result, options.plot)


if __name__ == "__main__":
    main()
