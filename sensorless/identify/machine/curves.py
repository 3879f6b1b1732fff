"""Flux linkage over both currents as polynomials through zero, symmetric in the q axis."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sensorless.identify.machine.electric import Complex
from sensorless.identify.machine.pulses import Samples
from sensorless.machine.magnetics import Floats

DEGREE = 5
POWERS_D = [(a, b) for a in range(DEGREE + 1) for b in range(0, DEGREE + 1 - a, 2) if a + b]
POWERS_Q = [(a, b) for a in range(DEGREE + 1) for b in range(1, DEGREE + 1 - a, 2)]


@dataclass(frozen=True)
class Curves:
    """Flux linkage less the magnet's [Vs] over the current over ``scale``."""

    scale: float
    """[A]"""
    d: Floats
    q: Floats

    def psi(self, i: Complex) -> Complex:
        """(n,) flux linkage d + j q [Vs] of the currents (n,) d + j q [A]."""
        x = np.asarray(i) / self.scale
        return np.asarray(powers(x, POWERS_D) @ self.d + 1j * (powers(x, POWERS_Q) @ self.q))


def fit_curves(s: Samples, i_rated: float) -> Curves:
    """Least squares over all samples."""
    d, q = (
        np.asarray(np.linalg.lstsq(powers(s.i / i_rated, use), part, rcond=None)[0], float)
        for use, part in ((POWERS_D, s.psi.real), (POWERS_Q, s.psi.imag))
    )
    return Curves(i_rated, d, q)


def powers(x: Complex, exponents: Sequence[tuple[int, int]]) -> Floats:
    """Columns x_d^a x_q^b, one for each pair of exponents."""
    return np.stack([x.real**a * x.imag**b for a, b in exponents], axis=-1)
