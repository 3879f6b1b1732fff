"""What the place of the rotor and the iron add to the flux linkage over current.

The model is that of ``core/sim/harmonics.h`` and ``core/sim/plant.h``. With the rotor at theta in
the stator, in its frame, the saturation model gives the current of x = psi - m, and
    i = i(x) + gamma conj(x - psi_f) exp(j 6 theta) + g e
    m = m_d cos 6 theta + j m_q sin 6 theta
gamma is a second saliency, m the sixth harmonic of the magnet's flux linkage, g the conductance of
the iron's loss across the EMF e, whose current a sensor sees as its mean of the last period. All
are small, so the flux linkage changes by the incremental inductance times what they add to i.
"""

import dataclasses
from dataclasses import dataclass

import numpy as np

from sensorless.identify.machine.electric import Complex, parts
from sensorless.identify.machine.nameplate import Nameplate
from sensorless.machine.magnetics import Floats, inverse_inductance
from sensorless.machine.motor import Saturation

SECOND_SALIENCY = 0.05
"""Of a machine's second saliency over its first: the slots' share, standard deviation."""
EMF_HARMONICS = 0.05
"""Of the fifth and the seventh harmonic of the EMF over the first, standard deviation."""
IRON = 0.03
"""Of the iron's loss at rated speed over rated power, standard deviation."""


@dataclass(frozen=True)
class Details:
    """Numbers of the model."""

    gamma: float = 0.0
    """second saliency [1/H]"""
    m_d: float = 0.0
    """sixth harmonic of the magnet's flux linkage [Vs]"""
    m_q: float = 0.0
    """[Vs]"""
    g: float = 0.0
    """conductance of the iron's loss [S]"""

    @property
    def all(self) -> Floats:
        """(4,) in the order of ``flux_columns`` and ``torque_columns``."""
        return np.array(dataclasses.astuple(self))


def expected(plate: Nameplate, psi_f: float, small: tuple[float, float]) -> Details:
    """Return standard deviations of what machines have.

    ``small``: L_d and L_q at small current [H]. A harmonic n of the EMF is one of n times less flux
    linkage; rated power is 3/2 of rated current times the voltage at rated speed.
    """
    L_d, L_q = small
    m = EMF_HARMONICS * float(np.hypot(1.0 / 5.0, 1.0 / 7.0)) * psi_f
    gamma = SECOND_SALIENCY * 0.5 * abs(1.0 / L_d - 1.0 / L_q)
    return Details(gamma, m, m, IRON * plate.i_rated / plate.u_base)


def flux_columns(
    model: Saturation, psi: Complex, psi_f: float, six: Complex, e: Complex
) -> Complex:
    """(n, 4) flux linkage in the rotor frame per unit of each number of ``Details``.

    ``psi``: that of the model [Vs]; ``six``: exp(j 6 theta); ``e``: EMF of the last period [V].
    """
    gamma = inverse_inductance(model, parts(psi))
    added = np.stack([(psi - psi_f).conj() * six, e], axis=-1)
    both = np.linalg.solve(gamma, np.stack([added.real, added.imag], axis=1))
    second, iron = (both[:, 0] + 1j * both[:, 1]).T
    return np.stack([-second, six.real, 1j * six.imag, -iron], axis=-1)


def torque_columns(i: Complex, psi: Complex, psi_f: float, six: Complex, e: Complex) -> Floats:
    """(n, 4) torque over 3/2 n_p [Vs A] that each number adds to psi x i per unit.

    Harmonics take from it what the field's energy gains with the angle, the iron what its current
    would give. ``i`` [A], ``psi`` [Vs], ``e`` [V]: (n,) in the rotor frame.
    """
    second = 3.0 * ((psi - psi_f) ** 2 * six.conj()).imag
    magnet = 6.0 * i.real * six.imag, -6.0 * i.imag * six.real
    return -np.stack([second, *magnet, (psi.conj() * e).imag], axis=-1)
