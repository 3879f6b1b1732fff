"""What happens to a drive: its profile, its start, and how reality differs from its parameters."""

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensorless.core.api import PROFILE_N, SIM, Array, lib, sim_start
from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record, fill, good_noise, plant_record, sensor_record
from sensorless.envs.counter_random import Floats, Seeds
from sensorless.errors import UserError
from sensorless.machine.magnetics import iron_conductance
from sensorless.machine.motor import Motor
from sensorless.observers.start_design import alike, knows_poles, spin_speed
from sensorless.policy import NO_SETTINGS, Settings
from sensorless.units import RPM_TO_RAD_S

Bools = NDArray[np.bool_]

NEVER: int = lib.NEVER
LOST_ANGLE_DEG = 60.0
"""Angle error beyond which lock is lost, if it lasts [degrees]."""
LOST_TIME = 0.01
"""How long it has to last [s]."""
OF_THE_MACHINE = ("emf_5", "emf_7", "saliency_6", "p_iron", "u_transistor", "u_diode")
"""Fields whose nominal value is the motor file's."""
OF_THE_SCENARIO = ("ripple", "ripple_hz", "ripple_phase", "winding_K", "magnet_K")
"""Fields that are nominally zero."""
U_DC_TIME = 0.01
"""Time in which the DC link would move by its nominal voltage between its targets [s]."""
RUNAWAY = 2.5
"""Speed over rated beyond which the twin has run away: no suite asks for more than rated speed, and
by default the estimators are bounded there too."""


@dataclass
class Scenarios:
    """A batch of n scenarios; every field has n rows. Speeds are mechanical, torques in N m.

    Profile arrays have ``PROFILE_N`` columns, one per segment; a segment whose ``t`` is infinite
    never starts. Each quantity runs to its target with its own rate (infinite: a step).
    """

    seed: Seeds
    duration: Floats
    """[s]"""
    t: Floats
    """start of each segment [s]; the first is 0"""
    omega: Floats
    """speed target [rad/s]"""
    omega_rate: Floats
    """[rad/s^2]"""
    tau: Floats
    """load torque, positive brakes positive speed [N m]"""
    tau_rate: Floats
    """[N m/s]"""
    u_dc: Floats
    """DC-link voltage over the motor's nominal one"""
    omega_0: Floats
    """speed at the start [rad/s]"""
    theta_0: Floats
    """electrical angle at the start [rad]"""
    theta_err_0: Floats
    """truth minus the estimators' angle at the start [rad]"""
    seek: Bools
    """the drive knows neither its angle nor its speed and runs its start sequence first"""
    passive: Bools
    """the load only resists, like friction: its magnitude acts against the motion, none at rest"""
    R_s: Floats
    """resistance over the controller's value"""
    L_q_hat: Floats
    """observer's q inductance over its design value"""
    psi_f: Floats
    """magnet strength over its nominal value"""
    J: Floats
    """inertia over its nominal value"""
    cross_hat: Floats
    """cross-coupling compensation over its design value"""
    dead_time: Floats
    """[s]"""
    noise: Floats
    """current noise, RMS [A]"""
    gain: Floats
    """(n, 2) gains of the phase-current channels"""
    offset: Floats
    """(n, 2) offsets of the phase-current channels [A]"""
    detailed: Bools
    """the averaged inverter knows its currents at every edge, see ``core/sim/edges.h``; so it does
    wherever one of the following is not zero"""
    emf_5: Floats
    """5th harmonic of the EMF over its fundamental; this and the next ones as in the motor file"""
    emf_7: Floats
    saliency_6: Floats
    p_iron: Floats
    """[W]"""
    u_transistor: Floats
    """[V]"""
    u_diode: Floats
    """[V]"""
    ripple: Floats
    """amplitude of the DC link's ripple over the link"""
    ripple_hz: Floats
    ripple_phase: Floats
    """of a cosine, at the start [rad]"""
    winding_K: Floats
    """winding above the temperature at which the controller knows its resistance [K]"""
    magnet_K: Floats
    """magnet above the temperature at which the controller knows its flux [K]"""

    def __len__(self) -> int:
        """Return the number of scenarios."""
        return len(self.seed)

    def __getitem__(self, rows: int | slice | Array) -> "Scenarios":
        """Rows of every field; of one row by its number, too."""
        rows = rows if isinstance(rows, slice) else np.atleast_1d(rows)
        return Scenarios(**{f.name: getattr(self, f.name)[rows] for f in dataclasses.fields(self)})

    @classmethod
    def nominal(cls, motor: Motor, seed: Seeds, duration: float) -> "Scenarios":
        """Standstill without load on a drive that knows its machine exactly."""
        n = len(seed)
        ones, zeros = np.ones(n), np.zeros(n)
        profile = np.zeros((n, PROFILE_N))
        t = np.full((n, PROFILE_N), np.inf)
        t[:, 0] = 0.0
        fast = np.full((n, PROFILE_N), np.inf)
        return cls(
            seed=np.asarray(seed, dtype=np.uint64),
            duration=duration * ones,
            t=t,
            omega=profile,
            omega_rate=fast,
            tau=profile.copy(),
            tau_rate=fast.copy(),
            u_dc=np.ones((n, PROFILE_N)),
            omega_0=zeros,
            theta_0=zeros.copy(),
            theta_err_0=zeros.copy(),
            seek=np.zeros(n, dtype=bool),
            passive=np.zeros(n, dtype=bool),
            R_s=ones,
            L_q_hat=ones.copy(),
            psi_f=ones.copy(),
            J=ones.copy(),
            cross_hat=ones.copy(),
            dead_time=motor.dead_time * ones,
            noise=good_noise(motor) * ones,
            gain=np.ones((n, 2)),
            offset=np.zeros((n, 2)),
            detailed=np.zeros(n, dtype=bool),
            **{name: np.full(n, getattr(motor, name)) for name in OF_THE_MACHINE},
            **{name: np.zeros(n) for name in OF_THE_SCENARIO},
        )


