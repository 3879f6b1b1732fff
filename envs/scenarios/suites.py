"""Named sets of scenarios, each a function of name, seed and size alone.

A scenario is a function of these and of its own index, so any part of a set can be drawn anywhere.
"""

import dataclasses
from collections.abc import Callable
from itertools import product

import numpy as np
from numpy.typing import NDArray

from sensorless.envs.counter_random import Floats, Seeds, combine
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.envs.scenarios.starts import starts_scenarios
from sensorless.envs.scenarios.stress import stress_scenarios
from sensorless.errors import UserError
from sensorless.machine.motor import Motor
from sensorless.units import RPM_TO_RAD_S

ROLES = {"train": 1, "tune": 2, "test": 3}
"""Seeds of training, tuning and judging never meet."""


Indices = NDArray[np.int64]


@dataclasses.dataclass(frozen=True)
class SuiteRows:
    """Scenarios of a suite that are not drawn yet: a few numbers, however many there are.

    Parameters
    ----------
    name : str
        One of ``SUITES``.
    motor : Motor
    suite_seed : int
        0 to 2^63 - 1; another seed draws other scenarios.
    size : int
        Number of scenarios in the suite; for ``envelope``, a grid, a square number.
    role : str
        ``train``, ``tune`` or ``test``: keeps the three apart whatever the seeds.
    rows : range, optional
        Indices of the scenarios; default: all.

    Raises
    ------
    UserError
        Unknown suite or role, or a seed or size out of range.
    """

    name: str
    motor: Motor
    suite_seed: int
    size: int
    role: str = "test"
    rows: range | None = None

    def __post_init__(self) -> None:
        name, seed, size = self.name, self.suite_seed, self.size
        if name not in SUITES:
            raise UserError(f"suite: {name!r}; allowed: {', '.join(SUITES)}")
        if self.role not in ROLES:
            raise UserError(f"role: {self.role!r}; allowed: {', '.join(ROLES)}")
        if not 0 <= seed < 2**63:
            raise UserError(f"seed: {seed}; allowed: 0 to 2^63 - 1")
        if not 1 <= size <= 10_000_000:
            raise UserError(f"size: {size}; allowed: 1 to 10000000")
        if name == "envelope" and (size < 4 or int(np.sqrt(size)) ** 2 != size):
            raise UserError(f"size: {size}; allowed for envelope: a square number of at least 4")

    def __len__(self) -> int:
        """Return the number of scenarios."""
        return len(self._range)

    def __getitem__(self, rows: slice) -> "SuiteRows":
        """Some of them."""
        return dataclasses.replace(self, rows=self._range[rows])

    @property
    def _range(self) -> range:
        return range(self.size) if self.rows is None else self.rows

    @property
    def seed(self) -> Seeds:
        """(n,) seeds of the scenarios."""
        return combine(ROLES[self.role], self.suite_seed, np.asarray(self._range))

    def draw(self) -> Scenarios:
        """Scenarios themselves."""
        return SUITES[self.name](self.motor, self.seed, np.asarray(self._range), self.size)


def nominal_scenarios(motor: Motor, seeds: Seeds, *_: object) -> Scenarios:
    """The profiles of ``stress`` on a drive that knows its machine and has good sensors."""
    s = stress_scenarios(motor, seeds)
    exact = Scenarios.nominal(motor, seeds, 1.0)
    for name in (
        "R_s",
        "L_q_hat",
        "psi_f",
        "J",
        "cross_hat",
        "dead_time",
        "noise",
        "gain",
        "offset",
    ):
        setattr(s, name, getattr(exact, name))
    s.u_dc[:] = 1.0
    return s


