"""Machine and settings travel with a schedule; what contradicts them is refused, or overrides."""

import json
from dataclasses import asdict, replace
from pathlib import Path

import pytest

from sensorless.baselines.linear import EQ25_BAND, linear_table
from sensorless.core.api import Array
from sensorless.design.carried import carried, record
from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.errors import UserError
from sensorless.evaluation.evaluate import evaluate
from sensorless.evaluation.rollout import rollout
from sensorless.machine.motor import Motor
from sensorless.policies.bench import WHY, bench
from sensorless.policies.registry import RULES, table_named
from sensorless.policies.tuned import Tuned
from sensorless.policy import design_for
from sensorless.table.ks_table import KsTable
from tests.helpers.command import run as command
from tests.helpers.script import ROOT

PAPER = Motor.load("paper")
OTHER = replace(Motor.load("ipmsm_2200w"), name="mine", J=0.02)
FAST = DriveDesign(hfi_pll_hz=40.0, smo_emf_hz=900.0, carrier=True)


def made(folder: Path, motor: Motor | None, design: DriveDesign, name: str = "run") -> str:
    """Run folder of Eq. 25, as training on a machine and a design leaves it."""
    run = folder / name
    run.mkdir()
    facts = {} if motor is None else {"motor": motor.name, "motor_digest": motor.digest}
    linear_table(*EQ25_BAND).save(run / "table.json", {**facts, **record(design, motor)})
    return str(run)


@pytest.mark.parametrize("kind", ["run", "table", "tuned"])
def test_machine_and_design_come_back_whole(kind: str, tmp_path: Path) -> None:
    """Also of a machine that no file holds, and infinite numbers through JSON."""
    spec = made(tmp_path, OTHER, FAST)
    if kind == "table":
        spec = str(Path(spec) / "table.json")
    if kind == "tuned":
        spec = str(tmp_path / "a.json")
        Tuned("gated", RULES["gated"].defaults(), record(FAST, OTHER)).save(Path(spec))
    found = bench([spec])
    assert found.motor == OTHER
    assert design_for(found.policy(spec), found.design) == FAST
    assert not found.notes


def test_a_rule_by_its_name_takes_what_is_asked_for(tmp_path: Path) -> None:
    found = bench(["eq25"], "ipmsm_2200w", ["hfi_pll_hz=40"])
    assert found.motor == Motor.load("ipmsm_2200w")
    assert design_for(found.policy("eq25"), found.design).hfi_pll_hz == 40.0
    assert bench(["eq25"]).motor == PAPER


@pytest.mark.parametrize("words", [[], ["hfi_pll_hz=40"], ["hfi_pll_hz=40.0", "carrier=true"]])
def test_the_same_value_is_no_contradiction(words: list[str], tmp_path: Path) -> None:
    spec = made(tmp_path, PAPER, FAST)
    assert design_for(bench([spec], "paper", words).policy(spec), DriveDesign()) == FAST


@pytest.mark.parametrize(
    "words",
    [
        ["evaluate", "--policy", "eq25", "--policy", "RUN"],
        ["export", "RUN", "--out", "out"],
        ["report", "RUN"],
        ["pil", "RUN"],
        ["replay", "sample", "--policy", "RUN"],
        ["simulate", "--policy", "RUN"],
    ],
    ids=lambda words: words[0],
)
def test_every_command_refuses_a_contradiction(words: list[str], tmp_path: Path) -> None:
    made(tmp_path, PAPER, FAST)
    words = [word.replace("RUN", "./run") for word in words]
    before = sorted(tmp_path.rglob("*"))
    for option, has, asked in (
        (["--set", "hfi_pll_hz=20"], "hfi_pll_hz=40", "hfi_pll_hz=20"),
        (["--motor", "ipmsm_2200w"], "paper", "ipmsm_2200w"),
    ):
        done = command(*words, *option, cwd=tmp_path)
        assert done.returncode == 2 and done.stderr.count("\n") == 1, done.stderr
        assert all(text in done.stderr for text in (has, asked, "./run", "--override"))
    assert sorted(tmp_path.rglob("*")) == before


def test_override_wins_for_that_setting_alone(tmp_path: Path) -> None:
    spec = made(tmp_path, PAPER, FAST)
    found = bench([spec], "ipmsm_2200w", ["hfi_pll_hz=20"], override=True)
    assert found.motor == Motor.load("ipmsm_2200w")
    assert design_for(found.policy(spec), found.design) == replace(FAST, hfi_pll_hz=20.0)


