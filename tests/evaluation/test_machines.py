"""The suite of random machines: each as if it were judged alone, and compared with itself."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
import pytest

from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.machine_family import family
from sensorless.envs.scenarios.machines import JUDGED
from sensorless.envs.scenarios.machines_suite import SCENARIOS, on_machine, rows_on
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.words import scenario_from
from sensorless.errors import UserError
from sensorless.evaluation import machines as module
from sensorless.evaluation.aggregate import mean_interval
from sensorless.evaluation.evaluate import Scores, score
from sensorless.evaluation.machines import COMPARED, evaluate_machines
from sensorless.evaluation.results import Results
from sensorless.evaluation.results_tables import machines_table
from sensorless.evaluation.rollout import CAUSES, Floats
from sensorless.machine.motor import Motor
from sensorless.policies.bench import bench
from sensorless.policies.registry import make_policy
from sensorless.policy import Policy

pytestmark = pytest.mark.usefixtures("short_suites")

DESIGN, SEED, N = DriveDesign(), 3, 2
NAMES = ("reference", "sliding_mode")
MOTORS = family(JUDGED + SEED, N)


def policies_on(motor: Motor) -> Mapping[str, Policy]:
    return bench(NAMES).on(motor).policies(NAMES)


@pytest.fixture(scope="module")
def results() -> Results:
    return evaluate_machines(DESIGN, SEED, N, policies_on)


def test_intervals_are_over_machines(results: Results) -> None:
    found = results.policies["reference"]
    dev = np.array(found["scenarios"]["torque_dev_rms"])
    groups = np.repeat(np.arange(N), SCENARIOS)
    kept = np.array([cause is None for cause in found["scenarios"]["lost_cause"]])
    want = mean_interval(dev[kept], SEED, groups[kept])
    assert found["torque_dev_rms_ci"] == pytest.approx(want)


def test_each_machine_is_as_if_judged_alone(results: Results) -> None:
    found = results.policies["sliding_mode"]
    assert found["by_machine"]["machine"] == [motor.name for motor in MOTORS]
    for i, motor in enumerate(MOTORS):
        rows, policy = rows_on(motor, i, SEED, N), make_policy("sliding_mode", motor)
        alone = score(policy, rows, SimFactory(motor, DESIGN))
        part = slice(SCENARIOS * i, SCENARIOS * (i + 1))
        assert found["scenarios"]["seed"][part] == rows.seed.tolist()
        deviation = alone.metrics["torque_dev_rms"]
        assert found["scenarios"]["torque_dev_rms"][part] == deviation.tolist()
        assert found["by_machine"]["lost"][i] == np.sum(alone.lost != 0)
        assert found["by_machine"]["torque_dev_rms"][i] == np.mean(deviation[alone.lost == 0])


def test_a_policy_stands_beside_the_first_on_the_same_machine(results: Results) -> None:
    pair = results.paired["sliding_mode"]["by_machine"]
    rows = {name: results.policies[name]["scenarios"] for name in NAMES}
    for i, ratio in enumerate(pair["torque_ripple_rms_ratios"]):
        part = range(SCENARIOS * i, SCENARIOS * (i + 1))
        both = [
            j for j in part if not rows["reference"]["lost"][j] | rows["sliding_mode"]["lost"][j]
        ]
        here, there = (np.array(rows[n]["torque_ripple_rms"])[both] for n in NAMES[::-1])
        assert ratio == pytest.approx(here.mean() / there.mean())
    mean = np.exp(np.mean(np.log(pair["torque_ripple_rms_ratios"])))
    assert pair["torque_ripple_rms"] == pytest.approx(mean)
    low, high = pair["torque_ripple_rms_ci"]
    assert low < mean < high
    assert machines_table(results).row_count == len(NAMES)


Ends = Callable[[str, int], tuple[Floats, Floats]]
"""From policy and machine to what is lost, as bits, and the deviation of each scenario."""
KEPT = np.zeros(SCENARIOS)


def ended(ends: Ends, monkeypatch: pytest.MonkeyPatch) -> Results:
    """Results of drives that ended so."""
    first = MOTORS[0]
    policy = policies_on(first)["sliding_mode"]
    known = score(policy, rows_on(first, 0, SEED, N), SimFactory(first, DESIGN))

    def made_up(policy: Policy, factory: SimFactory, rows: object) -> Scores:
        lost, deviation = ends(policy.name, MOTORS.index(factory.motor))
        metrics = known.metrics | dict.fromkeys(COMPARED, deviation)
        return replace(known, lost=lost.astype(np.int32), metrics=metrics)

    monkeypatch.setattr(module, "score_chunk", made_up)
    return evaluate_machines(DESIGN, SEED, N, policies_on)


def test_two_percent_more_on_a_machine_is_as_good(monkeypatch: pytest.MonkeyPatch) -> None:
    more = {"reference": (1.0, 1.0), "sliding_mode": (1.03, 1.01)}
    results = ended(lambda name, i: (KEPT, np.full(SCENARIOS, more[name][i])), monkeypatch)
    pair = results.paired["sliding_mode"]["by_machine"]
    assert pair["torque_dev_rms_ratios"] == pytest.approx([1.03, 1.01])
    assert pair["torque_dev_rms_as_good"] == 0.5


def test_what_the_first_policy_loses_is_not_compared(monkeypatch: pytest.MonkeyPatch) -> None:
    """There it deviates nine times as much."""
    first = np.arange(SCENARIOS) == 0
    wild = np.where(first, 9.0, 1.0)

    def ends(name: str, machine: int) -> tuple[Floats, Floats]:
        return (CAUSES["angle"] * first, wild) if name == "reference" else (KEPT, KEPT + 1.0)

    pair = ended(ends, monkeypatch).paired["sliding_mode"]["by_machine"]
    assert pair["torque_dev_rms_ratios"] == pytest.approx([1.0, 1.0])


def test_a_machine_does_not_count_as_lost_what_it_cannot_do(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    lost = KEPT.copy()
    lost[:2] = CAUSES["angle"] | CAUSES["twin"], CAUSES["angle"]
    found = ended(lambda *of: (lost, KEPT), monkeypatch).policies["reference"]["by_machine"]
    assert found["lost"] == [1] * N and found["feasible"] == [SCENARIOS - 1] * N


@pytest.mark.parametrize("threads", [1, 2])
def test_any_number_of_threads_gives_the_same_file(
    results: Results, monkeypatch: pytest.MonkeyPatch, threads: int
) -> None:
    monkeypatch.setenv("SENSORLESS_THREADS", str(threads))

    def one(motor: Motor) -> Mapping[str, Policy]:
        return {"sliding_mode": policies_on(motor)["sliding_mode"]}

    found = evaluate_machines(DESIGN, SEED, N, one).policies["sliding_mode"]
    assert repr(found) == repr(results.policies["sliding_mode"])


def test_a_word_replays_a_scenario_on_its_machine(results: Results) -> None:
    assert results.policies["reference"]["worst"][0]["scenario"].startswith(f"machines:{SEED}:")
    motor, word = on_machine(f"machines:{SEED}:17")
    assert motor == MOTORS[1]
    drawn = rows_on(motor, 1, SEED, N).draw()[1:2]
    assert scenario_from(word, motor).tau.tolist() == drawn.tau.tolist()
    with pytest.raises(UserError, match="write machines:SEED:INDEX"):
        on_machine("machines:3")


def test_judging_and_training_never_share_a_machine() -> None:
    assert {motor.digest for motor in MOTORS}.isdisjoint(motor.digest for motor in family(SEED, N))
