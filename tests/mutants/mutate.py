"""Small changes to C code, each a mistake that someone could make."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

LEFT_OUT = ("compiler.h", "vector.h", "ks_selftest.c", "ks_selftest.h", "drive_types.h",
            "ks_types.h")  # fmt: skip
"""No logic of the drive: compilers, vector code, the comparison with golden vectors, declarations.
What belongs to gain schedules (``gain*``) has tests of its own."""

RULES: tuple[tuple[str, str, str], ...] = (
    ("plus to minus", r"(?<=[\w)\]]) \+ (?=[\w(])", " - "),
    ("minus to plus", r"(?<=[\w)\]]) - (?=[\w(])", " + "),
    ("dropped term", r"(?<=[\w)\]]) ([+-]) (?=[\w(])", r" \1 0 * "),
    ("term 10 % larger", r"(?<=[\w)\]]) ([+-]) (?=[\w(])", r" \1 1.1f * "),
    ("value 10 % larger", r"(?<=[^=!<>+*/-]) = (?=[\w(-][^;{]*;)(?![\w.>-]+ \?)", " = 1.1f * "),
    ("growth 10 % larger", r"([+-])= ", r"\1= 1.1f * "),
    ("growth reversed", r" \+= ", " -= "),
    ("times to divided", r"(?<=[\w)\]]) \* (?=[\w(])", " / "),
    ("sign lost", r"(?<=[(=,?:] )-(?=[\w(])|(?<=\()-(?=[\w(])", ""),
    ("less to greater", r" < ", " > "),
    ("less or equal", r" < ", " <= "),
    ("greater to less", r" > ", " < "),
    ("greater or equal", r" > ", " >= "),
    ("without equal", r" ([<>])= ", r" \1 "),
    ("not greater", r" >= ", " < "),
    ("not less", r" <= ", " > "),
    ("equal to unequal", r" == ", " != "),
    ("unequal to equal", r" != ", " == "),
    ("and to or", r" && ", " || "),
    ("or to and", r" \|\| ", " && "),
    ("min to max", r"\bmin_f\(", "max_f("),
    ("max to min", r"\bmax_f\(", "min_f("),
    ("no bound", r"\bbound_f\((?=[^;]*;)", "(0.0f, "),
    ("choice turned", r" \? ([^?:;]+) : ([^?:;,()]+)(?=[;,)])", r" ? \2 : \1"),
    ("number 10 % larger", r"(?<![\w.])(\d+\.\d*(?:e[+-]?\d+)?)f\b", r"(1.1f * \1f)"),
    ("integer 1 larger", r"(?<![\w.])(\d+)(?![\w.])", r"(\1 + 1)"),
    ("axes swapped", r"\.([ab]) = ", ""),
)
"""Name, pattern, what comes in its place; the last assigns to the other axis."""


@dataclass(frozen=True)
class Mutant:
    """One change: file, line, and the line before and after."""

    file: str
    line: int
    rule: str
    before: str
    after: str
    text: str
    """The whole file with the change."""

    @property
    def name(self) -> str:
        """Where and what."""
        return f"{self.file}:{self.line}: {self.rule}"


def _hidden(text: str) -> list[tuple[int, int]]:
    """Comments and preprocessor lines, as spans."""
    found = re.finditer(
        r"/\*.*?\*/|^#[^\n]*?(?:\\\n[^\n]*)*$", text, flags=re.DOTALL | re.MULTILINE
    )
    return [m.span() for m in found if not re.match(r"#define \w+ [\d(]", m.group())]


def mutants_of(path: Path) -> Iterator[Mutant]:
    """Every change that a rule makes to one file."""
    text = path.read_text(encoding="utf-8")
    hidden = _hidden(text)
    for rule, pattern, new in RULES:
        for m in re.finditer(pattern, text):
            if any(a <= m.start() < b for a, b in hidden):
                continue
            put = m.expand(new)
            if rule == "axes swapped":
                put = f".{'b' if m.group(1) == 'a' else 'a'} = "
            changed = text[: m.start()] + put + text[m.end() :]
            line = text.count("\n", 0, m.start()) + 1
            before, after = (t.split("\n")[line - 1].strip() for t in (text, changed))
            yield Mutant(path.name, line, rule, before, after, changed)


def all_mutants(drive: Path) -> list[Mutant]:
    """Mutants of every file in ``drive`` that is not left out, in a fixed order."""
    paths = [path for path in sorted(drive.glob("*.[ch]")) if path.name not in LEFT_OUT]
    return [m for path in paths if not path.name.startswith("gain") for m in mutants_of(path)]
