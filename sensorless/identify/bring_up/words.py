"""What a result of the check means, and what to do about it."""

from sensorless.identify.bring_up.check import Found

WIRING = {
    "right": "as it should be",
    "swapped_bc": "phases b and c are swapped",
    "swapped_ab": "phases a and b are swapped",
    "swapped_ca": "phases c and a are swapped",
    "next": "current channel a shows phase b, b shows c",
    "previous": "current channel a shows phase c, b shows a",
    "channel_a": "i_a has the wrong sign",
    "channel_b": "i_b has the wrong sign",
    "unknown": "no swap and no sign explains the currents",
}
"""By the names of WIRING_*."""
CURE = {
    "current": "the current went beyond the limit: look for a scale or a short circuit",
    "moves": "current without voltage: let the shaft come to rest, and correct the sensors' offset",
    "deaf": "hardly any current: is the PWM on, the motor connected, the scale right, and this the "
    "motor of --motor?",
    "delay": "the voltage has to act from one period after its sample to two: move the sample, the "
    "interrupt, or the event that loads the duty registers; a log has to begin with the first "
    "period",
    "sign": "invert both currents, or the duties (an active-low gate driver)",
    "phases": "exchange the phases in the current channels or in the duties, not in both",
    "wiring": "look for a dead current channel, one of another gain, or an open phase",
    "channel": "invert that current channel, or the duty of its phase",
    "scale": "check the duty formula 0.5 + u / u_dc of each leg, the scale of currents and DC "
    "link, and L_d; look for an open phase; a shaft that turns slowly shows like this, too",
    "dead_time": "somebody else compensates dead time: switch that off, or export with "
    "--set dead_time_share=0",
    "state": "the state of the check was damaged, or bring_up_init was not called: repeat it from "
    "there, then look for what overwrites memory",
}
"""By the names of BRING_UP_FAULT_*."""

UNSEEN = frozenset(("current", "moves", "deaf"))
"""Faults that end the check before delay and wiring are measured."""

OTHERS = (
    "not a log of this check: it has pulses, but not when the check of this motor makes them; give "
    "--motor the file of the export that made the log, and every period from the first call of "
    "bring_up_step on"
)
FAR = 10.0
"""Lost voltage over the motor file's beyond which it is none."""


def verdict(found: Found) -> list[str]:
    """Lines for the screen: what was measured, then each fault and its cure.

    Of a log with other pulses nothing else is told: it says nothing about this motor.
    """
    if found.other_pulses:
        return [OTHERS]
    lines, cure = [], dict(CURE)
    if "sign" in found.faults and found.wiring == "right":
        wiring = "the order is right"
    else:
        wiring = WIRING[found.wiring]
    if not UNSEEN.intersection(found.faults):
        lines = [f"delay {found.delay:.2f} periods (right: 1.00); wiring: {wiring}"]
    if "phases" in found.faults:
        cure["sign"] += "; or is one duty alone inverted?"
    if found.scale and not abs(found.lost) <= FAR:
        lines.append(
            f"voltage {100.0 * found.scale:.0f} % of the commanded one; neither dead time nor "
            "resistance can be told from such currents: is --motor the file of the export?"
        )
    elif found.scale:
        lost = "not judged" if found.lost == 1.0 else f"{100.0 * found.lost:.0f} %"
        lines.append(
            f"voltage {100.0 * found.scale:.0f} % of the commanded one; lost by dead time, over "
            f"the motor file's: {lost}; resistance {found.R_s:.3g} ohm"
        )
    lines += [f"{name}: {cure[name]}" for name in found.faults]
    return lines if found.faults else [*lines, "integrated correctly, as far as the check can see"]
