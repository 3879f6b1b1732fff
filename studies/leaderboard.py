"""Judge policies on the frozen suites: results/leaderboard.csv, and docs/leaderboard.md from it.

    python studies/leaderboard.py
    python studies/leaderboard.py --policy examples.own_rule:MoreUnderLoad
    python studies/leaderboard.py --pair reference linear-coupled-tuned

Without --policy it judges every policy that ships, and drops all other rows at the end. With
--policy it judges these alone and leaves the other rows as they are. The machine is the paper's.
With --pair it runs nothing: it compares two policies scenario by scenario on the first suite, from
results/leaderboard.npz, which has torque deviation and ripple in each.
"""

import argparse
import csv
import io
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binomtest

from sensorless.design.fingerprint import fingerprint
from sensorless.envs.scenarios.frozen import FROZEN, MOTOR, SEED, Frozen
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.errors import UserError, in_one_line
from sensorless.evaluation.aggregate import mean_interval, summary
from sensorless.evaluation.evaluate import score
from sensorless.evaluation.objective import weighted
from sensorless.evaluation.results_tables import number
from sensorless.files import write_atomic
from sensorless.policies import shipped
from sensorless.policies.bench import Bench, bench
from sensorless.policy import Policy, design_for, knows_truth
from sensorless.versions import versions

ROOT = Path(__file__).parents[1]
CSV, PAGE = ROOT / "results" / "leaderboard.csv", ROOT / "docs" / "leaderboard.md"
FORM = ROOT / "docs" / "site" / "leaderboard.md"
"""The page without its tables."""
EACH = ROOT / "results" / "leaderboard.npz"
STEP, LOST = 1e-4, 65535
"""Unit of ``EACH``, over rated torque; its largest number stands for a scenario not survived."""
HEADROOM = ROOT / "results" / "studies" / "clairvoyant.json"
PLAIN = ("eq25", "sliding_mode", "flux_observer", "error_blend", "sensored")
"""Rules as they are that belong there: Eq. 25 on each estimator, and the bound."""
COLUMNS = (
    ("torque_dev_rms", "torque deviation [%]", 100.0, 2),
    ("torque_ripple_rms", "torque ripple [%]", 100.0, 2),
    ("overshoot_excess_pct", "overshoot beyond the twin's [%]", 1.0, 2),
    ("angle_err_rms_deg", "angle error [°]", 1.0, 2),
    ("injection_share", "injection on [%]", 100.0, 1),
    ("hops", "`k_s` hops in [%]", 100.0, 1),
)
"""Metric, heading, factor and decimals."""
FIRST = FROZEN[0].suite
TITLES = {
    "coupled": "The default drive: coupled observer",
    "flux": "Flux observer",
    "smo": "The paper's sliding-mode observer",
    "errors": "Injection and sliding-mode observer in one loop",
    "": "Position sensor: the bound",
}
"""What a table is headed by, by estimator."""

Row = Mapping[str, str]
Short = NDArray[np.uint16]


def shipped_words() -> list[str]:
    """Every policy that comes with the package and belongs there."""
    return [*PLAIN, *(name for name in shipped.docs({}) if name not in shipped.ALIASES)]


def admitted(word: str) -> tuple[Bench, Policy]:
    """Return a policy that may stand beside the others.

    Raises
    ------
    UserError
        Its name is that of another policy, or its settings move the twin that all are measured by.
    """
    made = bench([word], MOTOR)
    policy = made.policy(word)
    if policy.name != word and policy.name in shipped_words():
        raise UserError(f"policy: {word!r}: name: {policy.name!r} ships; give it one of its own")
    own = fingerprint(made.motor, design_for(policy, made.design))["control"]
    if own != fingerprint(made.motor, made.design)["control"]:
        raise UserError(
            f"policy: {word!r}: settings: they change the control, and so the drive with an "
            "encoder that torque is measured by; set the estimator and its observer alone"
        )
    return made, policy


