# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A bag that is being recorded is read by nobody as a whole one, and changed by no other."""

import errno
import fcntl
import multiprocessing
import os
import struct
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from rosbags.rosbag2 import Writer as Rosbag2Writer
from rosbags.typesys import Stores, get_typestore

from rodless_lab.bags import being_written, file_lock
from rodless_lab.bags.metadata import METADATA_FILE, BagError, BagTopic
from rodless_lab.bags.reader import read_bag
from rodless_lab.bags.writer import BagWriter, recover_bag

UNDER_WAY = r"_0\.mcap is still being written by process \d+ \(.+\); end that first$"
TOPIC = BagTopic("/x", "std_msgs/msg/Float64")


def add(writer: BagWriter, first: int, last: int) -> None:
    """Write messages of which each is a number."""
    for k in range(first, last):
        writer.write("/x", k.to_bytes(12, "little"), k, k)
    writer.flush()


def recording(bag: Path) -> BagWriter:
    """Return a bag under construction that has a thousand messages."""
    writer = BagWriter(bag)
    writer.add_topic(TOPIC)
    add(writer, 0, 1000)
    return writer


def numbers(bag: Path, recover: bool = False) -> list[int]:
    """The messages of the bag."""
    found = read_bag(bag, recover)["/x"].payloads
    return [int.from_bytes(payload, "little") for payload in found]


def files(bag: Path) -> dict[str, bytes]:
    """What is in the folder."""
    return {file.name: file.read_bytes() for file in bag.iterdir()}


@pytest.mark.parametrize("attempt", [recover_bag, read_bag])
def test_a_bag_under_way_is_refused_and_ends_whole(
    tmp_path: Path, attempt: Callable[[Path], object]
) -> None:
    """It would be cut short, and its recorder would write on behind an end that is none."""
    bag = tmp_path / "bag"
    with recording(bag) as writer:
        before = files(bag)
        with pytest.raises(BagError, match=UNDER_WAY):
            attempt(bag)
        assert files(bag) == before
        assert numbers(bag, recover=True) == list(range(1000))
        add(writer, 1000, 2000)
    assert writer.failure is None
    assert numbers(bag) == list(range(2000))
    assert recover_bag(bag) == 2000


