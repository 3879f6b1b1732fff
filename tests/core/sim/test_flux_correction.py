"""A flux map's correction: its currents against SciPy's splines, its energy, where it is known."""

import dataclasses
import pickle
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import simpson
from scipy.interpolate import BSpline

from sensorless.core.api import PLANT_STATE, SIGNAL_N, Array, lib, pointer, sim_run
from sensorless.core.machine import flux_correction_currents, flux_map_currents, plant_run
from sensorless.design.drive import DriveDesign
from sensorless.design.records import plant_record
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.envs.scenarios.stress import stress_1_scenarios
from sensorless.machine.flux_correction import FluxCorrection
from sensorless.machine.magnetics import Floats, flux, plant_currents, plant_map, slopes
from sensorless.machine.motor import Motor, Saturation
from tests.helpers.machines import measured_machine, rough_correction, rough_machine

PIECES = 400
NODES, PARTS = np.polynomial.legendre.leggauss(4)
PLACES = ((np.arange(PIECES)[:, None] + 0.5 + 0.5 * NODES) / PIECES).ravel()
WEIGHTS = np.tile(0.5 * PARTS / PIECES, PIECES)
"""Integral from 0 to 1 in pieces, as splines are smooth in pieces only."""

Map = Callable[[Saturation, Floats], Floats]
Bytes = Callable[[Array], bytes]

GRID = FluxCorrection(
    -0.4, 1.1, 0.9, tuple(map(tuple, np.random.default_rng(5).standard_normal((12, 8)).tolist()))
)


def by_scipy(f: FluxCorrection, psi: Floats) -> Floats:
    """Currents (n, 2) from SciPy's splines, whose images below psi_q = 0 are coefficients."""
    c = np.array(f.energy)
    n_d, n_q = c.shape
    h_d, h_q = (f.psi_d_to - f.psi_d_from) / (n_d + 3), f.psi_q_to / (n_q + 1)
    both = np.pad(np.concatenate([c[:, :0:-1], c], axis=1), 3)  # zeros: SciPy's end conditions
    knots_d = f.psi_d_from + h_d * (np.arange(n_d + 10) - 3.0)
    knots_q = h_q * (np.arange(2 * n_q + 9) - n_q - 4.0)

    def splines(x: Floats, knots: Floats, slope: int) -> Floats:
        eye = np.eye(len(knots) - 4)
        return np.asarray(np.nan_to_num(BSpline(knots, eye, 3, extrapolate=False)(x, nu=slope)))

    d, q = psi.T
    i_d = np.einsum("nj,jm,nm->n", splines(d, knots_d, 1), both, splines(q, knots_q, 0))
    i_q = np.einsum("nj,jm,nm->n", splines(d, knots_d, 0), both, splines(q, knots_q, 1))
    return np.stack([i_d, i_q], axis=-1)


def points(f: FluxCorrection, n: int = 2000) -> Floats:
    """Flux linkages on the grid and around it."""
    rng = np.random.default_rng(6)
    d = rng.uniform(f.psi_d_from - 0.2, f.psi_d_to + 0.2, n)
    return np.stack([d, rng.uniform(-1.2, 1.2, n) * f.psi_q_to], axis=-1)


def test_currents_are_those_of_scipys_splines() -> None:
    psi = points(GRID)
    i = by_scipy(GRID, psi)
    assert flux_correction_currents(GRID.record, psi) == pytest.approx(i, abs=1e-11)
    assert np.abs(i).max() > 5.0 and (i == 0.0).all(axis=1).sum() > 100


def test_they_have_no_curl() -> None:
    """di_d/dpsi_q = di_q/dpsi_d by finite differences, for numbers without any order."""
    gamma = slopes(lambda at: flux_correction_currents(GRID.record, at), points(GRID), 1e-6)
    assert gamma[:, 0, 1] == pytest.approx(gamma[:, 1, 0], abs=1e-6)
    assert np.abs(gamma[:, 0, 1]).max() > 10.0


def test_they_mirror_in_psi_q() -> None:
    psi = points(GRID)
    here, there = (flux_correction_currents(GRID.record, psi * (1.0, way)) for way in (1.0, -1.0))
    assert np.array_equal(here * (1.0, -1.0), there)
    on_d = flux_correction_currents(GRID.record, psi * (1.0, 0.0))
    assert not on_d[:, 1].any() and on_d[:, 0].any()


def test_at_the_edges_currents_and_slopes_are_zero() -> None:
    """So the map goes on smoothly; beyond, also for what is no number, there is nothing."""
    line = np.linspace(0.0, 1.0, 101)
    d = GRID.psi_d_from + line * (GRID.psi_d_to - GRID.psi_d_from)
    edges = [
        np.stack([np.full(101, GRID.psi_d_from), line * GRID.psi_q_to], axis=-1),
        np.stack([np.full(101, GRID.psi_d_to), line * GRID.psi_q_to], axis=-1),
        np.stack([d, np.full(101, GRID.psi_q_to)], axis=-1),
    ]
    for edge in edges:
        gamma = slopes(lambda at: flux_correction_currents(GRID.record, at), edge, 1e-6)
        assert np.abs(gamma).max() < 0.02, "of slopes up to some hundred"
    far = np.array([[1e9, 0.1], [-1e300, 0.1], [0.1, 1e9], [np.nan, np.nan], [np.inf, -np.inf]])
    assert np.abs(flux_correction_currents(GRID.record, far)).max() < 1e-9


