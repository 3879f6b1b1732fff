"""Recorded logs: what can be read, how voltages are given, and what is said about a bad one."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from sensorless.errors import UserError
from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Motor
from sensorless.machine.phases import clarke, duties
from sensorless.replay.log import Log, read_log

MOTOR = Motor.load("paper")
N = 40
K = np.arange(N)
U = 100.0 * np.exp(1j * 0.05 * K)
I_AB = 3.0 * np.exp(1j * (0.05 * K - 1.0))
PHASES = np.exp(-2j * np.pi * np.arange(3) / 3.0)

Columns = dict[str, Floats]
Read = Callable[..., Log]


def columns() -> Columns:
    i = (I_AB[:, None] * PHASES).real
    return {
        "t": 0.5 + K * MOTOR.T_s,
        "i_a": i[:, 0],
        "i_b": i[:, 1],
        "u_alpha": U.real,
        "u_beta": U.imag,
    }


def write(path: Path, values: Columns) -> Path:
    lines = [",".join(values)]
    lines += [",".join(f"{x:.9g}" for x in row) for row in np.stack(list(values.values()), axis=-1)]
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.fixture
def read(tmp_path: Path) -> Read:
    def reader(values: Columns, u_dt: float = 0.0, delay: int = 0) -> Log:
        file = write(tmp_path / "log.csv", values)
        return read_log(file, MOTOR, u_dt=u_dt, inv_i_dt=1e3, delay=delay)

    return reader


def test_a_voltage_is_known_a_row_after_it_began_to_act(read: Read) -> None:
    log = read(columns())
    assert log.u[0].tolist() == [0.0, 0.0]
    assert log.u[1:, 0] + 1j * log.u[1:, 1] == pytest.approx(U[:-1], abs=1e-6)
    assert log.theta_e is None
    assert log.inj is None
    assert np.all(log.rows()["infer"] == 1.0)
    assert np.all(log.u_dc == MOTOR.u_dc)


def test_a_command_acts_a_row_later(read: Read) -> None:
    log = read(columns(), delay=1)
    assert np.all(log.u[:2] == 0.0)
    assert log.u[2:, 0] + 1j * log.u[2:, 1] == pytest.approx(U[:-2], abs=1e-6)


def without_voltage() -> Columns:
    values = columns()
    return {name: values[name] for name in ("t", "i_a", "i_b")}


def test_phase_voltages_and_duties_give_the_same(read: Read) -> None:
    """Both with a common-mode voltage that does not reach the machine."""
    want = read(columns()).u
    legs = (U[:, None] * PHASES).real + 30.0 * np.sin(K)[:, None]
    names = ("u_a", "u_b", "u_c")
    phase = read(without_voltage() | dict(zip(names, legs.T, strict=True)))
    assert phase.u == pytest.approx(want, abs=1e-6)
    u_dc = 500.0 + K.astype(float)
    d = duties(np.stack([U.real, U.imag], axis=-1), u_dc)
    names = ("d_a", "d_b", "d_c")
    by_duty = read(without_voltage() | dict(zip(names, d.T, strict=True)) | {"u_dc": u_dc})
    assert by_duty.u == pytest.approx(want, abs=1e-5)
    assert by_duty.u_dc == pytest.approx(u_dc)


def test_duties_lose_the_dead_time(read: Read) -> None:
    """Each leg against its current, as the averaged inverter."""
    d = duties(np.stack([U.real, U.imag], axis=-1), np.full(N, 540.0))
    values = without_voltage() | dict(zip(("d_a", "d_b", "d_c"), d.T, strict=True))
    values["u_dc"] = np.full(N, 540.0)
    lost = read(values, u_dt=5.4).u - read(values).u
    over = 0.5 * (I_AB[:-1] + I_AB[1:])  # the current around the period that ends at the next row
    sign = np.sign((over[:, None] * PHASES).real)
    assert lost[1:] == pytest.approx(clarke(-5.4 * sign), abs=1e-6)
    assert np.max(np.abs(lost)) == pytest.approx(5.4 * 4.0 / 3.0, rel=1e-6)


def test_three_currents_have_no_common_part(read: Read) -> None:
    values = columns()
    i_c = -values["i_a"] - values["i_b"]
    off = 0.3 * np.cos(K)
    values |= {"i_a": values["i_a"] + off, "i_b": values["i_b"] + off, "i_c": i_c + off}
    assert read(values).i == pytest.approx(read(columns()).i, abs=1e-6)


def test_mechanical_encoder(read: Read) -> None:
    log = read(columns() | {"theta_m": 0.1 * K})
    assert log.theta_e == pytest.approx(MOTOR.n_p * 0.1 * K)
    log = read(columns() | {"theta_m": 0.1 * K, "theta_e": 0.3 * K})
    assert log.theta_e == pytest.approx(0.3 * K)


def test_a_recorded_sign_is_moved_like_the_voltage(read: Read) -> None:
    log = read(columns() | {"inj": (-1.0) ** K})
    assert log.inj is not None
    assert log.inj[:3].tolist() == [0.0, 1.0, -1.0]
    assert np.all(log.rows()["infer"] == 0.0)


def test_other_columns_are_left_alone(read: Read, tmp_path: Path) -> None:
    read(columns() | {"temperature": K.astype(float)})
    text = (tmp_path / "log.csv").read_text().replace("temperature", "note")
    (tmp_path / "words.csv").write_text(text.replace(",39\n", ",tripped\n"))
    log = read_log(tmp_path / "words.csv", MOTOR, u_dt=0.0, inv_i_dt=1.0)
    assert len(log.t) == N


def changed(name: str, row: int, value: float) -> Columns:
    values = columns()
    values[name] = values[name].copy()
    values[name][row] = value
    return values


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (changed("i_b", 3, math.nan), "line 5: i_b: 'nan'; give a finite number"),
        (changed("u_alpha", 0, math.inf), "line 2: u_alpha: 'inf'"),
        (changed("t", 10, 0.5 + 9.5 * MOTOR.T_s), "line 12: t: 0.0001 s after the row before"),
        (
            columns() | {"t": 1e-4 * K},
            "t: 0.0001 s from row to row, but motor 'paper' has T_s = 0.0002 s",
        ),
        (columns() | {"inj": 0.5 * K}, "line 3: inj: 0.5; give -1, 0 or 1"),
        (without_voltage(), "no complete voltage; give u_alpha, u_beta; or u_a, u_b, u_c; or"),
        (without_voltage() | {"d_a": U.real, "d_b": U.real, "d_c": U.real}, "no complete voltage"),
        (columns() | {"i_a": np.where(K == 7, 1000.0, 0.0)}, "line 9: i_a: 1000 A, 1 of 40 rows"),
        (columns() | {"u_beta": 1e4 + K}, "line 2: u_beta: 10000 V, 40 of 40 rows"),
        (columns() | {"u_dc": 0.0 * K}, "line 2: u_dc: 0 V, 40 of 40 rows"),
        (
            {k: v for k, v in columns().items() if k != "i_a"},
            "column i_a: missing; name it with --map i_a=COLUMN; the file has t, i_b",
        ),
        ({k: v[:2] for k, v in columns().items()}, "2 of at least 3 rows; record more"),
    ],
)
def test_a_bad_log_is_named(values: Columns, message: str, read: Read) -> None:
    with pytest.raises(UserError) as error:
        read(values)
    assert "log.csv" in str(error.value)
    assert message in str(error.value)


def test_a_dead_channel_is_named(read: Read) -> None:
    log = read(columns() | {"i_a": 0.0 * K})
    assert log.doubtful and log.notes[-1].startswith("i_a is 0 A in every row")


@pytest.mark.parametrize(
    ("names", "value", "said"),
    [
        (("i_a", "i_b"), 0.0, "i_a, i_b stay at 0, 0 A in every row"),
        (("i_a", "i_b"), 3.2, "i_a, i_b stay at 3.2, 3.2 A in every row"),
        (("u_alpha", "u_beta"), 0.0, "u_alpha, u_beta stay at 0, 0 in every row"),
    ],
)
def test_dead_channels_are_named(
    names: tuple[str, str], value: float, said: str, read: Read
) -> None:
    log = read({**columns(), **dict.fromkeys(names, np.full(N, value))})
    assert log.doubtful and log.notes[-1].startswith(said)


def test_small_currents_are_named(read: Read) -> None:
    """Steps of the voltage are too few here to tell."""
    small = {name: 1e-3 * columns()[name] for name in ("i_a", "i_b")}
    log = read({**columns(), **small})
    assert log.notes[-1].startswith("no current is above 0.003 A") and not log.doubtful
    assert read(columns()).notes == ()


def test_a_dropped_row_is_found(read: Read) -> None:
    values = {name: np.delete(x, 20) for name, x in columns().items()}
    with pytest.raises(UserError, match=r"line 22: t: 0\.0004 s after the row before"):
        read(values)


def test_broken_files(tmp_path: Path) -> None:
    def complaint(path: Path) -> str:
        with pytest.raises(UserError) as error:
            read_log(path, MOTOR, u_dt=0.0, inv_i_dt=1.0)
        return str(error.value)

    assert "give a file that can be read" in complaint(tmp_path / "none.csv")
    path = write(tmp_path / "log.csv", columns())
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines[:4], lines[4] + ",1", *lines[5:]]))
    assert "line 5: 6 values; give 5" in complaint(path)
    path.write_text(lines[0].replace("u_beta", "t") + "\n" + lines[1])
    assert "column t: given twice" in complaint(path)
    path.write_text(lines[0])
    assert "no rows" in complaint(path)
    path.write_bytes(b"\xff\xfe\x00")
    assert "not a valid CSV file" in complaint(path)
