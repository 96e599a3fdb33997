"""What is wrong with an option."""

from __future__ import annotations


class OptionError(ValueError):
    """An option has a value that makes no sense.

    Parameters
    ----------
    name
        Of the option.
    message
        What was found, and what is expected.
    """

    def __init__(self, name: str, message: str) -> None:
        super().__init__(message)
        self.name = name
