"""Fit of the saturation model to a flux map: coefficients by least squares, exponents by search.

For given exponents the model of ``core/sim/flux_map.h`` is linear in all coefficients except three
of its bridge term (a_bp, k_q, psi_n). Non-linear least squares finds these three; each of its steps
solves non-negative linear least squares for the others. The search then moves one exponent at a
time as long as that helps. The error is that of the current at the map's flux linkages.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares, nnls

from sensorless.errors import UserError
from sensorless.machine.magnetics import Floats, cross_term, currents, flux, inverse_inductance
from sensorless.machine.motor import Saturation

EXPONENTS = {"S": 7, "T": 7, "U": 5, "V": 5, "W": 6}
"""Largest exponents tried; the smallest is 0 in the cross term (U, V) and 1 elsewhere."""
STARTS = ((4, 5, 1, 1, 1), (4, 6, 1, 1, 2), (4, 1, 0, 0, 2))
"""Exponents to start from: those of published fits (doi 10.1109/ICEM60801.2024.10700403)."""
SHAPES = tuple((a, k, n) for a in (1.0, 10.0) for k in (0.05, 0.2) for n in (0.7, 1.0))
"""a_bp, k_q, psi_n to start from, with fluxes over the map's largest."""
OUTSIDE = 0.5
"""Weight of points between rated and largest current; points within rated have 1."""
NOTHING = 1e-5
"""Share of the largest current below which a term is left out."""
LEAST = 1e-3
"""Least slope of the linear terms over the map's mean slope; keeps the model invertible."""


@dataclass(frozen=True)
class MapFit:
    """A fitted model and its errors."""

    saturation: Saturation
    i: Floats
    """(n, 2) currents of the map [A]"""
    psi: Floats
    """(n, 2) flux linkages of the map [Vs]"""
    error: Floats
    """(n, 2) current of the model minus that of the map [A]"""
    i_rated: float
    i_max: float

    def inside(self, limit: float) -> Floats:
        """(n,) whether a point lies within a current [A]."""
        return np.asarray(np.hypot(*self.i.T) <= (1.0 + 1e-9) * limit)

    def rms_percent(self, limit: float) -> tuple[float, float]:
        """RMS of the errors of i_d and i_q within a current [A], in % of rated current."""
        rows = self.error[self.inside(limit)]
        d, q = 100.0 * np.sqrt(np.mean(rows**2, axis=0)) / self.i_rated
        return float(d), float(q)

    def max_percent(self, limit: float) -> float:
        """Largest error of a current within ``limit`` [A], in % of rated current."""
        return float(100.0 * np.abs(self.error[self.inside(limit)]).max() / self.i_rated)


def fit_map(i: Floats, psi: Floats, i_rated: float, i_max: float) -> MapFit:
    """Fit the model to the points of a map within ``i_max`` [A].

    Raises
    ------
    UserError
        The map has too few points within ``i_max``, a flux in it does not rise with its current, or
        the model has no inverse up to it.
    """
    size = np.hypot(*i.T)
    use = size <= (1.0 + 1e-9) * i_max
    if np.sum(use) < 20 or size[use].max() < 0.7 * i_rated:
        raise UserError(
            f"map: {int(use.sum())} points up to {size[use].max(initial=0.0):g} A within i_max = "
            f"{i_max:g} A; give at least 20, up to rated current"
        )
    _require_rise(i[use], psi[use])
    weight = np.where(size[use] <= i_rated, 1.0, OUTSIDE)
    scale = float(np.abs(psi[use]).max())
    data = _Data(i[use], psi[use] / scale, weight)
    best: tuple[float, _Trial] | None = None
    for start in STARTS:
        found = _descend(data, list(start))
        if best is None or found[0] < best[0]:
            best = found
    assert best is not None
    saturation = _unscaled(best[1], scale)
    _require_inverse(saturation, i[use])
    return MapFit(saturation, i, psi, currents(saturation, psi) - i, i_rated, i_max)


@dataclass(frozen=True)
class _Data:
    i: Floats
    psi: Floats
    """over the largest of the map"""
    weight: Floats


@dataclass(frozen=True)
class _Trial:
    exponents: tuple[int, ...]
    shape: Floats
    """a_bp, k_q, psi_n"""
    linear: Floats
    """a_d0, i_f, a_dd, a_q0, a_qq, a_dq, a_b"""


def _descend(data: _Data, exponents: list[int]) -> tuple[float, _Trial]:
    """Change one exponent at a time, as long as that helps."""
    cost, trial = _fit(data, exponents, SHAPES)
    known: set[tuple[object, ...]] = set()
    moved = True
    while moved:
        moved = False
        for k, (name, top) in enumerate(EXPONENTS.items()):
            for value in range(int(name in "STW"), top + 1):
                tried = list(trial.exponents)
                if tried[k] == value:
                    continue
                tried[k] = value
                start = (*tried, *trial.shape)
                if start in known:  # no better than what is now the best
                    continue
                known.add(start)
                found = _fit(data, tried, [tuple(trial.shape)])
                if found[0] < 0.9999 * cost:
                    (cost, trial), moved = found, True
    final = _fit(data, list(trial.exponents), [*SHAPES, tuple(trial.shape)])
    return min((cost, trial), final, key=lambda x: x[0])


