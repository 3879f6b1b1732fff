"""From a datasheet to the numbers of a motor file, each with its source."""

import math
from dataclasses import dataclass

from sensorless.errors import UserError
from sensorless.machine.motor import Motor
from sensorless.settings import settings_of
from sensorless.units import RPM_TO_RAD_S

KE_KINDS = {"rms": math.sqrt(2.0), "peak": 1.0}
"""Whether Ke counts the RMS or the peak line-to-line voltage; factor to the peak."""
KT_KINDS = {"rms": 1.0 / math.sqrt(2.0), "peak": 1.0}
"""Whether Kt counts the RMS or the peak current; factor to newton metres per peak ampere."""
BETWEEN = {"line": 0.5, "phase": 1.0}
"""Where R and L are measured: between two terminals of a star, or on one phase."""
INERTIA = {"kgm2": 1.0, "kgcm2": 1e-4, "gm2": 1e-3, "gcm2": 1e-7}
"""Factors of units of inertia to kg m^2."""
UNITS = {
    "poles": "", "speed": "r/min", "current": "A", "power": "W", "torque": "N m", "r": "ohm",
    "ke": "V", "kt": "N m/A", "l-d": "H", "l-q": "H", "l": "H", "ratio": "", "inertia": "kg m2",
    "u-dc": "V", "pwm": "Hz", "adc-range": "A", "u-inj": "V",
}  # fmt: skip
"""Numbers of a sheet and an inverter, as ``sensorless motor new`` names them."""
ROUNDED = 0.05
"""Largest relative difference of two numbers of one sheet that rounding explains."""
TOLERANCE = 0.15
"""Largest relative difference of Ke, at no load and cold, and Kt, at rated torque."""


@dataclass(frozen=True)
class Number:
    """One number of a motor file, and its source."""

    value: float
    source: str


@dataclass(frozen=True)
class Datasheet:
    """What the sheet says, None where it says nothing; ``machine_numbers`` checks it."""

    poles: int
    speed_rpm: float
    current_rms: float
    R: float
    ke: float | None = None
    """V per 1000 r/min, line to line"""
    ke_kind: str = "rms"
    kt: float | None = None
    """N m/A"""
    kt_kind: str = "rms"
    between: str = "line"
    L_d: float | None = None
    L_q: float | None = None
    L: float | None = None
    """average of both axes [H]"""
    ratio: float | None = None
    """L_q / L_d, which goes with ``L``"""
    power: float | None = None
    torque: float | None = None
    inertia: float | None = None
    """[kg m^2]"""


def inertia_from(text: str) -> float:
    """Inertia [kg m^2] from a text like ``320 g cm2`` or ``1.2kgcm2``.

    Raises
    ------
    UserError
        The text is not a number with a unit of ``INERTIA``.
    """
    word = text.replace("²", "2").replace("^", "").replace("*", "").replace("·", "")
    word = "".join(word.lower().split())
    unit = next((u for u in sorted(INERTIA, key=len, reverse=True) if word.endswith(u)), "")
    try:
        return float(word.removesuffix(unit)) * INERTIA[unit]
    except (KeyError, ValueError):
        raise UserError(
            f"inertia: {text!r}; give a number such as 0.5 with its unit, one of "
            f"{', '.join(INERTIA)}"
        ) from None


def check_number(name: str, value: float) -> None:
    """Check one number of a sheet or an inverter, named as in ``UNITS``, without the others.

    Raises
    ------
    UserError
        Names the number, its value, and what to give.
    """
    period, pairs = settings_of(Motor)["T_s"], settings_of(Motor)["n_p"]
    if name == "poles":
        if not (value >= 2 and value % 2 == 0 and pairs.low <= value / 2 <= pairs.high):
            most = 2 * pairs.high
            raise UserError(f"poles: {value:g}; give twice the pole pairs: 2, 4, 6, ..., {most:g}")
        return
    if not (math.isfinite(value) and value > 0.0):
        bare = "; a machine without magnets is none for this drive" if name in ("ke", "kt") else ""
        raise UserError(f"{name}: {value:g} {UNITS[name]}; give a finite number above 0{bare}")
    if name == "pwm" and not period.low <= 1.0 / value <= period.high:
        raise UserError(f"pwm: {value:g} Hz; give {1.0 / period.high:g} to {1.0 / period.low:g} Hz")


