"""What an inverter's switches take from the voltage: thresholds of transistors and diodes."""

from sensorless.machine.motor import Motor

LOW_VOLTAGE = 150.0
"""Below this link voltage, inverters have MOSFETs: short dead times and no threshold [V]."""
U_TRANSISTOR = (0.7, 1.2)
U_DIODE = (0.6, 1.0)
"""Threshold voltages of IGBTs and their diodes [V]; docs/suites-trials.md has the source."""


def threshold_voltage(motor: Motor) -> float:
    """Voltage that the switches of a leg take, against the current [V].

    Half of a transistor's and half of a diode's, as if both conducted equally long: the motor
    file's, or the middle of ``U_TRANSISTOR`` and ``U_DIODE`` where it has none.
    """
    if motor.u_transistor + motor.u_diode > 0.0:
        return 0.5 * (motor.u_transistor + motor.u_diode)
    return 0.25 * (sum(U_TRANSISTOR) + sum(U_DIODE)) if motor.u_dc >= LOW_VOLTAGE else 0.0
