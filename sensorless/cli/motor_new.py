"""The command ``sensorless motor new``: a motor file from a data sheet."""

from pathlib import Path
from typing import Annotated, Any

import typer

from sensorless.cli.motor_check import show_check
from sensorless.cli.options import console
from sensorless.errors import UserError

ASKED = {
    "poles": "poles (twice the pole pairs)",
    "speed": "rated speed [r/min]",
    "current": "rated current [A RMS]",
    "r": "resistance [ohm]",
    "u_dc": "DC-link voltage of the inverter [V]",
    "pwm": "PWM frequency [Hz]",
}
"""What has to be, and how it is asked for."""


def new_command(
    name: Annotated[str, typer.Option(help="Name of the motor.")],
    out: Annotated[Path, typer.Option(help="Motor file to write.")],
    poles: Annotated[
        int | None, typer.Option(metavar="N", help="Twice the pole pairs. Default: asked for.")
    ] = None,
    speed: Annotated[
        float | None, typer.Option(help="Rated speed [r/min]. Default: asked for.")
    ] = None,
    power: Annotated[
        float | None, typer.Option(help="Rated power [W]. Default: from the torque.")
    ] = None,
    torque: Annotated[
        float | None, typer.Option(help="Rated torque [N m]. Default: from the power.")
    ] = None,
    current: Annotated[
        float | None, typer.Option(help="Rated current, RMS [A]. Default: asked for.")
    ] = None,
    ke: Annotated[
        float | None,
        typer.Option(help="No-load voltage, line to line [V/krpm]. Default: from --kt."),
    ] = None,
    ke_kind: Annotated[str, typer.Option(help="How --ke counts the voltage: rms, peak.")] = "rms",
    kt: Annotated[
        float | None, typer.Option(help="Torque constant [N m/A]. Default: from --ke.")
    ] = None,
    kt_kind: Annotated[str, typer.Option(help="How --kt counts the current: rms, peak.")] = "rms",
    between: Annotated[
        str, typer.Option(help="Where R and L are measured: line (two terminals), phase.")
    ] = "line",
    r: Annotated[
        float | None, typer.Option("--r", help="Resistance [ohm]. Default: asked for.")
    ] = None,
    l_d: Annotated[
        float | None,
        typer.Option("--l-d", help="Inductance of the d axis [H]. Default: asked for."),
    ] = None,
    l_q: Annotated[
        float | None,
        typer.Option("--l-q", help="Inductance of the q axis [H]. Default: asked for."),
    ] = None,
    inductance: Annotated[
        float | None,
        typer.Option("--l", help="Average inductance [H], with --ratio. Default: --l-d, --l-q."),
    ] = None,
    ratio: Annotated[
        float | None, typer.Option(help="L_q / L_d [-], with --l. Default: from --l-d, --l-q.")
    ] = None,
    inertia: Annotated[
        str | None,
        typer.Option(
            help="With its unit: '320 g cm2', '1.2 kg cm2', '0.01 kg m2'. Default: 0.2 s "
            "from rest to rated speed."
        ),
    ] = None,
    u_dc: Annotated[
        float | None, typer.Option(help="DC-link voltage [V]. Default: asked for.")
    ] = None,
    pwm: Annotated[
        float | None, typer.Option(help="PWM frequency [Hz]. Default: asked for.")
    ] = None,
    adc_range: Annotated[
        float | None, typer.Option(help="Largest measurable current [A]. Default: twice rated.")
    ] = None,
    adc_bits: Annotated[
        int, typer.Option(metavar="N", help="Resolution of the current measurement.")
    ] = 12,
    dead_time: Annotated[
        float | None, typer.Option(help="Dead time [s]. Default: usual for the voltage.")
    ] = None,
    u_inj: Annotated[
        float | None, typer.Option(help="Injected voltage [V]. Default: from noise and limits.")
    ] = None,
    size: Annotated[
        int, typer.Option(min=0, metavar="N", help="Scenarios of the check's run; 0: no run.")
    ] = 100,
) -> None:
    """Write a motor file from what a data sheet gives, then check it.

    What must be and is not given is asked for. Of --ke and --kt one is enough, of --power and
    --torque likewise; where both are given they have to agree. The file says where every number is
    from and what is assumed.

    For example:

        sensorless motor new --name mine --out mine.toml
        sensorless motor new --name mine --out mine.toml --ke 40 --pwm 8000
    """
    from sensorless.design.drive import DriveDesign
    from sensorless.design.new_motor import new_motor, plain
    from sensorless.files import check_writable, write_atomic
    from sensorless.machine.datasheet import Datasheet, inertia_from
    from sensorless.machine.motor import Motor
    from sensorless.machine.motor_file import written

    check_writable(out)
    given = {"poles": poles, "speed": speed, "current": current, "r": r, "u_dc": u_dc, "pwm": pwm}
    known: dict[str, Any] = {key: _asked(key, value) for key, value in given.items()}
    if ke is None and kt is None:
        ke = _asked_number("ke", f"Ke [V per 1000 r/min, line to line, {ke_kind}]")
    if power is None and torque is None:
        torque = _asked_number("torque", "rated torque [N m]")
    if l_d is None and l_q is None and inductance is None:
        l_d = _asked_number("l-d", f"d inductance, {between} [H]")
        l_q = _asked_number("l-q", f"q inductance, {between} [H]")
    sheet = Datasheet(
        poles=known["poles"], speed_rpm=known["speed"], current_rms=known["current"],
        R=known["r"], ke=ke, ke_kind=ke_kind, kt=kt, kt_kind=kt_kind, between=between,
        L_d=l_d, L_q=l_q, L=inductance, ratio=ratio, power=power, torque=torque,
        inertia=None if inertia is None else inertia_from(inertia),
    )  # fmt: skip
    design = DriveDesign()
    data = new_motor(
        name, sheet, u_dc=known["u_dc"], pwm_hz=known["pwm"], adc_range=adc_range,
        adc_bits=adc_bits, dead_time=dead_time, u_inj=u_inj, pll_hz=design.hfi_pll_hz,
    )  # fmt: skip
    motor = Motor.from_tables(plain(data), str(out))
    head = (
        "Made by sensorless motor new from data-sheet numbers. Currents and flux are peak values."
    )
    write_atomic(out, written(data, head))
    console.print(f"wrote {out}")
    show_check(motor, design, size, None, f"sensorless motor check {out}")


def _asked(key: str, value: float | None) -> float:
    """A value that was given, or asked for."""
    if value is not None:
        return value
    number = _asked_number(key.replace("_", "-"), ASKED[key])
    return int(number) if key == "poles" else number


def _asked_number(option: str, question: str) -> float:
    """Ask for a number.

    Raises
    ------
    UserError
        Nobody answers.
    """
    try:
        return float(typer.prompt(question, type=float))
    except (typer.Abort, EOFError):
        raise UserError(
            f"{option}: missing; allowed: --{option}, or an answer: {question}"
        ) from None