@contextmanager
def another_writer(file: Path) -> Iterator[None]:
    """Another process has the file open, as rosbag2's recorder has: without a lock."""
    hold = "import sys; file = open(sys.argv[1], 'ab'); print(flush=True); sys.stdin.read()"
    with subprocess.Popen(
        [sys.executable, "-c", hold, str(file)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline()
        yield
        process.communicate(timeout=60)


def test_the_bag_of_another_recorder_is_left_alone_too(tmp_path: Path) -> None:
    """The process is named that has the file open to write; after that the bag is recovered."""
    bag = tmp_path / "bag"
    with recording(bag):
        cut = files(bag)["bag_0.mcap"]
    (bag / METADATA_FILE).unlink()
    (bag / "bag_0.mcap").write_bytes(cut)
    with another_writer(bag / "bag_0.mcap"):
        for attempt in (recover_bag, read_bag):
            with pytest.raises(BagError, match=UNDER_WAY):
                attempt(bag)
        assert files(bag) == {"bag_0.mcap": cut}
    assert recover_bag(bag) == 1000
    assert numbers(bag) == list(range(1000))


def test_a_file_that_others_change_ends_its_recording(tmp_path: Path) -> None:
    """A program that asks nobody: the recorder says so, and ends the bag with what it knows."""
    bag = tmp_path / "bag"
    with recording(bag) as writer:
        with (bag / "bag_0.mcap").open("ab") as other:
            other.write(b"an end")
        with pytest.raises(BagError, match="another program has changed its file"):
            add(writer, 1000, 2000)
    assert writer.failure is not None
    assert numbers(bag) == list(range(1000))


def test_a_fork_keeps_nobody_from_a_bag(tmp_path: Path) -> None:
    """A process forked while it was recorded has no part in it, however long it lives."""
    bag = tmp_path / "bag"
    with recording(bag) as writer, multiprocessing.get_context("fork").Pool(1) as pool:
        assert pool.apply(os.getpid) != os.getpid()
        add(writer, 1000, 2000)
        writer.close()
        (bag / METADATA_FILE).unlink()
        assert recover_bag(bag) == 2000


@pytest.fixture
def unseen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No process can be seen, as another user's, or one in another container."""
    monkeypatch.setattr(being_written, "PROCESSES", tmp_path / "none")


@pytest.mark.usefixtures("unseen")
@pytest.mark.parametrize("attempt", [recover_bag, read_bag])
def test_a_recorder_that_cannot_be_seen_is_noticed_by_its_lock(
    tmp_path: Path, attempt: Callable[[Path], object]
) -> None:
    """By all readers, too: its bag is not called one whose recording was killed."""
    bag = tmp_path / "bag"
    with recording(bag) as writer:
        with pytest.raises(BagError, match=r"_0\.mcap is still being written by another process;"):
            attempt(bag)
        add(writer, 1000, 2000)
    assert numbers(bag) == list(range(2000))


@pytest.mark.usefixtures("unseen")
def test_a_fork_leaves_the_lock_to_its_parent(tmp_path: Path) -> None:
    """What a forked process lets go of stays locked, until its parent ends the bag."""
    bag = tmp_path / "bag"
    with recording(bag) as writer, multiprocessing.get_context("fork").Pool(1) as pool:
        assert pool.apply(os.getpid) != os.getpid()
        with pytest.raises(BagError, match=r"is still being written by another process;"):
            recover_bag(bag)
        writer.close()
        assert recover_bag(bag) == 1000


# What who may only read a file can take on it.
READERS_LOCKS = {
    "flock": lambda file: fcntl.flock(file, fcntl.LOCK_EX),
    "fcntl": lambda file: fcntl.fcntl(
        file, fcntl.F_OFD_SETLK, struct.pack("hhqqi4x", fcntl.F_RDLCK, 0, 0, 0, 0)
    ),
}


@pytest.mark.parametrize("lock", READERS_LOCKS)
def test_who_can_only_read_a_bag_keeps_nobody_from_it(tmp_path: Path, lock: str) -> None:
    """A stranger's lock is no recorder's: whose bag it is can recover it."""
    bag = tmp_path / "bag"
    with recording(bag):
        before = files(bag)["bag_0.mcap"]
    (bag / "bag_0.mcap").write_bytes(before)
    (bag / METADATA_FILE).unlink()
    with (bag / "bag_0.mcap").open("rb") as opened:
        READERS_LOCKS[lock](opened)
        with pytest.raises(BagError, match="was never closed because its recording was killed"):
            read_bag(bag)
        assert recover_bag(bag) == 1000


def test_a_file_system_without_locks_will_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Recording, reading and recovery go on, and keep nobody out."""

    def no_locks(*_: object) -> bytes:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(file_lock.fcntl, "fcntl", no_locks)
    bag = tmp_path / "bag"
    with recording(bag):
        pass
    assert recover_bag(bag) == 1000
    assert numbers(bag) == list(range(1000))


def test_a_database_that_grows_is_not_read_as_a_whole_one(
    tmp_path: Path,
) -> None:
    """SQLite has no end that could be missing: the file alone does not tell."""
    bag = tmp_path / "bag"
    with Rosbag2Writer(bag, version=9) as writer:
        topic = writer.add_connection("/x", TOPIC.type_name, typestore=get_typestore(Stores.LATEST))
        writer.write(topic, 1, bytes(12))
    with another_writer(bag / "bag.db3"), pytest.raises(BagError, match=r"bag\.db3 is still being"):
        read_bag(bag)
    assert numbers(bag) == [0]


def test_a_link_that_leads_to_itself_is_no_place_for_a_bag(tmp_path: Path) -> None:
    """Refused in one line, as what exists already."""
    (tmp_path / "link").symlink_to(tmp_path / "link")
    with pytest.raises(BagError, match="exists already"):
        BagWriter(tmp_path / "link")
