"""Hand-over rules that the page offers: tables of k_s alone, which the core looks up itself."""

import dataclasses
from dataclasses import dataclass

import numpy as np

from sensorless.baselines.linear import EQ25_BAND
from sensorless.design.drive import DriveDesign
from sensorless.errors import UserError
from sensorless.machine.motor import MOTORS as FOLDER
from sensorless.machine.motor import Motor
from sensorless.policies.best import best
from sensorless.policies.registry import RULES, carried_by, make_policy
from sensorless.policy import TablePolicy, knows_truth
from sensorless.table.ks_table import Axis, KsTable

MOTORS = ("paper", *sorted(path.stem for path in FOLDER.glob("*.toml") if path.stem != "paper"))
WORDS = {
    "eq25": "Eq. 25, the paper's ramp (20 to 26.7 % of rated speed or more)",
    "smoothstep": "Smooth step over the same band",
    "sine": "Sine over the same band",
    "quadratic": "Parabola of the speed",
    "fuzzy": "Ten fuzzy rules: speed, acceleration, disagreement",
    "linear-coupled-tuned": "Ramp, tuned on the coupled observer",
    "logistic-coupled-tuned": "Speed, torque and disagreement, tuned",
    "reference": "Learned by PPO on the coupled observer",
    "reference-flux": "Learned by PPO on the flux observer",
    "ppo-smo-ks": "Learned by PPO on the sliding-mode observer",
    "sliding_mode": "Eq. 25 on the paper's observers",
    "flux_observer": "Eq. 25 on the flux observer",
    "error_blend": "Eq. 25 on two error signals in one loop",
    "constant:1": "Injection at every speed",
    "constant:0": "Observer at every speed",
}
"""Words of ``--policy``, and what the page calls them."""
BEST = "Best found for this machine"
OWN = "own"
OWN_TEXT = "Your own: Eq. 25 on 16 nodes, to be dragged"
OWN_AXIS = Axis("speed", 0.0, 0.6, 16)


@dataclass(frozen=True)
class Named:
    """A rule of the page."""

    word: str
    text: str
    policy: TablePolicy


def rules(motor: Motor) -> list[Named]:
    """Rules for a machine: learned and tuned ones only where they were made for it."""
    found = best(motor)
    words = dict(WORDS)
    if found is not None:
        words = {found.policy: WORDS.get(found.policy, BEST), **words}
    out = []
    for word, text in words.items():
        policy = _made(word, motor)
        if policy is not None:
            out.append(Named(word, text, policy))
    return [*out, Named(OWN, OWN_TEXT, _own())]


def without_table(motor: Motor) -> list[str]:
    """Names of rules that a drive can run but no table holds: Python decides, not the core."""
    made = {
        name: make_policy(name, motor) for name, rule in RULES.items() if not rule.needs_numbers
    }
    return [
        name
        for name, policy in made.items()
        if not isinstance(policy, TablePolicy) and not knows_truth(policy)
    ]


def _own() -> TablePolicy:
    """Eq. 25 where the nodes are."""
    low, high = EQ25_BAND
    values = np.clip((high - OWN_AXIS.nodes) / (high - low), 0.0, 1.0)
    return TablePolicy(OWN, KsTable((OWN_AXIS,), values.astype(np.float32)))


def _made(word: str, motor: Motor) -> TablePolicy | None:
    """Table of k_s on the default drive; None if the word is not one, or for another machine."""
    try:
        policy = make_policy(word, motor)
        carried = carried_by(word)
    except UserError:
        return None
    if carried is not None and carried.made_for is not None and carried.made_for[1] != motor.digest:
        return None
    if not isinstance(policy, TablePolicy) or policy.table.gains or not _default(policy):
        return None
    return policy


def _default(policy: TablePolicy) -> bool:
    """Whether it runs on the default drive, but for its estimator."""
    rest = {name: x for name, x in policy.settings.items() if name != "estimator"}
    return dataclasses.replace(DriveDesign(), **rest) == DriveDesign()
