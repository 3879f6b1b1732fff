"""Turns a schedule table into a folder that drops into any C project and checks itself."""

import shutil
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from sensorless.baselines.linear import EQ25_BAND, eq25_band
from sensorless.core.bring_up import periods_of
from sensorless.decision import RUNNING, whole_periods
from sensorless.design.drive import DriveDesign
from sensorless.design.records import bring_up_record, control_record
from sensorless.errors import UserError
from sensorless.export.cmsis import cmsis_files
from sensorless.export.code import params_header, params_source
from sensorless.export.core_files import FIRMWARE, core_files
from sensorless.export.fit import readme as rule_readme
from sensorless.export.fit import two_threshold
from sensorless.export.folder import (
    SUMS,
    TABLE_JSON,
    check_replaceable,
    sums,
    write_folder,
)
from sensorless.export.gains import gain_params
from sensorless.export.hook import hook_header, hook_source
from sensorless.export.judge import Judged, verdict
from sensorless.export.provenance import motor_hash, provenance_text, table_json
from sensorless.export.readme import readme
from sensorless.export.selftest import SelfTest, run_selftest
from sensorless.export.start import spin_text, start_define
from sensorless.export.tables import drive_vectors_header, table_header, table_source
from sensorless.export.vectors import drive_vectors, table_vectors
from sensorless.files import ensure_writable, part_of, put, reason
from sensorless.machine.motor import Motor
from sensorless.policy import Policy, TablePolicy
from sensorless.table.ks_table import KsTable

TESTS = ("selftest.c", "arithmetic.c", "arithmetic.h", "faults.c", "faults.h")
"""Of ``firmware/``, into every export."""
EXAMPLES = ("cortex_m4.c", "foreign_drive.c")
"""Of ``firmware/example/``, likewise."""


@dataclass(frozen=True)
class Exported:
    """What ``export`` wrote."""

    folder: Path
    files: tuple[str, ...]
    self_test: SelfTest


def export(
    table: KsTable,
    motor: Motor,
    design: DriveDesign,
    folder: str | Path,
    *,
    policy: str = "table",
    provenance: Mapping[str, Any] | None = None,
    fit: bool = False,
    judged: Judged | None = None,
) -> Exported:
    """Write the folder, whole or not at all, after its self test has passed on this host.

    Parameters
    ----------
    table, motor, design
    folder : str or Path
        A new or empty folder, or an earlier export, which is replaced.
    policy : str
        Name of the schedule in the folder's texts.
    provenance : mapping, optional
        JSON types that replace the table's own: training command, seed, versions, ...
    fit : bool
        Also find the two speed thresholds closest to the table, and what they cost; takes seconds.
    judged : Judged, optional
        Verdict that the README opens with.

    Raises
    ------
    UserError
        The table is for another motor or slew limit, a number is not finite, the folder cannot be
        written to or holds other files, or the self test fails.
    """
    table = with_rule(table, motor)
    origin = {**table.provenance, **(provenance or {}), "policy": policy}
    _check_origin(origin, table, motor, design)
    target = Path(folder).resolve()
    check_replaceable(target)
    ensure_writable(target.parent)
    periods = whole_periods(RUNNING, motor)
    rule = two_threshold(table, motor, design) if fit else None
    if rule is not None:
        origin["two_threshold"] = rule
    if judged is not None:
        origin["judged"] = judged.facts()
    texts = verdict(judged), rule_readme(rule), spin_text(motor, design)
    files = _contents(table, motor, design, policy, periods, texts)
    files["PROVENANCE.txt"] = provenance_text(table, motor, design, origin, texts[0]).encode(
        "utf-8", "backslashreplace"
    )
    files[TABLE_JSON] = table_json(table, motor, design, origin, files).encode()
    files[SUMS] = sums(files).encode()
    part = part_of(target)
    try:
        write_folder(part, files)
        self_test = run_selftest(part)
        put(part, target)
    except OSError as error:
        raise UserError(
            f"output folder {str(target)!r}: {reason(error)}; give a folder that can be written to"
        ) from None
    finally:
        shutil.rmtree(part, ignore_errors=True)
    return Exported(target, tuple(sorted(files)), self_test)


