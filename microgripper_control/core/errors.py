"""The one error this package raises for what a user can mend."""


class MicrogripperError(Exception):
    """Bad input: the message is one line that names the file, the key, the value and the remedy.

    The command line prints it on standard error and exits with status 2. A programming error is
    never wrapped in it.
    """
