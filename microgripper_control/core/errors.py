"""The one error this package raises for what a user can mend."""

from __future__ import annotations


def one_line(text: str) -> str:
    """The text with every character that is not printed replaced by its escape.

    Names and values come from other people's files: they may neither break the line nor steer the
    terminal.
    """
    return "".join(
        character if character.isprintable() else character.encode("unicode_escape").decode()
        for character in text
    )


class MicrogripperError(Exception):
    """Bad input: the message is one line that names the file, the key, the value and the remedy.

    The command line prints it on standard error and exits with status 2. A programming error is
    never wrapped in it.
    """

    def __str__(self) -> str:
        return one_line(super().__str__())


class TooStiffError(MicrogripperError):
    """Values that no step of a simulation is short enough for."""
