"""What the tests of the core share: its inline stages as functions, and NumPy references."""

import ctypes
import math
import os
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sensorless.core.api import SIGNAL_N, Array, sim_run
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Motor, Saturation

Call = Callable[..., None]

CORE = Path(__file__).parents[2] / "core"
FLAGS = ("-std=c99", "-O1", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math")
QUICK = "-DCORE_INLINE=static inline"
"""Not all of it inlined, which takes the compiler half as long again."""


@pytest.fixture(scope="session")
def c(tmp_path_factory: pytest.TempPathFactory) -> Call:
    """Function of ``shim.c`` by name: arrays go as pointers, floats as float, integers as int."""
    out = tmp_path_factory.mktemp("shim") / "shim.so"
    sources = [
        str(Path(__file__).with_name("shim.c")),
        str(CORE / "sim" / "carrier.c"),
        str(CORE / "sim" / "batch.c"),
        str(CORE / "sim" / "simd.c"),
        str(CORE / "sim" / "flux_correction.c"),
    ]
    compiler = os.environ.get("CC", "cc").split()
    subprocess.run(
        [
            *compiler,
            *FLAGS,
            QUICK,
            "-shared",
            "-fPIC",
            f"-I{CORE}",
            f"-I{CORE}/sim",
            *sources,
            "-o",
            str(out),
        ],
        check=True,
    )
    lib = ctypes.CDLL(str(out))

    made: dict[tuple[str, tuple[type, ...]], Any] = {}
    places: dict[int, tuple[Any, int]] = {}

    def place(array: Any) -> int:
        """Address of an array, which many calls in a row name again."""
        known = places.get(id(array))
        if known is None:
            if len(places) > 1000:
                places.clear()
            known = places[id(array)] = array, array.ctypes.data
        return known[1]

    def kind(of: type) -> Any:
        if issubclass(of, np.ndarray | ctypes.c_void_p):
            return ctypes.c_void_p
        return ctypes.c_int if issubclass(of, int) else ctypes.c_float

    def call(name: str, *args: Any) -> None:
        """The same function with other types of arguments is loaded again."""
        key = name, tuple(map(type, args))
        function = made.get(key)
        if function is None:
            function = made[key] = lib[f"t_{name}"]
            function.argtypes = [kind(of) for of in key[1]]
        function(*[place(x) if type(x) is np.ndarray else x for x in args])

    return call


@pytest.fixture(scope="session")
def map_currents() -> Callable[[Saturation, Floats], Floats]:
    """The flux map in NumPy, from the equations in ``flux_map.h``."""

    def currents(s: Saturation, psi: Floats) -> Floats:
        d, q = psi[..., 0], psi[..., 1]
        a_d, a_q = np.abs(d), np.abs(q)
        cross_d = s.a_dq / (s.V + 2) * a_d**s.U * a_q ** (s.V + 2)
        cross_q = s.a_dq / (s.U + 2) * a_d ** (s.U + 2) * a_q**s.V
        i_d = (s.a_d0 + s.a_dd * a_d**s.S + cross_d) * d - s.i_f
        i_q = (s.a_q0 + s.a_qq * a_q**s.T + cross_q) * q
        n = d - s.psi_n
        bridge = np.sqrt(n**2 + s.k_q * q**2) ** s.W
        g = s.a_b * bridge / (1.0 + s.a_bp * bridge)
        return np.stack([i_d + g * n, i_q + s.k_q * g * q], axis=-1)

    return currents


@pytest.fixture(scope="session")
def state_bytes() -> Callable[[Array], bytes]:
    """All numbers of a structured array, field by field: padding has no say."""

    def collect(records: Array) -> bytes:
        if records.dtype.names is None:
            return records.tobytes()
        return b"".join(collect(records[name]) for name in records.dtype.names)

    return collect


@pytest.fixture(scope="session")
def steady_angle(motor: Motor) -> Callable[[DriveDesign, float, float, float], float]:
    """Truth minus estimate [deg] of a closed loop with design, k_s, speed [r/min] and torque [N m].

    Sensors and inverter are ideal; what is left are the errors of the estimators themselves.
    """

    def settle(design: DriveDesign, k_s: float, rpm: float, tau: float) -> float:
        s = Scenarios.nominal(motor, np.array([1], dtype=np.uint64), 3.0)
        s.omega_0[:] = rpm * math.pi / 30.0
        s.omega[:] = s.omega_0[:, None]
        s.tau[:], s.tau_rate[:] = tau - motor.B * s.omega_0[0], 20.0
        s.noise[:], s.dead_time[:] = 0.0, 0.0
        sims = SimFactory(motor, design).build(s, twin=False)
        sims["sensor"]["lsb"], sims["sensor"]["inv_lsb"] = 1e-6, 1e6
        sims["control"]["control"]["u_dt"] = 0.0
        weight, obs = np.full(1, k_s, np.float32), np.empty((1, SIGNAL_N), np.float32)
        sim_run(sims, round(2.5 / motor.T_s), weight, obs)
        sim_run(sims, round(0.4 / motor.T_s), weight, obs)
        assert sims["lost"][0] == 0
        return math.degrees(float(sims["sums"]["err"][0] / sims["sums"]["n"][0]))

    return settle
