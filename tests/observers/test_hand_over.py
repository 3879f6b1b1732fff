"""The end of Eq. 25's band: where the voltages carry the angle alone."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

from sensorless.baselines.linear import EQ25_BAND, eq25_band, linear_table
from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import SuiteRows
from sensorless.errors import UserError
from sensorless.evaluation.evaluate import score
from sensorless.machine.motor import Motor
from sensorless.observers.hand_over import UNAIDED, unaided_speed
from sensorless.observers.tracking import unknown_drift
from sensorless.policies.registry import RULES, make_policy
from sensorless.policy import TablePolicy

NAMES = (
    "paper", "ipmsm_2200w", "pmsyrm_5600w", "pmsrm_15kw", "ebike_hub", "brusa_hsm1",
    "formula_wheel",
)  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_a_flux_error_that_is_integrated_in_time_leans_as_far(name: str) -> None:
    """With the gains that ship, at that speed, after the drift has come at once."""
    motor = Motor.load(name)
    p = control_record(motor, DriveDesign())["coupled"]
    b, zeta = float(p["gain_0"]) / motor.T_s, float(p["gain_w"]) / motor.T_s
    w, v = unaided_speed(motor), unknown_drift(motor)
    decay = 2.0 * (b + zeta * w)
    loop = np.array([[0.0, w], [-w, -decay]])  # of phi and a: docs/coupled-observer.md
    step = expm(0.01 / w * np.block([[loop, np.array([[v], [0.0]])], [np.zeros((1, 3))]]))
    x, phi = np.array([0.0, 0.0, 1.0]), []
    for _ in range(4000):
        x = step @ x
        phi.append(x[0])
    assert phi[-1] == pytest.approx(UNAIDED, rel=1e-3)
    assert max(phi) < 1.6 * UNAIDED


def test_the_shipped_machines() -> None:
    """The paper's band, but where dead time or resistance take most of the EMF at its end."""
    ends = {name: eq25_band(Motor.load(name)) for name in NAMES}
    assert {name: band[1] for name, band in ends.items() if band != EQ25_BAND} == {
        "brusa_hsm1": pytest.approx(0.360, abs=5e-4),
        "formula_wheel": pytest.approx(0.326, abs=5e-4),
    }
    assert all(band[0] == EQ25_BAND[0] for band in ends.values())


@pytest.mark.parametrize("name", NAMES)
def test_every_rule_starts_from_the_band_of_its_machine(name: str) -> None:
    """As ``eq25`` does: no rule is judged, or tuned from, another machine's."""
    motor = Motor.load(name)
    low, high = eq25_band(motor)
    for rule in ("linear", "smoothstep", "sine", "sliding_mode", "flux_observer", "error_blend"):
        assert RULES[rule].parse(rule, None, motor) == {"lo": low, "hi": high}, rule
    logistic, gated, ramp = (RULES[x].parse(x, None, motor) for x in ("logistic", "gated", "ramp"))
    assert logistic["speed"] == pytest.approx(0.5 * (low + high))
    assert logistic["width"] == pytest.approx(high - low)
    assert gated["lo"] == low and gated["hi"] == high <= gated["force"]
    assert ramp["hi"] - ramp["lo"] == pytest.approx(0.05 * (low + high))
    assert ramp["hi"] + ramp["lo"] == pytest.approx(low + high)
    assert RULES["quadratic"].parse("quadratic", None, motor) == {"corner": high}
    given = RULES["linear"].parse("linear:lo=10", "lo=10", motor)
    assert given == {"lo": 10.0 / motor.n_rated_rpm, "hi": high}


def test_it_ends_at_rated_speed_at_most() -> None:
    motor = replace(Motor.load("brusa_hsm1"), dead_time=1e-5)
    assert unaided_speed(motor) > motor.omega_rated
    assert eq25_band(motor) == (EQ25_BAND[0], 1.0)


@pytest.mark.parametrize("value", [0.0, -1.0])
@pytest.mark.parametrize("field", ["R_s", "L_d", "psi_f", "T_s", "n_rated_rpm", "i_rated"])
def test_numbers_that_no_file_may_have_are_the_drives_to_refuse(field: str, value: float) -> None:
    changed: dict[str, Any] = {field: value}
    motor = replace(Motor.load("paper"), **changed)
    assert eq25_band(motor) == EQ25_BAND
    with pytest.raises(UserError, match=field):
        SimFactory(motor, DriveDesign()).build(SuiteRows("nominal", motor, 1, 1).draw())


def test_a_hot_winding_does_not_slip_beyond_the_band() -> None:
    """Braking drives with 1.4 times the resistance: whole turns under the paper's band."""
    motor = Motor.load("formula_wheel")
    rows = SuiteRows("mismatch", motor, 730211, 512).draw()[np.array([12, 114, 157, 253, 400])]
    factory = SimFactory(motor, DriveDesign())
    paper, own = (
        score(policy, rows, factory).metrics["angle_err_max_deg"]
        for policy in (
            TablePolicy("paper", linear_table(*EQ25_BAND)), make_policy("eq25", motor),
        )
    )  # fmt: skip
    assert np.all(paper > 170.0) and np.all(own < 45.0)
