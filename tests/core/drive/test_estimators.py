"""The other ways from two sources to one estimate, in the closed loop and by themselves."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from sensorless.core.api import SIGNAL_N, Array, sim_run, struct_dtype
from sensorless.design.drive import ESTIMATORS, DriveDesign
from sensorless.design.records import control_record
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.stress import stress_1_scenarios
from sensorless.evaluation.metrics.catalogue import angle_err_max_deg
from sensorless.evaluation.rollout import rollout
from sensorless.evaluation.steady import make_ideal, steady
from sensorless.machine.motor import Motor, Saturation
from sensorless.observers.flux_design import APART
from sensorless.observers.tracking import voltage_drift
from sensorless.policies.registry import make_policy
from sensorless.units import RPM_TO_RAD_S
from tests.helpers.drives import Alone, flux_model
from tests.helpers.scenarios import lasting

Call = Callable[..., None]
State = Callable[[Array], bytes]

FLUX = DriveDesign(estimator="flux", flux_L_q_bias=1.0, speed_hz=1.0)


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_blocks_and_plain_loop_agree(motor: Motor, estimator: str, state_bytes: State) -> None:
    """Two have vector code; the others are refused there, not computed wrongly."""
    scenarios = stress_1_scenarios(motor, np.arange(18, dtype=np.uint64))
    design = DriveDesign(estimator=estimator)
    ends = []
    for plain in (False, True):
        sims = SimFactory(motor, design).build(scenarios)
        obs = np.zeros((18, SIGNAL_N), dtype=np.float32)
        sim_run(sims, 1500, np.full(18, 0.5, np.float32), obs, plain=plain)
        ends.append(state_bytes(sims))
    assert ends[0] == ends[1]


def test_published_injection_is_the_same_in_both_loops(motor: Motor, state_bytes: State) -> None:
    scenarios = stress_1_scenarios(motor, np.arange(18, dtype=np.uint64))
    ends = {}
    for scheme in ("rotating", "stationary"):
        for plain in (False, True):
            sims = SimFactory(motor, DriveDesign(estimator="smo", hfi_scheme=scheme)).build(
                scenarios
            )
            obs = np.zeros((18, SIGNAL_N), dtype=np.float32)
            sim_run(sims, 500, np.ones(18, np.float32), obs, plain=plain)
            ends[scheme, plain] = state_bytes(sims["drive"])
    assert ends["stationary", False] == ends["stationary", True]
    assert ends["rotating", False] == ends["rotating", True] != ends["stationary", True]


@pytest.mark.parametrize("estimator", ["flux", "coupled"])
@pytest.mark.parametrize("name", ["paper", "pmsyrm_5600w"])
def test_iron_that_both_currents_saturate_turns_no_angle(name: str, estimator: str) -> None:
    """Alone, motoring and regenerating in both directions below field weakening.

    With L_d and the magnets' flux of a machine without torque current, and the apparent L_q in
    the place of the incremental one, the flux observer errs by 3 degrees.
    """
    motor = Motor.load(name)
    design = DriveDesign(estimator=estimator, flux_L_q_bias=1.0, coupled_L_q_bias=1.0, speed_hz=1.0)
    points = [(a, b) for a in (-0.6, -0.3, 0.3, 0.6) for b in (-0.95, 0.0, 0.95)]
    rpm, tau = np.array(points).T * [[motor.n_rated_rpm], [motor.tau_rated]]
    run = steady(motor, design, rpm, tau, 0.0, change=make_ideal)
    assert run.held.all()
    assert np.max(np.abs(np.rad2deg(run.err))) < 0.1


@pytest.mark.parametrize("L_q_bias", [0.8, 1.0, 1.2])
def test_error_of_the_flux_observer(motor: Motor, L_q_bias: float) -> None:
    """A wrong L_q on a linear machine turns it by the closed form of its two corrections.

    Across psi_a the loop brings the flux error to zero, along it the gain k pulls: x = dL_q i_q,
    delta = -x (a_d + 2 k a_q / w) / |a|^2, a = psi_f + (L_d - L_q_hat)(i_d - j i_q) in its frame.
    """
    linear = replace(motor, saturation=Saturation.linear(motor.L_d, motor.L_q, motor.psi_f))
    design = replace(FLUX, L_q_table=False, flux_L_q_bias=L_q_bias, mtpa=False, cross="none")
    rpm, tau = np.array([(600.0, 3.0), (600.0, -3.0), (1000.0, 3.0), (-600.0, -3.0)]).T
    run = steady(linear, design, rpm, tau, 0.0, change=make_ideal)
    assert run.held.all()
    i = (run.i[:, 0] + 1j * run.i[:, 1]) * np.exp(1j * run.err)
    L_q_hat = L_q_bias * motor.L_q
    a = motor.psi_f + (motor.L_d - L_q_hat) * i.conj()
    p = control_record(linear, design)["flux"]
    w = motor.n_p * run.omega_m
    k = (p["gain_0"] + p["gain_w"] * np.abs(w)) / motor.T_s
    want = -(motor.L_q - L_q_hat) * i.imag * (a.real + 2.0 * k / w * a.imag) / np.abs(a) ** 2
    np.testing.assert_allclose(np.rad2deg(run.err), np.rad2deg(want), atol=0.25)


def test_flux_observer_follows_below_its_floor(c: Call, motor: Motor) -> None:
    """At rest it is told angle and speed, and its flux is the one of the current."""
    p = np.array(control_record(motor, FLUX)["flux"]).reshape(1)
    x, y = (np.zeros(1, struct_dtype(name)) for name in ("flux_state_t", "emf_estimate_t"))
    i, u = np.array([0.5, 0.1], np.float32), np.array([1.0, 2.0], np.float32)
    for _ in range(20):
        c("flux_observe", p, flux_model(motor), x, y, i, i, u, 3.0, 0.0, 0.5, motor.T_s)
    assert y["valid"][0] == 0.0 and y["err"][0] == 0.0
    assert y["pll"]["theta"][0] == pytest.approx(3.0 * motor.T_s, abs=1e-6)
    assert y["pll"]["omega"][0] == 3.0
    psi = float(x["psi"]["a"][0]), float(x["psi"]["b"][0])
    assert psi == pytest.approx((motor.psi_f + 0.5 * motor.L_d, 0.1 * motor.L_q), rel=1e-5)


@pytest.mark.parametrize("k_s", [1.0, 0.4])
def test_injection_holds_a_flux_that_the_voltages_turn(c: Call, motor: Motor, k_s: float) -> None:
    """Without current, voltages wrong by v psi_f across the flux turn it; k k_s lead = v stops it.

    The lead that is left is ``APART`` over the weight where v is that of a whole dead time; the
    speed is not wrong at all.
    """
    p = np.array(control_record(motor, FLUX)["flux"]).reshape(1)
    x, y = (np.zeros(1, struct_dtype(name)) for name in ("flux_state_t", "emf_estimate_t"))
    omega, i = motor.rpm_to_electrical(100.0), np.zeros(2, np.float32)
    y["pll"]["omega"] = omega
    m, lead = flux_model(motor), 0.0
    for k in range(20_000):
        theta = omega * motor.T_s * k
        lead = float(np.angle(np.exp(1j * (theta - y["pll"]["theta"][0]))))
        wrong = 1j * motor.psi_f * (omega - voltage_drift(motor))
        turned = wrong * np.exp(1j * (y["pll"]["theta"][0] - 0.5 * omega * motor.T_s))
        u = np.array([turned.real, turned.imag], np.float32)
        c("flux_observe", p, m, x, y, i, i, u, omega, theta, k_s * lead, motor.T_s)
    assert lead == pytest.approx(APART / k_s, rel=0.01)
    assert y["pll"]["omega"][0] == pytest.approx(omega, rel=1e-3)


@pytest.mark.parametrize("name", ["brusa_hsm1", "ipmsm_2200w", "paper"])
def test_injection_moves_the_flux_as_a_turn_of_the_angle_would(c: Call, name: str) -> None:
    """At rated torque, voltages exact: all of the move shows as eps, none as a wrong length."""
    motor = Motor.load(name)
    p = np.array(control_record(motor, FLUX)["flux"]).reshape(1)
    i = motor.i_rated * np.exp(1j * np.radians(130.0))
    psi = motor.psi_f + motor.L_d * i.real + 1j * motor.L_q * i.imag
    x, y = (np.zeros(1, struct_dtype(name)) for name in ("flux_state_t", "emf_estimate_t"))
    x["psi"]["a"], x["psi"]["b"] = psi.real, psi.imag
    sample = np.array([i.real, i.imag], np.float32)
    flux = []
    for lead in (0.2, 0.0):
        c("flux_observe", p, flux_model(motor), x, y, sample, sample,
          np.float32(motor.R_s) * sample, motor.omega_rated, 0.0, lead, motor.T_s)  # fmt: skip
        flux.append(complex(x["psi"]["a"][0], x["psi"]["b"][0]))
    turn = 0.2 * float(p["k_turn"][0])
    assert y["err"][0] == pytest.approx(turn, rel=2e-3)
    assert abs(flux[1] - flux[0]) < 2e-3 * abs(flux[0] - psi)


@pytest.mark.parametrize(("carrier", "n"), [(False, 64), (True, 4)])
def test_flux_observer_does_not_slip(motor: Motor, carrier: bool, n: int) -> None:
    """Loads taken off at 1 s, at 40 to 250 r/min, under schedules that rely on the flux.

    Both where dead time is averaged and where it is switched. Without the cure: 40 to 50 degrees.
    """
    factory = Alone(motor, DriveDesign(estimator="flux", carrier=carrier))
    for name in ("eq25", "grid-flux-tuned", "logistic-flux-tuned", "reference-flux"):
        policy = make_policy(name, motor)
        policy.settings = {}
        r = rollout(policy, lasting(1.6)("unload", motor, 11, n), factory)
        assert not r.lost.any()
        assert angle_err_max_deg(r).max() < 15.0, name


def test_weighted_errors_meet_between_the_two(motor: Motor) -> None:
    """Uncompensated sources apart: one loop settles where the weighted error signals cancel.

    Near lock that is the mean of both angles by weight times slope: the injection's is 1 - L_d/L_q.
    """
    base = DriveDesign(
        estimator="smo", cross="none", mtpa=False, L_q_table=False, L_q_bias=1.0, speed_hz=1.0
    )
    at = dict(rpm=[350.0], tau=[4.0], change=make_ideal)
    own = [float(steady(motor, base, k_s=k, **at).err[0]) for k in (0.0, 1.0)]  # type: ignore[arg-type]
    one_loop = replace(base, estimator="errors")
    ends = [float(steady(motor, one_loop, k_s=k, **at).err[0]) for k in (0.0, 1.0)]  # type: ignore[arg-type]
    assert np.rad2deg(ends) == pytest.approx(np.rad2deg(own), abs=0.1)
    middle = float(np.rad2deg(steady(motor, one_loop, k_s=0.5, **at).err[0]))  # type: ignore[arg-type]
    low, high = sorted(np.rad2deg(own))
    assert low + 1.0 < middle < high - 1.0


def test_the_printed_blend_jumps_at_the_seam(c: Call, motor: Motor) -> None:
    """Eq. 26 without its wrap: 179 and -179 degrees make 0; elsewhere it is the same."""
    y, z = np.empty(2, np.float32), np.empty(2, np.float32)
    a, b = (np.array([math.radians(d), 40.0], np.float32) for d in (179.0, -179.0))
    c("blend_unwrapped", a, b, 0.5, y)
    c("blend", a, b, 0.5, z)
    assert abs(y[0]) < 1e-5 and abs(z[0]) == pytest.approx(math.pi, abs=1e-5)
    a, b = (np.array([math.radians(d), w], np.float32) for d, w in ((20.0, 40.0), (10.0, 80.0)))
    c("blend_unwrapped", a, b, 0.25, y)
    c("blend", a, b, 0.25, z)
    np.testing.assert_allclose(y, z, rtol=1e-6)


def test_the_printed_blend_shows_in_the_band(motor: Motor) -> None:
    """At half weight and 4 N m its angle error reaches a large part of half a turn now and then."""
    base = DriveDesign(estimator="smo", cross="none", mtpa=False, L_q_table=False, L_q_bias=1.0)
    rough = [
        float(np.rad2deg(steady(motor, d, [350.0], [4.0], 0.5, change=make_ideal).err_std[0]))
        for d in (base, replace(base, estimator="unwrapped"))
    ]
    assert rough[1] > 10.0 * rough[0]


def test_unnormalised_and_uncompensated_injection_still_lock(motor: Motor) -> None:
    """All that is published about injection together, at 150 r/min without load."""
    design = DriveDesign(
        estimator="smo", hfi_scheme="stationary", hfi_delay_cure=False, hfi_normalised=False
    )
    run = steady(motor, design, [150.0, 350.0], [0.0, 0.0], 1.0, change=make_ideal)
    assert run.held.all()
    step = np.rad2deg(motor.n_p * run.omega_m * motor.T_s)
    shift = (0.5 * motor.L_q + 1.5 * motor.L_d) / (motor.L_q - motor.L_d)
    np.testing.assert_allclose(np.rad2deg(run.err), shift * step, atol=0.05)
    assert RPM_TO_RAD_S * 150.0 == pytest.approx(run.omega_m[0], rel=0.01)
