"""Identifies cross-coupling as in commissioning: a load sweep on the injection estimator alone.

The drive runs at low speed on its injection estimator, and the load goes from full torque in one
direction to full torque in the other while an encoder watches. Without compensation the estimate is
off the rotor by theta_cross (half the angle of Fig. 4 and Eq. 16 of doi 10.12177/emca.2025.011).
Angles here are truth minus estimate: what compensation adds.
"""

import dataclasses
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from sensorless.core.api import CURVE_N, Array
from sensorless.design.control import operating_line
from sensorless.design.cross_coupling import FORMAT, slope_through_zero
from sensorless.design.drive import DriveDesign
from sensorless.errors import UserError
from sensorless.evaluation.steady import Steady, steady
from sensorless.files import write_atomic
from sensorless.machine.magnetics import Floats, cross_angle, torque
from sensorless.machine.motor import Motor

POINTS = 41
CURRENT = 1.1
"""Ends of the sweep: the torque that this multiple of rated current gives."""
SPEED = 0.1
"""Speed of the sweep over rated speed."""
SPEED_HZ = 1.0
"""Speed loop of the sweep: slow, so that the drive comes to rest at each load [Hz]."""


@dataclass(frozen=True)
class Fit:
    """How well a compensation fits the measured angles."""

    r2: float
    """share of the variance of the angles that it explains"""
    residual_rms_deg: float
    residual_max_deg: float


@dataclass(frozen=True)
class Line:
    """A line through zero, the source paper's compensation; least squares up to a working torque.

    It cannot fit everywhere: the q axis saturates, so the slope falls with the current.
    """

    slope: float
    """[rad/A]"""
    up_to: float
    """|i_q| of the working torque, where the fit ends [A]"""
    fit: Fit
    """over the range that it was fitted to"""
    slopes: tuple[float, float]
    """of lines for positive and for negative torque alone, over the same range [rad/A]"""
    fits: tuple[Fit, Fit]
    """of the common line, for positive and for negative torque"""
    to_rated: Fit
    """of the same line over the whole sweep up to rated current"""


@dataclass(frozen=True)
class CrossCoupling:
    """Result of the sweep. Currents are in the encoder's frame."""

    motor: Motor
    mtpa: bool
    speed_rpm: float
    i: Floats
    """(n, 2) currents of the sweep [A]"""
    angle: Floats
    """(n,) theta_cross measured [rad]"""
    line: Line
    nodes: Floats
    """(CURVE_N,) |i_q| of the table [A]"""
    table: Floats
    """(CURVE_N,) theta_cross at positive i_q [rad], from a second sweep under the first fit"""
    table_fit: Fit
    left: Floats
    """(m,) error of the drive that runs on the table [rad], over ``left_i_q`` [A]"""
    left_i_q: Floats
    left_line: Floats
    """error of the drive that runs on the line, as far as the line was fitted [rad]"""

    def report(self) -> dict[str, Any]:
        """Return plain data in amperes and degrees."""
        rad = np.rad2deg
        theory = cross_angle(self.motor, self.i)
        line = self.line
        return {
            "format": FORMAT,
            "motor": self.motor.name,
            "motor_digest": self.motor.digest,
            "mtpa": self.mtpa,
            "speed_rpm": self.speed_rpm,
            "angle": "truth minus estimate of the uncompensated injection estimator, theta_cross",
            "line": {
                "slope_deg_per_A": float(rad(line.slope)),
                "fitted_up_to_A": line.up_to,
                **dataclasses.asdict(line.fit),
                **{
                    f"{way}_torque": {
                        "slope_deg_per_A": float(rad(slope)),
                        **dataclasses.asdict(fit),
                    }
                    for way, slope, fit in zip(
                        ("positive", "negative"), line.slopes, line.fits, strict=True
                    )
                },
                "to_rated_current": dataclasses.asdict(line.to_rated),
            },
            "table": {
                "i_q_A": self.nodes.tolist(),
                "angle_deg": rad(self.table).tolist(),
                **dataclasses.asdict(self.table_fit),
            },
            "left_with_table_max_deg": float(rad(np.max(np.abs(self.left)))),
            "left_with_line_max_deg": float(rad(np.max(np.abs(self.left_line)))),
            "closed_form_max_gap_deg": float(rad(np.max(np.abs(self.angle - theory)))),
            "sweep": {
                "i_d_A": self.i[:, 0].tolist(),
                "i_q_A": self.i[:, 1].tolist(),
                "angle_deg": rad(self.angle).tolist(),
                "closed_form_deg": rad(theory).tolist(),
            },
        }

    def write(self, path: Path) -> None:
        """Write ``report`` as JSON, whole or not at all."""
        write_atomic(path, json.dumps(self.report(), indent=1) + "\n")


