"""What a log shows when it is not what it seems: units, signs, delay, by their signature."""

from collections.abc import Iterator

import numpy as np

from sensorless.core.api import Array
from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Motor

CLEAR = 0.5
"""Correlation from which steps of the voltage are the cause of those of the current."""
BETTER = 0.1
"""How much more another delay has to explain."""
CURES = {
    "i_a has the wrong sign: turn it with --map i_a=-i_a": ((-1.0, 0.0), (0.0, 1.0)),
    "i_b has the wrong sign: turn it with --map i_b=-i_b": ((1.0, 0.0), (0.0, -1.0)),
    "u_alpha has the wrong sign: turn it with --map u_alpha=-u_alpha": ((-1.0, 0.0), (1.0, 1.0)),
    "phases a and b of one of them are swapped; swap them with --map i_a=i_b --map i_b=i_a": (
        (0.0, 1.0), (1.0, 0.0),
    ),
    "phases b and c of one of them are swapped, or u_beta has the wrong sign; mend it with --map": (
        (1.0, 0.0), (-1.0, -1.0),
    ),
    "phases a and c of one of them are swapped; swap them with --map": ((-1.0, -1.0), (0.0, 1.0)),
    "u_alpha and u_beta are swapped: --map u_alpha=u_beta --map u_beta=u_alpha": (
        (3.0**-0.5, 2.0 * 3.0**-0.5), (3.0**-0.5, -(3.0**-0.5)),
    ),
}  # fmt: skip
"""What mends currents that turn against the voltage, and the matrix that does so to i_a, i_b."""
ASIDE = 30.0
"""Half of what phases in another order turn the answer by, or what is left to half a turn [deg]."""
PAST = 12
"""Rows before a step that tell what noise and EMF do to the current; 8 tell too little."""
SURE = 50.0
"""Logarithm of how much likelier one sign and delay has to be than another. In right logs of eight
machines a wrong one is, by up to 43 in all but 1 of 114: noise is not all that is unknown."""
AGREES, DIFFERS = 0.9, 0.6
"""Length of the mean of exp(j error) of an encoder that turns with the estimate, or does not."""
TURNED = 2.0 * np.pi
"""Way of the rotor from which its direction shows [rad]."""
SAME_STEP = 0.02
"""Largest deviation of a period from a multiple of the motor's own."""
STEPS = {"s": 1.0, "ms": 1e-3, "µs": 1e-6, "periods": 0.0}
"""Units of time [s]."""


def time_scale(t: Floats, T_s: float) -> tuple[float, str]:
    """Factor of a time column to seconds, and its unit; 1 and "s" if nothing fits."""
    step = usual_step(t) if len(t) > 1 else T_s
    for unit, scale in STEPS.items():
        factor = scale or T_s
        if abs(factor * step - T_s) <= SAME_STEP * T_s:
            return factor, unit
    return 1.0, "s"


def usual_step(t: Floats) -> float:
    """Mean of the steps near their median, which a column of few digits has only roughly."""
    step = np.diff(t)
    middle = float(np.median(step))
    near = step[np.abs(step - middle) <= 0.5 * abs(middle)]
    return float(np.mean(near)) if len(near) else middle


def is_degrees(theta: Floats, T_s: float, omega_max: float) -> bool:
    """Whether an angle is in degrees: it jumps by 360, or turns too fast for radians."""
    steps = np.abs(np.diff(theta))
    if not len(steps) or np.max(np.abs(theta)) <= 2.05 * np.pi:
        return False
    jumps = steps[steps > np.pi]
    if len(jumps) and abs(float(np.median(jumps)) - 360.0) < 40.0:
        return True
    usual = float(np.quantile(steps, 0.9)) / T_s
    return bool(usual > omega_max and np.radians(usual) <= omega_max)


def are_percent(duties: Floats) -> bool:
    """Whether duty cycles (n, 3) are in percent."""
    return bool(1.5 < np.max(duties) <= 101.0 and np.median(duties) > 1.0)