def judged(word: str, frozen: Frozen) -> tuple[Row, Short]:
    """One policy on one suite: its row, and (n, 2) torque deviation and ripple by scenario."""
    made, policy = admitted(word)
    s = score(policy, frozen.rows(made.motor), SimFactory(made.motor, made.design))
    names = ("not_held", "k_s_hop", *(name for name, *_ in COLUMNS))
    found = summary(s.lost, {name: s.metrics[name] for name in names}, SEED)
    feasible = len(s.lost) - found["lost_by_cause"]["twin"]
    lost = round(found["lost_rate"] * feasible)
    exact = binomtest(lost, feasible).proportion_ci(0.95)
    cost = weighted(found["lost_rate"], found["torque_dev_rms"], found["torque_ripple_rms"])
    row: dict[str, Any] = {
        "suite": frozen.suite,
        "digest": frozen.digest,
        "policy": policy.name,
        "estimator": "" if policy.sensored else design_for(policy, made.design).estimator,
        "bound": int(knows_truth(policy)),
        "core": versions()["core"][:12],
        "feasible": feasible,
        "lost": lost,
        "lost_low": exact.low,
        "lost_high": exact.high,
        "not_held": round(found["not_held_rate"] * feasible),
        "objective": cost,
    }
    for name in names[1:]:
        row[name], (row[f"{name}_low"], row[f"{name}_high"]) = found[name], found[f"{name}_ci"]
    both = np.stack([s.metrics[name] for name, *_ in COLUMNS[:2]], axis=-1)
    kept = np.where((s.lost == 0)[:, None], np.rint(np.nan_to_num(both) / STEP), LOST)
    each = kept.clip(0, LOST).astype("<u2")
    return {k: f"{x:.6g}" if isinstance(x, float) else str(x) for k, x in row.items()}, each


def pair(name: str, other: str, each: Mapping[str, Short]) -> str:
    """Say how a policy differs from another one in the scenarios that both survive."""
    here, there = each[name].astype(float), each[other].astype(float)
    lost = [np.any(x == LOST, axis=1) for x in (here, there)]
    kept = ~(lost[0] | lost[1])
    lines = [f"{name} beside {other}, {FIRST}: lost {lost[0].sum()} and {lost[1].sum()}"]
    for j, (_, heading, *_) in enumerate(COLUMNS[:2]):
        apart, base = (here - there)[kept, j], np.mean(there[kept, j])
        low, high = (100.0 * x / base for x in mean_interval(apart, SEED))
        what = heading.removesuffix(" [%]")
        lines.append(f"{what}: {100.0 * apart.mean() / base:+.2f} % ({low:+.2f} to {high:+.2f} %)")
    return "\n".join(lines)


def kept_each(path: Path) -> dict[str, Short]:
    """Errors by scenario, by policy; none without a file."""
    if not path.is_file():
        return {}
    with np.load(path) as found:
        return {name: found[name] for name in found.files}


def write_each(path: Path, each: Mapping[str, Short]) -> None:
    """Write errors by scenario, an array (n, 2) for each policy; the same bytes for the same."""
    file = io.BytesIO()
    named: dict[str, Any] = {name: each[name] for name in sorted(each)}
    np.savez_compressed(file, **named)
    write_atomic(path, file.getvalue())


def read(path: Path) -> list[Row]:
    """Rows of the file; none if there is none."""
    if not path.is_file():
        return []
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def headroom() -> dict[str, str]:
    """Share of the headroom by policy [%], of those that ``studies/clairvoyant.py`` judged."""
    if not HEADROOM.is_file():
        return {}
    entries = json.loads(HEADROOM.read_text(encoding="utf-8")).values()
    found = {name: x for entry in entries for name, x in entry["policies"].items()}
    out = {}
    for name, x in found.items():
        share, low, high = (number(100.0 * y, 0) for y in (x["share"], *x["share_ci"]))
        out[name] = f"{share} ({low} … {high})"
    return out


def ordered(rows: Sequence[Row]) -> list[Row]:
    """By suite, then by the objective on the first suite."""
    suites = [frozen.suite for frozen in FROZEN]
    first = {row["policy"]: float(row["objective"]) for row in rows if row["suite"] == FIRST}
    return sorted(rows, key=lambda row: (suites.index(row["suite"]), first[row["policy"]]))


