"""Runs chunks as tasks of a Ray cluster.

Ray restarts a task when its worker or its node is lost. Results are compressed: below 100 KiB they
go to the driver at once, while larger ones stay on their node and can be lost with it. Every task
first compares the code of its worker with that of the driver, because another version could give
other bits.
"""

import logging
import os
import pickle
import secrets
import signal
import socket
import zlib
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from itertools import islice
from types import ModuleType
from typing import TYPE_CHECKING, Any

from sensorless.errors import UserError
from sensorless.evaluation.engines.code import code
from sensorless.evaluation.engines.engine import Chunk, Result

if TYPE_CHECKING:
    from ray import ObjectRef

RETRIES = 8
"""How often a chunk is run again after its worker or node was lost."""

WINDOW_PER_CPU = 3
"""Chunks per processor that may be running, or finished and waiting for their turn."""

REACH_TIME = 10.0
"""Time that a cluster has to accept a connection [s]."""

LOOPBACK = "127.0.0.1"
"""Where a cluster on this computer listens."""

STORE = 256 * 2**20
"""Object store of a cluster on this computer [bytes]; a compressed result has some 100 KiB."""


class RayEngine:
    """Tasks of the cluster that this process is connected to."""

    def __init__(self, ray: ModuleType, retries: int = RETRIES) -> None:
        self._ray, self._retries = ray, retries
        self._task = ray.remote(max_retries=retries)(_task())
        self._window = WINDOW_PER_CPU * max(4, int(ray.cluster_resources().get("CPU", 0)))

    def map(self, function: Callable[[Chunk], Result], chunks: Iterable[Chunk]) -> Iterator[Result]:
        """Yield results in order, each as soon as it and all before it are ready.

        After an error or Ctrl-C running chunks are not cancelled: Ray 2.60 can abort the process
        when it cancels a task that is just ending. They end by themselves, or with the job.
        """
        ray = self._ray
        work = ray.put(ray.cloudpickle.dumps(function))
        waiting = iter(chunks)
        window: deque[ObjectRef[Any]] = deque()
        while True:
            for chunk in islice(waiting, self._window - len(window)):
                window.append(self._task.remote(code(), work, ray.cloudpickle.dumps(chunk)))
            if not window:
                return
            yield self._result(window[0])
            window.popleft()

    def _result(self, ref: "ObjectRef[Any]") -> Any:
        """Result of a task; errors of its function are raised here as they were there."""
        try:
            refusal, packed = self._ray.get(ref)
        except self._ray.exceptions.RayTaskError as error:
            raise error.cause from None
        except self._ray.exceptions.RayError as error:
            raise UserError(
                f"engine: ray lost a chunk after {self._retries} retries: {_line(error)}; check "
                "the cluster, or use --engine local"
            ) from None
        if refusal is not None:
            raise UserError(f"engine: {refusal}; install the same version on every node")
        return pickle.loads(zlib.decompress(packed))


def _task() -> Callable[[dict[str, str], bytes, bytes], tuple[str | None, bytes]]:
    """Return what a worker runs; a local function travels as code, even to workers without us."""

    def run(wanted: dict[str, str], function: bytes, chunk: bytes) -> tuple[str | None, bytes]:
        import os

        import ray

        os.environ.setdefault("SENSORLESS_THREADS", "1")  # Ray reserves one processor per task
        node = f"ray node {ray.util.get_node_ip_address()}"
        try:
            from sensorless.evaluation.engines.code import code, difference
        except ImportError as error:
            return f"{node} cannot use the package sensorless ({error})", b""
        found = difference(wanted, code())
        if found:
            return f"{node} has other code ({found})", b""
        result = pickle.loads(function)(pickle.loads(chunk))
        return None, zlib.compress(pickle.dumps(result), level=1)

    return run


@contextmanager
def ray_engine(address: str | None) -> Iterator[RayEngine]:
    """Engine on a running cluster, or on one started on this computer that ends with the block.

    Raises
    ------
    UserError
        Ray is not installed, or the cluster cannot be reached, started or entered.
    """
    if address is None:
        require_token()
    try:
        import ray
    except ImportError:
        raise UserError(
            "engine: ray is not installed; run: pip install 'sensorless[scale]'"
        ) from None
    if address is not None:
        _check_reachable(address)
    logging.getLogger("ray").setLevel(logging.ERROR)
    options: dict[str, Any] = {"log_to_driver": False, "configure_logging": False}
    if address is None:
        options |= {"include_dashboard": False, "object_store_memory": STORE}
        options |= {"_node_ip_address": LOOPBACK}
    try:
        with own_signals(), on_loopback() if address is None else nullcontext():
            ray.init(address=address or "local", **options)
    except (ConnectionError, OSError, RuntimeError, ValueError, ray.exceptions.RayError) as error:
        where = "local" if address is None else repr(address)
        raise UserError(
            f"ray-address: {where}: {_line(error)}; give HOST:PORT of a running cluster with the "
            "same Ray and Python, and set its RAY_AUTH_MODE and RAY_AUTH_TOKEN"
        ) from None
    try:
        yield RayEngine(ray)
    finally:
        ray.shutdown()


@contextmanager
def own_signals() -> Iterator[None]:
    """Keep the program's answer to SIGTERM: Ray's would end with another status, work unsaved."""
    before = signal.getsignal(signal.SIGTERM)
    try:
        yield
    finally:
        with suppress(ValueError):  # not the main thread: Ray could not set its own either
            signal.signal(signal.SIGTERM, before)


@contextmanager
def on_loopback() -> Iterator[None]:
    """Let Ray listen on loopback alone; by itself it takes 127.0.0.1 for the network's address."""
    from ray._private import services

    own = services.get_node_ip_address
    vars(services)["get_node_ip_address"] = lambda *_, **__: LOOPBACK
    try:
        yield
    finally:
        vars(services)["get_node_ip_address"] = own


def require_token() -> None:
    """Let a cluster of ours ask for a token, which its processes inherit and nobody else has.

    It stays for the life of this process, because Ray reads it once. A mode or a token of the user
    is left alone.
    """
    if os.environ.setdefault("RAY_AUTH_MODE", "token") == "token":
        os.environ.setdefault("RAY_AUTH_TOKEN", secrets.token_hex(32))


def _check_reachable(address: str) -> None:
    """Check that something listens at HOST:PORT; Ray itself would try for ten minutes."""
    host, _, port = address.rpartition(":")
    if not host or not port.isdecimal() or int(port) > 65535:
        raise UserError(f"ray-address: {address!r}; give HOST:PORT of a running cluster")
    try:
        socket.create_connection((host, int(port)), timeout=REACH_TIME).close()
    except OSError as error:
        raise UserError(
            f"ray-address: {address!r}: {error}; give HOST:PORT of a running cluster"
        ) from None


def _line(error: Exception) -> str:
    """First line of a message."""
    return next(iter(str(error).strip().splitlines()), type(error).__name__)
