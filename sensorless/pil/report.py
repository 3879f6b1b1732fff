"""Prints a processor-in-the-loop report as a table and writes it as a file."""

import json
from pathlib import Path
from typing import Any

from sensorless.design.words import observer_name
from sensorless.files import write_atomic
from sensorless.plain_table import PlainTable

NAMES = {
    "period": "period with schedule",
    "drive_step": "  control step alone",
    "lookup_f32": "  lookup, float table",
    "lookup_q15": "  lookup, Q15 table",
    "part_hfi": "  injection estimator",
    "part_smo": "  sliding-mode observer",
    "part_control": "  speed and current control",
    "part_signals": "  signals of the schedule",
    "part_decide": "  a decision of the schedule",
    "part_mend": "  to mend a damaged state, on top",
}


def table(report: dict[str, Any]) -> PlainTable:
    """Table of comparisons, instructions and memory."""
    out = PlainTable(title=f"{report['policy']}, {report['motor']}: host against Cortex-M4F (QEMU)")
    out.add_column("")
    for name in ("min", "mean", "max"):
        out.add_column(name, justify="right")
    lost = [f"{s['name']} ({s['lost']})" for s in report["scenarios"] if s["lost"]]
    out.add_row("control periods compared", "", "", f"{report['periods']:,}")
    out.add_row("  words that differ", "", "", f"{report['mismatches']:,}")
    out.add_row("lookups compared", "", "", f"{report['lookups']:,}")
    out.add_row("  words that differ", "", "", f"{report['lookup_mismatches']:,}")
    out.add_row("failed tests on the target", "", "", f"{sum(report['target_tests'].values()):,}")
    out.add_row("fused multiply-adds in the image", "", "", f"{report['fused_instructions']:,}")
    out.add_row("scenarios", "", "", f"{len(report['scenarios'])}")
    out.add_row(f"  lost: {', '.join(lost) or 'none'}", "", "", f"{len(lost)}", end_section=True)
    out.add_row("instructions", style="bold")
    for name, spread in report["instructions"].items():
        if name == "part_smo" and observer_name(report["estimator"]) != "SMO":
            continue  # measured alone; this drive has another observer
        out.add_row(NAMES[name], *(f"{spread[key]:,.0f}" for key in ("min", "mean", "max")))
    out.add_section()
    out.add_row("bytes", style="bold")
    out.add_row("flash: control core, parameters, table", "", "", f"{report['flash_core']:,}")
    out.add_row("  table and its check", "", "", f"{report['flash_table_and_check']:,}")
    for name, part in report["memory"].items():
        sizes = ", ".join(f"{section} {n:,}" for section, n in part.items() if n)
        out.add_row(f"  {name}: {sizes}")
    out.add_row("RAM: state of a drive and its schedule", "", "", f"{report['ram_state']:,}")
    out.add_row("  stack of a period, calls included", "", "", f"{report['stack']:,}")
    return out


def write_report(report: dict[str, Any], path: Path) -> None:
    """Write a report as JSON, whole or not at all."""
    write_atomic(path, json.dumps(report, indent=2) + "\n")
