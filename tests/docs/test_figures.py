"""Figures of the pages that follow from the code: sizes, gains, poles, a run."""

import math
import re
from collections.abc import Iterator

import numpy as np
import pytest

from sensorless.core.api import SIM, ffi, lib
from sensorless.design.derived import Derived, derive
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.words import plan_from
from sensorless.evaluation.trace import trace
from sensorless.evaluation.trace_summary import plateaus
from sensorless.machine.motor import Motor
from sensorless.machine.saliency import LEAST
from sensorless.observers.coupled_design import Bandwidths, bandwidths, layer
from sensorless.observers.hfi_design import hf_current
from sensorless.observers.lock_design import most_answer
from sensorless.observers.start_design import peaks, polarity_pulse
from sensorless.observers.tracking import dead_time_noise, flux_noise
from sensorless.policies.registry import make_policy
from sensorless.suitability import seen
from tests.helpers.documentation import ROOT, text

DOCS = ROOT / "docs"
LANES = 16
"""Drives of a block."""


def cells(page: str, first: str) -> list[str]:
    """Cells after the first of the last row of a page that begins with ``first``."""
    rows = re.findall(rf"^\| {re.escape(first)} \|(.*)\|$", (DOCS / page).read_text(), re.MULTILINE)
    return [cell.strip() for cell in rows[-1].split("|")]


def near(told: str, value: float) -> bool:
    """Whether a number is told to the digits that it is told in."""
    decimals = len(told.partition(".")[2])
    return abs(float(told) - value) <= 0.51 * 10.0**-decimals


def test_sizes_of_a_drive_and_of_a_block() -> None:
    size = SIM.itemsize
    page = text(DOCS / "performance.md")
    assert f"A drive is {size} bytes, {size // 8} units" in page
    assert f"a block is {LANES * size / 1000:.0f} kB" in page
    assert f"of which {size / 1000:.1f} kB are the drive with its twin" in page


def test_units_that_a_block_leaves_out() -> None:
    header = (ROOT / "build" / "generated" / "sim_fields.h").read_text(encoding="utf-8")
    (runs,) = re.findall(r"#define SIM_UNIT_RUNS \{(.*)\}", header)
    copied = sum(int(end) - int(first) for first, end in re.findall(r"\{(\d+), (\d+)\}", runs))
    left = SIM.itemsize // 8 - copied
    assert f"leaves out the {left} units" in text(DOCS / "performance.md")


def test_trust_near_zero_current() -> None:
    page = text(DOCS / "coupled-observer.md")
    told = re.findall(r"`(\w+)` with ([\d.]+)(?: σ)? and `(\w+)` with ([\d.]+),", page)[0]
    for name, value in (told[:2], told[2:]):
        motor = Motor.load(name)
        assert near(value, dead_time_noise(motor) / flux_noise(motor)), name


def test_bounds_on_the_answer_of_the_injection() -> None:
    page = text(DOCS / "lock-trials.md")
    out = re.findall(
        r"at ([\d.]+) times the answer .* on `(\w+)` and at ([\d.]+) times on `(\w+)`", page
    )
    value, name, other_value, other = out[0]
    for told, motor in ((value, Motor.load(name)), (other_value, Motor.load(other))):
        assert near(told, most_answer(motor) / hf_current(motor)), motor.name


@pytest.mark.parametrize("name", ["README.md", "docs/index.md"])
def test_memory_of_a_drive_with_its_schedule(name: str) -> None:
    state = ffi.sizeof("drive_state_t") + ffi.sizeof("ks_schedule_state_t")
    assert f"at most {state} bytes of RAM" in text(ROOT / name)


def test_estimated_time_of_a_period() -> None:
    page = text(DOCS / "index.md")
    told = re.search(
        r"at ([\d.]+) to (\d+) cycles an instruction .* (\d+) take .* at (\d+) MHz", page
    )
    assert told is not None
    low, high, instructions, megahertz = map(float, told.groups())
    assert f"at most {instructions:.0f} instructions" in page
    first, last = (f"{cycles * instructions / megahertz:.0f}" for cycles in (low, high))
    for name in ("README.md", "docs/index.md"):
        assert f"{first} to {last} µs at {megahertz:.0f} MHz" in text(ROOT / name)


