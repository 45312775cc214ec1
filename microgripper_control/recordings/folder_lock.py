"""Who writes a bag says so, and who would replace it asks."""

from __future__ import annotations

import fcntl
import os
from pathlib import Path

from microgripper_control.core.errors import MicrogripperError


class FolderLock:
    """Keeps a folder from all others that lock it, until `close` or the death of the process.

    Raises MicrogripperError where another has it. A file system that knows no locks grants all.
    """

    def __init__(self, folder: Path) -> None:
        self._handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            fcntl.flock(self._handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self.close()
            raise MicrogripperError(
                f"{folder}: is being written; stop the recorder first"
            ) from None
        except OSError:
            pass

    def close(self) -> None:
        """Let others have it; once."""
        os.close(self._handle)