def identify_cross_coupling(motor: Motor, design: DriveDesign) -> CrossCoupling:
    """Sweep, fit, and sweep again with the fit in force.

    Without compensation the wrong angle moves the current itself off its operating line. So the
    table comes from a second sweep with the first fit in force: what compensation adds, plus the
    error that is left.

    Raises
    ------
    UserError
        The drive holds too few loads of the sweep.
    """
    design = dataclasses.replace(design, estimator="smo", cross="none", speed_hz=SPEED_HZ)
    raw = _sweep(motor, design, np.zeros(CURVE_N))
    i_q, angle = raw.i[:, 1], raw.err_hfi
    tau = torque(motor, raw.i)
    working = np.abs(tau) <= 1.001 * design.cross_line_torque * motor.tau_rated
    line = fit_line(i_q, angle, working, motor.i_rated)
    nodes = np.linspace(0.0, motor.i_max, CURVE_N)
    first = fit_table(nodes, i_q, angle)
    second = _sweep(motor, design, first)
    total = second.err_hfi + lookup(nodes, first, second.i_q_hat)
    table = fit_table(nodes, second.i[:, 1], total)
    check = _sweep(motor, design, table)
    on_line = _sweep(motor, design, line.slope * nodes)
    inside = np.abs(on_line.i[:, 1]) <= line.up_to
    return CrossCoupling(
        motor=motor,
        mtpa=design.mtpa,
        speed_rpm=SPEED * motor.n_rated_rpm,
        i=raw.i,
        angle=angle,
        line=line,
        nodes=nodes,
        table=table,
        table_fit=_fit(total, lookup(nodes, table, second.i[:, 1])),
        left=check.err,
        left_i_q=check.i[:, 1],
        left_line=on_line.err[inside],
    )


def _sweep(motor: Motor, design: DriveDesign, table: Floats) -> Steady:
    """Run the sweep; return the part that the drive holds within 97 % of its current limit."""

    def change(sims: Array) -> None:
        sims["control"]["theta_cross"]["y"] = table

    line = operating_line(motor, design.mtpa)
    top = np.interp(CURRENT * motor.i_rated, np.hypot(*line.T), torque(motor, line))
    tau = top * np.linspace(-1.0, 1.0, POINTS)
    rpm = np.full(POINTS, SPEED * motor.n_rated_rpm)
    out = steady(motor, design, rpm, tau, 1.0, settle=2.5, change=change)
    good = out.held & (np.hypot(*out.i.T) < 0.97 * motor.i_max)
    if np.sum(good & (tau > 0)) < 5 or np.sum(good & (tau < 0)) < 5:
        raise UserError(
            f"motor {motor.name!r}: the injection estimator holds only {int(good.sum())} of "
            f"{POINTS} loads of the sweep, and needs 5 in each direction; check the motor's "
            "saliency and current limit"
        )
    return Steady(**{f.name: getattr(out, f.name)[good] for f in dataclasses.fields(out)})


def fit_line(i_q: Floats, angle: Floats, working: Array, rated: float) -> Line:
    """Least-squares line through zero over the ``working`` points, judged up to ``rated`` [A]."""
    slope = slope_through_zero(i_q[working], angle[working])

    def judge(rows: Array) -> Fit:
        return _fit(angle[rows], slope * i_q[rows])

    ways = (working & (i_q > 0.0), working & (i_q < 0.0))
    return Line(
        slope=slope,
        up_to=float(np.max(np.abs(i_q[working]))),
        fit=judge(working),
        slopes=(
            slope_through_zero(i_q[ways[0]], angle[ways[0]]),
            slope_through_zero(i_q[ways[1]], angle[ways[1]]),
        ),
        fits=(judge(ways[0]), judge(ways[1])),
        to_rated=judge(np.abs(i_q) <= rated),
    )


def fit_table(nodes: Floats, i_q: Floats, angle: Floats) -> Floats:
    """Least-squares values at evenly spaced |i_q| ``nodes`` of an odd, piecewise linear function.

    Beyond the measured currents it continues in a straight line.
    """
    step, size = nodes[1] - nodes[0], np.abs(i_q)
    hats = np.maximum(0.0, 1.0 - np.abs(size[:, None] - nodes) / step) * np.sign(i_q)[:, None]
    known = min(len(nodes), int(size.max() / step + 0.5) + 1)
    inside = size <= nodes[known - 1]
    out = np.zeros(len(nodes))
    out[1:known] = np.linalg.lstsq(hats[inside, 1:known], angle[inside], rcond=None)[0]
    for j in range(known, len(nodes)):
        out[j] = 2.0 * out[j - 1] - out[j - 2]
    return out


def lookup(nodes: Floats, table: Floats, i_q: Floats) -> Floats:
    """Value of a table over |i_q| at ``i_q`` of either sign [rad]."""
    return np.asarray(np.sign(i_q) * np.interp(np.abs(i_q), nodes, table))


def _fit(angle: Floats, model: Floats) -> Fit:
    gap = np.rad2deg(angle - model)
    spread = np.rad2deg(angle - angle.mean())
    return Fit(
        r2=float(1.0 - gap @ gap / (spread @ spread)),
        residual_rms_deg=float(np.sqrt(np.mean(gap**2))),
        residual_max_deg=float(np.max(np.abs(gap))),
    )
