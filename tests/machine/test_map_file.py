"""Flux maps as files: any order, unit and separator; CSV and MATLAB; and what is refused."""

from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from sensorless.errors import UserError
from sensorless.machine.magnetics import Floats, flux
from sensorless.machine.map_file import load_map
from sensorless.machine.motor import Motor

MOTOR = Motor.load("paper")
AXIS_D, AXIS_Q = np.linspace(-6.0, 6.0, 7), np.linspace(-5.0, 5.0, 7)
I = np.stack(np.meshgrid(AXIS_D, AXIS_Q, indexing="ij"), axis=-1).reshape(-1, 2)  # noqa: E741
PSI = flux(MOTOR.saturation, I)


def csv(path: Path, heads: str, columns: list[Floats], sep: str = ",") -> Path:
    rows = [sep.join(f"{float(x)!r}" for x in row) for row in np.stack(columns, axis=1)]
    path.write_text("\n".join(["# a comment", heads, *rows]) + "\n", encoding="utf-8")
    return path


def check(path: Path, **options: object) -> None:
    i, psi = load_map(path, **options)  # type: ignore[arg-type]
    assert i == pytest.approx(I, abs=1e-12)
    assert psi == pytest.approx(PSI, abs=1e-12)


@pytest.mark.parametrize(
    ("heads", "order", "factors", "sep"),
    [
        ("i_d [A],i_q [A],psi_d [Vs],psi_q [Vs]", (0, 1, 2, 3), (1, 1, 1, 1), ","),
        ("psi_q [mVs];i_q;psi_d [mWb];i_d [mA]", (3, 1, 2, 0), (1e3, 1, 1e3, 1e3), ";"),
        ("lambda_d\tlambda_q\tid\tiq", (2, 3, 0, 1), (1, 1, 1, 1), "\t"),
        ("Flux_d(Wb) Flux_q(Wb) I_d(A) I_q(A)", (2, 3, 0, 1), (1, 1, 1, 1), " "),
        ("i_s_d [kA];i_s_q [kA];phi_d;Phi_s_q", (0, 1, 2, 3), (1e-3, 1e-3, 1, 1), ";"),
        ("speed,i_d,i_q,psi_d,psi_q", (4, 0, 1, 2, 3), (1, 1, 1, 1, 1), ","),
    ],
)
def test_text(
    heads: str, order: tuple[int, ...], factors: tuple[float, ...], sep: str, tmp_path: Path
) -> None:
    source = [*I.T, *PSI.T, np.full(len(I), 400.0)]
    columns = [f * source[k] for k, f in zip(order, factors, strict=True)]
    check(csv(tmp_path / "map.csv", heads, columns, sep))


def test_names_of_columns_may_be_given(tmp_path: Path) -> None:
    path = csv(tmp_path / "map.csv", "a,b,c,d", [*PSI.T, *I.T])
    check(path, columns="psi_d,psi_q,i_d,i_q")


@pytest.mark.parametrize("sep", [";", "\t", " "])
@pytest.mark.parametrize("encoding", ["utf-16", "latin-1"])
def test_decimal_commas_and_other_encodings(sep: str, encoding: str, tmp_path: Path) -> None:
    path = csv(
        tmp_path / "map.csv", sep.join(("i_d", "i_q", "psi_d", "psi_q")), [*I.T, *PSI.T], sep
    )
    text = path.read_text(encoding="utf-8").replace(".", ",").replace("comment", "Fluß")
    path.write_text(text, encoding=encoding)
    check(path)


@pytest.mark.parametrize(
    "kind", ["columns", "grid", "turned grid", "blank corner", "turned blank corner", "struct"]
)
def test_matlab(kind: str, tmp_path: Path) -> None:
    """A square grid is turned the right way round, also where it has no flux in a corner."""
    shape = (len(AXIS_D), len(AXIS_Q))
    psi_d, psi_q = (PSI[:, k].reshape(shape) for k in (0, 1))
    known = slice("blank" in kind, None)
    if "blank" in kind:
        psi_d, psi_q = psi_d.copy(), psi_q.copy()
        psi_d[0, 0] = psi_q[0, 0] = np.nan
    data: dict[str, object] = {
        "i_d": I[:, 0],
        "i_q": I[:, 1],
        "psi_d": PSI[:, 0],
        "psi_q": PSI[:, 1],
    }
    if kind in ("grid", "blank corner"):
        data = {"i_d": AXIS_D, "i_q": AXIS_Q, "psi_d": psi_d, "psi_q": psi_q}
    elif kind.startswith("turned"):
        data = {"i_d": AXIS_D, "i_q": AXIS_Q, "psi_d": psi_d.T, "psi_q": psi_q.T}
    path = tmp_path / "map.mat"
    savemat(path, {"map": data} if kind == "struct" else data)
    i, psi = load_map(path)
    order = np.lexsort((i[:, 1], i[:, 0]))
    assert i[order] == pytest.approx(I[known]) and psi[order] == pytest.approx(PSI[known])


def test_the_irons_axis_is_turned(tmp_path: Path) -> None:
    columns = [I[:, 1], -I[:, 0], PSI[:, 1], -PSI[:, 0]]
    check(csv(tmp_path / "map.csv", "i_d,i_q,psi_d,psi_q", columns), turn=True)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("i_d,i_q,psi_d\n1,2,3\n", "no column psi_q; found i_d, i_q, psi_d"),
        ("i_d,i_q,psi_d,psi_q\n1,2,3,4\n", "numbers: 1"),
        ("i_d,i_q,psi_d,psi_q\n1,2,much,4\n", "row '1,2,much,4': could not convert"),
        ("i_d,i_q,psi_d,psi_q\n1,2,3\n1,2,3,4\n", "row '1,2,3': 3 numbers; give 4"),
        ("i_d,i_q,psi_d,psi_q\n", "no numbers under the heading"),
        ("i_d [V],i_q,psi_d,psi_q\n1,2,3,4\n", "write one of A"),
        ("i_d,id,i_q,psi_d,psi_q\n1,2,3,4,5\n", "i_d twice"),
        ("1,2,3,4\n", "no heading"),
        ("i_d,i_q,psi_d,psi_q\n1,2,3,4,5\n", "5 numbers; give 4"),
        ("i_d,i_q,psi_d,psi_q\n1,5,2,0,3,0,4,0\n", "a semicolon between two"),
        ("", "no numbers"),
        ("i_d,i_q,psi_d,psi_q\n1,2,3,4\n1,2,nan,4\n", "row 2: i_d = 1, i_q = 2, psi_d = nan"),
    ],
)
def test_what_is_no_map_is_one_line(text: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "map.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(UserError) as error:
        load_map(path)
    assert said in str(error.value) and "\n" not in str(error.value)
    assert str(path) in str(error.value)


@pytest.mark.parametrize("name", ["map.csv", "map.mat"])
def test_missing_and_broken_files(name: str, tmp_path: Path) -> None:
    with pytest.raises(UserError, match=name):
        load_map(tmp_path / name)
    for broken in (b"\xff\xfe\x00garbage" * 40, b"", b"MATLAB 5.0 MAT-file".ljust(124) + b"\0\2IM"):
        (tmp_path / name).write_bytes(broken)
        with pytest.raises(UserError, match=name) as error:
            load_map(tmp_path / name)
        assert "\n" not in str(error.value)
