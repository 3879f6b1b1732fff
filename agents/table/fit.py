"""Least-squares fit of a table's nodes, smooth where there is little data."""

import numpy as np
import torch
from numpy.typing import NDArray
from scipy import sparse
from scipy.optimize import minimize

from sensorless.agents.table.module import TableModule
from sensorless.table.ks_table import Axis, KsTable
from sensorless.table.standstill import even_at_standstill

Floats = NDArray[np.float64]

SNAP = 0.05
"""Nodes this near to 0 or 1 are set to 0 or 1: a trace of k_s left by the fit would keep the
injection running for nothing."""


class TableFit:
    """Least-squares problem that grows with its samples: node values for wanted k_s at signals.

    It minimises over node values v in [0, 1], with w_i the weights of the corners at sample i:

        sum_i (w_i v - k_i)^2 / n + smoothness / N sum (second differences of v along every axis)^2

    Parameters
    ----------
    axes : tuple of Axis
    smoothness : float
        Weight of the second differences.
    """

    def __init__(self, axes: tuple[Axis, ...], smoothness: float) -> None:
        self._table = KsTable(axes, np.zeros([a.n for a in axes], dtype=np.float32))
        self._module = TableModule(self._table)
        size = self._table.values.size
        self._square, self._right = np.zeros((size, size)), np.zeros(size)
        self._n = 0
        self._rough = smoothness / size * roughness(self._table.values.shape)

    def add(self, obs: NDArray[np.float32], k_s: NDArray[np.float32]) -> None:
        """Add samples: signals (n, SIGNAL_N), all finite, and weights wanted (n,)."""
        nodes, frac, _ = self._module.corners(torch.from_numpy(obs))
        weights = self._module.weights(frac).double().numpy()
        rows = np.repeat(np.arange(len(obs)), weights.shape[1])
        shape = len(obs), len(self._right)
        w = sparse.csr_array((weights.ravel(), (rows, nodes.numpy().ravel())), shape=shape)
        self._square += (w.T @ w).toarray()
        self._right += w.T @ k_s.astype(np.float64)
        self._n += len(obs)

    def solve(self, slew_per_s: float) -> KsTable:
        """Return the best table for the samples so far, snapped to 0 and 1 (``SNAP``).

        At standstill it is even.
        """
        count = max(self._n, 1)
        a, b = self._square / count + self._rough, self._right / count

        def cost(v: Floats) -> tuple[float, Floats]:
            slope = a @ v - b
            return float(0.5 * v @ (slope - b)), slope

        start = np.full(len(b), 0.5)
        found = minimize(
            cost, start, jac=True, method="L-BFGS-B", bounds=[(0.0, 1.0)] * len(b),
            options={"maxiter": 1000, "maxfun": 2000, "ftol": 1e-14, "gtol": 1e-8, "maxcor": 50},
        )  # fmt: skip
        v = np.where(found.x < SNAP, 0.0, np.where(found.x > 1.0 - SNAP, 1.0, found.x))
        values = v.astype(np.float32).reshape(self._table.values.shape)
        axes = self._table.axes
        return KsTable(axes, even_at_standstill(values, axes), slew_per_s=slew_per_s)


def roughness(shape: tuple[int, ...]) -> Floats:
    """Matrix (N, N) of the sum of squared second differences along every axis of a grid."""
    total = np.zeros((int(np.prod(shape)),) * 2)
    for a, n in enumerate(shape):
        second = np.diff(np.eye(n), n=2, axis=0) if n > 2 else np.diff(np.eye(n), axis=0)
        before, after = int(np.prod(shape[:a])), int(np.prod(shape[a + 1 :]))
        total += np.kron(np.kron(np.eye(before), second.T @ second), np.eye(after))
    return total
