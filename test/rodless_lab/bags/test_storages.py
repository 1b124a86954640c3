# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Bags of rosbag2 in every storage and compression, written by an independent program."""

import shutil
import sqlite3
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
    assert contents(next(bag.glob("*.db3"))) == sent


# What a flipped bit makes of a row: SQLite keeps no sums, and any type in any column.
DAMAGE = {
    "UPDATE messages SET timestamp = 'x' WHERE id = 5": "message \\d+ has no time or content",
    "UPDATE messages SET timestamp = 1.5 WHERE id = 5": "message \\d+ has no time or content",
    "UPDATE messages SET data = 7 WHERE id = 5": "message \\d+ has no time or content",
    "DELETE FROM messages WHERE id = 5": "/joint_states has 299 messages, metadata.yaml says 300",
    "UPDATE messages SET topic_id = 3 - topic_id WHERE id = 5": "metadata.yaml says",
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_row_of_sqlite_is_told(sample_bag, tmp_path: Path, damage: str) -> None:
    """In one line, whatever reads the bag; nothing of it passes as whole."""
    sent = {topic: sample_bag.messages[topic] for topic in ("/joint_states", "/valve/voltage")}
    bag = write(tmp_path / "bag", sent)
    assert read_bag(bag).complete
    with closing(sqlite3.connect(next(bag.glob("*.db3")))) as file, file:
        file.execute(damage)
    for read in (read_bag, read_run):
        with pytest.raises(ValueError, match=DAMAGE[damage]) as refusal:
            read(bag)
        assert isinstance(refusal.value, BagError | RunError)
        assert "\n" not in str(refusal.value)
    if "metadata" in DAMAGE[damage]:
        assert not read_bag(bag, recover=True).complete


@pytest.fixture
def sqlite_bag(sample_bag, tmp_path: Path) -> Path:
    """A bag of one topic in SQLite."""
    return write(tmp_path / "bag", {"/joint_states": sample_bag.messages["/joint_states"]})


def test_a_table_that_computes_its_messages_is_bounded(
    sqlite_bag: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A few bytes of SQLite may stand for as many as they like."""
    monkeypatch.setattr(decompress, "LARGEST", 10_000_000)
    monkeypatch.setattr(decompress, "RATIO", 10)
    assert read_bag(sqlite_bag).complete
    with closing(sqlite3.connect(next(sqlite_bag.glob("*.db3")))) as file, file:
        file.execute("ALTER TABLE messages DROP COLUMN data")
        file.execute("ALTER TABLE messages ADD COLUMN data BLOB AS (zeroblob(1000000))")
    with pytest.raises(BagError, match=r"message \d+ has 1000100 bytes, more than \d+"):
        read_bag(sqlite_bag)


def test_a_table_that_multiplies_its_messages_is_bounded(
    sqlite_bag: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each message once for each of many topics of one number, all of them empty."""
    monkeypatch.setattr(decompress, "LARGEST", 100_000)
    monkeypatch.setattr(decompress, "RATIO", 1)
    with closing(sqlite3.connect(next(sqlite_bag.glob("*.db3")))) as file, file:
        file.execute("UPDATE messages SET data = x''")
        file.execute("CREATE TABLE many AS SELECT * FROM topics")
        file.execute("INSERT INTO many SELECT topics.* FROM topics, messages")
        file.execute("DROP TABLE topics")
        file.execute("ALTER TABLE many RENAME TO topics")
    with pytest.raises(BagError, match=r"message \d+ has \d+ bytes, more than \d+"):
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


def test_without_the_library_the_way_to_it_is_told(
    sample_bag, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """SQLite needs an extra; MCAP, compressed or not, needs none."""
    sent = {"/valve/voltage": sample_bag.messages["/valve/voltage"]}
    plain = write(tmp_path / "sqlite", sent)
    packed = write(tmp_path / "mcap", sent, StoragePlugin.MCAP, CompressionMode.MESSAGE)
    monkeypatch.setitem(sys.modules, "rosbags.rosbag2", None)
    with pytest.raises(BagError, match=r"needs the package rosbags: pip install 'rodless_sim\[ba"):
        read_bag(plain)
    assert contents(packed) == sent


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
