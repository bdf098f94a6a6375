"""The calls of a robot in PyTorch, with exact derivatives.

    tau, status = robot.torch.inverse_dynamics(u, du, ddu)
    (tau**2).sum().backward()

Values and derivatives are compiled kernels of the library, on the CPU and in 64 bits.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ...errors import InputError
from ...ground.lazy import lazy
from .calls import CALL_BY_NAME
from .function_calls import FunctionCalls

try:
    import torch

    from .torch_function import CompiledCall, Differentiable
except ModuleNotFoundError as error:  # pragma: no cover
    if error.name != "torch":
        raise
    raise InputError(
        "robot.torch needs PyTorch: pip install 'hybrid_dynamics_ros[torch]', or torch"
    ) from error

Tensor = Any  # torch.Tensor; PyTorch is no dependency of type checks


class TorchCalls(FunctionCalls):
    """The calls of a robot in PyTorch.

    Every call takes vectors (n,) of one state, or (..., n) of states side by side: tensors or
    arrays. Vectors are broadcast against each other. A call returns its results and then `status`,
    an int64 tensor: 0 (CLOSED), or the number of another `OutcomeKind`. With another one the
    results are NaN.

    Results have the type and the device of u; they are computed on the CPU in 64 bits. First
    derivatives are exact, and there are no second ones.

    Dynamics also take `gravity` (3,) [m/s^2]. All calls take `start`, the reference configuration
    by default. Loops without a closed form are closed from there in one smooth move. The status is
    JUMP if u is too far away.
    """

    def _run(self, name: str, vectors: dict[str, Any]) -> tuple[list[Tensor], Tensor]:
        """Results of a call in their shapes, and the status."""
        call = self._compiled(name)
        tensors = {key: self._tensor(key, vectors[key]) for key in call.names}
        batch = torch.broadcast_shapes(*[tensor.shape[:-1] for tensor in tensors.values()])
        rows = [_rows(tensor, batch) for tensor in tensors.values()]
        flat, status = Differentiable.apply(call, *rows)
        device = None
        u = vectors["u"]
        if isinstance(u, torch.Tensor):
            device = u.device
            # the next call needs all digits of its start
            is_rounded = u.is_floating_point() and name != "step"
            flat = flat.to(device=device, dtype=u.dtype if is_rounded else None)
        results = []
        sizes = [math.prod(shape) for shape in call.layout]
        for part, shape in zip(flat.split(sizes, dim=-1), call.layout, strict=True):
            results.append(part.reshape(*batch, *shape))
        return results, status.to(device).reshape(batch)

    @lazy
    def _calls(self) -> dict[str, CompiledCall]:
        return {}

    def _compiled(self, name: str) -> CompiledCall:
        if name not in self._calls:
            self._calls[name] = CompiledCall(CALL_BY_NAME[name], self._tracer)
        return self._calls[name]

    def _tensor(self, name: str, values: Any) -> Tensor:
        """A vector (..., size of the input) of 64 bits on the CPU; raises InputError."""
        if not isinstance(values, torch.Tensor):
            values = np.array(values, dtype=float)  # PyTorch wants to own what it is given
        tensor = torch.as_tensor(values).to(device="cpu", dtype=torch.float64)
        if name == "du" and tensor.ndim == 0:
            tensor = tensor.expand(self._size(name))
        self._check_shape(name, tuple(tensor.shape))
        return tensor


def _rows(tensor: Tensor, batch: tuple[int, ...]) -> Tensor:
    """A vector of one state, or one row for each state."""
    if not batch:
        return tensor.contiguous()
    size = tensor.shape[-1]
    return tensor.expand(*batch, size).reshape(-1, size).contiguous()