class SimFactory:
    """Turns scenarios into started ``SIM`` records for one motor and one design."""

    def __init__(self, motor: Motor, design: DriveDesign) -> None:
        self.motor = motor
        self.design = design
        template = np.zeros(1, dtype=SIM)
        fill(
            template[0],
            {
                "control": control_record(motor, design),
                "plant": plant_record(motor),
                "sensor": sensor_record(motor),
                "omega_scale": motor.n_p,
                "i_trip": motor.i_trip,
                "omega_limit": RUNAWAY * motor.omega_rated / motor.n_p,
                "err_limit": np.deg2rad(LOST_ANGLE_DEG),
                "err_periods": round(LOST_TIME / motor.T_s),
                "with_twin": 1,
            },
        )
        template["sensor"]["carrier"] = int(design.carrier)
        self.template = template
        """One drive (1,) before its scenario; ``build`` starts from copies."""

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore a pickle, also in a process that has not seen the machine's flux map."""
        self.__dict__.update(state)
        plant_record(self.motor)

    def build(
        self,
        s: Scenarios,
        *,
        sensored: bool = False,
        twin: bool = True,
        settings: Settings = NO_SETTINGS,
    ) -> Array:
        """Drives at the start of their scenarios, an array of ``SIM`` with shape (n,).

        ``settings``, as in ``Policy``, override the design's.

        Raises
        ------
        UserError
            A start from an unknown angle, at rest or nearly so, on a machine whose saturation does
            not tell its poles apart.
        """
        motor, slow = self.motor, spin_speed(self.motor)
        if not knows_poles(motor) and np.any(s.seek & (np.abs(s.omega_0) < slow * RPM_TO_RAD_S)):
            raise UserError(
                f"start: the poles of {motor.name} look alike: {alike(motor)}; start at a known "
                f"angle, or at {slow:.0f} r/min or more, or give the motor file a [saturation] in "
                "which L_d falls with i_d"
            )
        sims = np.repeat(self.template, len(s))
        design = dataclasses.replace(self.design, **settings)
        if design != self.design:
            sims["control"] = control_record(motor, design)
            sims["sensor"]["carrier"] = int(design.carrier)
        plant, control, sensor = sims["plant"], sims["control"], sims["sensor"]
        plant["inv_J"] /= s.J
        fill_details(plant, sensor, s, motor)
        control["L_q"]["y"] *= s.L_q_hat[:, None]
        control["theta_cross"]["y"] *= s.cross_hat[:, None]
        sensor["dead_time_share"] = s.dead_time / motor.T_s
        sensor["noise_rms"] = s.noise
        for j, phase in enumerate("ab"):
            sensor[f"gain_{phase}"] = s.gain[:, j]
            sensor[f"offset_{phase}"] = s.offset[:, j]
        _fill_profile(sims["profile"], s, motor)
        start = sims["start"]
        start["omega_m"], start["theta_e"] = s.omega_0, s.theta_0
        start["theta_err"], start["k_s"] = s.theta_err_0, 1.0
        start["seek"] = s.seek
        stick = 0.5 * motor.J * s.J / (motor.T_s * motor.tau_rated)
        sims["inv_stick"] = np.where(s.passive, stick, 0.0)
        sims["k_end"] = np.minimum(np.rint(s.duration / motor.T_s), lib.NEVER)
        sims["seed"] = (s.seed & np.uint64(0xFFFFFFFF)).astype(np.uint32)
        sims["sensored"], sims["with_twin"] = int(sensored), int(twin)
        sim_start(sims)
        return sims


