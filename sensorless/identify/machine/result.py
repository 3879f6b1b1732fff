"""What was found: a motor file with the source of every number, and rows for the screen."""

import math
from typing import Any

from sensorless.design.derived import derive
from sensorless.design.drive import DriveDesign
from sensorless.errors import UserError
from sensorless.identify.machine.procedure import Identified
from sensorless.machine.datasheet import Number
from sensorless.machine.magnetics import at_zero_current
from sensorless.machine.mapped import rounded, saturation_table
from sensorless.machine.motor import Motor, Saturation
from sensorless.machine.motor_file import tables
from sensorless.suitability.examine import examine
from sensorless.suitability.finding import NOTE

GIVEN = (
    "n_p", "tau_rated", "i_rated", "n_rated_rpm", "u_dc", "T_s", "u_inj", "i_max", "i_trip",
    "dead_time", "adc_range", "adc_bits",
)  # fmt: skip
LEAST_SALIENCY = 1.05
"""L_q / L_d below which the two cannot be told apart for sure."""


def motor_tables(found: Identified) -> dict[str, Any]:
    """Tables of a motor file, see ``Motor.from_tables``.

    Raises
    ------
    UserError
        The machine has no saliency to speak of.
    """
    model = rounded(found.map_fit.saturation)
    L_d, L_q, psi_f = at_zero_current(model, found.plate.i_rated)
    if L_q < LEAST_SALIENCY * L_d:
        raise UserError(
            f"inductance: L_d = {L_d:.4g} H, L_q = {L_q:.4g} H; a machine without saliency gives "
            "injection no angle"
        )
    plate, r, spin = found.plate, found.resistance, found.spin
    d, q = found.map_fit.rms_percent(plate.i_rated)
    mapped = f"identified: voltage pulses at rest, errors of i_d and i_q {d:.2f} and {q:.2f} % RMS"
    mechanics = f"identified: spin, torque left over {spin.mechanics.residual:.3g} N m RMS"
    numbers = {name: Number(getattr(plate, name), "given") for name in GIVEN} | {
        "R_s": Number(
            r.R_s,
            f"identified: {len(r.i)} direct currents, +-{r.R_std:.2g} ohm; the inverter's lost "
            f"voltage of {r.inverter.u_lost:.4g} V a leg taken out",
        ),
        "L_d": Number(L_d, mapped),
        "L_q": Number(L_q, mapped),
        "psi_f": Number(
            psi_f, f"identified: EMF at {len(spin.used)} points, +-{spin.psi_f_std:.2g} Vs"
        ),
        "J": Number(spin.mechanics.J, f"{mechanics}, +-{spin.mechanics.J_std:.2g} kg m^2"),
        "B": Number(max(spin.mechanics.B, 0.0), mechanics),
    }
    data = tables(plate.name, "identified by its drive", numbers)
    source = data.pop("source")
    return {
        **data,
        "saturation": saturation_table(model),
        "source": {**source, "saturation": mapped},
    }


def doubts(data: dict[str, Any]) -> list[str]:
    """What of a measured machine does not fit its name plate, or no machine."""
    motor = Motor.from_tables(data, "identified")
    found = examine(motor, derive(motor, DriveDesign()).hfi_pll_hz).findings
    return [f.text for f in found if f.weight != NOTE or f.field == "tau_rated"]


def screen(found: Identified) -> list[tuple[str, str, str, str]]:
    """Rows of quantity, value, scatter and how it was found."""
    r, spin, plate = found.resistance, found.spin, found.plate
    L_d, L_q, psi_f = at_zero_current(found.map_fit.saturation, plate.i_rated)
    d, q = found.map_fit.rms_percent(plate.i_rated)
    m = spin.mechanics
    return [
        _row("R_s", r.R_s, r.R_std, "ohm", f"{len(r.i)} direct currents of both signs"),
        _row("lost voltage", r.inverter.u_lost, r.residual, "V", "the same, of one leg"),
        ("current gains, b / a", f"{r.sensors.ratio:.4f}", "", "the same, rotor at rest"),
        ("L_d", f"{L_d:.5g} H", f"{d:.2f} % of rated", _pulses(found)),
        ("L_q", f"{L_q:.5g} H", f"{q:.2f} % of rated", "the same"),
        ("saturation", _terms(found.map_fit.saturation), "", "terms that earned their place"),
        _row("psi_f", psi_f, spin.psi_f_std, "Vs", f"EMF at {len(spin.used)} points"),
        _row("J", m.J, m.J_std, "kg m^2", "ramps up and down"),
        _row("B", m.B, math.nan, "N m s/rad", f"and {m.tau_0:.2g} N m at any speed"),
    ]


def _row(name: str, value: float, spread: float, unit: str, how: str) -> tuple[str, str, str, str]:
    share = f"{100.0 * spread / abs(value):.2g} %" if value and math.isfinite(spread) else ""
    return name, f"{value:.5g} {unit}", share, how


def _pulses(found: Identified) -> str:
    s = found.samples
    return f"{len(s.i)} samples of pulses, {100.0 * s.left:.1f} % left over at their ends"


def _terms(s: Saturation) -> str:
    names = {
        f"d^{s.S}": s.a_dd, f"q^{s.T}": s.a_qq, f"cross {s.U},{s.V}": s.a_dq, "bridges": s.a_b
    }  # fmt: skip
    return ", ".join(name for name, value in names.items() if value > 0.0) or "linear"
