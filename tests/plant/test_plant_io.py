"""Files of ``sensorless simulate --plant``: what is refused and how, and what is written."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sensorless.errors import UserError
from sensorless.machine.magnetics import currents
from sensorless.plant.case import case_from, read_case
from sensorless.plant.inputs import read_inputs
from sensorless.plant.run import COLUMNS, integrate, plant_arrays, run_case, simulate_plant, to_csv

GOLDEN = Path(__file__).parents[1] / "data" / "golden"
LINEAR: dict[str, Any] = json.loads((GOLDEN / "linear_injection.json").read_text())
HELD: dict[str, Any] = json.loads((GOLDEN / "linear_fixed_speed.json").read_text())
SATURATED: dict[str, Any] = json.loads((GOLDEN / "saturated_injection.json").read_text())


def changed(data: dict[str, Any], path: str, value: Any) -> dict[str, Any]:
    """A copy with the field ``table.name`` set, or removed for ``...``."""
    out: dict[str, Any] = json.loads(json.dumps(data))
    *tables, name = path.split(".")
    at = out
    for table in tables:
        at = at[table]
    if value is ...:
        del at[name]
    else:
        at[name] = value
    return out


def refusal(data: Any) -> str:
    with pytest.raises(UserError) as error:
        case_from(data, "here.json")
    message = str(error.value)
    assert message.startswith("here.json: ") and "\n" not in message
    return message


def field_paths(data: dict[str, Any]) -> list[str]:
    nested = [
        f"{table}.{name}" for table in ("machine", "mechanics", "init") for name in data[table]
    ]
    return ["T_s", *nested]


@pytest.mark.parametrize("path", field_paths(SATURATED))
def test_missing_field(path: str) -> None:
    """Every field is needed, and named when it is not there."""
    message = refusal(changed(SATURATED, path, ...))
    name = path.split(".")[-1]
    assert f"{name}: " in message and ("missing" in message or "None" in message)


@pytest.mark.parametrize("value", [math.nan, math.inf, "x", None, True, [1]])
def test_not_a_number(value: Any) -> None:
    """NaN, infinity, text, null, booleans and lists are refused with field, value and range."""
    for path in field_paths(SATURATED):
        if path != "machine.type":
            message = refusal(changed(SATURATED, path, value))
            assert f"{path.split('.')[-1]}: {value!r}; give " in message


@pytest.mark.parametrize(
    "path", [p for p in field_paths(SATURATED) if p != "machine.type" and not p.startswith("init")]
)
def test_negative(path: str) -> None:
    """No physical quantity of a machine is negative; start values may be."""
    assert f"{path.split('.')[-1]}: -1; give " in refusal(changed(SATURATED, path, -1))


@pytest.mark.parametrize(
    ("data", "path", "value", "expected"),
    [
        (SATURATED, "machine.S", 4.5, "S: 4.5; give a whole number from 0 to 7"),
        (SATURATED, "machine.T", 8, "T: 8; give a whole number from 0 to 7"),
        (SATURATED, "machine.n_p", 0, "n_p: 0; give a whole number from 1"),
        (SATURATED, "machine.n_p", 1.5, "n_p: 1.5; give a whole number from 1"),
        (SATURATED, "machine.X", 1, "X: unknown field; known are n_p, R_s"),
        (LINEAR, "machine.a_d0", 1, "a_d0: unknown field; known are n_p, R_s, L_d"),
        (LINEAR, "machine.L_d", 0, "L_d: 0; give a finite number above 0"),
        (LINEAR, "machine.R_s", 10**400, "R_s: 1000"),
        (LINEAR, "machine.type", "im", "type: 'im'; choose linear or pmsyrm"),
        (LINEAR, "machine.type", ..., "type: None; choose linear or pmsyrm"),
        (LINEAR, "mechanics.K", 1, "K: unknown field; known are J, B"),
        (LINEAR, "mechanics.J", 0, "J: 0; give a finite number above 0"),
        (HELD, "mechanics.J", 1, "J: unknown field; known are w_M"),
        (HELD, "init.w_M", 3, "init: w_M: 3; give the held speed, 40 rad/s"),
        (LINEAR, "init.x", 3, "x: unknown field; known are i_d, i_q, theta_m, w_M"),
        (LINEAR, "speed", 3, "speed: unknown field; known are T_s"),
        (LINEAR, "machine", ..., "machine: missing; give an object"),
        (LINEAR, "init", 7, "init: 7; give an object"),
        (LINEAR, "T_s", 0, "T_s: 0; give a finite number above 0"),
    ],
)
def test_messages(data: dict[str, Any], path: str, value: Any, expected: str) -> None:
    """Field, value and remedy, in one line."""
    assert expected in refusal(changed(data, path, value))


@pytest.mark.parametrize("data", [[], 3, None, "linear"])
def test_not_an_object(data: Any) -> None:
    """Any other JSON is refused as a whole."""
    assert "give an object" in refusal(data)


@pytest.mark.parametrize("content", [b"{", b"", b"\xff\xfe", b"{'a': 1}"])
def test_not_json(content: bytes, tmp_path: Path) -> None:
    """Broken text names the file."""
    path = tmp_path / "m.json"
    path.write_bytes(content)
    with pytest.raises(UserError, match=r"plant '.*m\.json': not a valid JSON file"):
        read_case(path)


def test_optional_parts() -> None:
    """A saturated machine may lack the bridge, or have a magnet as an equivalent current."""
    data = changed(SATURATED, "machine.i_f", 2.5)
    for name in ("a_b", "a_bp", "k_q", "psi_n", "W"):
        data = changed(data, f"machine.{name}", ...)
    case = case_from(data, "x")
    assert (case.saturation.i_f, case.saturation.a_b) == (2.5, 0.0)
    assert plant_arrays(case)[0]["extra"][0] == 0
    assert plant_arrays(case_from(SATURATED, "x"))[0]["extra"][0] == 1


def inputs_file(folder: Path, text: str) -> Path:
    path = folder / "in.csv"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    "text",
    [
        "u_alpha,u_beta,tau_L\n1,2,3\n4,5,6\n",
        "tau_L,u_beta,u_alpha\n3,2,1\n6,5,4\n",
        "\ufeffu_alpha, u_beta ,tau_L\r\n1.0, 2,3e0\r\n4,5,6",
        "u_beta,u_alpha,tau_L\n2,1,3\n\n5,4,6\n\n",
    ],
)
def test_inputs(text: str, tmp_path: Path) -> None:
    """Columns by name in any order, with or without a final newline."""
    assert read_inputs(inputs_file(tmp_path, text)).tolist() == [[1, 2, 3], [4, 5, 6]]


def test_inputs_in_utf_16(tmp_path: Path) -> None:
    """As PowerShell writes them."""
    (tmp_path / "u.csv").write_text("u_alpha,u_beta\n1,2\n", encoding="utf-16")
    assert read_inputs(tmp_path / "u.csv").tolist() == [[1, 2, 0]]


def test_load_torque_is_optional(tmp_path: Path) -> None:
    """Without the column there is no load."""
    assert read_inputs(inputs_file(tmp_path, "u_beta,u_alpha\n2,1\n")).tolist() == [[1, 2, 0]]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("u_alpha,u_beta\n1,2\n3\n", "line 3: 1 values; give 2"),
        ("u_alpha,u_beta\n1,2,3\n", "line 2: 3 values; give 2"),
        ("u_alpha,u_beta\n1,x\n", "line 2: u_beta: 'x'; give a finite number"),
        ("u_alpha,u_beta\n1,2\n\n1,\n", "line 4: u_beta: ''; give a finite number"),
        ("u_alpha,u_beta\nnan,2\n", "line 2: u_alpha: 'nan'; give a finite number"),
        ("u_alpha,u_beta\n1,inf\n", "line 2: u_beta: 'inf'; give a finite number"),
        ("u_alpha,u_b\n1,2\n", "line 1: column 'u_b'; give each of u_alpha, u_beta, tau_L"),
        ("u_alpha,tau_L\n1,2\n", "line 1: column u_beta: missing"),
        ("u_alpha,u_beta,u_beta\n1,2,3\n", "line 1: column 'u_beta'; give each of"),
        ("1,2\n3,4\n", "line 1: column '1'; give"),
        ("u_alpha,u_beta\n", "no rows; give one per PWM period"),
        ("", "line 1: column u_alpha: missing"),
    ],
)
def test_bad_inputs(text: str, expected: str, tmp_path: Path) -> None:
    """Every mistake names its line."""
    with pytest.raises(UserError) as error:
        read_inputs(inputs_file(tmp_path, text))
    assert expected in str(error.value) and "\n" not in str(error.value)


def test_missing_files(tmp_path: Path) -> None:
    """A file that is not there is one line."""
    with pytest.raises(UserError, match=r"plant '.*none\.json': No such file"):
        read_case(tmp_path / "none.json")
    with pytest.raises(UserError, match=r"inputs '.*none\.csv': No such file"):
        read_inputs(tmp_path / "none.csv")


def test_nothing_is_written_on_a_mistake(tmp_path: Path) -> None:
    """The old result stays as it was, and nothing lies beside it."""
    out = tmp_path / "out" / "y.csv"
    out.parent.mkdir()
    out.write_text("old")
    with pytest.raises(UserError):
        simulate_plant(GOLDEN / "linear_injection.json", inputs_file(tmp_path, "u_alpha\n"), out)
    assert [path.name for path in out.parent.iterdir()] == ["y.csv"]
    assert out.read_text() == "old"


def test_output_folder_has_to_exist(tmp_path: Path) -> None:
    """A result that cannot be written is one line."""
    source = GOLDEN / "linear_fixed_speed"
    with pytest.raises(UserError, match=r"output '.*y\.csv'"):
        simulate_plant(f"{source}.json", f"{source}.u.csv", tmp_path / "no" / "y.csv")


def test_runaway_is_told(tmp_path: Path) -> None:
    """A machine that leaves the numbers is the user's mistake, with the time it happens."""
    case = case_from(SATURATED, "x")
    with pytest.raises(UserError, match="no finite state from t = "):
        run_case(case, np.full((400, 3), 1e60))


