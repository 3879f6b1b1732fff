"""The results file: complete, exact and never half-written."""

import io
import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from sensorless.evaluation.results import COLUMNS, RATES, Results

ROW = dict.fromkeys([*RATES, *(key for key, *_ in COLUMNS)], 0.123456789012)
INTERVALS = {RATES.get(key, f"{key}_ci"): (0.1, 0.2) for key in ROW}
RESULTS = Results(
    suite="stress",
    seed=7,
    size=2,
    motor="paper",
    motor_digest="abc",
    design={"smo_emf_hz": math.inf, "mtpa": True, "estimator": "smo"},
    versions={"numpy": "2"},
    policies={
        "eq25": {
            "estimator": "flux",
            "own": {"estimator": "flux"},
            "bound": False,
            "infeasible_rate": 0.0,
            **ROW,
            **INTERVALS,
            "scenarios": {"seed": [2**64 - 1, 3], "lost": [True, False], "x": [1.0, math.nan]},
            "worst": [{"torque_dev_rms": math.inf}],
        },
        "other": {
            "estimator": None,
            "own": {},
            "bound": True,
            "infeasible_rate": 0.0,
            **ROW,
            **INTERVALS,
            "overshoot_pct": math.nan,
            "angle_err_rms_deg_ci": (math.nan, math.nan),
            "scenarios": {},
        },
    },
    paired={"other": {"with": "eq25", "x": np.float64(1.5), "x_ci": (-math.inf, 2)}},
)


def refuse(constant: str) -> float:
    raise ValueError(f"{constant} is not JSON")


def test_what_is_no_number_is_null_and_the_rest_comes_back() -> None:
    data = json.loads(RESULTS.to_json(), parse_constant=refuse)
    assert list(data) == [
        "suite",
        "seed",
        "size",
        "motor",
        "motor_digest",
        "design",
        "versions",
        "policies",
        "paired",
    ]
    assert data["design"] == {"smo_emf_hz": None, "mtpa": True, "estimator": "smo"}
    assert data["policies"]["eq25"]["scenarios"] == {
        "seed": [2**64 - 1, 3],
        "lost": [True, False],
        "x": [1.0, None],
    }
    assert data["policies"]["eq25"]["worst"] == [{"torque_dev_rms": None}]
    assert data["policies"]["eq25"]["lost_rate"] == 0.123456789
    assert data["paired"]["other"] == {"with": "eq25", "x": 1.5, "x_ci": [None, 2]}


def test_lists_stay_on_one_line() -> None:
    assert ' "lost": [true, false],' in RESULTS.to_json()


def test_a_file_is_replaced_as_a_whole(tmp_path: Path) -> None:
    path = tmp_path / "results.json"
    path.write_text("old")
    RESULTS.write(path)
    assert path.read_text(encoding="utf-8") == RESULTS.to_json()
    assert [p.name for p in tmp_path.iterdir()] == ["results.json"]


def test_single_scenarios_can_be_left_out(tmp_path: Path) -> None:
    RESULTS.write(tmp_path / "r.json", scenarios=False)
    data = json.loads((tmp_path / "r.json").read_text(encoding="utf-8"))
    assert data["policies"]["eq25"]["lost_rate"] == 0.123456789
    assert all("scenarios" not in policy for policy in data["policies"].values())
    assert "scenarios" in RESULTS.policies["eq25"], "the results themselves keep them"


def test_a_failure_leaves_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "results.json"
    path.write_text("old")
    with pytest.raises(TypeError):
        replace(RESULTS, versions={"numpy": object()}).write(path)  # type: ignore[dict-item]
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["results.json"]


def test_the_table_fits_on_a_terminal_and_shows_every_policy() -> None:
    console = Console(width=80, record=True, file=io.StringIO())
    console.print(RESULTS.table())
    text = console.export_text()
    assert "eq25" in text and "other" in text
    assert text.count("(told truth)") == text.count("(flux)") == 1
    assert "(None)" not in text and "(smo)" not in text
    assert "12.3 │" in text and "(10.0–20.0) │" in text
    assert "12.35 ±5.00" in text and "0.12 ±0.05" in text
    assert "–" in text and "nan" not in text
    assert max(map(len, text.splitlines())) <= 80


def test_rates_of_nothing_feasible_are_dashes() -> None:
    nothing: dict[str, object] = dict.fromkeys(RATES, math.nan)
    nothing |= dict.fromkeys(RATES.values(), (math.nan, math.nan))
    policies = {name: {**p, **nothing} for name, p in RESULTS.policies.items()}
    console = Console(width=80, record=True, file=io.StringIO())
    console.print(replace(RESULTS, policies=policies).table())
    assert "nan" not in console.export_text()
