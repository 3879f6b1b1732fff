"""Under load: what injection corrects must not look like a speed."""

import numpy as np
import pytest
from numpy.typing import NDArray

from sensorless.core.api import struct_dtype
from sensorless.machine.motor import Motor
from tests.core.drive.test_coupled import COLUMNS, Call, params
from tests.helpers.drives import flux_model

Floats = NDArray[np.float64]

N, THETA = 3000, 0.3


class Loaded:
    """At rest under constant current, voltages and flux exact, but for injection's error."""

    def __init__(self, c: Call, motor: Motor, part: float, err: Floats) -> None:
        """Rated current times ``part``, 130 degrees ahead of the d axis, without learning."""
        p = params(motor)
        p["drift"]["k"] = p["drift"]["u_dt_i"] = 0.0
        i = part * motor.i_rated * np.exp(1j * np.radians(130.0))
        psi = motor.psi_f + motor.L_d * i.real + 1j * motor.L_q * i.imag
        self.aux = psi - motor.L_q * i.real - 1j * motor.L_d * i.imag
        psi_ab = psi * np.exp(1j * THETA)
        i_ab = i * np.exp(1j * THETA)
        samples = np.tile(np.array([i_ab.real, i_ab.imag], dtype=np.float32), (N, 1))
        x = np.zeros(1, dtype=struct_dtype("coupled_state_t"))
        y = np.zeros(1, dtype=struct_dtype("emf_estimate_t"))
        x["psi"]["a"], x["psi"]["b"] = psi_ab.real, psi_ab.imag
        x["i_1"]["a"], x["i_1"]["b"] = samples[0]
        y["pll"]["theta"], y["valid"] = THETA, 1.0
        out = np.zeros((N, len(COLUMNS)), dtype=np.float32)
        volts = np.float32(motor.R_s) * samples
        c("coupled_observe", p, flux_model(motor), x, y, samples, volts, err.astype(np.float32),
          1.0, motor.T_s, out, N)  # fmt: skip
        self.out = out.astype(np.float64)
        self.k_p = float(p["k_p"][0])

    def __getitem__(self, name: str) -> Floats:
        return self.out[:, COLUMNS.index(name)]


@pytest.mark.parametrize("part", [0.5, 1.0])
@pytest.mark.parametrize("name", ["brusa_hsm1", "ipmsm_2200w"])
def test_noise_of_the_injection_stays_out_of_the_speed(c: Call, name: str, part: float) -> None:
    """The angle walks at random, the flux by j psi_a with it; eps and speed stay."""
    motor = Motor.load(name)
    err = np.random.default_rng(1).normal(0.0, 0.02, N)
    still, noisy = Loaded(c, motor, part, 0.0 * err), Loaded(c, motor, part, err)
    walk = noisy["theta"] - still["theta"]
    assert np.std(walk) > 0.01
    assert np.std(noisy["eps"] - still["eps"]) < 0.02 * np.std(walk)
    bandwidth = 0.5 * still.k_p / motor.T_s
    assert np.std(noisy["omega"] - still["omega"]) < 0.02 * bandwidth * np.std(walk)
    moved = (noisy["psi_a"] - still["psi_a"]) + 1j * (noisy["psi_b"] - still["psi_b"])
    wanted = 1j * still.aux * np.exp(1j * THETA) * walk
    left = moved[:-1] - wanted[1:]  # what corrects the length of the flux takes some of it
    assert np.std(left) < 0.1 * np.std(wanted)
