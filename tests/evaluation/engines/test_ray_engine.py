"""Two nodes on loopback: the same bits as one process, also when a node dies at work."""

import os
import signal
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from sensorless.design.drive import DriveDesign
from sensorless.errors import UserError
from sensorless.evaluation.engines import ray_engine
from sensorless.evaluation.engines.code import code
from sensorless.evaluation.engines.engine import Chunk, Engine, Result
from sensorless.evaluation.engines.named import engine_named
from sensorless.evaluation.evaluate import evaluate, score
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policies
from sensorless.tuning import rule_search
from sensorless.tuning import tune as tuning
from tests.helpers.command import run
from tests.helpers.scenarios import lasting

MOTOR = Motor.load("paper")
DESIGN = DriveDesign()


@pytest.fixture(scope="module", autouse=True)
def surroundings() -> Iterator[None]:
    """What Ray's clusters find in the environment; Ray itself is required where CI=true."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RAY_AUTH_MODE", "token")
        patch.setenv("RAY_AUTH_TOKEN", "0123456789abcdef" * 4)
        patch.setenv("RAY_USAGE_STATS_ENABLED", "0")
        patch.setenv("RAY_IGNORE_UNHANDLED_ERRORS", "1")  # of chunks behind the first that fails
        for name in ("prestart_worker_first_driver", "enable_worker_prestart"):
            patch.setenv(f"RAY_{name}", "0")  # no worker that none of these tests needs
        if find_spec("ray") is None:
            if os.environ.get("CI") == "true":
                pytest.fail("CI needs ray: pip install -e '.[scale]'")
            pytest.skip("needs ray: pip install -e '.[scale]'")
        yield


@pytest.mark.usefixtures("all_draws")
def test_the_command_starts_a_cluster_of_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Before this process has another one, and without what would watch it."""
    from ray._private import parameter

    bare: dict[str, Any] = {"include_log_monitor": False, "no_monitor": True}
    monkeypatch.setattr(parameter, "RayParams", partial(parameter.RayParams, **bare))
    for engine in ("local", "ray"):
        words = (
            f"evaluate --policy eq25 --suite paper --size 6 --engine {engine} --out {engine}.json"
        )
        done = run(*words.split(), cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        assert done.stderr == f"evaluated eq25\nwrote {engine}.json\n"
    assert (tmp_path / "local.json").read_bytes() == (tmp_path / "ray.json").read_bytes()


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    """A node of one processor that others can be added to."""
    from ray.cluster_utils import Cluster

    quick = {"health_check_period_ms": 1000, "health_check_failure_threshold": 3}
    bare = {"include_dashboard": False, "include_log_monitor": False, "no_monitor": True}
    head = {"num_cpus": 1, "_system_config": quick, **bare}
    with ray_engine.own_signals():
        made = Cluster(initialize_head=True, head_node_args=head)
    yield made
    made.shutdown()


@pytest.fixture(scope="module")
def engine(cluster: Any) -> Iterator[Engine]:
    before = signal.getsignal(signal.SIGTERM)
    with engine_named("ray", cluster.address) as made:
        assert signal.getsignal(signal.SIGTERM) == before, "Ray took the program's signals"
        yield made


@dataclass(frozen=True)
class Watched:
    """An engine whose chunks take 0.5 s more; a folder says on which node they start."""

    engine: Engine
    folder: Path

    def map(self, function: Callable[[Chunk], Result], chunks: Iterable[Chunk]) -> Iterator[Result]:
        folder = self.folder

        def slow(numbered: tuple[int, Chunk]) -> Result:
            import ray

            node = ray.get_runtime_context().get_node_id()
            (folder / f"{numbered[0]}-{node}-{time.time_ns()}").touch()
            time.sleep(0.5)
            return function(numbered[1])

        return self.engine.map(slow, enumerate(chunks))

    def started(self, i: str, node: str) -> list[Path]:
        return list(self.folder.glob(f"{i}-{node}-*"))

    def busy(self, node: str) -> bool:
        """Whether a chunk began there in the last 0.1 s, so that it goes on for 0.4 s or more."""
        begun = [int(p.name.rsplit("-", 1)[1]) for p in self.started("*", node)]
        return any(time.time_ns() - at < 100_000_000 for at in begun)


def test_a_lost_node_costs_its_chunk_and_nothing_else(
    cluster: Any, engine: Engine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The file is the same to the byte, too."""
    monkeypatch.setattr("sensorless.evaluation.evaluate.score", partial(score, chunk=12))
    words = (MOTOR, DESIGN, "envelope", 7, 12**2, make_policies(["eq25"], MOTOR))
    evaluate(*words, out=tmp_path / "local.json")
    (tmp_path / "chunks").mkdir()
    watched = Watched(engine, tmp_path / "chunks")
    with ray_engine.own_signals():
        second = cluster.add_node(num_cpus=1)
    seen: list[float] = []

    def kill(_: str, done: float) -> None:
        seen.append(done)
        if len(seen) > 1:
            return
        deadline = time.monotonic() + 20.0
        while not watched.busy(second.node_id):
            assert time.monotonic() < deadline, "the second node got no work"
            time.sleep(0.005)
        cluster.remove_node(second, allow_graceful=False)

    evaluate(*words, out=tmp_path / "ray.json", engine=watched, progress=kill)
    assert len(seen) == 12 and seen == sorted(seen) and seen[-1] == 1.0
    assert (tmp_path / "local.json").read_bytes() == (tmp_path / "ray.json").read_bytes()
    again = [str(i) for i in range(12) if len(watched.started(str(i), "*")) > 1]
    assert 1 <= len(again) <= 2, again  # the one under way, and one whose result was on its way
    assert all(watched.started(i, second.node_id) for i in again)


def test_tuning_finds_the_same(engine: Engine, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rule_search, "suite", lasting(0.1))
    monkeypatch.setattr("sensorless.tuning.batch.DRIVES", 32)
    local = tuning.tune("linear", MOTOR, DESIGN, 60.0, 7)
    assert local.provenance["generations"] >= rule_search.CHECK
    assert tuning.tune("linear", MOTOR, DESIGN, 60.0, 7, engine=engine) == local


def test_errors_are_raised_as_they_were(engine: Engine) -> None:
    def fails(i: int) -> int:
        raise UserError(f"chunk {i}")

    with pytest.raises(UserError, match=r"^chunk 0$"):
        list(engine.map(fails, range(3)))


def test_other_code_is_refused(engine: Engine, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ray_engine, "code", lambda: {**code(), "core": "0" * 64})
    with pytest.raises(UserError, match=r"ray node .* has other code \(core .* instead of 000000"):
        list(engine.map(abs, [-1]))


def test_a_worker_that_dies_every_time_ends_the_work(cluster: Any, engine: Engine) -> None:
    import ray

    def dies(_: int) -> None:
        os._exit(1)

    with pytest.raises(UserError, match="lost a chunk after 1 retries"):
        list(ray_engine.RayEngine(ray, retries=1).map(dies, [1]))


@pytest.mark.parametrize("address", ["nonsense", "127.0.0.1:1", ":1", "127.0.0.1:x"])
def test_no_cluster_there(cluster: Any, address: str) -> None:
    with pytest.raises(UserError, match="ray-address"), engine_named("ray", address):
        pytest.fail("entered")


def test_a_cluster_of_ours_is_for_us_alone(cluster: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ray's servers bind to loopback alone if that is their node's address."""
    from ray._private import services

    own = services.get_node_ip_address
    with ray_engine.on_loopback():
        assert services.resolve_ip_for_localhost("localhost") == "127.0.0.1"
    assert services.get_node_ip_address is own
    for name in ("RAY_AUTH_MODE", "RAY_AUTH_TOKEN"):
        monkeypatch.setenv(name, "")
        monkeypatch.delenv(name)
    ray_engine.require_token()
    assert os.environ["RAY_AUTH_MODE"] == "token" and len(os.environ["RAY_AUTH_TOKEN"]) == 64
    monkeypatch.setenv("RAY_AUTH_TOKEN", "mine")
    ray_engine.require_token()
    assert os.environ["RAY_AUTH_TOKEN"] == "mine"
