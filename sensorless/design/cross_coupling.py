"""Compensation of cross-coupling: nothing, a line, the flux map's own curve, or a measured one."""

import math
from pathlib import Path
from typing import Any

import numpy as np

from sensorless.core.api import CURVE_N
from sensorless.errors import UserError
from sensorless.files import read_json, reason
from sensorless.machine.magnetics import Floats, cross_angle, torque
from sensorless.machine.motor import Motor

FORMAT = "sensorless-cross-coupling/1"
MOST = 0.5 * math.pi
"""Largest angle by which current can turn the magnetic axes [rad]."""
POINTS = 60
"""Number of currents that a line is fitted to."""


def slope_through_zero(i_q: Floats, angle: Floats) -> float:
    """Least-squares slope of a line through zero [rad/A]."""
    return float(i_q @ angle / (i_q @ i_q))


def working_current(motor: Motor, line: Floats, share: float) -> float:
    """i_q [A] on the operating line (n, 2) at ``share`` of rated torque, at most its end."""
    tau = torque(motor, line)
    return float(np.interp(share * motor.tau_rated, tau, line[:, 1]))


def cross_curve(motor: Motor, line: Floats, cross: str, share: float) -> Floats:
    """theta_cross [rad] over i_q of the operating line, (CURVE_N,): the angle's correction.

    Parameters
    ----------
    line : array, shape (CURVE_N, 2)
        Currents of the operating line [A].
    cross : str
        ``"none"``; ``"line"``, through zero as in the source paper; ``"table"``; or a file that
        ``sensorless identify cross-coupling`` wrote.
    share : float
        The line is fitted from zero to this share of rated torque.

    Raises
    ------
    UserError
        The file cannot be read or belongs to another machine.
    """
    if cross == "none":
        return np.zeros(CURVE_N)
    if cross == "table":
        return cross_angle(motor, line)
    if cross != "line":
        return load(Path(cross), motor, line[:, 1])
    i_q = working_current(motor, line, share) * np.linspace(0.0, 1.0, POINTS + 1)[1:]
    i_d = np.interp(i_q, line[:, 1], line[:, 0])
    angle = cross_angle(motor, np.stack([i_d, i_q], axis=-1))
    return line[:, 1] * slope_through_zero(i_q, angle)


def load(path: Path, motor: Motor, i_q: Floats) -> Floats:
    """Table of an identified cross-coupling [rad] at ``i_q`` >= 0 [A]; see ``cross_curve``.

    Raises
    ------
    UserError
        The file cannot be read, is damaged, or is of another machine.
    """
    try:
        data: Any = read_json(path)
    except (OSError, ValueError) as error:
        raise UserError(
            f"cross: {path}: {reason(error)}; give a file that sensorless identify cross-coupling "
            "wrote"
        ) from None
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        found = data.get("format") if isinstance(data, dict) else type(data).__name__
        raise UserError(f"cross: {path}: format {found!r} is not {FORMAT!r}; identify it again")
    if data.get("motor_digest") != motor.digest:
        raise UserError(
            f"cross: {path}: measured on machine {data.get('motor')!r}, not on {motor.name!r} as "
            f"it is now, digest {motor.digest[:16]}; identify it again"
        )
    try:
        nodes = np.asarray(data["table"]["i_q_A"], dtype=np.float64)
        angle = np.deg2rad(np.asarray(data["table"]["angle_deg"], dtype=np.float64))
        good = nodes.ndim == 1 and len(nodes) > 1 and nodes.shape == angle.shape
        good = good and bool(np.all(np.diff(nodes) > 0.0) and np.all(np.abs(angle) <= MOST))
    except (KeyError, TypeError, ValueError):
        good = False
    if not good:
        raise UserError(
            f"cross: {path}: table: must hold angles within {math.degrees(MOST):g} degrees over "
            "rising i_q_A; identify it again"
        )
    return np.asarray(np.interp(i_q, nodes, angle))