def with_rule(table: KsTable, motor: Motor) -> KsTable:
    """The table with Eq. 25 of its machine in the place of the paper's, for when it is damaged.

    A rule of the table's own stays.
    """
    usual = table.rule == tuple(float(np.float32(x)) for x in EQ25_BAND)
    return replace(table, rule=eq25_band(motor)) if usual else table


def table_of(policy: Policy, word: str) -> KsTable:
    """Return the table of a policy.

    Raises
    ------
    UserError
        It has none; ``word`` is the user's name for it.
    """
    if not isinstance(policy, TablePolicy):
        raise UserError(
            f"run: {word!r} is not a table of the drive's signals; export a training run, a rule "
            "that is a table, such as eq25, linear, smoothstep, fuzzy or constant:K, or what "
            "sensorless distill makes of a policy in Python"
        )
    return policy.table


def _check_origin(
    origin: Mapping[str, Any], table: KsTable, motor: Motor, design: DriveDesign
) -> None:
    made_for = str(origin.get("motor_digest", motor.digest))
    if made_for != motor.digest:
        raise UserError(
            f"motor: {motor.name!r}, digest {motor.digest[:16]}; give the machine that the policy "
            f"was made for, digest {made_for[:16]}"
        )
    if table.slew_per_s != float(np.float32(design.k_s_slew)):
        raise UserError(
            f"k_s_slew: {design.k_s_slew:g} 1/s; the policy's table was made for "
            f"{table.slew_per_s:g} 1/s: use that"
        )


def _contents(
    table: KsTable,
    motor: Motor,
    design: DriveDesign,
    policy: str,
    periods: int,
    texts: tuple[str, str, str],
) -> dict[str, bytes]:
    """Every file of the folder except ``ks_table.json``; ``texts`` of the README: see there."""
    lookups_f32, lookups_q15 = table_vectors(table, "f32"), table_vectors(table, "q15")
    run = drive_vectors(table, motor, design, periods)
    tag = motor_hash(motor)
    cmsis = cmsis_files(table)
    drive = control_record(motor, design)
    tests = [*TESTS, *(("cmsis.c", "cmsis.h") if cmsis else ())]
    vectors = len(lookups_f32), len(run.words)
    check = bring_up_record(motor, compensates=bool(drive["control"]["u_dt"] > 0.0))
    check_time = motor.T_s * periods_of(check)
    text = {
        "README.md": readme(
            table, motor, drive, check_time, policy, design.estimator, periods, vectors, texts
        ),
        **cmsis,
        "params.h": params_header(motor, start_define(motor), bool(table.gains)),
        "params.c": params_source(drive, check, table.rule, periods, gain_params(table, periods)),
        "ks_hook_params.h": hook_header(),
        "ks_hook_params.c": hook_source(motor, drive, table, periods),
        "ks_table_data.h": table_header(table, len(lookups_f32), bool(cmsis)),
        "ks_table_data.c": table_source(table, "f32", tag, lookups_f32, periods * motor.T_s),
        "ks_table_q15.c": table_source(table, "q15", tag, lookups_q15, periods * motor.T_s),
        "test/drive_vectors.h": drive_vectors_header(run),
    }
    return {
        **{name: content.encode("utf-8", "backslashreplace") for name, content in text.items()},
        "Makefile": (FIRMWARE / "selftest.mk").read_bytes(),
        "LICENSE": (FIRMWARE / "LICENSE").read_bytes(),
        **{f"test/{name}": (FIRMWARE / name).read_bytes() for name in tests},
        **{f"example/{name}": (FIRMWARE / "example" / name).read_bytes() for name in EXAMPLES},
        **{f"core/{name}": content for name, content in core_files(bool(table.gains)).items()},
    }
