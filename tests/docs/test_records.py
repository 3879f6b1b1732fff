"""Tables of the pages are those of the records in ``results/studies``."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
OTHERS = "results-other-observers.md"


def record(name: str) -> Any:
    return json.loads((ROOT / "results" / "studies" / f"{name}.json").read_text(encoding="utf-8"))


def text(page: str) -> str:
    return (ROOT / "docs" / page).read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("name", "place"), [("identify", 0), ("identify-held-out", 1), ("identify-details", 2)]
)
def test_errors_of_an_identification(name: str, place: int) -> None:
    told = record(name)["summary"]
    page = text("identify.md")
    for what in ("R_s", "psi_f", "L_d", "L_q", "J"):
        row = re.findall(rf"^\| {what}, at most \d+ % \|(.*)\|$", page, re.MULTILINE)[place]
        found = told[what]
        assert [cell.strip() for cell in row.split("|")] == [
            f"{found['within']} of {told['identified']}",
            f"{100 * found['median']:.2f} %",
            f"{100 * found['95 %']:.2f} %",
            f"{100 * found['worst']:.1f} %",
        ], what


def test_faults_of_sensors() -> None:
    campaign = record("fault_campaign")
    faults = [f for e in campaign.values() if "faults" in e for f in e["faults"].values()]
    total = {name: sum(f[name] for f in faults) for name in ("cases", "lost", "tripped")}
    page = " ".join(text("protection.md").split())
    assert f"{total['cases']} cases over five estimators" in page
    assert sum(f["lost_unseen"] for f in faults) == 0
    assert f"All {total['lost']} lost drives had a fault bit within 50 ms" in page
    assert f"of {total['tripped']} trips {sum(f['tripped_unseen'] for f in faults)} came" in page
    assert f"largest current was {max(f['peak_A'] for f in faults):.1f} A" in page


def test_gains_on_many_machines() -> None:
    machines = list(record("any_machine")["machines"].values())
    lost = {s: [m[s]["lost_rate"] for m in machines] for s in ("nominal", "stress-1")}
    means = [
        100 * np.exp(np.mean(np.log([m["nominal"][name] for m in machines])))
        for name in ("torque_dev_rms", "torque_ripple_rms")
    ]
    page = text("gains-trials.md")
    (row,) = re.findall(r"^\| \*\*from the machine\*\* \|(.*)\|$", page, re.MULTILINE)
    assert [cell.strip(" *") for cell in row.split("|")] == [
        f"{100 * np.mean(lost['nominal']):.2f} %",
        f"{sum(x <= 0.01 for x in lost['nominal'])} of {len(machines)}",
        f"{means[0]:.2f} / {means[1]:.2f} %",
        f"{100 * np.mean(lost['stress-1']):.2f} % ({100 * np.median(lost['stress-1']):.0f})",
    ]


def test_one_schedule_against_a_rule_for_each_machine() -> None:
    shares = record("random_machines")["shares"]
    for word, found in shares.items():
        (row,) = re.findall(
            rf"^\| `{word}` \| (\d+) % \| (.*) % \| (\d+) % \| (.*) % \| (\d+) \| (\d+) % \|$",
            text("random-machines.md"), re.MULTILINE,
        )  # fmt: skip
        told = [float(cell.replace("−", "-")) for cell in row]
        names = (
            f"torque_{m}_rms_{what}" for m in ("dev", "ripple") for what in ("as_good", "more")
        )
        values = [100.0 * found[name] for name in names]
        assert told[:4] == pytest.approx(values, abs=0.51), word
        assert told[1] == pytest.approx(values[1], abs=0.051), word
        assert told[4:] == pytest.approx([found["lost"], 100.0 * found["no_more_lost"]], abs=0.51)
    assert f"its own ramps {shares['eq25']['lost_tuned']} " in text("random-machines.md")


def near(told: str, value: float) -> bool:
    decimals = len(told.partition(".")[2])
    return abs(float(told) - value) <= 0.51 * 10.0**-decimals


def test_rated_torque_at_standstill() -> None:
    motors = record("standstill")["motors"]
    part = text("control.md").split("## Rated torque at standstill")[1]
    name, rows = "", re.findall(r"^\| (?:`(\w+)`, )?`(\w+)` \|(.*)\|$", part, re.MULTILINE)
    assert len(rows) == 2 * len(motors)
    for motor, estimator, cells in rows:
        name = motor or name
        found = motors[name][estimator]
        wanted = [
            found[j][x] for j in ("J x 1", "J x 0.5") for x in ("torque_pct", "torque_worst_pct")
        ]
        told = re.findall(r"[\d.]+", cells)
        assert all(map(near, told, [*wanted, found["dip_rpm"], found["twin_dip_rpm"]]))
        assert ("limit cycle" in cells) == any(
            found[j]["limit_cycle"] for j in ("J x 1", "J x 0.5")
        )


def of_the_lost(
    report: dict[str, Any], restart: dict[str, Any], truth: dict[str, Any]
) -> tuple[str, ...]:
    """Cells of a row on what is detected, and on what comes back."""
    return (
        f"{100 * report['detected_rate']:.0f} %",
        " / ".join(
            f"{100 * x['recovered_rate']:.0f} % of {x['lock_counts']['could_recover']}"
            for x in (report, restart)
        ),
        f"{truth['possible_recovered']} of {truth['possible']}",
        f"{restart['allowed_recovered']} of {restart['allowed']}",
        f"{restart['kept']} of {restart['otherwise_lost']}",
    )


def test_drives_that_know_that_they_are_lost() -> None:
    found = {(f["motor"], f["estimator"], f["lost_lock"]): f for f in record("lock")["found"]}
    page, names = text("lock-counts.md"), {"coupled": "coupled", "SMO": "smo", "flux": "flux"}
    rows = re.findall(r"^\| `(\w+)`, (coupled|SMO|flux) \|(.*)\|$", page, re.MULTILINE)
    back = possible = 0
    load = np.zeros(2, dtype=int)
    for motor, label, cells in rows:
        report, restart, truth = (
            found[motor, names[label], action] for action in ("report", "restart", "truth")
        )
        count = report["lock_counts"]
        back, possible = back + truth["possible_recovered"], possible + truth["possible"]
        load += (restart["allowed_recovered"], restart["allowed"])
        assert [cell.strip() for cell in cells.split("|")] == [
            f"{report['held_s']:.0f}",
            f"{count['false_alarms']}" + f" ({count['near_losses']})" * bool(count["false_alarms"]),
            f"{count['lost']}",
            *(of_the_lost(report, restart, truth) if count["lost"] else ("",) * 5),
        ]
    told = {(motor, names[label]) for motor, label, _ in rows}
    quiet = [x for key, x in found.items() if key[:2] not in told]
    assert len(rows) == 7 and len(quiet) == len(found) - 21
    assert all(x["lock_counts"]["lost"] == x["lock_counts"]["false_alarms"] == 0 for x in quiet)
    flat = " ".join(page.split())
    assert f"Of them {back} of the {possible} losses that a perfect search" in flat
    assert f"and {load[0]} of the {load[1]} that the load allows" in flat
    restarts = [x for x in found.values() if x["lost_lock"] == "restart"]
    kept, of = (sum(x[name] for x in restarts) for name in ("kept", "otherwise_lost"))
    assert f"`restart` keeps {kept} of the {of} drives that `report` loses" in flat


def test_returns_of_three_rules() -> None:
    policies = record("returns")["policies"]
    page = text("learning-trials.md")
    labels = {
        "logistic-tuned": "`logistic-tuned`",
        "eq25": "Eq. 25",
        "gated-tuned": "`gated-tuned`",
    }
    for name, found in policies.items():
        (row,) = re.findall(rf"^\| {labels[name]} \| (−.*)\|$", page, re.MULTILINE)
        slow = found["5 ms"]
        values = [-slow["return"], -found["1 ms"]["return"], slow["lost"]]
        values += [100.0 * found[x] for x in ("torque_dev_rms", "torque_ripple_rms")]
        assert all(map(near, re.findall(r"[\d.]+", row), values)), name
    worst = min(x["5 ms"]["worst"] for x in policies.values())
    assert f"what the worst survivor pays ({-worst:.0f})" in page


def test_share_of_the_headroom() -> None:
    found = record("clairvoyant")
    page = text("studies.md")
    (row,) = re.findall(r"^\| deviation, ripple of Eq\. 25 and .*?\|(.*)\|$", page, re.MULTILINE)
    eq25 = {"coupled": "eq25", "smo": "sliding_mode", "flux": "flux_observer"}
    for cell, (name, rule) in zip(row.split("|"), eq25.items(), strict=True):
        at, bound = found[name]["policies"][rule], found[name]
        values = [100 * x[y] for x in (at, bound) for y in ("deviation", "ripple")]
        assert all(map(near, re.findall(r"[\d.]+", cell), values)), name
    last = [1 - x["after_generations"][-1] / x["after_generations"][-11] for x in found.values()]
    assert f"by {100 * min(last):.1f} to {100 * max(last):.1f} %." in page


def test_learning_with_gains() -> None:
    """Both tables of five seeds, and what is lost on the harder suites."""
    page = text(OTHERS).split("### With gains\n")[1].split("\n### ")[0]
    judged = record("learning")["smo-gains"]["judged"]
    rows = re.findall(r"^\| .* \|$", page, re.MULTILINE)
    found = [judged[f"stress-1:{seed}"]["policies"] for seed in (11, 12)]
    for row, name in zip(rows[1:11], found[0], strict=True):
        runs = [x[name] for x in found]
        kept = [x["of"] - x["lost"] for x in runs]
        metrics = ("torque_dev_rms", "torque_ripple_rms", "overshoot_excess_pct", "injection_share")
        values = [np.average([x[m] for x in runs], weights=kept) for m in metrics]
        scaled = np.array(values) * (100.0, 100.0, 1.0, 100.0)
        cells = [cell.strip() for cell in row.split("|")[2:-1]]
        assert int(cells[0]) == sum(x["lost"] for x in runs), name
        assert all(map(near, cells[1:], scaled)), name
    for row, changes in zip(
        rows[12:], judged["stress-1:11"]["agents against"].values(), strict=True
    ):
        values = [x for m in metrics[:3] for x in changes[m].values()]
        told = re.findall(r"[-+]?\d+\.\d", row.split("|", 2)[2].replace("−", "-"))
        assert [float(t) for t in told] == pytest.approx(values, abs=0.051)
    for suite in ("hard", "low-inertia", "mismatch"):
        lost = {name: x["lost"] for name, x in judged[f"{suite}:11"]["policies"].items()}
        seeds = [n for name, n in lost.items() if name.startswith("ppo")]
        assert f" {min(seeds)} to {max(seeds)} " in " ".join(page.split()), suite


def test_learning_where_many_are_lost() -> None:
    """What each loses on four suites, its means on one, and the changes of five seeds."""
    page = text(OTHERS).split("### Where many are lost\n")[1].split("\n## ")[0]
    judged = record("learning")["smo-robust"]["judged"]
    rows = re.findall(r"^\| .* \|$", page, re.MULTILINE)
    suites = ("mismatch:11", "low-inertia:11", "hard:11", "stress-1:11")
    metrics = ("torque_dev_rms", "torque_ripple_rms", "injection_share")
    for row, name in zip(rows[1:10], judged["hard:11"]["policies"], strict=True):
        found = [judged[suite]["policies"][name] for suite in suites]
        cells = [cell.strip() for cell in row.split("|")[2:-1]]
        assert [int(cell) for cell in cells[:4]] == [x["lost"] for x in found], name
        assert all(map(near, cells[4:], [100.0 * found[3][m] for m in metrics])), name
    against = judged["stress-1:11"]["agents against"]
    for row, name in zip(rows[11:], ("eq25", "tuned-smo-gains", "scheduled"), strict=True):
        names = ("torque_dev_rms", "torque_ripple_rms", "overshoot_excess_pct")
        values = [x for m in names for x in against[name][m].values()]
        told = re.findall(r"[-+]?\d+\.\d", row.split("|", 2)[2].replace("−", "-"))
        assert [float(t) for t in told] == pytest.approx(values, abs=0.051)
    for suite in suites[:3]:
        lost = {n: x["lost"] for n, x in judged[suite]["policies"].items()}
        assert all(2 * n <= lost["tuned-smo-gains"] for m, n in lost.items() if "seed" in m)


def test_first_page_on_gains() -> None:
    """Changes of five seeds against Eq. 25, and those of the rules with the same gains."""
    page = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    names = ("injection_share", "torque_dev_rms", "torque_ripple_rms")
    cases = {c: record("learning")[c]["judged"]["stress-1:11"] for c in ("coupled", "smo-gains")}
    off = {
        c: [f"{-x['agents against']['eq25'][n]['change']:.0f}" for n in names]
        for c, x in cases.items()
    }
    on, deviation, ripple = off["coupled"]
    assert f"for {on} % less of the time than Eq. 25, with {deviation} % less deviation" in page
    assert f"and {ripple} % less ripple" in page
    assert f"take {off['smo-gains'][1]} % off the deviation of Eq. 25 and" in page
    assert f"and {off['smo-gains'][2]} % off its ripple" in page
    found = cases["smo-gains"]["policies"]
    rules = [found[name] for name in ("tuned-smo-gains", "static", "scheduled")]
    less = [sorted(round(100 - 100 * r[n] / found["eq25"][n]) for r in rules) for n in names[1:]]
    told = " and ".join(f"{x[0]} to {x[-1]}" for x in less)
    assert f"gains take {told} % off" in page
