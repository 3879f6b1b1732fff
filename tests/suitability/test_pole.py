"""Whether a map bears out the pole of its fitted model: two maps in closed form."""

from dataclasses import replace

import numpy as np
import pytest

from sensorless.machine.magnetics import Floats, flux
from sensorless.machine.map_fit import fit_map
from sensorless.machine.mapped import mapped
from sensorless.machine.motor import Motor, Saturation
from sensorless.observers.start_design import knows_poles, polarity_pulse
from sensorless.suitability.pole import pole_unsure

TRACTION = replace(
    Motor.load("paper"), name="traction", n_p=4, R_s=0.08, L_d=1.2e-3, L_q=3.2e-3, psi_f=0.14,
    J=0.03, B=1e-3, tau_rated=95.0, i_rated=120.0, n_rated_rpm=3500.0, u_dc=650.0, u_inj=60.0,
    i_max=170.0, i_trip=360.0, dead_time=3e-6, adc_range=300.0,
    saturation=Saturation.linear(1.2e-3, 3.2e-3, 0.14),
)  # fmt: skip


def grid(d: tuple[float, float], q: float) -> Floats:
    """Currents (n, 2) of a map [A]."""
    axes = np.meshgrid(np.linspace(*d, 26), np.linspace(-q, q, 39), indexing="ij")
    return np.stack([x.ravel() for x in axes], axis=-1)


def linear_along_d(i: Floats) -> Floats:
    """Fluxes of iron that only the q current saturates, and that couples the axes [Vs].

    From one co-energy: d psi_d / d i_q = d psi_q / d i_d = -k tanh(i_q / 60 A).
    """
    d, q, k = *i.T, 1.2e-4
    psi_d = 0.14 + 1.2e-3 * d - k * 60.0 * np.log(np.cosh(q / 60.0))
    psi_q = 3.2e-3 * (0.45 * q + 0.55 * 70.0 * np.tanh(q / 70.0)) - k * d * np.tanh(q / 60.0)
    return np.stack([psi_d, psi_q], axis=-1)


@pytest.fixture(scope="module")
def invented() -> tuple[Motor, Floats, Floats]:
    """A machine whose fit shows a pole, within 1 % RMS of a map that shows none."""
    i = grid((-190.0, 60.0), 190.0)
    psi = linear_along_d(i)
    fit = fit_map(i, psi, TRACTION.i_rated, TRACTION.i_max)
    assert max(fit.rms_percent(TRACTION.i_rated)) < 1.0
    return mapped(TRACTION, fit), i, psi


def test_a_pole_that_only_the_fit_has_is_told(invented: tuple[Motor, Floats, Floats]) -> None:
    motor, i, psi = invented
    assert knows_poles(motor)
    (said,) = pole_unsure(motor, i, psi)
    assert "by the map with 0.0%" in said and "drive_init" in said
    assert not knows_poles(replace(motor, pole_at_rest=False))


def test_a_map_without_current_on_one_side_is_told(invented: tuple[Motor, Floats, Floats]) -> None:
    motor, i, psi = invented
    left = i[:, 0] < 0.0
    (said,) = pole_unsure(motor, i[left], psi[left])
    assert said.startswith("the map has no current on both sides of rest")


def test_a_pole_that_the_map_has_too_is_not_doubted(motor: Motor) -> None:
    i = grid((-6.5, 6.5), 6.5)
    assert list(pole_unsure(motor, i, flux(motor.saturation, i))) == []


@pytest.mark.parametrize(("share", "sure"), [(0.03, False), (0.05, True)])
def test_a_map_needs_four_percent_of_rated_current(
    share: float, sure: bool, invented: tuple[Motor, Floats, Floats]
) -> None:
    """A current of x + k x^2 along d, x the flux over L_d: pulses of +-x differ by 2 k x^2."""
    motor, i = invented[0], grid((-130.0, 130.0), 190.0)  # beyond both peaks
    pulse, _ = polarity_pulse(motor)
    x = pulse / motor.L_d
    k = 0.5 * share * motor.i_rated / x**2
    root = (np.sqrt(1.0 + 4.0 * k * i[:, 0]) - 1.0) / (2.0 * k)
    rest = flux(motor.saturation, np.zeros((1, 2)))[0, 0]
    psi = np.stack([rest + motor.L_d * root, motor.L_q * i[:, 1]], axis=-1)
    assert (list(pole_unsure(motor, i, psi)) == []) == sure
