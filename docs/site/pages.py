"""Pages of the site that are made from the code and its records."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from docs.site import notebooks
from docs.site.tables import motors

API = {
    "environment": (
        "Environment",
        "What `gymnasium.make` and `gymnasium.make_vec` give, and what they take.",
        (
            "envs.blend_env.BlendEnv",
            "envs.blend_vector_env.BlendVectorEnv",
            "envs.blend_settings.BlendSettings",
            "envs.blend_settings.GainSettings",
            "envs.blend_v1.GainEnv",
            "envs.blend_v1.GainVectorEnv",
            "envs.reward",
            "envs.window_reward",
            "envs.privileged",
        ),
    ),
    "policies": (
        "Policies and rules",
        "What chooses the weight `k_s`: the protocol, the rules by name, and how to add one.",
        ("policy", "policies.registry", "baselines.rule"),
    ),
    "machine": (
        "Machine and drive",
        "From a motor file and settings to the numbers that the drive runs on.",
        ("machine.motor", "design.drive", "design.derived", "suitability.examine"),
    ),
    "evaluation": (
        "Scenarios and evaluation",
        "From a suite's name to results.",
        (
            "envs.scenarios.scenario",
            "envs.scenarios.suites",
            "evaluation.evaluate",
            "evaluation.results",
            "evaluation.metrics.catalogue",
            "evaluation.trace",
        ),
    ),
    "training": (
        "Training and tuning",
        "PPO on the nodes of a table, CMA-ES on the numbers of a rule.",
        ("agents.train.config", "agents.train.train", "tuning.tune"),
    ),
    "export": (
        "Table, export, replay",
        "The table and its image in C, the folder for firmware, observers over a log.",
        ("table.ks_table", "export.export", "replay.log", "replay.replay"),
    ),
}
"""Title, what it is, and the modules or classes of ``sensorless`` on each page of the API."""

HERE = Path(__file__).parent


def _api(title: str, about: str, names: Sequence[str]) -> str:
    parts = "\n\n".join(f"::: sensorless.{name}" for name in names)
    return f"# {title}\n\n{about}\n\n{parts}\n"


MADE: dict[str, Callable[[], str]] = {
    "environment.md": lambda: (HERE / "environment.md").read_text(encoding="utf-8"),
    "motors.md": motors,
    **{place: partial(notebooks.page, path) for place, path in notebooks.PAGES.items()},
    **{f"api/{name}.md": partial(_api, *about) for name, about in API.items()},
}
"""Place on the site, and what makes the Markdown there."""
