# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Bags of rosbag2 in every storage and compression, written by an independent program."""

import errno
import os
import shutil
import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
import rig_bag
import yaml
from mcap.writer import Writer as McapWriter
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from rodless_lab.bags import decompress
from rodless_lab.bags.metadata import METADATA_FILE, BagError
from rodless_lab.bags.reader import read_bag
from rodless_lab.bags.writer import recover_bag
from rodless_lab.runs.from_bag import read_run
from rodless_lab.runs.measured_run import MeasuredRun, RunError

TYPES = {
    "/joint_states": "sensor_msgs/msg/JointState",
    "/chamber_a/pressure": "sensor_msgs/msg/FluidPressure",
    "/chamber_b/pressure": "sensor_msgs/msg/FluidPressure",
    "/supply/pressure": "sensor_msgs/msg/FluidPressure",
    "/valve/voltage": "std_msgs/msg/Float64",
}
Messages = dict[str, list[tuple[int, bytes]]]


def write(
    path: Path,
    messages: Messages,
    storage: StoragePlugin = StoragePlugin.SQLITE3,
    compression: CompressionMode = CompressionMode.NONE,
) -> Path:
    """Write messages by topic (log time in ns, CDR) as rosbag2 would."""
    writer = Writer(path, version=9, storage_plugin=storage)
    writer.set_compression(compression, CompressionFormat.ZSTD)
    with writer:
        for topic, sent in messages.items():
            connection = writer.add_connection(
                topic, TYPES[topic], typestore=get_typestore(Stores.ROS2_JAZZY)
            )
            for log_time, data in sent:
                writer.write(connection, log_time, data)
    return path


def contents(bag: Path) -> Messages:
    """What we read: log time and payload of each message, by topic."""
    return {
        topic: list(zip(messages.log_time.tolist(), messages.payloads, strict=True))
        for topic, messages in read_bag(bag)._messages.items()
    }


@pytest.mark.parametrize(
    ("storage", "compression"),
    [
        (StoragePlugin.SQLITE3, CompressionMode.NONE),
        (StoragePlugin.SQLITE3, CompressionMode.FILE),
        (StoragePlugin.SQLITE3, CompressionMode.MESSAGE),
        (StoragePlugin.MCAP, CompressionMode.NONE),
        (StoragePlugin.MCAP, CompressionMode.FILE),
        (StoragePlugin.MCAP, CompressionMode.MESSAGE),
        (StoragePlugin.MCAP, CompressionMode.STORAGE),
    ],
)
def test_what_was_recorded_is_read(
    sample_bag, tmp_path: Path, storage: StoragePlugin, compression: CompressionMode
) -> None:
    """Each message, byte for byte, at its time; without metadata.yaml too, as a kill leaves it."""
    sent = {topic: sample_bag.messages[topic] for topic in ("/joint_states", "/valve/voltage")}
    bag = write(tmp_path / "bag", sent, storage, compression)
    assert contents(bag) == sent
    (bag / METADATA_FILE).unlink()
    assert contents(bag) == sent


def test_messages_that_were_compressed_side_by_side_are_put_in_order(
    sample_bag, tmp_path: Path
) -> None:
    """rosbag2 writes first what is compressed first; where the plant was reset, time goes back."""
    first = sample_bag.messages["/joint_states"]
    later = [(log_time + 10**11, data) for log_time, data in first]
    ordered = {"/joint_states": later + first}
    shuffled = list(ordered["/joint_states"])
    for place in (0, 5, 20, len(first) + 3):
        shuffled[place], shuffled[place + 1] = shuffled[place + 1], shuffled[place]
    bag = write(
        tmp_path / "bag", {"/joint_states": shuffled}, StoragePlugin.MCAP, CompressionMode.MESSAGE
    )
    assert contents(bag) == ordered
    plain = write(tmp_path / "plain", {"/joint_states": shuffled}, StoragePlugin.MCAP)
    assert contents(plain) == {"/joint_states": shuffled}, "only where threads compress"


