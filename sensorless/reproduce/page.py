"""The reproduction as a page and as data, in three columns: paper, ours as published, corrected."""

import json
from collections.abc import Sequence
from dataclasses import asdict

from sensorless.design.carried import worded
from sensorless.design.derived import derive
from sensorless.machine.motor import Motor
from sensorless.reproduce.case import CORRECTED, NOT_SWITCHABLE, PUBLISHED, Case, Cell, Row
from sensorless.settings import AUTO
from sensorless.versions import versions

DOI = "10.12177/emca.2025.011"


def markdown(cases: Sequence[Case], motor: Motor) -> str:
    """Text of the page; pictures are named after their cases."""
    parts = [
        "# The source paper and this drive",
        "Written by `sensorless reproduce`. The paper is *Full-speed-range position sensorless "
        f"control of interior permanent magnet synchronous motors*, doi {DOI}; its column has the "
        f"values that its text gives. The other columns are our simulation of the motor "
        f"`{motor.name}`, whose saturation, dead time and noise are assumptions; the pictures show "
        "our runs, and the values of the paper as lines. k_s is the weight between injection (1) "
        "and the sliding-mode observer (0), and Eq. 25 is the paper's linear rule for it.",
        f"**As published** is our drive with its corrections switched off: {_differences(motor)}.",
        "No switch undoes these, so both columns share them:",
        "\n".join(f"- {text}" for text in NOT_SWITCHABLE),
    ]
    for case in cases:
        parts.append(f"## {case.title}")
        parts.append(case.setting[0].upper() + case.setting[1:] + ".")
        head = "| | unit | paper | as published | corrected |\n|---|---|---|---|---|"
        parts.append("\n".join([head, *(_line(row) for row in case.rows)]))
        parts.append(f"**Why:** {case.why}")
        if case.figure is not None:
            parts.append(f"![{case.title}]({case.name}.png)")
    return "\n\n".join(parts) + "\n"


def _line(row: Row) -> str:
    cells = (_text(value, row.decimals) for value in (row.published, row.corrected))
    return f"| {row.quantity} | {row.unit} | {row.paper} | {' | '.join(cells)} |"


def _text(cell: Cell, decimals: int) -> str:
    if isinstance(cell, bool):
        return "yes" if cell else "no"
    if isinstance(cell, float):
        return f"{cell:.{decimals}f}".replace("-", "−") if cell == cell else "lost"
    return "–" if cell is None else cell


def _differences(motor: Motor) -> str:
    """Settings as published; a corrected one that follows from the motor with its number."""
    ours, numbers = asdict(CORRECTED), asdict(derive(motor, CORRECTED))
    return ", ".join(
        f"`{name}={_word(value)}` (corrected "
        f"`{_word(ours[name]) if ours[name] is not None else f'{AUTO} = {numbers[name]:.4g}'}`)"
        for name, value in asdict(PUBLISHED).items()
        if value != ours[name]
    )


def _word(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else f"{value}"


def data(cases: Sequence[Case], motor: Motor) -> str:
    """JSON of all rows, with the designs and versions behind them."""
    known = versions()
    return (
        json.dumps(
            {
                "doi": DOI,
                "command": "sensorless reproduce",
                "motor": motor.name,
                "motor_digest": motor.digest,
                "versions": {name: known[name] for name in ("sensorless", "core")},
                "designs": {
                    "published": worded(asdict(PUBLISHED)),
                    "corrected": worded(asdict(CORRECTED)),
                },
                "not_switchable": list(NOT_SWITCHABLE),
                "cases": {
                    case.name: {
                        "title": case.title,
                        "setting": case.setting,
                        "rows": {row.quantity: row.facts() for row in case.rows},
                        "why": case.why,
                    }
                    for case in cases
                },
            },
            indent=1,
            ensure_ascii=False,
            allow_nan=False,
        )
        + "\n"
    )
