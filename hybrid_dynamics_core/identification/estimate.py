"""Estimation of parameters from logged motion and efforts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from ..closed_state.state import ClosedState, ClosureStatus
from ..description.effects import JointEffect
from ..description.model import RobotDescription, effects_of
from ..description.rigid_body import TRIANGLE_SLACK, impossibility, nearest_possible
from ..dynamics.loads import Loads
from ..dynamics.pack_loads import inertial_vector
from ..dynamics.parameters import JOINT_KINDS, Parameters, described_parameters, link_of
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arguments import require_type
from ..ground.check_arrays import finite_vectors
from ..ground.wording import counted, singular_or_plural
from ..robot.taken import AnyRobot, robot_of
from .base import RANK, BaseParameters, base_parameters, joint_rows, numerical_rank
from .consistency import consistent
from .outliers import Mask, outlying_samples

# Weight of the divergence from the prior, relative to half the sum of squared residuals.
PRIOR_WEIGHT = 1e-3
# Least noise, as a share of a joint's largest effort; below it, only rounding would be left.
FINEST = 1e-6
RUNS = 3  # number of fits, each weighted by the residuals of the previous one
CONFIDENCE = 0.95  # of intervals
LISTED = 3  # base parameters named in a message
TINY = 1e-300  # keeps divisors above zero


class TooLittleShownError(InputError):
    """The samples do not determine all requested base parameters."""


@dataclass(frozen=True, eq=False)
class Identification:
    """Estimated parameters.

    Attributes:
        base: the combinations that the data can determine.
        estimate: (b,) values of the combinations, by weighted least squares.
        deviation: (b,) standard deviation of each. It assumes independent noise: for filtered or
            densely sampled logs it is too small.
        interval: (b, 2) where each lies with 95 % confidence, too narrow for such logs as well.
        values: (p,) physical values of all parameters: positive masses, inertias that bodies can
            have, positive friction. Undetermined combinations stay near the description.
        noise: (k,) standard deviation of the residuals of each joint with efforts [N m or N].
        explained: (k,) share of the variance of tau that the estimate explains, 1 at best.
        outlying: mask (N,) of samples that were left out as outliers in some joint.
        residual: (N, k) measured minus estimated efforts of all samples [N m or N].
        condition: condition number of the data: above a few hundred the motion excites too little.
    """

    base: BaseParameters
    estimate: Array
    deviation: Array
    interval: Array
    values: Array
    noise: Array
    explained: Array
    outlying: np.ndarray
    residual: Array
    condition: float

    @property
    def parameters(self) -> Parameters:
        """The requested parameters."""
        return self.base.parameters

    def described(self, description: RobotDescription) -> RobotDescription:
        """The description with the physical estimates in it."""
        parameters = self.parameters
        links = dict(description.links)
        for k, link in enumerate(parameters.links):
            values = self.values[10 * k : 10 * k + 10]
            share = links[link].gravity_compensation or 0.0
            estimated = link_of(link, values)
            compensated = (share * estimated.mass, estimated.com)
            links[link] = replace(
                estimated, compensated_mass=compensated[0], compensated_com=compensated[1]
            )
        effects: dict[str, JointEffect] = dict(description.effects)
        joint_values = iter(self.values[parameters.inertial_size :])
        for kind in JOINT_KINDS:
            for joint in getattr(parameters, kind):
                effect = effects.get(joint, effects_of(description, joint))
                value = float(next(joint_values))
                effects[joint] = _with(effect, kind, value)
        return replace(
            description, links=MappingProxyType(links), effects=MappingProxyType(effects)
        )

    def table(self) -> Mapping[str, tuple[float, float, float]]:
        """Estimate and ends of its 95 % interval, by the name of each base parameter."""
        rows = {}
        for k, name in enumerate(self.base.names):
            low, high = self.interval[k].tolist()
            rows[name] = (float(self.estimate[k]), low, high)
        return MappingProxyType(rows)


def identify(  # noqa: PLR0913, PLR0917 - the data, and what of them counts
    robot: AnyRobot,
    state: ClosedState,
    ddu: ArrayLike,
    tau: ArrayLike,
    parameters: Parameters | None = None,
    loads: Loads | None = None,
    joints: Sequence[str] | None = None,
) -> Identification:
    """Estimate parameters from samples of a motion and of its efforts.

    Outliers are left out, see `Identification.outlying`.

    Args:
        robot: the model, or its description. It gives the parameters that are not estimated.
        state: N states, a batch.
        ddu: (N, n) accelerations of the active joints [rad/s^2 or m/s^2].
        tau: (N, k) measured efforts of `joints` [N m or N].
        parameters: the parameters to estimate; None: inertias of all links with mass, no friction.
        loads: known loads besides the actuators; None: those of the description.
        joints: the k active joints whose efforts were measured; None: all. They decide which base
            parameters there are.

    Returns:
        Estimates, with confidence and residuals.

    Raises:
        TooLittleShownError: an InputError: the samples do not determine all base parameters.
        InputError: the loops of a row do not close, an entry is not finite, or a name is unknown.
    """
    robot = robot_of(robot)
    require_type("state", state, ClosedState, "robot.close(u, du)")
    if parameters is None:
        parameters = described_parameters(robot.description)
    loads = robot.loads if loads is None else loads
    require_type("loads", loads, Loads, "robot.loads")
    parameters.check(robot.description)
    if state.u.ndim != 2:
        raise InputError("identification takes a batch of states")
    _check_closed(state)
    joints = robot.active if joints is None else tuple(joints)
    rows = joint_rows(robot, joints)
    efforts = finite_vectors("tau", tau, joints, len(state.u))
    prior = parameters.values(robot.description, loads.effects)
    regressor = robot.regressor(state, ddu, parameters, loads)[:, rows]
    # Efforts of the parameters that are not estimated.
    given = robot.inverse_dynamics(state, ddu, loads)[:, rows] - regressor @ prior
    base = base_parameters(robot, parameters, loads, joints=joints)
    target = efforts - given
    fit = _Fit(regressor, target, base)
    start = _positive(prior, fit, parameters.inertial_size)
    equations = fit.weighted(fit.regressor)
    bodies = len(parameters.links)
    return Identification(
        base=base,
        estimate=fit.beta,
        deviation=fit.deviation,
        interval=fit.interval,
        values=consistent(equations, fit.weighted_target, start, bodies, PRIOR_WEIGHT),
        noise=fit.noise,
        explained=fit.explained,
        outlying=fit.outlying,
        residual=target - regressor[..., base.kept] @ fit.beta,
        condition=fit.condition,
    )


def _check_closed(state: ClosedState) -> None:
    """Raise InputError at the first row that did not close in `close(..., check=False)`."""
    status = np.asarray(state.status)
    rows = np.flatnonzero(status != ClosureStatus.OK)
    if len(rows):
        problem = ClosureStatus(status[rows[0]]).name.lower()
        raise InputError(
            f"{len(rows)} of {counted(len(status), 'state')}"
            f" {singular_or_plural(len(rows), 'does', 'do')} not close, row {rows[0]} the first"
            f" ({problem}); leave {singular_or_plural(len(rows), 'it', 'them')} out"
        )


class _Fit:
    """Least squares in the base parameters, without outliers.

    The equations of each joint are weighted by its noise.
    """

    def __init__(self, regressor: Array, target: Array, base: BaseParameters) -> None:
        self.base = base
        self._take(regressor, target)
        floor = _noise_floor(target)
        self.outlying: Mask = outlying_samples(self.columns, target, floor)
        good = ~self.outlying
        self._take(regressor[good], target[good])
        self._free = self.target.size - base.size  # degrees of freedom
        self.noise = self._estimated_noise(floor)
        self.beta, triangle, sizes = self._solved()
        self.condition = float(np.linalg.cond(triangle))
        residual = self.target - self.columns @ self.beta
        self.deviation = self._deviation(residual, triangle, sizes)
        self.interval = self._interval()
        variance = np.maximum(self.target.var(axis=0), TINY)
        unexplained = residual.var(axis=0)
        self.explained = 1.0 - unexplained / variance

    def _take(self, regressor: Array, target: Array) -> None:
        """Use these samples; raise InputError if they are too few or determine too little."""
        self.regressor = regressor
        self.target = target
        self.columns = regressor[..., self.base.kept]
        if target.size <= self.base.size:
            raise InputError(
                f"{target.size} equations cannot tell {self.base.size} base parameters; give more"
                " samples"
            )
        self._check_shown()

    def _check_shown(self) -> None:
        """Raise InputError if the samples do not separate the effects of some base parameters."""
        from scipy.linalg import qr  # noqa: PLC0415  slow to import

        size = self.base.size
        matrix = self.columns.reshape(-1, size)
        norms = np.linalg.norm(matrix, axis=0)
        sizes = np.maximum(norms, TINY)
        triangle, order = qr(matrix / sizes, mode="r", pivoting=True)
        rank = numerical_rank(triangle, RANK)
        if rank < size:
            names = self.base.names
            hidden = [names[k] for k in sorted(order[rank:])[:LISTED]]
            more = ", ..." if size - rank > LISTED else ""
            raise TooLittleShownError(
                f"the motion shows {rank} of {size} base parameters, not"
                f" {', '.join(hidden)}{more}; give more varied motion, or ask for fewer parameters"
            )

    def _estimated_noise(self, floor: Array) -> Array:
        """(n,) standard deviation of each joint's noise, by iteratively reweighted fits."""
        n = self.target.shape[1]
        self.noise = np.ones(n)
        for _ in range(RUNS - 1):
            beta, _, _ = self._solved()
            residual = self.target - self.columns @ beta
            squares = (residual**2).sum(axis=0)
            deviation = np.sqrt(squares * n / self._free)
            self.noise = np.maximum(deviation, floor)
        return self.noise

    def _solved(self) -> tuple[Array, Array, Array]:
        """Estimate with the present weights, triangle R of the scaled equations, and the scales."""
        from scipy.linalg import solve_triangular  # noqa: PLC0415  slow to import

        matrix = self.weighted(self.columns)
        sizes = np.linalg.norm(matrix, axis=0)
        q, triangle = np.linalg.qr(matrix / sizes)
        beta = solve_triangular(triangle, q.T @ self.weighted_target) / sizes
        return np.asarray(beta), triangle, sizes

    def _deviation(self, residual: Array, triangle: Array, sizes: Array) -> Array:
        """(b,) standard deviation of each base parameter."""
        from scipy.linalg import solve_triangular  # noqa: PLC0415  slow to import

        normalised = residual / self.noise
        scale = np.sqrt((normalised**2).sum() / self._free)
        inverse = solve_triangular(triangle, np.eye(self.base.size))
        lengths = np.linalg.norm(inverse, axis=1)
        return np.asarray(scale * lengths / sizes)

    def _interval(self) -> Array:
        """(b, 2) confidence interval of each base parameter."""
        from scipy.special import stdtrit  # noqa: PLC0415  slow to import

        quantile = stdtrit(self._free, 0.5 + 0.5 * CONFIDENCE)
        reach = float(quantile) * self.deviation
        low = self.beta - reach
        high = self.beta + reach
        return np.stack([low, high], axis=1)

    def weighted(self, rows: Array) -> Array:
        """Equations (N, n, k) as a matrix (N n, k), each divided by its joint's noise."""
        weighted = rows / self.noise[:, None]
        return np.asarray(weighted.reshape(-1, rows.shape[-1]))

    @property
    def weighted_target(self) -> Array:
        """The right-hand side (N n,)."""
        return np.asarray((self.target / self.noise).ravel())