@pytest.mark.parametrize("spec", ["sliding_mode", "bench_own:OnSmo"])
def test_a_rule_and_python_keep_what_they_name(
    spec: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What contradicts their estimator is refused, or overrides, as with a file."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bench_own.py").write_text(
        'class OnSmo:\n    settings = {"estimator": "smo"}\n'
        "    def __init__(self, motor):\n        pass\n"
        "    def act(self, obs):\n        return [0.5] * len(obs)\n"
    )
    with pytest.raises(UserError, match=rf"set: estimator=flux .* {spec} brings estimator=smo: .*"):
        bench(["eq25", spec], None, ["estimator=flux"])
    same = bench([spec], None, ["estimator=smo", "hfi_pll_hz=20"])
    assert design_for(same.policy(spec), same.design).hfi_pll_hz == 20.0
    found = bench([spec], None, ["estimator=flux"], override=True)
    assert design_for(found.policy(spec), found.design).estimator == "flux"


def test_policies_of_two_machines_are_refused(tmp_path: Path) -> None:
    specs = [made(tmp_path, PAPER, FAST, "a"), made(tmp_path, OTHER, FAST, "b")]
    with pytest.raises(UserError, match=r"paper comes with the first policy.*made for mine"):
        bench(specs)
    changed = made(tmp_path, replace(PAPER, R_s=2.0, J=0.03), FAST, "c")
    with pytest.raises(UserError, match=rf"with R_s = 2.0 instead of {PAPER.R_s} and 1 more"):
        bench([changed], "paper")
    assert bench(specs, override=True).motor == PAPER
    assert len(bench(specs, override=True).policies(specs)) == 2


def test_a_start_is_only_numbers_of_any_machine(tmp_path: Path) -> None:
    spec = made(tmp_path, OTHER, FAST)
    assert table_named(spec, PAPER).digest == linear_table(*EQ25_BAND).digest


def test_a_schedule_of_many_machines_runs_on_any(tmp_path: Path) -> None:
    spec = made(tmp_path, None, FAST)
    assert bench([spec]).motor == PAPER
    assert bench([spec], "ipmsm_2200w").motor.name == "ipmsm_2200w"


def test_each_policy_is_judged_on_its_own_design(tmp_path: Path) -> None:
    """Beside others the same as alone, to the bit, and the results say what is its own."""
    spec = made(tmp_path, PAPER, replace(FAST, carrier=False))
    found = bench([spec, "eq25"])
    results = evaluate(PAPER, found.design, "paper", 0, 1, found.policies([spec, "eq25"]))
    assert results.policies["run"]["own"] == {"hfi_pll_hz": 40.0, "smo_emf_hz": 900.0}
    assert results.note("run") == "(hfi_pll_hz=40, smo_emf_hz=900)" and not results.note("eq25")
    scenarios, own = suite("stress-1", PAPER, 3, 4), found.policy(spec)
    factory = SimFactory(PAPER, replace(FAST, carrier=False))
    alone = rollout(found.policy("eq25"), scenarios, factory)
    beside = rollout(own, scenarios, SimFactory(PAPER, found.design))
    assert alone.sums.tobytes() == beside.sums.tobytes()


