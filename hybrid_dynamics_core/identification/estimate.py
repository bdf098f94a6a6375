"""Estimation of parameters from logged motion and efforts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats
from scipy.linalg import qr, solve_triangular

from ..closed_state.state import ClosedState, ClosureStatus
from ..description.effects import JointEffect
from ..description.model import RobotDescription, effects_of
from ..dynamics.loads import Loads
from ..dynamics.parameters import JOINT_KINDS, Parameters, described_parameters, link_of
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arrays import finite_vectors
from ..ground.wording import counted, singular_or_plural
from ..robot.robot import Robot
from .base import RANK, BaseParameters, base_parameters
from .consistency import consistent
from .outliers import outlying_samples

PRIOR_WEIGHT = (
    1e-3  # of the divergence from the prior against half the sum of squares of normalised residuals
)
# of a joint's largest effort: none is measured better, and better weights leave nothing but
# rounding
FINEST = 1e-6
RUNS = 3  # estimates, each weighted with the residuals of the one before


class TooLittleShownError(InputError):
    """The samples do not show all base parameters that were asked for."""


@dataclass(frozen=True, eq=False)
class Identification:
    """Estimated parameters.

    Attributes:
        base: which combinations the data can show.
        estimate: (b,) of them, by weighted least squares.
        deviation: (b,) standard deviation of each; interval: (b, 2) where each lies with 95 %
        confidence. Both take the
            noise of the samples as independent: filtered or densely sampled logs make them too
            narrow.
        values: (p,) of all parameters, physical: positive masses, inertias that bodies can have,
        friction above zero.
            Combinations that the data cannot show stay near the description.
        noise: (n,) standard deviation of the residuals of each active joint [N m or N].
        explained: (n,) share of the variance of tau that the estimate explains, 1 at best.
        outlying: (N,) which samples were left out: in some joint further from the estimate than
        noise explains.
        residual: (N, n) measured efforts less those of the estimate, of all samples [N m or N].
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
        """Which parameters were asked for."""
        return self.base.parameters

    def described(self, description: RobotDescription) -> RobotDescription:
        """The description with the physical estimates in it."""
        names, links = self.parameters, dict(description.links)
        for k, link in enumerate(names.links):
            links[link] = link_of(link, self.values[10 * k : 10 * k + 10])
        effects: dict[str, JointEffect] = dict(description.effects)
        rest = iter(self.values[names.inertial_size :])
        for kind in JOINT_KINDS:
            for joint in getattr(names, kind):
                effects[joint] = _with(
                    effects.get(joint, effects_of(description, joint)), kind, float(next(rest))
                )
        return replace(
            description, links=MappingProxyType(links), effects=MappingProxyType(effects)
        )

    def table(self) -> Mapping[str, tuple[float, float, float]]:
        """Estimate and 95 % interval by the name of each base parameter."""
        rows = zip(self.base.names, self.estimate, self.interval, strict=True)
        return MappingProxyType(
            {name: (float(value), float(low), float(high)) for name, value, (low, high) in rows}
        )


def identify(
    robot: Robot,
    state: ClosedState,
    ddu: ArrayLike,
    tau: ArrayLike,
    parameters: Parameters | None = None,
    loads: Loads | None = None,
) -> Identification:
    """Estimate parameters from N samples: a batch state, accelerations and measured efforts (N, n).

    parameters: which to estimate (None: inertias of all links with mass, friction of no joint); all
    others, and what
        `loads` gives, are taken as they are. Samples that noise does not explain are left out, and
        are told in
        `Identification.outlying`. Raises TooLittleShownError, an InputError, where the samples do
        not show all base
        parameters; InputError for a row whose loops do not close, for entries that are not finite,
        and for names that
        the robot does not have.
    """
    parameters = described_parameters(robot.description) if parameters is None else parameters
    loads = robot.loads if loads is None else loads
    parameters.check(robot.description)
    if state.u.ndim != 2:
        raise InputError("identification takes a batch of states")
    _check_closed(state)
    tau = finite_vectors("tau", tau, robot.active, len(state.u))
    prior = parameters.values(robot.description, loads.effects)
    regressor = robot.regressor(state, ddu, parameters, loads)
    known = (
        robot.inverse_dynamics(state, ddu, loads) - regressor @ prior
    )  # of what is not asked for
    base = base_parameters(robot, parameters, loads)
    fit = _Fit(regressor, tau - known, base)
    start = _positive(prior, fit, parameters.inertial_size)
    weighted = fit.weighted(fit.regressor)
    values = consistent(weighted, fit.weighted_target, start, len(parameters.links), PRIOR_WEIGHT)
    return Identification(
        base,
        fit.beta,
        fit.deviation,
        fit.interval,
        values,
        fit.noise,
        fit.explained,
        fit.outlying,
        tau - known - regressor[..., base.kept] @ fit.beta,
        fit.condition,
    )


