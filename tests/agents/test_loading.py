"""A trained schedule runs on the estimator it was trained on, wherever it is run."""

import json
from dataclasses import asdict, replace
from pathlib import Path

import pytest

from sensorless.agents.loading import CONFIG, TABLE, carried_by_run, load_run
from sensorless.agents.mlp.schedule import MlpSchedule
from sensorless.agents.table.start import start_table
from sensorless.agents.train.config import TrainConfig
from sensorless.agents.train.train import train
from sensorless.baselines.linear import EQ25_BAND, linear_table
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.errors import UserError
from sensorless.evaluation.evaluate import evaluate
from sensorless.evaluation.rollout import rollout
from sensorless.evaluation.trace import trace
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policies, make_policy, table_named
from sensorless.policies.tuned import Tuned
from sensorless.policy import TablePolicy

MOTOR = Motor.load("paper")
START = table_named("eq25", MOTOR)
FLUX = DriveDesign(estimator="flux")
OWN = replace(FLUX, hfi_pll_hz=40.0, smo_emf_hz=900.0)
TINY = TrainConfig(n_envs=8, n_steps=8, n_epochs=1, steps=64, warm_up=0, validate_size=16)


def write(folder: Path, table_says: str | None, config_says: str | None) -> Path:
    """Run folder of Eq. 25 whose table and configuration name these estimators, or none."""
    folder.mkdir()
    origin = {} if table_says is None else {"design": asdict(DriveDesign(estimator=table_says))}
    linear_table(*EQ25_BAND).save(folder / TABLE, origin)
    if config_says is not None:
        (folder / CONFIG).write_text(json.dumps({"design": {"estimator": config_says}}))
    return folder


@pytest.mark.parametrize(
    ("table_says", "config_says", "found"),
    [
        (None, None, "smo"),
        ("flux", None, "flux"),
        (None, "flux", "flux"),
        ("errors", "flux", "errors"),
    ],
)
def test_the_folder_tells(
    table_says: str | None, config_says: str | None, found: str, tmp_path: Path
) -> None:
    """The table first, then the configuration; what names none is older than the choice."""
    policy = load_run(write(tmp_path / "run", table_says, config_says), MOTOR)
    assert policy.settings["estimator"] == found


@pytest.mark.parametrize("text", ["{", "\udcff"])
def test_a_damaged_configuration_is_named(text: str, tmp_path: Path) -> None:
    run = write(tmp_path / "run", None, None)
    (run / CONFIG).write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(UserError, match=r"config\.json"):
        load_run(run, MOTOR)


def test_a_run_that_has_no_schedule_yet_is_named(tmp_path: Path) -> None:
    run = write(tmp_path / "run", None, "smo")
    (run / TABLE).unlink()
    with pytest.raises(UserError, match=f"no schedule yet; .* --resume {run}"):
        load_run(run, MOTOR)


def test_an_estimator_that_does_not_exist_is_named(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="estimator: 'magic': must be smo"):
        load_run(write(tmp_path / "run", None, "magic"), MOTOR)


@pytest.mark.parametrize("design", [DriveDesign(), FLUX], ids=["default", "flux"])
def test_the_design_of_the_evaluation_does_not_matter(design: DriveDesign, tmp_path: Path) -> None:
    """Rollout and trace, under either design: what Eq. 25 does on the estimator of the run."""
    policy, eq25 = (
        load_run(write(tmp_path / "run", "flux", None), MOTOR),
        make_policy("eq25", MOTOR),
    )
    scenarios = suite("stress-1", MOTOR, 3, 4)
    asked = rollout(policy, scenarios, SimFactory(MOTOR, design)).sums
    assert asked.tobytes() == rollout(eq25, scenarios, SimFactory(MOTOR, FLUX)).sums.tobytes()
    one = suite("paper", MOTOR, 0, 1)
    a, b = trace(policy, one, MOTOR, design), trace(eq25, one, MOTOR, FLUX)
    assert a["theta_e_err"].tobytes() == b["theta_e_err"].tobytes()


def test_results_say_what_each_policy_ran_on(tmp_path: Path) -> None:
    run = write(tmp_path / "mine", "flux", None)
    results = evaluate(
        MOTOR, DriveDesign(), "paper", 0, 1, make_policies(["eq25", str(run)], MOTOR)
    )
    assert [p["estimator"] for p in results.policies.values()] == ["coupled", "flux"]


@pytest.mark.usefixtures("brief")
@pytest.mark.parametrize("kind", ["table", "mlp"])
def test_training_on_flux(kind: str, tmp_path: Path) -> None:
    """The schedule is validated on that drive, and asks for it when it is loaded again."""
    run = tmp_path / "run"
    best = train(replace(TINY, policy_kind=kind), OWN, run, START)
    policy = load_run(run, MOTOR)
    assert isinstance(policy, TablePolicy if kind == "table" else MlpSchedule)
    assert policy.settings == asdict(OWN)
    assert carried_by_run(run).motor == MOTOR
    (run / CONFIG).unlink()
    assert load_run(run, MOTOR).settings == asdict(OWN)
    assert best == train(replace(TINY, policy_kind=kind), OWN, tmp_path / "again", START)
    assert best != train(replace(TINY, policy_kind=kind), DriveDesign(), tmp_path / "other", START)


def test_a_start_is_only_numbers(tmp_path: Path) -> None:
    """Tuned on one estimator, it may start a training on another."""
    path = tmp_path / "tuned.json"
    for rule in ("linear", "flux_observer"):
        Tuned(rule, {"lo": 0.1, "hi": 0.5}, {"design": {"estimator": "flux"}}).save(path)
        table = start_table("start", str(path), table_named(str(path), MOTOR), MOTOR, 50.0)
        assert (table.axes[0].lo, table.axes[0].hi) == pytest.approx((0.1, 0.5))
