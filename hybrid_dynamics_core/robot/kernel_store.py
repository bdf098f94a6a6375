"""The kernels of a robot, created at first use."""

from __future__ import annotations

from collections.abc import Mapping

from ..ground.arrays import Array
from ..kernels.run import Codes, Kernel
from ..programs import Model, Program
from .model import RobotModel


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
            self.kernels[key] = program.kernel(model or self.model.program_model, label)
        return self.kernels[key]

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
