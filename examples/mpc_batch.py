"""One step of model predictive control for a batch, from exact derivatives of the dynamics.

python examples/mpc_batch.py [--plot FILE]

Sixteen forging robots stand beside the place where they should be. About each one's state the
motion is linear: d/dt (u, u') = A (u, u') + B tau + c, with A and B from
`forward_dynamics_derivatives`. Over a horizon this is a least-squares problem in the efforts, with
their limits as bounds (SciPy's lsq_linear). The plans then run on the full model, all robots at
once, beside efforts that only hold the weight.
"""

from __future__ import annotations

import argparse

import numpy as np
from scipy.linalg import expm
from scipy.optimize import lsq_linear

from hybrid_dynamics_core import Robot, load

STEPS = 12  # of the horizon
DT = 0.03  # [s] of a step
SUBSTEPS = 3  # of the integration of the full model, a step
GOAL = np.array([0.0, 0.15, 0.10, 0.0])  # q1 [rad], q12 [m], q22 [m], q4 [rad]
GOAL_STATE = np.concatenate([GOAL, np.zeros(4)])  # at rest
LIMITS = np.array([150.0, 6000.0, 9000.0, 5.0])  # of the efforts [N m], [N], [N], [N m]
WEIGHTS = np.array([20.0, 100.0, 100.0, 10.0, 1.0, 5.0, 5.0, 0.5])  # of the error of u and u'
THRIFT = 0.02  # weight of an effort as a share of its limit


def starts(count: int = 16) -> np.ndarray:
    """States (N, 8): u and u' beside the goal."""
    rng = np.random.default_rng(3)
    largest = np.array([0.15, 0.03, 0.03, 0.3, 0.2, 0.05, 0.05, 0.5])
    return GOAL_STATE + largest * rng.uniform(-1.0, 1.0, (count, 8))


