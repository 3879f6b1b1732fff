"""The coupled observer in C against the linear loop of docs/coupled-observer.md."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import expm

from sensorless.core.api import Array, struct_dtype
from sensorless.design.derived import derive
from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.machine.motor import Motor, Saturation
from sensorless.observers.coupled_design import bandwidths
from tests.helpers.drives import flux_model

Call = Callable[..., None]
Floats = NDArray[np.float64]

T_S = 2e-5
"""Short, so that the sampled loop is the continuous one but for W T_s, about 1 %."""
OMEGA = 100.0
COLUMNS = ("theta", "omega", "eps", "load", "drift", "psi_a", "psi_b")


@pytest.fixture
def linear(motor: Motor) -> Motor:
    """The paper's motor with short periods and a linear flux map."""
    sat = Saturation.linear(motor.L_d, motor.L_q, motor.psi_f)
    return replace(motor, T_s=T_S, u_inj=10.0 * motor.u_inj, saturation=sat)


def params(motor: Motor, **changes: float) -> Array:
    """``coupled_params_t``, shape (1,), without dead time or learning the sensors' gain."""
    p = np.array(control_record(motor, DriveDesign(estimator="coupled"))["coupled"]).reshape(1)
    p["drift"]["u_dt"] = p["match"]["k_gain"] = 0.0
    for name, value in changes.items():
        p[name] = value
    return p


def turn(theta: Floats) -> Floats:
    """Unit vectors (n, 2)."""
    return np.stack([np.cos(theta), np.sin(theta)], axis=-1)


class Run:
    """The observer on a shaft that nothing drives: no current, u = dpsi/dt exactly."""

    def __init__(
        self, c: Call, motor: Motor, p: Array, omega: Array, *, behind: float = 0.0,
        turned: float = 0.0, size: float = 1.0, k_s: float = 0.0, drift: float = 0.0,
        err: Floats | None = None,
    ) -> None:  # fmt: skip
        """Run through the speeds ``omega`` (n,).

        The angle begins ``behind`` the rotor, the flux ``turned`` back and ``size`` times as long.
        The voltage lacks what would turn the flux by ``drift`` [rad/s].
        """
        n = len(omega)
        theta = np.concatenate([[0.3], 0.3 + np.cumsum(omega) * T_S])
        psi = motor.psi_f * turn(theta)
        u = np.diff(psi, axis=0, prepend=psi[:1]) / T_S
        u -= drift * motor.psi_f * turn(theta + 0.5 * math.pi)
        x = np.zeros(1, dtype=struct_dtype("coupled_state_t"))
        y = np.zeros(1, dtype=struct_dtype("emf_estimate_t"))
        x["psi"]["a"], x["psi"]["b"] = size * motor.psi_f * turn(theta[0] - turned)
        y["pll"]["theta"], y["pll"]["omega"], y["valid"] = theta[0] - behind, omega[0], 1.0
        self.out = np.zeros((n, len(COLUMNS)), dtype=np.float32)
        zero = np.zeros((n, 2), dtype=np.float32)
        errors = np.zeros(n) if err is None else err
        c("coupled_observe", p, flux_model(motor), x, y, zero, u[:n].astype(np.float32),
          errors.astype(np.float32), k_s, T_S, self.out, n)  # fmt: skip
        self.t = np.arange(n) * T_S
        self.delta = (theta[:n] - self["theta"] + math.pi) % (2 * math.pi) - math.pi
        self.omega = omega
        self.theta = theta[:n]

    def __getitem__(self, name: str) -> Floats:
        return self.out[:, COLUMNS.index(name)].astype(np.float64)


def loop(p: Array, omega: float = 0.0, T_s: float = T_S) -> Floats:
    """Of (eps, omega_hat - omega, load, phi, drift, size of the flux - 1) at k_s = 1."""
    k_h, zeta = (float(p[name][0]) / T_s for name in ("k_h", "gain_w"))
    k_b = float(p["drift"]["k"][0]) / T_s
    k_p, k_i, k_l = (float(p[name][0]) for name in ("k_p", "k_i", "k_l"))
    k_p, k_l = k_p / T_s, k_l / T_s
    return np.array([
        [-k_p, -1.0, 0.0, 0.0, 1.0, -omega],
        [k_i, 0.0, 1.0, 0.0, 0.0, 0.0],
        [k_l, 0.0, 0.0, 0.0, 0.0, 0.0],
        [-k_h, 0.0, 0.0, -k_h, -1.0, omega],
        [k_b, 0.0, 0.0, k_b, 0.0, 0.0],
        [0.0, 0.0, 0.0, -omega, 0.0, -2.0 * zeta * abs(omega)],
    ])  # fmt: skip


def test_poles(linear: Motor) -> None:
    """Those that the design asks for: (s + W)^2 (s + r) and, apart from them, (s + Omega)^2."""
    at = bandwidths(linear, derive(linear, DriveDesign()).speed_hz)
    matrix = loop(params(linear))
    wanted = [-at.flux, -at.flux, -at.load]
    assert np.poly(matrix[:3, :3]) == pytest.approx(np.poly(wanted), rel=1e-5)
    without_drift = [*wanted, -2.0 * at.injection]
    assert np.poly(matrix[:4, :4]) == pytest.approx(np.poly(without_drift), rel=1e-5)


