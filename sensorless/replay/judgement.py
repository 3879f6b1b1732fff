"""Which estimator served best over a log, and what the errors of the others consist of."""

import math
from collections.abc import Mapping

from sensorless.replay.replay import Replay

ENOUGH = 0.2
"""Share of the samples in which an estimator must have had a signal, to be compared."""
ADRIFT = 0.01
"""Share of the samples without a signal that is worth a word."""
ASTRAY = 45.0
"""RMS error from which an estimator does not follow: at random, on both poles, it is 104 [deg]."""
ZERO, ALIKE = 5.0, 0.4
"""Constant error from which the encoder is suspected where all estimators have it [deg], and how
far they may differ in it, over its size: their own errors have different causes."""
NONE = (
    "no estimator had a signal in a fifth of the log: record with injection, or from a higher "
    "speed on with --speed and --angle of the first row"
)
CONSTANT = {
    "hfi": "cross-coupling that the drive does not compensate (sensorless identify "
    "cross-coupling), or at speed a sample that is late",
    "smo": "the inductance that the drive takes on purpose (coupled_L_q_bias, flux_L_q_bias, "
    "L_q_bias), or a wrong resistance, inductance or dead time in the motor's file",
    "blend": "the same as of the observer, or a voltage measured at the terminals, of which no "
    "inverter takes any more: --set dead_time_share=0",
    "ekf": "the voltage that the inverter loses, which it takes no account of, or a wrong flux, "
    "resistance, inductance or scale of the voltage",
}
"""What turns an estimate by a constant angle, by estimator."""
SCATTER = {
    "hfi": "noise of the current beside the injected one, and transients",
    "smo": "little flux at low speed, noise and transients",
    "blend": "noise and transients; more bandwidth follows faster and passes more noise",
    "ekf": "transients: its model has no torque, so it takes each acceleration for noise",
}
"""What scatters an estimate."""


def judgement(found: Replay, after: float = 0.0) -> list[str]:
    """Lines for people; none without an encoder.

    The RMS error consists of a constant part, its mean, and of the scatter about it. What is larger
    names the cause.
    """
    rows = {
        name: row
        for name, row in found.summary(after).items()
        if row["share"] >= ENOUGH and math.isfinite(row["rms_deg"])
    }
    if not rows:
        return [] if found.log.theta_e is None else [NONE]
    if found.log.doubtful:
        return [
            "the log contradicts itself: mend it as the note says before judging the estimators"
        ]
    best = min(rows, key=lambda name: rows[name]["rms_deg"])
    if rows[best]["rms_deg"] > ASTRAY:
        return [
            f"no estimator follows the encoder (best {found.label(best)}, "
            f"{rows[best]['rms_deg']:.0f}° RMS): check order, signs, delay and pole pairs of the "
            "log, and that the motor's file is this machine's"
        ]
    lines = [f"best here: {found.label(best)}, {rows[best]['rms_deg']:.2f}° RMS"]
    if "hfi" in rows and len(rows) > 1 and (shared := _shared(rows)):
        lines.append(
            f"all estimators, which err for different reasons, are {abs(shared):.0f}° "
            f"{'behind' if shared > 0.0 else 'ahead of'} the encoder: likely its zero is off by as "
            "much, or at speed its samples are of another instant than the currents"
        )
    for name, row in rows.items():
        if name == best or row["rms_deg"] < 1.1 * rows[best]["rms_deg"]:
            continue
        constant = abs(row["mean_deg"])
        scatter = math.sqrt(max(row["rms_deg"] ** 2 - constant**2, 0.0))
        cause = CONSTANT[name] if constant > scatter else SCATTER[name]
        lines.append(
            f"{found.label(name)}: {row['rms_deg']:.2f}°, of it {constant:.2f}° constant and "
            f"{scatter:.2f}° scatter; likely {cause}"
        )
    row = found.summary(after)["blend"]
    if 1.0 - row["share"] >= ADRIFT and math.isfinite(row["without_rms_deg"]):
        lines.append(
            f"dead reckoning: in {100.0 * (1.0 - row['share']):.0f} % of the samples the blend had "
            f"no signal, {row['without_rms_deg']:.1f}° RMS; more injection (a higher k_s at low "
            "speed) would give it one"
        )
    return lines


def _shared(rows: Mapping[str, Mapping[str, float]]) -> float:
    """Mean of the constant errors if they are large and alike, truth − estimate [deg]; else 0."""
    means = [row["mean_deg"] for row in rows.values()]
    size = min(map(abs, means))
    alike = size > ZERO and max(means) - min(means) < ALIKE * size
    return sum(means) / len(means) if alike else 0.0
