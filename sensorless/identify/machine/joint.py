"""One fit over all pulses: the flux map and the inertia that explain them together.

In the frame of the rotor at the start of a pulse, the integral of the voltage behind resistance and
lost voltage is
    path = a + b t + (psi_f + psi(i exp(-j theta))) exp(j theta)
with a and b of each pulse free: noise at its start, and what is left of offsets or of a speed. psi
is a model plus a polynomial of both currents and what the rotor's place and the iron add
(``details.py``). theta is the angle at which the rotor stood, plus 3/2 n_p^2 / J times the double
integral of the torque over 3/2 n_p. The fit finds the polynomial, the details, the angles and J by
Gauss and Newton.

On pulses in q, a turn looks much like an inductance, so J is known from here only as well as the
rest of the pulse tells them apart. Therefore the spin's J takes part with its standard deviation,
the pulses with theirs: where a light rotor turns far, they say more; else the spin decides. The
same holds for an angle and cross-saturation on pulses between the axes. The rotor stands alike at
one place, but for what the short pulses before each group show; these find its axis only as well
as dead time and thresholds let through their small current, so it is free for all of a place.
A rotor that swings before a pulse fits no J at all. Such a group is known by what it leaves over.
"""

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sensorless.identify.machine.axis import OFF_AXIS
from sensorless.identify.machine.details import Details, expected
from sensorless.identify.machine.electric import rms
from sensorless.identify.machine.equations import Known, State, equations, line, path
from sensorless.identify.machine.nameplate import Nameplate
from sensorless.identify.machine.pulses import Group, Samples, closed
from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Saturation

ROUNDS = 4
"""Of Gauss and Newton."""
OUTLIER = 3.0
"""Flux that a group leaves over, over the median's: beyond, its rotor was in motion."""
NOISE = 1e-3
"""First guess of the flux left over, over the magnet's."""
LEAST_DOUBT = 0.01
"""Least relative standard deviation of the spin's J: few stretches tell it."""
LEAST_SCATTER = 1e-4
"""Least standard deviation of the rotor's angle at a place [rad]."""
PULSE_TELLS = 2
"""Independent errors of a pulse, one of each axis: what is wrong with the lost voltage is alike."""


@dataclass(frozen=True)
class Joint:
    """Result of the fit."""

    samples: Samples
    share: float
    """1 / J over that of the spin"""
    doubt: float
    """relative standard deviation of J"""
    g: float
    """conductance of the iron's loss [S]"""


@dataclass(frozen=True)
class _Prior:
    """What is known of the last parameters before the fit."""

    stands: Floats
    """(groups, places + groups) which of ``State.stood`` a group has"""
    start: State
    spread: Floats
    """standard deviations of details, ``stood`` and ``share``"""

    @classmethod
    def of(cls, groups: Sequence[Group], likely: Details, doubt: float) -> "_Prior":
        """See how far the short pulses agree on where the rotor stood."""
        places = np.unique([g.place for g in groups])
        at = np.array([g.place == places for g in groups], dtype=float)
        off = np.array([g.theta - g.place for g in groups])
        start = np.array([np.median(off[column > 0.0]) for column in at.T])
        scatter = np.abs(off - at @ start)
        scatter = np.maximum(scatter, max(float(np.median(scatter)), LEAST_SCATTER))
        of_places = np.full(len(places), OFF_AXIS)
        return cls(
            np.c_[at, np.eye(len(groups))],
            State(Details(), np.r_[start, np.zeros(len(groups))], 1.0),
            np.r_[dataclasses.astuple(likely), of_places, scatter, doubt],
        )


def fit_jointly(
    groups: Sequence[Group],
    model: Saturation,
    psi_f: float,
    turn: float,
    doubt: float,
    plate: Nameplate,
) -> Joint:
    """Fit all groups; while one leaves too much over, without it.

    ``turn``: 3/2 n_p^2 / J of the spin; ``doubt``: relative standard deviation of that J.
    """
    known = Known(model, psi_f, turn, plate.i_rated)
    likely = expected(plate, psi_f, groups[0].small)
    used = list(groups)
    while True:
        prior = _Prior.of(used, likely, max(doubt, LEAST_DOUBT))
        found, left = _solved(used, known, prior)
        worst = int(np.argmax(left))
        if left[worst] <= OUTLIER * np.median(left) or len(used) <= len(groups) // 2:
            return found
        del used[worst]


def _solved(groups: Sequence[Group], k: Known, prior: _Prior) -> tuple[Joint, Floats]:
    """The fit, and what each group leaves over [Vs]."""
    psi = [closed(g, k.psi_f, np.zeros(len(g.i)))[0] for g in groups]
    state, noise, known = prior.start, NOISE * k.psi_f, len(prior.spread)
    for _ in range(ROUNDS):
        pulses = [
            p
            for n, g in enumerate(groups)
            for p in equations(n, g, prior.stands[n], psi[n], state, k)
        ]
        bases = [np.linalg.qr(p.free)[0] for p in pulses]
        A, y = (
            np.concatenate([x - q @ (q.T @ x) for x, q in zip(parts, bases, strict=True)])
            for parts in ([p.matrix for p in pulses], [p.wanted for p in pulses])
        )
        alike = np.sqrt(len(y) / (PULSE_TELLS * len(pulses)))
        weight = np.diag(noise * alike / prior.spread)
        # all are expected at zero but the share, at one
        A = np.r_[A, np.c_[np.zeros((known, A.shape[1] - known)), weight]]
        y = np.r_[y, weight[-1]]
        scale = np.linalg.norm(A, axis=0)
        x = np.linalg.lstsq(A / scale, y, rcond=None)[0] / scale
        noise = max(rms(y - A @ x), 1e-6 * k.psi_f)
        details, stood, (share,) = np.split(x[-known:], [4, -1])
        share = float(np.clip(share, 0.5 * state.share, 2.0 * state.share))
        state = State(Details(*details.tolist()), stood, share)
        left = [0.0] * len(groups)
        for p in pulses:
            over = p.wanted - p.matrix @ x
            ab = np.linalg.lstsq(p.free, over, rcond=None)[0]
            left[p.group] = max(left[p.group], rms(over - p.free @ ab))
            psi[p.group][p.rows] = path(groups[p.group], p.rows) - line(p.rows, ab)
    spread = np.linalg.pinv((A / scale).T @ (A / scale))[-1, -1]
    std = float(noise * alike * np.sqrt(spread) / scale[-1] / share)
    i = np.concatenate([p.i for p in pulses])
    out = [psi[p.group][p.rows][p.use] * p.back - k.psi_f - p.details @ details for p in pulses]
    turned = max(p.turned for p in pulses)
    samples = Samples(i, np.concatenate(out), noise / k.psi_f, turned)
    return Joint(samples, share, std, state.details.g), np.array(left)