@pytest.mark.parametrize("name", ["paper", "ipmsm_2200w", "pmsyrm_5600w"])
def test_the_drift_moves_the_poles_little(name: str) -> None:
    """All are damped by more than 0.6, none is slower than half the load's."""
    motor = Motor.load(name)
    poles = np.linalg.eigvals(loop(params(motor), T_s=motor.T_s)[:5, :5])
    at = bandwidths(motor, derive(motor, DriveDesign()).speed_hz)
    assert np.all(-poles.real / np.abs(poles) > 0.6)
    assert np.all(np.abs(poles) > 0.5 * at.load)


def test_a_step_of_the_angle_decays_as_the_linear_loop(c: Call, linear: Motor) -> None:
    """The flux is right, the angle is not: the voltage model alone."""
    p = params(linear)
    step = 0.5 * float(p["eps_rise"][0])
    run = Run(c, linear, p, np.full(6000, OMEGA), behind=step)
    inner = loop(p)[:3, :3]
    expected = np.array([(expm(inner * t) @ [step, 0.0, 0.0])[0] for t in run.t[::200]])
    assert run["eps"][::200] == pytest.approx(expected, abs=0.02 * step)
    assert np.abs(expected).min() < 0.1 * step < np.abs(expected).max()


def test_a_flux_that_is_trusted_less_is_followed_more_slowly(c: Call, linear: Motor) -> None:
    """Without current: the loop with the share of its bandwidth, and of its load pole's gain."""
    p, share = params(linear), 0.4
    p["drift"]["calm"] = share
    slow = params(linear)
    for name, power in (("k_p", 1), ("k_i", 2), ("k_l", 2)):
        slow[name] *= share**power
    step = 0.5 * float(p["eps_rise"][0])
    run = Run(c, linear, p, np.full(6000, OMEGA), behind=step)
    inner = loop(slow)[:3, :3]
    expected = np.array([(expm(inner * t) @ [step, 0.0, 0.0])[0] for t in run.t[::200]])
    assert run["eps"][::200] == pytest.approx(expected, abs=0.02 * step)


def test_injection_turns_angle_and_flux_back(c: Call, linear: Motor) -> None:
    """Both are wrong alike, which no voltage can tell: injection sees delta, period by period."""
    p = params(linear)
    slope, step, n = 1.0 / float(p["inv_slope"][0]), 2e-3, 4000
    one = expm(loop(p, OMEGA) * T_S)
    path = np.zeros((n, 6))
    path[0, 3] = step
    for k in range(n - 1):
        path[k + 1] = one @ path[k]
    delta = path[:, 0] + path[:, 3]
    run = Run(c, linear, p, np.full(n, OMEGA), behind=step, turned=step, k_s=1.0, err=slope * delta)
    assert run.delta == pytest.approx(delta, abs=0.025 * step)
    assert run["drift"] == pytest.approx(path[:, 4], abs=0.02 * np.abs(path[:, 4]).max())


def test_noise_of_the_injection_never_reaches_the_speed(c: Call, linear: Motor) -> None:
    """At rest, without the drift: the angle walks at random, the speed stays where it is."""
    err = np.random.default_rng(1).normal(0.0, 0.1, 5000)
    p = params(linear)
    p["drift"]["k"] = 0.0
    still = Run(c, linear, p, np.zeros(5000), k_s=1.0)
    noisy = Run(c, linear, p, np.zeros(5000), k_s=1.0, err=err)
    walk = np.cumsum(err * float(p["inv_slope"][0]) * float(p["k_h"][0]))
    moved = still.delta - noisy.delta
    assert moved[1:] == pytest.approx(walk[:-1], abs=1e-3 * np.abs(walk).max() + 2e-5)
    assert np.std(walk) > 3e-3
    assert noisy["omega"] == pytest.approx(still["omega"], abs=0.03)


def test_load_at_once_and_load_that_rises(c: Call, linear: Motor) -> None:
    """Constant acceleration: no lag, the load state has it. Rising by j a second: eps = j / k_l."""
    p = params(linear)
    n, a = 40000, 300.0
    run = Run(c, linear, p, OMEGA + a * T_S * np.arange(n))
    assert run["load"][-1] == pytest.approx(a, rel=0.01)
    assert abs(run["eps"][-1]) < 2e-5
    assert run["omega"][-1] == pytest.approx(run.omega[-1], abs=0.05)
    j = 1000.0
    run = Run(c, linear, p, OMEGA + 0.5 * j * (np.arange(n) * T_S) ** 2)
    assert np.mean(run["eps"][-2000:]) == pytest.approx(j * T_S / float(p["k_l"][0]), rel=0.03)


