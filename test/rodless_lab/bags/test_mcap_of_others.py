# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""MCAP files by other writers: what ROS 2 cannot mean is refused, and checksums are looked at."""

import struct
from collections.abc import Callable
from pathlib import Path

import pytest
from mcap.records import Channel, DataEnd, Footer, Header, McapRecord, Message, Schema
from mcap.writer import CompressionType, Writer
from quiet_stop import Quiet
from rclpy.serialization import serialize_message
from std_msgs.msg import Float64, Int64

from rodless_lab import read_bag
from rodless_lab.bags.mcap_file.index import MAGIC, encoded
from rodless_lab.bags.message_definition import message_definition
from rodless_lab.bags.metadata import BagError
from rodless_lab.bags.writer import BagWriter
from rodless_lab.cli import recover

FLOAT, INT = "std_msgs/msg/Float64", "std_msgs/msg/Int64"
MESSAGE = struct.Struct("<BQHIQQ")  # the kind of record, its length, and its own head

Messages = list[tuple[str, bytes, int, int]]  # type, payload, log and publish time


def written(path: Path, messages: Messages, encoding: str = "cdr", **options: object) -> Path:
    """Write messages of the topic ``/x``, a channel for each type, with the mcap library."""
    with path.open("wb") as file:
        writer = Writer(file, compression=CompressionType.NONE, **options)
        writer.start("ros2", "test")
        channels: dict[str, int] = {}
        for kind, data, log_time, publish_time in messages:
            if kind not in channels:
                found = message_definition(kind)
                schema = writer.register_schema(kind, found.encoding, found.text.encode())
                channels[kind] = writer.register_channel("/x", encoding, schema)
            writer.add_message(channels[kind], log_time, data, publish_time)
        writer.finish()
    return path


def numbers(count: int) -> Messages:
    """Return messages of the numbers from 0 on."""
    return [(FLOAT, serialize_message(Float64(data=float(k))), k, k) for k in range(count)]


def spoilt(log_time: int, publish_time: int) -> Messages:
    """Return ten messages, one of which has these times."""
    messages = numbers(10)
    messages[5] = (*messages[5][:2], log_time, publish_time)
    return messages


@pytest.mark.parametrize(
    ("log_time", "publish_time"), [(2**63, 5), (5, 2**63), (2**64 - 1, 2**64 - 1)]
)
def test_a_time_that_ros_has_not_is_damage(
    tmp_path: Path, log_time: int, publish_time: int
) -> None:
    """The file counts nanoseconds without a sign: what came before it can be read."""
    bag = written(tmp_path / "x.mcap", spoilt(log_time, publish_time))
    with pytest.raises(BagError, match=r"damaged at byte \d+: .* ns, later than ROS can express"):
        read_bag(bag)
    found = read_bag(bag, recover=True)["/x"]
    assert found.fields["data"].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]


FIRST = Channel(1, "/x", "cdr", {}, schema_id=1)


@pytest.mark.parametrize(
    ("second", "line"),
    [
        (FIRST, ""),
        (Channel(1, "/y", "cdr", {}, schema_id=1), "channel 1 is defined a second time, as anoth"),
        (Schema(1, b"", "ros2msg", INT), "schema 1 is defined a second time, as another one"),
    ],
    ids=["repeated", "another topic", "another type"],
)
def test_a_number_that_comes_to_mean_another_topic_is_damage(
    tmp_path: Path, second: McapRecord, line: str
) -> None:
    """The format forbids it: messages would go to the wrong topic. It may be said twice."""
    found = message_definition(FLOAT)
    schema = Schema(1, found.text.encode(), found.encoding, FLOAT)
    messages = [Message(1, time, data, time, k) for k, (_, data, time, _) in enumerate(numbers(2))]
    data = [Header("ros2", "test"), schema, FIRST, messages[0], second, messages[1]]
    bag = tmp_path / "x.mcap"
    bag.write_bytes(MAGIC + encoded([*data, DataEnd(0), Footer(0, 0, 0)]) + MAGIC)
    if line:
        with pytest.raises(BagError, match=rf"is damaged at byte \d+: {line}"):
            read_bag(bag)
    assert read_bag(bag, recover=bool(line))["/x"].log_time.tolist() == [0, 1][: 1 if line else 2]


def test_the_last_time_that_ros_has_is_none(tmp_path: Path) -> None:
    """Three centuries from now."""
    bag = written(tmp_path / "x.mcap", spoilt(2**63 - 1, 2**63 - 1))
    assert int(read_bag(bag)["/x"].log_time.max()) == 2**63 - 1


def test_messages_of_two_types_are_refused(tmp_path: Path) -> None:
    """Both are eight bytes: a whole number would be read as another real one."""
    messages = [*numbers(3), (INT, serialize_message(Int64(data=7)), 3, 3)]
    bag = read_bag(written(tmp_path / "x.mcap", messages))
    assert len(bag["/x"]) == 4
    with pytest.raises(BagError, match=f"/x: messages of {FLOAT} and {INT} under one name"):
        _ = bag["/x"].messages


def test_messages_of_two_types_in_two_files_are_refused(tmp_path: Path) -> None:
    """As in a bag that somebody has put together of others."""
    folder = tmp_path / "bag"
    folder.mkdir()
    written(folder / "bag_0.mcap", numbers(3))
    written(folder / "bag_1.mcap", [(INT, serialize_message(Int64(data=7)), 3, 3)])
    with pytest.raises(BagError, match=f"/x: messages of {FLOAT} and {INT} under one name"):
        _ = read_bag(folder)["/x"].messages


