"""An excavator under nonlinear model predictive control, within all its limits.

python examples/excavator_mpc.py [--solver real-time] [--plot FILE]

Twenty times a second, CasADi plans the next second: by Ipopt, or by a single quadratic program from
the plan before (a real-time iteration). Accelerations are held over 50 ms, so rates are linear
between two samples. The flow of the pump is convex in the rates. Both thus hold between the samples
where they hold at them. Pressures follow from inverse dynamics at both ends of each step. A plan
starts where the machine will be when it is ready. The machine is the exact forward dynamics, with a
load that is 5 % heavier than in the model.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from itertools import product

import casadi
import numpy as np

from hybrid_dynamics_core import Payload, Robot, load
from hybrid_dynamics_core.description.actuators import Pump

STEPS = 20  # of the horizon
DT = 0.05  # [s] of a step, and from plan to plan
TICKS = 50  # of the drives' loop in a step
PLANS = 100  # of a run
MARGIN = 0.97  # share of rates, flow and efforts that plans use
SPARE = 0.002  # [m] of the strokes that plans leave at either end
START = np.array([0.0, 0.45, 0.95, 0.6])  # slewing angle [rad], strokes [m]
GOAL = np.array([1.2, 0.85, 0.7, 0.997])  # the bucket's cylinder almost at its end
RATES = np.array([0.8, 0.3, 0.3, 0.3])  # largest [rad/s], [m/s]
TORQUE = 120e3  # of the slewing gear [N m]
FLOW = 220 / 6e4  # of the pump [m^3/s]
KNOWN = Payload(900.0, com=(-0.6, 0.3, 0.0))  # in the bucket [kg], [m]
TRUE = Payload(945.0, com=(-0.6, 0.3, 0.0))
WEIGHTS = np.array([1.0, 6.0, 6.0, 6.0])  # of the coordinates
DAMPING = 0.1  # weight of rates
THRIFT = 0.004  # weight of accelerations
IPOPT = {
    "print_level": 0,
    "sb": "yes",
    "tol": 1e-4,
    "warm_start_init_point": "yes",
    "mu_init": 1e-3,
}
ONE_PROGRAM = {
    "max_iter": 1,
    "print_header": False,
    "print_iteration": False,
    "print_status": False,
    "qpsol": "osqp",
    "qpsol_options": {"osqp": {"verbose": False}},
}
SOLVERS = {"ipopt": ("ipopt", {"ipopt": IPOPT}), "real-time": ("sqpmethod", ONE_PROGRAM)}


def machine() -> Robot:
    """The excavator with limits of its rates, its slewing gear and its pump."""
    description = load("excavator").description
    joints = dict(description.joints)
    for name, rate in zip(description.active, RATES, strict=True):
        joints[name] = replace(joints[name], velocity_limit=float(rate))
    joints["slew"] = replace(joints["slew"], effort_limit=TORQUE)
    pump = Pump(description.active[1:], flow_limit=FLOW)
    return Robot(replace(description, joints=joints, pumps={"main": pump}))


def flow_rows(robot: Robot) -> np.ndarray:
    """Rows (8, 4) whose largest product with u' is the flow of the pump [m^3/s].

    A cylinder that extends takes its cap area times its rate, one that retracts its rod area.
    """
    areas = [(one.cap_area, -one.rod_area) for one in robot.cylinders.values()]
    return np.array([(0.0, *row) for row in product(*areas)])


class Planner:
    """Plans accelerations for the horizon, each plan from the one before."""

    def __init__(self, robot: Robot, solver: str) -> None:
        problem = casadi.Opti()
        self._now = problem.parameter(4, 2)  # u and u' where the plan starts
        u, du = problem.variable(4, STEPS), problem.variable(4, STEPS)  # at the ends of steps
        ddu = problem.variable(4, STEPS)
        u_before = casadi.horzcat(self._now[:, 0], u[:, :-1])
        du_before = casadi.horzcat(self._now[:, 1], du[:, :-1])
        problem.subject_to(u == u_before + DT * du_before + 0.5 * DT**2 * ddu)
        problem.subject_to(du == du_before + DT * ddu)
        model = robot.casadi.under(robot.loads.with_payload(KNOWN)).inverse_dynamics.expand()
        both_ends = casadi.horzcat(u_before, u), casadi.horzcat(du_before, du)
        tau, _ = model.map(2 * STEPS)(*both_ends, casadi.horzcat(ddu, ddu))
        within(problem, u, robot.limits + SPARE * np.array([1.0, -1.0]))
        within(problem, du, MARGIN * np.stack([-RATES, RATES], axis=1))
        efforts = [robot.effort_ranges[name] for name in robot.active]
        within(problem, tau, MARGIN * np.array(efforts))
        flow = casadi.DM(flow_rows(robot)) @ du
        problem.subject_to(casadi.vec(flow) / FLOW <= MARGIN)
        cost = weighed(u - casadi.repmat(GOAL, 1, STEPS))
        cost += DAMPING * weighed(du) + THRIFT * weighed(ddu)
        problem.minimize(cost)
        self._problem = problem
        self._unknowns = (u, du, ddu)
        self._plan = [np.tile(START[:, None], STEPS), np.zeros((4, STEPS)), np.zeros((4, STEPS))]
        self._choose(solver, cost)

    def _choose(self, solver: str, cost: casadi.MX) -> None:
        """Take a solver, with the second derivatives of the cost alone (Gauss-Newton)."""
        problem = self._problem
        factor = casadi.MX.sym("factor")
        curvature = factor * casadi.hessian(cost, problem.x)[0]
        name, options = SOLVERS[solver]
        if name == "ipopt":
            curvature = casadi.triu(curvature)
        inputs = [problem.x, problem.p, factor, problem.lam_g]
        second = casadi.Function("nlp_hess_l", inputs, [curvature])
        problem.solver(name, {**options, "hess_lag": second, "print_time": False})

    def __call__(self, u: np.ndarray, du: np.ndarray) -> np.ndarray:
        """The acceleration (4,) for the step that starts at u and u'."""
        problem = self._problem
        problem.set_value(self._now, np.stack([u, du], axis=1))
        for unknown, values in zip(self._unknowns, self._plan, strict=True):
            problem.set_initial(unknown, np.hstack([values[:, 1:], values[:, -1:]]))
        solution = problem.solve_limited()
        self._plan = [solution.value(unknown) for unknown in self._unknowns]
        return self._plan[2][:, 0]


