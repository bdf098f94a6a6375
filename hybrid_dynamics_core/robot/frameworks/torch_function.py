"""A call of a robot as a function of PyTorch that has first derivatives.

Its inputs are tensors of 64 bits on the CPU, which compiled kernels read in place.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import torch
from torch.autograd.function import once_differentiable

from ...ground.arrays import Array
from ...ground.lazy import lazy
from ...kernels.run import Codes, Kernel
from ...programs import Program, kinds
from .calls import Call, CallTracer

Tensor = Any  # torch.Tensor; PyTorch is no dependency of type checks


class CompiledCall:
    """Values and derivatives of a call, by compiled kernels.

    Attributes:
        names: names of its vectors, in order.
    """

    def __init__(self, call: Call, tracer: CallTracer) -> None:
        self._call = call
        self._tracer = tracer
        self.names = (*call.inputs, *tracer.start_names())
        self._program = tracer.program(call)
        self._kernel = tracer.kernel(self._program, call.name)
        self._kernels: dict[str, Kernel] = {}

    @lazy
    def layout(self) -> list[tuple[int, ...]]:
        """Shapes of the results, in order."""
        shapes = dict(self._kernel.layout)
        return [shapes[name] for name in self._call.results]

    @property
    def count(self) -> int:
        """Number of values of all results."""
        return sum(math.prod(shape) for shape in self.layout)

    def values(self, named: Mapping[str, Array]) -> tuple[Array, Codes]:
        """Flat results (..., count), and the kind of the outcome (...)."""
        results, codes = self._run(self._kernel, self._program, named)
        parts = []
        for name, shape in zip(self._call.results, self.layout, strict=True):
            parts.append(results[name].reshape(*codes.shape, math.prod(shape)))
        flat = np.concatenate(parts, axis=-1)
        flat[codes != 0] = np.nan
        return flat, kinds(codes)

    def slopes(self, named: Mapping[str, Array], by: Sequence[str]) -> dict[str, Array]:
        """Derivatives (..., count, size) of the flat results by some inputs.

        They are NaN for states without a result.
        """
        matrices: dict[str, Array] = {}
        for program, results in self._tracer.slope_programs(self._call, by):
            label = f"{self._call.name}_by_{'_'.join(results)}"
            if label not in self._kernels:
                self._kernels[label] = self._tracer.kernel(program, label)
            values, codes = self._run(self._kernels[label], program, named)
            for name, result in results.items():
                size = named[name].shape[-1]
                matrix = values[result].reshape(*codes.shape, self.count, size)
                matrix[codes != 0] = np.nan
                matrices[name] = matrix
        return matrices

    def _run(
        self, kernel: Kernel, program: Program, named: Mapping[str, Array]
    ) -> tuple[dict[str, Array], Codes]:
        values = {**self._tracer.constants, **named}
        return kernel(*[values[name] for name in program.inputs])


class Differentiable(torch.autograd.Function):  # type: ignore[misc]  # PyTorch may be missing
    """The function (call, *vectors) -> flat results, kind of the outcome."""

    @staticmethod
    def forward(context: Any, call: CompiledCall, *vectors: Tensor) -> tuple[Tensor, Tensor]:
        """The call, for vectors (size,) of one state or (N, size); the start may be shared."""
        context.call = call
        context.save_for_backward(*vectors)
        flat, status = call.values(_arrays(call, vectors))
        outcome = torch.from_numpy(status)
        context.mark_non_differentiable(outcome)
        return torch.from_numpy(flat), outcome

    @staticmethod
    @once_differentiable  # type: ignore[untyped-decorator]
    def backward(context: Any, slope_of_flat: Tensor, _: Tensor) -> tuple[Tensor | None, ...]:
        """The gradient by each vector, None where none is asked for."""
        call: CompiledCall = context.call
        needed = zip(call.names, context.needs_input_grad[1:], strict=True)
        by = [name for name, is_needed in needed if is_needed]
        slopes = call.slopes(_arrays(call, context.saved_tensors), by)
        gradients: list[Tensor | None] = [None]
        for name in call.names:
            slope = slopes.get(name)
            gradient = None
            if slope is not None:
                gradient = (slope_of_flat[..., None] * torch.from_numpy(slope)).sum(-2)
            gradients.append(gradient)
        return tuple(gradients)


def _arrays(call: CompiledCall, vectors: Sequence[Tensor]) -> dict[str, Array]:
    """The memory of vectors, by name."""
    named: dict[str, Array] = {}
    for name, vector in zip(call.names, vectors, strict=True):
        named[name] = np.asarray(np.from_dlpack(vector.detach()), dtype=np.float64)
    return named
