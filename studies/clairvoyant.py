"""How far k_s alone can go: the best k_s(t) that a search finds for each scenario, knowing it.

    python studies/clairvoyant.py --estimator smo
    python studies/clairvoyant.py --estimator smo --seeds mine runs/seed-1 runs/seed-2 runs/seed-3

For each of the first scenarios of the frozen suite, CMA-ES adds a line through knots, 100 ms apart,
to the k_s(t) of the policy that is best there, until torque deviation + torque ripple is least. No
drive can do that; it bounds what any schedule of k_s can reach, and as no search is ever done, the
true bound lies lower still. A policy's share of the headroom is how far it comes from Eq. 25 to
that bound, over the scenarios that it and Eq. 25 survive; one that sets gains besides may come
farther. The 95 % intervals resample scenarios, and with --seeds the training seeds of one learner
with them. A bound that is in the record is not searched again: delete the record after a change of
the drive.
"""

import argparse
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensorless.cli.study_numbers import a_count
from sensorless.decision import decision_time
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.frozen import FROZEN, MOTOR, SEED
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.errors import in_one_line
from sensorless.evaluation.metrics.catalogue import torque_dev_rms
from sensorless.evaluation.metrics.ripple import torque_ripple_rms
from sensorless.evaluation.over_seeds import half_width
from sensorless.evaluation.rollout import Floats, Rollout, rollout
from sensorless.files import write_record
from sensorless.machine.motor import Motor
from sensorless.policies import shipped
from sensorless.policies.bench import bench
from sensorless.policy import Policy, Signals, design_for, gains_of
from sensorless.tuning.batch import DRIVES
from sensorless.tuning.evolution import evolution
from sensorless.versions import versions

RECORD = Path(__file__).parents[1] / "results" / "studies" / "clairvoyant.json"
EQ25 = {"coupled": "eq25", "smo": "sliding_mode", "flux": "flux_observer"}
"""Eq. 25 on each estimator."""
KNOT = 0.1
"""Time between two knots [s]."""
SIGMA = 0.15
RESAMPLES = 2000
Weights = NDArray[np.float32]
LOST = 1e3
"""Cost of a lost scenario in the search."""


class Moved:
    """The k_s(t) of earlier runs, decision by decision, plus a line from knot to knot.

    Parameters
    ----------
    traces : array, shape (decisions, n)
    knots : array, shape (n, knots)
    """

    name = "moved"
    sensored = False

    def __init__(
        self, traces: Weights, knots: Floats, settings: Mapping[str, Any], decision: float
    ) -> None:
        self.traces, self.knots, self.settings = traces, knots, settings
        self._decision, self._count = decision, 0

    def reset(self, n: int) -> None:
        """Begin at the first decision."""
        self._count = 0

    def act(self, obs: Signals) -> Weights:
        """Weights (n,) at this time."""
        at = min(self._count * self._decision / KNOT, self.knots.shape[1] - 1.0)
        low = min(int(at), self.knots.shape[1] - 2)
        share = at - low
        more = (1.0 - share) * self.knots[:, low] + share * self.knots[:, low + 1]
        k_s = self.traces[self._count] + more
        self._count += 1
        return np.asarray(k_s.clip(0.0, 1.0), dtype=np.float32)


def errors(r: Rollout) -> Floats:
    """(2, n) torque deviation and ripple over rated torque; NaN where the drive was lost."""
    parts = np.stack([torque_dev_rms(r), torque_ripple_rms(r)])
    return np.where(r.lost == 0, parts, np.nan)


class Heard:
    """A policy of k_s, and what it asks for at every decision."""

    sensored = False

    def __init__(self, policy: Policy) -> None:
        self.name, self.settings, self._policy = policy.name, policy.settings, policy
        self.asked: list[Weights] = []

    def reset(self, n: int) -> None:
        """Forget the past."""
        self._policy.reset(n)

    def act(self, obs: Signals) -> Weights:
        """Weights (n,) of the policy."""
        self.asked.append(self._policy.act(obs))
        return self.asked[-1]


def searched(
    policies: Sequence[Policy], scenarios: Scenarios, factory: SimFactory, generations: int
) -> tuple[Floats, list[float]]:
    """Errors (2, n) of the best k_s(t) of each scenario, and the mean cost after generations.

    The search starts from the best policy of each scenario. All run on one drive.
    """
    heard = [Heard(policy) for policy in policies]
    known = np.stack([errors(rollout(policy, scenarios, factory)) for policy in heard])
    costs = np.nan_to_num(known.sum(axis=1), nan=LOST)
    first, n = costs.argmin(axis=0), costs.shape[1]
    best, cost = known[first, :, np.arange(n)].T, costs.min(axis=0)
    traces = np.stack([policy.asked for policy in heard])[first, :, np.arange(n)].T
    decision, settings = decision_time(factory.motor), policies[0].settings
    count = round(len(traces) * decision / KNOT) + 1
    searches = [evolution([0.0] * count, SIGMA, i, -1.0, 1.0) for i in range(n)]
    history = [float(cost.mean())]
    for _ in range(generations):
        asked = [search.ask() for search in searches]
        each = len(asked[0])
        rows, knots = np.repeat(np.arange(n), each), np.concatenate(asked)
        parts = []
        for start in range(0, len(rows), DRIVES):
            part = slice(start, start + DRIVES)
            moved = Moved(traces[:, rows[part]], knots[part], settings, decision)
            parts.append(errors(rollout(moved, scenarios[rows[part]], factory)))
        found = np.concatenate(parts, axis=1).reshape(2, n, each)
        costs = np.nan_to_num(found.sum(axis=0), nan=LOST)
        for i, search in enumerate(searches):
            search.tell(asked[i], costs[i].tolist())
            j = int(costs[i].argmin())
            if costs[i, j] < cost[i]:
                cost[i], best[:, i] = costs[i, j], found[:, i, j]
        history.append(float(cost.mean()))
    return best, history


