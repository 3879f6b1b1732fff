"""The abstract's torque ripple while switching: hard switch against blend under load."""

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from sensorless.core.api import Array
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.evaluation.steady import Change, constant, make_ideal
from sensorless.evaluation.trace import Trace, lost_cause, trace, without_injection
from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Motor
from sensorless.plots.paper import hand_over
from sensorless.plots.paper_values import PaperValue
from sensorless.policies.registry import make_policy
from sensorless.reproduce.case import CORRECTED, PUBLISHED, Case, Cell, Row, row_of
from sensorless.reproduce.steady import less
from sensorless.units import RPM_TO_RAD_S

HARD = "hysteresis:332.5,367.5"
"""Switch at 350 r/min, +-5 %."""
RULES = {"hard switch": HARD, "blend (Eq. 25)": "eq25"}
WAYS = {"up": (1.0, 3.0), "down": (3.0, 5.0)}
"""Start and end of each crossing [s]."""
LESS = 45.0
"""Torque ripple that the paper's blend takes away [%]."""
REPEATS = 16
"""Runs with real sensors, each with its own noise."""
AROUND = 0.25
"""Half the window of the mean run [s]; the blend takes 0.33 s to cross."""
Pair = dict[str, Trace]


def crossing(motor: Motor, seed: int) -> Scenarios:
    """200, 600, 200 r/min at 300 r/min/s under 4 N m; ``seed`` draws the noise."""
    s = constant(motor, np.array([200.0]), np.array([4.0 / 14.0 * motor.tau_rated]), 5.0, seed)
    s.t[:, 2:4] = (WAYS["up"][0], WAYS["down"][0])
    s.omega[:, 2], s.omega[:, 3:] = 600.0 * RPM_TO_RAD_S, 200.0 * RPM_TO_RAD_S
    s.omega_rate[:] = 300.0 * RPM_TO_RAD_S
    return s


def run(motor: Motor, design: DriveDesign, seed: int, change: Change | None = None) -> Pair:
    """Run both rules through one crossing; the slew limit of k_s does not slow the hard switch."""
    at_once = dataclasses.replace(design, k_s_slew=5000.0)
    return {
        name: trace(
            make_policy(word, motor),
            crossing(motor, seed),
            motor,
            at_once if word == HARD else design,
            change,
        )
        for name, word in RULES.items()
    }


def quiet(sims: Array) -> None:
    """Remove the noise; resolution and dead time stay."""
    sims["sensor"]["noise_rms"] = 0.0


def in_band(t: Trace, way: str) -> Array:
    """Periods of a crossing between 300 and 400 r/min, (periods,) bool."""
    start, stop = WAYS[way]
    rpm = np.abs(t["omega_m"]) / RPM_TO_RAD_S
    return np.asarray((t["t"] >= start) & (t["t"] < stop) & (rpm > 300.0) & (rpm < 400.0))


def torque_span(t: Trace, way: str) -> float:
    """Peak-to-peak torque [N m] between 300 and 400 r/min; NaN if lost."""
    inside = in_band(t, way)
    if not inside.any() or (lost_cause(t) is not None and t["t"][-1] < WAYS[way][1]):
        return math.nan
    return float(np.ptp(without_injection(t)[inside]))


def claimed(pair: Pair) -> list[PaperValue]:
    """Lines as far apart as the paper says a blend leaves of the hard switch's torque."""
    lines = []
    for way in WAYS:
        left = 0.5 * (1.0 - 0.01 * LESS) * torque_span(pair["hard switch"], way)
        inside = in_band(pair["blend (Eq. 25)"], way)
        if not inside.any() or not math.isfinite(left):
            continue
        t = pair["blend (Eq. 25)"]["t"][inside]
        centre = float(np.median(without_injection(pair["blend (Eq. 25)"])[inside]))
        span = (float(t[0]), float(t[-1]))
        label = f"paper: {LESS:g} % less than the hard switch"
        lines += [PaperValue(centre + x, label, span) for x in (-left, left)]
    return lines


def around_switch(t: Trace, way: str) -> Floats:
    """Torque [N m] from ``AROUND`` before to ``AROUND`` after the weight passes one half."""
    start, stop = WAYS[way]
    T_s = float(t["t"][1] - t["t"][0])
    first, n = round(start / T_s), round(AROUND / T_s)
    k_s = t["k_s"][first : round(stop / T_s)]
    at = first + int(np.argmax(k_s < 0.5 if way == "up" else k_s > 0.5))
    return without_injection(t)[at - n : at + n]