def fill_details(plant: Array, sensor: Array, s: Scenarios, motor: Motor) -> None:
    """Resistance and magnet, and what the plant has beyond its fundamental, into n records."""
    R_s = s.R_s * (1.0 + motor.winding_per_K * s.winding_K)
    magnet = s.psi_f * (1.0 + motor.magnet_per_K * s.magnet_K)
    plant["R_s"] *= R_s
    for field in ("i_f", "psi_n"):  # the machine has its magnet in either of them
        plant["map"][field] *= magnet
    harmonics, turn = plant["harmonics"], 2.0**32
    fifth, seventh = (motor.psi_f * magnet * x for x in (s.emf_5 / 5.0, s.emf_7 / 7.0))
    harmonics["m_d"], harmonics["m_q"] = fifth + seventh, seventh - fifth
    harmonics["gamma"] = 0.5 * s.saliency_6 * (1.0 / motor.L_d - 1.0 / motor.L_q)
    plant["g_iron"] = iron_conductance(motor, s.p_iron)
    plant["k_iron"] = 1.0 / (1.0 + plant["R_s"] * plant["g_iron"])
    sensor["u_on"] = 0.5 * (s.u_transistor + s.u_diode)
    sensor["u_skew"] = s.u_transistor - s.u_diode
    sensor["ripple"] = s.ripple
    phase = s.ripple_phase / (2.0 * np.pi) % 1.0
    sensor["ripple_phase"] = np.floor(turn * phase).astype(np.uint64)
    sensor["ripple_half_step"] = np.rint(turn * (0.5 * s.ripple_hz * motor.T_s % 1.0)) % turn
    names = (*OF_THE_MACHINE, "ripple")
    plant["detail"] = s.detailed | np.any([getattr(s, name) != 0.0 for name in names], axis=0)


def _fill_profile(profile: Array, s: Scenarios, motor: Motor) -> None:
    """Convert scenarios in SI units to ``profile_t`` in periods and electrical speed."""
    n_p, T_s, top = motor.n_p, motor.T_s, np.float32(1e9)
    periods = np.where(np.isfinite(s.t), np.rint(np.where(np.isfinite(s.t), s.t, 0.0) / T_s), NEVER)
    profile["start"] = periods.astype(np.int64).clip(0, NEVER)
    profile["omega_ref"] = n_p * s.omega
    profile["omega_step"] = np.minimum(n_p * s.omega_rate * T_s, top)
    profile["tau"] = s.tau
    profile["tau_step"] = np.minimum(s.tau_rate * T_s, top)
    profile["u_dc"] = motor.u_dc * s.u_dc
    profile["u_dc_step"] = motor.u_dc * T_s / U_DC_TIME
