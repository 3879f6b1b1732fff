"""Policies that come with the package: the learned schedules, and the tuned rules."""

from collections.abc import Mapping
from pathlib import Path

from sensorless.policies.tuned import Tuned

FOLDER = Path(__file__).absolute().parents[1] / "reference"
"""``results/reference`` of the repository."""
RUNS = {"reference": "", "reference-flux": "flux"}
"""Learned schedules by name, and their folders within ``FOLDER``."""
ALIASES = {
    "tuned-coupled": "fuzzy-coupled-tuned",
    "tuned-smo": "logistic-tuned",
}
"""Second names, by what a policy is: who made it, on which drive."""
LEARNED = "learned"
"""Folder of the learned policies, and of rules that set gains, within ``FOLDER``."""
SETS = {
    "ks": ("k_s", "logistic-tuned"),
    "gains": ("k_s and gains", "an earlier tuned-smo-gains"),
    "robust": ("k_s and gains against losses", "the rule"),
    "coupled": ("k_s and gains", "a narrow ramp"),
    "machines": ("k_s and gains, any machine,", "a ramp"),
}
"""What one of them sets, and what PPO began with, by the last part of its name."""
SUFFIX = "-tuned"


def reference_run(name: str = "reference") -> Path | None:
    """Folder of a learned schedule of ``RUNS``; None if it does not exist."""
    folder = FOLDER / RUNS[name] if name in RUNS else None
    return folder if folder is not None and (folder / "table.json").is_file() else None


def tuned_file(name: str) -> Path:
    """Path of a tuned rule, such as ``linear-tuned``; the file need not exist."""
    return FOLDER / "tuned" / f"{name}.json"


def learned_names() -> list[str]:
    """Names of the policies in ``LEARNED``."""
    return sorted(path.stem for path in (FOLDER / LEARNED).glob("*.json"))


def learned_file(name: str) -> Path:
    """Path of one of them: a table, or a tuned rule."""
    return FOLDER / LEARNED / f"{name}.json"


def tuned_names() -> list[str]:
    """Names of all tuned rules."""
    return sorted(path.stem for path in (FOLDER / "tuned").glob(f"*{SUFFIX}.json"))


def docs(own: Mapping[str, str | None]) -> dict[str, str]:
    """One line about each policy, by name.

    Parameters
    ----------
    own : mapping
        By name of a rule, the estimator that it brings along, or None.

    Raises
    ------
    UserError
        A file is damaged.
    """
    lines = {}
    for name in tuned_names():
        tuned = Tuned.load(tuned_file(name))
        budget = float(tuned.provenance.get("budget_s", "nan"))
        runs_on = own.get(tuned.rule) or tuned.carried(str(tuned_file(name))).settings["estimator"]
        lines[name] = (
            f"{tuned.rule} with parameters found by CMA-ES in {budget:g} s simulated, "
            f"estimator={runs_on}"
        )
    for name in learned_names():
        kind, on = name.split("-")[:2]
        sets, start = SETS[name.rpartition("-")[2]]
        how = f"PPO from {start}" if kind == "ppo" else "CMA-ES on a rule"
        lines[name] = f"{sets} on the {on} drive by {how}, best in validation"
    lines |= {name: f"the same as {other}" for name, other in ALIASES.items()}
    for name, where in RUNS.items():
        if reference_run(name) is not None:
            lines[name] = f"the schedule of {Path('results/reference', where)}, learned by PPO"
    return lines
