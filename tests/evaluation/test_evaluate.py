"""Evaluation from names to a file."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sensorless.evaluation.evaluate
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.stress import stress_1_scenarios
from sensorless.errors import UserError
from sensorless.evaluation.evaluate import evaluate, score
from sensorless.evaluation.metrics.catalogue import METRICS
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policies, make_policy

pytestmark = pytest.mark.usefixtures("short_suites")

MOTOR = Motor.load("paper")
DESIGN = DriveDesign()
SIZE = 8


def run(*policies: str, seed: int = 7, suite: str = "stress-1", **options: Any) -> dict[str, Any]:
    """Parsed results file."""
    results = evaluate(MOTOR, DESIGN, suite, seed, SIZE, make_policies(policies, MOTOR), **options)
    data: dict[str, Any] = json.loads(results.to_json())
    return data


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    path = tmp_path_factory.mktemp("results") / "results.json"
    run("eq25", "smo", "sensored", out=path)
    loaded: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return loaded


def test_the_file_says_what_was_run(data: dict[str, Any]) -> None:
    assert (data["suite"], data["seed"], data["size"]) == ("stress-1", 7, SIZE)
    assert (data["motor"], data["motor_digest"]) == ("paper", MOTOR.digest)
    assert data["design"]["hfi_pll_hz"] == DESIGN.hfi_pll_hz
    assert {"sensorless", "core", "numpy", "scipy"} <= set(data["versions"])
    assert list(data["policies"]) == ["eq25", "smo", "sensored"]


def test_means_are_those_of_the_scenarios_survived(data: dict[str, Any]) -> None:
    for policy in data["policies"].values():
        rows = policy["scenarios"]
        lost = np.array(rows["lost"])
        assert policy["lost_rate"] == pytest.approx(lost.mean())
        assert policy["survived"] == (~lost).sum()
        for name in METRICS:
            x = np.array(rows[name], dtype=np.float64)[~lost]
            x = x[np.isfinite(x)]
            assert policy["defined"][name] == len(x)
            if len(x):
                assert policy[name] == pytest.approx(x.mean(), rel=1e-7), name
            else:
                assert policy[name] is None
            if len(x) > 1:
                assert policy[f"{name}_ci"][0] <= policy[name] * 1.000001 + 1e-9
                assert policy[f"{name}_ci"][1] >= policy[name] * 0.999999 - 1e-9


def test_every_array_has_one_entry_a_scenario(data: dict[str, Any]) -> None:
    for policy in data["policies"].values():
        assert {"seed", "lost", "lost_cause", "time_s"} <= set(policy["scenarios"])
        assert {len(x) for x in policy["scenarios"].values()} == {SIZE}
        for lost, cause in zip(
            policy["scenarios"]["lost"], policy["scenarios"]["lost_cause"], strict=True
        ):
            assert lost == (cause is not None)


def test_the_policies_are_told_apart(data: dict[str, Any]) -> None:
    eq25, smo, sensored = data["policies"].values()
    assert smo["lost_rate"] > eq25["lost_rate"]
    assert "angle" in smo["scenarios"]["lost_cause"]
    assert sensored["lost_rate"] == sensored["torque_dev_rms"] == 0.0
    assert sensored["angle_err_rms_deg"] == sensored["injection_share"] == 0.0
    assert eq25["torque_dev_rms"] > 0.001
    assert eq25["angle_err_rms_deg"] > 0.2
    assert [p["bound"] for p in (eq25, smo, sensored)] == [False, False, True]
    assert [p["estimator"] for p in (eq25, smo, sensored)] == ["coupled", "smo", None]


def test_places_add_up_to_the_whole(data: dict[str, Any]) -> None:
    for policy in data["policies"].values():
        rows = policy["scenarios"]
        for block, label in (("by_quadrant", "place"), ("by_speed", "from_rated_speed")):
            places = policy[block]
            assert {len(x) for x in places.values()} == {len(places[label])}
            assert sum(places["lost"]) == sum(rows["lost"])
            if policy["survived"]:
                assert sum(places["time_share"]) == pytest.approx(1.0)
            for lost, came, ci in zip(
                places["lost"], places["came"], places["lost_ci"], strict=True
            ):
                assert lost <= came <= SIZE
                assert came == 0 or 0.0 <= ci[0] <= lost / came <= ci[1] <= 1.0


def test_pairs_compare_with_the_first_policy(data: dict[str, Any]) -> None:
    assert list(data["paired"]) == ["smo", "sensored"]
    pair = data["paired"]["sensored"]
    first, other = data["policies"]["eq25"]["scenarios"], data["policies"]["sensored"]["scenarios"]
    both = ~(np.array(first["lost"]) | np.array(other["lost"]))
    assert pair["with"] == "eq25"
    assert pair["survived_both"] == both.sum()
    difference = (np.array(other["torque_dev_rms"]) - np.array(first["torque_dev_rms"]))[both]
    assert pair["torque_dev_rms"] == pytest.approx(difference.mean(), rel=1e-6)


def test_same_seed_same_bytes(tmp_path: Path) -> None:
    for name in ("a.json", "b.json"):
        run("hysteresis", "eq25", out=tmp_path / name)
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()


def test_a_policy_is_judged_the_same_in_any_company(data: dict[str, Any]) -> None:
    assert run("smo")["policies"]["smo"] == data["policies"]["smo"]


def test_another_seed_other_scenarios(data: dict[str, Any]) -> None:
    other = run("eq25", seed=8)["policies"]["eq25"]["scenarios"]
    mine = data["policies"]["eq25"]["scenarios"]
    assert not set(other["seed"]) & set(mine["seed"])
    assert other["torque_ripple_rms"] != mine["torque_ripple_rms"]


def test_chunks_change_nothing() -> None:
    scenarios = stress_1_scenarios(MOTOR, np.arange(5, dtype=np.uint64))
    scenarios.duration[:] = 0.3
    factory = SimFactory(MOTOR, DESIGN)
    policy = make_policy("eq25", MOTOR)
    a, b = (score(policy, scenarios, factory, chunk=chunk) for chunk in (2, 5))
    assert a.lost.tolist() == b.lost.tolist()
    assert a.time.tolist() == b.time.tolist()
    for name in METRICS:
        np.testing.assert_allclose(a.metrics[name], b.metrics[name], rtol=1e-12, atol=1e-15)
    for name, places in a.places.items():
        for field in places.dtype.names or ():
            np.testing.assert_allclose(places[field], b.places[name][field], rtol=1e-9, atol=1e-12)


def test_progress_names_the_policy() -> None:
    seen: list[tuple[str, float]] = []
    run("sensored", "hfi", progress=lambda name, done: seen.append((name, done)))
    assert [name for name, done in seen if done == 1.0] == ["sensored", "hfi"]


@pytest.mark.parametrize(
    ("policies", "seed", "size", "suite"),
    [
        ((), 7, SIZE, "stress-1"),
        (("eq25", "eq25"), 7, SIZE, "stress-1"),
        (("eq25", "nonsense"), 7, SIZE, "stress-1"),
        (("eq25",), 7, SIZE, "nonsense"),
        (("eq25",), 7, 0, "stress-1"),
        (("eq25",), -1, SIZE, "stress-1"),
    ],
)
def test_bad_requests(
    policies: tuple[str, ...], seed: int, size: int, suite: str, tmp_path: Path
) -> None:
    with pytest.raises(UserError, match=r"; (give|choose)"):
        evaluate(
            MOTOR,
            DESIGN,
            suite,
            seed,
            size,
            make_policies(policies, MOTOR),
            out=tmp_path / "results.json",
        )
    assert not list(tmp_path.iterdir())


def test_a_file_that_cannot_be_written_stops_before_the_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sensorless.evaluation.evaluate, "score", lambda *_: pytest.fail("ran"))
    with pytest.raises(UserError, match="does not exist"):
        run("eq25", out=tmp_path / "missing" / "results.json")


def test_an_interrupted_run_leaves_no_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(sensorless.evaluation.evaluate, "score", interrupt)
    with pytest.raises(KeyboardInterrupt):
        run("eq25", out=tmp_path / "results.json")
    assert not list(tmp_path.iterdir())