@dataclass(frozen=True)
class Repeated:
    """Crossings with real sensors, by rule and way."""

    span: dict[tuple[str, str], float]
    """median of the single runs' peak to peak [N m]"""
    mean_span: dict[tuple[str, str], float]
    """peak to peak of the mean run, aligned at the switch [N m]"""
    spread: float
    """RMS between the runs [N m]: noise, not hand-over"""


def repeated(motor: Motor, design: DriveDesign) -> Repeated:
    """Run ``REPEATS`` crossings; all NaN if any of them is lost."""
    pairs = [run(motor, design, seed) for seed in range(REPEATS)]
    if any(lost_cause(t) is not None for pair in pairs for t in pair.values()):
        nothing = {(rule, way): math.nan for rule in RULES for way in WAYS}
        return Repeated(nothing, nothing, math.nan)
    span, mean_span, spread = {}, {}, []
    for rule in RULES:
        for way in WAYS:
            runs = np.array([around_switch(pair[rule], way) for pair in pairs])
            span[rule, way] = float(np.median([torque_span(pair[rule], way) for pair in pairs]))
            mean_span[rule, way] = float(np.ptp(runs.mean(axis=0)))
            spread.append(float(np.mean(runs.var(axis=0))))
    return Repeated(span, mean_span, math.sqrt(float(np.mean(spread))))


def switching(motor: Motor) -> Case:
    """Torque while the drive crosses the band at 4 N m, hard switch against blend."""
    designs = (dataclasses.replace(PUBLISHED, speed_hz=2.0), CORRECTED)
    exact = [run(motor, design, 0, make_ideal) for design in designs]
    silent = [run(motor, design, 0, quiet) for design in designs]
    noisy = [repeated(motor, design) for design in designs]
    hard, blend = RULES
    rows: list[Row] = []

    def add(what: str, way: str, spans: list[dict[tuple[str, str], float]]) -> None:
        for rule in RULES:
            name = "hard switch" if rule == hard else "blend"
            cells: list[Cell] = [span[rule, way] for span in spans]
            rows.append(row_of(f"{what}, {name}, {way}", "N m", "–", cells))
        cut: list[Cell] = [less(span[hard, way], span[blend, way]) for span in spans]
        rows.append(row_of(f"{what}: blend less by, {way}", "%", f"{LESS:g}", cut, 0))

    for way in WAYS:
        for what, pairs in (("exact sensors", exact), ("12 bits and dead time", silent)):
            spans = [{(rule, way): torque_span(t, way) for rule, t in p.items()} for p in pairs]
            add(what, way, spans)
        add("real sensors, mean run", way, [r.mean_span for r in noisy])
        add("real sensors, single run", way, [r.span for r in noisy])
    rows.append(
        row_of("RMS of the torque between runs", "N m", "–", [r.spread for r in noisy]),
    )
    return Case(
        "switching",
        "Abstract: torque ripple while switching less by 45 %",
        "200, 600, 200 r/min at 300 r/min/s, 4 N m; torque peak to peak without the injection "
        "band. Exact sensors and single runs: between 300 and 400 r/min. Real sensors: 5 mA "
        f"noise, 12 bits and dead time, {REPEATS} runs that differ in noise; single run is their "
        f"median, mean run the peak to peak of their mean within {AROUND:g} s of the switch. The "
        "hard switch is at 350 r/min ± 5 %; the published drive has a speed loop of 2 Hz",
        tuple(rows),
        "The published estimators disagree: injection leads because of cross-coupling, the "
        "observer lags. A hard switch makes a step of that difference, a blend spreads it. The "
        "corrected estimators agree better, except for the observer's L_q, which is biased low on "
        "purpose, for robustness. With real sensors a single run shows a smaller difference: the 5 "
        "mA of current noise, an assumption, pass PLLs and speed controller and become torque at "
        "all times and under either rule, as slow as the hand-over, so that no filter separates "
        "the two. The mean of many runs does: what is left belongs to the hand-over, and the blend "
        "removes it. Resolution and dead time alone do not hide it.",
        hand_over(
            dict(zip(("published", "corrected"), exact, strict=True)),
            "200, 600, 200 r/min with 4 N m, exact sensors",
            {name: claimed(p) for name, p in zip(("published", "corrected"), exact, strict=True)},
        ),
    )