def _check_closed(state: ClosedState) -> None:
    """Raise InputError at the first row that `close(..., check=False)` let through."""
    status = np.asarray(state.status)
    rows = np.flatnonzero(status != ClosureStatus.OK)
    if len(rows):
        problem = ClosureStatus(status[rows[0]]).name.lower()
        raise InputError(
            f"{len(rows)} of {counted(len(status), 'state')} {singular_or_plural(len(rows), 'does', 'do')} not"
            f" close, row {rows[0]} the first ({problem}); leave"
            f" {singular_or_plural(len(rows), 'it', 'them')} out"
        )


class _Fit:
    """Least squares in the base parameters, each joint's equations weighted with its own noise, outliers left out."""

    def __init__(self, regressor: Array, target: Array, base: BaseParameters) -> None:
        n = target.shape[1]
        self._take(regressor, target, base)
        size = np.abs(target)
        floor = np.maximum(FINEST * size.max(axis=0), 1e-3 * FINEST * size.max(initial=1e-300))
        self.outlying = outlying_samples(self.columns, target, floor)
        self._take(regressor[~self.outlying], target[~self.outlying], base)
        target, free = self.target, self.target.size - base.size
        self.noise = np.ones(n)
        for _ in range(RUNS - 1):
            residual = target - self.columns @ self._solved()[0]
            share = np.sqrt((residual**2).sum(axis=0) * n / free)
            self.noise = np.maximum(share, floor)
        self.beta, triangle, sizes = self._solved()
        self.condition = float(np.linalg.cond(triangle))
        residual = target - self.columns @ self.beta
        scale = np.sqrt(((residual / self.noise) ** 2).sum() / free)
        inverse = solve_triangular(triangle, np.eye(base.size))
        self.deviation = scale * np.linalg.norm(inverse, axis=1) / sizes
        reach = float(stats.t.ppf(0.975, free)) * self.deviation
        self.interval = np.stack([self.beta - reach, self.beta + reach], axis=1)
        self.explained = 1.0 - residual.var(axis=0) / np.maximum(target.var(axis=0), 1e-300)

    def _take(self, regressor: Array, target: Array, base: BaseParameters) -> None:
        """Fit these samples; raise InputError where they are too few or show too little."""
        self.regressor, self.target, self.columns = regressor, target, regressor[..., base.kept]
        if target.size <= base.size:
            raise InputError(
                f"{target.size} equations cannot tell {base.size} base parameters; give more"
                " samples"
            )
        self._check_shown(base)

    def _check_shown(self, base: BaseParameters) -> None:
        """Raise InputError where some base parameters have no effect of their own on these samples."""
        matrix = self.columns.reshape(-1, base.size)
        sizes = np.maximum(np.linalg.norm(matrix, axis=0), 1e-300)
        triangle, order = qr(matrix / sizes, mode="r", pivoting=True)
        pivots = np.abs(np.diag(triangle))
        rank = int((pivots > RANK * pivots[0]).sum())
        if rank < base.size:
            hidden = ", ".join(base.names[k] for k in sorted(order[rank:])[:3])
            raise TooLittleShownError(
                f"the motion shows {rank} of {base.size} base parameters, not"
                f" {hidden}{', ...' if base.size - rank > 3 else ''}; give more varied motion, or"
                " ask for fewer parameters"
            )

    def _solved(self) -> tuple[Array, Array, Array]:
        """The estimate with the weights as they are, the triangle of the scaled equations and the scales."""
        matrix = self.weighted(self.columns)
        sizes = np.linalg.norm(matrix, axis=0)
        q, triangle = np.linalg.qr(matrix / sizes)
        return (
            np.asarray(solve_triangular(triangle, q.T @ self.weighted_target) / sizes),
            triangle,
            sizes,
        )

    def weighted(self, rows: Array) -> Array:
        """Equations (N, n, k) as a matrix (N n, k), each divided by its joint's noise."""
        return np.asarray((rows / self.noise[:, None]).reshape(-1, rows.shape[-1]))

    @property
    def weighted_target(self) -> Array:
        """The right-hand side (N n,)."""
        return np.asarray((self.target / self.noise).ravel())


def _positive(prior: Array, fit: _Fit, inertial: int) -> Array:
    """The prior; joint parameters of zero (those after the inertial ones) get what would make a hundredth of tau."""
    sizes = np.sqrt((fit.regressor[..., inertial:] ** 2).mean(axis=(0, 1)))
    small = 0.01 * float(np.sqrt((fit.target**2).mean())) / np.maximum(sizes, 1e-300)
    joints = prior[inertial:]
    return np.concatenate([prior[:inertial], np.where(joints > 0.0, joints, small)])


def _with(effect: JointEffect, kind: str, value: float) -> JointEffect:
    if kind == "armature":
        return replace(effect, rotor_inertia=value, gear_ratio=1.0)
    return replace(effect, **{kind: value})
