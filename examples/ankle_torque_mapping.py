"""The ankle of a legged robot: one matrix maps torques of the foot to two motors, and back.

python examples/ankle_torque_mapping.py [--plot FILE]

Two cranks move the foot by push rods. With J = d(pitch, roll)/d(q_L, q_R), rows of R, the rates of
the foot are J u'. For foot torques m the motors must give J^T m: both sides do the same power.
Pitch and roll are given, the loops are closed from there, and J follows.
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
    return state.R[..., foot_columns(robot), :]


def foot_columns(robot: Robot) -> list[int]:
    """Where pitch and roll are among the coordinates."""
    return [robot.coordinates.index(name) for name in FOOT]


def push_off(pitches: np.ndarray) -> dict[str, np.ndarray]:
    """The mapping at pitch angles (N,) [rad] without roll.

    Returns:
        `cranks` (N, 2) [rad], `jacobian` (N, 2, 2), `torques` of the motors (N, 2) [N m], and the
        power at both ends, `motor_power` and `foot_power` (N,) [W].
    """
    robot = load("ankle")
    states = [robot.close_given({"pitch": float(pitch), "roll": 0.0}) for pitch in pitches]
    cranks = np.array([state.u for state in states])
    rates = np.tile([1.0, 0.6], (len(pitches), 1))  # of the cranks [rad/s]
    state = robot.close(cranks, rates)
    torques = robot.generalised_forces(state, PUSH_OFF)  # J^T m, by name
    foot_rates = state.ds[:, foot_columns(robot)]
    return {
        "cranks": cranks,
        "jacobian": foot_jacobian(robot, state),
        "torques": torques,
        "motor_power": np.einsum("ni,ni->n", torques, rates),
        "foot_power": foot_rates @ np.array(list(PUSH_OFF.values())),
    }


def available(jacobian: np.ndarray) -> np.ndarray:
    """Corners of the foot torques that motors up to LARGEST can give [N m].

    Returns:
        (5, 2), the first corner at both ends.
    """
    square = LARGEST * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1], [1, 1]])
    return np.linalg.solve(jacobian.T, square.T).T


def plot(pitches: np.ndarray, result: dict[str, np.ndarray], path: str) -> None:
    """Motor torques over the pitch, and the torques that the foot can have."""
    # Matplotlib is an extra.
    from hybrid_dynamics_core.drawing.page import entitled, written_page  # noqa: PLC0415
    from hybrid_dynamics_core.drawing.style import INK  # noqa: PLC0415

    pitch, roll = PUSH_OFF.values()
    torques = f"{pitch:.0f} N m about the pitch axis and {roll:.0f} N m about the roll axis"
    about = f"push-off takes {torques} of the foot"
    title = "Torques of an ankle and of its two motors"
    with written_page(path, title, about, height=3.4) as figure:
        needed, region = figure.subplots(1, 2)
        needed.plot(np.degrees(pitches), result["torques"], label=["motor q_L", "motor q_R"])
        needed.set(xlabel="pitch of the foot, toes down [deg]", ylabel="torque of a motor [N m]")
        for k in (0, len(pitches) // 2, -1):
            corners = available(result["jacobian"][k])
            region.plot(*corners.T, label=f"pitch {np.degrees(pitches[k]):.0f} deg")
        region.plot(*PUSH_OFF.values(), "*", color=INK, markersize=9, label="push-off")
        region.set(xlabel="pitch torque of the foot [N m]", ylabel="roll torque of the foot [N m]")
        entitled(needed, "what the motors need for it", 1)
        entitled(region, f"what motors of {LARGEST:.0f} N m can give", 2)


def main() -> None:
    """Print the mapping at three angles; draw if asked."""
    parser = argparse.ArgumentParser(description="Torques of an ankle.")
    parser.add_argument("--plot", metavar="FILE", help="write a figure (.svg or .png)")
    options = parser.parse_args()
    pitches = np.radians(np.linspace(-30.0, 30.0, 13))
    result = push_off(pitches)
    foot = f"pitch {PUSH_OFF['pitch']:.0f} N m, roll {PUSH_OFF['roll']:.0f} N m"
    print(f"foot: {foot}; the motors need")
    for k in (0, 6, 12):
        q_L, q_R = result["torques"][k]
        print(f"  at {np.degrees(pitches[k]):+4.0f} deg: q_L {q_L:6.2f} N m, q_R {q_R:6.2f} N m")
    difference = np.abs(result["motor_power"] - result["foot_power"]).max()
    power = np.abs(result["foot_power"]).max()
    print(f"power of motors and foot differ by at most {difference:.0e} W of {power:.0f} W")
    if options.plot:
        plot(pitches, result, options.plot)


if __name__ == "__main__":
    main()