def test_the_plant_has_model_and_correction(map_currents: Map) -> None:
    motor = measured_machine()
    psi = points(motor.flux_correction or GRID)
    i = map_currents(motor.saturation, psi) + by_scipy(motor.flux_correction or GRID, psi)
    assert plant_currents(motor, psi) == pytest.approx(i, abs=1e-9)
    assert flux_map_currents(*plant_map(motor), psi) == pytest.approx(i, abs=1e-9)


@pytest.mark.parametrize("details", [{}, {"emf_5": 0.04, "emf_7": -0.025, "saliency_6": 0.06}])
def test_energy_is_neither_made_nor_lost(details: dict[str, float], map_currents: Map) -> None:
    """Electrical input = copper loss + shaft work + change of field energy, also with harmonics.

    Currents and energy are computed here, from the equations of the headers and SciPy's splines.
    """
    motor = rough_machine()
    s = Scenarios.nominal(motor, np.ones(1, dtype=np.uint64), 1.0)
    for name, value in details.items():
        getattr(s, name)[:] = value
    plant = SimFactory(motor, DriveDesign()).build(s)["plant"].copy()
    assert plant["detail"][0] == bool(details) and plant["map"]["correction"][0] != 0
    h, hold, J = 5e-6, 40, 0.005
    plant["h"], plant["inv_J"] = h, 1.0 / J
    m_d, m_q, gamma, psi_0 = (
        float(plant["harmonics"][n][0]) for n in ("m_d", "m_q", "gamma", "psi_0")
    )

    def own(x: Floats) -> Floats:
        more = by_scipy(motor.flux_correction or GRID, x.reshape(-1, 2)).reshape(x.shape)
        return np.asarray(map_currents(motor.saturation, x) + more)

    def at(psi: Floats, theta: Floats) -> tuple[Floats, Floats]:
        c, s = np.cos(6.0 * theta), np.sin(6.0 * theta)
        x = psi - np.stack([m_d * c, m_q * s], axis=-1)
        z = gamma * (x[..., 0] - psi_0 - 1j * x[..., 1]) * (c + 1j * s)
        return own(x) + np.stack([z.real, z.imag], axis=-1), x

    def energy(psi: Floats, theta: float) -> float:
        x = at(psi, np.asarray(theta))[1]
        start = np.array([psi_0, 0.0])
        way = x - start
        total = float(WEIGHTS @ (own(start + PLACES[:, None] * way) @ way))
        z = (x[0] - psi_0 + 1j * x[1]) ** 2 * np.exp(-6j * theta)
        return float(1.5 * (total + 0.5 * gamma * z.real))

    assert own(np.array([psi_0, 0.0])) == pytest.approx([0.0, 0.0], abs=1e-9)
    rng = np.random.default_rng(3)
    held = rng.uniform(-250.0, 250.0, 40) + 1j * rng.uniform(-250.0, 250.0, 40)
    state = np.zeros(1, dtype=PLANT_STATE)
    state["psi_d"], state["psi_q"] = flux(motor.saturation, np.array([[-1.0, 3.0]]))[0]
    state["omega_m"], state["theta_e"] = 90.0, 0.4
    u = np.repeat(held, hold)
    rows = plant_run(plant, state, np.stack([u.real, u.imag, np.zeros(len(u))], axis=-1))
    psi, tau, omega, theta = rows[:, 2:4], rows[:, 4], rows[:, 5], rows[:, 6]
    i_dq = at(psi, theta)[0]
    assert rows[:, :2] == pytest.approx(i_dq, abs=1e-8)
    i = (i_dq[:, 0] + 1j * i_dq[:, 1]) * np.exp(1j * theta)
    electrical = copper = 0.0
    for k, volt in enumerate(held):
        part = slice(hold * k, hold * (k + 1) + 1)
        electrical += simpson(1.5 * (volt * np.conj(i[part])).real, dx=h)
        copper += simpson(1.5 * motor.R_s * np.abs(i[part]) ** 2, dx=h)
    shaft = simpson(tau * omega, dx=h)
    field = energy(psi[-1], theta[-1]) - energy(psi[0], theta[0])
    scale = copper + abs(shaft) + abs(field)
    assert min(copper, abs(shaft), abs(field)) > 1e-3 * scale, "a term is too small to be tested"
    assert abs(electrical - copper - shaft - field) < 1e-6 * scale
    kinetic = 0.5 * J * (omega[-1] ** 2 - omega[0] ** 2)
    assert abs(shaft - kinetic - motor.B * simpson(omega**2, dx=h)) < 1e-6 * scale


