"""Runs the drive's estimators, their blend and an independent filter over a recorded log."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from sensorless.core.api import REPLAY_NAMES, SIGNAL_N, Array, ObserverRun
from sensorless.decision import decision_periods
from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.design.words import observer_name
from sensorless.errors import UserError
from sensorless.files import write_atomic
from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Motor
from sensorless.machine.phases import clarke, with_third
from sensorless.observers.ekf import run_ekf
from sensorless.plain_table import PlainTable
from sensorless.policy import Policy, PrivilegedPolicy, design_for, gains_of
from sensorless.replay.log import Log, read_log
from sensorless.replay.signature import of_encoder, of_injection
from sensorless.units import wrapped

SAMPLE = Path(__file__).parent / "sample_log.csv"
"""A log of the paper's motor that comes with the package."""


FLUX_ALONE = "flux alone"
"""What the coupled observer's flux model would give without injection."""
LITTLE = 0.05
"""Weight of an estimator in the blend from which it counts as its signal."""
MOST_SPEED = 10.0
"""First speed of the estimators over rated, at most."""


@dataclass(frozen=True)
class Estimate:
    """One estimator over n samples."""

    theta_e: Floats
    """(n,) angle, electrical [rad]"""
    omega_e: Floats
    """(n,) speed, electrical [rad/s]"""
    valid: Array
    """(n,) bool: it had a signal; otherwise it followed the blend, and the blend its last speed"""


@dataclass(frozen=True)
class Replay:
    """All estimators over a log."""

    motor: Motor
    policy: str
    log: Log
    k_s: Floats
    """(n,) weight of the blend"""
    observer: str
    """name of the observer beside the injection, see ``observer_name``, or ``FLUX_ALONE``"""
    estimates: dict[str, Estimate] = field(default_factory=dict)
    """by the ending of their columns: hfi, smo (the observer), blend and ekf"""
    notes: tuple[str, ...] = ()
    """what was taken for what in the log, and what looks wrong in it"""

    def label(self, name: str) -> str:
        """Name of an estimator for people."""
        return {"hfi": "HFI", "smo": self.observer, "blend": "blend", "ekf": "EKF"}[name]

    def error(self, name: str) -> Floats | None:
        """Truth minus estimate (n,) [rad]; None without an encoder."""
        if self.log.theta_e is None:
            return None
        turn = self.log.theta_e - self.estimates[name].theta_e
        return np.asarray(wrapped(turn))

    def write_csv(self, path: Path) -> None:
        """Write angle, speed and error of every estimator, one row per sample."""
        columns: dict[str, Array] = {"t": self.log.t, "k_s": self.k_s}
        if self.log.theta_e is not None:
            columns["theta_e"] = self.log.theta_e
        for name, estimate in self.estimates.items():
            columns[f"theta_e_hat_{name}"] = estimate.theta_e
            columns[f"omega_e_hat_{name}"] = estimate.omega_e
            error = self.error(name)
            if error is not None:
                columns[f"theta_e_err_{name}"] = error
            columns[f"valid_{name}"] = estimate.valid
        form = ",".join(["%.9g"] * len(columns))
        lines = [form % tuple(row) for row in np.stack(list(columns.values()), axis=-1)]
        write_atomic(path, "\n".join([",".join(columns), *lines]) + "\n")

    def table(self, after: float = 0.0) -> PlainTable:
        """Errors of every estimator while it had its own signal, from ``after`` [s] on."""
        since = f" from {after:g} s on" if after > 0.0 else ""
        table = PlainTable(
            title=f"{len(self.log.t)} samples of {self.motor.name}, k_s: {self.policy}"
        )
        table.caption = (
            "own signal: share of samples with a signal to find the angle by. RMS, largest, mean: "
            f"angle error there, truth − estimate, electrical{since}. without: RMS in the other "
            "samples, which have neither injection nor speed enough: there HFI and the observer "
            "follow the blend, and blend and EKF go on by dead reckoning. HFI: injection. EKF: a "
            "Kalman filter to compare with."
        )
        headings = ("estimator", "own\nsignal [%]", "RMS\n[°]", "largest\n[°]", "mean\n[°]")
        for heading in (*headings, "without\n[°]"):
            table.add_column(heading, justify="left" if heading == "estimator" else "right")
        for name, row in self.summary(after).items():
            keys = ("rms_deg", "max_deg", "mean_deg", "without_rms_deg")
            cells = (f"{row[key]:.2f}" if math.isfinite(row[key]) else "–" for key in keys)
            table.add_row(self.label(name), f"{100.0 * row['share']:.0f}", *cells)
        return table

    def summary(self, after: float = 0.0) -> dict[str, dict[str, float]]:
        """Share of samples with an own signal and angle errors over those, by estimator.

        Returns
        -------
        dict
            By estimator ``share``, and ``rms_deg``, ``max_deg``, ``mean_deg`` [deg] where it had a
            signal, and ``without_rms_deg`` [deg] where not; NaN without an encoder or such samples.

        Raises
        ------
        UserError
            The log ends before ``after``.
        """
        late = self.log.t - self.log.t[0] >= after
        if not late.any():
            length = self.log.t[-1] - self.log.t[0]
            raise UserError(f"after: {after:g} s; the log ends at {length:g} s: give less")
        out = {}
        for name, estimate in self.estimates.items():
            own = late & estimate.valid
            error = self.error(name)
            deg = np.rad2deg(error[own]) if error is not None and own.any() else np.array([np.nan])
            rest = late & ~estimate.valid & np.isfinite(estimate.theta_e)
            lost = np.rad2deg(error[rest]) if error is not None and rest.any() else [np.nan]
            out[name] = {
                "share": float(np.mean(estimate.valid[late])),
                "rms_deg": float(np.sqrt(np.mean(deg**2))),
                "max_deg": float(np.max(np.abs(deg))),
                "mean_deg": float(np.mean(deg)),
                "without_rms_deg": float(np.sqrt(np.mean(np.square(lost)))),
            }
        return out


