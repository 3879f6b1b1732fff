"""Energy is neither made nor lost by the machine model and its integrator."""

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Motor, Saturation
from sensorless.plant.case import PlantCase
from sensorless.plant.run import integrate
from tests.helpers.machines import BRIDGE

Map = Callable[[Saturation, Floats], Floats]

H = 5e-6
HOLD = 40


def simpson(y: Floats) -> float:
    """Integral over n samples ``H`` apart, n odd."""
    return float(H / 3.0 * (y[0] + 4.0 * y[1:-1:2].sum() + 2.0 * y[2:-1:2].sum() + y[-1]))


def magnetic_energy(currents: Map, s: Saturation, start: Floats, end: Floats) -> float:
    """Work 3/2 int i dpsi along the straight line between two fluxes [J]."""

    def slope(x: float) -> float:
        return 1.5 * float(currents(s, start + x * (end - start)) @ (end - start))

    return float(quad(slope, 0.0, 1.0, epsabs=1e-13, epsrel=1e-13, limit=400)[0])


@pytest.mark.parametrize("name", ["linear", "saturated", "bridge"])
def test_balance(name: str, motor: Motor, map_currents: Map) -> None:
    """Electrical input = copper loss + shaft work + change of field energy, to 1e-8."""
    linear = Saturation.linear(motor.L_d, motor.L_q, motor.psi_f)
    s = {"linear": linear, "saturated": motor.saturation, "bridge": BRIDGE}[name]
    case = PlantCase(
        T_s=H,
        n_p=2,
        R_s=2.484,
        saturation=s,
        J=0.005,
        B=0.02,
        i_d=-1.0,
        i_q=3.0,
        theta_e=0.4,
        omega_m=60.0,
    )
    rng = np.random.default_rng(3)
    held = np.concatenate(
        [rng.uniform(-200.0, 200.0, (30, 2)), rng.uniform(-5.0, 5.0, (30, 1))], axis=1
    )
    inputs = np.repeat(held, HOLD, axis=0)
    i_d, i_q, psi_d, psi_q, tau, omega, theta = integrate(case, inputs).T
    i_ab = (i_d + 1j * i_q) * np.exp(1j * theta)

    electrical = shaft_load = 0.0
    for k, (u_alpha, u_beta, tau_load) in enumerate(held):
        part = slice(HOLD * k, HOLD * (k + 1) + 1)
        power = 1.5 * (u_alpha * i_ab[part].real + u_beta * i_ab[part].imag)
        electrical += simpson(power)
        shaft_load += tau_load * simpson(omega[part])
    copper = simpson(1.5 * case.R_s * (i_d**2 + i_q**2))
    shaft = simpson(tau * omega)
    psi = np.stack([psi_d, psi_q], axis=-1)
    field = magnetic_energy(map_currents, s, psi[0], psi[-1])
    scale = copper + abs(shaft) + abs(field)
    assert min(copper, abs(shaft), abs(field)) > 1e-3 * scale, "a term is too small to be tested"
    assert abs(electrical - copper - shaft - field) < 1e-8 * scale

    kinetic = 0.5 * case.J * (omega[-1] ** 2 - omega[0] ** 2)
    friction = case.B * simpson(omega**2)
    assert abs(shaft - kinetic - friction - shaft_load) < 1e-8 * scale


@pytest.mark.parametrize("name", ["saturated", "bridge"])
def test_without_resistance_the_field_gives_back_what_it_took(
    name: str, motor: Motor, map_currents: Map
) -> None:
    """A closed loop of flux at standstill costs nothing: the map has an energy."""
    s = {"saturated": motor.saturation, "bridge": BRIDGE}[name]
    case = PlantCase(
        T_s=1e-4,
        n_p=1,
        R_s=0.0,
        saturation=s,
        J=math.inf,
        B=0.0,
        i_d=0.0,
        i_q=0.0,
        theta_e=0.0,
        omega_m=0.0,
    )
    loop = np.array(
        [[1000.0, 500.0, 0.0], [-700.0, 900.0, 0.0], [-600.0, -800.0, 0.0], [300.0, -600.0, 0.0]]
    )
    rows = integrate(case, np.repeat(loop, 2, axis=0), split=200)
    psi = rows[:, 2:4]
    assert np.max(np.abs(psi[-1] - psi[0])) < 1e-12
    work = [magnetic_energy(map_currents, s, a, b) for a, b in pairwise(psi)]
    assert max(np.abs(work)) > 0.05
    assert abs(sum(work)) < 1e-10
