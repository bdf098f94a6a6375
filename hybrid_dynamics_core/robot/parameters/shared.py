"""Code that robots share which differ in some numbers of one description.

The first robot with other values of these numbers has code of its own. From the second on, the
numbers are arguments of code that all further ones use.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...description.document import KeyPath
from ...description.parameters.paths import component_paths, name_of, number_at
from ...description.parameters.written import Written
from ...errors import DescriptionError
from ...ground.arrays import Array, frozen
from ...kernels.digest import NoDigestError, digest
from ...kernels.run import Kernel
from ...programs import Program
from ...programs.live import BoundProgram, LiveModel
from ..model import RobotModel
from .bound_kernel import BoundKernel
from .live_check import difference
from .live_model import live_model


class _Code:
    """What robots with other values of the same numbers have in common.

    Attributes:
        first: values of the first robot.
        model: the model in which the numbers are live; None until a second robot is made.
        kernels: kernels by key and content of the program.
    """

    def __init__(self, first: Array) -> None:
        self.first = first
        self.model: LiveModel | None = None
        self.kernels: dict[tuple[str, str], Kernel] = {}


class SharedCode(NamedTuple):
    """The shared code of a robot, and its values of the numbers."""

    code: _Code
    values: Array

    def kernel(self, key: str, program: Program, label: str) -> Kernel | None:
        """The kernel of a program at these values; None if the program cannot be shared."""
        if self.code.model is None:
            return None
        try:
            content = digest((program.inputs, program.run, dict(program.sizes)))
        except NoDigestError:
            return None
        kernel = self.code.kernels.get((key, content))
        if kernel is None:
            kernel = BoundProgram(self.code.model, program).kernel(label)
            self.code.kernels[key, content] = kernel
        return BoundKernel(kernel, self.values)


def shared_code(model: RobotModel) -> SharedCode | None:
    """The code that a robot shares; None if it has code of its own."""
    written = model.description.written
    if not isinstance(written, Written) or not written.changes:
        return None
    paths: set[KeyPath] = set()
    for path in written.changes:
        paths.update(component_paths(written, name_of(path)))
    ordered = sorted(paths, key=str)
    values = {path: number_at(written, path) for path in ordered}
    numbers = frozen(list(values.values()))
    code = written.code.setdefault(tuple(ordered), _Code(numbers))
    if np.array_equal(code.first, numbers) or not all(map(math.isfinite, numbers)):
        return None
    described = model.program_model
    try:
        if code.model is None:
            code.model = live_model(described, model.description, written, values)
    except (TypeError, DescriptionError):  # a number is read in a way that code cannot follow
        return None
    if difference(code.model, numbers.tolist(), described, model.description):
        return None
    return SharedCode(code, numbers)