def check_words(ke_kind: str, kt_kind: str, between: str) -> None:
    """Check how a sheet counts its numbers.

    Raises
    ------
    UserError
        Names the word, and those to choose from.
    """
    for name, value, known in (
        ("ke-kind", ke_kind, KE_KINDS),
        ("kt-kind", kt_kind, KT_KINDS),
        ("between", between, BETWEEN),
    ):
        if value not in known:
            raise UserError(f"{name}: {value!r}; choose from {', '.join(known)}")


def machine_numbers(s: Datasheet) -> dict[str, Number]:
    """Fields of [machine] and [rating] that the sheet determines.

    Raises
    ------
    UserError
        A number is missing, or two numbers contradict each other; the message has both.
    """
    check_number("poles", s.poles)
    check_words(s.ke_kind, s.kt_kind, s.between)
    n_p = s.poles // 2
    L_d, L_q = _inductances(s)
    share, measured = BETWEEN[s.between], f"datasheet, {s.between}"
    halved = ", halved" if s.between == "line" else ""
    torque = _torque(s)
    numbers = {
        "n_p": Number(n_p, f"datasheet: {s.poles} poles"),
        "R_s": Number(share * s.R, f"{measured}: {s.R:g} ohm{halved}; cold, unless it says hot"),
        "L_d": L_d,
        "L_q": L_q,
        "psi_f": _magnet(s, n_p),
        "tau_rated": torque,
        "i_rated": Number(
            math.sqrt(2.0) * s.current_rms, f"datasheet: {s.current_rms:g} A RMS, peak value"
        ),
        "n_rated_rpm": Number(s.speed_rpm, "datasheet"),
    }
    if s.inertia is not None:
        numbers["J"] = Number(s.inertia, "datasheet: the rotor alone; add the load's")
    return numbers


def _inductances(s: Datasheet) -> tuple[Number, Number]:
    share, said = BETWEEN[s.between], f"datasheet, {s.between}"
    halved = ", halved" if s.between == "line" else ""
    if s.L_d is not None and s.L_q is not None:
        if s.L is not None or s.ratio is not None:
            raise UserError("l, ratio: given in addition to l-d and l-q; give one of the two pairs")
        return (
            Number(share * s.L_d, f"{said}: {s.L_d:g} H{halved}"),
            Number(share * s.L_q, f"{said}: {s.L_q:g} H{halved}"),
        )
    if s.L is None or s.ratio is None or s.L_d is not None or s.L_q is not None:
        raise UserError(
            "inductance: incomplete; give l-d and l-q, or the average l and ratio = L_q / L_d; a "
            "sheet that has one inductance alone is usually that of surface magnets, ratio 1"
        )
    how = f"{said}: average {s.L:g} H{halved}, L_q / L_d = {s.ratio:g} as given"
    L_d = 2.0 * share * s.L / (1.0 + s.ratio)
    return Number(L_d, how), Number(s.ratio * L_d, how)


