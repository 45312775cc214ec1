"""A demo replaces its own bags, and nobody else's."""

from __future__ import annotations

from pathlib import Path

import pytest

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.demo.experiment import BAG, BAG_WITH_FAULT, run_experiment


@pytest.mark.parametrize("name", [BAG, BAG_WITH_FAULT])
def test_a_bag_that_no_demo_has_made_is_kept(tmp_path: Path, name: str) -> None:
    kept = tmp_path / name / "recorded_0.mcap"
    kept.parent.mkdir()
    kept.write_text("hours of work")
    with pytest.raises(MicrogripperError, match=f"{name}: is there already; move it away"):
        run_experiment(tmp_path, 1, lambda _: None)
    assert kept.read_text() == "hours of work"
    assert [path.name for path in tmp_path.iterdir()] == [name]