@pytest.mark.parametrize("compression", [CompressionMode.NONE, CompressionMode.FILE])
def test_a_split_bag_is_read_as_one(
    sample_bag, tmp_path: Path, compression: CompressionMode
) -> None:
    """`ros2 bag record --max-bag-size` makes several files: their messages follow each other."""
    sent = sample_bag.messages["/joint_states"]
    halves = [sent[:100], sent[100:]]
    bags = [
        write(tmp_path / str(k), {"/joint_states": half}, compression=compression)
        for k, half in enumerate(halves)
    ]
    names = [next(file.name for file in bag.iterdir() if file.suffix != ".yaml") for bag in bags]
    shutil.move(bags[1] / names[1], bags[0])
    description = yaml.safe_load((bags[0] / METADATA_FILE).read_text())
    about = description["rosbag2_bagfile_information"]
    about["relative_file_paths"] = names
    about["topics_with_message_count"][0]["message_count"] = len(sent)
    about["message_count"] = len(sent)
    (bags[0] / METADATA_FILE).write_text(yaml.safe_dump(description))
    assert contents(bags[0]) == {"/joint_states": sent}


def test_one_file_of_a_bag_is_read_by_itself(sample_bag, tmp_path: Path) -> None:
    """The .db3 file alone is as good as its folder."""
    sent = {"/valve/voltage": sample_bag.messages["/valve/voltage"]}
    bag = write(tmp_path / "bag", sent)
    (file,) = bag.glob("*.db3")
    assert contents(file) == sent
    assert (read_bag(file).complete, read_bag(file).notes) == (True, ())


@pytest.mark.parametrize("compression", [CompressionMode.NONE, CompressionMode.FILE])
def test_the_files_of_a_killed_recording_are_read_in_order(
    sample_bag, tmp_path: Path, compression: CompressionMode
) -> None:
    """By their numbers, of which there may be more than ten; nothing lists them any more."""
    sent = sample_bag.messages["/joint_states"]
    bag = tmp_path / "bag"
    bag.mkdir()
    for k in range(12):
        part = {"/joint_states": sent[20 * k : 20 * k + 20]}
        (file,) = write(tmp_path / str(k), part, compression=compression).glob("*.db3*")
        file.rename(bag / file.name.replace(str(k), f"bag_{k}", 1))
    assert contents(bag) == {"/joint_states": sent[:240]}


def test_a_file_that_was_being_compressed_is_read_once(sample_bag, tmp_path: Path) -> None:
    """A kill leaves it plain and, whole or not, compressed: the plain one is whole."""
    sent = {"/joint_states": sample_bag.messages["/joint_states"]}
    bag = write(tmp_path / "bag", sent)
    (compressed,) = write(tmp_path / "packed" / "bag", sent, compression=CompressionMode.FILE).glob(
        "*.zstd"
    )
    (bag / METADATA_FILE).unlink()
    for packed in (compressed.read_bytes(), compressed.read_bytes()[:100]):
        (bag / compressed.name).write_bytes(packed)
        assert contents(bag) == sent


def altered(bag: Path, *changes: str) -> None:
    """Change the tables of a bag in SQLite."""
    with closing(sqlite3.connect(next(bag.glob("*.db3")))) as file, file:
        for change in changes:
            file.execute(change)