def _noise_floor(target: Array) -> Array:
    """(n,) least standard deviation of each joint's noise, from efforts (N, n)."""
    size = np.abs(target)
    largest = size.max(initial=TINY)
    finest = FINEST * size.max(axis=0)
    return np.asarray(np.maximum(finest, 1e-3 * FINEST * largest))


def _positive(prior: Array, fit: _Fit, inertial: int) -> Array:
    """The prior, changed to possible inertias and joint parameters above zero.

    Joint parameters that are zero get a value that gives a hundredth of tau.
    """
    squares = fit.regressor[..., inertial:] ** 2
    sizes = np.sqrt(squares.mean(axis=(0, 1)))
    mean_square = (fit.target**2).mean()
    effort = float(np.sqrt(mean_square))
    small = 0.01 * effort / np.maximum(sizes, TINY)
    joints = prior[inertial:]
    positive = np.where(joints > 0.0, joints, small)
    bodies = [_possible(prior[k : k + 10]) for k in range(0, inertial, 10)]
    return np.concatenate([*bodies, positive])


def _possible(body: Array) -> Array:
    """Ten parameters of a body, with the nearest possible inertia."""
    link = link_of("", body)
    if not impossibility(link.inertia, TRIANGLE_SLACK):
        return body
    return inertial_vector(link.mass, link.com, nearest_possible(link.inertia))


def _with(effect: JointEffect, kind: str, value: float) -> JointEffect:
    if kind == "armature":
        return replace(effect, rotor_inertia=value, gear_ratio=1.0)
    return replace(effect, **{kind: value})