def test_a_period_that_no_step_divides_finely_enough_is_told() -> None:
    """30 turns in a period of 10 ms, at which 1024 steps are far off."""
    data = changed(changed(HELD, "mechanics.w_M", 1e4), "init.w_M", 1e4)
    case = case_from(changed(data, "T_s", 0.01), "x")
    with pytest.raises(UserError, match=r"T_s = 0\.01 s is too long.*give more and shorter"):
        run_case(case, np.full((3, 3), 100.0))


@pytest.mark.parametrize("theta", [0.0, 2.5, -3.1, 9.0, -40.0])
@pytest.mark.parametrize("data", [LINEAR, SATURATED], ids=["linear", "saturated"])
def test_first_row_is_the_start(data: dict[str, Any], theta: float) -> None:
    """Currents, wrapped electrical angle and speed of ``init``; phase currents add up to zero."""
    for name, value in (("i_d", -1.5), ("i_q", 2.5), ("theta_m", theta), ("w_M", -12.0)):
        data = changed(data, f"init.{name}", value)
    row = dict(zip(COLUMNS, run_case(case_from(data, "x"), np.zeros((3, 3))).rows[0], strict=True))
    assert (row["t"], row["w_M"]) == (0.0, -12.0)
    assert (row["i_d"], row["i_q"]) == pytest.approx((-1.5, 2.5), abs=1e-9)
    assert row["theta_m"] == pytest.approx(math.remainder(theta, 2.0 * math.pi), abs=1e-12)
    vector = complex(-1.5, 2.5) * complex(math.cos(theta), math.sin(theta))
    phases = [
        (vector * complex(math.cos(a), -math.sin(a))).real
        for a in (0.0, 2 * math.pi / 3, -2 * math.pi / 3)
    ]
    assert [row["i_a"], row["i_b"], row["i_c"]] == pytest.approx(phases, abs=1e-9)
    assert (row["i_alpha"], row["i_beta"]) == pytest.approx((vector.real, vector.imag), abs=1e-9)
    n_p = data["machine"]["n_p"]
    assert row["tau_M"] == pytest.approx(1.5 * n_p * (row["psi_d"] * 2.5 + row["psi_q"] * 1.5))


