from __future__ import annotations

import os
from pathlib import Path

import pytest

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.files import check_place, written_whole


def test_a_name_that_is_no_utf_8_does_not_spoil_the_file_that_names_it(tmp_path: Path) -> None:
    path = tmp_path / "report.html"
    with written_whole(path) as file:
        file.write("mess\udce9.csv")
    assert path.read_text(encoding="utf-8") == "mess\\udce9.csv"


def test_a_file_that_is_left_unfinished_leaves_the_one_before(tmp_path: Path) -> None:
    path = tmp_path / "report.html"
    path.write_text("before", encoding="utf-8")

    def interrupted() -> None:
        with written_whole(path) as file:
            file.write("after")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert [path.read_text(encoding="utf-8")] == ["before"]
    assert list(tmp_path.iterdir()) == [path]


def test_who_may_read_it_is_as_it_was_or_as_the_process_has_it(tmp_path: Path) -> None:
    new, old = tmp_path / "new.csv", tmp_path / "old.csv"
    old.touch()
    old.chmod(0o640)
    before = os.umask(0o077)
    try:
        for path in (new, old):
            with written_whole(path) as file:
                file.write("text")
    finally:
        os.umask(before)
    assert [path.stat().st_mode & 0o777 for path in (new, old)] == [0o600, 0o640]


def test_a_link_to_itself_gives_way(tmp_path: Path) -> None:
    loop = tmp_path / "loop"
    loop.symlink_to(loop)
    check_place(loop, [tmp_path / "other"])
    with written_whole(loop) as file:
        file.write("text")
    assert loop.read_text() == "text"


def test_a_result_does_not_replace_what_it_is_made_from(tmp_path: Path) -> None:
    with pytest.raises(MicrogripperError, match="would overwrite what is read"):
        check_place(tmp_path / "run.csv", [tmp_path / "other.csv", tmp_path / "." / "run.csv"])


def test_a_name_that_no_file_can_have_is_refused_before_the_work(tmp_path: Path) -> None:
    with pytest.raises(MicrogripperError, match="cannot be written: File name too long"):
        check_place(tmp_path / ("m" * 300))


def test_a_place_is_left_as_it_was_until_something_is_written(tmp_path: Path) -> None:
    (tmp_path / "kept").mkdir()
    check_place(tmp_path / "kept" / "run.csv")
    check_place(tmp_path / "new" / "deeper" / "run.csv")
    assert [path.name for path in tmp_path.iterdir()] == ["kept"]
    with pytest.raises(MicrogripperError, match="cannot be made or written"):
        check_place(tmp_path / ("m" * 300) / "run.csv")


def test_what_is_no_regular_file_is_not_replaced(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    with pytest.raises(MicrogripperError, match="is no regular file; give the name of a file"):
        check_place(pipe)


def test_a_link_stays_and_what_it_points_to_is_written(tmp_path: Path) -> None:
    (tmp_path / "real").write_text("old")
    (tmp_path / "link").symlink_to(tmp_path / "real")
    with written_whole(tmp_path / "link") as file:
        file.write("new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_text() == "new"
