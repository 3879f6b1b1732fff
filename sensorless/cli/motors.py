"""The command ``sensorless motors``: machines that come with the package."""

from sensorless.cli.options import (
    JsonOption,
    console,
    say_json,
)


def motors_command(as_json: JsonOption = False) -> None:
    """List the shipped motors with their numbers, whether each suits this drive, and a schedule.

    Whether it suits is the verdict of `sensorless motor check` without its simulation. The
    schedule is the best that `studies/best_schedules.py` found for the motor on the default drive,
    among Eq. 25 and two rules tuned for it, with its verdict on 400 scenarios of stress-1 that
    tuning has not seen. It says so where the drive has changed since.

    For example:

        sensorless motors
        sensorless motor check paper
        sensorless evaluate --motor ipmsm_2200w --policy eq25 --suite nominal
    """
    from rich.table import Table
    from rich.text import Text

    from sensorless.design.derived import derive
    from sensorless.design.drive import DriveDesign
    from sensorless.machine.motor import MOTORS, Motor
    from sensorless.policies.best import best
    from sensorless.suitability.examine import examine

    table = Table(box=None, padding=(0, 1))
    for heading in ("motor", "N m", "r/min", "V", "poles", "L_q/L_d", "suitable"):
        table.add_column(heading, justify="left" if heading in ("motor", "suitable") else "right")
    schedules, told = [], {}
    for path in sorted(MOTORS.glob("*.toml")):
        motor = Motor.load(path)
        found = best(motor)
        word = examine(motor, derive(motor, DriveDesign()).hfi_pll_hz).verdict.word
        told[motor.name] = {
            "rated_torque": motor.tau_rated, "rated_speed_rpm": motor.n_rated_rpm,
            "u_dc": motor.u_dc, "poles": 2 * motor.n_p, "saliency": motor.L_q / motor.L_d,
            "suitable": word, "policy": None if found is None else found.policy,
        }  # fmt: skip
        if found is not None:
            unfit = f"; unfit for export: {found.objection}" if found.objection else ""
            since = "" if found.fresh else "; motor or drive have changed since"
            line = f"{motor.name}: --policy {found.policy}\n  {found.verdict}{unfit}{since}"
            schedules.append(line)
        table.add_row(
            Text.assemble(f"{motor.name}\n", (motor.description, "dim")),
            f"{motor.tau_rated:g}",
            f"{motor.n_rated_rpm:g}",
            f"{motor.u_dc:g}",
            str(2 * motor.n_p),
            f"{motor.L_q / motor.L_d:.2f}",
            word,
        )
    if as_json:
        say_json(told)
    console.print(table)
    console.print("best schedules, by studies/best_schedules.py", highlight=False)
    for line in schedules:
        console.print(line, highlight=False, soft_wrap=True)
    text = f"The table [source] of each file in {MOTORS} names the source of every number."
    console.print(text, highlight=False, soft_wrap=True)
