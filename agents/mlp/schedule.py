"""A schedule that is a small network over all signals; runs in NumPy, its file needs no pickle."""

import json
import zipfile
from collections.abc import Mapping
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensorless.core.api import SIGNAL_N, SIGNAL_NAMES
from sensorless.errors import UserError
from sensorless.files import write_atomic
from sensorless.policy import NO_SETTINGS, Settings
from sensorless.table.ks_table import KsTable

Floats = NDArray[np.float32]

BOUND = 3.0
"""The network sees signals multiplied by SCALE and clipped to +-BOUND."""
SCALE: Floats = np.array([0.1 if n == "acceleration" else 1.0 for n in SIGNAL_NAMES], np.float32)
"""Factors of the signals; see BOUND."""
MARGIN = 0.02
"""How far beyond [0, 1] a start of 0 or 1 lies before the network moves it: small jitter of the
network must not turn the injection on."""
ROWS = 32
"""Rows of a matrix product: always as many, so that a row's bits do not depend on the others, and
few, so that the library does not split the product over threads."""
LAYERS = ("w0", "b0", "w1", "b1", "w2", "b2")
"""Names of the arrays: weights (inputs, outputs) and biases of two hidden layers and the output."""


class MlpSchedule:
    """k_s = clip(1/2 + 1/2 ((1 + 2 MARGIN) (2 k_start - 1) + net(y)), 0, 1), net with tanh.

    Parameters
    ----------
    name : str
    start : KsTable
        The schedule that the network corrects.
    layers : mapping
        Arrays of ``LAYERS``, float32.
    provenance : mapping, optional
        Origin of the schedule (JSON types); ``motor_digest`` names its machine.
    """

    sensored = False
    settings: Settings = NO_SETTINGS

    def __init__(
        self,
        name: str,
        start: KsTable,
        layers: Mapping[str, Floats],
        provenance: Mapping[str, Any] | None = None,
    ) -> None:
        self.name, self.start, self.layers = name, start, dict(layers)
        self.provenance: dict[str, Any] = dict(provenance or {})

    def reset(self, n: int) -> None:
        """Nothing to forget."""

    def act(self, obs: Floats) -> Floats:
        """Weights (n,) at signals (n, SIGNAL_N); 1 where a signal is not finite."""
        finite: NDArray[np.bool_] = np.all(np.isfinite(obs), axis=1)
        x = np.clip(np.where(finite[:, None], obs, np.float32(0.0)) * SCALE, -BOUND, BOUND)
        rows = np.zeros((-(-len(x) // ROWS) * ROWS, x.shape[1]), dtype=np.float32)
        rows[: len(x)] = x
        move = np.concatenate([self._net(x) for x in rows.reshape(-1, ROWS, x.shape[1])])[: len(x)]
        start = np.float32(1.0 + 2.0 * MARGIN) * (2.0 * self.start.evaluate(obs) - 1.0)
        k_s = np.clip(0.5 + 0.5 * (start + move), 0.0, 1.0)
        return np.where(finite, k_s, 1.0).astype(np.float32)

    def _net(self, x: Floats) -> Floats:
        """Output (ROWS,) of the network for inputs (ROWS, SIGNAL_N)."""
        p = self.layers
        for a in "01":
            x = np.tanh(_product(x, p[f"w{a}"]) + p[f"b{a}"])
        return np.asarray((_product(x, p["w2"]) + p["b2"])[:, 0])

    def save(self, path: Path, provenance: Mapping[str, Any]) -> None:
        """Write arrays, start and provenance, whole or not at all."""
        texts = {"start": self.start.to_json(), "provenance": json.dumps(dict(provenance))}
        buffer = BytesIO()
        arrays: dict[str, Any] = {**self.layers, **{k: np.array(t) for k, t in texts.items()}}
        np.savez(buffer, **arrays)
        write_atomic(path, buffer.getvalue())

    @classmethod
    def load(cls, path: Path, name: str) -> "MlpSchedule":
        """Read a file that ``save`` wrote.

        Raises
        ------
        UserError
            The file does not exist or is damaged.
        """
        try:
            with np.load(path, allow_pickle=False) as data:
                layers = {k: np.asarray(data[k], dtype=np.float32) for k in LAYERS}
                start, provenance = str(data["start"]), json.loads(str(data["provenance"]))
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
            raise UserError(f"{path}: {error}; restore the file, or train anew") from None
        hidden = layers["b0"].size
        shapes = ((SIGNAL_N, hidden), (hidden,), (hidden, hidden), (hidden,), (hidden, 1), (1,))
        for key, shape in zip(LAYERS, shapes, strict=True):
            if layers[key].shape != shape or not np.isfinite(layers[key]).all():
                raise UserError(f"{path}: {key}: not finite numbers of shape {shape}; train anew")
        return cls(name, KsTable.from_json(start, str(path)), layers, provenance)


def _product(x: Floats, w: Floats) -> Floats:
    """``x @ w`` row by row: in BLAS the bits of a row depend on its place in the block."""
    return np.asarray(np.einsum("ri,io->ro", x, w))
