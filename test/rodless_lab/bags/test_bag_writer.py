# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A bag we write is a rosbag2 bag: an independent reader finds in it what was put in."""

import struct
import time
from pathlib import Path

import pytest
import yaml
from mcap.reader import make_reader
from no_room import no_room
from rosbags.highlevel import AnyReader
from rosbags.interfaces import Qos, QosDurability, QosHistory, QosReliability

from rodless_lab.bags.metadata import BagError, BagTopic
from rodless_lab.bags.writer import BagWriter

# As `ros2 bag record` of the distribution jazzy writes them, in its order.
KEYS = [
    "version",
    "storage_identifier",
    "duration",
    "starting_time",
    "message_count",
    "topics_with_message_count",
    "compression_format",
    "compression_mode",
    "relative_file_paths",
    "files",
    "custom_data",
    "ros_distro",
]
TOPIC_KEYS = [
    "name",
    "type",
    "serialization_format",
    "offered_qos_profiles",
    "type_description_hash",
]
JOINT_STATE_HASH = "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e"


def description(bag: Path) -> dict:
    return yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]


def test_an_independent_reader_gets_the_same_messages(sample_bag) -> None:
    """Every payload and time comes back byte for byte, in order, and decodes to its values."""
    with AnyReader([sample_bag.path]) as reader:
        read: dict[str, list[tuple[int, bytes]]] = {"/silent": []}
        for connection, log_time, data in reader.messages():
            read.setdefault(connection.topic, []).append((log_time, bytes(data)))
            if connection.topic == "/joint_states":
                state = reader.deserialize(data, connection.msgtype)
                assert state.position[0] == pytest.approx(1e-12 * log_time)
    assert read == sample_bag.messages


@pytest.mark.parametrize("times", [(-1, 0), (0, -1), (2**64, 0)])
def test_a_time_that_a_bag_has_no_room_for_takes_no_other_message_with_it(
    tmp_path: Path, times: tuple[int, int]
) -> None:
    """It is refused, and what came before and comes after is there: an independent reader."""
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic(BagTopic("/setpoint", "std_msgs/msg/Float64"))
        for k in range(4):
            writer.write("/setpoint", bytes(12), k, k)
            with pytest.raises(struct.error):
                writer.write("/setpoint", bytes(12), *times)
    with AnyReader([tmp_path / "bag"]) as reader:
        assert [log_time for _, log_time, _ in reader.messages()] == [0, 1, 2, 3]


def test_an_independent_reader_gets_types_quality_of_service_and_hashes(sample_bag) -> None:
    """What a bag says of its topics is complete: type, hash, counts, one profile a publisher."""
    with AnyReader([sample_bag.path]) as reader:
        found = {connection.topic: connection for connection in reader.connections}
    joint_states = found["/joint_states"]
    assert joint_states.msgtype == "sensor_msgs/msg/JointState"
    assert joint_states.digest == JOINT_STATE_HASH
    assert {name: entry.msgcount for name, entry in found.items()} == {
        "/joint_states": 300,
        "/valve/voltage": 300,
        "/silent": 0,
    }
    profiles = joint_states.ext.offered_qos_profiles
    assert len(profiles) == 2
    profile: Qos = profiles[0]
    assert (profile.history, profile.depth) == (QosHistory.KEEP_LAST, 7)
    assert profile.reliability == QosReliability.BEST_EFFORT
    assert profile.durability == QosDurability.TRANSIENT_LOCAL
    assert (profile.lifespan.sec, profile.lifespan.nsec) == (1, 5)


def test_the_description_has_the_keys_of_rosbag2(sample_bag) -> None:
    """metadata.yaml has the keys of rosbag2's own, in its order, and true numbers."""
    content = description(sample_bag.path)
    assert list(content) == KEYS
    assert content["version"] == 9
    assert content["duration"] == {"nanoseconds": 299_000_000}
    assert content["starting_time"] == {"nanoseconds_since_epoch": 0}
    assert content["message_count"] == 600
    assert content["relative_file_paths"] == ["sample_0.mcap"]
    (file,) = content["files"]
    assert list(file) == ["path", "starting_time", "duration", "message_count"]
    for topic in content["topics_with_message_count"]:
        assert list(topic) == ["topic_metadata", "message_count"]
        assert list(topic["topic_metadata"]) == TOPIC_KEYS


