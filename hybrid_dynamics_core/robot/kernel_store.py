"""The kernels of a robot, created at first use."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from ..ground.arrays import Array
from ..ground.lazy import lazy
from ..kernels.run import Codes, Kernel
from ..programs import Model, Program
from .model import RobotModel

if TYPE_CHECKING:
    from .parameters.shared import SharedCode


class KernelStore:
    """Kernels of programs by key.

    Attributes:
        model: the robot that the programs run on.
        kernels: the kernels created so far, by key.
    """

    def __init__(self, model: RobotModel) -> None:
        self.model = model
        self.kernels: dict[str, Kernel] = {}

    def kernel(
        self,
        key: str,
        program: Program,
        model: Model | None = None,
    ) -> Kernel:
        """The kernel of a program.

        Args:
            key: identifies program and model. Its first word is the program's name in messages.
            program: the program; not used if the kernel exists.
            model: tree and plan; those from the active coordinates if None.
        """
        if key not in self.kernels:
            label = f"{key.partition(' ')[0]} of {self.model.name}"
            described = self.model.program_model
            kernel: Kernel | None = None
            if self._shared is not None and model in (None, described):
                kernel = self._shared.kernel(key, program, label)
            self.kernels[key] = kernel or program.kernel(model or described, label)
        return self.kernels[key]

    @lazy
    def _shared(self) -> SharedCode | None:
        """The code that the robot shares with others; None if it has its own."""
        from .parameters.shared import shared_code  # noqa: PLC0415  few robots need it

        return shared_code(self.model)

    def run(
        self,
        key: str,
        program: Program,
        inputs: Mapping[str, Array],
        model: Model | None = None,
    ) -> tuple[dict[str, Array], Codes]:
        """Run a program.

        Args:
            key: as in `kernel`.
            program: the program to run.
            inputs: vectors by name, (size,) or (N, size); those that the program lacks are ignored.
            model: as in `kernel`.

        Returns:
            Results by name, and the status codes () or (N,).
        """
        kernel = self.kernel(key, program, model)
        return kernel(*[inputs[name] for name in program.inputs])
