"""Resistance and the inverter's lost voltage, from direct currents along phase a.

With a current I in phase a and -I/2 in the others, and the rotor at rest,
u = R_s I + 2/3 (v(I) + v(I/2)) + c, where v is the lost voltage of a leg and c what is left of
offsets. Currents of both signs and many sizes tell the three apart (doi 10.1109/TIA.2016.2644624
takes v as measured before; here the same data give it).
"""

from dataclasses import dataclass

import numpy as np

from sensorless.errors import UserError
from sensorless.identify.machine.electric import Inverter, Sensors, rms, windows
from sensorless.identify.machine.nameplate import Nameplate
from sensorless.identify.machine.source import Source, volts
from sensorless.machine.magnetics import Floats

LEVELS = (1.0, 0.8, 0.6, 0.45, 0.3, 0.2, 0.1)
"""Currents over rated."""
SETTLE, WINDOW, TURN = 0.25, 0.1, 0.25
"""Time at a level before its mean is taken, length of it, least time of a quarter turn [s]."""
WAITS = (0.02, 0.1)
"""Currents over rated at which the ramp waits for the rotor."""
WAIT_SLOPE, WAIT_TIME = 0.003, 6.0
"""Slope of the ramp between them over the largest phase voltage [1/s], most time for it [s]."""
REACHED = 0.9
"""Current over rated that counts as rated: from there up no two levels differ enough."""
GROWTH, GROWTH_TIME = 1.25, 0.4
"""Ratio by which the voltage of the ramp grows, and the time for it [s]."""
EMF_SHARE = 0.3
"""EMF of the slow turn over the voltage across the resistance at rated current."""
ENOUGH = 0.7
"""Share of the levels that have to settle."""
STEADY = 0.004
"""Most change of the current within a window over rated current; more in the longest windows."""
ZEROS = np.geomspace(0.002, 0.3, 120)
"""Ends of the lost voltage's slope over rated current that are tried."""


@dataclass(frozen=True)
class Resistance:
    """Result of the holds."""

    R_s: float
    """[ohm]"""
    R_std: float
    """standard deviation by the residuals [ohm]"""
    inverter: Inverter
    sensors: Sensors
    residual: float
    """RMS of the voltage left over [V]"""
    i: Floats
    """(n,) currents along phase a [A]"""
    u: Floats
    """(n,) voltages commanded [V]"""


def measure_offsets(source: Source) -> Sensors:
    """Offsets of the channels, with no voltage."""
    part = source.run("offset", [volts(0.05, 0.0)])
    return Sensors((float(part["i_a"].mean()), float(part["i_b"].mean())))


def measure_resistance(source: Source, plate: Nameplate, sensors: Sensors) -> Resistance:
    """Ramp to rated current, then hold currents of both signs.

    Raises
    ------
    UserError
        The current does not reach rated current, or never settles.
    """
    i, u = _ramp(source, plate, sensors)
    if i.max() < REACHED * plate.i_rated:
        raise UserError(
            f"resistance: {i.max():.3g} A at {u.max():.3g} V, not rated current "
            f"({plate.i_rated:.3g} A, peak); check the wiring, the name plate's current, and of a "
            "log that it is whole and has peak values"
        )
    order = np.maximum.accumulate(i)
    levels = [float(u[np.argmax(order >= min(f * plate.i_rated, order[-1]))]) for f in LEVELS]
    turn = quarter(plate, (levels[0] - levels[-1]) / (LEVELS[0] - LEVELS[-1]))
    for stretch in (1.0, 3.0, 9.0):
        means = np.concatenate(
            [
                _held(source, plate, sensors, levels, stretch),
                _turned(source, plate, sensors, levels, stretch, turn),
            ]
        )
        steady = means[:, 3] < STEADY * max(1.0, stretch / 3.0) * plate.i_rated
        if np.mean(steady) >= ENOUGH:
            return fit_resistance(means[steady, :3], sensors, plate)
    raise UserError("resistance: the rotor does not come to rest; free it from its load")


