"""Programs under loads: packed loads, and a kernel for each pattern of loads."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from weakref import WeakKeyDictionary

from numpy.typing import ArrayLike

from ..closed_state.state import ClosedState
from ..dynamics.load_pattern import LoadPattern
from ..dynamics.loads import Loads, described_loads
from ..dynamics.pack_loads import pack_loads
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.lazy import lazy
from ..kernels.run import Kernel
from ..kernels.status import GOOD
from ..programs import Program
from .kernel_store import KernelStore
from .model import RobotModel

LoadedProgram = Callable[[LoadPattern], Program]
# pattern of loads, and their values as inputs of a program
Packed = tuple[LoadPattern, dict[str, Array]]
# kernel of a program, and names of its inputs
LoadedKernel = tuple[Kernel, tuple[str, ...]]
# the same, and values of its inputs, None for those of the state
DescribedKernel = tuple[Kernel, tuple[str, ...], list[Array | None]]


class LoadedPrograms:
    """Packs loads for kernels, and caches packed loads."""

    def __init__(self, model: RobotModel, kernels: KernelStore) -> None:
        self._model = model
        self._kernels = kernels
        self._packed: WeakKeyDictionary[Loads, Packed] = WeakKeyDictionary()
        self._by_pattern: dict[tuple[str, LoadPattern], LoadedKernel] = {}
        self._under_described: dict[str, DescribedKernel] = {}

    @lazy
    def described(self) -> Loads:
        """Loads of the description."""
        return described_loads(self._model.description, self._model.coordinates)

    def pack(
        self,
        loads: Loads,
        rows: int | None = None,
    ) -> Packed:
        """The pattern of the loads, and their values as inputs of a program.

        Args:
            loads: the loads.
            rows: number of states N of the batch; None for a single state.

        Raises:
            InputError: `loads` are no loads, a frame is unknown, or the number of rows is wrong.
        """
        if not isinstance(loads, Loads):
            raise InputError(f"expected Loads, such as robot.loads, got {type(loads).__name__}")
        packed = self._packed.get(loads)
        if packed is None:
            packed = pack_loads(loads, self._model.tree, self._model.frame, rows)
            # wrenches with rows belong to one batch
            if all(wrench.values.ndim == 1 for wrench in loads.wrenches.values()):
                self._packed[loads] = packed
        return packed

    def kernel(
        self,
        key: str,
        program: LoadedProgram,
        pattern: LoadPattern,
    ) -> LoadedKernel:
        """The kernel of a program under a pattern of loads, and the names of its inputs."""
        loaded = self._by_pattern.get((key, pattern))
        if loaded is None:
            with_loads = program(pattern)
            kernel = self._kernels.kernel(pattern.key(key), with_loads)
            loaded = kernel, with_loads.inputs
            self._by_pattern[key, pattern] = loaded
        return loaded

    def one_described(
        self, key: str, program: LoadedProgram, state: ClosedState, vector: Mapping[str, ArrayLike]
    ) -> dict[str, Array] | None:
        """Results of a program on one state under the loads of the description.

        Args:
            key: key of the program.
            program: function from a pattern of loads to the program.
            state: closed state of this robot, one.
            vector: a vector over the active coordinates by name, as the caller gave it.

        Returns:
            Results by name; None if the state has no result, or the vector is no plain array.
        """
        described = self._under_described.get(key)
        if described is None:
            described = self._under_described[key] = self._load_described(key, program)
        kernel, names, constants = described
        inputs = {"u": state.u, "du": state.du, "branch": state.signs, "guess": state.s, **vector}
        arguments = map(inputs.get, names, constants)
        outs = kernel.new_outs()
        # the code takes only finite arrays of the right type and shape
        if kernel.one(*arguments, *outs) != GOOD:
            return None
        return dict(zip(kernel.names, outs, strict=True))

    def _load_described(self, key: str, program: LoadedProgram) -> DescribedKernel:
        loads = self.described
        pattern, values = self.pack(loads)
        kernel, names = self.kernel(key, program, pattern)
        values = {**values, "gravity": loads.gravity}
        return kernel, names, [values.get(name) for name in names]
