"""Phase-locked loop: natural frequency and damping to gains."""

import math


def pll_gains(hertz: float, slope: float, zeta: float = math.sqrt(0.5)) -> tuple[float, float]:
    """Gains of a second-order PLL whose error signal has slope ``slope`` at lock.

    k_p = 2 zeta w_n / slope,  k_i = w_n^2 / slope,  w_n = 2 pi hertz

    Parameters
    ----------
    hertz : float
        Natural frequency [Hz].
    slope : float
        Error signal per radian of angle error [1/rad].
    zeta : float
        Damping ratio.

    Returns
    -------
    k_p [1/s], k_i [1/s^2]
    """
    w_n = 2.0 * math.pi * hertz
    return 2.0 * zeta * w_n / slope, w_n * w_n / slope
