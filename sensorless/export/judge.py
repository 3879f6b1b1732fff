"""Whether a schedule is fit for firmware: what it loses, and how it compares with Eq. 25."""

from dataclasses import asdict, dataclass
from typing import Any

from sensorless.baselines.linear import eq25_band, linear_table
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.errors import UserError
from sensorless.evaluation.compare import Comparison, compare, counted, outcomes
from sensorless.evaluation.machine_check import SIZE as CHECKED
from sensorless.evaluation.machine_check import Check, check
from sensorless.machine.motor import Motor
from sensorless.plain_json import plain
from sensorless.policy import Policy, TablePolicy

SUITE, SEED, SIZE = "nominal", 1, 200
"""The drive knows its machine, and its sensors are good: the least that a schedule must do."""
UNSUITED = "its machine does not suit"
MOST_LOST = 0.05
"""Of the feasible scenarios of ``SUITE``."""
LEAST_FEASIBLE = 0.5
"""Of the drawn scenarios: with fewer, what is lost of them says nothing of the machine."""


@dataclass(frozen=True)
class Judged:
    """What an export says about its schedule."""

    lost: int
    nominal: int
    """Scenarios of ``SUITE`` that are feasible, of which ``lost`` were lost,"""
    drawn: int
    """and of all."""
    eq25: Comparison
    """With Eq. 25 on the same machine and drive."""
    machine: Check | None = None
    """What ``sensorless motor check`` says of the machine on this drive, with this schedule."""
    suits: bool = False
    """It says no, but under Eq. 25 it does not."""

    @property
    def unsuited(self) -> tuple[str, ...]:
        """Why it says no; empty unless it does."""
        if self.machine is None or not _says_no(self.machine):
            return ()
        return self.machine.examination.verdict.because

    @property
    def objection(self) -> str:
        """Why it should not run a motor; empty if it may."""
        if self.unsuited:
            who = "it does not suit its machine, as Eq. 25 does" if self.suits else UNSUITED
            return f"{who}, because {'; '.join(self.unsuited)}"
        if not self.nominal:
            return f"no scenario of {SUITE} is feasible on this machine"
        if self.lost > MOST_LOST * self.nominal:
            return (
                f"it loses {self.lost} of {counted(self.nominal, self.drawn)} of {SUITE}, more "
                f"than {100 * MOST_LOST:g} %"
            )
        if self.nominal < LEAST_FEASIBLE * self.drawn:
            failed = f"{self.drawn - self.nominal} of {self.drawn} scenarios of {SUITE}"
            return f"even with an encoder, the drive fails {failed}"
        return self.eq25.sentence if self.eq25.word == "worse" else ""

    @property
    def sentence(self) -> str:
        """The verdict."""
        nominal = f"lost {self.lost} of {counted(self.nominal, self.drawn)} of {SUITE}"
        return f"{self.eq25.sentence}; {nominal}"

    def facts(self) -> dict[str, Any]:
        """All of it in JSON types."""
        found = {
            "objection": self.objection,
            SUITE: {"seed": SEED, "scenarios": self.nominal, "lost": self.lost},
            "eq25": self.eq25.facts(),
        }
        if self.machine is not None:
            word, runs = self.machine.examination.verdict.word, self.machine.runs
            found["motor_check"] = {"suitable": word, "runs": plain([asdict(run) for run in runs])}
        return found


def judge_export(policy: Policy, motor: Motor, design: DriveDesign) -> Judged:
    """Check the machine with a schedule, run it on ``SUITE``, and beside Eq. 25 on the drive."""
    factories = [SimFactory(motor, design)]
    nominal = outcomes(policy, factories, SUITE, SEED, SIZE)
    eq25 = TablePolicy("eq25", linear_table(*eq25_band(motor)), policy.settings)
    machine = machine_with(policy, motor, design)
    return Judged(
        int(nominal.lost.sum()),
        int(nominal.feasible.sum()),
        len(nominal.feasible),
        compare(policy, eq25, "Eq. 25", factories),
        machine,
        _says_no(machine) and not _says_no(check(motor, design, eq25, "Eq. 25", CHECKED)),
    )


def machine_with(policy: Policy, motor: Motor, design: DriveDesign) -> Check:
    """What ``sensorless motor check`` says of a machine on this drive, with a schedule."""
    return check(motor, design, policy, "the schedule", CHECKED)


def _says_no(machine: Check) -> bool:
    return machine.examination.verdict.word == "no"


def require_fit(judged: Judged, name: str) -> None:
    """Refuse a schedule with an objection.

    Raises
    ------
    UserError
        Says why.
    """
    if judged.unsuited and not judged.suits:
        mend = (
            "correct the motor file or the settings, or add --force; sensorless motor check, with "
            "the same --set, shows all"
        )
        raise UserError(f"export: {name}: {judged.objection}: {mend}")
    if judged.objection:
        worse = judged.objection == judged.eq25.sentence
        better = "export eq25, or train" if worse or judged.suits else "train"
        raise UserError(
            f"export: {name}: {judged.objection}: {better} or tune one for this machine, or add "
            "--force; sensorless motor check says whether the machine suits"
        )


def verdict(judged: Judged | None) -> str:
    """Sentence of the README, without its full stop."""
    if judged is None:
        return "not judged; `sensorless export` judges a schedule before it writes one"
    told = judged.sentence
    if judged.objection:
        told = f"not fit to run a motor: {judged.objection}; exported all the same with --force"
    if judged.machine is not None and judged.machine.runs:
        found = judged.machine.examination.verdict
        told += f"; motor check with it: {found.word}, lost {judged.machine.lost}"
        slips = [
            f"{100.0 * r.slipped:.1f} % of {r.suite}"
            for r in judged.machine.runs
            if r.slipped > 0.0
        ]
        told += f", slips and comes back in {', '.join(slips)}" if slips else ""
        told += f", because {'; '.join(found.because)}" if found.word == "with limits" else ""
    return told