def test_shaft_that_a_load_moves_before_the_rotor_is_found() -> None:
    motor = Motor.load("paper")
    plan = plan_from("0:0", "0:14", None, 0.5, motor, 0, start=True, theta_err=180.0)
    run = trace(make_policy("eq25", motor), plan, motor, DriveDesign())
    speed = np.abs(run["omega_m"]) * 30.0 / math.pi
    found = np.flatnonzero(run["starting"])[-1]
    page = text(DOCS / "index.md")
    assert f"at {speed[found]:.0f} r/min when it is found, and at {speed.max():.0f} before" in page


def test_what_none_lost_of_many_means() -> None:
    """Exact upper end of the 95 % interval (Clopper and Pearson)."""
    (size, told) = re.findall(r"0 of (\d+) means at most ([\d.]+) %", text(DOCS / "index.md"))[0]
    assert near(told, 100.0 * (1.0 - 0.025 ** (1.0 / int(size))))


def test_power_of_the_motors_that_are_named() -> None:
    named = re.findall(r"`(\w+)` \(([\d.]+) kW\)", text(DOCS / "index.md"))
    assert len(named) == 3
    for name, told in named:
        motor = Motor.load(name)
        assert near(told, motor.tau_rated * motor.omega_rated / motor.n_p / 1000.0), name


def test_memory_of_gains() -> None:
    more = ffi.sizeof("drive_params_t")
    more += ffi.sizeof("gain_schedule_state_t") - ffi.sizeof("ks_schedule_state_t")
    assert f"takes {more} bytes more" in text(DOCS / "firmware-engineers.md")
    assert f"bytes of RAM; {more} more if" in text(DOCS / "index.md")