def _ramp(source: Source, plate: Nameplate, sensors: Sensors) -> tuple[Floats, Floats]:
    """Raise the voltage until rated current flows; currents and voltages along phase a.

    A rotor that starts far from phase a swings there with an EMF that the small resistance does not
    hold back. So the current first waits while it is small, twice, and then grows by a fixed ratio.
    Where L/R_s is long, the voltage runs ahead of the current. If it drives rated current, the part
    of it goes on that drives the current of the last wait at most, as some voltage is lost.
    """
    base, i = plate.u_base, plate.i_rated
    part = source.run("ramp", [volts(2.0, 0.0, end=0.2 * base, until=WAITS[0] * i)])
    for wait in WAITS[1:]:
        u = max(float(part.u.real[-1]), 1e-3 * base)
        end = u + WAIT_TIME * WAIT_SLOPE * base
        part = source.run(
            "ramp", [volts(1.5, u, until=i), volts(WAIT_TIME, u, end=end, until=wait * i)]
        )
    u = max(float(part.u.real[-1]), 1e-3 * base)
    flowing = float(sensors.current(part).real[-1])
    if flowing >= REACHED * i:
        u *= WAITS[-1] * i / flowing
        source.run("ramp", [volts(2.0, u)])
    commands = [volts(2.0, u)]
    while u < 0.6 * base:
        commands.append(volts(GROWTH_TIME, u, end=GROWTH * u, until=i))
        u *= GROWTH
    part = source.run("ramp", commands)
    return sensors.current(part).real, part.u.real


def quarter(plate: Nameplate, u: float) -> float:
    """Time of a quarter turn [s] whose EMF stays well below the voltage u [V] across R_s."""
    speed = EMF_SHARE * max(u, 1e-4 * plate.u_base) / plate.u_base * plate.omega
    return max(TURN, 0.5 * np.pi / speed)


def _held(
    source: Source, plate: Nameplate, sensors: Sensors, levels: list[float], stretch: float
) -> Floats:
    """Hold voltages in turn; rows of voltage, both channels and the current's drift."""
    time = stretch * (SETTLE + WINDOW)
    part = source.run("hold", [volts(time, u) for u in (levels[0], *levels)])
    i = sensors.current(part)
    out = []
    for w in windows(part, stretch * WINDOW, plate.T_s):
        if w.stop - w.start < 2:
            raise UserError("stage hold: a command has a single row; measure it to its end")
        a, b = np.array_split(i[w], 2)
        out.append(
            [
                part.u.real[w].mean(),
                part["i_a"][w].mean(),
                part["i_b"][w].mean(),
                abs(a.mean() - b.mean()),
            ]
        )
    return np.array(out)


def _turned(
    source: Source,
    plate: Nameplate,
    sensors: Sensors,
    levels: list[float],
    stretch: float,
    turn: float,
) -> Floats:
    """Turn the rotor by half a turn, then hold the levels with the other sign.

    The turn is slow: a current that jumped to the other side would find the rotor balanced there.
    """
    speed = np.pi / turn
    source.run(
        "turn",
        [
            volts(turn, levels[0]),
            volts(turn, levels[0], None, omega=(0.0, speed)),
            volts(turn, levels[0], None, omega=(speed, 0.0)),
        ],
    )
    return _held(source, plate, sensors, [-u for u in levels], stretch)


def fit_resistance(means: Floats, sensors: Sensors, plate: Nameplate) -> Resistance:
    """Least squares over means (n, 3) of voltage and both channels; ``i_zero`` is searched.

    Raises
    ------
    UserError
        The resistance found is not above zero, or a current has the wrong sign.
    """
    u = means[:, 0]
    a, b = means[:, 1] - sensors.offset[0], means[:, 2] - sensors.offset[1]
    ratio = float(-2.0 * (a @ b) / (a @ a))
    if not ratio > 0.0:
        raise UserError(
            "resistance: with the voltage along phase a, i_b should be half of -i_a, and has the "
            "sign of i_a: one current has the wrong sign"
        )
    sensors = Sensors(sensors.offset, ratio)
    i = a * np.sqrt(sensors.ratio)
    best = None
    for share in ZEROS:
        i_zero = share * plate.i_rated
        lost = sum(np.clip(x / i_zero, -1.0, 1.0) for x in (i, 0.5 * i))
        matrix = np.stack([i, 2.0 / 3.0 * lost, np.ones(len(i))], axis=-1)
        x = np.linalg.lstsq(matrix, u, rcond=None)[0]
        left = u - matrix @ x
        if best is None or left @ left < best[0]:
            best = (float(left @ left), i_zero, x, left, matrix)
    assert best is not None
    cost, i_zero, x, left, matrix = best
    if x[0] <= 0.0:
        raise UserError(f"resistance: {x[0]:.3g} ohm found; check the wiring")
    spread = np.linalg.inv(matrix.T @ matrix)[0, 0] * cost / (len(u) - 4)
    return Resistance(
        R_s=float(x[0]),
        R_std=float(np.sqrt(spread)),
        inverter=Inverter(max(float(x[1]), 0.0), float(i_zero)),
        sensors=sensors,
        residual=rms(left),
        i=i,
        u=u,
    )
