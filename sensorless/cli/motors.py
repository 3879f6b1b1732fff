"""The command ``sensorless motors``: machines that come with the package."""

from sensorless.cli.options import console


def motors_command() -> None:
    """List the shipped motors with their numbers, and whether each suits this drive.

    The verdict is that of `sensorless motor check` without its simulation.

    For example:

        sensorless motors
        sensorless motor check paper
    """
    from rich.table import Table

    from sensorless.design.drive import DriveDesign
    from sensorless.machine.motor import MOTORS, Motor
    from sensorless.suitability.examine import examine

    table = Table(box=None, padding=(0, 1))
    for heading in ("motor", "N m", "r/min", "V", "poles", "L_q/L_d", "suitable"):
        table.add_column(heading, justify="left" if heading in ("motor", "suitable") else "right")
    for path in sorted(MOTORS.glob("*.toml")):
        motor = Motor.load(path)
        table.add_row(
            f"{motor.name}\n[dim]{motor.description}[/]",
            f"{motor.tau_rated:g}",
            f"{motor.n_rated_rpm:g}",
            f"{motor.u_dc:g}",
            str(2 * motor.n_p),
            f"{motor.L_q / motor.L_d:.2f}",
            examine(motor, DriveDesign().hfi_pll_hz).verdict.word,
        )
    console.print(table)
    text = f"The table [source] of each file in {MOTORS} names the source of every number."
    console.print(text, markup=False, highlight=False, soft_wrap=True)
