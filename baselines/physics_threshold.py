"""Hard switch at the speed whose back-EMF exceeds the voltages that the drive does not know.

    omega_1 = (share R_s i_max + u_dt) / psi_f,   u_dt = u_dc dead_time / T_s

share = 0.2 is the usual uncertainty of the resistance; u_dt is the mean voltage that a phase loses
to the dead time. The phobia firmware computes its threshold in this way.
"""

from math import inf

from sensorless.baselines.hysteresis import Hysteresis
from sensorless.baselines.rule import Parameter, Rule, Values
from sensorless.machine.motor import Motor


def physics_speed(share: float, motor: Motor) -> float:
    """Threshold omega_1 over rated speed [-]."""
    unknown = share * motor.R_s * motor.i_max + motor.dead_time_voltage
    return unknown / (motor.psi_f * motor.omega_rated)


def _build(name: str, v: Values, motor: Motor) -> Hysteresis:
    centre, gap = physics_speed(v["share"], motor), 0.01 * v["gap"]
    return Hysteresis(name, (1.0 - gap) * centre, (1.0 + gap) * centre)


RULE = Rule(
    "physics",
    "hard switch at the speed (SHARE R_s i_max + dead-time voltage) / psi_f, +-GAP %",
    _build,
    (
        Parameter(
            "share",
            0.2,
            "1",
            0,
            inf,
            "unknown part of the resistance over the known resistance",
            search=(0.0, 10.0),
        ),
        Parameter("gap", 5.0, "%", 0.1, 90, "half the gap", search=(1.0, 50.0)),
    ),
)