def linearised(robot: Robot, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The motion over DT about states x (N, 8) that efforts hold: x_next = Ad x + Bd tau + cd.

    Returns:
        Ad (N, 8, 8), Bd (N, 8, 4) and cd (N, 8).
    """
    state = robot.close(x[:, :4], x[:, 4:])
    tau = robot.inverse_dynamics(state, np.zeros_like(state.u))
    by_u, by_du, by_tau = robot.forward_dynamics_derivatives(state, tau)  # all robots in one call
    flow = np.zeros((len(x), 13, 13))  # of (x, tau, 1): constant efforts over a step
    flow[:, :4, 4:8] = np.eye(4)
    flow[:, 4:8, :4] = by_u
    flow[:, 4:8, 4:8] = by_du
    flow[:, 4:8, 8:12] = by_tau
    at = np.concatenate([x, tau], axis=1)
    flow[:, 4:8, 12] = -np.einsum("nij,nj->ni", flow[:, 4:8, :12], at)  # no acceleration there
    step = expm(DT * flow)
    return step[:, :8, :8], step[:, :8, 8:12], step[:, :8, 12]


def plan(Ad: np.ndarray, Bd: np.ndarray, cd: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Efforts (STEPS, 4) of one robot that cost least over the horizon, within their limits."""
    free = x  # without efforts
    forced = np.zeros((8, STEPS, 4))  # by efforts, and linear in them
    rows = []
    target = []
    for k in range(STEPS):
        free = Ad @ free + cd
        forced = np.einsum("ij,jkl->ikl", Ad, forced)
        forced[:, k] = Bd
        rows.append(WEIGHTS[:, None] * (forced * LIMITS).reshape(8, -1))
        target.append(WEIGHTS * (GOAL_STATE - free))
    rows.append(THRIFT * np.eye(4 * STEPS))
    target.append(np.zeros(4 * STEPS))
    share = lsq_linear(np.vstack(rows), np.concatenate(target), (-1.0, 1.0)).x
    return share.reshape(STEPS, 4) * LIMITS


def rolled(robot: Robot, x: np.ndarray, efforts: np.ndarray) -> np.ndarray:
    """The full model under efforts (STEPS, N, 4), by Runge-Kutta, all robots at once.

    Returns:
        States (STEPS + 1, N, 8).
    """
    dynamics = robot.kernels.forward_dynamics

    def rate(x: np.ndarray, tau: np.ndarray) -> np.ndarray:
        u = np.ascontiguousarray(x[:, :4])
        du = np.ascontiguousarray(x[:, 4:])
        return np.concatenate([du, dynamics(u, du, np.ascontiguousarray(tau))], axis=1)

    h = DT / SUBSTEPS
    states = [x]
    for tau in efforts:
        for _ in range(SUBSTEPS):
            a = rate(x, tau)
            b = rate(x + 0.5 * h * a, tau)
            c = rate(x + 0.5 * h * b, tau)
            x = x + h / 6 * (a + 2 * b + 2 * c + rate(x + h * c, tau))
        states.append(x)
    return np.array(states)


def cost(states: np.ndarray, efforts: np.ndarray) -> np.ndarray:
    """What each robot's motion costs over the horizon (N,)."""
    error = (states[1:] - GOAL_STATE) * WEIGHTS
    thrift = THRIFT * efforts / LIMITS
    return (error**2).sum(axis=(0, 2)) + (thrift**2).sum(axis=(0, 2))


def solve() -> dict[str, np.ndarray]:
    """Plan, and run the plans on the full model.

    Returns:
        `efforts` (STEPS, N, 4), `predicted` and true `states` (STEPS + 1, N, 8), and costs (N,):
        `cost_predicted`, `cost` of the full model, and `cost_held` of holding the weight.
    """
    robot = load("forging_chu2020")
    x = starts()
    Ad, Bd, cd = linearised(robot, x)
    plans = [plan(Ad[n], Bd[n], cd[n], x[n]) for n in range(len(x))]
    efforts = np.stack(plans, axis=1)
    states = rolled(robot, x, efforts)
    predicted = predict(Ad, Bd, cd, x, efforts)
    weight = robot.minimal_form(robot.close(x[:, :4]))[2]
    hold = np.tile(weight, (STEPS, 1, 1))
    return {
        "efforts": efforts,
        "predicted": predicted,
        "states": states,
        "cost": cost(states, efforts),
        "cost_predicted": cost(predicted, efforts),
        "cost_held": cost(rolled(robot, x, hold), hold),
    }


def predict(
    Ad: np.ndarray, Bd: np.ndarray, cd: np.ndarray, x: np.ndarray, efforts: np.ndarray
) -> np.ndarray:
    """States (STEPS + 1, N, 8) of the linear model under efforts (STEPS, N, 4)."""
    states = [x]
    for tau in efforts:
        moved = np.einsum("nij,nj->ni", Ad, states[-1])
        driven = np.einsum("nij,nj->ni", Bd, tau)
        states.append(moved + driven + cd)
    return np.array(states)


def plot(result: dict[str, np.ndarray], path: str) -> None:
    """Errors of a cylinder, predicted and true, and its forces in the plans."""
    # Matplotlib is an extra.
    from hybrid_dynamics_core.drawing.page import entitled, written_page  # noqa: PLC0415
    from hybrid_dynamics_core.drawing.style import BLUE, QUIET, RED  # noqa: PLC0415

    t = DT * np.arange(STEPS + 1)
    true_error = 1e3 * (result["states"][:, :, 1] - GOAL[1])
    predicted_error = 1e3 * (result["predicted"][:, :, 1] - GOAL[1])
    count = true_error.shape[1]
    no_labels = [""] * (count - 1)  # one line of a batch has a name
    about = f"{count} forging robots beside their goal, {STEPS} steps of {1e3 * DT:.0f} ms"
    title = "A step of model predictive control for a batch"
    with written_page(path, title, about, height=3.5) as figure:
        error, effort = figure.subplots(1, 2)
        labels = ["full model", *no_labels]
        error.plot(t, true_error, color=BLUE, linewidth=1.2, label=labels)
        labels = ["predicted", *no_labels]
        error.plot(t, predicted_error, "--", color=RED, linewidth=0.9, label=labels)
        error.set(xlabel="t [s]", ylabel="error of q12 [mm]")
        plans = 1e-3 * result["efforts"][:, :, 1]
        labels = ["a plan", *no_labels]
        effort.step(t[:-1], plans, where="post", color=BLUE, linewidth=1.0, label=labels)
        limit = 1e-3 * LIMITS[1]
        effort.axhline(limit, color=QUIET, linestyle="--", label="limits")
        effort.axhline(-limit, color=QUIET, linestyle="--", label="")
        effort.set(xlabel="t [s]", ylabel="force of cylinder 1 [kN]")
        entitled(error, "where the plans lead", 2)
        entitled(effort, "the plans", 2)


def main() -> None:
    """Print what the plans gain; draw if asked."""
    parser = argparse.ArgumentParser(description="Model predictive control of a batch of robots.")
    parser.add_argument("--plot", metavar="FILE", help="write a figure (.svg or .png)")
    options = parser.parse_args()
    result = solve()
    horizon = f"{STEPS} steps of {1e3 * DT:.0f} ms"
    print(f"{len(result['cost'])} robots, {horizon}; cost over the horizon, on the average:")
    print(f"  holding the weight {result['cost_held'].mean():7.1f}")
    print(f"  plan, predicted    {result['cost_predicted'].mean():7.1f}")
    print(f"  plan, full model   {result['cost'].mean():7.1f}")
    largest = np.abs(result["efforts"]).max(axis=(0, 1)) / LIMITS
    shares = ", ".join(f"{share:.2f}" for share in largest)
    print(f"largest efforts in parts of their limits: {shares}")
    if options.plot:
        plot(result, options.plot)


if __name__ == "__main__":
    main()