def within(problem: casadi.Opti, values: casadi.MX, bounds: np.ndarray) -> None:
    """Keep columns (4, N) within bounds (4, 2), infinite or not."""
    for k, (low, high) in enumerate(bounds):
        if np.isfinite(high):
            problem.subject_to(problem.bounded(low / high, values[k, :].T / high, 1.0))


def weighed(columns: casadi.MX) -> casadi.MX:
    """Weighed sum of squares of columns (4, N)."""
    return casadi.dot(casadi.repmat(WEIGHTS, 1, columns.shape[1]), columns**2)


def moved(robot: Robot, x: np.ndarray, tau: np.ndarray, h: float) -> np.ndarray:
    """The machine's state (2, 4) after h [s] of held efforts, by Runge-Kutta."""
    dynamics = robot.kernels.under(robot.loads.with_payload(TRUE)).forward_dynamics

    def rate(x: np.ndarray) -> np.ndarray:
        return np.stack([x[1], dynamics(x[0], x[1], tau)])

    a = rate(x)
    b = rate(x + 0.5 * h * a)
    c = rate(x + 0.5 * h * b)
    return x + h / 6.0 * (a + 2.0 * b + 2.0 * c + rate(x + h * c))


def run(solver: str = "ipopt", plans: int = PLANS) -> dict[str, np.ndarray]:
    """The motion under a planner.

    Returns:
        At each tick `t` [s], `u`, `du`, `tau` (N, 4); `spent` [s], CPU time of each plan.
    """
    robot = machine()
    planner = Planner(robot, solver)
    model = robot.kernels.under(robot.loads.with_payload(KNOWN)).inverse_dynamics
    x = np.stack([START, np.zeros(4)])
    ddu = np.zeros(4)
    states, efforts, spent = [], [], []
    for _ in range(plans):
        ready = x[0] + DT * x[1] + 0.5 * DT**2 * ddu, x[1] + DT * ddu
        begin = time.process_time()
        following = planner(*ready)
        spent.append(time.process_time() - begin)
        for _ in range(TICKS):
            tau = model(x[0], x[1], ddu)
            states.append(x)
            efforts.append(tau)
            x = moved(robot, x, tau, DT / TICKS)
        ddu = following
    u, du = np.array(states).transpose(1, 0, 2)
    t = DT / TICKS * np.arange(len(u))
    return {"t": t, "u": u, "du": du, "tau": np.array(efforts), "spent": np.array(spent)}