def text_of(rows: Sequence[Row]) -> str:
    """Content of the file."""
    out = io.StringIO()
    writer = csv.DictWriter(out, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return out.getvalue()


def page(rows: Sequence[Row]) -> str:
    """Markdown with a table for each estimator, and one of what is lost on each suite."""
    parts, first = [], [row for row in rows if row["suite"] == FIRST]
    heads = (
        "policy",
        "objective [%]",
        "lost",
        "not held",
        *(c[1] for c in COLUMNS),
        "headroom [%]",
    )
    groups = {row["estimator"]: True for row in first if row["bound"] == "0"}
    for estimator in (*groups, ""):
        some = [row for row in first if row["estimator"] == estimator]
        if some:
            setting = f"`--set estimator={estimator}`, " if estimator else ""
            about = f"{setting}`{FIRST}`, seed {SEED}, {FROZEN[0].size} scenarios:"
            title = TITLES.get(estimator, f"Estimator `{estimator}`")
            parts.append(f"## {title}\n\n{about}\n\n{_table(heads, some, _cells)}")
    by_key = {(row["suite"], row["policy"]): row for row in rows}
    heads = ("policy", "estimator", *(f"`{f.suite}`, of {f.size}" for f in FROZEN))
    parts.append(
        "## Lost by suite\n\nScenarios lost; below, the mean torque deviation of the others [%]:"
        f"\n\n{_table(heads, first, lambda row: _suites(row, by_key))}"
    )
    return FORM.read_text(encoding="utf-8").format(tables="\n".join(parts))


def _table(heads: Sequence[str], rows: Sequence[Row], cells: Callable[[Row], list[str]]) -> str:
    lines = [heads, ["---"] * len(heads), *map(cells, rows)]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def _label(row: Row) -> str:
    """Name of a policy, with its second name."""
    also = [name for name, what in shipped.ALIASES.items() if what == row["policy"]]
    return " = ".join(f"`{name}`" for name in (row["policy"], *also))


def _cells(row: Row) -> list[str]:
    low, high = (f"{100.0 * float(row[key]):.2f}" for key in ("lost_low", "lost_high"))
    out = [_label(row), f"{100.0 * float(row['objective']):.2f}"]
    out += [f"{row['lost']} of {row['feasible']}<br>({low}–{high} %)", row["not_held"]]
    for name, _, factor, decimals in COLUMNS:
        value, low_, high_ = (factor * float(row[name + end]) for end in ("", "_low", "_high"))
        out.append(
            f"{number(value, decimals)}&nbsp;±&nbsp;{number(0.5 * (high_ - low_), decimals)}"
        )
    return [*out, headroom().get(row["policy"], "–")]


def _suites(row: Row, by_key: Mapping[tuple[str, str], Row]) -> list[str]:
    out = [_label(row), row["estimator"] or "–"]
    for frozen in FROZEN:
        found = by_key.get((frozen.suite, row["policy"]))
        deviation = number(100.0 * float(found["torque_dev_rms"]), 2) if found else ""
        out.append(f"{found['lost']}<br>{deviation}" if found else "–")
    return out


def main() -> None:
    """Judge, and write file and page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--policy", action="append", help="policy to judge; repeat for several")
    parser.add_argument("--pair", nargs=2, metavar=("POLICY", "OTHER"), help="compare these two")
    args = parser.parse_args()
    if args.pair:
        name, other = args.pair
        each = kept_each(EACH)
        if not {name, other} <= set(each):
            parser.error(f"pair: choose from {', '.join(each)}")
        print(pair(name, other, each))
        return
    judge_all(args.policy or shipped_words(), drop_others=not args.policy)


def judge_all(words: Sequence[str], *, drop_others: bool) -> None:
    """Judge these policies; an interrupted run leaves the rows of the others as they were."""
    rows = {(row["suite"], row["policy"]): row for row in read(CSV)}
    each, done = kept_each(EACH), set[str]()
    for word in words:
        for frozen in FROZEN:
            row, errors = judged(word, frozen)
            rows[row["suite"], row["policy"]] = row
            done.add(row["policy"])
            if frozen.suite == FIRST:
                each[row["policy"]] = errors
        store(list(rows.values()), each)
        print(f"judged {word}", flush=True)
    if drop_others:
        kept = [row for row in rows.values() if row["policy"] in done]
        store(kept, {name: x for name, x in each.items() if name in done})


def store(rows: Sequence[Row], each: Mapping[str, Short]) -> None:
    """Write the file, the errors by scenario and the page."""
    found = ordered(rows)
    write_atomic(CSV, text_of(found))
    write_each(EACH, each)
    write_atomic(PAGE, page(found))


if __name__ == "__main__":
    in_one_line(main)
