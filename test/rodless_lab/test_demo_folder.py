# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A demo takes the place of an earlier one, and of nothing else; it has its folder for itself."""

import shutil
from contextlib import suppress
from pathlib import Path

import pytest
from quiet_stop import Quiet

from rodless_lab.cli import demo
from rodless_lab.demo import BAG, METRICS, PICTURE, earlier_results
from rodless_lab.results_folder import results_folder
from rodless_lab.session.errors import HarnessError


@pytest.fixture
def earlier(tmp_path: Path) -> Path:
    """Return a folder with what a demo leaves, by name, and a file of somebody's."""
    (tmp_path / BAG).mkdir()
    for name in (f"{BAG}/bag_0.mcap", f"{BAG}/metadata.yaml", METRICS, PICTURE, "notes.txt"):
        (tmp_path / name).write_text(f"earlier {name}", encoding="utf-8")
    return tmp_path


def files(folder: Path) -> dict[str, str]:
    """Return what is in the files of a folder, hidden ones too, by their paths there."""
    return {
        str(file.relative_to(folder)): file.read_text(encoding="utf-8")
        for file in folder.rglob("*")
        if file.is_file()
    }


def test_files_that_are_no_bag_are_kept(tmp_path: Path) -> None:
    """A folder with somebody's file is refused by name and stays as it is."""
    bag = tmp_path / BAG
    bag.mkdir()
    (bag / "notes.txt").write_text("precious", encoding="utf-8")
    with (
        pytest.raises(HarnessError, match="not the bag of a demo; choose another --output"),
        earlier_results(tmp_path),
    ):
        pass
    assert files(tmp_path) == {f"{BAG}/notes.txt": "precious"}


def test_earlier_results_stand_until_there_is_another_bag(earlier: Path) -> None:
    """A demo that ends before it records, whatever ends it, costs nothing."""
    before = files(earlier)

    def end_early() -> None:
        with earlier_results(earlier) as there:
            assert there
            assert not (earlier / BAG).exists()
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        end_early()
    assert files(earlier) == before


def test_earlier_results_go_with_their_bag(earlier: Path) -> None:
    """Figures of one bag never stand beside another."""
    with earlier_results(earlier):
        (earlier / BAG).mkdir()
        (earlier / BAG / "bag_0.mcap").write_text("new", encoding="utf-8")
    assert files(earlier) == {f"{BAG}/bag_0.mcap": "new", "notes.txt": "earlier notes.txt"}


def test_results_whose_bag_is_gone_do_not_stay_beside_another(earlier: Path) -> None:
    """Somebody has moved it away for its size: figures and picture are not those of the new one."""
    shutil.rmtree(earlier / BAG)
    with earlier_results(earlier) as there:
        assert there
        (earlier / BAG).mkdir()
        (earlier / BAG / "bag_0.mcap").write_text("new", encoding="utf-8")
    assert files(earlier) == {f"{BAG}/bag_0.mcap": "new", "notes.txt": "earlier notes.txt"}


def test_what_no_demo_has_left_stays_until_there_is_something_in_its_place(tmp_path: Path) -> None:
    """Figures of another verb, and a folder of somebody's by the name of ours."""
    others = {METRICS: "a bench's", ".earlier/notes.txt": "precious", ".earlier/bag.txt": "too"}
    (tmp_path / ".earlier").mkdir()
    for name, text in others.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    for bag in (False, True):
        with earlier_results(tmp_path) as there:
            assert there
            if bag:
                (tmp_path / BAG).mkdir()
        assert files(tmp_path) == others


def test_what_a_killed_demo_has_set_aside_comes_back(earlier: Path) -> None:
    """With the next one, which finds it as the demo before the killed one left it."""
    before = files(earlier)
    killed = earlier_results(earlier)
    killed.__enter__()
    assert files(earlier) != before
    with earlier_results(earlier) as there:
        assert there
    assert files(earlier) == before
    with suppress(FileNotFoundError):  # it lives on in this test
        killed.__exit__(None, None, None)


def test_where_nothing_was_there_nothing_is(tmp_path: Path) -> None:
    """Nor is anything set aside."""
    with earlier_results(tmp_path) as there:
        assert not there
    assert files(tmp_path) == {}


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
