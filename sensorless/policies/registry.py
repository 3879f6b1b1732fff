"""Policies by the names that commands take."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from sensorless.agents.loading import carried_by_run, load_run, load_table
from sensorless.baselines import (
    constant,
    emf_threshold,
    fusion,
    fuzzy,
    gated,
    grid,
    hysteresis,
    linear,
    logistic,
    on_estimator,
    oracle,
    physics_threshold,
    ramp,
    sensored,
    smooth,
)
from sensorless.baselines.rule import Rule
from sensorless.design.carried import Carried, carried
from sensorless.errors import UserError, like
from sensorless.files import as_text
from sensorless.machine.motor import Motor
from sensorless.policies import shipped
from sensorless.policies.python import is_python, python_policy
from sensorless.policies.tuned import Tuned
from sensorless.policy import Policy, TablePolicy
from sensorless.table.json_form import is_table
from sensorless.table.ks_table import KsTable

RULES: dict[str, Rule] = {
    rule.name: rule
    for rule in (
        linear.EQ25,
        linear.RULE,
        smooth.SMOOTHSTEP,
        smooth.SINE,
        smooth.QUADRATIC,
        hysteresis.RULE,
        ramp.RULE,
        gated.RULE,
        emf_threshold.RULE,
        physics_threshold.RULE,
        fusion.RULE,
        on_estimator.SLIDING_MODE,
        on_estimator.ERROR_BLEND,
        on_estimator.FLUX_OBSERVER,
        fuzzy.RULE,
        logistic.RULE,
        grid.RULE,
        constant.RULE,
        constant.HFI,
        constant.SMO,
        oracle.RULE,
        sensored.RULE,
    )
}
"""Every rule by name."""

TUNED = "tuned:FILE.json"
RUN = "RUN"
PYTHON = "MODULE:NAME"


def known() -> dict[str, str]:
    """Names that ``make_policy`` understands, and what each policy is."""
    return {
        **{rule.usage: rule.doc for rule in RULES.values()},
        **shipped.docs({rule.name: rule.estimator for rule in RULES.values()}),
        TUNED: "rule that sensorless tune wrote; FILE.json alone also works",
        RUN: "policy of a training run; give the path of its folder",
        PYTHON: "your own policy: a Python class or function of the motor that gives it",
    }


def rule_named(name: str) -> Rule:
    """Rule by name.

    Raises
    ------
    UserError
        No such rule.
    """
    if name not in RULES:
        raise UserError(
            f"rule: {name!r} does not exist; {like(name, RULES)}choose from {', '.join(RULES)}"
        )
    return RULES[name]


def make_policy(spec: str, motor: Motor, *, override: bool = False) -> Policy:
    """Policy by a name as in ``known``, for one motor.

    The name of a rule takes precedence over a folder or file of that name; ``./NAME`` means the
    folder.

    Raises
    ------
    UserError
        The name is unknown, a number is out of its range, the schedule is for another machine and
        ``override`` is not set, or Python code fails.
    """
    word, colon, text = spec.partition(":")
    if word in RULES:
        rule = RULES[word]
        return rule.build(spec, rule.parse(spec, text if colon else None, motor), motor)
    if word != "tuned" and is_python(spec):
        return python_policy(spec, motor)
    path = file_of(spec)
    if path.is_dir():
        learned = load_run(path, motor, override=override)
        learned.name = spec if spec in {*shipped.RUNS, *shipped.ALIASES} else learned.name
        return learned
    loaded = (
        load_table(path, motor, override=override) if is_table(path) else load_tuned(path, motor)
    )
    loaded.name = spec if spec in shipped.ALIASES else loaded.name
    return loaded


def carried_by(spec: str) -> Carried | None:
    """Machine and settings that a file brings along; None for a rule by its name, or Python.

    Raises
    ------
    UserError
        The name is unknown, or its file is damaged.
    """
    word = spec.partition(":")[0]
    if word in RULES or (word != "tuned" and is_python(spec)):
        return None
    path = file_of(spec)
    if path.is_dir():
        return carried_by_run(path)
    if is_table(path):
        return carried(KsTable.load(path).provenance, str(path))
    tuned = Tuned.load(path)
    known = tuned.carried(str(path))
    own = RULES[tuned.rule].estimator if tuned.rule in RULES else None
    return known if own is None else replace(known, settings={**known.settings, "estimator": own})


def file_of(spec: str) -> Path:
    """Run folder, or file of a tuned rule or a table; the file need not exist.

    Raises
    ------
    UserError
        There is no policy of this name.
    """
    spec = shipped.ALIASES.get(spec, spec)
    word, colon, text = spec.partition(":")
    if word.endswith(shipped.SUFFIX) and shipped.tuned_file(word).is_file() and not colon:
        return shipped.tuned_file(word)
    if spec in shipped.learned_names():
        return shipped.learned_file(spec)
    run = shipped.reference_run(spec)
    if run is not None:
        return run
    if word == "tuned" and text:
        return Path(text)
    if (spec and Path(spec).is_dir()) or spec.endswith(".json"):
        return Path(spec)
    if spec.endswith(".toml"):
        raise UserError(f"policy: {spec!r} is a motor file; give it to --motor")
    if Path(spec).is_file():
        raise UserError(
            f"policy: {spec!r} is no .json file that tune wrote; give one, or the folder of a "
            "training run"
        )
    if Path(spec).name != spec:
        raise UserError(
            f"policy: there is no folder {spec!r}; give that of a training run, or a .json file"
        )
    made = *shipped.RUNS, *shipped.ALIASES, *shipped.learned_names(), *shipped.tuned_names()
    names = ", ".join((*RULES, *made, TUNED, RUN, PYTHON))
    rule_name = spec.removesuffix(shipped.SUFFIX)
    if rule_name in RULES:
        raise UserError(
            f"policy: {spec!r}: results/reference/tuned/{spec}.json does not exist; make one with "
            f"'sensorless tune {rule_name} --out FILE.json', or choose from {names}"
        )
    advice = (not colon and like(spec, (*RULES, *made))) or f"choose from {names}; "
    raise UserError(
        f"policy: {spec!r} is not a rule, folder or file; {advice}'sensorless evaluate --list' "
        "explains all"
    )


def make_policies(
    specs: Sequence[str], motor: Motor, *, override: bool = False
) -> dict[str, Policy]:
    """Policies by name; where two have the same name, the second goes by all that was given.

    Raises
    ------
    UserError
        A policy is given twice, or as in `make_policy`.
    """
    out: dict[str, Policy] = {}
    for spec in specs:
        policy = make_policy(spec, motor, override=override)
        name = spec if policy.name in out else policy.name
        if name in out:
            raise UserError(f"policy: {spec!r} is given twice; give each policy once")
        out[name] = policy
    return out


def table_named(spec: str, motor: Motor) -> KsTable:
    """Table of a policy, for training to start from: its numbers, whatever it was made for.

    Raises
    ------
    UserError
        The policy has no table, or as in `make_policy`.
    """
    try:
        policy = make_policy(spec, motor, override=True)
    except UserError as error:
        raise UserError(f"start: {error}") from None
    if not isinstance(policy, TablePolicy):
        raise UserError(
            f"start: {spec!r} has no table; start from eq25, linear:LO,HI [r/min], logistic, a "
            "file that sensorless tune wrote, or the folder of a run with a table"
        )
    return policy.table


def load_tuned(path: Path, motor: Motor) -> Policy:
    """Policy of a tuned rule, named after its file. Its parameters scale with the machine.

    It brings the settings that it was tuned on, and keeps an estimator of its own.

    Raises
    ------
    UserError
        The file does not exist or is damaged, or its rule does not take its parameters.
    """
    tuned = Tuned.load(path)
    if tuned.rule not in RULES:
        raise UserError(
            f"{path}: rule: {tuned.rule!r} does not exist; choose from {', '.join(RULES)}"
        )
    rule = RULES[tuned.rule]
    names = [p.name for p in rule.parameters]
    if sorted(tuned.parameters) != sorted(names) or not rule.allows(tuned.parameters):
        raise UserError(
            f"{path}: parameters: {dict(tuned.parameters)!r}; give those of {rule.usage}, each in "
            "its range"
        )
    policy = rule.build(as_text(path.stem), tuned.parameters, motor)
    policy.settings = {**tuned.carried(str(path)).settings, **policy.settings}
    return policy