def paper_scenarios(motor: Motor, seeds: Seeds, indices: Indices, _: int) -> Scenarios:
    """Figs. 9, 13/14 and 11 of doi 10.12177/emca.2025.011 in turn, speeds relative to 1500 r/min.

    Fig. 9: 200, 350, 600 r/min in steps without load. Figs. 13/14: 150, 350, 650 and back on ramps
    of 600 r/min/s. Fig. 11: 150 r/min, 6 N m (43 % of rated torque).
    """
    s = Scenarios.nominal(motor, seeds, 4.0)
    base = motor.n_rated_rpm / 1500.0 * RPM_TO_RAD_S
    kind = indices % 3
    steps = kind == 0
    _plan(s, steps, [(0.0, 200), (1.0, 350), (2.0, 600)], base)
    _plan(s, kind == 1, [(0.0, 150), (0.8, 350), (1.6, 650), (2.4, 350), (3.2, 150)], base)
    _plan(s, kind == 2, [(0.0, 150)], base)
    s.omega_rate[~steps] = 600.0 * base
    s.duration[steps] = 3.0
    s.tau[kind == 2, 1:] = 6.0 / 14.0 * motor.tau_rated
    s.t[kind == 2, 1] = 1.0
    s.tau_rate[:] = motor.tau_rated / 0.1
    return s


def _plan(s: Scenarios, rows: Floats, plan: list[tuple[float, float]], base: float) -> None:
    """Speed targets (start [s], r/min of a 1500 r/min machine) for the given rows."""
    for j, (start, rpm) in enumerate(plan):
        s.t[rows, j] = start
        s.omega[rows, j:] = rpm * base


def handoff_scenarios(motor: Motor, seeds: Seeds, indices: Indices, _: int) -> Scenarios:
    """Crossings of the hand-over band, one family after the other; noise differs by seed.

    Up, dwell at the band's centre with a load step, and down again at three ramps, motoring and
    regenerating 0 to 100 %; reversals through zero; load steps at standstill; fast decelerations.
    """
    s = Scenarios.nominal(motor, seeds, 3.0)
    base = motor.n_rated_rpm * RPM_TO_RAD_S
    crossings = list(product((200.0, 600.0, 1200.0), (-1.0, -0.5, 0.0, 0.5, 1.0), (1.0, -1.0)))
    reversals = list(product((300.0, 900.0), (-0.5, 0.0, 0.5), (1.0, -1.0)))
    holds = list(product((0.5, 1.0), (1.0, -1.0)))
    stops = list(product((-0.5, 0.0, 0.5), (1.0, -1.0)))
    n_kinds = len(crossings) + len(reversals) + len(holds) + len(stops)
    for i, index in enumerate(indices.tolist()):
        j = index % n_kinds
        if j < len(crossings):
            ramp, load, way = crossings[j]
            _cross(
                s,
                i,
                ramp * RPM_TO_RAD_S * motor.n_rated_rpm / 1500.0,
                load * motor.tau_rated,
                way * base,
            )
            continue
        j -= len(crossings)
        if j < len(reversals):
            ramp, load, way = reversals[j]
            _segments(
                s,
                i,
                [(0.0, 0.4 * way, 0.0), (0.6, 0.4 * way, load), (1.0, -0.4 * way, load)],
                base,
                motor.tau_rated,
                ramp * RPM_TO_RAD_S * motor.n_rated_rpm / 1500.0,
            )
            s.omega_0[i] = 0.4 * way * base
            continue
        j -= len(reversals)
        if j < len(holds):
            load, way = holds[j]
            _segments(
                s,
                i,
                [(0.0, 0.0, 0.0), (0.3, 0.0, way * load), (1.5, 0.0, -way * load)],
                base,
                motor.tau_rated,
                base,
            )
            continue
        load, way = stops[j - len(holds)]
        _segments(
            s,
            i,
            [(0.0, 0.5 * way, 0.0), (0.3, 0.5 * way, load), (1.0, 0.0, load)],
            base,
            motor.tau_rated,
            2.0 * base,
        )
        s.omega_0[i] = 0.5 * way * base
    s.tau_rate[:] = motor.tau_rated / 0.05
    return s


