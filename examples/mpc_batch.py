"""One step of model predictive control for a batch of states, from the exact derivatives of the dynamics.

python examples/mpc_batch.py [--plot FILE]

Sixteen forging robots stand beside the place where they should be. About each one's state the
motion is linear, d/dt (u, u') = A (u, u') + B tau + c, with A and B from
`forward_dynamics_derivatives`; over a horizon that makes a least-squares problem in the efforts,
with their limits as bounds (SciPy's lsq_linear). The plans are then tried on the full model, all
robots at once, beside efforts that only hold the weight.
"""

from __future__ import annotations

import argparse

import numpy as np
from scipy.linalg import expm
from scipy.optimize import lsq_linear

from hybrid_dynamics_core import Robot, load

STEPS, DT = 12, 0.03  # of the horizon, [s]
GOAL = np.array([0.0, 0.15, 0.10, 0.0])  # q1 [rad], q12 [m], q22 [m], q4 [rad], at rest
LIMITS = np.array([150.0, 6000.0, 9000.0, 5.0])  # of the efforts [N m], [N], [N], [N m]
WEIGHTS = np.array([20.0, 100.0, 100.0, 10.0, 1.0, 5.0, 5.0, 0.5])  # of the error of u and u'
THRIFT = 0.02  # weight of an effort as a share of its limit


def starts(count: int = 16) -> np.ndarray:
    """States (N, 8): u and u' beside the goal."""
    rng = np.random.default_rng(3)
    spread = np.array([0.15, 0.03, 0.03, 0.3, 0.2, 0.05, 0.05, 0.5])
    return np.concatenate([GOAL, np.zeros(4)]) + spread * rng.uniform(-1.0, 1.0, (count, 8))


