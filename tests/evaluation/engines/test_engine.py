"""Engines by name, work in order, and how code is told apart."""

import pickle
import sys
from collections.abc import Iterator

import numpy as np
import pytest

from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.errors import UserError
from sensorless.evaluation.engines.code import arithmetic, code, difference
from sensorless.evaluation.engines.engine import LOCAL
from sensorless.evaluation.engines.named import engine_named
from sensorless.machine.motor import Motor
from sensorless.policies.registry import RULES, make_policy

MOTOR = Motor.load("paper")


def test_local_work_is_done_in_order_and_only_when_asked_for() -> None:
    taken = []

    def chunks() -> Iterator[int]:
        for i in range(5):
            taken.append(i)
            yield i

    with engine_named("local") as engine:
        results = engine.map(lambda i: i * i, chunks())
        assert next(results) == 0 and taken == [0]
        assert list(results) == [1, 4, 9, 16]
    assert engine is LOCAL


@pytest.mark.parametrize(
    ("name", "address", "said"),
    [
        ("slurm", None, "engine: 'slurm' does not exist; choose from local, ray"),
        ("local", "127.0.0.1:6379", "ray-address"),
    ],
)
def test_bad_names(name: str, address: str | None, said: str) -> None:
    with pytest.raises(UserError, match=said), engine_named(name, address):
        pytest.fail("entered")


def test_without_ray_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(UserError, match=r"sensorless\[scale\]"), engine_named("ray"):
        pytest.fail("entered")


@pytest.mark.parametrize("rule", RULES)
def test_every_rule_can_travel(rule: str) -> None:
    specs = {"constant": "constant:0.5"}
    policy = make_policy(specs.get(rule, rule), MOTOR)
    factory = SimFactory(MOTOR, DriveDesign())
    there, built = pickle.loads(pickle.dumps((policy, factory)))
    assert there.name == policy.name
    assert built.design == factory.design
    assert built.template.tobytes() == factory.template.tobytes()


def test_code_names_what_bits_depend_on() -> None:
    here = code()
    assert {"sensorless", "core", "sources", "arithmetic", "numpy", "scipy"} == set(here)
    assert len(here["sources"]) == len(here["arithmetic"]) == 64
    assert difference(here, dict(here)) == ""
    assert difference(here, {**here, "core": "f" * 64}).startswith("core ffffffffffff instead of ")
    assert "scipy none" in difference(here, {k: v for k, v in here.items() if k != "scipy"})


def test_another_arithmetic_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    exact, exp = arithmetic(), np.exp
    monkeypatch.setattr("numpy.exp", lambda x: np.nextafter(exp(x), np.inf))
    assert arithmetic() != exact
