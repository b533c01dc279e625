"""A constant sparse matrix as a part of a network."""

from __future__ import annotations

import warnings
from typing import Any

import torch
from scipy.sparse import csr_array
from torch import Tensor, nn


class SparseMap(nn.Module):
    """A sparse matrix (m, n) that multiplies the first axis of a tensor (n, ...); it is not learned.

    Its numbers are dense buffers, which move between devices and into checkpoints as any others do, and it is kept
    beside its transpose, so that gradients need none.
    """

    def __init__(self, matrix: csr_array) -> None:
        super().__init__()
        self.shape = (int(matrix.shape[0]), int(matrix.shape[1]))
        for name, one in (("forward", matrix), ("back", csr_array(matrix.T.tocsr()))):
            for part, values in (("pointer", one.indptr), ("index", one.indices), ("value", one.data)):
                kept = torch.as_tensor(values, dtype=torch.float32 if part == "value" else torch.int64)
                self.register_buffer(f"{name}_{part}", kept, persistent=False)
        with warnings.catch_warnings():
            # once in a process PyTorch says that its CSR tensors are young
            warnings.filterwarnings("ignore", message="Sparse CSR tensor support")
            self._matrix("forward")

    def forward(self, values: Tensor) -> Tensor:
        """The product (m, ...) with values (n, ...)."""
        flat = values.reshape(values.shape[0], -1)
        product: Tensor = _Multiply.apply(flat, self._matrix("forward"), self._matrix("back"))
        return product.reshape(self.shape[0], *values.shape[1:])

    def _matrix(self, name: str) -> Tensor:
        pointer, index, value = (getattr(self, f"{name}_{part}") for part in ("pointer", "index", "value"))
        size = self.shape if name == "forward" else self.shape[::-1]
        return torch.sparse_csr_tensor(pointer, index, value, size=size, check_invariants=False)


class _Multiply(torch.autograd.Function):
    """In the matrix's precision, whatever is used around it: sparse products know no bfloat16 on every device."""

    @staticmethod
    def forward(context: Any, values: Tensor, matrix: Tensor, transposed: Tensor) -> Tensor:
        context.transposed, context.precision = transposed, values.dtype
        with torch.autocast(values.device.type, enabled=False):
            return matrix @ values.to(matrix.dtype)

    @staticmethod
    def backward(context: Any, gradient: Tensor) -> tuple[Tensor, None, None]:
        with torch.autocast(gradient.device.type, enabled=False):
            product = context.transposed @ gradient.to(context.transposed.dtype).contiguous()
        return product.to(context.precision), None, None
