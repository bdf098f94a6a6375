"""A study: many designs of a robot, and the same quantities of each."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from threading import Lock
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..description.model import RobotDescription
from ..description.parameters import with_parameters
from ..description.parameters.paths import component_paths
from ..description.parameters.written import written_of
from ..errors import DescriptionError, HybridDynamicsError, InputError
from ..ground.arrays import Array
from ..ground.check_arguments import integer
from ..ground.check_arrays import finite_vectors
from ..ground.file_options import PathText
from ..ground.suggestions import no_such_name
from ..library import load
from ..programs.outcome import OutcomeKind
from ..robot.parameters import RobotFamily
from ..robot.robot import Robot
from .designs import CLOSED, Designs, EachRobot, Function, checked_columns
from .function_source import source_of
from .quantities import Quantity, quantities_of, results_of
from .spaces import Space

CHUNK: Final = 20_000
VERSION: Final = 1  # of the content of results
Column = NDArray[Any]
_OF_A_DESIGN = ("robot", "poses", "quantities", "function")  # parts that decide its numbers
_KINDS = {kind.value: kind.name.lower() for kind in OutcomeKind}
SHARES: Final[tuple[str, ...]] = ("closes", "within_limits")  # of the poses
SLACK: Final = 1e-9  # [rad, m] beyond a limit: rounding
LETTERS: Final = max(map(len, _KINDS.values()))  # of a status


@dataclass(frozen=True, eq=False)
class Work:
    """What is computed of each design: what the workers of a cluster get.

    Attributes:
        description: the robot as it is described.
        names: the parameters that vary.
        quantities: names of the quantities.
        u: active coordinates (P, n) of the poses [rad, m].
        frame: name of the frame of `position`; the end effector if None.
        function: further columns; None without.
        key: digest of all this.
    """

    description: RobotDescription
    names: tuple[str, ...]
    quantities: tuple[str, ...]
    u: Array
    frame: str | None
    function: Function | None
    key: str


class Study:
    """Many designs of a robot.

    Attributes:
        robot: the robot as it is described.
        space: the designs.
        chunk: number of designs that are computed and written at once.
        work: what is computed of each.
        digests: digest of each part of the study, by name of the part.
    """

    def __init__(  # noqa: PLR0913 - a study has these parts
        self,
        robot: Robot | PathText,
        space: Space,
        quantities: Sequence[str] = (),
        u: ArrayLike | None = None,
        function: Function | None = None,
        *,
        frame: str | None = None,
        chunk: int = CHUNK,
    ) -> None:
        """Check a study; nothing is computed yet.

        Args:
            robot: a robot that was read from a file, the name of a shipped one, or a path.
            space: the designs: `grid`, `random` or `listed`.
            quantities: names such as `position.z`, `coordinate.q2`, `effort.q12`, `pin.theta_1`,
                `singularity`; for several poses with `.min`, `.max`, `.mean` or `.range`.
            u: active coordinates (n,) or (P, n) of the poses of each design [rad, m]; the reference
                if None.
            function: a function from `Designs` to arrays (N,) by name.
            frame: name of the frame of `position`; the end effector if None.
            chunk: number of designs that are computed and written at once.

        Raises:
            InputError: there is no such parameter, quantity or frame, a value is impossible, or a
                parameter cannot be free.
            DescriptionError: the robot's file is wrong.
        """
        self.robot = robot if isinstance(robot, Robot) else load(robot)
        self.space = space
        self.chunk = integer("chunk", chunk)
        if frame is not None and frame not in self.robot.frames:
            raise InputError(no_such_name("frame", frame, self.robot.frames))
        poses = self.robot.reference if u is None else finite_vectors("u", u, self.robot.active)
        poses = np.atleast_2d(poses)
        quantities_of(quantities, self.robot, len(poses))
        self._require_parameters()
        if quantities or not isinstance(function, EachRobot):
            self._require_possible()
            self._require_free()
        self.digests = {
            "robot": _digest(_content(self.robot.description)),
            "designs": _digest(space.content()),
            "poses": _digest([poses.shape, poses.tobytes().hex(), frame]),
            "quantities": _digest(list(quantities)),
            "function": _digest(source_of(function)),
            "chunk": str(self.chunk),
            "version": str(VERSION),
        }
        self.work = Work(
            self.robot.description,
            space.names,
            tuple(quantities),
            poses,
            frame,
            function,
            key=_digest([space.names, *(self.digests[part] for part in _OF_A_DESIGN)]),
        )

    @property
    def digest(self) -> str:
        """Digest of the whole study."""
        return _digest(self.digests)

    @property
    def chunks(self) -> int:
        """Number of chunks."""
        return -(-self.space.count // self.chunk)

    def rows(self, chunk: int) -> int:
        """Number of designs in a chunk."""
        return min(self.chunk, self.space.count - chunk * self.chunk)

    def values(self, chunk: int) -> Array:
        """Values (N, k) of the parameters of the designs in a chunk."""
        first = chunk * self.chunk
        return self.space.designs(first, first + self.rows(chunk))

    def columns(self, chunk: int) -> dict[str, Column]:
        """The columns (N,) of a chunk: `design`, the parameters, `status`, `closes`, results."""
        values = self.values(chunk)
        first = chunk * self.chunk
        numbers = np.arange(first, first + len(values))
        return {"design": numbers, **computed((self.work, values))}

    # -- checks

    def _require_parameters(self) -> None:
        """Raise InputError for a name that means no number, or several."""
        written = written_of(self.robot.description)
        for name in self.space.names:
            try:
                paths = component_paths(written, name)
            except InputError as error:
                raise InputError(f"vary: {error}") from error
            if len(paths) > 1:
                raise InputError(f"vary: '{name}' means {len(paths)} numbers; name one: {name}[0]")

    def _require_possible(self) -> None:
        """Raise InputError for a bound that the description refuses, such as a mass below zero."""
        for column, name in enumerate(self.space.names):
            for value in self.space.extremes()[:, column].tolist():
                try:
                    with_parameters(self.robot.description, {name: value})
                except DescriptionError as error:
                    what = f"{error.key} {error.problem}"
                    raise InputError(f"vary: {name} = {value:g}: {what}") from error

    def _require_free(self) -> None:
        """Raise InputError for a parameter that changes the structure of the robot."""
        try:
            self.robot.free(*self.space.names)
        except InputError as error:
            hint = "; a function of each robot (EachRobot) takes such designs too"
            raise InputError(f"vary: {error}{hint}") from error


class _Evaluator:
    """Computes the columns of designs; made once in each process."""

    def __init__(self, work: Work) -> None:
        self.work = work
        self.robot = Robot(work.description)
        self.family: RobotFamily | None = None
        with suppress(InputError):  # a function of each robot takes it too
            self.family = self.robot.free(*work.names)

    @cached_property
    def quantities(self) -> list[Quantity]:
        """What is computed."""
        return quantities_of(self.work.quantities, self.robot, len(self.work.u))

    def compile(self, values: Array) -> None:
        """Compile all code, with the parameters (1, k) of one design."""
        if self.family is not None:
            self._quantities(self._designs(values))

    def _designs(self, values: Array) -> Designs:
        work = self.work
        status = np.full(len(values), CLOSED, dtype=f"U{LETTERS}")
        return Designs(work.names, values, work.u, self.robot, self.family, status)

    def columns(self, values: Array) -> dict[str, Column]:
        """The columns (N,) of designs with parameters (N, k)."""
        work = self.work
        columns: dict[str, Column] = dict(zip(work.names, values.T, strict=True))
        designs = self._designs(values)
        results: dict[str, Array] = {}
        if self.family is not None:
            results = self._quantities(designs)
        shares = _taken(results, SHARES)
        if work.function is not None:
            results |= self._function(designs)
        if isinstance(work.function, EachRobot):
            for name, share in shares.items():
                shares[name] = np.where(designs.status == CLOSED, share, 0.0)
        for name in results:
            if name in columns or name in ("design", "status", *SHARES):
                raise InputError(f"function: there is a column '{name}' already; use another name")
            results[name] = np.where(designs.status == CLOSED, results[name], np.nan)
        return {**columns, "status": designs.status, **shares, **results}

    def _quantities(self, designs: Designs) -> dict[str, Array]:
        """The named quantities, and the share of the poses that close."""
        assert self.family is not None  # noqa: S101
        count, poses = len(designs), len(self.work.u)
        u = np.tile(self.work.u, (count, 1))
        parameters = np.repeat(designs.values, poses, axis=0)
        calls = dict.fromkeys(["close", *(one.call for one in self.quantities)])
        with np.errstate(all="ignore"):  # rows that do not close are NaN
            results = results_of(self.family, list(calls), u, parameters, self.work.frame)
            columns = {
                one.name: one.of_designs(results[one.call], poses) for one in self.quantities
            }
        codes = np.zeros((count, poses), dtype=np.int64)
        for result in results.values():
            status = np.asarray(result.status).reshape(count, poses)
            codes = np.where(codes == 0, status, codes)
        first = np.argmax(codes != 0, axis=1)
        kinds = codes[np.arange(count), first]
        for kind, text in _KINDS.items():
            designs.status[kinds == kind] = text
        is_within = self._within_limits(results["close"]["s"]).reshape(count, poses)
        shares = {"closes": codes == 0, "within_limits": (codes == 0) & is_within}
        return {**{name: mask.mean(axis=1) for name, mask in shares.items()}, **columns}

    def _within_limits(self, s: Array) -> NDArray[np.bool_]:
        """Whether all coordinates of rows (R, n_s) are within the limits of the description."""
        joints = self.robot.description.joints
        limits = np.array([joints[name].limits for name in self.robot.coordinates])
        low, high = limits.T
        with np.errstate(invalid="ignore"):  # rows that do not close are NaN
            is_within = (s >= low - SLACK) & (s <= high + SLACK)
        return np.asarray(is_within.all(axis=1))

    def _function(self, designs: Designs) -> dict[str, Array]:
        """The columns of the function."""
        assert self.work.function is not None  # noqa: S101
        try:
            results = self.work.function(designs)
        except InputError as error:
            raise InputError(f"function: {error}") from error
        except HybridDynamicsError:
            raise
        except Exception as error:  # of the user
            kind = type(error).__name__
            raise InputError(f"function: {kind}: {error}") from error
        return checked_columns(results, designs)


_EVALUATORS: dict[str, _Evaluator] = {}
_MAKING = Lock()


def computed(piece: tuple[Work, Array]) -> dict[str, Column]:
    """The columns of some designs, without their numbers.

    Args:
        piece: what is computed, and the parameters (N, k).
    """
    work, values = piece
    with _MAKING:  # code is compiled once
        evaluator = _EVALUATORS.get(work.key)
        if evaluator is None:
            _EVALUATORS.clear()
            evaluator = _EVALUATORS[work.key] = _Evaluator(work)
            evaluator.compile(values[:1])
    return evaluator.columns(values)


def _taken(results: dict[str, Array], names: Sequence[str]) -> dict[str, Array]:
    """Some columns, taken out of the results."""
    return {name: results.pop(name) for name in names if name in results}


def _digest(content: Any) -> str:
    text = json.dumps(content, default=str)
    return hashlib.sha256(text.encode()).hexdigest()


def _content(description: RobotDescription) -> Any:
    """The numbers and names of a description."""
    _, expanded = written_of(description).expanded
    return expanded.data


def described(study: Study) -> Mapping[str, Any]:
    """What a study is, as plain data, for its folder."""
    return {
        "robot": study.robot.name,
        "parameters": list(study.space.names),
        "designs": study.space.count,
        "chunk": study.chunk,
        "quantities": list(study.work.quantities),
        "digest": study.digest,
        "digests": study.digests,
    }
