"""How the program meets its surroundings: signals that end it, and terminals without Unicode."""

import codecs
import contextlib
import os
import signal
import sys
import threading
import unicodedata
from collections.abc import Iterator
from types import FrameType
from typing import Any

from rich.console import Console
from rich.text import Text

ENDING = ("SIGTERM", "SIGHUP")
"""Signals that end the program as Ctrl-C does: work is kept. Windows lacks the second."""
SOON = 0.05
"""Time [s] after which a signal comes again whose exception Python could not raise."""
WORDS = {
    "°": "deg", "²": "2", "³": "3", "−": "-", "–": "-", "—": "-", "·": "*", "×": "x", "→": "->",
    "±": "+-", "≥": ">=", "≤": "<=", "…": "...", "’": "'", "α": "alpha", "β": "beta", "γ": "gamma",
    "θ": "theta", "ω": "omega", "ψ": "psi", "τ": "tau", "σ": "sigma", "ρ": "rho", "µ": "u",
    "μ": "u", "Ω": "ohm", "√": "sqrt", "Δ": "d", "━": "-", "█": "#",
}  # fmt: skip


NARROWEST = 80
"""Columns below which tables would cut their numbers: there the terminal breaks their lines."""
WIDEST = 10_000
"""Columns of a terminal, from which on ``COLUMNS`` is taken for a mistake."""


class Signalled(KeyboardInterrupt):
    """A signal asks the program to end."""


@contextlib.contextmanager
def ended_by_signals() -> Iterator[list[int]]:
    """Turn the signals that end a program into Ctrl-C; yields the numbers of those that came.

    A signal that is ignored, as under ``nohup``, stays ignored. One that meets a destructor or a
    callback, which no exception leaves, comes again after ``SOON``.
    """
    came: list[int] = []
    hook = sys.unraisablehook

    def interrupt(number: int, frame: FrameType | None) -> None:
        came.append(number)
        raise Signalled

    def again(failed: "sys.UnraisableHookArgs") -> None:
        if isinstance(failed.exc_value, Signalled):
            timer = threading.Timer(SOON, os.kill, (os.getpid(), came[-1]))
            timer.daemon = True
            timer.start()
        else:
            hook(failed)

    before: dict[int, Any] = {}
    for name in ENDING:
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) == signal.SIG_DFL:
            with contextlib.suppress(ValueError):  # not the main thread
                before[number] = signal.signal(number, interrupt)
    sys.unraisablehook = again
    try:
        yield came
    finally:
        sys.unraisablehook = hook
        for number, handler in before.items():
            signal.signal(number, handler)


def spelled(text: str) -> str:
    """Return a text in ASCII: signs as words, letters without accents, the rest as ``?``."""
    return "".join(map(_letters, text))


def _letters(sign: str) -> str:
    if sign.isascii():
        return sign
    bare = unicodedata.normalize("NFKD", sign).encode("ascii", "ignore").decode()
    return WORDS.get(sign) or bare or "?"


def _spell(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return spelled(error.object[error.start : error.end]), error.end


def _quiet(failed: "threading.ExceptHookArgs") -> None:
    """Say nothing of a thread that could not write: the main thread meets the same and says so."""
    if not isinstance(failed.exc_value, OSError):
        threading.__excepthook__(failed)


def open_streams() -> None:
    """Let input, output and errors that a parent has closed be empty ones.

    Otherwise a file of the program would take the number of the stream, and what is said to the
    stream would end up in it.
    """
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        if getattr(sys, name) is None:
            opened = os.open(os.devnull, os.O_RDWR)
            if opened != number:
                os.dup2(opened, number)
                os.close(opened)
            setattr(sys, name, open(number, "w" if number else "r", encoding="utf-8"))


def ignore_no_width() -> None:
    """Forget a ``COLUMNS`` that no terminal has: at 0 every table would be empty."""
    text = os.environ.get("COLUMNS", "")
    if text.isdigit() and not (text.isdecimal() and 0 < int(text[:9]) <= WIDEST):
        del os.environ["COLUMNS"]


def never_fail_to_print() -> None:
    """Let output that lacks a sign spell it; a full disk is said once, by the main thread."""
    open_streams()
    ignore_no_width()
    threading.excepthook = _quiet
    codecs.register_error("spelled", _spell)
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            reconfigure(errors="spelled")


class AnyConsole(Console):
    """A console that prints text as it is, without markup: a path may have brackets or :x:.

    Its tables stay in line where its output lacks a sign, and keep their numbers where it is
    narrow.
    """

    def __init__(self, **how: Any) -> None:
        ignore_no_width()  # a console reads it when it is made
        super().__init__(markup=False, emoji=False, **how)
        if self.width < NARROWEST:
            self.width = NARROWEST

    def render_str(self, text: str, **how: Any) -> Text:
        """Text of a cell or a line, spelled if need be."""
        try:
            text.encode(self.encoding)
        except UnicodeEncodeError:
            text = spelled(text)
        return super().render_str(text, **how)
