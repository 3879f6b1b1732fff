"""Replay of recorded logs: the closed loop's estimates, the injection's sign, the sample."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.words import plan_from
from sensorless.errors import UserError
from sensorless.evaluation.trace import Trace, trace
from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.policy import TablePolicy
from sensorless.replay.log import write_log
from sensorless.replay.replay import SAMPLE, Replay, load, replay
from sensorless.table.ks_table import Axis, GainGrid, KsTable
from tests.helpers.sample import replayed_sample

MOTOR = Motor.load("paper")
DESIGN = DriveDesign(estimator="smo", carrier=True)


def wrapped(x: Floats) -> Floats:
    return np.asarray(np.remainder(x + np.pi, 2.0 * np.pi) - np.pi)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Trace, Path]:
    """From standstill through the band with carrier, dead time, noise and load, and its log."""
    case = plan_from("0:550", "0:0,0.2:3", 1500.0, 0.6, MOTOR, 1)
    run = trace(make_policy("eq25", MOTOR), case, MOTOR, DESIGN)
    path = tmp_path_factory.mktemp("log") / "log.csv"
    write_log(run, path)
    return run, path


@pytest.fixture(scope="module")
def found(recorded: tuple[Trace, Path]) -> Replay:
    """The recorded run, replayed as it was driven."""
    return again(recorded[1])


def again(path: Path, policy: str = "eq25", **start: float) -> Replay:
    log = load(path, MOTOR, DESIGN)
    return replay(log, MOTOR, DESIGN, make_policy(policy, MOTOR), **start)


def drop(path: Path, out: Path, *names: str, rows: int | None = None) -> Path:
    """The log without some columns, and only its first rows if so asked."""
    table = [line.split(",") for line in path.read_text().splitlines()[:rows]]
    keep = [j for j, name in enumerate(table[0]) if name not in names]
    assert len(keep) == len(table[0]) - len(names)
    out.write_text("\n".join(",".join(row[j] for j in keep) for row in table) + "\n")
    return out


def test_the_estimates_are_those_of_the_closed_loop(
    recorded: tuple[Trace, Path], found: Replay
) -> None:
    """Same inputs, same angles to the rounding of a float, same weight to the bit."""
    run, _ = recorded
    assert 0.0 < np.mean(found.k_s) < 1.0
    assert np.array_equal(found.k_s, run["k_s"])
    for name, column in (("hfi", "_hfi"), ("smo", "_smo"), ("blend", "")):
        error = found.error(name)
        assert error is not None
        assert np.max(np.abs(wrapped(error - run[f"theta_e_err{column}"]))) < 2e-6
    speed = found.estimates["blend"].omega_e / MOTOR.n_p
    assert np.max(np.abs(speed - run["omega_m_hat"])) < 1e-4


def test_the_encoder_is_for_the_error_alone(
    recorded: tuple[Trace, Path], found: Replay, tmp_path: Path
) -> None:
    blind = again(drop(recorded[1], tmp_path / "blind.csv", "theta_e"))
    assert blind.error("ekf") is None
    for name, estimate in found.estimates.items():
        assert np.array_equal(blind.estimates[name].theta_e, estimate.theta_e)
    assert math.isnan(blind.summary()["ekf"]["rms_deg"])


@pytest.mark.usefixtures("without_ekf")
def test_the_sign_of_the_injection_is_in_the_voltage(
    recorded: tuple[Trace, Path], found: Replay, tmp_path: Path
) -> None:
    """Without the recorded sign all periods but a few count as before, for the same angle."""
    inferred = again(drop(recorded[1], tmp_path / "no_sign.csv", "inj"))
    differ = found.estimates["hfi"].valid != inferred.estimates["hfi"].valid
    assert 0 < differ.sum() < 10
    assert found.estimates["hfi"].valid.mean() > 0.5
    apart = found.estimates["hfi"].theta_e - inferred.estimates["hfi"].theta_e
    assert np.max(np.abs(wrapped(apart))) < math.radians(0.5)


AT_REST = 1100
"""Rows of the log up to 0.22 s."""


def hfi_error(found: Replay) -> Floats:
    """Angle error of the injection estimator at standstill and without load [deg]."""
    error = found.error("hfi")
    assert error is not None
    at = (found.log.t > 0.1) & (found.log.t < 0.2)
    assert np.all(found.estimates["hfi"].valid[at])
    return np.asarray(np.rad2deg(error[at]))


@pytest.mark.usefixtures("without_ekf")
def test_recorded_signs_turned_round_turn_the_angle(
    recorded: tuple[Trace, Path], tmp_path: Path
) -> None:
    """The answer to the injection is taken for its opposite: half a turn."""
    _, path = recorded
    rows = [line.split(",") for line in path.read_text().splitlines()[:AT_REST]]
    j = rows[0].index("inj")
    turned = [rows[0], *([*r[:j], str(-int(r[j])), *r[j + 1 :]] for r in rows[1:])]
    (tmp_path / "turned.csv").write_text("\n".join(",".join(r) for r in turned) + "\n")
    assert np.min(np.abs(hfi_error(again(tmp_path / "turned.csv")))) > 170.0


def test_recorded_signs_against_the_voltage_are_named(
    recorded: tuple[Trace, Path], found: Replay, tmp_path: Path
) -> None:
    """By the encoder, and not taken for one whose zero is off."""
    table = [line.split(",") for line in recorded[1].read_text().splitlines()]
    at = table[0].index("inj")
    for row in table[1:]:
        row[at] = str(-int(row[at]))
    path = tmp_path / "log.csv"
    path.write_text("\n".join(map(",".join, table)) + "\n")
    turned = again(path)
    assert [note for note in turned.notes if note.startswith("inj has the wrong sign")]
    assert not [note for note in turned.notes if "encoder" in note]
    assert turned.log.doubtful
    assert found.notes == () and not found.log.doubtful


@pytest.mark.usefixtures("without_ekf")
@pytest.mark.parametrize("start", [-60.0, 130.0])
def test_injection_from_a_wrong_start(
    start: float, recorded: tuple[Trace, Path], tmp_path: Path
) -> None:
    """The recorded sign leads home from anywhere; one read from the voltage to the near pole."""
    log = drop(recorded[1], tmp_path / "log.csv", rows=AT_REST)
    theta_0 = math.radians(start)
    assert np.max(np.abs(hfi_error(again(log, theta_0=theta_0)))) < 10.0
    found = again(drop(log, tmp_path / "no_sign.csv", "inj"), theta_0=theta_0)
    to_pole = 0.0 if abs(start) < 90.0 else 180.0
    assert np.max(np.abs(np.abs(hfi_error(found)) - to_pole)) < 10.0


def test_duties_instead_of_voltages(
    recorded: tuple[Trace, Path], found: Replay, tmp_path: Path
) -> None:
    by_duty = again(drop(recorded[1], tmp_path / "duty.csv", "u_alpha", "u_beta")).summary(0.1)
    by_voltage = found.summary(0.1)
    for name in by_voltage:
        assert by_duty[name]["rms_deg"] == pytest.approx(by_voltage[name]["rms_deg"], abs=0.7)


def test_the_coupled_observer_has_what_either_of_its_sources_has() -> None:
    """Whatever the weight; the Kalman filter has an EMF of its own, or the injection."""
    found = replayed_sample()
    valid = {name: estimate.valid for name, estimate in found.estimates.items()}
    assert found.observer == "flux alone"
    assert np.array_equal(valid["blend"], valid["hfi"] | valid["smo"])
    assert np.all(valid["ekf"][valid["hfi"]]) and not np.array_equal(valid["ekf"], valid["blend"])


def test_sample_log() -> None:
    """Carrier and dead time: at medium speed the filter is within 2 degrees.

    The SMO, whose q inductance is set low on purpose, is the worst while the load comes on.
    """
    found = again(SAMPLE)
    assert SAMPLE.stat().st_size < 300_000
    assert found.summary(0.4)["ekf"]["max_deg"] < 2.0
    assert found.summary(0.05)["ekf"]["rms_deg"] < 2.0
    for name, row in found.summary(0.05).items():
        assert 0.5 < row["share"] <= 1.0
        assert 0.0 < row["max_deg"] < (14.0 if name == "smo" else 12.0)
    assert found.log.inj is not None
    assert set(found.log.inj) == {-1.0, 0.0, 1.0}


def test_csv_and_table(found: Replay, tmp_path: Path) -> None:
    found.write_csv(tmp_path / "out.csv")
    rows = np.genfromtxt(tmp_path / "out.csv", delimiter=",", names=True)
    assert rows.dtype.names is not None
    assert len(rows) == len(found.log.t)
    for name in found.estimates:
        error = wrapped(rows["theta_e"] - rows[f"theta_e_hat_{name}"])
        assert wrapped(error - rows[f"theta_e_err_{name}"]) == pytest.approx(0.0, abs=1e-6)
        assert f"omega_e_hat_{name}" in rows.dtype.names
    assert len(found.table(0.1).rows) == 4
    with pytest.raises(UserError, match="after: 9 s"):
        found.summary(9.0)


@pytest.mark.parametrize("policy", ["sensored", "oracle"])
def test_a_policy_with_the_truth_is_refused(policy: str) -> None:
    with pytest.raises(UserError, match="needs the true angle"):
        again(SAMPLE, policy=policy)


def test_another_machine_with_another_period_is_refused() -> None:
    with pytest.raises(UserError, match=r"has T_s = 0\.0001 s"):
        load(SAMPLE, replace(MOTOR, T_s=1e-4), DESIGN)
    with pytest.raises(UserError, match="delay: 3"):
        load(SAMPLE, MOTOR, DESIGN, delay=3)


def test_a_schedule_with_gains_is_refused(recorded: tuple[Trace, Path]) -> None:
    grids = (GainGrid("l_q", np.zeros(2, np.float32)),)
    table = KsTable((Axis("speed", 0.0, 1.0, 2),), np.ones(2, np.float32), gains=grids)
    with pytest.raises(UserError, match="'t' also sets gains"):
        replay(load(recorded[1], MOTOR, DESIGN), MOTOR, DESIGN, TablePolicy("t", table))


@pytest.mark.parametrize(
    ("k_s", "led"), [(0.96, "hfi"), (0.04, "smo"), (0.06, "both"), (0.94, "both")]
)
def test_the_blend_has_the_signal_of_what_it_weighs(
    recorded: tuple[Trace, Path], k_s: float, led: str
) -> None:
    """Of two separate estimators, in the samples in which the weight has arrived."""
    table = KsTable((Axis("speed", 0.0, 1.0, 2),), np.full(2, k_s, np.float32))
    made = replay(load(recorded[1], MOTOR, DESIGN), MOTOR, DESIGN, TablePolicy("one", table))
    there = np.abs(made.k_s - k_s) < 1e-6
    hfi, smo, blend = (made.estimates[name].valid[there] for name in ("hfi", "smo", "blend"))
    assert np.array_equal(blend, {"hfi": hfi, "smo": smo, "both": hfi | smo}[led])
    assert not np.array_equal(hfi, smo) and smo.any() and hfi.any() and there.mean() > 0.9


def test_a_rotor_that_turns_backward_shows_as_much(found: Replay) -> None:
    """The machine's mirror image: phases b and c swapped, as are the signs of angle and u_beta."""
    log = found.log
    assert log.theta_e is not None
    i_c = -log.i.sum(axis=1)
    mirrored = replace(
        log, u=log.u * (1.0, -1.0), i=np.stack([log.i[:, 0], i_c], axis=-1), theta_e=-log.theta_e
    )
    there, back = (
        replay(each, MOTOR, DESIGN, make_policy("eq25", MOTOR)).summary()["ekf"]
        for each in (log, mirrored)
    )
    assert back["share"] == pytest.approx(there["share"], abs=0.01)
    assert back["mean_deg"] == pytest.approx(-there["mean_deg"], abs=0.2)


def test_after_counts_from_the_first_row_on(found: Replay) -> None:
    late = replace(found, log=replace(found.log, t=found.log.t + 4.0))
    after, before = (each.summary(0.3)["blend"]["rms_deg"] for each in (late, found))
    assert after == pytest.approx(before, rel=1e-3)
    assert abs(after - found.summary()["blend"]["rms_deg"]) > 0.1


@pytest.mark.parametrize(("times", "allowed"), [(9.9, True), (-9.9, True), (-10.1, False)])
def test_the_first_speed_is_at_most_ten_times_rated(
    recorded: tuple[Trace, Path], times: float, allowed: bool
) -> None:
    if allowed:
        again(recorded[1], omega_0=times * MOTOR.omega_rated)
        return
    with pytest.raises(UserError, match="at most 15000 r/min"):
        again(recorded[1], omega_0=times * MOTOR.omega_rated)
