"""User errors, which the command line shows as one line without a traceback."""

from collections.abc import Callable, Iterable
from difflib import get_close_matches
from unicodedata import category


class UserError(ValueError):
    """Wrong input: the message names the field and its value, and says what to do."""


def in_one_line(main: Callable[[], None]) -> None:
    """Run a script; a user's error ends it with status 1 and one line instead of a traceback."""
    try:
        main()
    except UserError as error:
        raise SystemExit(f"error: {error}") from None


LONGEST = 80
"""Characters of a value that a message shows."""


def shown(value: object) -> str:
    """A value as a message names it: as Python writes it, at most ``LONGEST`` characters."""
    try:
        text = repr(value)
    except ValueError:  # Python writes no whole number of so many digits
        text = "a number of too many digits"
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 4]} ..."


def like(name: str, known: Iterable[str]) -> str:
    """A question with the known name most like a wrong one, to go before advice; or nothing."""
    near = get_close_matches(name, list(known), n=1, cutoff=0.7)
    return f"did you mean {near[0]}? " if near else ""


def has_control(text: str) -> bool:
    """Whether a text has characters that break or turn lines: control, format, line ends."""
    return any(category(character) in ("Cc", "Cf", "Zl", "Zp") for character in text)


class StaleCoreError(ImportError):
    """The compiled core is missing or older than its sources; the message says how to rebuild."""