def linearised(robot: Robot, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Ad (N, 8, 8), Bd (N, 8, 4) and cd (N, 8) of x_next = Ad x + Bd tau + cd over DT, about states x that hold."""
    state = robot.close(x[:, :4], x[:, 4:])
    tau = robot.inverse_dynamics(state, np.zeros_like(state.u))
    by_u, by_du, by_tau = robot.forward_dynamics_derivatives(state, tau)  # all robots in one call
    flow = np.zeros((len(x), 13, 13))  # of (x, tau, 1): constant efforts over a step
    flow[:, :4, 4:8] = np.eye(4)
    flow[:, 4:8, :4], flow[:, 4:8, 4:8], flow[:, 4:8, 8:12] = by_u, by_du, by_tau
    at = np.concatenate([x, tau], axis=1)
    flow[:, 4:8, 12] = -np.einsum("nij,nj->ni", flow[:, 4:8, :12], at)  # no acceleration there
    step = expm(DT * flow)
    return step[:, :8, :8], step[:, :8, 8:12], step[:, :8, 12]


def plan(Ad: np.ndarray, Bd: np.ndarray, cd: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Efforts (STEPS, 4) of one robot that cost least over the horizon, within their limits."""
    free, forced = x, np.zeros((8, STEPS, 4))
    rows, target = [], []
    for k in range(STEPS):
        free, forced = Ad @ free + cd, np.einsum("ij,jkl->ikl", Ad, forced)
        forced[:, k] = Bd
        rows.append(WEIGHTS[:, None] * (forced * LIMITS).reshape(8, -1))
        target.append(WEIGHTS * (np.concatenate([GOAL, np.zeros(4)]) - free))
    rows.append(THRIFT * np.eye(4 * STEPS))
    target.append(np.zeros(4 * STEPS))
    share = lsq_linear(np.vstack(rows), np.concatenate(target), (-1.0, 1.0)).x
    return share.reshape(STEPS, 4) * LIMITS


def rolled(robot: Robot, x: np.ndarray, efforts: np.ndarray) -> np.ndarray:
    """States (STEPS + 1, N, 8) of the full model under efforts (STEPS, N, 4): Runge-Kutta, all robots at once."""
    dynamics = robot.kernels.forward_dynamics

    def rate(x: np.ndarray, tau: np.ndarray) -> np.ndarray:
        u, du = np.ascontiguousarray(x[:, :4]), np.ascontiguousarray(x[:, 4:])
        return np.concatenate([du, dynamics(u, du, np.ascontiguousarray(tau))], axis=1)

    states = [x]
    for tau in efforts:
        for _ in range(3):
            h = DT / 3
            a = rate(x, tau)
            b = rate(x + 0.5 * h * a, tau)
            c = rate(x + 0.5 * h * b, tau)
            x = x + h / 6 * (a + 2 * b + 2 * c + rate(x + h * c, tau))
        states.append(x)
    return np.array(states)


def cost(states: np.ndarray, efforts: np.ndarray) -> np.ndarray:
    """What each robot's motion costs over the horizon (N,)."""
    error = (states[1:] - np.concatenate([GOAL, np.zeros(4)])) * WEIGHTS
    return (error**2).sum(axis=(0, 2)) + ((THRIFT * efforts / LIMITS) ** 2).sum(axis=(0, 2))


def solve() -> dict[str, np.ndarray]:
    """Plans (STEPS, N, 4), predicted and true states (STEPS + 1, N, 8), and costs (N,) beside holding the weight."""
    robot = load("forging_chu2020")
    x = starts()
    Ad, Bd, cd = linearised(robot, x)
    efforts = np.stack(
        [plan(*one, start) for *one, start in zip(Ad, Bd, cd, x, strict=True)], axis=1
    )
    predicted = [x]
    for tau in efforts:
        predicted.append(
            np.einsum("nij,nj->ni", Ad, predicted[-1]) + np.einsum("nij,nj->ni", Bd, tau) + cd
        )
    weight = robot.minimal_form(robot.close(x[:, :4]))[2]
    hold = np.tile(weight, (STEPS, 1, 1))
    states, held = rolled(robot, x, efforts), rolled(robot, x, hold)
    return {
        "efforts": efforts,
        "predicted": np.array(predicted),
        "states": states,
        "cost": cost(states, efforts),
        "cost_predicted": cost(np.array(predicted), efforts),
        "cost_held": cost(held, hold),
    }


def plot(result: dict[str, np.ndarray], path: str) -> None:
    """Errors of a cylinder, predicted and true, and its forces in the plans."""
    from hybrid_dynamics_core.drawing.page import (  # noqa: PLC0415  needs Matplotlib
        entitled,
        written_page,
    )
    from hybrid_dynamics_core.drawing.style import BLUE, QUIET, RED  # noqa: PLC0415

    t = DT * np.arange(STEPS + 1)
    off, told = (1e3 * (result[key][:, :, 1] - GOAL[1]) for key in ("states", "predicted"))
    count = off.shape[1]
    about = f"{count} forging robots beside their goal, {STEPS} steps of {1e3 * DT:.0f} ms"
    with written_page(
        path, "A step of model predictive control for a batch", about, height=3.5
    ) as figure:
        error, effort = figure.subplots(1, 2)
        error.plot(t, off, color=BLUE, linewidth=1.2, label=["full model"] + [""] * (count - 1))
        error.plot(
            t, told, "--", color=RED, linewidth=0.9, label=["predicted"] + [""] * (count - 1)
        )
        error.set(xlabel="t [s]", ylabel="error of q12 [mm]")
        plans = 1e-3 * result["efforts"][:, :, 1]
        effort.step(
            t[:-1],
            plans,
            where="post",
            color=BLUE,
            linewidth=1.0,
            label=["a plan"] + [""] * (count - 1),
        )
        for k, limit in enumerate((1e-3 * LIMITS[1], -1e-3 * LIMITS[1])):
            effort.axhline(limit, color=QUIET, linestyle="--", label="" if k else "limits")
        effort.set(xlabel="t [s]", ylabel="force of cylinder 1 [kN]")
        entitled(error, "where the plans lead", 2)
        entitled(effort, "the plans", 2)


def main() -> None:
    """Print what the plans gain; draw if asked."""
    parser = argparse.ArgumentParser(description="Model predictive control of a batch of robots.")
    parser.add_argument("--plot", metavar="FILE", help="write a figure (.svg or .png)")
    options = parser.parse_args()
    result = solve()
    used = np.abs(result["efforts"]).max(axis=(0, 1)) / LIMITS
    print(
        f"{len(result['cost'])} robots, {STEPS} steps of {1e3 * DT:.0f} ms; cost over the horizon,"
        " on the average:"
    )
    print(f"  holding the weight {result['cost_held'].mean():7.1f}")
    print(f"  plan, predicted    {result['cost_predicted'].mean():7.1f}")
    print(f"  plan, full model   {result['cost'].mean():7.1f}")
    print(
        f"largest efforts in parts of their limits: {', '.join(f'{share:.2f}' for share in used)}"
    )
    if options.plot:
        plot(result, options.plot)


if __name__ == "__main__":
    main()
