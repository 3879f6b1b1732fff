"""The README's table of fault bits: meaning from the headers of the core, and what to do."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from sensorless.export.core_files import core_files

_BIT = re.compile(r"\b(\w*FAULT_\w+) = (\d+),?\s*(?:\};\s*)?/\*(.*?)\*/", re.DOTALL)

DO = {
    "FAULT_CURRENT": "look for a broken wire, a wrong range, missed interrupts; stop if it repeats",
    "FAULT_U_DC": "look at the measurement of the link; below its least value do not start, below "
    "half of it open the bridge; above its largest control gives no voltage, injection and "
    "compensation go on: open the bridge",
    "FAULT_COMMAND": "correct what the application passes; the drive held a safe value meanwhile",
    "FAULT_POLE": "stop and start again at less load; if it repeats, start from a known angle",
    "FAULT_OVER_CURRENT": "open the bridge at once, find out why, then start as after a trip",
    "FAULT_LOCK": "let the drive recover if it does so; stop what needs speed or torque meanwhile; "
    "with `LOCK_STALL` in `lock.reason`, see whether the shaft is blocked, and open the bridge",
    "FAULT_STOPPED": "open the bridge at once: zero voltage shorts a motor that spins; find out "
    "why, then start as after a trip",
    "FAULT_STATE": "let it start anew; in the first period, call `drive_init` before; if it "
    "repeats, look for what overwrites memory",
    "KS_FAULT_TABLE": "run on, the linear rule decides; call the schedule's init first, or write "
    "the table to flash again",
    "KS_FAULT_INPUT": "run on; the sample behind it has a bit of its own, but in a "
    "drive with `ks_hook_step`: check what it is given",
    "KS_FAULT_GAINS": "run on, all gains are static; write the table to flash again",
    "KS_FAULT_PARAMS": "run on, the word is restored; if it repeats, look for what overwrites "
    "memory",
    "BRING_UP_FAULT_CURRENT": "look for a wrong scale or a short circuit",
    "BRING_UP_FAULT_MOVES": "let the shaft come to rest; correct the offset of the sensors",
    "BRING_UP_FAULT_DEAF": "switch the PWM on, connect the motor, check both scales",
    "BRING_UP_FAULT_DELAY": "move sample, interrupt, or the event that loads the duty registers",
    "BRING_UP_FAULT_SIGN": "invert both current channels, or the duties; with "
    "`BRING_UP_FAULT_PHASES`: look for one duty alone that is inverted",
    "BRING_UP_FAULT_PHASES": "exchange phases in the currents or in the duties, not in both",
    "BRING_UP_FAULT_WIRING": "look for a dead current channel, one of another gain, an open phase",
    "BRING_UP_FAULT_CHANNEL": "invert that channel, or the duty of its phase",
    "BRING_UP_FAULT_SCALE": "check the duty formula of each leg, scale of each current and of the "
    "link, and L_d; look for an open phase; a shaft that turns slowly shows like this, too",
    "BRING_UP_FAULT_DEAD_TIME": "switch the driver's compensation off, or export with "
    "`--set dead_time_share=0`",
    "BRING_UP_FAULT_STATE": "check again, from `bring_up_init` on; if it repeats, look for what "
    "overwrites memory",
}
"""What the application should do. A bit that is not here tells only what it means."""
GUESSED = (
    "stop: the drive starts anew, but on a guessed pole, and may turn the wrong way; start from a "
    "known angle, as after a trip; if it repeats, look for what overwrites memory"
)
"""The same for ``FAULT_STATE`` on a machine that shows no pole at rest."""


@dataclass(frozen=True)
class Bit:
    """One bit of a fault word."""

    name: str
    value: int
    meaning: str


def bits(gains: bool = True) -> Iterator[Bit]:
    """Every fault bit of the core, header by header; ``gains``: also of what sets gains."""
    for name, content in core_files(gains).items():
        if name.endswith(".h"):
            for bit, value, comment in _BIT.findall(content.decode()):
                if bit.endswith("_ALL"):  # a mask
                    continue
                yield Bit(bit, int(value), " ".join(re.sub(r"\n\s*\*", " ", comment).split()))


def _rows(found: list[Bit], do: Mapping[str, str]) -> str:
    return "\n".join(
        f"| {b.value} | `{b.name}` | {b.meaning} | {do.get(b.name, '')} |" for b in found
    )


def fault_tables(gains: bool = True, dead_time: bool = True, finds: bool = True) -> dict[str, str]:
    """Rows for the README by the word that holds the bits: ``drive``, ``schedule``, ``check``.

    ``dead_time``: whether the check judges it; ``finds``: whether the drive finds its pole.
    """
    found = sorted(bits(gains), key=lambda bit: bit.value)
    if not dead_time:
        found = [b for b in found if b.name != "BRING_UP_FAULT_DEAD_TIME"]
    heads = {"drive": "FAULT_", "schedule": "KS_FAULT_", "check": "BRING_UP_FAULT_"}
    do = DO if finds else {**DO, "FAULT_STATE": GUESSED}
    return {
        word: _rows([b for b in found if b.name.startswith(head)], do)
        for word, head in heads.items()
    }