def _magnet(s: Datasheet, n_p: int) -> Number:
    """Magnet flux linkage [Vs] from Ke, else from Kt; where both are given they must agree.

    A Kt may be that of the magnet alone, or torque over current at the rated point, which has the
    reluctance's torque in it. Kt alone is the latter if it is the sheet's own torque over current.
    """
    from_ke = from_kt = rated = None
    if s.ke is not None:
        volt = s.ke * KE_KINDS[s.ke_kind] / math.sqrt(3.0)
        from_ke = volt / (n_p * 1000.0 * RPM_TO_RAD_S)
    if s.kt is not None:
        from_kt = s.kt * KT_KINDS[s.kt_kind] / (1.5 * n_p)
        rated = _beside_reluctance(s, from_kt)
    if from_ke is not None and from_kt is not None:
        known, likely = from_ke, _likely(from_kt / from_ke)
        from_kt = min((from_kt, rated or from_kt), key=lambda x: abs(x / known - 1.0))
        off = from_kt / from_ke
        if abs(off - 1.0) > TOLERANCE:
            raise UserError(
                f"ke, kt: Ke = {s.ke:g} V/krpm ({s.ke_kind}) is a magnet flux of {from_ke:.4g} Vs, "
                f"Kt = {s.kt:g} N m/A ({s.kt_kind}) one of {from_kt:.4g} Vs, {off:.3g} times as "
                f"much{likely}; correct one (they may differ by {100 * TOLERANCE:.0f} %), or "
                "give only one"
            )
    if from_ke is not None:
        beside = f"; Kt gives {from_kt:.4g} Vs" if from_kt is not None else ""
        return Number(from_ke, f"datasheet: Ke = {s.ke:g} V/krpm line to line {s.ke_kind}{beside}")
    if from_kt is not None:
        told = f"datasheet: Kt = {s.kt:g} N m/A {s.kt_kind}, "
        if rated is not None and _is_rated(s):
            return Number(rated, told + "torque over current: less what L_q - L_d makes of it")
        return Number(from_kt, told + "taken as the magnet's alone")
    raise UserError("ke, kt: none given; give at least one of them")


def _is_rated(s: Datasheet) -> bool:
    """Whether the sheet's Kt is its torque over its current."""
    amperes = s.current_rms * KT_KINDS[s.kt_kind] / KT_KINDS["rms"]
    return s.kt is not None and abs(s.kt * amperes / _torque(s).value - 1.0) <= ROUNDED


def _beside_reluctance(s: Datasheet, psi: float) -> float | None:
    """Magnet flux [Vs] that makes, beside reluctance, the torque that ``psi`` would make alone.

    At rated current i and the angle of most torque, i_d = (x - sqrt(x^2 + 8 (D i)^2)) / (4 D) with
    D = L_q - L_d and the flux x: psi i = (x - D i_d) sqrt(i^2 - i_d^2). None if reluctance alone
    makes more.
    """
    from scipy.optimize import brentq

    D = _inductances(s)[1].value - _inductances(s)[0].value
    i = math.sqrt(2.0) * s.current_rms
    if not D > 0.0:
        return psi

    def excess(x: float) -> float:
        i_d = (x - math.sqrt(x * x + 8.0 * (D * i) ** 2)) / (4.0 * D)
        return (x - D * i_d) * math.sqrt(max(i * i - i_d * i_d, 0.0)) - psi * i

    return None if excess(0.0) >= 0.0 else float(brentq(excess, 0.0, psi))


def _likely(off: float) -> str:
    """A usual mistake that explains this factor."""
    usual = {
        "RMS and peak are mixed": math.sqrt(2.0),
        "line and phase are mixed": math.sqrt(3.0),
        "both RMS with peak and line with phase are mixed": math.sqrt(6.0),
    }
    for text, factor in usual.items():
        if any(abs(off / f - 1.0) < 0.06 for f in (factor, 1.0 / factor)):
            return f" ({text}?)"
    return ""


def _torque(s: Datasheet) -> Number:
    omega = s.speed_rpm * RPM_TO_RAD_S
    if s.power is None and s.torque is None:
        raise UserError("power, torque: none given; give at least one of them")
    if s.torque is None:
        assert s.power is not None
        return Number(s.power / omega, f"datasheet: {s.power:g} W at {s.speed_rpm:g} r/min")
    if s.power is not None and abs(s.torque * omega / s.power - 1.0) > ROUNDED:
        raise UserError(
            f"power, torque: {s.power:g} W at {s.speed_rpm:g} r/min is {s.power / omega:.4g} N m, "
            f"but the torque given is {s.torque:g} N m; correct one (they may differ by "
            f"{100 * ROUNDED:.0f} %), or give only one"
        )
    return Number(s.torque, "datasheet")
