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
from sensorless.evaluation.engines.named import engine_named
from sensorless.evaluation.engines.threads import LOCAL
from sensorless.machine.motor import Motor
from sensorless.policies.registry import RULES, make_policy

MOTOR = Motor.load("paper")


@pytest.mark.parametrize(("threads", "ahead"), [(1, 1), (2, 4)])
def test_local_work_is_done_in_order_and_not_long_before_it_is_asked_for(
    monkeypatch: pytest.MonkeyPatch, threads: int, ahead: int
) -> None:
    monkeypatch.setenv("SENSORLESS_THREADS", str(threads))
    taken = []

    def chunks() -> Iterator[int]:
        for i in range(9):
            taken.append(i)
            yield i

    with engine_named("local") as engine:
        results = engine.map(lambda i: i * i, chunks())
        assert next(results) == 0 and taken == list(range(ahead))
        assert list(results) == [i * i for i in range(1, 9)]
    assert engine is LOCAL


class Counting:
    """Counts its calls; ``kept`` is something that it keeps."""

    def __init__(self, kept: object) -> None:
        self.calls, self.kept = 0, kept

    def __call__(self, _: int) -> int:
        """Calls so far."""
        self.calls += 1
        return self.calls


@pytest.mark.parametrize("threads", ["1", "2"])
def test_every_chunk_gets_a_function_of_its_own(
    monkeypatch: pytest.MonkeyPatch, threads: str
) -> None:
    monkeypatch.setenv("SENSORLESS_THREADS", threads)
    fresh = Counting(None)
    assert list(LOCAL.map(fresh, range(6))) == [1] * 6
    assert fresh.calls == 0


def test_what_cannot_be_copied_computes_one_by_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SENSORLESS_THREADS", "2")
    with open(__file__, encoding="utf-8") as file:
        assert list(LOCAL.map(Counting(file), range(6))) == [1, 2, 3, 4, 5, 6]
        counting = Counting(file)
        assert list(LOCAL.map(lambda own: own(0), [counting] * 6)) == [1, 2, 3, 4, 5, 6]
    assert list(LOCAL.map(Counting(None), [])) == []


def test_a_chunk_that_fails_ends_the_work(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SENSORLESS_THREADS", "2")
    results = LOCAL.map(lambda i: 1 // (i - 1), range(100))
    assert next(results) == -1
    with pytest.raises(ZeroDivisionError):
        next(results)


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
