"""Pictures of the theory pages and figures of whole suites: ``make docs-test``."""

import numpy as np
import pytest

from docs.site import figures
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import SuiteRows, suite
from sensorless.evaluation import compare
from sensorless.evaluation.compare import outcomes
from sensorless.evaluation.evaluate import score
from sensorless.evaluation.rollout import are_feasible
from sensorless.export import judge
from sensorless.machine.motor import MOTORS, Motor
from sensorless.plots.figure import png
from sensorless.policies.bench import bench
from sensorless.policies.registry import make_policy
from tests.helpers.documentation import ROOT, text
from tests.helpers.drives import Alone

DOCS = ROOT / "docs"


@pytest.mark.parametrize("name", figures.FIGURES)
def test_a_picture_is_drawn_from_a_few_points(name: str) -> None:
    assert png(figures.FIGURES[name](4)).startswith(b"\x89PNG")
    assert (ROOT / "docs" / f"{name}.png").is_file()


def test_losses_of_the_weakest_motor(monkeypatch: pytest.MonkeyPatch) -> None:
    """The twins of lost drives run afterwards and alone, which is as good for what is counted."""
    monkeypatch.setattr(compare, "suite", suite)
    lost = {}
    for path in MOTORS.glob("*.toml"):
        motor = Motor.load(path.stem)
        made = Alone(motor, DriveDesign())
        lost[path.stem] = int(
            outcomes(make_policy("eq25", motor), [made], "stress", 1, 200).lost.sum()
        )
    assert len(lost) == 7 and not any(lost.values())
    motor = Motor.load("brusa_hsm1")
    s = score(
        make_policy("eq25", motor), SuiteRows("stress", motor, 5, 6000),
        SimFactory(motor, DriveDesign()),
    )  # fmt: skip
    n = int(np.sum((s.lost != 0) & are_feasible(s.lost)))
    few = f"{n} ({n / 60:.1g} %)" if n else "none"
    told = f"none on any of the seven motors. Of 6000 on `brusa_hsm1` it loses {few}"
    assert told in text(DOCS / "index.md")


@pytest.mark.usefixtures("all_draws")
def test_the_verdict_on_the_reference(monkeypatch: pytest.MonkeyPatch) -> None:
    """At its full size; other tests judge on a few scenarios."""
    monkeypatch.setattr(judge, "SIZE", 200)
    monkeypatch.setattr(compare, "SIZE", 400)
    monkeypatch.setattr(compare, "suite", suite)
    made = bench(["reference"])
    judged = judge.judge_export(made.policy("reference"), made.motor, made.design)
    assert judged.sentence in text(DOCS / "what-a-run-carries.md")