def drives(motor: Motor, n: int = 20) -> Array:
    seeds = np.arange(n, dtype=np.uint64)
    return SimFactory(motor, DriveDesign()).build(stress_1_scenarios(motor, seeds))


def advance(sims: Array, **how: bool) -> Array:
    obs = np.zeros((len(sims), SIGNAL_N), np.float32)
    sim_run(sims, 1500, np.full(len(sims), 0.6, np.float32), obs, **how)  # type: ignore[arg-type]
    return obs


@pytest.mark.parametrize("machine", [rough_machine, measured_machine])
def test_blocks_equal_the_plain_loop(machine: Callable[[], Motor], state_bytes: Bytes) -> None:
    """Also beside drives of the same machine without correction; the correction matters."""
    motor = machine()
    without = dataclasses.replace(motor, flux_correction=None)
    sims = np.concatenate([drives(motor), drives(without)])
    plain, alone = sims.copy(), sims[:20].copy()
    here, there = advance(sims), advance(plain, plain=True)
    assert here.tobytes() == there.tobytes()
    assert state_bytes(sims) == state_bytes(plain)
    advance(alone)
    assert state_bytes(alone) == state_bytes(sims[:20])
    assert (sims["drive"]["y"]["i_d"][:20] != sims["drive"]["y"]["i_d"][20:]).all()
    assert (sims["lost"] == 0).sum() > 30


def test_two_corrections_side_by_side(state_bytes: Bytes) -> None:
    motor = rough_machine()
    other = dataclasses.replace(motor, flux_correction=rough_correction(motor, 0.005))
    both = np.concatenate([drives(m, 8) for m in (motor, other)])
    mixed = both[[0, 8, 1, 9, 2, 10, 3, 11, 4, 12, 5, 13, 6, 14, 7, 15]].copy()
    advance(both)
    advance(mixed)
    assert state_bytes(mixed[0::2]) == state_bytes(both[:8])
    assert state_bytes(mixed[1::2]) == state_bytes(both[8:])


def test_an_unknown_map_is_not_taken_for_another() -> None:
    """A drive from a process that knows its map has no numbers in one that does not."""
    sims = drives(rough_machine(), 4)
    sims["plant"]["map"]["correction"] ^= 1 << 20
    record, extra = plant_map(rough_machine())
    record["correction"] ^= 1
    assert np.isnan(flux_map_currents(record, extra, np.array([[0.3, 0.1]]))).all()
    advance(sims)
    assert (sims["lost"] & lib.LOST_NONFINITE != 0).all()


def test_the_key_follows_from_the_numbers() -> None:
    motor = rough_machine()
    key = int(plant_record(motor)["map"]["correction"])
    again = pickle.loads(pickle.dumps(motor))
    assert int(plant_record(again)["map"]["correction"]) == key != 0
    assert int(plant_record(Motor.load("paper"))["map"]["correction"]) == 0
    other = dataclasses.replace(motor, flux_correction=rough_correction(motor, 0.02))
    assert int(plant_record(other)["map"]["correction"]) != key


def test_a_place_is_not_given_twice() -> None:
    """Two keys with one remainder: the second is refused, not mixed up with the first."""
    kept = np.array([GRID.record, GRID.record])
    kept["key"] = 0x10000 + 12345, 0x20000 + 12345
    enter = [
        lib.flux_correction_enter(pointer(row, "flux_correction_t[]")) for row in kept[:, None]
    ]
    KEPT.append(kept)
    assert enter == [1, 0]


KEPT: list[Array] = []
"""What the core goes on reading."""


def test_another_process_has_the_same_drive(tmp_path: Path) -> None:
    """A pickled factory brings its machine's map along."""
    factory = SimFactory(rough_machine(), DriveDesign())
    file = tmp_path / "factory.pickle"
    file.write_bytes(pickle.dumps(factory))
    code = (
        "import pickle, sys, numpy as np\n"
        "from sensorless.core.api import SIGNAL_N, sim_run\n"
        "from sensorless.envs.scenarios.stress import stress_1_scenarios\n"
        "factory = pickle.loads(open(sys.argv[1], 'rb').read())\n"
        "sims = factory.build("
        "stress_1_scenarios(factory.motor, np.arange(3, dtype=np.uint64)))\n"
        "obs = np.zeros((3, SIGNAL_N), np.float32)\n"
        "sim_run(sims, 1500, np.full(3, 0.6, np.float32), obs)\n"
        "open(sys.argv[2], 'wb').write(sims.tobytes())\n"
    )
    out = tmp_path / "sims"
    subprocess.run([sys.executable, "-c", code, str(file), str(out)], check=True)
    sims = drives(rough_machine(), 3)
    advance(sims)
    assert np.isfinite(sims["drive"]["y"]["tau"]).all()
    assert out.read_bytes() == sims.tobytes()
