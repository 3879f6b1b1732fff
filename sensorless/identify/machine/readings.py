"""Whether a log's currents are those that its voltages drive: signs, order, scale, row, limit."""

from collections.abc import Iterator, Sequence

import numpy as np

from sensorless.errors import UserError
from sensorless.identify.machine.electric import Complex, Sensors
from sensorless.identify.machine.log import Part
from sensorless.identify.machine.nameplate import Nameplate
from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Motor

PULSED = ("probe", "axis", "pulse")
"""Stages whose voltage jumps while the rotor stands."""
ANSWERS = {
    "": (1.0, -0.5),
    "i_a has the wrong sign": (-1.0, -0.5),
    "i_b has the wrong sign": (1.0, 0.5),
    "both currents have the wrong sign, or the voltage has": (-1.0, 0.5),
    "i_a and i_b are swapped": (-0.5, 1.0),
    "phases a and c are swapped": (-0.5, -0.5),
}
"""What i_a and i_b do under a voltage along phase a, by what is wrong; at rest a right log has
i_b = -i_a / 2."""
GAINS = 1.4
"""Largest quotient of both channels' gains that is no other scale: sensors differ by percent."""
LAGS = (0, -1, 1, 2)
"""Rows that the voltage may stand too late (above 0) or too early."""


def require_answers(parts: Sequence[Part], motor: Motor, where: str) -> None:
    """Refuse a log whose currents do not answer its voltages, or that a current limit ended.

    Raises
    ------
    UserError
        What is wrong, and the cure.
    """
    for said in (*_at_rest(parts), *_in_pulses(parts), *_beyond(parts, motor)):
        raise UserError(f"{where}: {said}")


def _beyond(parts: Sequence[Part], motor: Motor) -> Iterator[str]:
    """A part with a current at which a test stops, so that its end is missing."""
    limit = Nameplate.of(motor).i_limit
    for part in parts:
        over = np.flatnonzero(np.abs(Sensors().current(part)) > limit)
        if len(over):
            yield (
                f"stage {part.stage}: current above {limit:.3g} A in row {over[0]} of the stage, "
                "where the test stops; check the motor file's rated current and voltage, and that "
                "the next command starts from the voltage at which the last one ended"
            )


def _at_rest(parts: Sequence[Part]) -> Iterator[str]:
    """Signs and order of the channels, from the held voltages along phase a."""
    held = [p for p in parts if p.stage == "hold" and len(p.rows) > 1]
    if not held:
        return
    names = ("u_alpha", "u_beta", "i_a", "i_b")
    u, beside, a, b = (np.concatenate([p[name] for p in held]) for name in names)
    if beside @ beside > u @ u:
        yield "the held voltages lie along u_beta: u_alpha and u_beta are swapped; mend the columns"
    u = u - u.mean()
    answer = np.array([u @ a, u @ b])
    size = float(np.hypot(*answer))
    if size == 0.0:
        return
    wrong = max(ANSWERS, key=lambda w: float(answer @ ANSWERS[w]) / float(np.hypot(*ANSWERS[w])))
    if wrong:
        yield f"under a voltage along phase a, {wrong}; mend the columns"
    elif not 1.0 / GAINS < (share := -2.0 * answer[1] / answer[0]) < GAINS:
        yield (
            f"under a voltage along phase a, i_b is {share:.2g} times -i_a / 2; check the scale of "
            "both channels"
        )


def _in_pulses(parts: Sequence[Part]) -> Iterator[str]:
    """Order of the phases and the row of the voltage, from its jumps.

    A jump of the voltage bends the current along it, g du, and by the saliency to the mirrored
    side, G exp(2j theta) conj(du) with G < g, in the row in which it acts.
    """
    pulsed = [p for p in parts if p.stage in PULSED and len(p.rows) > 2 * len(LAGS)]
    direct, mirrored = (np.zeros(len(LAGS)) for _ in range(2))
    for part in pulsed:
        du, bend = np.diff(part.u)[:-1], np.diff(Sensors().current(part), 2)
        for k, lag in enumerate(LAGS):
            x, y = _beside(du, bend, lag)
            direct[k] += float(np.vdot(x, y).real)
            mirrored[k] += abs(complex(x @ y))
    if not pulsed:
        return
    if mirrored.max() > np.abs(direct).max():
        yield (
            "the current turns against the voltage: u_beta has the wrong sign, or two phases are "
            "swapped; mend the columns"
        )
    elif lag := LAGS[int(np.abs(direct).argmax())]:
        way = (
            "late; move u_alpha and u_beta up" if lag > 0 else "early; move u_alpha and u_beta down"
        )
        rows = "a row" if abs(lag) == 1 else f"{abs(lag)} rows"
        yield (
            f"the voltage stands {rows} too {way} by as much: a row has the voltage that acts from "
            "its sample to the next"
        )


def _beside(x: Complex | Floats, y: Complex | Floats, lag: int) -> tuple[Complex, Complex]:
    """Values of x that stand ``lag`` rows after those of y."""
    n = len(x) - abs(lag)
    return np.asarray(x[max(lag, 0) :][:n]), np.asarray(y[max(-lag, 0) :][:n])