def along(run: Run, motor: Motor) -> Floats:
    """Length of the flux beyond the magnet's, over the magnet's, in the rotor's direction."""
    after = run.theta
    flux = run["psi_a"] * np.cos(after) + run["psi_b"] * np.sin(after)
    return np.asarray(flux / motor.psi_f - 1.0)


def test_flux_error_decays_with_the_design_damping(c: Call, linear: Motor) -> None:
    """Seen from the rotor s^2 + 2 zeta omega s + omega^2, the angle held on the rotor."""
    p = params(linear, k_p=0.0, k_i=0.0, k_l=0.0, gain_0=0.0)
    run = Run(c, linear, p, np.full(4000, OMEGA), size=1.01)
    zeta = float(p["gain_w"][0]) / T_S
    matrix = np.array([[-2.0 * zeta * OMEGA, OMEGA], [-OMEGA, 0.0]])
    expected = [0.01 * (expm(matrix * t) @ [1.0, 0.0])[0] for t in run.t[::100]]
    assert zeta == pytest.approx(0.3)
    assert along(run, linear)[::100] == pytest.approx(expected, abs=2e-4)


def test_a_voltage_that_lacks_leans_the_angle(c: Call, linear: Motor) -> None:
    """Without injection by 2 (b + zeta omega) v / omega^2."""
    p, v = params(linear, inv_layer=0.0), 0.5
    run = Run(c, linear, p, np.full(60_000, OMEGA), drift=v)
    rate = (float(p["gain_0"][0]) + OMEGA * float(p["gain_w"][0])) / T_S
    assert run.delta[-1] == pytest.approx(2.0 * rate * v / OMEGA**2, rel=0.02)


def test_sigmoid_is_linear_inside_its_layer_and_bounded_outside(c: Call, linear: Motor) -> None:
    held = {"k_p": 0.0, "k_i": 0.0, "k_l": 0.0, "gain_0": 0.0}
    smooth, straight = params(linear, **held), params(linear, inv_layer=0.0, **held)
    layer, n = float(smooth["layer"][0]), 3000
    for share, apart in ((0.05, 0.01), (2.0, None)):
        a, b = (
            along(Run(c, linear, p, np.full(n, OMEGA), size=1.0 + share * layer), linear)
            for p in (smooth, straight)
        )
        if apart is not None:
            assert a == pytest.approx(b, abs=apart * share * layer)
        else:  # of a rate of the layer's thickness: tanh(2) / 2 of the linear one
            assert a[1] - a[0] == pytest.approx(0.5 * math.tanh(2.0) * (b[1] - b[0]), rel=0.02)


@pytest.mark.parametrize("share", [1.0, 0.5])
def test_bandwidth_rises_with_the_error(share: float, c: Call, linear: Motor) -> None:
    """A load that is eight times as large displaces the angle by much less than eight times.

    Where the flux is trusted less, so by a share of the bandwidth, the same loads make it rise.
    """
    p = params(linear)
    p["drift"]["calm"] = share
    n = 3000 if share == 1.0 else 6000
    peak = {
        a: share**2 * float(Run(c, linear, p, OMEGA + a * T_S * np.arange(n))["eps"].max())
        for a in (300.0, 2400.0)
    }
    assert peak[300.0] < float(p["eps_rise"][0]) < peak[2400.0]
    assert 8.0 / 1.75**2 < peak[2400.0] / peak[300.0] < 6.0


def test_the_shaft_alone_is_estimated_without_error(c: Call, linear: Motor) -> None:
    run = Run(c, linear, params(linear), np.full(3000, -OMEGA))
    assert np.abs(run.delta).max() < 2e-4
    assert run["omega"] == pytest.approx(-OMEGA, abs=0.05)


def test_dead_time_excess_is_the_difference_of_two_transitions(c: Call) -> None:
    i = np.random.default_rng(2).uniform(-1.0, 1.0, (200, 2)).astype(np.float32)
    wide, steep, both = (np.zeros_like(i) for _ in range(3))
    c("dead_time", 4.0, 5.0, i, wide, len(i))
    c("dead_time", 3.0, 20.0, i, steep, len(i))
    c("dead_time_excess", 4.0, 4.0 * 5.0, 3.0, 3.0 * 20.0, i, both, len(i))
    assert both == pytest.approx(wide - steep, abs=2e-6)
    assert np.abs(both).max() > 1.0


def test_incremental_of_a_curve_is_its_derivative(c: Call) -> None:
    """d(x y)/dx by central differences, away from the nodes."""
    y = np.linspace(0.3, 0.1, 9) ** 2
    curve = y.astype(np.float32)
    x = (np.arange(8)[:, None] + np.array([0.25, 0.5, 0.75])).ravel().astype(np.float32)
    found = np.zeros_like(x)
    c("curve_incremental", curve, x, 1.0, found, len(x))
    nodes = np.arange(9.0)
    low, high = ((x + step) * np.interp(x + step, nodes, y) for step in (-0.01, 0.01))
    assert found == pytest.approx((high - low) / 0.02, rel=1e-4)
