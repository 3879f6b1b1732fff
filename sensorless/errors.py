"""Errors that are the user's to mend; the command line shows them as one line."""


class UserError(ValueError):
    """Something the user gave is wrong: the message names field, value and what is allowed."""


class StaleCoreError(ImportError):
    """The compiled core is missing or older than its sources; the message says how to rebuild."""
