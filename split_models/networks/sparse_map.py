"""A constant sparse matrix as a layer of a network."""

from __future__ import annotations

import warnings
from typing import Any

import torch
from scipy.sparse import csr_array
from torch import Tensor, nn


class SparseMap(nn.Module):
    """A constant sparse matrix (m, n) that multiplies the first axis of a tensor (n, ...); it is not trained.

    Its numbers are dense buffers, which move between devices with the network. Its transpose is kept as well, for the
    gradient.
    """

    def __init__(self, matrix: csr_array) -> None:
        super().__init__()
        self.shape = (int(matrix.shape[0]), int(matrix.shape[1]))
        for name, sparse in (("forward", matrix), ("back", csr_array(matrix.T.tocsr()))):
            for part, values in (("pointer", sparse.indptr), ("index", sparse.indices), ("value", sparse.data)):
                buffer = torch.as_tensor(values, dtype=torch.float32 if part == "value" else torch.int64)
                self.register_buffer(f"{name}_{part}", buffer, persistent=False)
        with warnings.catch_warnings():
            # PyTorch warns once in a process that its CSR tensors are in beta
            warnings.filterwarnings("ignore", message="Sparse CSR tensor support")
            self._matrix("forward")

    def forward(self, values: Tensor) -> Tensor:
        """The product (m, ...) with values (n, ...)."""
        flat = values.reshape(values.shape[0], -1)
        product: Tensor = _Multiply.apply(flat, self._matrix("forward"), self._matrix("back"))
        return product.reshape(self.shape[0], *values.shape[1:])

    def _matrix(self, name: str) -> Tensor:
        """The matrix (``forward``) or its transpose (``back``) as a CSR tensor of the buffers."""
        pointer, index, value = (getattr(self, f"{name}_{part}") for part in ("pointer", "index", "value"))
        size = self.shape if name == "forward" else self.shape[::-1]
        return torch.sparse_csr_tensor(pointer, index, value, size=size, check_invariants=False)


class _Multiply(torch.autograd.Function):
    """Sparse product with gradient, in the matrix's precision: not every device multiplies sparse bfloat16 matrices."""

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
