# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Files that are there whole or not at all."""

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest
from no_room import fill_up

from rodless_base.atomic_write import (
    atomic_write,
    check_file_writable,
    check_writable,
    write_together,
)


def test_an_error_names_the_file_that_was_wanted(tmp_path: Path) -> None:
    """Not the unfinished one beside it, of which nothing is left."""
    path = tmp_path / ("a" * 300 + ".csv")
    with pytest.raises(OSError, match="too long") as caught:
        atomic_write(path, "1")
    assert caught.value.errno == errno.ENAMETOOLONG
    assert (caught.value.filename, caught.value.filename2) == (str(path), None)
    assert not list(tmp_path.iterdir())


def test_an_error_leaves_what_was_there(tmp_path: Path) -> None:
    """A folder in the place of the file stays as it is."""
    folder = tmp_path / "run.csv"
    (folder / "in").mkdir(parents=True)
    with pytest.raises(OSError, match="directory"):
        atomic_write(folder, "1")
    assert [path.name for path in tmp_path.rglob("*")] == ["run.csv", "in"]


def test_a_full_disk_is_named_with_its_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What the system says then names no file; the one of before stays."""
    fill_up(monkeypatch)
    path = tmp_path / "run.csv"
    path.write_text("earlier")
    with pytest.raises(OSError, match="No space left") as caught:
        atomic_write(path, "1")
    assert caught.value.filename == str(path)
    assert [(file.name, file.read_text()) for file in tmp_path.iterdir()] == [
        ("run.csv", "earlier")
    ]


def test_files_that_belong_together_are_all_written_or_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A disk that is full at any of three leaves the earlier ones, and of new folders nothing."""
    earlier = {tmp_path / name: f"earlier {name}" for name in ("a", "b", "c")}
    write_together(earlier)
    wanted = dict.fromkeys(earlier, "later") | {tmp_path / "new" / "below" / "d": "later"}
    for room in range(len(wanted)):
        with monkeypatch.context() as patch:
            fill_up(patch, room)
            with pytest.raises(OSError, match="No space left") as caught:
                write_together(wanted)
        assert caught.value.filename == str(list(wanted)[room])
        assert {path: path.read_text() for path in tmp_path.iterdir()} == earlier
    write_together(wanted)
    assert {path.read_text() for path in wanted} == {"later"}
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["a", "b", "below", "c", "d", "new"]


def test_what_is_no_file_stays_what_it_is(tmp_path: Path) -> None:
    """A pipe, and a link to one: a file in its place would take it from whoever reads it."""
    pipe, link = tmp_path / "pipe", tmp_path / "link"
    os.mkfifo(pipe)
    link.symlink_to(pipe)
    for path in (pipe, link, Path("/dev/null")):
        for write in (check_file_writable, lambda path: atomic_write(path, "1")):
            with pytest.raises(OSError, match="is no regular file"):
                write(path)
    assert pipe.is_fifo()
    assert link.is_symlink()


def test_links_in_a_circle_stay_and_are_named(tmp_path: Path) -> None:
    """They lead to no file that could be written."""
    here, there = tmp_path / "here", tmp_path / "there"
    here.symlink_to(there)
    there.symlink_to(here)
    for write in (check_file_writable, lambda path: atomic_write(path, "1")):
        with pytest.raises(OSError, match="Too many levels of symbolic links") as caught:
            write(here)
        assert caught.value.filename == str(here)
    for folder in (here, here / "below"):
        with pytest.raises(OSError, match="Too many levels of symbolic links") as caught:
            check_writable(folder)
        assert caught.value.filename == str(folder)
    assert here.is_symlink()
    assert there.is_symlink()


def test_a_link_that_leads_nowhere_is_no_folder(tmp_path: Path) -> None:
    """None can be made in its place: that is found by looking, not after the work."""
    (tmp_path / "link").symlink_to(tmp_path / "gone")
    for folder in (tmp_path / "link", tmp_path / "link" / "below"):
        with pytest.raises(OSError, match="No such file or directory") as caught:
            check_writable(folder)
        assert caught.value.filename == str(folder)
    assert [path.name for path in tmp_path.iterdir()] == ["link"]


def test_looking_leaves_nothing_behind(tmp_path: Path) -> None:
    """What is refused later has made no folder; one that is there keeps what it has."""
    check_writable(tmp_path / "new" / "results")
    check_writable(tmp_path / "new" / ".." / "other")
    check_file_writable(tmp_path / "new" / "run.gif")
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "kept").touch()
    check_writable(tmp_path)
    check_file_writable(tmp_path / "kept")
    assert [path.name for path in tmp_path.iterdir()] == ["kept"]


def test_what_cannot_be_written_is_found_by_looking(tmp_path: Path) -> None:
    """A file where a folder must be, a folder where a file must be, and what no file can be in."""
    (tmp_path / "file").touch()
    (tmp_path / "link").symlink_to("/proc/nothing")
    for folder in (tmp_path / "file", tmp_path / "file" / "below", Path("/proc/results")):
        with pytest.raises(OSError, match=r".") as caught:
            check_writable(folder)
        assert caught.value.filename == str(folder)
    for file in (tmp_path, tmp_path / "file" / "below", tmp_path / "link"):
        with pytest.raises(OSError, match=r"."):
            check_file_writable(file)


ENDED = """
import os, signal, sys
from pathlib import Path
from rodless_base import atomic_write
from rodless_base.start import Stop

stop, fsync = Stop(), os.fsync
def end(handle):
    fsync(handle)
    os.kill(os.getpid(), signal.SIGTERM)
os.fsync = end
folder = Path(sys.argv[1])
stop.undo = atomic_write.removal_of_new(folder)
atomic_write.write_together({folder / "a.txt": "new", folder / "b.txt": "new"})
"""


def test_a_process_that_ends_while_it_writes_leaves_nothing_half(tmp_path: Path) -> None:
    """Neither the file beside its place, nor the folder that was made for it."""
    done = subprocess.run([sys.executable, "-c", ENDED, str(tmp_path / "new")], check=False)
    assert done.returncode == 0
    assert list(tmp_path.iterdir()) == []