def voltage_steps(u: Floats, i: Floats) -> tuple[Array, Array, Array]:
    """Steps of the voltage (n,) [V], of the current's slope (n,), and that slope (n + 1,) [A].

    Complex, alpha + j beta; the slope is the current's change from a row to the next.

    Parameters
    ----------
    u, i : as in ``of_voltage``
    """
    step, slope = (np.diff(x[:, 0] + 1j * x[:, 1]) for x in (u, i))
    return step[1:], np.diff(slope), slope


def of_voltage(u: Floats, i: Floats, delay: int) -> Iterator[str]:
    """Signs and delay from what steps of the voltage do to the current.

    A step of the voltage changes the slope of the current along with it, whatever the machine.

    Parameters
    ----------
    u : (n, 2) stator voltage [V] over the period before each sample
    i : (n, 2) stator current [A], alpha, beta
    delay : int
        Rows by which the voltage was shifted.
    """
    du, bend, slope = voltage_steps(u, i)
    if len(bend) < 4 * PAST:
        return
    direct, mirrored = [0j], [0.0]
    for lag in (0, -1, 1, 2):
        x, y = apart(du, bend, lag)
        size = max(float(np.linalg.norm(x) * np.linalg.norm(y)), 1e-30)
        direct.append(complex(np.vdot(x, y)) / size)
        mirrored.append(abs(complex(x @ y)) / size)
    most = max(direct, key=abs)
    if max(abs(most), *mirrored) < CLEAR:
        return
    angle = abs(float(np.degrees(np.angle(most))))
    if max(mirrored) > abs(most) + BETTER:
        yield f"voltage and current turn opposite ways: {mirrored_by(*apart(du, bend, 0))}"
    elif ASIDE < angle < 180.0 - ASIDE and not _turns(du):
        yield (
            f"the current answers {angle:.0f} degrees beside the voltage: the phases of one are in "
            "another order; rename them with --map"
        )
    else:
        ways = answered(du, bend, slope, delay)
        if ways[0] != (1, delay):
            cures = " or ".join(_cure(*way, delay) for way in ways)
            yield f"the current does not answer the voltage as it should: {cures}"


def _turns(du: Array) -> bool:
    """Whether steps of the voltage follow each other in direction, as without injection and noise.

    Then they and those of the current turn with the rotor, at an angle that tells nothing.
    """
    return complex(np.vdot(du[:-1], du[1:])).real > 0.5 * float(np.linalg.norm(du)) ** 2


def _cure(sign: int, right: int, delay: int) -> str:
    """What mends a log whose current answers with this sign, and with the delay ``right``."""
    if right < 0:
        return "move the columns of the voltage one row up"
    late = "" if right == delay else f"try --delay {right}"
    turn = "turn the sign of all currents with --map, as in i_a=-i_a"
    return late if sign > 0 else f"{turn}, and {late}" if late else turn


def answered(du: Array, bend: Array, slope: Array, delay: int) -> list[tuple[int, int]]:
    """Signs of the current's answer to the voltage with the delays that explain it, best first.

    An injection that changes sign every row looks alike a row off and with the other sign. What
    tells the two apart is the little that is left, and there a controller sets its voltage against
    the noise that the samples before have bent. So what the ``PAST`` rows of the current tell is
    taken off both first: noise and EMF are in them, and so is all that the controller knew.

    Parameters
    ----------
    du, bend, slope : complex: steps of the voltage (n,) [V], of the current's slope (n,) [A], and
        that slope (n + 1,) [A], as the log has them with this delay
    delay : int
        Rows by which the voltage was shifted; -1 in the result: it acts a row before it stands.
    """
    rows = np.arange(PAST - 1, len(bend) - 3)
    rights = (0, 1, 2, -1)
    known = np.stack([slope[rows - j] for j in range(PAST)], axis=-1)
    new = np.stack([bend[rows], *(du[rows + delay - right] for right in rights)], axis=-1)
    new -= known @ np.linalg.lstsq(known, new, rcond=None)[0]
    y, likely = new[:, 0], {}
    for right, x in zip(rights, new[:, 1:].T, strict=True):
        answer = complex(np.vdot(x, y)) / max(float(np.linalg.norm(x)) ** 2, 1e-30)
        rest = max(float(np.mean(np.abs(y - answer * x) ** 2)), 1e-30)
        if right >= 0 or answer.real > 0.0:  # not two mistakes at once, of signs and a row late
            likely[1 if answer.real > 0.0 else -1, right] = -len(y) * float(np.log(rest))
    ways = [way for way in likely if likely[way] > max(likely.values()) - SURE]
    ways = [way for way in ways if way[0] > 0 or way[1] == delay] or ways  # one mistake, if any
    return sorted(ways, key=lambda way: (way != (1, delay), way[1] not in (0, 1), -likely[way]))


