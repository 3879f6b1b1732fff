"""The command ``sensorless motor new``: a motor file from a datasheet."""

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from sensorless.cli.motor_check import show_check
from sensorless.cli.options import (
    JsonOption,
    ReplaceOption,
    errors,
    say_wrote,
)
from sensorless.errors import UserError, shown

ASKED = {
    "poles": "poles (twice the pole pairs)",
    "speed": "rated speed [r/min]",
    "current": "rated current [A RMS]",
    "r": "resistance [ohm]",
    "u-dc": "DC-link voltage of the inverter [V]",
    "pwm": "PWM frequency [Hz]",
}
"""What a motor file needs, and the question that asks for it."""


def new_command(
    name: Annotated[str, typer.Option(help="Call the motor this.")],
    out: Annotated[Path, typer.Option(help="Write the motor file here.")],
    poles: Annotated[
        int | None,
        typer.Option(
            metavar="N", help="Give the number of poles, twice the pole pairs. Default: asked for."
        ),
    ] = None,
    speed: Annotated[
        float | None, typer.Option(help="Give the rated speed [r/min]. Default: asked for.")
    ] = None,
    power: Annotated[
        float | None,
        typer.Option(help="Give the rated power [W]. Default: it follows from --torque."),
    ] = None,
    torque: Annotated[
        float | None,
        typer.Option(help="Give the rated torque [N m]. Default: it follows from --power."),
    ] = None,
    current: Annotated[
        float | None, typer.Option(help="Give the rated RMS current [A]. Default: asked for.")
    ] = None,
    ke: Annotated[
        float | None,
        typer.Option(
            help="Give the no-load voltage between two lines at 1000 r/min [V]. Default: it "
            "follows from --kt."
        ),
    ] = None,
    ke_kind: Annotated[str, typer.Option(help="Take --ke as an rms or a peak voltage.")] = "rms",
    kt: Annotated[
        float | None,
        typer.Option(help="Give the torque constant [N m/A]. Default: it follows from --ke."),
    ] = None,
    kt_kind: Annotated[
        str, typer.Option(help="Take --kt per ampere of rms or of peak current.")
    ] = "rms",
    between: Annotated[
        str,
        typer.Option(
            help="Take --r, --l-d, --l-q and --l as measured between two terminals (line) or on "
            "one phase (phase)."
        ),
    ] = "line",
    r: Annotated[
        float | None, typer.Option("--r", help="Give the resistance [ohm]. Default: asked for.")
    ] = None,
    l_d: Annotated[
        float | None,
        typer.Option("--l-d", help="Give the inductance of the d axis [H]. Default: asked for."),
    ] = None,
    l_q: Annotated[
        float | None,
        typer.Option("--l-q", help="Give the inductance of the q axis [H]. Default: asked for."),
    ] = None,
    inductance: Annotated[
        float | None,
        typer.Option(
            "--l",
            help="Give the mean inductance of both axes [H] and --ratio instead of --l-d and "
            "--l-q. Default: none.",
        ),
    ] = None,
    ratio: Annotated[
        float | None,
        typer.Option(
            help="Give L_q / L_d [-]; goes with --l. Default: it follows from --l-d and --l-q."
        ),
    ] = None,
    inertia: Annotated[
        str | None,
        typer.Option(
            help="Give the inertia with its unit: '320 g cm2', '1.2 kg cm2', '0.01 kg m2'. "
            "Default: "
            "0.2 s from rest to rated speed at rated torque."
        ),
    ] = None,
    u_dc: Annotated[
        float | None, typer.Option(help="Give the DC-link voltage [V]. Default: asked for.")
    ] = None,
    pwm: Annotated[
        float | None, typer.Option(help="Give the PWM frequency [Hz]. Default: asked for.")
    ] = None,
    adc_range: Annotated[
        float | None,
        typer.Option(
            help="Give the largest current that is measured [A]. Default: twice the peak of the "
            "rated current."
        ),
    ] = None,
    adc_bits: Annotated[
        int,
        typer.Option(metavar="N", help="Give the resolution of the current measurement in bits."),
    ] = 12,
    dead_time: Annotated[
        float | None,
        typer.Option(
            help="Give the dead time [s]. Default: 0.5e-6 below 150 V, 2e-6 from there on, at most "
            "2 % of the PWM period."
        ),
    ] = None,
    u_inj: Annotated[
        float | None,
        typer.Option(
            help="Give the injected voltage [V]. Default: as low as noise, converter and dead time "
            "allow."
        ),
    ] = None,
    size: Annotated[
        int,
        typer.Option(
            min=0, metavar="N", help="Simulate this many scenarios in the check; 0: none."
        ),
    ] = 100,
    replace: ReplaceOption = False,  # apart.py reads it, before the command runs
    as_json: JsonOption = False,
) -> None:
    """Write a motor file from what a datasheet gives, then check it.

    The command asks for what you did not give, and asks again if an answer is impossible. One of
    --ke and --kt is enough, and so is one of --power and --torque; if you give both, they have to
    agree. The file names the source of every number and says what is assumed. Exit status 1: the
    file is written, and the check says no. Only --replace replaces an existing file.

    For example:

        sensorless motor new --name mine --out mine.toml
        sensorless motor new --name other --out other.toml --ke 40 --pwm 8000
    """
    from sensorless.design.drive import DriveDesign
    from sensorless.design.new_motor import new_motor
    from sensorless.files import write_atomic
    from sensorless.machine.datasheet import Datasheet, check_number, check_words, inertia_from
    from sensorless.machine.motor import Motor, check_name
    from sensorless.machine.motor_file import check_motor_out, written
    from sensorless.settings import settings_of

    check_name(name)
    check_motor_out(out)
    check_words(ke_kind, kt_kind, between)
    rotor = None if inertia is None else inertia_from(inertia)
    given = {"poles": poles, "speed": speed, "current": current, "r": r, "u-dc": u_dc, "pwm": pwm}
    others = {
        "power": power, "torque": torque, "ke": ke, "kt": kt, "l-d": l_d, "l-q": l_q,
        "l": inductance, "ratio": ratio, "inertia": rotor, "adc-range": adc_range, "u-inj": u_inj,
    }  # fmt: skip
    for key, value in {**given, **others}.items():  # before the first question
        if value is not None:
            check_number(key, value)
    for field, number in (("dead_time", dead_time), ("adc_bits", adc_bits)):
        if number is not None:
            settings_of(Motor)[field].checked(number)
    known: dict[str, Any] = {
        key: _asked(key, ASKED[key]) if value is None else value for key, value in given.items()
    }
    if ke is None and kt is None:
        ke = _asked("ke", f"Ke [V per 1000 r/min, line to line, {ke_kind}]")
    if power is None and torque is None:
        torque = _asked("torque", "rated torque [N m]")
    if ratio is not None and l_d is None and l_q is None and inductance is None:
        inductance = _asked("l", f"mean inductance of both axes, {between} [H]")
    elif l_d is None and l_q is None and inductance is None:
        l_d = _asked("l-d", f"d inductance, {between} [H]")
        l_q = _asked("l-q", f"q inductance, {between} [H]")
    sheet = Datasheet(
        poles=int(known["poles"]), speed_rpm=known["speed"], current_rms=known["current"],
        R=known["r"], ke=ke, ke_kind=ke_kind, kt=kt, kt_kind=kt_kind, between=between,
        L_d=l_d, L_q=l_q, L=inductance, ratio=ratio, power=power, torque=torque,
        inertia=rotor,
    )  # fmt: skip
    design = DriveDesign()
    data = new_motor(
        name, sheet, u_dc=known["u-dc"], pwm_hz=known["pwm"], adc_range=adc_range,
        adc_bits=adc_bits, dead_time=dead_time, u_inj=u_inj, design=design,
    )  # fmt: skip
    motor = Motor.from_tables(data, str(out))
    head = (
        "Made by sensorless motor new from data-sheet numbers. Currents and flux are peak values."
    )
    write_atomic(out, written(data, head))
    say_wrote(out)
    try:
        show_check(motor, design, size, None, as_json)
    except typer.Exit:
        if not as_json:
            errors.print("to try other numbers, add --replace", highlight=False)
        raise


def _asked(option: str, question: str) -> float:
    """Ask for a number, on a terminal until it is one that can be.

    Raises
    ------
    UserError
        There is no answer, or one that cannot be does not come from a terminal.
    """
    while True:
        try:
            text = typer.prompt(question)
        except (typer.Abort, EOFError):
            raise UserError(
                f"{option}: missing; give --{option}, or answer the question: {question}"
            ) from None
        try:
            return _answer(option, text)
        except UserError as error:
            if not sys.stdin.isatty():
                raise
            errors.print(str(error), highlight=False, soft_wrap=True)


def _answer(option: str, text: str) -> float:
    """Return the number that an answer is; errors as ``check_number``."""
    from sensorless.machine.datasheet import check_number

    try:
        value = float(text)
    except ValueError:
        raise UserError(
            f"{option}: {shown(text)}; give a number without its unit, such as 12 or 4.5e-3"
        ) from None
    check_number(option, value)
    return value