def _segments(
    s: Scenarios,
    i: int,
    plan: list[tuple[float, float, float]],
    base: float,
    tau: float,
    rate: float,
) -> None:
    """Segments (start [s], speed / base, load / tau) for row i."""
    for j, (start, speed, load) in enumerate(plan):
        s.t[i, j] = start
        s.omega[i, j:] = speed * base
        s.tau[i, j:] = load * tau
    s.omega_rate[i] = rate


def _cross(s: Scenarios, i: int, ramp: float, load: float, base: float) -> None:
    """From 10 % of rated speed to the band's centre, a dwell and a load step, 40 %, and back."""
    low, centre, high = 0.1 * base, 7.0 / 30.0 * base, 0.4 * base
    signed = load * np.sign(base)
    up, down = abs(centre - low) / ramp, abs(high - low) / ramp
    plan = [
        (0.0, low, 0.0),
        (0.2, low, signed),
        (0.4, centre, signed),
        (0.4 + up + 0.15, centre, 0.5 * signed),
        (0.4 + up + 0.30, high, signed),
        (0.4 + 2.0 * up + 0.6, low, signed),
    ]
    for j, (start, speed, tau) in enumerate(plan):
        s.t[i, j] = start
        s.omega[i, j:] = speed
        s.tau[i, j:] = tau
    s.omega_0[i] = low
    s.omega_rate[i] = ramp
    s.duration[i] = 0.4 + 2.0 * up + 0.6 + down + 0.3


def envelope_scenarios(motor: Motor, seeds: Seeds, indices: Indices, size: int) -> Scenarios:
    """A square grid of speed (rows) and load (columns) from -100 to 100 %, in row-major order.

    The drive starts at its speed, then the load rises within 0.2 s and stays for 0.6 s.
    """
    side = int(np.sqrt(size))
    grid = np.linspace(-1.0, 1.0, side)
    speed, load = grid[indices // side], grid[indices % side]
    s = Scenarios.nominal(motor, seeds, 1.0)
    omega = speed * motor.omega_rated / motor.n_p
    s.omega_0[:] = omega
    s.omega[:] = omega[:, None]
    s.t[:, 1] = 0.2
    s.tau[:, 1:] = load[:, None] * motor.tau_rated
    s.tau_rate[:] = motor.tau_rated / 0.2
    return s


def motors_scenarios(motor: Motor, seeds: Seeds, indices: Indices, size: int) -> Scenarios:
    """``handoff`` (even rows) and ``stress`` (odd rows), for machines that training never saw.

    All of a scenario is relative to the machine's own numbers: run it once for each of the shipped
    machines but the one that was trained on.
    """
    s = stress_scenarios(motor, seeds)
    even = indices % 2 == 0
    crossings = handoff_scenarios(motor, seeds[even], indices[even] // 2, size)
    for f in dataclasses.fields(s):
        rows = np.array(getattr(s, f.name))
        rows[even] = getattr(crossings, f.name)
        setattr(s, f.name, rows)
    return s


SUITES: dict[str, Callable[[Motor, Seeds, Indices, int], Scenarios]] = {
    "paper": paper_scenarios,
    "nominal": nominal_scenarios,
    "handoff": handoff_scenarios,
    "stress": lambda motor, seeds, *_: stress_scenarios(motor, seeds),
    "envelope": envelope_scenarios,
    "motors": motors_scenarios,
    "starts": starts_scenarios,
}
"""From motor, seeds (n,), indices (n,) and the suite's size to n scenarios."""


def suite(name: str, motor: Motor, seed: int, size: int, role: str = "test") -> Scenarios:
    """All scenarios of a suite; arguments and errors as in ``SuiteRows``."""
    return SuiteRows(name, motor, seed, size, role).draw()


def scenario_word(name: str, seed: int, index: int, size: int) -> str:
    """SUITE:SEED:INDEX[:SIZE], which names one scenario of a suite for ``sensorless simulate``.

    The size is there only where a scenario depends on it: in the grid of ``envelope``.
    """
    return f"{name}:{seed}:{index}" + (f":{size}" if name == "envelope" else "")
