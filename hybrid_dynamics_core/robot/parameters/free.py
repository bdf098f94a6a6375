"""Choice of free parameters: which numbers of a description may be arguments of compiled code."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...description.document import KeyPath
from ...description.parameters.paths import component_paths, name_of, number_at
from ...description.parameters.written import Written, written_of
from ...dynamics.loads import described_loads
from ...errors import DescriptionError, InputError
from ...programs.live import LiveModel
from ..closure import Closure
from ..model import RobotModel
from .family import RobotFamily
from .live_check import difference, has_other_loads, unused
from .live_model import live_model

STEP = 2e-3  # relative, or in SI units at zero: more than what counts as rounding of files
Values = Mapping[KeyPath, float]


class FreeParameters:
    """Makes numbers of a robot's description arguments of its code."""

    def __init__(self, model: RobotModel, closure: Closure) -> None:
        self._model = model
        self._closure = closure

    def free(self, *names: str, given: Sequence[str] | None = None) -> RobotFamily:
        """The robot with some numbers of its description as arguments of its compiled code.

        The structure stays that of the robot: which loops have closed forms, which axes are
        parallel and which bars are equal. Numbers that would change it are refused. To change such
        a number, use `with_parameters`: that analyses the loops again.

        Args:
            names: names of `parameters:`, or paths such as `joints.q2.origin.xyz[0]`.
            given: coordinates that calls take in place of the active ones, as many; efforts are
                then along them.

        Returns:
            The robot as a function of these numbers, with exact derivatives.

        Raises:
            InputError: there is no such number, or it would change the structure, or has no effect.
        """
        if not names:
            raise InputError("name at least one parameter, such as 'L2' or 'links.boom.mass'")
        written = written_of(self._model.description)
        values = _values(written, names)
        given = self._model.active if given is None else tuple(given)
        problem, made = self._made(written, values, given)
        if made is None:
            raise InputError(self._refusal(written, values, given, problem))
        live, moved = made
        other_loads = has_other_loads(self._model, moved)
        without_effect = unused(live)
        if without_effect and not other_loads:
            name = list(map(name_of, values))[without_effect[0]]
            raise InputError(f"'{name}' has no effect on geometry, masses or loads")
        loads = described_loads(self._model.description, self._model.coordinates)
        by_name = {name_of(path): value for path, value in values.items()}
        return RobotFamily(self._closure, loads, live, by_name, other_loads)

    def _made(
        self, written: Written, values: Values, given: tuple[str, ...]
    ) -> tuple[str, tuple[LiveModel, RobotModel] | None]:
        """Why numbers cannot be free, or the live model and the robot with moved numbers."""
        described = self._model.program_model_from(given)
        moved = {path: _moved(k, value) for k, (path, value) in enumerate(values.items())}
        try:
            model = RobotModel.from_description(written.changed(moved).described())
            other = model.program_model_from(given)
            live = live_model(described, self._model.description, written, values)
        except DescriptionError as error:
            return f"does not fit the loops when it varies: {error.problem}", None
        except TypeError:
            return "is read in a way that code cannot follow", None
        problem = difference(live, list(moved.values()), other, model.description)
        return problem, None if problem else (live, model)

    def _refusal(
        self, written: Written, values: Values, given: tuple[str, ...], problem: str
    ) -> str:
        """The message for numbers that cannot be free, with the one that is the cause."""
        names = [name_of(path) for path in values]
        for path, value in values.items():
            alone, _ = self._made(written, {path: value}, given)
            if alone:
                names, problem = [name_of(path)], alone
                break
        listed = ", ".join(f"'{name}'" for name in names)
        return (
            f"{listed} cannot be free: {problem}; with_parameters makes a robot with other values"
        )


def _values(written: Written, names: Sequence[str]) -> dict[KeyPath, float]:
    """The numbers by path; a path that means several stands for each of them."""
    values: dict[KeyPath, float] = {}
    for name in names:
        for path in component_paths(written, name):
            if path in values:
                raise InputError(f"'{name_of(path)}' is named twice")
            values[path] = number_at(written, path)
    return values


def _moved(index: int, value: float) -> float:
    """Another value nearby; no two parameters move alike."""
    step = STEP * (1.0 + 0.1 * ((7 * index) % 10))
    return value + step * (abs(value) or 1.0)
