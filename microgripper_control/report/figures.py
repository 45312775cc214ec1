"""What all figures share: one style, no screen, files that appear whole."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.rcsetup import cycler

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.files import make_folder

MEASURED, SIMULATED, THIRD, FOURTH = "#1f4e79", "#d1495b", "#3a7d44", "#8d6a9f"
STYLE: dict[Any, Any] = {
    "figure.dpi": 130,
    "axes.grid": True,
    "grid.color": "#e4e8ee",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.prop_cycle": cycler(color=[MEASURED, SIMULATED, THIRD, FOURTH]),
    "legend.frameon": False,
    "font.size": 9,
}


@contextmanager
def figure(path: Path, size: tuple[float, float] = (8.0, 4.5)) -> Iterator[Figure]:
    """Yield an empty figure of `size` (inch) and save it as PNG under its final name.

    Raises MicrogripperError where the place cannot be written.
    """
    temporary = make_folder(path.parent) / f".{path.name}"
    with mpl.rc_context(STYLE):
        drawn = Figure(figsize=size, layout="constrained")
        yield drawn
        try:
            drawn.savefig(temporary, format="png")
            temporary.replace(path)
        except OSError as error:
            temporary.unlink(missing_ok=True)
            raise MicrogripperError(f"{path}: cannot be written: {error.strerror}") from None


def label(axes: Axes, x: str, y: str, title: str = "") -> None:
    """Name both axes, with their units."""
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    if title:
        axes.set_title(title, loc="left", fontsize=10)