# What a flipped bit makes of a row: SQLite keeps no sums, and any type in any column.
DAMAGE = {
    "UPDATE messages SET timestamp = 'x' WHERE id = 5": "message \\d+ has no time or content",
    "UPDATE messages SET timestamp = 1.5 WHERE id = 5": "message \\d+ has no time or content",
    "UPDATE messages SET data = 7 WHERE id = 5": "message \\d+ has no time or content",
    "DELETE FROM messages WHERE id = 5": "/joint_states has 299 messages, metadata.yaml says 300",
    "UPDATE messages SET topic_id = 77 WHERE id = 5": "message \\d+ is of no topic that the file",
    "UPDATE messages SET topic_id = 3 - topic_id WHERE id = 5": "metadata.yaml says",
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_row_of_sqlite_is_told(sample_bag, tmp_path: Path, damage: str) -> None:
    """In one line, whatever reads the bag; nothing passes as whole, what is before can be read."""
    sent = {topic: sample_bag.messages[topic] for topic in ("/joint_states", "/valve/voltage")}
    bag = write(tmp_path / "bag", sent)
    assert read_bag(bag).complete
    altered(bag, damage)
    for read in (read_bag, read_run):
        with pytest.raises(ValueError, match=DAMAGE[damage]) as refusal:
            read(bag)
        assert isinstance(refusal.value, BagError | RunError)
        assert "\n" not in str(refusal.value)
    found = read_bag(bag, recover=True)
    assert not found.complete
    left = 4 if "message" in DAMAGE[damage][:8] else len(sent["/joint_states"]) - 1
    assert sum(len(found[topic]) for topic in found) >= left


def test_a_damaged_page_of_sqlite_leaves_what_is_before(sqlite_bag: Path) -> None:
    """As what is recovered of a damaged MCAP: the first messages, byte for byte."""
    before = contents(sqlite_bag)["/joint_states"]
    file = next(sqlite_bag.glob("*.db3"))
    pages = file.stat().st_size // 4096
    with file.open("r+b") as damaged:
        damaged.seek((pages - 2) * 4096)
        damaged.write(bytes(4096))
    with pytest.raises(BagError, match=r"is damaged \(database disk image is malformed\)"):
        read_bag(sqlite_bag)
    found = read_bag(sqlite_bag, recover=True)
    assert not found.complete
    payloads = found._messages["/joint_states"].payloads
    assert 10 < len(payloads) < len(before)
    assert list(payloads) == [data for _, data in before[: len(payloads)]]


@pytest.mark.parametrize("share", [0.6, 0.8, 0.83, 0.95])
def test_what_there_is_of_a_sqlite_file_that_is_cut_short_is_read(
    sqlite_bag: Path, share: float
) -> None:
    """As of an MCAP: refused without recover, with it the first messages, byte for byte."""
    before = contents(sqlite_bag)["/joint_states"]
    file = next(sqlite_bag.glob("*.db3"))
    size = file.stat().st_size
    with file.open("r+b") as short:
        short.truncate(int(share * size))
    with pytest.raises(BagError, match=r"is damaged \(database disk image is malformed\)"):
        read_bag(sqlite_bag)
    found = read_bag(sqlite_bag, recover=True)
    assert not found.complete
    payloads = found._messages["/joint_states"].payloads
    assert 80 <= len(payloads) < len(before)
    assert list(payloads) == [data for _, data in before[: len(payloads)]]
    assert file.stat().st_size == int(share * size)


def test_half_a_page_of_sqlite_is_no_message(tmp_path: Path) -> None:
    """SQLite reads zeros where a file ends within a page; cut anywhere, no message holds them."""
    before = [(k, bytes([1 + k]) * 3000) for k in range(20)]
    bag = write(tmp_path / "bag", {"/joint_states": before})
    file = next(bag.glob("*.db3"))
    whole, counts = file.read_bytes(), []
    for end in range(len(whole) - 1500, len(whole) // 2, -1500):
        file.write_bytes(whole[:end])
        found = read_bag(bag, recover=True)._messages
        payloads = list(found["/joint_states"].payloads) if found else []
        assert payloads == [data for _, data in before[: len(payloads)]]
        counts.append(len(payloads))
    assert max(counts) > 12


def test_a_half_written_page_of_sqlite_under_way_is_not_called_damage(sqlite_bag: Path) -> None:
    """While its recorder has the file open, the way out is to end that."""
    file = next(sqlite_bag.glob("*.db3"))
    whole = file.read_bytes()
    with file.open("r+b") as recorder:
        recorder.truncate(int(0.8 * len(whole)))
        with pytest.raises(BagError, match=r"is still being written by process \d+ .*; end that"):
            read_bag(sqlite_bag)
        recorder.write(whole)
    assert len(read_bag(sqlite_bag)["/joint_states"]) == 300


@pytest.fixture
def sqlite_bag(sample_bag, tmp_path: Path) -> Path:
    """A bag of one topic in SQLite."""
    return write(tmp_path / "bag", {"/joint_states": sample_bag.messages["/joint_states"]})


@pytest.mark.parametrize(
    ("table", "column"),
    [
        ("messages", "data BLOB AS (zeroblob(999999999))"),
        ("messages", "timestamp INTEGER AS (instr(zeroblob(200000000), zeroblob(100000)||x'01'))"),
        ("topics", "type TEXT AS ('std_msgs/msg/' || 'Float64')"),
    ],
    ids=["memory", "time", "topics"],
)
def test_a_table_that_computes_a_column_is_refused(
    sqlite_bag: Path, table: str, column: str
) -> None:
    """A few bytes may stand for as many as they like, and for a search without an end."""
    altered(
        sqlite_bag,
        "DROP INDEX timestamp_idx",
        f"ALTER TABLE {table} DROP COLUMN {column.split(maxsplit=1)[0]}",
        f"ALTER TABLE {table} ADD COLUMN {column}",
    )
    with pytest.raises(BagError, match=f"its table of {table} computes a column"):
        read_bag(sqlite_bag)


def test_names_of_topics_are_bounded(sqlite_bag: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What a column is by default stands in the file once, and in each of its rows."""
    monkeypatch.setattr(decompress, "LARGEST", 1_000_000)
    monkeypatch.setattr(decompress, "RATIO", 1)
    with closing(sqlite3.connect(next(sqlite_bag.glob("*.db3")))) as file, file:
        file.execute("ALTER TABLE topics DROP COLUMN serialization_format")
        names = "id, name, type, offered_qos_profiles, type_description_hash"
        add = f"INSERT INTO topics ({names}) VALUES (?, ?, '', '', '')"
        file.executemany(add, [(k, f"/t{k}") for k in range(10, 40)])
        text = "x" * 100_000
        column = f"serialization_format TEXT NOT NULL DEFAULT '{text}'"
        file.execute(f"ALTER TABLE topics ADD COLUMN {column}")
    with pytest.raises(BagError, match=r"a topic has names of \d+ bytes, more than \d+"):
        read_bag(sqlite_bag)


def test_no_room_for_a_copy_is_said_of_the_place_for_it(
    sample_bag, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A bag with a journal is read from a copy; it is whole, and the way out is another place."""
    bag = write(tmp_path / "bag", {"/joint_states": sample_bag.messages["/joint_states"]})
    (file,) = bag.glob("*.db3")
    subprocess.run([sys.executable, "-c", WRITE_AHEAD, str(file), "WAL"], check=True)

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(shutil, "copyfile", full)
    with pytest.raises(BagError, match=r"no copy of \d+ bytes could be made in .* set TMPDIR to"):
        read_bag(bag, recover=True)


# What may stand where a table is read: its rows are what code makes of others, or may have no end.
IN_PLACE_OF_TABLES = {
    "a virtual table": (
        "DROP TABLE messages",
        "CREATE VIRTUAL TABLE messages USING fts5(topic_id, timestamp, data)",
    ),
    "a view": (
        "ALTER TABLE messages RENAME TO few",
        "CREATE VIEW messages AS SELECT few.* FROM few, few, few, few",
    ),
}


@pytest.mark.parametrize("changes", IN_PLACE_OF_TABLES.values(), ids=IN_PLACE_OF_TABLES)
def test_what_is_no_table_is_refused(sqlite_bag: Path, changes: tuple[str, ...]) -> None:
    """It is told as a bag that lacks the table."""
    altered(sqlite_bag, *changes)
    with pytest.raises(BagError, match="it lacks rosbag2's tables"):
        read_bag(sqlite_bag)


def test_topics_of_one_number_are_refused(sqlite_bag: Path) -> None:
    """Which of them a message is of cannot be told."""
    altered(
        sqlite_bag,
        "CREATE TABLE many AS SELECT * FROM topics",
        "INSERT INTO many SELECT topics.* FROM topics, messages",
        "DROP TABLE topics",
        "ALTER TABLE many RENAME TO topics",
    )
    with pytest.raises(BagError, match="two of its topics have one number"):
        read_bag(sqlite_bag)


def test_a_description_without_counts_tells_nothing(sample_bag, tmp_path: Path) -> None:
    """Such as another program may have written: the bag is read as before."""
    sent = {"/joint_states": sample_bag.messages["/joint_states"]}
    bag = write(tmp_path / "bag", sent)
    whole = yaml.safe_load((bag / METADATA_FILE).read_text())
    for odd in (None, [], [5], "x", [{"message_count": 3}]):
        whole["rosbag2_bagfile_information"]["topics_with_message_count"] = odd
        (bag / METADATA_FILE).write_text(yaml.safe_dump(whole))
        assert contents(bag) == sent


def in_two_files(path: Path, sent: list[tuple[int, bytes]], storage: StoragePlugin) -> Path:
    """Write a split bag whose description names the first file alone, and counts both."""
    halves = [
        write(path / str(k), {"/joint_states": half}, storage)
        for k, half in enumerate((sent[:100], sent[100:]))
    ]
    (second,) = (file for file in halves[1].iterdir() if file.name != METADATA_FILE)
    shutil.move(second, halves[0])
    whole = yaml.safe_load((halves[0] / METADATA_FILE).read_text())
    about = whole["rosbag2_bagfile_information"]
    about["topics_with_message_count"][0]["message_count"] = about["message_count"] = len(sent)
    (halves[0] / METADATA_FILE).write_text(yaml.safe_dump(whole))
    return halves[0]


STORAGES = {StoragePlugin.SQLITE3: "1.db3", StoragePlugin.MCAP: "1.mcap"}


@pytest.mark.parametrize("storage", STORAGES)
def test_a_file_that_the_description_leaves_out_is_missed(
    sample_bag, tmp_path: Path, storage: StoragePlugin
) -> None:
    """By the number of messages, in one line with the file's name and the way to all of it."""
    sent = sample_bag.messages["/joint_states"]
    bag = in_two_files(tmp_path, sent, storage)
    said = (
        f"/joint_states has 100 messages, {METADATA_FILE} says 300: the bag or its description is "
        f"damaged; {STORAGES[storage]} left out: {METADATA_FILE} lists no such file. Where it "
        f"belongs to the bag, remove {METADATA_FILE}, and all files are read"
    )
    with pytest.raises(BagError) as refusal:
        read_bag(bag)
    assert str(refusal.value) == f"{bag}: {said}"
    assert len(read_bag(bag, recover=True)["/joint_states"]) == 100
    (bag / METADATA_FILE).unlink()
    assert contents(bag) == {"/joint_states": sent}


@pytest.mark.parametrize("storage", STORAGES)
def test_a_file_that_is_another_bags_is_told_and_left_out(
    tmp_path: Path, sample_bag, storage: StoragePlugin
) -> None:
    """The counts agree without it: the bag is read, and its runs say so; a packed copy is none."""
    time = np.arange(200) * 1e-3
    run = MeasuredRun(time, 0 * time, 0 * time + 4e5, 0 * time + 4e5, 0 * time + 6e5, 0 * time + 5)
    ours = contents(rig_bag.write(tmp_path / "ours", run))
    bag = write(tmp_path / "bag", ours, storage)
    (own,) = (file for file in bag.iterdir() if file.name != METADATA_FILE)
    (bag / f"{own.name}.zstd").write_bytes(b"packed")
    assert read_bag(bag).notes == read_run(bag).notes == ()
    shutil.copy(sample_bag.path / "sample_0.mcap", bag / "other.mcap")
    found = read_bag(bag)
    assert found.complete
    (note,) = read_run(bag).notes
    assert (note,) == found.notes
    assert note.startswith(f"{bag}: other.mcap left out: {METADATA_FILE} lists no such file")


@pytest.mark.parametrize("storage", STORAGES)
def test_a_sum_of_messages_that_is_not_there_is_told(
    sample_bag, tmp_path: Path, storage: StoragePlugin
) -> None:
    """The sum over all topics counts too; what rosbag2 says of one file, or left out, does not."""
    sent = {topic: sample_bag.messages[topic] for topic in ("/joint_states", "/valve/voltage")}
    bag = write(tmp_path / "bag", sent, storage)
    whole = yaml.safe_load((bag / METADATA_FILE).read_text())
    about = whole["rosbag2_bagfile_information"]
    about["files"][0]["message_count"] = 5000  # with those that a full cache dropped
    (bag / METADATA_FILE).write_text(yaml.safe_dump(whole))
    assert read_bag(bag).complete
    taken_off = yaml.safe_load((bag / METADATA_FILE).read_text())
    about = taken_off["rosbag2_bagfile_information"]
    del about["topics_with_message_count"][1]
    about["message_count"] = 300
    (bag / METADATA_FILE).write_text(yaml.safe_dump(taken_off))
    assert read_bag(bag).complete
    whole["rosbag2_bagfile_information"]["message_count"] = 999
    (bag / METADATA_FILE).write_text(yaml.safe_dump(whole))
    with pytest.raises(BagError, match=r"it has 600 messages, metadata.yaml says 999: the bag or"):
        read_bag(bag)


def test_a_topic_that_is_listed_twice_has_the_sum(sample_bag, tmp_path: Path) -> None:
    """As by programs that list it once for each kind of publisher."""
    sent = {"/joint_states": sample_bag.messages["/joint_states"]}
    bag = write(tmp_path / "bag", sent, StoragePlugin.MCAP)
    whole = yaml.safe_load((bag / METADATA_FILE).read_text())
    (one,) = whole["rosbag2_bagfile_information"]["topics_with_message_count"]
    halves = [{**one, "message_count": count} for count in (200, 100)]
    whole["rosbag2_bagfile_information"]["topics_with_message_count"] = halves
    (bag / METADATA_FILE).write_text(yaml.safe_dump(whole))
    assert read_bag(bag).complete


def test_the_way_to_a_bag_with_other_counts_leads_there(sample_bag) -> None:
    """Without its description, as the line says, `rodless recover` makes a new one."""
    description = sample_bag.path / METADATA_FILE
    description.write_text(
        description.read_text().replace("message_count: 300", "message_count: 7")
    )
    way = r"600 messages can be recovered \(remove metadata.yaml, then rodless recover\)"
    with pytest.raises(BagError, match=way):
        read_bag(sample_bag.path)
    description.unlink()
    recover_bag(sample_bag.path)
    assert read_bag(sample_bag.path).complete


def test_a_topic_on_two_channels_is_counted_once_by_recovery(sample_bag, tmp_path: Path) -> None:
    """Others write a channel for each publisher: recovery counts the messages of both."""
    with (tmp_path / "bag_0.mcap").open("wb") as stream:
        writer = McapWriter(stream)
        writer.start("ros2")
        schema = writer.register_schema(TYPES["/joint_states"], "ros2msg", b"")
        for place, half in enumerate((slice(0, 100), slice(100, 300))):
            metadata = {"publisher": str(place)}
            channel = writer.register_channel("/joint_states", "cdr", schema, metadata)
            for log_time, data in sample_bag.messages["/joint_states"][half]:
                writer.add_message(channel, log_time, data, log_time)
        writer.finish()
    assert recover_bag(tmp_path) == 300
    assert len(read_bag(tmp_path)["/joint_states"]) == 300


def test_paths_of_an_older_rosbag2_are_found(sample_bag, tmp_path: Path) -> None:
    """Before version 4 the names of the files began with that of the bag's folder."""
    sent = {"/valve/voltage": sample_bag.messages["/valve/voltage"]}
    bag = write(tmp_path / "bag", sent)
    text = (bag / METADATA_FILE).read_text()
    name = next(bag.glob("*.db3")).name
    (bag / METADATA_FILE).write_text(text.replace(f"- {name}", f"- bag/{name}"))
    assert f"- bag/{name}" in (bag / METADATA_FILE).read_text()
    assert contents(bag) == sent


def test_a_run_in_sqlite_gives_the_arrays_of_one_in_mcap(tmp_path: Path) -> None:
    """Position, pressures and voltage are equal, whichever storage they come from."""
    time = np.arange(200) * 1e-3
    wave = np.sin(10.0 * time)
    run = MeasuredRun(time, 0.1 + 0.01 * wave, 4e5 + wave, 4e5 - wave, 0 * time + 6e5, 5.0 + wave)
    ours = rig_bag.write(tmp_path / "ours", run)
    theirs = write(tmp_path / "theirs", contents(ours), compression=CompressionMode.MESSAGE)
    for name, values in read_run(theirs).columns().items():
        np.testing.assert_array_equal(values, read_run(ours).columns()[name], name)


def test_a_reset_of_the_plant_is_seen_in_either_storage(sample_bag, tmp_path: Path) -> None:
    """Times go back where the second run begins; it is not put between the samples of the first."""
    first = sample_bag.messages["/joint_states"]
    sent = {"/joint_states": first + first[:100]}
    for storage in (StoragePlugin.SQLITE3, StoragePlugin.MCAP):
        bag = write(tmp_path / storage.name, sent, storage)
        assert contents(bag) == sent
        assert read_bag(bag)["/joint_states"].restarts() == [len(first)]


WRITE_AHEAD = """
import os, sqlite3, sys
bag = sqlite3.connect(sys.argv[1])
bag.execute(f"PRAGMA journal_mode={sys.argv[2]}")
bag.execute("PRAGMA cache_size=1")  # what is not committed goes to the disk, too
bag.execute("PRAGMA wal_autocheckpoint=0")
with bag:
    bag.execute("UPDATE messages SET timestamp = timestamp + 1")
bag.execute("UPDATE messages SET timestamp = timestamp + 5")
os._exit(0)
"""


@pytest.mark.parametrize("journal", ["WAL", "DELETE"])
def test_what_sqlite_has_beside_a_file_is_a_part_of_it(
    sample_bag, tmp_path: Path, journal: str
) -> None:
    """A killed recording: what it committed is read, what it did not is not, and that is said."""
    sent = sample_bag.messages["/joint_states"]
    bag = write(tmp_path / "bag", {"/joint_states": sent})
    (file,) = bag.glob("*.db3")
    subprocess.run([sys.executable, "-c", WRITE_AHEAD, str(file), journal], check=True)
    beside = f"{file.name}{'-wal' if journal == 'WAL' else '-journal'}"
    before = {one: one.read_bytes() for one in bag.iterdir()}
    (tmp_path / "link.db3").symlink_to(file)
    for path in (tmp_path / "link.db3", bag):
        with pytest.raises(BagError, match=rf"never closed: {beside} is still beside it") as told:
            read_bag(path)
    assert "; 300 messages can be recovered (read_bag(..., recover=True))" in str(told.value)
    found = read_bag(bag, recover=True)
    assert not found.complete
    assert found["/joint_states"].log_time.tolist() == [time + 1 for time, _ in sent]
    assert {one: one.read_bytes() for one in bag.iterdir()} == before
    with closing(sqlite3.connect(file)) as database:  # the way that the line tells
        database.execute("PRAGMA journal_mode=DELETE")
    assert read_bag(bag)["/joint_states"].log_time.tolist() == [time + 1 for time, _ in sent]


def test_whether_sqlite_was_closed_is_told_by_its_description(sample_bag, tmp_path: Path) -> None:
    """Without metadata.yaml nothing tells; a line says so, and the bag passes for no whole one."""
    bag = write(tmp_path / "bag", {"/joint_states": sample_bag.messages["/joint_states"]})
    assert read_bag(bag).notes == ()
    (bag / METADATA_FILE).unlink()
    found = read_bag(bag)
    assert not found.complete
    assert "messages of its end may be missing" in "".join(found.notes)


@pytest.mark.parametrize(
    ("storage", "compression", "said"),
    [
        (StoragePlugin.SQLITE3, CompressionMode.NONE, r"is not plain MCAP; `ros2 bag reindex`"),
        (StoragePlugin.MCAP, CompressionMode.FILE, r"is not plain MCAP; `ros2 bag reindex`"),
        (StoragePlugin.MCAP, CompressionMode.MESSAGE, "holds messages compressed one by one"),
    ],
)
def test_recovery_leaves_alone_what_it_does_not_write(
    sample_bag, tmp_path: Path, storage: StoragePlugin, compression: CompressionMode, said: str
) -> None:
    """Other storages and compressions are refused, and stay as they were."""
    sent = {"/valve/voltage": sample_bag.messages["/valve/voltage"]}
    bag = write(tmp_path / "bag", sent, storage, compression)
    (bag / METADATA_FILE).unlink()
    before = {file: file.read_bytes() for file in bag.iterdir()}
    with pytest.raises(BagError, match=said):
        recover_bag(bag)
    assert {file: file.read_bytes() for file in bag.iterdir()} == before
