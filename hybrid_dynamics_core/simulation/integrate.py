"""Integration of the equations of motion in minimal coordinates.

The loops are closed at every step, so there is no drift. The integrated state is (u, u', work).
Work is the energy from tau and applied wrenches, minus the losses by friction. So the robot's
energy minus the work is constant up to the integrator's error.
"""

from __future__ import annotations

from numpy.typing import ArrayLike

from ..closed_state.state import ClosedState
from ..errors import InputError
from ..ground.progress import Progress
from ..robot.robot import Robot
from ..robot.taken import AnyRobot, robot_of
from .arguments import Efforts, check_order, check_takes
from .result import Simulation
from .run import Run
from .settings import Settings, checked_span


def simulate(
    robot: AnyRobot,
    u: ArrayLike | ClosedState,
    du: ArrayLike | None = None,
    tau: ArrayLike | Efforts | None = None,
    t_span: tuple[float, float] = (0.0, 10.0),
    settings: Settings | None = None,
) -> Simulation:
    """Simulate the motion from an initial state under efforts tau.

    Args:
        robot: the model, or its description.
        u: (n,) active coordinates [rad or m], or a ClosedState with its rates.
        du: (n,) active rates [rad/s or m/s]; zero if None, and None with a ClosedState.
        tau: efforts [N m or N]: None for zero, a constant (n,), or a function of time [s] and
            ClosedState that returns (n,). The function must be free of memory, unless
            `settings.hold` is given: then it is called once a period, in order.
        t_span: start and end [s].
        settings: tolerances, sampling, and when to stop.

    Returns:
        The recorded motion. It ends early at a limit or singular configuration, see its `events`.

    Raises:
        InputError: an argument is wrong.
        ClosureError: the start does not close.
        MassSingularityError: the mass matrix is singular.
    """
    robot = robot_of(robot)
    if settings is None:
        settings = Settings()
    check_order(du, tau, t_span, settings)
    span = checked_span(t_span)
    start = _start(robot, u, du)
    if start.u.ndim != 1:
        raise InputError("a simulation starts from one state, not from a batch")
    if callable(tau):
        check_takes(tau, start)
    run = Run(robot, start, tau, span, settings)
    duration = span[1] - span[0]
    with Progress(f"simulating {robot.name}", duration, settings.progress) as progress:
        run.integrate(progress)
    return run.result()


def _start(robot: Robot, u: ArrayLike | ClosedState, du: ArrayLike | None) -> ClosedState:
    if not isinstance(u, ClosedState):
        return robot.close(u, du)
    if du is not None:
        raise InputError("du: the closed state has rates; give active coordinates, or no du")
    return u
