"""What the page starts from: records of every machine and estimator, tables, and their layout.

The records are those that the native core runs on, byte for byte: the page computes no parameter.
"""

import json
from functools import lru_cache
from typing import Any

import numpy as np

from sensorless.core.api import SIGNAL_NAMES, SIM, TABLE, TRACE_NAMES, Array, enumeration, ffi, lib
from sensorless.decision import decision_periods
from sensorless.design.drive import ESTIMATORS, DriveDesign
from sensorless.envs.counter_random import combine
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.machine.motor import Motor
from sensorless.observers.start_design import knows_poles
from sensorless.settings import settings_of
from sensorless.table.axis import MAX_NODES
from sensorless.table.image import PROBLEMS
from sensorless.units import RPM_TO_RAD_S
from web.fields import FIELDS, TABLE_FIELDS, offsets, response
from web.rules import MOTORS, Named, rules, without_table
from web.words import ESTIMATORS as WORDS
from web.words import FAULTS, LOST, PHASES

ALIGN = 8
SEEDS = 100
"""Noises that the page offers, those of ``sensorless simulate --seed``."""
LEVERS = {"R_s": "resistance", "psi_f": "magnet", "J": "inertia"}
"""Fields of ``Scenarios`` that scale parameters of the plant, and their names on the page."""


class Image:
    """Bytes one after the other, each piece at a multiple of ``ALIGN``."""

    def __init__(self) -> None:
        self.data = bytearray()

    def add(self, array: Array) -> int:
        """Append an array; return where it starts."""
        self.data.extend(bytes(-len(self.data) % ALIGN))
        at = len(self.data)
        self.data.extend(np.ascontiguousarray(array).tobytes())
        return at


def scenario(motor: Motor, **changed: float) -> Scenarios:
    """Standstill without load, as ``sensorless simulate`` starts, seed 0; a field may differ."""
    s = Scenarios.nominal(motor, combine(0, np.arange(1)), 1.0)
    for name, value in changed.items():
        getattr(s, name)[:] = value
    return s


def _noise(seed: int) -> np.uint32:
    """Seed of a drive's sensors for a seed of the command line."""
    return np.uint32(combine(seed, np.arange(1))[0] & np.uint64(0xFFFFFFFF))


def template(motor: Motor, estimator: str, **changed: float) -> Array:
    """Record of ``SIM``, shape (1,), that the page copies for a drive; it has no end."""
    sim = SimFactory(motor, DriveDesign(estimator=estimator)).build(scenario(motor, **changed))
    sim["k_end"] = np.iinfo(np.int32).max
    return sim


def _levers(motor: Motor, base: Array) -> dict[str, list[tuple[int, str, str]]]:
    """What each lever scales, found by doubling it."""
    doubled = {name: template(motor, "coupled", **{field: 2.0}) for field, name in LEVERS.items()}
    return {name: response(base[0], sim[0]) for name, sim in doubled.items()}


def _table(named: Named, image: Image) -> dict[str, Any]:
    table = named.policy.table
    return {
        "at": image.add(table.record().reshape(1)),
        "values": image.add(table.stored()),
        "axes": [
            {"signal": axis.signal, "lo": axis.lo, "hi": axis.hi, "n": axis.n}
            for axis in table.axes
        ],
    }


def _motor(motor: Motor, image: Image) -> dict[str, Any]:
    sims = {name: template(motor, name) for name in ESTIMATORS}
    return {
        "name": motor.name,
        "text": motor.description,
        "rpm": motor.n_rated_rpm,
        "tau": motor.tau_rated,
        "u_dc": motor.u_dc,
        "n_p": motor.n_p,
        "T_s": motor.T_s,
        "i_rated": motor.i_rated,
        "periods": decision_periods(motor),
        "seeks": knows_poles(motor),
        "levers": _levers(motor, sims["coupled"]),
        "sims": {name: image.add(sim) for name, sim in sims.items()},
        "rules": [
            {
                "word": named.word,
                "text": named.text,
                "estimator": named.policy.settings.get("estimator"),
                **_table(named, image),
            }
            for named in rules(motor)
        ],
    }


@lru_cache(maxsize=1)
def image() -> tuple[bytes, str]:
    """Return the initial memory, and the layout that explains it as JSON."""
    made = Image()
    words = settings_of(DriveDesign)["estimator"].choices
    layout = {
        "core": ffi.string(lib.core_hash).decode(),
        "rpm": RPM_TO_RAD_S,
        "sizes": {"sim": SIM.itemsize, "table": TABLE.itemsize},
        "fields": offsets(SIM, FIELDS),
        "table_fields": offsets(TABLE, TABLE_FIELDS),
        "most_nodes": MAX_NODES,
        "trace": list(TRACE_NAMES),
        "signals": list(SIGNAL_NAMES),
        "rows": max(decision_periods(motor) for motor in map(Motor.load, MOTORS)),
        "seeds": [int(_noise(seed)) for seed in range(SEEDS)],
        "lost": _bits("LOST_", LOST),
        "faults": _bits("FAULT_", FAULTS),
        "phases": _texts("START_", PHASES),
        "refusals": {"0": "accepted", **{str(k): text for k, text in PROBLEMS.items()}},
        "estimators": {**WORDS, **{k: v for k, v in words.items() if k not in WORDS}},
        "untabled": without_table(Motor.load(MOTORS[0])),
        "motors": [_motor(motor, made) for motor in map(Motor.load, MOTORS)],
    }
    return bytes(made.data), json.dumps(layout, separators=(",", ":"))


def _texts(prefix: str, words: dict[str, str]) -> dict[str, str]:
    """Text of each number of an enumeration; its own name where ``words`` has none."""
    found = enumeration(prefix)
    return {str(n): words.get(name, name.replace("_", " ")) for name, n in found.items()}


def _bits(prefix: str, words: dict[str, str]) -> dict[str, str]:
    """The same of single bits: masks of several are left out."""
    return {n: text for n, text in _texts(prefix, words).items() if int(n).bit_count() == 1}