def _fit(
    data: _Data, exponents: Sequence[int], shapes: Sequence[tuple[float, ...]]
) -> tuple[float, _Trial]:
    """Best coefficients for these exponents, starting from each of the bridge's shapes."""
    parts = _parts(data.psi, exponents)
    both = np.r_[data.weight, data.weight]
    matrix = both[:, None] * np.c_[parts, np.zeros(len(both))]
    largest = np.abs(matrix).max(axis=0)
    wanted = both * np.r_[data.i[:, 0], data.i[:, 1]]
    floor = np.zeros(7)
    for k, axis in ((0, 0), (3, 1)):
        floor[k] = LEAST * np.ptp(data.i[:, axis]) / np.ptp(data.psi[:, axis])

    def linear(log_shape: Floats) -> tuple[Floats, Floats]:
        a_bp, k_q, psi_n = np.exp(log_shape)
        n = data.psi[:, 0] - psi_n
        s_w = np.sqrt(n * n + k_q * data.psi[:, 1] ** 2) ** exponents[4]
        g = s_w / (1.0 + a_bp * s_w)
        bridge = np.concatenate([g * n, k_q * g * data.psi[:, 1]])
        matrix[:, 6] = both * bridge
        largest[6] = np.abs(matrix[:, 6]).max()
        x = floor + nnls(matrix, wanted - matrix @ floor)[0]
        small = largest * x < NOTHING * np.abs(wanted).max()
        x = np.where(small, floor, x)
        return x, matrix @ x - wanted

    found = []
    for shape in shapes:
        bounds = np.log(np.array([[1e-3, 1e-3, 0.05], [1e3, 2.0, 2.0]]))
        at = np.clip(np.log(shape), bounds[0] + 1e-6, bounds[1] - 1e-6)
        r = least_squares(lambda x: linear(x)[1], at, bounds=tuple(bounds), max_nfev=20)
        found.append((float(r.cost), _Trial(tuple(exponents), np.exp(r.x), linear(r.x)[0])))
    return min(found, key=lambda x: x[0])


def _parts(psi: Floats, exponents: Sequence[int]) -> Floats:
    """Matrix of the linear terms: columns a_d0, i_f, a_dd, a_q0, a_qq, a_dq; rows i_d, then i_q."""
    S, T, U, V = exponents[:4]
    d, q = psi.T
    ad, aq, zero = np.abs(d), np.abs(q), np.zeros(len(psi))
    cross_d, cross_q = cross_term(psi, U, V)
    of_d = [d, -np.ones(len(psi)), ad**S * d, zero, zero, cross_d]
    of_q = [zero, zero, zero, q, aq**T * q, cross_q]
    return np.concatenate([np.stack(of_d, axis=1), np.stack(of_q, axis=1)])


def _unscaled(t: _Trial, scale: float) -> Saturation:
    """Model for fluxes in Vs, from one for scaled fluxes."""
    S, T, U, V, W = t.exponents
    a_d0, i_f, a_dd, a_q0, a_qq, a_dq, a_b = (float(x) for x in t.linear)
    a_bp, k_q, psi_n = (float(x) for x in t.shape)
    return Saturation(
        a_d0=a_d0 / scale, a_dd=a_dd / scale ** (S + 1), S=S, i_f=i_f,
        a_q0=a_q0 / scale, a_qq=a_qq / scale ** (T + 1), T=T,
        a_dq=a_dq / scale ** (U + V + 3), U=U, V=V,
        a_b=a_b / scale ** (W + 1), a_bp=a_bp / scale**W if a_b else 0.0,
        k_q=k_q if a_b else 0.0, psi_n=psi_n * scale if a_b else 0.0, W=W if a_b else 0,
    )  # fmt: skip


def _require_rise(i: Floats, psi: Floats) -> None:
    together = np.mean((i - i.mean(axis=0)) * (psi - psi.mean(axis=0)), axis=0)
    for axis, rise in zip("dq", together, strict=True):
        if not rise > 0.0:
            raise UserError(
                f"map: psi_{axis} does not rise with i_{axis}; give points at several i_{axis}, "
                "and check names and signs of the columns"
            )


def _require_inverse(s: Saturation, i: Floats) -> None:
    try:
        low = np.linalg.eigvalsh(inverse_inductance(s, flux(s, i)))[:, 0].min()
    except UserError:
        low = -np.inf
    if low <= 0.0:
        raise UserError(
            "map: the fitted model has no inverse within i_max; check units and signs of the map, "
            "or lower i_max"
        )
