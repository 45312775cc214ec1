"""The files that come with the package are found, however it was installed."""

from __future__ import annotations

from pathlib import Path

import pytest

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.share import share_folder

NAME = "microgripper_control"


def made(folder: Path) -> Path:
    folder.mkdir(parents=True)
    return folder


def test_the_code_under_test_finds_its_configuration() -> None:
    assert (share_folder() / "config" / "apa120s.yaml").is_file()


@pytest.mark.parametrize("site", ["lib/python3.12/site-packages", "local/lib/dist-packages", "."])
def test_installed_it_is_the_share_folder_of_the_prefix(tmp_path: Path, site: str) -> None:
    share = made(tmp_path / "prefix" / "share" / NAME)
    (share / "package.xml").touch()
    package = made(tmp_path / "prefix" / site / NAME)
    assert share_folder(package) == share


def test_in_a_source_tree_it_is_the_tree(tmp_path: Path) -> None:
    tree = tmp_path / "prefix" / "src" / NAME
    package = made(tree / NAME)
    (tree / "package.xml").touch()
    (made(tmp_path / "prefix" / "share" / NAME) / "package.xml").touch()
    assert share_folder(package) == tree


def test_an_installation_inside_a_source_tree_is_one_by_itself(tmp_path: Path) -> None:
    (tmp_path / "package.xml").touch()
    share = made(tmp_path / "install" / "share" / NAME)
    (share / "package.xml").touch()
    package = made(tmp_path / "install" / "lib" / "site-packages" / NAME)
    assert share_folder(package) == share


def test_code_alone_is_an_error_that_says_what_to_do(tmp_path: Path) -> None:
    package = made(tmp_path / "lib" / NAME)
    with pytest.raises(MicrogripperError, match=r"no share/microgripper_control.*install"):
        share_folder(package)
