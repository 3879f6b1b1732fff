"""A motor from its datasheet: the file, whether it suits, its first run, Eq. 25 on 100 scenarios.

The numbers are those of a wheel hub motor of an electric bicycle, 27 N m at 400 r/min, 48 V.

    python examples/own_motor.py --out hub.toml
"""

import argparse
from pathlib import Path

from sensorless.design.derived import derive
from sensorless.design.drive import DriveDesign
from sensorless.design.new_motor import new_motor
from sensorless.envs.scenarios.words import plan_from
from sensorless.errors import UserError, in_one_line
from sensorless.evaluation.evaluate import evaluate
from sensorless.evaluation.trace import outcome, trace
from sensorless.files import write_atomic
from sensorless.machine.datasheet import Datasheet
from sensorless.machine.motor import Motor
from sensorless.machine.motor_file import written
from sensorless.policies.registry import make_policy
from sensorless.suitability.examine import examine

SHEET = Datasheet(
    poles=34,
    speed_rpm=400.0,
    current_rms=28.3,
    torque=27.0,
    ke=81.7,  # V per 1000 r/min between two lines
    ke_kind="peak",
    between="phase",  # where R, L_d and L_q are measured
    R=0.051,
    L_d=129e-6,
    L_q=280e-6,
)


def main(words: list[str] | None = None) -> None:
    """Write the file and print what there is to know before a schedule is made."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("hub.toml"), help="motor file to write")
    parser.add_argument("--size", type=int, default=100, help="scenarios")
    given = parser.parse_args(words)

    if given.out.exists():
        raise UserError(f"out: {str(given.out)!r} exists; write to another file")
    design = DriveDesign()
    tables = new_motor("hub", SHEET, u_dc=48.0, pwm_hz=10e3, design=design)
    write_atomic(given.out, written(tables, "From a datasheet."))
    motor = Motor.load(given.out)  # as `--motor hub.toml` does
    print(f"wrote {given.out}: every number with its source")

    found = examine(motor, derive(motor, design).hfi_pll_hz)
    print(
        f"suits this drive: {found.verdict.word}",
        *(finding.text for finding in found.findings),
        sep="\n  ",
    )

    eq25 = make_policy("eq25", motor)
    case = plan_from("0:40,0.5:200", "0:0,0.3:10", None, 1.0, motor, 1)
    print(f"40 to 200 r/min under 10 N m: {outcome(trace(eq25, case, motor, design))}")

    results = evaluate(motor, design, "stress-1", 7, given.size, {"eq25": eq25})
    print(f"lost {100.0 * results.policies['eq25']['lost_rate']:.1f} % of {given.size} scenarios")


if __name__ == "__main__":
    in_one_line(main)