def test_words_that_the_check_of_the_state_adds() -> None:
    words = np.eye(ffi.sizeof("drive_state_t") // 4, dtype=np.float32)
    counted = sum(lib.drive_sum(ffi.cast("drive_state_t *", ffi.from_buffer(w))) for w in words)
    assert f"each of {counted:.0f} words" in text(DOCS / "integrate-the-table.md")


def test_gains_of_the_papers_machine() -> None:
    numbers = derive(Motor.load("paper"), DriveDesign())
    table = (DOCS / "gains.md").read_text(encoding="utf-8")
    told = {
        name: row.rsplit("|", 2)[1].split()[0]
        for row in re.findall(r"^\| `.*\|$", table, re.MULTILINE)
        for name in re.findall(r"`(\w+)`", row.split("|")[1])
        if name in Derived.__dataclass_fields__
    }
    assert set(told) == set(Derived.__dataclass_fields__)
    for name, word in told.items():
        assert near(word, getattr(numbers, name)), name


MACHINES = ("paper", "ipmsm_2200w", "pmsyrm_5600w")


def of(name: str) -> tuple[Motor, Bandwidths]:
    motor = Motor.load(name)
    return motor, bandwidths(motor, derive(motor, DriveDesign()).speed_hz)


@pytest.mark.parametrize("name", MACHINES)
def test_bandwidths_of_the_coupled_observer(name: str) -> None:
    motor, at = of(name)
    hertz = [w / (2.0 * math.pi) for w in (at.flux, at.load, at.injection)]
    (table,) = re.findall(
        rf"W \[Hz\].*?^\| `{name}` \|(.*?)\|$",
        (DOCS / "coupled-gains.md").read_text(encoding="utf-8"),
        re.MULTILINE | re.DOTALL,
    )
    for told, value in zip(table.split("|"), [*hertz, layer(motor)], strict=True):
        assert near(told.strip(), value)


def test_flux_over_the_auxiliary_flux() -> None:
    """At rated current and most torque from it, on the motor where the two differ most."""
    motor = Motor.load("brusa_hsm1")
    i = motor.i_rated * np.exp(1j * np.linspace(0.5 * np.pi, np.pi, 9001))
    psi = motor.psi_f + motor.L_d * i.real + 1j * motor.L_q * i.imag
    best = np.argmax((psi.conj() * i).imag)
    ratio = (psi / (psi - motor.L_q * i.real - 1j * motor.L_d * i.imag))[best]
    told = f"ψ̂ is ({ratio.real:.2f} + {ratio.imag:.2f}j) ψ_a: {1.0 - ratio.real:.1f} φ stayed in ε"
    assert f"{told}, and {ratio.imag:.2f} φ went into σ" in text(DOCS / "coupled-observer.md")


def told_poles(name: str) -> Iterator[tuple[str, str]]:
    """Magnitudes of real and imaginary parts [Hz] that the page tells."""
    (row,) = re.findall(
        rf"outer and load \|.*?^\| `{name}` \|(.*?)\|$",
        (DOCS / "coupled-observer.md").read_text(encoding="utf-8"),
        re.MULTILINE | re.DOTALL,
    )
    for real, imaginary in re.findall(r"([\d.]+)(?: ± ([\d.]+)j)?", row):
        yield from [(real, imaginary)] * 2 if imaginary else [(real, "0")]


@pytest.mark.parametrize("name", MACHINES)
def test_poles_of_the_coupled_observer(name: str) -> None:
    """At standstill and full weight; states: phi, nu, delta, omega - omega_hat, l."""
    _, at = of(name)
    W, r, Omega = at.flux, at.load, at.injection
    k_p, k_i, k_l = 2 * W + r, W**2 + 2 * W * r, W**2 * r
    k_h, k_b = 2 * Omega, Omega**2
    loop = np.array(
        [
            [0.0, -1.0, -k_h, 0.0, 0.0],
            [0.0, 0.0, k_b, 0.0, 0.0],
            [k_p, 0.0, -k_p - k_h, 1.0, 0.0],
            [k_i, 0.0, -k_i, 0.0, -1.0],
            [-k_l, 0.0, k_l, 0.0, 0.0],
        ]
    )
    poles = np.linalg.eigvals(loop) / (2.0 * math.pi)
    told = list(told_poles(name))
    assert len(told) == 5
    for real, imaginary in told:
        assert any(near(real, -p.real) and near(imaginary, abs(p.imag)) for p in poles), real
    assert np.all(-poles.real / np.abs(poles) > 0.6)


def test_saliency_that_a_check_asks_for() -> None:
    limit, no = seen.RATIO
    page = text(DOCS / "bring-a-motor.md")
    assert f"only above {limit:g} is there room" in page
    assert f"less than {limit:g} somewhere is *with limits*" in page
    assert f"below {no:g} within rated current is *no*" in page
    assert f"a machine below {LEAST:g} at zero current is refused" in page


def test_pulse_of_the_start() -> None:
    motor = Motor.load("paper")
    pulse = polarity_pulse(motor)[0]
    plus, minus = peaks(motor, pulse)
    wanted = (
        f"{pulse:.3f} Vs ({pulse / 8e-4:.0f} V for 0.8 ms), {plus:.2f} A against {-minus:.2f} A"
    )
    assert wanted in text(DOCS / "how-it-works.md")


def test_steps_of_fig_9() -> None:
    motor = Motor.load("paper")
    policy = make_policy("sliding_mode", motor)
    plan = plan_from("0:200,1:350,2:600", "0:0", None, 3.0, motor, 0)
    for found in plateaus(trace(policy, plan, motor, DriveDesign())):
        told = cells("published-and-corrected.md", f"{found['target_rpm']:.0f}")
        names = ("settled_s", "overshoot_pct", "k_s", "angle_err_steady_deg")
        assert all(near(a, found[name]) for a, name in zip(told, names, strict=True)), told