def test_an_export_has_the_design_of_its_run(tmp_path: Path, without_selftest: None) -> None:
    spec = made(tmp_path, OTHER, replace(FAST, carrier=False))
    done = command("export", spec, "--out", "out", "--no-fit", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    known = carried(KsTable.load(tmp_path / "out/ks_table.json").provenance, "out")
    assert known.motor == OTHER and known.settings["hfi_pll_hz"] == 40.0
    gain, other = (control_record(OTHER, d)["hfi"]["pll"]["k_p"] for d in (FAST, DriveDesign()))
    text = (tmp_path / "out/params.c").read_text()
    assert f"{gain:.9g}" in text and f"{other:.9g}" not in text


def test_a_default_that_has_changed_is_said_but_not_refused(tmp_path: Path) -> None:
    """What nobody chose follows the defaults of today, and the record tells what they were."""
    spec = made(tmp_path, PAPER, DriveDesign(speed_hz=3.0))
    path = Path(spec) / "table.json"
    table = KsTable.load(path)
    then = {**asdict(DriveDesign()), "hfi_pll_hz": 12.5, "speed_hz": 3.0}
    table.save(path, {**table.provenance, "design": then})
    found = bench([spec])
    assert found.notes == (
        f"{spec} was made with other defaults: hfi_pll_hz (12.5, now 14.934); {WHY}",
    )
    assert found.policy(spec).settings["hfi_pll_hz"] == DriveDesign().hfi_pll_hz
    assert not bench([spec], None, ["hfi_pll_hz=12.5"], override=True).notes


def test_formulas_that_have_changed_are_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of the parts that the drive runs on: another observer's do not count."""
    spec = made(tmp_path, PAPER, FAST)
    assert not bench([spec]).notes

    def other(motor: Motor, design: DriveDesign) -> Array:
        record = control_record(motor, design)
        record["control"]["inv_i_dt"] *= 1.01
        record["flux"]["gain_w"] *= 2.0
        return record

    monkeypatch.setattr("sensorless.design.fingerprint.control_record", other)
    said = f"{spec} was made on other gains: its control changed since; {WHY}"
    assert bench([spec]).notes == (said,) and (ROOT / WHY.split()[-1]).is_file()
    assert bench([spec]).policy(spec).settings == asdict(FAST), "and not refused"


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"machine": {"name": "x"}}, "description: missing"),
        ({"machine": {**asdict(PAPER), "J": -1.0}}, "J: -1"),
        ({"set": {"estimator": "magic"}}, "magic"),
        ({"set": {"unheard_of": 1}}, "unheard_of"),
        ({"set": [1]}, "set: [1] holds no settings by name"),
        ({"set": None}, "set: None holds no settings by name"),
        ({"set": "estimator=smo"}, "set: 'estimator=smo' holds no settings by name"),
        ({"design": 3}, "design: 3 holds no settings by name"),
        ({"design": {"smo_pll_hz": 10**400}}, "design: smo_pll_hz: 1000000"),
        ({"design": {"smo_pll_hz": [1]}}, "design: smo_pll_hz: [1]: must be a number"),
        ({"motor_digest": "0" * 64}, "motor_digest: '0000000000"),
        (
            {"machine": asdict(replace(PAPER, R_s=4.0)), "motor_digest": PAPER.digest},
            f"but that of its machine is {replace(PAPER, R_s=4.0).digest[:16]}",
        ),
    ],
)
def test_a_damaged_record_is_named(change: dict[str, object], said: str, tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    Tuned("linear", {"lo": 0.1, "hi": 0.5}, {**record(FAST, PAPER), **change}).save(path)
    with pytest.raises(UserError) as caught:
        bench([str(path)])
    assert said in str(caught.value) and "a.json" in str(caught.value)
    assert "\n" not in str(caught.value)
    assert json.loads(path.read_text())["provenance"]["machine"]


def test_a_machine_without_settings_is_named(tmp_path: Path) -> None:
    known = record(FAST, PAPER)
    Tuned("linear", {"lo": 0.1, "hi": 0.5}, {"machine": known["machine"]}).save(tmp_path / "a.json")
    with pytest.raises(UserError, match=r"a\.json: set, design: missing beside the machine"):
        bench([str(tmp_path / "a.json")])


@pytest.mark.parametrize(
    ("specs", "words", "said"),
    [
        (
            [],
            ["smo_gain=0.5"],
            ["smo_gain is for estimator=smo or unwrapped or errors; the drive has coupled"],
        ),
        (["eq25"], ["flux_gain=0.3"], ["flux_gain is for estimator=flux; the drive has coupled"]),
        (["sliding_mode"], ["L_q_bias=0.8"], []),
        (["sliding_mode", "eq25"], ["coupled_flux_hz=30"], []),
        (
            ["sliding_mode"],
            ["coupled_flux_hz=30"],
            ["coupled_flux_hz is for estimator=coupled; the drive has smo"],
        ),
        ([], ["coupled_flux_hz=30", "estimator=smo", "lost_lock=restart"], []),
        (["eq25"], ["error_pll_hz=20", "estimator=errors"], []),
        (["eq25"], ["smo_floor_rpm=30", "L_q_table=false", "speed_hz=3"], []),
    ],
)
def test_a_setting_of_an_observer_that_does_not_run_is_told(
    specs: list[str], words: list[str], said: list[str]
) -> None:
    assert list(bench(specs, None, words).notes) == said
