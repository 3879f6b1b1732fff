"""The schedule table as a torch module: its node values are the parameters that PPO trains."""

from dataclasses import replace

import numpy as np
import torch
from torch import Tensor, nn

from sensorless.core_api import SIGNAL_NAMES
from sensorless.ks_table import KsTable


class TableModule(nn.Module):
    """Multilinear interpolation over evenly spaced, clipped axes, as ``core/ks_table.c`` does it.

    The same float32 operations in the same order: ``forward`` equals ``KsTable.evaluate`` to the
    bit. ``values`` holds k_s at the nodes themselves (no squashing), so that a start is exact and
    the trained table is the exported one; ``project`` takes them back to [0, 1] after a step of the
    optimiser (projected gradient), which leaves the gradient alive at the bounds.

    Parameters
    ----------
    table : KsTable
        Axes and start values.
    """

    start: Tensor
    x0: Tensor
    inv_step: Tensor
    last: Tensor

    def __init__(self, table: KsTable) -> None:
        super().__init__()
        record = table.record()
        axes = record["axis"][: len(table.axes)]
        self._table = table
        self.shape = tuple(axis.n for axis in table.axes)
        self.columns = [SIGNAL_NAMES.index(axis.signal) for axis in table.axes]
        self.strides = [int(np.prod(self.shape[a + 1 :])) for a in range(len(self.shape))]
        self.values = nn.Parameter(torch.tensor(table.values.reshape(-1), dtype=torch.float32))
        self.register_buffer("start", self.values.detach().clone())
        self.register_buffer("x0", torch.tensor(axes["x0"]), persistent=False)
        self.register_buffer("inv_step", torch.tensor(axes["inv_step"]), persistent=False)
        last = torch.tensor(self.shape, dtype=torch.float32) - 1.0
        self.register_buffer("last", last, persistent=False)

    def corners(self, obs: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Where observations fall: the cell's corner nodes, the place inside of it, and whether all
        signals are finite.

        Returns
        -------
        nodes (n, 2^axes) int64, frac (n, axes), finite (n,) bool
            Bit a of a corner's number says whether it is the upper node of axis a.
        """
        y = obs[:, self.columns]
        finite = torch.isfinite(y).all(dim=1)
        y = torch.nan_to_num(y, nan=0.0)
        pos = ((y - self.x0) * self.inv_step).clamp(min=0.0).minimum(self.last)
        low = pos.trunc().minimum(self.last - 1.0)
        index = low.to(torch.int64)
        nodes = (index * torch.tensor(self.strides)).sum(dim=1, keepdim=True)
        for stride in self.strides:
            nodes = torch.cat((nodes, nodes + stride), dim=1)
        return nodes, pos - low, finite

    def interpolate(self, corner: Tensor, frac: Tensor) -> Tensor:
        """Value (n,) from corner values (n, 2^axes), highest axis first."""
        for a in reversed(range(len(self.shape))):
            half = 1 << a
            low = corner[:, :half]
            corner = low + frac[:, a : a + 1] * (corner[:, half:] - low)
        return corner[:, 0]

    def at(self, nodes: Tensor, frac: Tensor, finite: Tensor) -> Tensor:
        """k_s (n,) where ``corners`` says."""
        k_s = self.interpolate(self.values.take(nodes), frac).clamp(0.0, 1.0)
        return torch.where(finite, k_s, torch.full_like(k_s, self._table.fallback))

    def forward(self, obs: Tensor) -> Tensor:
        """k_s (n,) at observations (n, at least SIGNAL_N); the fallback where one is not finite."""
        return self.at(*self.corners(obs))

    def weights(self, frac: Tensor) -> Tensor:
        """Weights (n, 2^axes) of the corner nodes; they add up to 1."""
        out = torch.ones_like(frac[:, :1])
        for a in range(frac.shape[1]):
            upper = frac[:, a : a + 1]
            out = torch.cat((out * (1.0 - upper), out * upper), dim=1)
        return out

    def roughness(self) -> Tensor:
        """Half the squared second differences of the change since the start, along every axis."""
        grid = (self.values - self.start).reshape(self.shape)
        out = torch.zeros(())
        for a, n in enumerate(self.shape):
            if n > 2:
                out = out + 0.5 * torch.diff(grid, n=2, dim=a).square().sum()
        return out

    def relax(self, share: float) -> None:
        """One step down the roughness of the table's change since the start."""
        grad = torch.autograd.grad(self.roughness(), self.values)[0]
        with torch.no_grad():
            self.values.sub_(share * grad)

    @torch.no_grad()
    def project(self) -> None:
        """Node values back into [0, 1]."""
        self.values.clamp_(0.0, 1.0)

    def table(self) -> KsTable:
        """Return the table as it stands."""
        values = self.values.detach().numpy().reshape(self.shape).copy()
        return replace(self._table, values=values)
