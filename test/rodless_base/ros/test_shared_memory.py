# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What processes that were killed leave in shared memory, and too little of it."""

import fcntl
import os
import time
from pathlib import Path

import pytest

from rodless_base.ros import shared_memory
from rodless_base.ros.shared_memory import TRANSPORTS, clear_dead_segments, prepare_shared_memory


@pytest.fixture(autouse=True)
def _environment(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in (TRANSPORTS, "RMW_IMPLEMENTATION", "ROS_AUTOMATIC_DISCOVERY_RANGE"):
        monkeypatch.setenv(name, "")
        monkeypatch.delenv(name)


def segment(folder: Path, number: int, age: float = 60.0, lock: str = "_el") -> Path:
    """Make a segment as Fast DDS does, with its lock file; return that."""
    name = f"fastrtps_{number:016x}"
    (folder / name).write_bytes(bytes(100))
    lock_file = folder / f"{name}{lock}"
    lock_file.touch()
    then = time.time() - age
    os.utime(lock_file, (then, then))
    return lock_file


def test_segments_of_dead_processes_are_cleared(tmp_path: Path) -> None:
    """Both files of each, however it was shared."""
    segment(tmp_path, 1)
    segment(tmp_path, 0xFEDCBA9876543210, lock="_sl")
    assert clear_dead_segments(tmp_path) == 2
    assert list(tmp_path.iterdir()) == []


def test_what_lives_or_is_none_of_ours_stays(tmp_path: Path) -> None:
    """A locked one, one that is just being made, a port, a link, another's name, a lone file."""
    (tmp_path / "elsewhere").touch()
    os.utime(tmp_path / "elsewhere", (0, 0))
    (tmp_path / f"fastrtps_{7:016x}_el").symlink_to(tmp_path / "elsewhere")
    for name in (f"fastrtps_{8:016x}", "fastrtps_port7411_el", f"other_{9:016x}_el"):
        (tmp_path / name).touch()
        os.utime(tmp_path / name, (0, 0))
    segment(tmp_path, 2, age=-3600.0)
    with segment(tmp_path, 1).open("ab") as owner:
        fcntl.flock(owner, fcntl.LOCK_EX)
        before = sorted(tmp_path.iterdir())
        assert clear_dead_segments(tmp_path) == 0
        assert sorted(tmp_path.iterdir()) == before
    assert clear_dead_segments(tmp_path) == 1


def test_segments_of_other_users_stay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever their owner may be doing."""
    segment(tmp_path, 1)
    uid = os.getuid()
    monkeypatch.setattr(os, "getuid", lambda: uid + 1)
    assert clear_dead_segments(tmp_path) == 0
    assert len(list(tmp_path.iterdir())) == 2


def test_without_room_nodes_do_without(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is said once, with the folder and what it lacks; children do the same in silence."""
    assert prepare_shared_memory(tmp_path) is None
    assert TRANSPORTS not in os.environ
    monkeypatch.setattr(shared_memory, "NEEDED", float("inf"))
    note = prepare_shared_memory(tmp_path)
    assert note is not None
    assert str(tmp_path) in note
    assert "kB free" in note
    assert os.environ[TRANSPORTS] == "UDPv4"
    assert prepare_shared_memory(tmp_path) is None


def test_what_the_user_has_chosen_stands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Transports of their own, another middleware; where ROS insists on memory, it is refused."""
    monkeypatch.setattr(shared_memory, "NEEDED", float("inf"))
    with monkeypatch.context() as patch:
        patch.setenv("RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp")
        assert prepare_shared_memory(tmp_path) is None
        assert TRANSPORTS not in os.environ
    with monkeypatch.context() as patch:
        patch.setenv(TRANSPORTS, "LARGE_DATA")
        assert prepare_shared_memory(tmp_path) is None
        assert os.environ[TRANSPORTS] == "LARGE_DATA"
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    with pytest.raises(RuntimeError, match="free some"):
        prepare_shared_memory(tmp_path)


def test_a_full_folder_is_named_before_ros_dies_of_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever the user has chosen: loading ROS alone ends in SIGBUS then."""
    monkeypatch.setattr(shared_memory, "LEAST", float("inf"))
    monkeypatch.setenv(TRANSPORTS, "UDPv4")
    with pytest.raises(RuntimeError, match=f"{tmp_path}: .* kB free"):
        prepare_shared_memory(tmp_path)


def test_a_folder_that_is_not_there_is_no_reason(tmp_path: Path) -> None:
    """Fast DDS says itself what it makes of that."""
    assert prepare_shared_memory(tmp_path / "none") is None
