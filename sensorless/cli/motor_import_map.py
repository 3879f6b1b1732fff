"""The command ``sensorless motor import-map``: a saturation model from a flux map."""

from pathlib import Path
from typing import Annotated

import typer

from sensorless.cli.options import (
    JsonOption,
    ReplaceOption,
    console,
    say_json,
    say_wrote,
)

WANTED = 1.0
"""RMS error within rated current that counts as good [% of rated current]."""


def import_map_command(
    file: Annotated[
        Path,
        typer.Argument(
            help="Read this flux map (FEA or measured): CSV or .mat with i_d, i_q, psi_d, psi_q."
        ),
    ],
    motor: Annotated[
        str,
        typer.Option(
            "--motor",
            help="Use this motor, to which the map belongs: a TOML file or a shipped name.",
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option(help="Write a motor file with the model. Default: print the model."),
    ] = None,
    plot: Annotated[
        Path | None,
        typer.Option(help="Draw map, model and errors as a PNG picture. Default: no picture."),
    ] = None,
    columns: Annotated[
        str | None,
        typer.Option(
            metavar="NAMES",
            help="Name the columns in order, separated by commas. Default: the heading names them.",
        ),
    ] = None,
    turn: Annotated[
        bool,
        typer.Option(
            "--turn",
            help="Turn a map whose d axis is that of a reluctance machine's iron, with the magnet "
            "along -q. Default: the map's d axis is the magnet's.",
        ),
    ] = False,
    replace: ReplaceOption = False,  # apart.py reads it, before the command runs
    as_json: JsonOption = False,
) -> None:
    """Fit the saturation model to a flux map and say how well it fits.

    Columns may be in any order, with units A, mA, Vs, mVs, Wb or mWb in brackets. The model is
    reciprocal by construction, as iron is. Points beyond the motor's i_max are ignored. L_d, L_q
    and psi_f of the motor become those of the model at zero current. Where the model misses the map
    by more than 1 % of rated current, the motor file also gets a correction, on which only the
    simulated machine runs: the drive is designed on the model. Where the map does not bear out the
    pole that pulses at rest would find by the model, it says pole_at_rest = false.

    For example:

        sensorless motor import-map map.csv --motor mine.toml --out sat.toml
    """
    import dataclasses
    from contextlib import suppress

    from sensorless.design.drive import DriveDesign
    from sensorless.errors import UserError
    from sensorless.files import write_atomic
    from sensorless.machine.correction_fit import corrected
    from sensorless.machine.flux_correction import correction_table
    from sensorless.machine.magnetics import plant_currents
    from sensorless.machine.map_file import load_map
    from sensorless.machine.map_fit import fit_map
    from sensorless.machine.mapped import (
        LIKELY,
        far_from,
        mapped,
        outside,
        saturation_table,
        tables_of,
    )
    from sensorless.machine.motor import Motor
    from sensorless.machine.motor_file import check_motor_out, table_lines, written
    from sensorless.plots.figure import check_picture
    from sensorless.report.motor_check import check
    from sensorless.suitability.pole import pole_unsure

    check_motor_out(out)
    check_picture(plot)
    machine = Motor.load(motor)
    i, psi = load_map(file, columns, turn)
    fit = fit_map(i, psi, machine.i_rated, machine.i_max)
    made = mapped(machine, fit)
    d, q = fit.rms_percent(machine.i_rated)
    most = fit.max_percent(machine.i_rated)
    console.print(
        f"{len(i)} points, {int(fit.inside(machine.i_max).sum())} within i_max = "
        f"{machine.i_max:g} A; errors of i_d and i_q in % of rated current:\n"
        f"within rated current: {d:.2f} and {q:.2f} RMS, at most "
        f"{most:.2f}\n"
        "within i_max: {:.2f} and {:.2f} RMS, at most {:.2f}".format(
            *fit.rms_percent(machine.i_max), fit.max_percent(machine.i_max)
        )
    )
    console.print(
        f"at zero current: L_d = {made.L_d:.4g} H, L_q = {made.L_q:.4g} H, "
        f"psi_f = {made.psi_f:.4g} Vs"
    )
    for note in (*far_from(made, machine), *outside(made, i)):
        console.print(f"note: {note}")
    unsure = next(pole_unsure(made, i, psi), "")
    if unsure:
        console.print(f"note: {unsure}")
        made = dataclasses.replace(made, pole_at_rest=False)
    with suppress(UserError):  # of no drive at all: motor check says why
        wanted = check(made, DriveDesign(), 0).examination.suggested
        if wanted is not None and wanted["u_inj"] > LIKELY * made.u_inj:
            console.print(
                f"note: u_inj stays at {made.u_inj:g} V; with this map {wanted['u_inj']:g} V is "
                "suggested, sensorless motor check says more"
            )
    beyond = ""
    if max(d, q) > WANTED:
        made = corrected(made, i, psi)
        fit = dataclasses.replace(fit, error=plant_currents(made, psi) - i)
        rms = fit.rms_percent(machine.i_rated)
        beyond = "flux map {}: what [saturation] leaves, within {:.2f} and {:.2f} % RMS".format(
            file.name, *rms
        )
        console.print(
            f"the model misses the map by more than {WANTED:g} %, so the simulated machine gets a "
            "correction;\nwith it, within rated current: "
            "{:.2f} and {:.2f} RMS, at most {:.2f}".format(*rms, fit.max_percent(machine.i_rated))
        )
        if max(rms) > WANTED:
            console.print(f"which still misses it by more than {WANTED:g} %; --plot shows where")
    if as_json:
        rated = {"rms_percent": [d, q], "max_percent": most}
        zero = {"L_d": made.L_d, "L_q": made.L_q, "psi_f": made.psi_f}
        found = {"points": len(i), "within_rated_current": rated, "at_zero_current": zero}
        if beyond:
            found["corrected"] = {
                "rms_percent": list(rms),
                "max_percent": fit.max_percent(machine.i_rated),
            }
        say_json(found)
    if out is None:
        lines = table_lines("saturation", saturation_table(made.saturation))
        if made.flux_correction is not None:
            table = correction_table(made.flux_correction)
            lines += ["", *table_lines("flux_correction", table)]
        if not made.pole_at_rest:
            lines += ["", *table_lines("drive", {"pole_at_rest": False})]
        console.print("\n".join(lines), highlight=False)
    else:
        head = f"{machine.name} with the flux map of {file.name}, by sensorless motor import-map."
        source = f"flux map {file.name}: fit within {d:.2f} and {q:.2f} % RMS of rated current"
        data = tables_of(made, source, motor, beyond)
        if unsure:
            data["source"]["pole_at_rest"] = f"flux map {file.name}, which does not show the pole"
        write_atomic(out, written(data, head))
        say_wrote(out)
    if plot is not None:
        from sensorless.plots.figure import save
        from sensorless.plots.map_fit import map_fit

        what = "simulated machine" if beyond else "reciprocal model"
        save(map_fit(machine.name, fit, what), plot)
        say_wrote(plot)
