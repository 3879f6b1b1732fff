"""Saturation model of measured flux linkages: as few terms as explain them.

The model is that of ``core/sim/flux_map.h`` without bridges, with the magnet flux given, so that
i_f follows from it. For given exponents it is linear in its coefficients, none of them negative.
Every set of exponents is tried, with and without each saturation term; a term has to earn its place
(Bayesian information criterion). The general fit of a flux map, with bridges, takes over where it
halves the error.
"""

import itertools

import numpy as np
from scipy.optimize import nnls

from sensorless.errors import UserError
from sensorless.identify.machine.electric import parts
from sensorless.identify.machine.equations import COVERED
from sensorless.identify.machine.pulses import Samples
from sensorless.machine.magnetics import Floats, cross_term, currents
from sensorless.machine.map_fit import MapFit, fit_map
from sensorless.machine.motor import Saturation

CROSS: tuple[tuple[int, int] | None, ...] = (None, *itertools.product(range(4), range(3)))
"""Exponents U and V of the cross term; None: no such term."""
PENALTY = 4.0
"""Weight of the criterion's penalty: neighbouring samples share their errors."""
GOOD = 2.5
"""RMS error of a current over rated that needs no bridges [%]."""
LEAST = 1e-3
"""Least linear terms, currents over rated and fluxes over the magnet's: keeps an inverse."""
POINTS = 160
"""Samples for the general fit, at most."""


def fit_model(s: Samples, psi_f: float, i_rated: float) -> MapFit:
    """Model of samples, and its errors.

    Raises
    ------
    UserError
        The magnet flux is not positive, or a model has no inverse.
    """
    if psi_f <= 0.0:
        raise UserError(f"magnet: {psi_f:.3g} Vs found; check the phase order")
    i, psi = parts(s.i), parts(psi_f + s.psi)
    inside = np.hypot(*i.T) <= COVERED * i_rated
    i, psi = i[inside], psi[inside]
    simple = _judged(_simple(i / i_rated, psi / psi_f, psi_f, i_rated), i, psi, i_rated)
    worst = max(simple.rms_percent(i_rated))
    if worst <= GOOD:
        return simple
    step = max(1, len(i) // POINTS)
    try:
        general = fit_map(i[::step], psi[::step], i_rated, 1.3 * i_rated)
    except UserError:
        return simple
    general = _judged(general.saturation, i, psi, i_rated)
    return general if max(general.rms_percent(i_rated)) < 0.5 * worst else simple


def _judged(model: Saturation, i: Floats, psi: Floats, i_rated: float) -> MapFit:
    return MapFit(model, i, psi, currents(model, psi) - i, i_rated, 1.3 * i_rated)


def _simple(i: Floats, psi: Floats, psi_f: float, i_rated: float) -> Saturation:
    """Best model by the criterion; currents over rated, fluxes over the magnet's.

    One triangle of all columns stands for the samples: least squares over some of its columns is
    that over those of the samples. What was measured is flux: an error of it is one of current over
    the axis' inductance, so rows weigh by that inductance, and q is not judged by the noise of d.
    """
    places, columns = _columns(psi)
    slopes = [np.ptp(psi[:, axis]) / np.ptp(i[:, axis]) for axis in (0, 1)]
    weight = np.repeat(slopes, len(i))[:, None]
    rows = weight * np.c_[columns, np.r_[i[:, 0], i[:, 1]]]
    both: Floats = np.asarray(np.linalg.qr(rows, mode="r"))
    best: tuple[float, tuple[int, int, tuple[int, int] | None], Floats] | None = None
    for S, T, cross in itertools.product(range(8), range(8), CROSS):
        use = [0, 1, *(places[k] for k in (("S", S), ("T", T), ("cross", cross)) if k in places)]
        x, norm = _least(both[:, [*use, -1]])
        score = len(i) * np.log(norm**2) + PENALTY * np.log(len(i)) * len(use)
        if best is None or score < best[0]:
            best = (float(score), (S, T, cross), x)
    assert best is not None
    S, T, cross = best[1]
    a_d0, a_q0, *more = best[2].tolist()
    a_dd = more.pop(0) if S else 0.0
    a_qq = more.pop(0) if T else 0.0
    a_dq = more.pop(0) if cross else 0.0
    U, V = cross or (0, 0)
    unit = i_rated / psi_f
    return Saturation(
        a_d0=a_d0 * unit, a_q0=a_q0 * unit,
        i_f=(a_d0 + a_dd) * i_rated,
        a_dd=a_dd * unit / psi_f**S, S=S, a_qq=a_qq * unit / psi_f**T, T=T,
        a_dq=a_dq * unit / psi_f ** (U + V + 2), U=U, V=V,
    )  # fmt: skip


def _columns(psi: Floats) -> tuple[dict[tuple[str, object], int], Floats]:
    """Columns of all terms, and which is whose: a_d0, a_q0, a_dd by S, a_qq by T, a_dq by U and V.

    Rows are i_d, then i_q.
    """
    d, q = psi.T
    ad, aq, zero = np.abs(d), np.abs(q), np.zeros(len(psi))
    columns = [np.r_[d - 1.0, zero], np.r_[zero, q]]
    places: dict[tuple[str, object], int] = {}
    for n in range(1, 8):
        places["S", n] = len(columns)
        columns.append(np.r_[ad**n * d - 1.0, zero])
        places["T", n] = len(columns)
        columns.append(np.r_[zero, aq**n * q])
    for U, V in filter(None, CROSS):
        places["cross", (U, V)] = len(columns)
        columns.append(np.concatenate(cross_term(psi, U, V)))
    return places, np.stack(columns, axis=-1)


def _least(both: Floats) -> tuple[Floats, float]:
    """Coefficients of at least zero, and the norm left over; the last column is what is wanted."""
    both = np.asarray(np.linalg.qr(both, mode="r"))
    n = both.shape[1] - 1
    floor = np.zeros(n)
    floor[:2] = LEAST
    x, norm = nnls(both[:n, :n], both[:n, n] - both[:n, :n] @ floor)
    return x + floor, float(np.hypot(norm, both[n, n]))
