"""The schedule table as a torch module: its node values are the parameters that PPO trains."""

from dataclasses import replace

import numpy as np
import torch
from torch import Tensor, nn

from sensorless.agents.table.start import MARGIN
from sensorless.core.api import SIGNAL_NAMES
from sensorless.table.ks_table import KsTable
from sensorless.table.standstill import turned_round


class TableModule(nn.Module):
    """Multilinear interpolation over evenly spaced, clipped axes, as in ``core/drive/ks_table.c``.

    It does the same float32 operations in the same order: ``forward`` equals ``KsTable.evaluate``
    of ``table()`` to the bit, and so does the start.

    ``values`` are the node values without squashing. They are clipped to [0, 1] where they are
    read, but their gradient is that without clipping. ``project`` keeps them within ``margin`` of
    that range after a step of the optimiser, so no gradient dies. A node at a bound starts
    ``margin`` beyond it, so that exploration does not lift it off: at 0 any higher k_s turns the
    injection on, and at 1 the other estimator may have no signal at all. Noise that does either
    trains a schedule for the noise.

    Parameters
    ----------
    table : KsTable
        Axes and start values.
    margin : float
        How far node values may lie outside [0, 1].
    """

    x0: Tensor
    inv_step: Tensor
    last: Tensor

    def __init__(self, table: KsTable, margin: float = MARGIN) -> None:
        super().__init__()
        axes = table.axes
        self._table, self._margin = table, margin
        self.shape = tuple(axis.n for axis in axes)
        self._columns = [SIGNAL_NAMES.index(axis.signal) for axis in axes]
        self._strides = [int(np.prod(self.shape[a + 1 :])) for a in range(len(axes))]
        self._turned = torch.from_numpy(turned_round(axes))
        k_s = torch.tensor(table.values.reshape(-1))
        beyond = margin * ((k_s >= 1.0).float() - (k_s <= 0.0).float())
        self.values = nn.Parameter(k_s + beyond)
        grids = [torch.tensor(grid.values.reshape(-1)) for grid in table.gains]
        self.gains = nn.Parameter(torch.stack(grids)) if grids else None
        """Values of the gains (m, nodes), in their bounds"""
        limits = [grid.range.limits(1.0) for grid in table.gains]
        self._bounds = [(x["least"], x["most"]) for x in limits]
        for name, numbers in {
            "x0": [axis.lo for axis in axes],
            "inv_step": [float(axis.inv_step) for axis in axes],
            "last": [axis.n - 1 for axis in axes],
        }.items():
            self.register_buffer(name, torch.tensor(numbers, dtype=torch.float32), persistent=False)

    def corners(self, obs: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Cells that observations (n, at least SIGNAL_N) fall into.

        Returns
        -------
        nodes (n, 2^axes) int64
            The cell's corners; bit a of a corner's number says whether it is the upper node of
            axis a.
        frac (n, axes)
            Place inside the cell, 0 to 1.
        finite (n,) bool
            Whether all signals of the axes are finite.
        """
        y = obs[:, self._columns]
        finite = torch.isfinite(y).all(dim=1)
        pos = ((torch.nan_to_num(y) - self.x0) * self.inv_step).clamp(min=0.0).minimum(self.last)
        low = pos.trunc().minimum(self.last - 1.0)
        nodes = (low.to(torch.int64) * torch.tensor(self._strides)).sum(dim=1, keepdim=True)
        for stride in self._strides:
            nodes = torch.cat((nodes, nodes + stride), dim=1)
        return nodes, pos - low, finite

    def at(self, nodes: Tensor, frac: Tensor, finite: Tensor) -> Tensor:
        """k_s (n,) at places from ``corners``; the table's fallback if a signal is not finite."""
        nodes_k_s = self.values.detach().clamp(0.0, 1.0) + (self.values - self.values.detach())
        k_s = self.mixed(nodes_k_s.take(nodes), frac).clamp(0.0, 1.0)
        return torch.where(finite, k_s, torch.full_like(k_s, self._table.fallback))

    def centre(self, nodes: Tensor, frac: Tensor, finite: Tensor) -> Tensor:
        """Centre of the exploration (n,): k_s, or up to ``margin`` beyond 0 and 1.

        It lies beyond where all corners are 0, or all are 1: there the values count unclipped.
        """
        k_s = self.at(nodes, frac, finite)
        beyond = self.mixed(self.values.take(nodes), frac)
        return torch.where(finite & ((k_s <= 0.0) | (k_s >= 1.0)), beyond, k_s)

    @property
    def outputs(self) -> int:
        """Numbers of an action: k_s, then the gains."""
        return 1 + len(self._table.gains)

    def action(self, nodes: Tensor, frac: Tensor, finite: Tensor) -> Tensor:
        """Centre of the exploration as an action (n, outputs): 2 k_s - 1, then the gains."""
        mean = 2.0 * self.centre(nodes, frac, finite)[:, None] - 1.0
        if self.gains is None:
            return mean
        values = [self.mixed(grid.take(nodes), frac)[:, None] for grid in self.gains]
        return torch.cat((mean, *values), dim=1)

    def mixed(self, value: Tensor, frac: Tensor) -> Tensor:
        """Interpolate (n,) between the values (n, 2^axes) of the corners."""
        for a in reversed(range(len(self.shape))):
            half = 1 << a
            low = value[:, :half]
            value = low + frac[:, a : a + 1] * (value[:, half:] - low)
        return value[:, 0]

    def forward(self, obs: Tensor) -> Tensor:
        """k_s (n,) at observations (n, at least SIGNAL_N)."""
        return self.at(*self.corners(obs))

    @staticmethod
    def weights(frac: Tensor) -> Tensor:
        """Weights (n, 2^axes) of the corners in the interpolation; their sum is 1."""
        out = torch.ones_like(frac[:, :1])
        for upper in frac.split(1, dim=1):
            out = torch.cat((out * (1.0 - upper), out * upper), dim=1)
        return out

    @torch.no_grad()
    def project(self) -> None:
        """Move node values back into their range, and make them even at standstill."""
        self.values.clamp_(-self._margin, 1.0 + self._margin)
        if self.gains is not None:
            for values, (low, high) in zip(self.gains, self._bounds, strict=True):
                values.clamp_(low, high)
        for values in (self.values, *(() if self.gains is None else self.gains)):
            values.copy_(0.5 * (values + values[self._turned]))

    def vector(self) -> Tensor:
        """Copy of all node values, k_s first."""
        parts = [self.values] if self.gains is None else [self.values, self.gains.reshape(-1)]
        return torch.cat([part.detach() for part in parts])

    def table(self, vector: Tensor | None = None) -> KsTable:
        """Return the table with the present values, or with those of a ``vector``."""
        given = self.vector() if vector is None else vector
        k_s, *gains = given.split(self.values.numel())
        grids = tuple(
            replace(grid, values=v.clamp(least, most).numpy().reshape(self.shape).copy())
            for grid, v, (least, most) in zip(self._table.gains, gains, self._bounds, strict=True)
        )
        nodes = k_s.clamp(0.0, 1.0).numpy().reshape(self.shape).copy()
        return replace(self._table, values=nodes, gains=grids)