def use(motion: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Shares of their limits at each tick (N,): rates, flow of the pump, efforts; spare stroke [m].

    A share of 1 is the limit itself, without the margin of the plans.
    """
    robot = machine()
    u, du, tau = motion["u"], motion["du"], motion["tau"]
    low, high = np.array([robot.effort_ranges[name] for name in robot.active]).T
    spare = np.minimum(u - robot.limits[:, 0], robot.limits[:, 1] - u)
    return {
        "rates": np.max(np.abs(du) / RATES, axis=1),
        "flow": np.max(du @ flow_rows(robot).T, axis=1) / FLOW,
        "efforts": np.max(np.maximum(tau / high, tau / low), axis=1),
        "spare": np.min(spare[:, 1:], axis=1),
    }


def plot(motion: dict[str, np.ndarray], path: str) -> None:
    """Coordinates on their way to the goal, and shares of the limits."""
    # Matplotlib is an extra.
    from hybrid_dynamics_core.drawing.page import entitled, written_page  # noqa: PLC0415

    names = ("slewing [rad]", "boom cylinder [m]", "stick cylinder [m]", "bucket cylinder [m]")
    shares = use(motion)
    title = "Model predictive control within the limits of cylinders and pump"
    about = f"plans of {STEPS * DT:.0f} s every {1e3 * DT:.0f} ms; {TRUE.mass:.0f} kg in the bucket"
    about += f", {KNOWN.mass:.0f} kg in the model"
    with written_page(path, title, about, height=3.6) as figure:
        way, limits = figure.subplots(1, 2)
        for k, name in enumerate(names):
            way.plot(motion["t"], motion["u"][:, k] - GOAL[k], label=name)
        way.set(xlabel="time [s]", ylabel="coordinate less its goal [rad], [m]")
        for name in ("efforts", "rates", "flow"):
            limits.plot(motion["t"], shares[name], label=name)
        limits.set(xlabel="time [s]", ylabel="largest share of a limit [-]", ylim=(0.0, 1.3))
        entitled(way, "to the goal", 2)
        entitled(limits, "limits", 3)


def main() -> None:
    """Print times and shares of limits; draw if asked."""
    parser = argparse.ArgumentParser(description="Model predictive control of an excavator.")
    parser.add_argument("--solver", choices=SOLVERS, default="ipopt")
    parser.add_argument("--plot", metavar="FILE", help="write a figure (.svg or .png)")
    options = parser.parse_args()
    motion = run(options.solver)
    half, most = 1e3 * np.percentile(motion["spent"], [50.0, 99.0])
    print(f"{options.solver}: a plan takes {half:.0f} ms of CPU time, p99 {most:.0f} ms")
    shares = use(motion)
    largest = ", ".join(f"{name} {shares[name].max():.3f}" for name in ("rates", "flow", "efforts"))
    print(f"largest shares of limits, at every millisecond: {largest}")
    print(f"least distance of a cylinder from its end: {1e3 * shares['spare'].min():.1f} mm")
    error = 1e3 * np.abs(motion["u"][-1] - GOAL)[1:].max()
    print(f"off the goal at the end: cylinders by {error:.1f} mm at most")
    if options.plot:
        plot(motion, options.plot)


if __name__ == "__main__":
    main()
