"""Correlation between the nodes of a table, which falls with their distance."""

import math
from collections.abc import Sequence

import torch
from torch import Tensor


class NodeKernel:
    """Correlation between nodes of a grid: exp(-(i - j)^2 / (2 length^2)) along every axis.

    Parameters
    ----------
    shape : sequence of int
        Nodes of each axis.
    length : float
        Distance over which nodes move together [nodes]; 0 for independent nodes.
    """

    def __init__(self, shape: Sequence[int], length: float) -> None:
        self.shape = tuple(shape)
        self._matrices = [self._matrix(n, length) for n in shape]
        self._factors = [
            torch.linalg.cholesky(c + 1e-4 * torch.eye(len(c))) for c in self._matrices
        ]
        self._neighbours = math.exp(-0.5 / length**2) if length > 0.0 else 0.0

    @staticmethod
    def _matrix(n: int, length: float) -> Tensor:
        if length == 0.0:
            return torch.eye(n)
        at = torch.arange(n, dtype=torch.float32)
        return torch.exp(-0.5 * ((at[:, None] - at) / length) ** 2)

    def spread(self, frac: Tensor) -> Tensor:
        """Standard deviation (n, 1) of an interpolation at ``frac`` between unit-variance nodes."""
        rest = 1.0 - frac
        variance = frac.square() + rest.square() + 2.0 * self._neighbours * frac * rest
        return variance.prod(dim=1, keepdim=True).sqrt()

    def sample(self, n: int) -> Tensor:
        """Draw n fields of unit variance (n, nodes)."""
        return self._apply(self._factors, torch.randn(n, *self.shape)).reshape(n, -1)

    def smooth(self, nodes: Tensor) -> Tensor:
        """Correlation matrix times a vector of nodes."""
        return self._apply(self._matrices, nodes.reshape(1, *self.shape)).reshape(-1)

    @staticmethod
    def _apply(matrices: list[Tensor], grid: Tensor) -> Tensor:
        """Multiply every axis except the first by its matrix."""
        for a, matrix in enumerate(matrices):
            grid = torch.movedim(torch.tensordot(grid, matrix, dims=([a + 1], [1])), -1, a + 1)
        return grid
