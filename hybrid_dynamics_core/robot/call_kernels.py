"""The kernels of one compiled call: from a guess, from a start, and along a motion."""

from __future__ import annotations

from .. import programs
from ..ground.lazy import lazy
from ..kernels.caller import Loaders
from ..kernels.run import Kernel
from ..programs import Program
from .kernel_store import KernelStore


class CallKernels:
    """Kernels of a program, each loaded when it is first used.

    Args:
        kernels: store of the kernels.
        key: key of the program.
        program: a program with the input `guess`.
    """

    def __init__(self, kernels: KernelStore, key: str, program: Program) -> None:
        self.program = program
        self._kernels = kernels
        self._key = key

    @lazy
    def at_guess(self) -> Kernel:
        """The kernel whose iterations start from a guess."""
        return self._kernels.kernel(self._key, self.program)

    @lazy
    def from_start(self) -> Kernel:
        """The kernel for one move from a nearby closed configuration."""
        return self._kernels.kernel(f"{self._key} from start", self.program.from_start())

    @lazy
    def names_from_start(self) -> tuple[str, ...]:
        """Inputs of `from_start`, in order."""
        return self.program.from_start().inputs

    @lazy
    def along_motion(self) -> Kernel:
        """The kernel of `from_start`, with the next start as a further output."""
        program = programs.warm_started(self.program)
        return self._kernels.kernel(f"{self._key} along motion", program)

    def loaders(self) -> Loaders:
        """Functions that load the code of each kernel for one state."""
        return Loaders(
            at_guess=lambda: self.at_guess.one,
            from_start=lambda: self.from_start.one,
            along_motion=lambda: self.along_motion.one,
        )