def mirrored_by(du: Array, bend: Array) -> str:
    """Which of ``CURES`` lets the current answer the voltage best.

    Parameters
    ----------
    du, bend : (n,) complex: steps of the voltage [V], and of the current's slope [A]
    """
    phases = np.stack([bend.real, -0.5 * bend.real + 0.75**0.5 * bend.imag])

    def along(matrix: tuple[tuple[float, float], ...]) -> float:
        a, b = np.array(matrix) @ phases
        y = a + 1j * (a + 2.0 * b) / 3.0**0.5
        return complex(np.vdot(du, y)).real / max(float(np.linalg.norm(y)), 1e-30)

    return max(CURES, key=lambda cure: along(CURES[cure]))


def apart(x: Array, y: Array, lag: int) -> tuple[Array, Array]:
    """Values of x beside those of y that stand ``lag`` rows behind them."""
    return x[max(-lag, 0) : len(x) - max(lag, 0)], y[max(lag, 0) : len(y) - max(-lag, 0)]


def of_encoder(theta: Floats, theta_hat: Floats, own: Array, motor: Motor) -> Iterator[str]:
    """Direction, pole pairs and zero of an encoder, beside an estimate where it had a signal."""
    way = float(np.ptp(np.unwrap(theta_hat[own]))) if own.any() else 0.0
    if way < TURNED:
        return
    turn = np.unwrap(theta)
    means = {
        name: complex(np.mean(np.exp(1j * (factor * turn - theta_hat)[own])))
        for name, factor in (
            ("as it is", 1.0), ("turned round", -1.0), ("mechanical", motor.n_p),
            ("mechanical and turned round", -motor.n_p),
        )
    }  # fmt: skip
    best = max(means, key=lambda name: abs(means[name]))
    if abs(means["as it is"]) < DIFFERS and abs(means[best]) > AGREES:
        columns = {
            "turned round": "theta_e=-theta_e",
            "mechanical": "theta_m=theta_e",
            "mechanical and turned round": "theta_m=-theta_e",
        }
        yield f"the encoder's angle fits the estimate if {best}: try --map {columns[best]}"
    elif abs(means["as it is"]) > AGREES:
        offset = float(np.degrees(np.angle(means["as it is"])))
        if abs(offset) > 30.0:
            yield (
                f"the encoder's zero is {offset:.0f} electrical degrees off the magnet, or the "
                "phases are"
            )


def of_injection(u: Floats, inj: Floats, theta: Floats, other: Floats) -> Iterator[str]:
    """Whether the voltage steps against the logged sign of the injection.

    Parameters
    ----------
    u : (n, 2) stator voltage over the period before each sample [V]
    inj : (n,) sign of the injection over it
    theta, other : (n,) angle of the encoder, and another one that does not come from ``inj`` [rad]
    """
    step, turn = np.diff(u[:, 0] + 1j * u[:, 1]), np.diff(inj)
    rows = np.flatnonzero((np.abs(turn) == 2.0) & np.isfinite(other[1:]))
    along = step[rows] * np.sign(turn[rows])
    size = max(float(np.abs(along).sum()), 1e-30)
    known, told = ((along * np.exp(-1j * angle[rows + 1])).real for angle in (theta, other))
    if known.sum() < -AGREES * size and told.sum() < -DIFFERS * size:
        yield (
            f"inj has the wrong sign: in {int((known < 0.0).sum())} of {len(rows)} rows where it "
            "changes, the voltage steps against it: turn it with --map inj=-inj"
        )
