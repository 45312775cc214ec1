"""What becomes of an earlier demo's bags and pages when another one goes wrong, or well."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.demo.experiment import BAG, BAG_WITH_FAULT, record_fault, run_experiment
from microgripper_control.demo.fault import drawn_fault
from microgripper_control.demo.fresh_bag import PAGES, fresh_bag
from microgripper_control.demo.plan import write_settings

NOBODY = 65534
REFUSED = 2**31  # seed: the plant takes none so large
EARLIER = (f"{BAG}/{BAG}.mcap", f"{BAG_WITH_FAULT}/{BAG_WITH_FAULT}.mcap", *PAGES)  # files


@pytest.fixture
def earlier(tmp_path: Path) -> Path:
    """The folder of a demo that went well."""
    write_settings(tmp_path)
    for name in EARLIER:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("earlier")
    return tmp_path


def kept(folder: Path) -> list[str]:
    """What is left of the earlier demo."""
    there = [name for name in EARLIER if (folder / name).exists()]
    return [name for name in there if (folder / name).read_bytes() == b"earlier"]


@pytest.fixture
def no_rights(tmp_path: Path) -> Iterator[Path]:
    """A folder that the test's user may not even look into, be it that he is root."""
    folder = tmp_path / "locked"
    folder.mkdir(mode=0)
    user = os.geteuid()
    if user == 0:
        os.seteuid(NOBODY)
    yield folder
    os.seteuid(user)


@pytest.mark.ros
@pytest.mark.parametrize(
    "record",
    [
        lambda folder: run_experiment(folder, REFUSED, lambda _: None),
        lambda folder: record_fault(folder, drawn_fault(1), REFUSED),
    ],
    ids=[BAG, BAG_WITH_FAULT],
)
def test_a_recording_that_fails_leaves_bags_and_pages_of_the_one_before(
    earlier: Path, record: Callable[[Path], object]
) -> None:
    with pytest.raises(MicrogripperError, match=r"node plant_simulator ended .* seed"):
        record(earlier)
    assert kept(earlier) == list(EARLIER)
    assert not list(earlier.glob(".*")), "half a recording"


def test_a_complete_recording_takes_the_place_and_the_pages_go(earlier: Path) -> None:
    with fresh_bag(earlier, BAG) as bag:
        bag.mkdir()
        (bag / f"{BAG}_new.mcap").write_text("new")
    assert [path.name for path in (earlier / BAG).iterdir()] == [f"{BAG}_new.mcap"]
    assert kept(earlier) == [EARLIER[1]]
    assert not list(earlier.glob(".*")), "the bag that was replaced"


def test_a_recording_that_is_not_there_replaces_nothing(earlier: Path) -> None:
    message = f"{BAG}: cannot be replaced: No such file or directory"
    with pytest.raises(MicrogripperError, match=message), fresh_bag(earlier, BAG):
        pass
    assert kept(earlier) == list(EARLIER)


def test_a_folder_without_rights_is_told_in_one_line(no_rights: Path) -> None:
    with pytest.raises(MicrogripperError, match="cannot be made or written: Permission denied"):
        run_experiment(no_rights / "demo", 1, lambda _: None)