def share(ours: Floats, base: Floats, bound: Floats) -> dict[str, Any]:
    """Share of the headroom, with its interval over seeds and scenarios.

    Parameters
    ----------
    ours : (seeds, n) cost of each training seed in each scenario; NaN where it was lost
    base, bound : (n,)
    """
    known = np.isfinite(ours) & np.isfinite(base)
    gain = np.where(known, base - np.nan_to_num(ours), 0.0)
    room = np.where(known, np.nan_to_num(base) - bound, 0.0)
    seeds, n = ours.shape
    rng = np.random.default_rng(0)
    of_rows = rng.multinomial(n, np.full(n, 1.0 / n), RESAMPLES)
    drawn = (of_rows @ gain.sum(axis=0)) / (of_rows @ room.sum(axis=0))
    low, high = np.quantile(drawn, (0.025, 0.975))
    found = float(gain.sum() / room.sum())
    if seeds > 1:
        half = half_width(gain.sum(axis=1) / room.sum(axis=1), float(drawn.std()), n)
        low, high = found - half, found + half
    return {"share": found, "share_ci": [float(low), float(high)]}


def policies_on(estimator: str) -> list[str]:
    """Shipped policies that run on this estimator."""
    design, words = DriveDesign(), []
    for word in shipped.docs({}).keys() - shipped.ALIASES.keys():
        if design_for(bench([word], MOTOR).policy(word), design).estimator == estimator:
            words.append(word)
    return sorted(words)


def judged(
    estimator: str, groups: Mapping[str, Sequence[str]], size: int, generations: int, old: Any
) -> dict[str, Any]:
    """Bound and shares on one estimator; the bound of a record of the same search is kept."""
    motor = Motor.load(MOTOR)
    factory, scenarios = SimFactory(motor, DriveDesign()), FROZEN[0].rows(motor)[:size].draw()
    words = {EQ25[estimator]: [EQ25[estimator]], **groups}
    found, able = {}, []
    for name, group in words.items():
        policies = [bench([w], MOTOR).policy(w) for w in group]
        found[name] = np.stack([errors(rollout(p, scenarios, factory)) for p in policies])
        able += [policy for policy in policies if not gains_of(policy)]
    about = {
        "suite": FROZEN[0].suite,
        "digest": FROZEN[0].digest,
        "seed": SEED,
        "size": size,
        "generations": generations,
    }
    if old is not None and {key: old[key] for key in about} == about:
        bound, history, core = np.array(old["bound"]), old["after_generations"], old["core"]
    else:
        core = versions()["core"][:12]
        bound, history = searched(able, scenarios, factory, generations)
    base_cost = found[EQ25[estimator]][0].sum(axis=0)
    return {
        **about,
        "core": core,
        "deviation": float(np.nanmean(bound[0])),
        "ripple": float(np.nanmean(bound[1])),
        "after_generations": [round(x, 6) for x in history],
        "policies": {
            name: {
                "seeds": len(parts),
                "lost": int(np.isnan(parts[:, 0]).sum()),
                "deviation": float(np.nanmean(parts[:, 0])),
                "ripple": float(np.nanmean(parts[:, 1])),
                **share(parts.sum(axis=1), base_cost, bound.sum(axis=0)),
            }
            for name, parts in found.items()
        },
        "bound": np.round(bound, 6).tolist(),
    }


def main() -> None:
    """Search, write the record, print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--estimator", choices=EQ25, action="append", help="default: all three")
    parser.add_argument("--size", type=a_count, default=128, help="scenarios")
    parser.add_argument(
        "--generations", type=a_count, default=50, help="of 13 runs a scenario each"
    )
    parser.add_argument("--policy", action="append", default=[], help="one more to judge")
    parser.add_argument(
        "--seeds", nargs="+", action="append", default=[], metavar=("NAME", "WORD"),
        help="training seeds of one learner",
    )  # fmt: skip
    args = parser.parse_args()
    record = json.loads(RECORD.read_text(encoding="utf-8")) if RECORD.is_file() else {}
    for estimator in args.estimator or EQ25:
        groups = {word: [word] for word in (*policies_on(estimator), *args.policy)}
        groups |= {name: words for name, *words in args.seeds}
        entry = judged(estimator, groups, args.size, args.generations, record.get(estimator))
        record[estimator] = entry
        write_record(RECORD, record)
        print(f"{estimator}: the bound deviates by {100 * entry['deviation']:.2f} %, ripple "
              f"{100 * entry['ripple']:.2f} %")  # fmt: skip
        for name, x in sorted(entry["policies"].items(), key=lambda item: item[1]["share"]):
            low, high = (100.0 * edge for edge in x["share_ci"])
            print(f"  {name:26} {100 * x['share']:6.1f} % ({low:.1f} to {high:.1f} %) of the "
                  f"headroom, lost {x['lost']}, deviation {100 * x['deviation']:.2f} %, ripple "
                  f"{100 * x['ripple']:.2f} %")  # fmt: skip


if __name__ == "__main__":
    in_one_line(main)