def load(
    path: Path,
    motor: Motor,
    design: DriveDesign,
    delay: int = 0,
    names: Mapping[str, str] | None = None,
) -> Log:
    """Read a log for a drive; see ``sensorless.replay.log.read_log``.

    Raises
    ------
    UserError
        The delay is out of range, or as there.
    """
    if not 0 <= delay <= 2:
        raise UserError(f"delay: {delay}; give 0, 1 or 2 rows")
    control = control_record(motor, design)["control"]
    u_dt, inv_i_dt = float(control["u_dt"]), float(control["inv_i_dt"])
    return read_log(path, motor, u_dt=u_dt, inv_i_dt=inv_i_dt, delay=delay, names=names)


def replay(
    log: Log,
    motor: Motor,
    design: DriveDesign,
    policy: Policy,
    *,
    theta_0: float = 0.0,
    omega_0: float = 0.0,
) -> Replay:
    """Run every estimator over a log. None of them sees the encoder.

    Parameters
    ----------
    policy : Policy
        Chooses k_s as often as in the drive, from the same signals; the speed reference, which a
        log does not have, is the estimated speed.
    theta_0, omega_0 : float
        Start of the estimators, electrical [rad, rad/s]; injection shows the angle only up to half
        a turn.

    Raises
    ------
    UserError
        The policy needs the true angle, or sets gains; the start is out of range.
    """
    _check_start(theta_0, omega_0, motor)
    _check_policy(policy)
    own = design_for(policy, design)
    control = control_record(motor, own)
    column = _run_observers(log, control, policy, decision_periods(motor), theta_0, omega_0)
    hfi, smo, weight = column["valid_hfi"] > 0.0, column["valid_smo"] > 0.0, column["k_s"]
    led = hfi | smo  # the coupled observer takes both
    if own.estimator != "coupled":
        led = (hfi & (weight > LITTLE)) | (smo & (weight < 1.0 - LITTLE))
    signal = {"hfi": hfi, "smo": smo, "blend": led}
    estimates = {
        name: Estimate(column[f"theta_{name}"], column[f"omega_{name}"], valid)
        for name, valid in signal.items()
    }
    theta, omega = run_ekf(motor, log.u, clarke(with_third(*log.i.T)), theta_0, omega_0)
    own_emf = motor.psi_f * np.abs(omega) > float(control["smo"]["e_floor"])
    estimates["ekf"] = Estimate(theta, omega, np.isfinite(theta) & (hfi | own_emf))
    notes = list(log.notes)
    if not np.isfinite(theta).all():
        notes.append(
            f"the Kalman filter diverged at t = {log.t[np.argmin(np.isfinite(theta))]:g} s"
        )
    if log.theta_e is not None:
        blend, against = estimates["blend"], []
        if log.inj is not None:
            against = list(of_injection(log.u, log.inj, log.theta_e, theta))
        notes += against or of_encoder(log.theta_e, blend.theta_e, blend.valid, motor)
        log = replace(log, doubtful=log.doubtful or bool(against))
    observer = FLUX_ALONE if own.estimator == "coupled" else observer_name(own.estimator)
    return Replay(motor, policy.name, log, weight, observer, estimates, tuple(notes))


def _check_start(theta_0: float, omega_0: float, motor: Motor) -> None:
    """Refuse a start beyond a turn, or beyond ``MOST_SPEED`` times rated speed.

    Raises
    ------
    UserError
        It is.
    """
    if not (abs(theta_0) <= 2.0 * math.pi and abs(omega_0) <= MOST_SPEED * motor.omega_rated):
        most = MOST_SPEED * motor.n_rated_rpm
        raise UserError(
            f"angle, speed: give -360 to 360 degrees, and a speed of at most {most:g} r/min"
        )


def _check_policy(policy: Policy) -> None:
    """Refuse a policy that a log cannot serve.

    Raises
    ------
    UserError
        It needs the true angle, or sets gains.
    """
    if policy.sensored or isinstance(policy, PrivilegedPolicy):
        raise UserError(
            f"policy: {policy.name!r} needs the true angle, which a log lacks; give a rule or table"
        )
    if gains_of(policy):
        raise UserError(
            f"policy: {policy.name!r} also sets gains, and a replay runs on static ones; give a "
            "schedule of k_s alone"
        )


def _run_observers(
    log: Log, control: Array, policy: Policy, every: int, theta_0: float, omega_0: float
) -> dict[str, Floats]:
    """Columns of ``REPLAY_NAMES`` (n,), SI units; the policy decides every ``every`` periods."""
    run = ObserverRun(control, theta_0, omega_0, 1.0)
    rows, out = log.rows(), []
    policy.reset(1)
    obs = run.advance(rows[:0], 1.0)[1]
    for first in range(0, len(rows), every):
        k_s = float(policy.act(obs.reshape(1, SIGNAL_N).copy())[0])
        part, obs = run.advance(rows[first : first + every], k_s)
        out.append(part)
    return dict(zip(REPLAY_NAMES, np.concatenate(out).T.astype(np.float64), strict=True))
