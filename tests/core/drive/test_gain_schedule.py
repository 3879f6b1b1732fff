"""A schedule that sets gains: what the drive gets, when, and what stays static."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from sensorless.core.api import (
    CONTROL,
    SIGNAL_N,
    SIM,
    Array,
    ffi,
    lib,
    pointer,
    sim_run,
    sim_set_due,
    sim_signals,
)
from sensorless.core.gains import DEFAULT, GAIN_NAMES, gain_records, ranks
from sensorless.decision import decision_periods, decision_time
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.evaluation.rollout import rollout
from sensorless.machine.motor import Motor
from sensorless.observers.lock_design import answer_bounds
from sensorless.policy import TablePolicy
from sensorless.table import gain_image
from sensorless.table.ks_table import Axis, GainGrid, KsTable

AXES = (Axis("speed", 0.0, 0.6, 4), Axis("disagreement", -1.0, 1.0, 3))


def table(gains: tuple[str, ...] = GAIN_NAMES, scale: float = 1.0) -> KsTable:
    rng = np.random.default_rng(7)
    k_s = np.array([1.0, 1.0, 0.3, 0.0], dtype=np.float32)[:, None] * np.ones(3, np.float32)
    grids = tuple(
        GainGrid(
            name,
            (scale * rng.uniform(-1, 0 if name == "amplitude" else 1, (4, 3))).astype(np.float32),
        )
        for name in gains
    )
    return KsTable(AXES, k_s, gains=grids)


class Firmware:
    """``gain_schedule_*`` for one drive, as an export calls it."""

    def __init__(self, t: KsTable, design: Array, periods: int, decision: float) -> None:
        self.axes, self.k_s = t.record().reshape(1), t.stored()
        self.header = gain_image.record(t.gains, self.axes, "f32", decision)
        self.values = gain_image.stored(t.gains, "f32")
        self.design, self.live = design.reshape(1).copy(), np.zeros(1, dtype=CONTROL)
        self.params = ffi.new("gain_schedule_params_t *")
        self.params.ks.table = pointer(self.axes, "ks_table_t[]")
        self.params.ks.values = pointer(self.k_s, "char[]")
        self.params.ks.periods = periods
        self.params.ks.rule.x_min, self.params.ks.rule.x_max = t.rule
        self.params.table = pointer(self.header, "gain_table_t[]")
        self.params.values = pointer(self.values, "char[]")
        self.state = ffi.new("gain_schedule_state_t *")
        self.start()

    def _both(self) -> tuple[Any, Any]:
        return pointer(self.design, "drive_params_t[]"), pointer(self.live, "drive_params_t[]")

    def start(self) -> int:
        return int(lib.gain_schedule_init(self.params, self.state, *self._both()))

    def step(self, signals: Array) -> float:
        x = np.ascontiguousarray(signals)
        return float(lib.gain_schedule_step(self.params, self.state, *self._both(),
                                            pointer(x, "signal_state_t[]")))  # fmt: skip


@pytest.mark.parametrize("estimator", ["smo", "flux", "coupled"])
def test_a_run_and_the_firmware_agree_to_the_bit(motor: Motor, estimator: str) -> None:
    """Blocks of drives with gains, against one drive a period at a time as a target runs it."""
    factory = SimFactory(motor, DriveDesign(estimator=estimator))
    scenarios = suite("stress-1", motor, 5, 6)
    scenarios.duration[:] = 0.3
    t = table()
    run = rollout(TablePolicy("t", t), scenarios, factory)
    periods = decision_periods(motor)
    sims = factory.build(scenarios)
    schedules = [Firmware(t, c, periods, decision_time(motor)) for c in sims["control"]]
    obs = np.zeros((6, SIGNAL_N), dtype=np.float32)
    total = np.zeros_like(sims["sums"]["tau"])
    at, size = SIM.fields["control"][1], SIM["control"].itemsize  # type: ignore[index]
    control = sims.view(np.uint8).reshape(6, -1)[:, at : at + size].view(np.uint32)
    for _ in range(int(sims["k_end"].max())):
        signals = sims["drive"]["x"]["signal"]
        k_s = np.array([s.step(signals[i]) for i, s in enumerate(schedules)], np.float32)
        for words, s in zip(control, schedules, strict=True):
            words[:] = s.live.view(np.uint32)
        sim_run(sims, 1, k_s, obs, plain=True)
        total += sims["sums"]["dev_sq"]
    assert sims["control"]["L_q"]["y"].std() > 0.0
    np.testing.assert_allclose(run.sums["dev_sq"].sum(axis=0), total, rtol=1e-4)
    np.testing.assert_array_equal(run.periods, sims["k"])
    last = rollout_state(t, scenarios, factory)
    for field in ("theta", "omega"):
        np.testing.assert_array_equal(
            last["drive"]["x"]["est"][field], sims["drive"]["x"]["est"][field]
        )


def rollout_state(t: KsTable, scenarios: Any, factory: SimFactory) -> Array:
    """Drives at the end of what ``rollout`` does."""
    motor = factory.motor
    sims = factory.build(scenarios)
    gains = gain_records(sims, t.ranges, decision_time(motor))
    obs = np.zeros((len(sims), SIGNAL_N), dtype=np.float32)
    sim_signals(sims, obs)
    for _ in range(int(sims["k_end"].max()) // decision_periods(motor)):
        k_s = t.evaluate(obs)
        gains["wanted"] = t.evaluate_gains(obs)
        sim_run(sims, decision_periods(motor), k_s, obs, gains)
    return sims


def test_zero_is_the_static_drive(motor: Motor) -> None:
    factory = SimFactory(motor, DriveDesign())
    scenarios = suite("stress-1", motor, 3, 5)
    t = table(scale=0.0)
    alone = KsTable(t.axes, t.values)
    with_gains = rollout(TablePolicy("t", t), scenarios, factory)
    without = rollout(TablePolicy("t", alone), scenarios, factory)
    np.testing.assert_array_equal(with_gains.sums, without.sums)


@pytest.fixture
def firmware(motor: Motor) -> Firmware:
    sims = SimFactory(motor, DriveDesign(estimator="smo")).build(suite("stress-1", motor, 3, 1))
    return Firmware(table(), sims["control"], 5, 1e-3)


def signals_at(speed: float, motor: Motor) -> Array:
    x = np.zeros(1, dtype=SIM["drive"]["x"]["signal"])
    x["omega"] = speed * motor.omega_rated
    return x


def test_bandwidths_set_both_gains_of_a_loop(firmware: Firmware, motor: Motor) -> None:
    for _ in range(500):
        firmware.step(signals_at(0.3, motor))
    design, live = firmware.design[0], firmware.live[0]
    for loop, j in (("smo", 0), ("hfi", 1)):
        x = firmware.header["limit"][0, j]
        v = float(firmware.state.value[j])
        factor = 1.0 + v * (float(x["rise"]) + float(x["bend"]) * v)
        assert abs(factor - 1.0) > 0.01
        assert live[loop]["pll"]["k_p"] == pytest.approx(design[loop]["pll"]["k_p"] * factor)
        assert live[loop]["pll"]["k_i"] == pytest.approx(design[loop]["pll"]["k_i"] * factor**2)
    assert live["hfi"]["u_inj"] < design["hfi"]["u_inj"]
    factors = (live["L_q"]["y"] / design["L_q"]["y"]).round(5)
    assert len(set(factors)) == 1 and factors[0] != 1.0
    here, there = live["lock"]["L_q_true"], design["lock"]["L_q_true"]
    assert here * live["L_q"]["y"][0] == pytest.approx(there * design["L_q"]["y"][0])


@pytest.mark.parametrize("name", ["formula_wheel", "pmsrm_15kw"])
def test_bounds_on_the_answer_follow_the_injected_voltage(name: str) -> None:
    """Dead time may take a larger share of less voltage; the value 0 is the static drive."""
    motor = Motor.load(name)
    sims = SimFactory(motor, DriveDesign()).build(suite("stress-1", motor, 3, 1))
    for value in (0.0, -1.0):
        grid = GainGrid("amplitude", np.full((4, 3), value, np.float32))
        t = KsTable(AXES, np.ones((4, 3), np.float32), gains=(grid,))
        firmware = Firmware(t, sims["control"], 5, 1e-3)
        for _ in range(500):
            firmware.step(signals_at(0.3, motor))
        live, design = firmware.live[0], firmware.design[0]
        assert live["hfi"]["u_inj"] == pytest.approx((1.0 + 0.5 * value) * motor.u_inj, rel=1e-4)
        if value == 0.0:
            assert live.tobytes() == design.tobytes()
        else:
            half = replace(motor, u_inj=0.5 * motor.u_inj)
            bounds = answer_bounds(half)
            assert live["lock"]["answer"] == pytest.approx(bounds["answer"], rel=1e-3)
            assert live["lock"]["rest"] <= live["lock"]["answer"] < 0.4 * design["lock"]["answer"]
            most = design["lock"]["above"] * (live["hfi"]["u_inj"] + design["lock"]["u_unsure"])
            assert live["lock"]["most"] == pytest.approx(most, rel=1e-5)


def test_one_gain_a_period_after_the_decision(firmware: Firmware, motor: Motor) -> None:
    moved = []
    for _ in range(5):
        before = [float(v) for v in firmware.state.value]
        firmware.step(signals_at(0.2, motor))
        after = [float(v) for v in firmware.state.value]
        moved.append([j for j in range(4) if after[j] != before[j]])
    assert moved == [[], [0], [1], [2], [3]]


@pytest.mark.parametrize(("periods", "n"), [(1, 4), (2, 3), (3, 4), (5, 4), (25, 2)])
def test_every_gain_is_due_once(periods: int, n: int) -> None:
    names = ranks(GAIN_NAMES)[:n]
    sims = np.zeros(2, dtype=SIM)
    gains = gain_records(sims, {name: DEFAULT[name] for name in names}, 1.0)
    gains["wanted"] = -1.0
    moved = []
    for period in range(periods):
        gains["value"] = 0.0
        sim_set_due(sims, gains, period, periods)
        moved += list(np.flatnonzero(gains["value"][1]))
    assert moved == list(range(n))


def test_a_refused_grid_leaves_gains_static(firmware: Firmware, motor: Motor) -> None:
    firmware.values[3] = 0.25
    assert firmware.start() == lib.KS_BAD_CRC
    weights = [firmware.step(signals_at(0.3, motor)) for _ in range(20)]
    assert weights[0] == pytest.approx(table().evaluate(_obs(0.3))[0])
    assert firmware.state.ks.fault == lib.KS_FAULT_GAINS
    assert firmware.live.tobytes() == firmware.design.tobytes()


@pytest.mark.parametrize("bit", range(31))
def test_a_damaged_check_makes_gains_static(firmware: Firmware, motor: Motor, bit: int) -> None:
    for _ in range(50):
        firmware.step(signals_at(0.3, motor))
    assert firmware.live.tobytes() != firmware.design.tobytes()
    firmware.state.check ^= 1 << bit
    firmware.step(signals_at(0.3, motor))
    assert firmware.state.ks.fault == lib.KS_FAULT_GAINS
    assert firmware.live.tobytes() == firmware.design.tobytes()


def test_a_bad_signal_leaves_gains_as_they_are(firmware: Firmware, motor: Motor) -> None:
    for _ in range(50):
        firmware.step(signals_at(0.3, motor))
    held = firmware.live.tobytes()
    for _ in range(50):
        firmware.step(signals_at(float("nan"), motor))
    assert firmware.live.tobytes() == held
    assert firmware.state.ks.fault == lib.KS_FAULT_INPUT


@pytest.mark.parametrize("at", [0, 12, 2**20, 2**32 - 1])
def test_a_damaged_place_reads_no_node_and_leaves_gains_as_they_are(
    firmware: Firmware, motor: Motor, at: int
) -> None:
    while firmware.state.next != 1:
        firmware.step(signals_at(0.2, motor))
    held = [float(v) for v in firmware.state.value]
    assert firmware.state.cell.at != at
    firmware.state.cell.at = at
    firmware.step(signals_at(0.2, motor))
    assert [float(v) for v in firmware.state.value] == held
    assert firmware.state.ks.fault == lib.KS_FAULT_INPUT
    for _ in range(5):
        firmware.step(signals_at(0.2, motor))
    assert [float(v) for v in firmware.state.value] != held


def _obs(speed: float) -> Array:
    obs = np.zeros((1, SIGNAL_N), dtype=np.float32)
    obs[0, 0] = speed
    return obs


@pytest.mark.parametrize("estimator", ["smo", "flux", "coupled"])
@pytest.mark.parametrize("gains", [GAIN_NAMES, ("l_q",), ()])
def test_any_damaged_parameter_is_restored(
    motor: Motor, estimator: str, gains: tuple[str, ...]
) -> None:
    """A gain's words come back with its decision, others one by one, and are told."""
    sims = SimFactory(motor, DriveDesign(estimator=estimator)).build(suite("stress-1", motor, 3, 1))
    both = [Firmware(table(gains or ("l_q",)), sims["control"], 5, 1e-3) for _ in range(2)]
    signals = signals_at(0.3, motor)
    for firmware in both:
        if not gains:
            firmware.values[3] = 0.25
            firmware.start()
        for _ in range(100):
            firmware.step(signals)
    firmware, sound = both
    words, wanted = firmware.live.view(np.uint32), sound.live.view(np.uint32)

    def settle(periods: int) -> None:
        for _ in range(periods):
            firmware.step(signals)
            sound.step(signals)
        np.testing.assert_array_equal(words, wanted)

    gain_words = set(np.flatnonzero(wanted != firmware.design.view(np.uint32)))
    assert firmware.state.ks.fault in (0, lib.KS_FAULT_GAINS) and bool(gain_words) == bool(gains)
    for word in range(words.size):
        firmware.state.ks.fault, firmware.state.word = 0, word
        words[word] ^= 0x7FC00001
        settle(11)
        told = bool(firmware.state.ks.fault & lib.KS_FAULT_PARAMS)
        assert told == (word not in gain_words), word
    words[7] ^= 1
    firmware.state.word = 0xFFFFFFFF
    settle(5 * words.size + 5)
