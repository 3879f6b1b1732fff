"""Which model explains measured flux linkages, and what of them it is fitted to."""

from dataclasses import astuple, replace

import numpy as np
import pytest

from sensorless.errors import UserError
from sensorless.identify.machine import model as module
from sensorless.identify.machine.model import fit_model
from sensorless.identify.machine.pulses import Samples
from sensorless.machine.magnetics import flux
from sensorless.machine.map_fit import MapFit
from sensorless.machine.motor import Motor

BRIDGED = Motor.load("pmsyrm_5600w")


def measured(motor: Motor, largest: float = 1.0) -> tuple[Samples, float]:
    """Flux linkages up to ``largest`` rated currents, and the magnet's."""
    size, angle = np.meshgrid(np.linspace(0.05, largest, 12), np.linspace(-np.pi, np.pi, 24))
    i = (motor.i_rated * size * np.exp(1j * angle)).ravel()
    psi = flux(motor.saturation, np.stack([i.real, i.imag], axis=-1))
    psi_f = float(flux(motor.saturation, np.zeros((1, 2)))[0, 0])
    return Samples(i, psi[:, 0] - psi_f + 1j * psi[:, 1], 0.0, 0.0), psi_f


def refused(*_: object) -> MapFit:
    raise UserError("no")


def test_terms_and_magnet_come_back_without_the_general_fit(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Saturation of d with its fourth power, of q, and between the axes."""
    monkeypatch.setattr(module, "fit_map", refused)
    motor = Motor.load("paper")
    found = fit_model(*measured(motor), motor.i_rated).saturation
    assert astuple(found) == pytest.approx(astuple(motor.saturation), rel=1e-6)


@pytest.mark.parametrize(("share", "general"), [(0.4, True), (0.6, False)])
def test_the_general_fit_has_to_halve_the_error(
    share: float, general: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One that is wrong by a current of the magnet alone: that current is its error of i_d."""
    s, psi_f = measured(BRIDGED)
    monkeypatch.setattr(module, "fit_map", refused)
    simple = fit_model(s, psi_f, BRIDGED.i_rated)
    worst = max(simple.rms_percent(BRIDGED.i_rated))
    assert worst > 2.5
    off = 0.01 * share * worst * BRIDGED.i_rated
    model = replace(BRIDGED.saturation, i_f=BRIDGED.saturation.i_f + off)
    monkeypatch.setattr(module, "fit_map", lambda *_: replace(simple, saturation=model))
    found = fit_model(s, psi_f, BRIDGED.i_rated).saturation
    assert found == (model if general else simple.saturation)


def test_samples_count_up_to_1_3_rated_currents() -> None:
    motor = Motor.load("ipmsm_2200w")
    s, psi_f = measured(motor, 1.29)
    beyond = Samples(np.r_[s.i, 1.31j * motor.i_rated], np.r_[s.psi, 9.0 + 9.0j], 0.0, 0.0)
    found = fit_model(beyond, psi_f, motor.i_rated)
    assert len(found.i) == len(s.i)
    assert found.saturation.a_q0 == pytest.approx(1.0 / motor.L_q)


@pytest.mark.parametrize("psi_f", [0.0, -0.5])
def test_a_magnet_that_is_none_is_refused(psi_f: float) -> None:
    with pytest.raises(UserError, match="check the phase order"):
        fit_model(measured(BRIDGED)[0], psi_f, BRIDGED.i_rated)
