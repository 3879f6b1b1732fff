"""The machine, the drive and the policies of one command, from its words and what policies carry.

A trained or tuned policy brings its machine and its settings, a rule or a Python policy those that
it names. What a command asks for must agree with them, unless it overrides; what is not brought is
as the command asks, or else the default.
"""

import dataclasses
import re
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, field
from typing import Any

from sensorless.design.carried import Carried, refuse_other, refuse_settings
from sensorless.design.drive import DriveDesign
from sensorless.design.words import asked_for, text_of
from sensorless.errors import UserError
from sensorless.machine.motor import Motor
from sensorless.policies.registry import carried_by, make_policies, make_policy
from sensorless.policy import Policy

DEFAULT_MOTOR = "paper"
WHY = "see docs/what-a-run-carries.md"
"""End of a note on what has changed."""
OF_ONE = re.compile(r"(smo|L_q|error|flux|coupled)_(?!floor|table)")
"""Beginning of the names of settings that one observer has."""
SMO = ("smo", "unwrapped", "errors")
USERS = {"smo": SMO, "L_q": SMO, "error": ("errors",), "flux": ("flux",), "coupled": ("coupled",)}
"""Estimators that have them."""


@dataclass(frozen=True)
class Bench:
    """What policies run on."""

    motor: Motor
    design: DriveDesign = field(default_factory=DriveDesign)
    """Of policies that bring no settings of their own."""
    asked: Mapping[str, Any] = field(default_factory=dict)
    """Settings that the command names."""
    override: bool = False
    """Policies run on the machine and the settings asked for, whatever they bring."""
    notes: tuple[str, ...] = ()
    """What a user should know."""

    def policies(self, specs: Sequence[str]) -> dict[str, Policy]:
        """Policies by name, as ``make_policies``."""
        made = make_policies(specs, self.motor, override=self.override)
        if self.override:
            for policy in made.values():
                policy.settings = {**policy.settings, **self.asked}
        return made

    def on(self, motor: Motor) -> "Bench":
        """The same on another machine, whatever the policies were made for."""
        return dataclasses.replace(self, motor=motor, override=True)

    def policy(self, spec: str) -> Policy:
        """One policy, as ``make_policy``."""
        (made,) = self.policies([spec]).values()
        return made


def bench(
    specs: Sequence[str],
    motor: str | None = None,
    words: Sequence[str] | None = None,
    *,
    override: bool = False,
) -> Bench:
    """Bench of the policies ``specs``.

    Parameters
    ----------
    motor : str, optional
        Machine asked for. By default that of the policies, or else the paper's.
    words : sequence of str, optional
        Settings asked for, NAME=VALUE.
    override : bool
        Let ``motor`` and ``words`` win over what a policy brings; of several machines without
        ``motor``, the first.

    Raises
    ------
    UserError
        Machine or settings contradict those of a policy, or policies are for several machines; or
        something that is named does not exist.
    """
    asked = asked_for(words)
    brought = {spec: known for spec in specs if (known := carried_by(spec)) is not None}
    machine = Motor.load(motor) if motor is not None else _machine(brought)
    if not override:
        why = "was asked for" if motor is not None else "comes with the first policy"
        for spec, known in brought.items():
            refuse_other(known, machine, spec, why)
            refuse_settings(known.settings, asked, spec, known.motor)
        for spec in specs if asked else ():
            if spec not in brought:
                refuse_settings(make_policy(spec, machine).settings, asked, spec)
    design = dataclasses.replace(DriveDesign(), **asked)
    notes = [_changed(spec, known, asked) for spec, known in brought.items()]
    if any(OF_ONE.match(name) for name in asked):
        own = (make_policy(spec, machine, override=override).settings for spec in specs)
        run = {str({**x, **asked}.get("estimator", design.estimator)) for x in own}
        run = run or {design.estimator}
        notes += [_idle(name, asked, run) for name in asked]
    return Bench(machine, design, asked, override, tuple(filter(None, notes)))


def _machine(brought: Mapping[str, Carried]) -> Motor:
    """Machine of the first policy that has one."""
    for spec, known in brought.items():
        if known.motor is not None:
            return known.motor
        if known.made_for is not None:
            name, digest = known.made_for
            raise UserError(
                f"motor: {spec} was made for {name}, digest {digest[:16]}, and does not hold its "
                "numbers: give its file with --motor"
            )
    return Motor.load(DEFAULT_MOTOR)


def _idle(name: str, asked: Mapping[str, Any], run: Set[str]) -> str:
    """A setting of an observer on which no policy runs; empty for others."""
    known = OF_ONE.match(name)
    users = USERS[known[1]] if known else ()
    ran = run | ({"coupled"} if asked.get("lost_lock") == "restart" else set())
    if not users or ran & set(users):
        return ""
    own = " and ".join(sorted(run))
    return f"{name} is for estimator={' or '.join(users)}; the drive has {own}"


def _changed(spec: str, known: Carried, asked: Mapping[str, Any]) -> str:
    """What has changed since a policy was made: defaults, or else formulas; empty for nothing."""
    defaults = [
        f"{name} ({text_of(then)}, now {text_of(now)})"
        for name, (then, now) in known.changed.items()
        if name not in asked
    ]
    if defaults:
        return f"{spec} was made with other defaults: {', '.join(defaults)}; {WHY}"
    parts = "" if known.changed else " and ".join(known.other_gains())
    return f"{spec} was made on other gains: its {parts} changed since; {WHY}" if parts else ""
