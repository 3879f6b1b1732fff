"""Tables of the site, from the motor files."""

from pathlib import Path

from sensorless.design.derived import derive
from sensorless.design.drive import DriveDesign
from sensorless.machine.motor import MOTORS, Motor
from sensorless.policies.best import best
from sensorless.suitability.examine import examine


def motors() -> str:
    """Page of the site: the machines that come with the package."""
    heading = ("motor", "what it is", "N m", "r/min", "V", "poles", "L_q/L_d", "suits")
    lines = [f"| {' | '.join(heading)} |", "|" + "---|" * len(heading)]
    schedules = []
    for path in sorted(MOTORS.glob("*.toml")):
        motor = Motor.load(path)
        verdict = examine(motor, derive(motor, DriveDesign()).hfi_pll_hz).verdict.word
        numbers = (motor.tau_rated, motor.n_rated_rpm, motor.u_dc, 2 * motor.n_p)
        cells = (
            f"`{motor.name}`",
            motor.description,
            *(f"{number:g}" for number in numbers),
            f"{motor.L_q / motor.L_d:.2f}",
            verdict,
        )
        lines.append(f"| {' | '.join(cells)} |")
        found = best(motor)
        if found is not None:
            unfit = f" Unfit for export: {found.objection}." if found.objection else ""
            since = "" if found.fresh else " Motor or drive have changed since."
            schedules.append(f"- `{motor.name}`: `{found.policy}`. {found.verdict}.{unfit}{since}")
    table, best_of = "\n".join(lines), "\n".join(schedules)
    text = Path(__file__).with_name("motors.md").read_text(encoding="utf-8")
    return text.format(table=table, best_of=best_of)