def test_a_second_type_without_messages_is_none(tmp_path: Path) -> None:
    """Somebody offered it and never sent anything."""
    with (tmp_path / "x.mcap").open("wb") as file:
        writer = Writer(file, compression=CompressionType.NONE)
        writer.start("ros2", "test")
        for kind in (INT, FLOAT):
            found = message_definition(kind)
            schema = writer.register_schema(kind, found.encoding, found.text.encode())
            channel = writer.register_channel("/x", "cdr", schema)
        writer.add_message(channel, 1, serialize_message(Float64(data=2.5)), 1)
        writer.finish()
    assert read_bag(tmp_path / "x.mcap")["/x"].fields["data"].tolist() == [2.5]


def test_messages_in_another_encoding_are_not_read_as_cdr(tmp_path: Path) -> None:
    """The bag can be read all the same: it is that topic's messages that cannot."""
    bag = read_bag(written(tmp_path / "x.mcap", numbers(3), encoding="json"))
    assert len(bag["/x"]) == 3
    with pytest.raises(BagError, match="/x: its messages are in 'json', must be in cdr"):
        _ = bag["/x"].messages


def test_two_encodings_under_one_name_are_told_apart(tmp_path: Path) -> None:
    """The types are the same: what differs is named. No copy mixes them without a word, either."""
    with (tmp_path / "x.mcap").open("wb") as file:
        writer = Writer(file, compression=CompressionType.NONE)
        writer.start("ros2", "test")
        found = message_definition(FLOAT)
        schema = writer.register_schema(FLOAT, found.encoding, found.text.encode())
        for time, encoding in enumerate(("cdr", "json")):
            channel = writer.register_channel("/x", encoding, schema)
            writer.add_message(channel, time, serialize_message(Float64(data=2.5)), time)
        writer.finish()
    mixed = read_bag(tmp_path / "x.mcap")["/x"]
    said = r"/x: messages of std_msgs/msg/Float64 and std_msgs/msg/Float64 in 'json' under one name"
    with pytest.raises(BagError, match=said):
        _ = mixed.messages
    with BagWriter(tmp_path / "copy") as copy, pytest.raises(BagError, match=said):
        copy.add_topic(mixed.topic)


LOOSE = {"use_chunking": False, "enable_data_crcs": True}


def flipped(content: bytes) -> bytes:
    """Turn the number 3 into another."""
    assert content.count(struct.pack("<d", 3.0)) == 1
    return content.replace(struct.pack("<d", 3.0), struct.pack("<d", 3.5))


@pytest.mark.parametrize(
    "spoil", [flipped, lambda content: content.replace(b"test", b"rest", 1)], ids=["data", "header"]
)
def test_the_checksum_of_all_data_is_looked_at(
    tmp_path: Path, spoil: Callable[[bytes], bytes]
) -> None:
    """Where there are no chunks with their own, it is all that tells a flipped bit."""
    bag = written(tmp_path / "x.mcap", numbers(10), **LOOSE)
    assert read_bag(bag)["/x"].fields["data"].tolist() == [float(k) for k in range(10)]
    bag.write_bytes(spoil(bag.read_bytes()))
    with pytest.raises(
        BagError, match=r"damaged at byte \d+: the checksum of all data before is wrong"
    ):
        read_bag(bag)
    assert len(read_bag(bag, recover=True)["/x"]) == 10


def test_recovery_does_not_call_a_wrong_checksum_sound(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It cuts off ends, and this bag has its end: code 2, and not a byte is changed."""
    folder = tmp_path / "bag"
    folder.mkdir()
    bag = written(folder / "bag_0.mcap", numbers(10), **LOOSE)
    bag.write_bytes(flipped(bag.read_bytes()))
    before = bag.read_bytes()
    assert recover.main([str(folder)], Quiet()) == 2
    assert "the checksum of all data before is wrong" in capsys.readouterr().err
    assert bag.read_bytes() == before


def test_a_message_that_is_gone_is_missed(tmp_path: Path) -> None:
    """Without chunks and checksum the file's own count tells, where there is one."""
    whole = written(tmp_path / "x.mcap", numbers(10), use_chunking=False)
    content = whole.read_bytes()
    one = len(MESSAGE.pack(0x05, 0, 0, 0, 0, 0)) + len(numbers(1)[0][1])
    begin = content.index(struct.pack("<d", 3.0)) + 8 - one
    assert content[begin] == 0x05
    bag = tmp_path / "y.mcap"
    bag.write_bytes(content[:begin] + content[begin + one :])
    with pytest.raises(BagError, match=r"damaged at byte \d+: holds 9 messages, its statistics 10"):
        read_bag(bag)
    found = read_bag(bag, recover=True)["/x"].fields["data"].tolist()
    assert found == [0.0, 1.0, 2.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]
    bag = written(tmp_path / "z.mcap", numbers(10), use_chunking=False, use_statistics=False)
    assert len(read_bag(bag)["/x"]) == 10


@pytest.mark.parametrize("length", [0, 2])
def test_an_end_that_is_cut_within_its_record_is_damage(tmp_path: Path, length: int) -> None:
    """It has room for no checksum."""
    bag = written(tmp_path / "x.mcap", numbers(10), **LOOSE)
    content = bag.read_bytes()
    end = content.rindex(struct.pack("<BQ", 0x0F, 4))
    rest = content[end + 13 :]
    bag.write_bytes(content[:end] + struct.pack("<BQ", 0x0F, length) + bytes(length) + rest)
    with pytest.raises(BagError, match="damaged at byte"):
        read_bag(bag)
    assert len(read_bag(bag, recover=True)["/x"]) == 10
