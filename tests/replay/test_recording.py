"""The same log however a tool exports it, and what its signature says of a wrong one."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from sensorless.errors import UserError
from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Motor
from sensorless.replay.log import Log, read_log
from sensorless.replay.mapping import names_from
from sensorless.replay.replay import SAMPLE

MOTOR = Motor.load("paper")
ROWS = 1500
TABLE = np.genfromtxt(SAMPLE, delimiter=",", names=True)[:ROWS]
NAMES = TABLE.dtype.names or ()
Columns = dict[str, Floats]


def columns(*drop: str) -> Columns:
    return {name: TABLE[name].copy() for name in NAMES if name not in drop}


def csv_of(values: Columns, mark: str = ",", comma: str = ".", heads: str = "") -> str:
    table = np.stack(list(values.values()), axis=-1)
    rows = [mark.join(f"{x:.9g}".replace(".", comma) for x in row) for row in table]
    return "\n".join([heads or mark.join(values), *rows]) + "\n"


@pytest.fixture
def read(tmp_path: Path) -> Callable[..., Log]:
    def reader(text: str, words: list[str] | None = None, delay: int = 0) -> Log:
        path = tmp_path / "log.csv"
        path.write_text(text, encoding="utf-8")
        names = names_from(words)
        return read_log(path, MOTOR, u_dt=5.4, inv_i_dt=10.0, delay=delay, names=names)

    return reader


Read = Callable[..., Log]


@pytest.fixture
def plain(read: Read) -> Log:
    log = read(csv_of(columns()))
    assert log.notes == ()
    return log


def same(a: Log, b: Log) -> None:
    for name in ("t", "i", "u", "u_dc", "theta_e"):
        x, y = getattr(a, name), getattr(b, name)
        assert x.shape == y.shape and (np.abs(x - y) <= 1e-6 * np.maximum(1.0, np.abs(y))).all(), (
            name
        )


def test_separators_and_decimal_commas(read: Read, plain: Log) -> None:
    same(read(csv_of(columns(), ";")), plain)
    same(read(csv_of(columns(), "\t", ",")), plain)
    same(read("# a scope\n%\n" + csv_of(columns(), ";", ",")), plain)


def test_a_comma_may_come_late_or_stand_in_quotes(read: Read, plain: Log) -> None:
    still = {name: np.concatenate([np.zeros(6), x]) for name, x in columns("t", "u_dc").items()}
    same(read(csv_of(still, ";", ",")), read(csv_of(still)))
    table = csv_of(columns(), ";", ",")
    quoted = "\n".join('"' + line.replace(";", '","') + '"' for line in table.splitlines())
    same(read(quoted), plain)


def test_what_tools_write_around_a_table(read: Read, plain: Log, tmp_path: Path) -> None:
    text = csv_of(columns(), ";", ",")
    same(read("sep=;\n" + text), plain)
    same(read("Model,MSO\nDate,2026-01-02\n\n" + csv_of(columns())), plain)
    same(read(text.replace("\n", ";\n")), plain)
    head, _, body = text.partition("\n")
    same(read(head + "\n" + body.replace("\n", ";\n")), plain)
    path = tmp_path / "wide.csv"
    path.write_text(csv_of(columns(), "\t"), encoding="utf-16")
    same(read_log(path, MOTOR, u_dt=5.4, inv_i_dt=10.0), plain)


def test_times_may_be_rounded(read: Read, plain: Log) -> None:
    """Of 0.2 ms to 0.05 ms at an odd first time, but a row must not be missing."""
    coarse = np.round((TABLE["t"] + 7e-5) / 5e-5 * 0.93) * 5e-5 / 0.93
    assert read(csv_of(columns() | {"t": coarse})).notes == ()
    assert read(csv_of(columns() | {"t": 1e3 * coarse})).notes == ("t: taken as ms",)
    gone = {name: np.delete(x, 700) for name, x in (columns() | {"t": coarse}).items()}
    with pytest.raises(UserError, match="line 702"):
        read(csv_of(gone))


def test_duty_cycles_beyond_0_and_1_are_refused(read: Read) -> None:
    duties = {name: TABLE[name] for name in ("d_a", "d_b", "d_c")}
    for factor, offset in ((2.0, -1.0), (4200.0, 0.0)):
        made = {name: factor * d + offset for name, d in duties.items()}
        text = csv_of(columns("u_alpha", "u_beta") | made)
        with pytest.raises(UserError, match=r"duty cycles from 0 to 1"):
            read(text)


@pytest.mark.parametrize("name", ["i_a", "i_b", "i_c"])
def test_one_of_three_currents_with_a_wrong_sign_is_named(name: str, read: Read) -> None:
    values = columns() | {"i_c": -TABLE["i_a"] - TABLE["i_b"]}
    assert read(csv_of(values)).notes == ()
    (note,) = read(csv_of(values | {name: -values[name]})).notes
    assert note.startswith(f"{name} has the wrong sign") and note.endswith(f"{name}=-{name}")


def test_units_behind_a_name_and_below_it(read: Read, plain: Log) -> None:
    values = columns()
    values["t"], values["i_a"] = 1e3 * values["t"], 1e3 * values["i_a"]
    heads = ",".join(values).replace("i_a", "i_a [mA]").replace("t,", "t (ms),", 1)
    same(read(csv_of(values, heads=heads)), plain)
    units = ["ms" if n == "t" else "mA" if n == "i_a" else "" for n in values]
    heads = ",".join(values) + "\n" + ",".join(units)
    same(read(csv_of(values, heads=heads)), plain)


@pytest.mark.parametrize("below", [False, True], ids=["behind the name", "below it"])
def test_a_unit_that_is_not_known_is_refused(below: bool, read: Read, plain: Log) -> None:
    values = columns()
    names = ",".join(values)
    line, heads = 1, names.replace("i_a", "i_a [uA]")
    if below:
        line, heads = 2, names + "\n" + ",".join("uA" if n == "i_a" else "" for n in values)
    with pytest.raises(UserError, match=rf"line {line}: column 'i_a.*unit 'uA' is not known; give"):
        read(csv_of(values, heads=heads))


@pytest.mark.parametrize(("name", "factor"), [("i_a (filtered)", 1.0), ("i_a [mA]", 1e3)])
def test_a_name_with_its_brackets(name: str, factor: float, read: Read, plain: Log) -> None:
    values = columns()
    values["i_a"] = factor * values["i_a"]
    heads = ",".join(values).replace("i_a", name)
    same(read(csv_of(values, heads=heads), [f"i_a={name}"]), plain)


def test_other_names_by_words_or_by_a_file(read: Read, plain: Log, tmp_path: Path) -> None:
    heads = ",".join(columns()).replace("i_a", "Ia").replace("i_b", "current B")
    values = columns()
    values["i_b"] = -values["i_b"]
    same(read(csv_of(values, heads=heads), ["i_a=Ia", "i_b=-current B"]), plain)
    (tmp_path / "names.toml").write_text('i_a = "Ia"\ni_b = "-current B"\n')
    same(read(csv_of(values, heads=heads), [str(tmp_path / "names.toml")]), plain)


def test_matlab(tmp_path: Path, plain: Log) -> None:
    path = tmp_path / "log.mat"
    for content in (columns(), {"log": columns()}):
        savemat(path, content)
        same(read_log(path, MOTOR, u_dt=5.4, inv_i_dt=10.0), plain)
    path.write_bytes(b"MATLAB 7.3")
    with pytest.raises(UserError, match="MATLAB"):
        read_log(path, MOTOR, u_dt=5.4, inv_i_dt=10.0)


@pytest.mark.parametrize(("scale", "said"), [(1e3, "taken as ms"), (1e6, "taken as µs")])
def test_time_in_another_unit(scale: float, said: str, read: Read, plain: Log) -> None:
    log = read(csv_of(columns() | {"t": scale * TABLE["t"]}))
    same(log, plain)
    assert log.notes == (f"t: {said}",)


def test_time_may_be_missing_or_count_periods(read: Read, plain: Log) -> None:
    log = read(csv_of(columns("t")))
    assert log.i == pytest.approx(plain.i) and "no time" in log.notes[0]
    assert read(csv_of(columns() | {"t": np.arange(float(ROWS))})).notes == ("t: taken as periods",)


def test_degrees_and_percent_are_seen(read: Read, plain: Log) -> None:
    wrapped = np.degrees(np.remainder(TABLE["theta_e"], 2.0 * np.pi))
    log = read(csv_of(columns() | {"theta_e": wrapped}))
    assert log.notes == ("theta_e: taken as degrees",)
    assert log.theta_e == pytest.approx(np.radians(wrapped))
    duties = {name: 100.0 * TABLE[name] for name in ("d_a", "d_b", "d_c")}
    log = read(csv_of(columns("u_alpha", "u_beta") | duties))
    assert log.notes == ("d_a, d_b, d_c: taken as percent",)


@pytest.mark.parametrize(
    ("late", "delay", "said"),
    [(1, 0, "--delay 1"), (0, 1, "--delay 0"), (1, 2, "--delay 1"), (-1, 0, "one row up")],
)
def test_a_wrong_delay_is_seen(late: int, delay: int, said: str, read: Read) -> None:
    values = columns()
    for name in ("u_alpha", "u_beta"):  # what was computed in a row acts one later
        values[name] = np.roll(values[name], -late)
    (note,) = read(csv_of(values), delay=delay).notes
    assert said in note


def test_a_wrong_sign_and_swapped_phases_are_seen(read: Read) -> None:
    turned = columns()
    turned |= {name: -turned[name] for name in ("i_a", "i_b")}
    (note,) = read(csv_of(turned)).notes
    assert "turn the sign of all currents" in note and "--delay" not in note
    shifted = columns() | {"i_a": columns()["i_b"], "i_b": -TABLE["i_a"] - TABLE["i_b"]}
    (note,) = read(csv_of(shifted)).notes
    assert "another order" in note


@pytest.mark.parametrize(
    ("mistake", "said"),
    [
        ({"i_a": (-1.0, 0.0)}, "--map i_a=-i_a"),
        ({"i_b": (0.0, -1.0)}, "--map i_b=-i_b"),
        ({"i_a": (0.0, 1.0), "i_b": (1.0, 0.0)}, "--map i_a=i_b --map i_b=i_a"),
        ({"i_b": (-1.0, -1.0)}, "phases b and c"),
        ({"i_a": (-1.0, -1.0)}, "phases a and c"),
        ({"i_a": (-1.0, 0.0), "i_b": (1.0, 1.0)}, "u_alpha has the wrong sign"),
        ({"i_a": (0.5774, 1.1547), "i_b": (0.5774, -0.5774)}, "u_alpha and u_beta are swapped"),
    ],
)
def test_what_turns_the_current_round_is_named(
    mistake: dict[str, tuple[float, float]], said: str, read: Read, plain: Log
) -> None:
    """By the share of both true currents in a column; a cure in full mends the log."""
    made = {name: a * TABLE["i_a"] + b * TABLE["i_b"] for name, (a, b) in mistake.items()}
    text = csv_of(columns() | made)
    wrong = read(text)
    assert wrong.doubtful and not plain.doubtful
    (note,) = wrong.notes
    assert "opposite ways" in note and said in note
    words = [word for word in note.split() if word.startswith("i_")][-said.count("--map") :]
    if said.startswith("--map"):
        same(read(text, words), plain)


def test_a_column_that_is_named_anew_loses_its_own_name(read: Read) -> None:
    turn = np.unwrap(TABLE["theta_e"]) / MOTOR.n_p
    log = read(csv_of(columns() | {"theta_e": turn}), ["theta_m=theta_e"])
    assert log.theta_e is not None
    assert np.cos(log.theta_e - TABLE["theta_e"]).min() == pytest.approx(1.0)


def test_mistakes_are_named(read: Read, tmp_path: Path) -> None:
    text = csv_of(columns())
    for words, said in (
        (["i_a"], "NAME=COLUMN"), (["i_x=Ia"], "'i_x' is no column"), (["i_a=Ia"], "Ia, which"),
        (["i_a=i_a", "i_a=i_b"], "i_a: given twice"), (["i_a="], "i_a: no column"),
        (["i_a=i_b"], "column i_b: --map reads it as i_a"),
        ([str(tmp_path / "none.toml")], "No such file"),
    ):  # fmt: skip
        with pytest.raises(UserError, match="map") as error:
            read(text, words)
        assert said in str(error.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('t,i_a,i_b,u_alpha,u_beta\n0,0,0,0,"0\n1,0,0,0,0\n2,0,0,0,0\n', "a quote in a line"),
        ("t,i_a,i_b,u_alpha,u_beta\nsec\n0,0,0,0,0\n1,0,0,0,0\n", "log"),
        ("t,i_a,i_b,u_alpha,u_beta\n0,0,0,0,0\n0.0002,0,0,0,0\n1,0,0,0,0\n", "log"),
    ],
    ids=["open quote", "short line of units", "gap"],
)
@pytest.mark.filterwarnings("error")
def test_broken_logs_are_named(read: Read, text: str, message: str) -> None:
    with pytest.raises(UserError, match=message):
        read(text)
