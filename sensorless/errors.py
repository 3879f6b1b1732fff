"""User errors, which the command line shows as one line without a traceback."""


class UserError(ValueError):
    """Wrong input: the message names the field and its value, and says what to do."""


class StaleCoreError(ImportError):
    """The compiled core is missing or older than its sources; the message says how to rebuild."""
