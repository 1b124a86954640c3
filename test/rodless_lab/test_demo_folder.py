# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The demo removes the bag of an earlier demo, and nothing else; it has its folder for itself."""

from pathlib import Path

import pytest
from quiet_stop import Quiet

from rodless_lab.cli import demo
from rodless_lab.demo import remove_old_bag
from rodless_lab.results_folder import results_folder
from rodless_lab.session.errors import HarnessError


def test_files_that_are_no_bag_are_kept(tmp_path: Path) -> None:
    """A folder with somebody's file is refused by name and stays as it is."""
    bag = tmp_path / "bag"
    bag.mkdir()
    (bag / "notes.txt").write_text("precious", encoding="utf-8")
    with pytest.raises(HarnessError, match="not the bag of a demo; choose another --output"):
        remove_old_bag(bag)
    assert (bag / "notes.txt").read_text(encoding="utf-8") == "precious"


def test_an_earlier_bag_is_removed(tmp_path: Path) -> None:
    """A bag's own files go, and a bag that is not there is no fault."""
    bag = tmp_path / "bag"
    bag.mkdir()
    (bag / "bag_0.mcap").touch()
    (bag / "metadata.yaml").touch()
    remove_old_bag(bag)
    remove_old_bag(bag)
    assert not bag.exists()


def said_of(folder: Path, capsys: pytest.CaptureFixture[str]) -> str:
    """Run a demo into a folder that it cannot use; return its one line."""
    assert demo.main(["--output", str(folder)], Quiet()) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.count("\n") == 1
    return printed.err.strip()


def test_a_place_where_nothing_can_be_written_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A file instead of a folder, a folder below a file, a file system that takes none."""
    file = tmp_path / "file"
    file.write_text("precious", encoding="utf-8")
    assert said_of(file, capsys) == f"{file}: cannot be written: Not a directory"
    below = file / "demo"
    assert said_of(below, capsys) == f"{below}: cannot be written: Not a directory"
    assert file.read_text(encoding="utf-8") == "precious"
    assert said_of(Path("/proc/self"), capsys).startswith("/proc/self: cannot be written: ")


def test_two_demos_in_one_folder_are_told_apart(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The second is refused and touches nothing; the folder is free again after the first."""
    bag = tmp_path / "bag"
    bag.mkdir()
    (bag / "metadata.yaml").touch()
    with results_folder(tmp_path):
        assert said_of(tmp_path, capsys) == (
            f"{tmp_path}: cannot be written: another process writes there; wait for its end, or "
            "give another --output"
        )
        assert (bag / "metadata.yaml").exists()
    with results_folder(tmp_path):
        pass