def test_angle_turns_electrically() -> None:
    """Over a period of held speed the angle moves by n_p w_M T_s, through many turns."""
    data = changed(changed(HELD, "mechanics.w_M", 250.0), "init.w_M", 250.0)
    rows = run_case(case_from(data, "x"), np.zeros((3000, 3))).rows
    t, theta = rows[:, 0], rows[:, -1]
    assert np.max(np.abs(np.angle(np.exp(1j * (theta - 2 * 250.0 * t))))) < 1e-9
    assert np.max(np.abs(theta)) <= math.pi


def test_pieces_of_a_long_run_join(monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs are computed in chunks; the chunk has no say in the numbers."""
    case = case_from(SATURATED, "x")
    inputs = read_inputs(GOLDEN / "saturated_injection.u.csv")[:500]
    whole = integrate(case, inputs, split=2)
    monkeypatch.setattr("sensorless.plant.run.CHUNK", 14)
    assert np.max(np.abs(integrate(case, inputs, split=2) - whole)) < 1e-12


def test_currents_belong_to_the_flux() -> None:
    """Each row satisfies the flux map."""
    case = case_from(SATURATED, "x")
    rows = run_case(case, read_inputs(GOLDEN / "saturated_injection.u.csv")[:300]).rows
    assert np.max(np.abs(currents(case.saturation, rows[:, 8:10]) - rows[:, 1:3])) < 1e-12


def test_text_keeps_13_digits() -> None:
    """One header line, one line a row, numbers that read back."""
    rows = np.random.default_rng(0).normal(size=(7, len(COLUMNS)))
    text = to_csv(rows)
    back = np.array([line.split(",") for line in text.splitlines()[1:]], dtype=float)
    assert text.endswith("\n")
    assert np.max(np.abs(back / rows - 1.0)) < 1e-12
