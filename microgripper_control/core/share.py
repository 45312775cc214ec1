"""Where the files are that come with the package but are no code: `config/` and `launch/`."""

from __future__ import annotations

from pathlib import Path

from microgripper_control.core.errors import MicrogripperError

PACKAGE = Path(__file__).resolve().parents[1]


def share_folder(package: Path = PACKAGE) -> Path:
    """The folder with `config/` and `launch/` that belongs to the code that is running.

    In a source tree, and so after `pip install --editable` and `colcon build --symlink-install`,
    that is the tree itself. Installed, it is `share/microgripper_control` of the prefix the code
    lies in: a virtual environment, a user's or a system's prefix, a colcon install space. Raises
    MicrogripperError if the code was copied there without it.
    """
    if (package.parent / "package.xml").is_file():
        return package.parent
    for prefix in package.parents:
        share = prefix / "share" / package.name
        if (share / "package.xml").is_file():
            return share
    raise MicrogripperError(
        f"{package}: no share/{package.name} in any folder above; install the package again"
    )