def test_the_storage_file_stands_by_itself(sample_bag) -> None:
    """Checksums, index and the description inside hold without metadata.yaml."""
    with (sample_bag.path / "sample_0.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
        assert summary.statistics.message_count == 600
        channels = {channel.topic: channel for channel in summary.channels.values()}
        by_topic = {
            topic: [(m.log_time, m.data) for _, _, m in reader.iter_messages(topics=[topic])]
            for topic in sample_bag.messages
        }
        inside = [record.metadata["serialized_metadata"] for record in reader.iter_metadata()]
    assert by_topic == sample_bag.messages
    assert channels["/joint_states"].message_encoding == "cdr"
    assert channels["/joint_states"].metadata["topic_type_hash"] == JOINT_STATE_HASH
    assert len(yaml.safe_load(channels["/joint_states"].metadata["offered_qos_profiles"])) == 2
    assert yaml.safe_load(inside[-1]) == description(sample_bag.path)


def test_index_and_messages_agree_in_any_order_of_time(tmp_path: Path) -> None:
    """Messages may come in any order of their times; a reader by index still sorts them."""
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic(BagTopic("/x", "std_msgs/msg/Float64"))
        for log_time in (50, 10, 40, 20, 30):
            writer.write("/x", bytes(12), log_time, log_time)
            writer.flush()
    with (tmp_path / "bag" / "bag_0.mcap").open("rb") as stream:
        times = [m.log_time for _, _, m in make_reader(stream).iter_messages()]
    assert times == [10, 20, 30, 40, 50]
    assert description(tmp_path / "bag")["duration"]["nanoseconds"] == 40


def test_a_bag_without_messages_opens(tmp_path: Path) -> None:
    """Stopping before the first message leaves a bag, not a broken folder."""
    with BagWriter(tmp_path / "bag"):
        pass
    with AnyReader([tmp_path / "bag"]) as reader:
        assert list(reader.messages()) == []


def test_a_bag_is_never_written_over(sample_bag) -> None:
    """A second recording into the same folder is refused and changes nothing."""
    before = {file.name: file.read_bytes() for file in sample_bag.path.iterdir()}
    with pytest.raises(BagError, match="sample: exists already"):
        BagWriter(sample_bag.path)
    assert {file.name: file.read_bytes() for file in sample_bag.path.iterdir()} == before


def test_a_bag_is_removed_with_what_was_made_for_it_alone(tmp_path: Path) -> None:
    """A file of somebody else in the folder stays, and the folder with it."""
    for name in ("alone", "shared"):
        with BagWriter(tmp_path / name / "bag") as writer:
            writer.add_topic(BagTopic("/x", "std_msgs/msg/Float64"))
            if name == "shared":
                (writer.path / "mine.txt").touch()
        writer.remove()
    assert list(tmp_path.iterdir()) == [tmp_path / "shared"]
    assert list((tmp_path / "shared" / "bag").iterdir()) == [tmp_path / "shared/bag/mine.txt"]


def test_what_has_come_in_the_place_of_a_bag_is_not_removed(tmp_path: Path) -> None:
    """It was moved while it was recorded, and another one has begun under its name."""
    first = BagWriter(tmp_path / "bag")
    first.path.rename(tmp_path / "moved")
    with BagWriter(tmp_path / "bag"):
        first.close()
        first.remove()
    assert (tmp_path / "bag" / "bag_0.mcap").is_file()
    assert (tmp_path / "bag" / "metadata.yaml").is_file()


def test_a_bag_that_cannot_be_begun_is_not_in_the_way_of_the_next_try(tmp_path: Path) -> None:
    """A folder can be made on a full disk, its first bytes cannot: both are gone again.

    So it is where the name leaves no room for that of its file.
    """
    for bag in (tmp_path / "bag", tmp_path / "new" / "bag"):
        with no_room(), pytest.raises(BagError, match=r"bag: cannot be written: File too large$"):
            BagWriter(bag)
    # A folder may have this name, the file in it has a longer one.
    with pytest.raises(BagError, match=r"b: cannot be written: File name too long$"):
        BagWriter(tmp_path / ("b" * 250))
    assert list(tmp_path.iterdir()) == []
    BagWriter(tmp_path / "bag").close()
    assert (tmp_path / "bag" / "metadata.yaml").is_file()


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    """A path below a file is refused in words."""
    (tmp_path / "file").touch()
    with pytest.raises(BagError, match="file/bag: cannot be written: Not a directory"):
        BagWriter(tmp_path / "file" / "bag")


def test_flushed_messages_are_in_the_file(tmp_path: Path) -> None:
    """What has been flushed is out of a crash's reach, before the bag is closed."""
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic(BagTopic("/x", "std_msgs/msg/Float64"))
        data = time.time_ns().to_bytes(12, "little")
        writer.write("/x", data, 1, 1)
        assert data not in (tmp_path / "bag" / "bag_0.mcap").read_bytes()
        writer.flush()
        assert data in (tmp_path / "bag" / "bag_0.mcap").read_bytes()
        assert writer.counts == {"/x": 1}


def test_the_counter_of_a_publisher_may_outgrow_the_file(tmp_path: Path) -> None:
    """A rig of 1 kHz has sent 2³² messages after 50 days; the file has room for the lowest bits."""
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic(BagTopic("/x", "std_msgs/msg/Float64"))
        for number in (2**32 - 1, 2**32, 2**32 + 1):
            writer.write("/x", bytes(12), number, number, number)
    with (tmp_path / "bag" / "bag_0.mcap").open("rb") as stream:
        numbers = [m.sequence for _, _, m in make_reader(stream).iter_messages()]
    assert numbers == [2**32 - 1, 0, 1]
