# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Only files are opened as files, and what is none is told at once."""

import os
import socket
from pathlib import Path

import pytest

from rodless_base.regular_file import NotAFileError, open_file, read_file

READ, ADD = os.O_RDONLY, os.O_WRONLY | os.O_APPEND | os.O_CREAT


@pytest.mark.parametrize("flags", [READ, ADD, os.O_RDWR])
def test_what_is_no_file_is_not_opened(tmp_path: Path, flags: int) -> None:
    """Pipe, socket, device and folder, to read and to write; no descriptor stays open."""
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "folder").mkdir()
    before = len(list(Path("/proc/self/fd").iterdir()))
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind(str(tmp_path / "socket"))
        for path in (tmp_path / "pipe", tmp_path / "socket", Path("/dev/null")):
            with pytest.raises(NotAFileError, match="not a file but a pipe or device"):
                open_file(path, flags)
        with pytest.raises(NotAFileError, match="Is a directory"):
            open_file(tmp_path / "folder", flags)
    assert len(list(Path("/proc/self/fd").iterdir())) == before


def test_a_link_is_followed_unless_it_is_not_to_be(tmp_path: Path) -> None:
    """Links in a circle and files that are missing have the words of the system."""
    (tmp_path / "file").write_text("abc")
    (tmp_path / "link").symlink_to("file")
    (tmp_path / "circle").symlink_to("circle")
    assert read_file(tmp_path / "link") == b"abc"
    with pytest.raises(NotAFileError, match="a symbolic link, which is not followed"):
        open_file(tmp_path / "link", ADD | os.O_NOFOLLOW)
    for name, words in (("circle", "Too many levels"), ("none", "No such file")):
        with pytest.raises(OSError, match=words) as refusal:
            read_file(tmp_path / name)
        assert not isinstance(refusal.value, NotAFileError)
