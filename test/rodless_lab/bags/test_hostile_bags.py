# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Bags made to do harm: a sentence and exit code 2, no memory eaten, nobody's file touched."""

import functools
import struct
import subprocess
import sys
import time
import tracemalloc
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import SimpleNamespace

import lz4.frame
import pytest
import yaml
import zstandard
from mcap.records import Channel, Chunk, DataEnd, Footer, Header, Message, Schema
from quiet_stop import Quiet
from rclpy.serialization import serialize_message
from std_msgs.msg import Float64

from rodless_lab.bags import decompress, recorded_topics
from rodless_lab.bags import reader as bag_reader
from rodless_lab.bags.mcap_file.index import MAGIC, encoded
from rodless_lab.bags.metadata import METADATA_FILE, BagError
from rodless_lab.bags.reader import read_bag
from rodless_lab.bags.writer import recover_bag
from rodless_lab.cli import recover, replay
from rodless_lab.runs.from_bag import read_commands, read_run
from rodless_lab.runs.measured_run import RunError

FLOAT = "std_msgs/msg/Float64"
NUMBER = serialize_message(Float64(data=1.0))


def records(
    data: bytes = NUMBER, kind: str = FLOAT, qos: str = "", topic: str = "/joint_states"
) -> bytes:
    """A schema, a channel and one message of it."""
    metadata: Mapping[str, str] = {"offered_qos_profiles": qos}
    return encoded(
        [
            Schema(id=1, data=b"", encoding="ros2msg", name=kind),
            Channel(id=1, topic=topic, message_encoding="cdr", metadata=metadata, schema_id=1),
            Message(channel_id=1, data=data, log_time=1, publish_time=1, sequence=0),
        ]
    )


def file_of(path: Path, content: bytes) -> Path:
    """Write a bag of one storage file, closed properly, without summary or metadata.yaml."""
    path.mkdir()
    end = [DataEnd(data_section_crc=0), Footer(0, 0, 0)]
    begin = MAGIC + encoded([Header(profile="ros2", library="")])
    (path / "bag_0.mcap").write_bytes(begin + content + encoded(end) + MAGIC)
    return path


def chunk(compression: str, data: bytes, size: int) -> bytes:
    """A chunk of ``data``, which declares to hold ``size`` bytes."""
    return encoded(
        [
            Chunk(
                compression=compression,
                data=data,
                message_start_time=1,
                message_end_time=1,
                uncompressed_crc=0,
                uncompressed_size=size,
            )
        ]
    )


def zstd_stream(count: int) -> bytes:
    """``count`` zeros, compressed without a word of how many there are."""
    compressor = zstandard.ZstdCompressor().compressobj()
    pieces = [compressor.compress(bytes(1_000_000)) for _ in range(count // 1_000_000)]
    return b"".join([*pieces, compressor.flush()])


def refusal(bag: Path, capsys: pytest.CaptureFixture[str], command=replay) -> str:
    """Run a command on the bag; return the one line that it says with code 2."""
    capsys.readouterr()
    arguments = ["--output", str(bag.parent / "out")] if command is replay else []
    assert command.main([str(bag), *arguments], Quiet()) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert bag.name in said
    return said


MEGABYTES = 400
BOMBS = {
    "declared": lambda: chunk("zstd", zstandard.compress(bytes(MEGABYTES * 10**6)), 4 * 10**8),
    "lies": lambda: chunk("zstd", zstandard.compress(bytes(MEGABYTES * 10**6)), 1000),
    "streamed": lambda: chunk("zstd", zstd_stream(MEGABYTES * 10**6), 1000),
    "lz4": lambda: chunk("lz4", lz4.frame.compress(bytes(MEGABYTES * 10**6)), 1000),
    "message": lambda: records(zstandard.compress(bytes(MEGABYTES * 10**6))),
    "message_streamed": lambda: records(zstd_stream(MEGABYTES * 10**6)),
}

# Prints what was said of the bag, and how many MB the reading took at most.
READ = """
import resource, sys
from rodless_lab.bags.reader import BagError, read_bag
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
try:
    read_bag(sys.argv[1])
    print("read")
except BagError as error:
    print(error)
print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) // 1000)
"""


@pytest.mark.parametrize("bomb", ["declared", "lies", "streamed", "lz4", "message"])
def test_a_small_file_does_not_become_a_large_one_in_memory(tmp_path: Path, bomb: str) -> None:
    """400 MB of zeros take a few kB: they are refused before they are there."""
    bag = file_of(tmp_path / "bag", BOMBS[bomb]())
    done = subprocess.run(
        [sys.executable, "-c", READ, str(bag)], capture_output=True, text=True, check=True
    )
    said, megabytes = done.stdout.splitlines()
    assert "bag_0.mcap" in said
    assert "declare" in said or "more than" in said
    # The compressed lz4 chunk itself is 1.6 MB.
    assert int(megabytes) < MEGABYTES / 4


def a_million_bytes() -> bytes:
    """What a chunk may hold: the definition of a type, which is nearly all zeros."""
    size = 1_000_000 - len(encoded([Schema(id=1, data=b"", encoding="", name="")]))
    return encoded([Schema(id=1, data=bytes(size), encoding="", name="")])


@pytest.mark.parametrize("compression", ["zstd", "lz4"])
def test_all_chunks_of_a_file_together_are_bounded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compression: str
) -> None:
    """Chunks that are fine one by one do not get through in any number."""
    monkeypatch.setattr(decompress, "LARGEST", 3_000_000)
    monkeypatch.setattr(decompress, "RATIO", 10)
    packer = {"zstd": zstandard.compress, "lz4": lz4.frame.compress}[compression]
    one = chunk(compression, packer(a_million_bytes()), 1_000_000)
    read_bag(file_of(tmp_path / "two", one * 2))
    with pytest.raises(BagError, match="a compressed chunk declares 1000000 bytes"):
        read_bag(file_of(tmp_path / "ten", one * 10))


def test_all_files_of_a_bag_together_are_bounded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Files that are fine one by one do not get through in any number."""
    monkeypatch.setattr(decompress, "LARGEST", 3_000_000)
    monkeypatch.setattr(decompress, "RATIO", 10)
    one = chunk("zstd", zstandard.compress(a_million_bytes()), 1_000_000)
    bag = file_of(tmp_path / "bag", one * 2)
    assert read_bag(bag).complete
    (bag / "bag_1.mcap").write_bytes((bag / "bag_0.mcap").read_bytes())
    with pytest.raises(BagError, match=r"bag_1\.mcap .* a compressed chunk declares 1000000 bytes"):
        read_bag(bag)


def test_what_is_packed_within_something_packed_is_bounded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The file that unpacks to 10 MB allows for no more than it is long itself."""
    monkeypatch.setattr(decompress, "LARGEST", 12_000_000)
    monkeypatch.setattr(decompress, "RATIO", 10)
    attachment = struct.pack("<BQ", 9, 10_000_000) + bytes(10_000_000)
    one = chunk("zstd", zstandard.compress(a_million_bytes()), 1_000_000)
    bag = file_of(tmp_path / "bag", attachment + 5 * one)
    plain = bag / "bag_0.mcap"
    assert read_bag(bag).complete
    (bag / "bag_0.mcap.zstd").write_bytes(zstandard.compress(plain.read_bytes()))
    plain.unlink()
    with pytest.raises(BagError, match="a compressed chunk declares 1000000 bytes"):
        read_bag(bag)


@pytest.mark.parametrize(
    "attempt", [read_bag, recover_bag, functools.partial(read_bag, recover=True)]
)
def test_want_of_memory_is_no_damage(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, attempt: Callable[[Path], object]
) -> None:
    """It is told as what it is, and nothing of the bag passes as all that can be read."""
    content = records()
    bag = file_of(tmp_path / "bag", chunk("zstd", zstandard.compress(content), len(content)))

    def full(*_: object) -> bytes:
        raise MemoryError

    monkeypatch.setattr(decompress.Decompressor, "chunk", full)
    with pytest.raises(BagError, match=r"bag_0\.mcap: needs more memory than there is; read it"):
        attempt(bag)


@pytest.mark.parametrize("attribute", ["messages", "fields"])
def test_want_of_memory_for_what_a_bag_holds_is_told(
    sample_bag, monkeypatch: pytest.MonkeyPatch, attribute: str
) -> None:
    """The messages are none of another type for that; and no traceback ends a command."""

    def full(*_: object) -> None:
        raise MemoryError

    voltage = read_bag(sample_bag.path)["/valve/voltage"]
    if attribute == "messages":
        monkeypatch.setattr("rclpy.serialization.deserialize_message", full)
    else:
        monkeypatch.setattr(bag_reader, "_value", full)
    with pytest.raises(BagError, match=r"^/valve/voltage.*: needs more memory than there is"):
        dict(getattr(voltage, attribute))


def test_what_is_too_large_is_not_called_damaged(tmp_path: Path) -> None:
    """It is whole, and no bag of a rig is like it."""
    bag = file_of(tmp_path / "bag", BOMBS["declared"]())
    said = (
        r"bag_0\.mcap is too large at byte \d+: a compressed chunk declares 400000000 bytes, more"
    )
    with pytest.raises(BagError, match=said):
        read_bag(bag)


@pytest.mark.parametrize("packed", [zstandard.compress(bytes(10**7)), zstd_stream(10**7)])
def test_a_file_compressed_as_a_whole_is_bounded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, packed: bytes
) -> None:
    """It goes to a temporary file, and no further than a bag may be long."""
    monkeypatch.setattr(decompress, "LARGEST", 1_000_000)
    monkeypatch.setattr(decompress, "RATIO", 10)
    (tmp_path / "bag").mkdir()
    (tmp_path / "bag" / "bag_0.mcap.zstd").write_bytes(packed)
    with pytest.raises(BagError, match=r"bag_0.mcap.zstd compressed data hold more than \d+ bytes"):
        read_bag(tmp_path / "bag")


def test_a_message_of_unknown_length_is_bounded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A message compressed by itself says of its size what it likes."""
    monkeypatch.setattr(decompress, "LARGEST", 1_000_000)
    with pytest.raises(BagError, match="compressed data hold more than 1000000 bytes"):
        read_bag(file_of(tmp_path / "bag", records(zstd_stream(10**7))))


@pytest.mark.parametrize(
    "content",
    [
        chunk("zstd", zstandard.compress(records())[:-3], len(records())),
        chunk("zstd", b"not zstd at all", 15),
        chunk("lz4", b"not lz4 at all", 14),
        chunk("brotli", records(), len(records())),
        chunk("", records(), len(records()) + 1),
        chunk("zstd", zstandard.compress(records()), len(records()) - 1),
        chunk("zstd", zstandard.compress(records()), 2**63),
        records(zstandard.compress(NUMBER)[:-3]),
    ],
)
def test_broken_compression_is_told_in_a_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], content: bytes
) -> None:
    """Cut, foreign or lying chunks and messages."""
    assert "bag_0.mcap" in refusal(file_of(tmp_path / "bag", content), capsys)


def test_whole_chunks_are_read(tmp_path: Path) -> None:
    """The same chunks, true to what they declare: what is refused above is refused for a reason."""
    content = records()
    for name, packed in (
        ("zstd", zstandard.compress(content)),
        ("lz4", lz4.frame.compress(content)),
    ):
        bag = file_of(tmp_path / name, chunk(name, packed, len(content)))
        assert list(read_bag(bag)["/joint_states"].payloads) == [NUMBER]


# Each within the one before it, and none by more than one level.
DEEP_BY_ALIASES = "\n".join(["a0: &a0 [1]", *(f"a{k}: &a{k} [*a{k - 1}]" for k in range(1, 1500))])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("5", "'5' are no profiles of quality of service"),
        ("[5]", "are no profiles"),
        ("{a: 1}", "are no profiles"),
        ("[" * 5000, "are no profiles"),
        ("2001-99-99", "are no profiles"),
        ("- !!bool foo", "are no profiles"),
        ("- !!timestamp x", "are no profiles"),
        ("- {<<: {a: 1}}", "are no profiles"),
        (DEEP_BY_ALIASES, "are no profiles"),
        ("\0", "are no profiles"),
        ("- a: " + "x" * 100_000, "of 100005 characters, more than 100000"),
    ],
)
@pytest.mark.parametrize("command", [replay, recover])
def test_quality_of_service_that_is_none(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, said: str, command
) -> None:
    """The text of a channel is anything but a list of profiles; recovery changes nothing either."""
    bag = file_of(tmp_path / "bag", records(qos=text))
    before = (bag / "bag_0.mcap").read_bytes()
    assert said in refusal(bag, capsys, command)
    assert (bag / "bag_0.mcap").read_bytes() == before
    assert not (bag / METADATA_FILE).exists()


def channels(texts: Sequence[str]) -> bytes:
    """A channel with each of these profiles of quality of service, and a message behind it."""
    content = [Schema(id=1, data=b"", encoding="ros2msg", name=FLOAT)]
    for number, text in enumerate(texts, start=1):
        metadata = {"offered_qos_profiles": text}
        content += [
            Channel(
                id=number,
                topic=f"/t{number}",
                message_encoding="cdr",
                metadata=metadata,
                schema_id=1,
            ),
            Message(channel_id=number, data=NUMBER, log_time=1, publish_time=1, sequence=0),
        ]
    return encoded(content)


@pytest.mark.parametrize(("different", "expected"), [(True, 100), (False, 1)])
def test_profiles_are_parsed_once_each(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, *, different: bool, expected: int
) -> None:
    """However many channels there are, each with its first message behind those of the others."""
    bag = file_of(tmp_path / "bag", channels([f"- {{a: {k * different}}}" for k in range(100)]))
    (bag / "bag_1.mcap").write_bytes((bag / "bag_0.mcap").read_bytes())
    parsed = []

    def load(text: str, loader: object) -> object:
        parsed.append(text)
        return yaml.load(text, loader)

    monkeypatch.setattr(recorded_topics, "yaml", SimpleNamespace(load=load, YAMLError=ValueError))
    found = read_bag(bag)
    assert len(parsed) == expected
    assert found["/t100"].topic.qos == ({"a": 99 * different},)


def test_profiles_are_bounded_in_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A few bytes for each channel, in a chunk, would be minutes of parsing."""
    monkeypatch.setattr(recorded_topics, "_LONGEST_PROFILES_IN_ALL", 50)
    bag = file_of(tmp_path / "bag", channels([f"- {{a: {k}}}" for k in range(10)]))
    said = "'/t7': profiles of quality of service with which those of the bag have more than 50 ch"
    with pytest.raises(BagError, match=said):
        read_bag(bag)
    with pytest.raises(BagError, match=said):
        recover_bag(bag)


@pytest.mark.parametrize("kind", ["../x", "", "/", "a/b/c/d", "os/path", "antigravity/msg/X"])
def test_a_type_that_is_no_message_is_not_imported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str
) -> None:
    """A name that leads elsewhere, or to a module of Python, whose import would run it."""
    before = set(sys.modules)
    bag = file_of(tmp_path / "bag", records(kind=kind))
    said = f"its type {kind} is not installed" if kind else "the bag does not say of which type its"
    assert f"/joint_states: {said}" in refusal(bag, capsys)
    assert "antigravity" not in set(sys.modules) - before


def test_a_module_beside_the_messages_is_no_type(tmp_path: Path) -> None:
    """What std_msgs.msg holds besides messages cannot be deserialised."""
    bag = file_of(tmp_path / "bag", records(kind="std_msgs/msg/_float64"))
    with pytest.raises(BagError, match="/joint_states: "):
        _ = read_bag(bag)["/joint_states"].messages


@pytest.mark.parametrize("data", [b"", b"\0", b"\0\1\0\0", b"\xff" * 40, NUMBER[:-1]])
def test_data_that_are_no_message(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], data: bytes
) -> None:
    """Too short or senseless for its type: topic and place are named."""
    bag = file_of(tmp_path / "bag", records(data, "sensor_msgs/msg/JointState"))
    assert "/joint_states: message 0 is no sensor_msgs/msg/JointState" in refusal(bag, capsys)


@pytest.mark.parametrize(
    "kind", ["std_msgs/msg/Float64", "std_msgs/msg/Header", "geometry_msgs/msg/Pose"]
)
def test_another_type_than_the_topic_has(tmp_path: Path, kind: str) -> None:
    """A topic of the rig with messages of another kind is refused by every reader of runs."""
    data = NUMBER if kind == FLOAT else bytes(200)
    bag = file_of(tmp_path / "bag", records(data, kind))
    for read in (read_run, read_commands):
        with pytest.raises(ValueError, match="/joint_states"):
            read(bag)


DESCRIPTIONS = {
    "relative_file_paths: 5": "relative_file_paths is 5, not a list",
    "relative_file_paths: {a: b}": "relative_file_paths is {'a': 'b'}, not a list",
    "relative_file_paths: [../bag_0.mcap]": "names '../bag_0.mcap', which is not in the bag",
    "relative_file_paths: [a/../../bag_0.mcap]": "which is not in the bag",
    "relative_file_paths: [/etc/passwd]": "names '/etc/passwd', which is not in the bag",
    'relative_file_paths: ["a\\0b.mcap"]': "which is not in the bag",
    "relative_file_paths: [.]": "is neither MCAP nor SQLite",
    "relative_file_paths: [metadata.yaml]": "is neither MCAP nor SQLite",
    "relative_file_paths: [x.mcap]": "its file x.mcap is missing",
    "relative_file_paths: " + "[" * 5000: "not the description of a rosbag2 bag",
    "a: {<<: {b: 1}}": "rosbag2 bag (line 3: merging (<<) is not for ROS; write the values out)",
    "a: &a [*a]": "rosbag2 bag (line 3: nested more than 20 levels deep)",
    DEEP_BY_ALIASES.replace("\n", "\n  "): "nested more than 20 levels deep)",
    "other: 5": "not the description of a rosbag2 bag (it has no relative_file_paths)",
}

JUNK = {
    b"hello": "it has no entries below rosbag2_bagfile_information",
    b"": "it has no entries below rosbag2_bagfile_information",
    b"[5]": "it has no entries below rosbag2_bagfile_information",
    b"5": "it has no entries below rosbag2_bagfile_information",
    b"rosbag2_bagfile_information: 3": "it has no entries below rosbag2_bagfile_information",
    b"rosbag2_bagfile_information: [3]": "it has no entries below rosbag2_bagfile_information",
    b"rosbag2_bagfile_information: {}": "it has no relative_file_paths",
    b"a: \xff": "byte 3 is no text in UTF-8",
    b"[" * 5000: "line 1: nested more than 20 levels deep",
}


@pytest.mark.parametrize("content", JUNK)
def test_a_description_that_is_none(
    sample_bag, capsys: pytest.CaptureFixture[str], content: bytes
) -> None:
    """What it lacks, in words of our own; and without it the bag is read, as the line says."""
    (sample_bag.path / METADATA_FILE).write_bytes(content)
    said = f"{sample_bag.path / METADATA_FILE}: not the description of a rosbag2 bag"
    assert f"{said} ({JUNK[content]}); without it the bag is" in refusal(sample_bag.path, capsys)
    (sample_bag.path / METADATA_FILE).unlink()
    assert read_bag(sample_bag.path).complete


@pytest.mark.parametrize("entry", DESCRIPTIONS)
def test_a_description_that_leads_astray(
    sample_bag, tmp_path: Path, capsys: pytest.CaptureFixture[str], entry: str
) -> None:
    """Reading and recovery refuse it; a file outside the bag stays as it is."""
    stranger = tmp_path / "bag_0.mcap"
    stranger.write_bytes((sample_bag.path / "sample_0.mcap").read_bytes()[:30_000])
    before = stranger.read_bytes()
    description = sample_bag.path / METADATA_FILE
    description.write_text(
        f"rosbag2_bagfile_information:\n  message_count: 600\n  {entry}\n", encoding="utf-8"
    )
    for command in (replay, recover):
        assert DESCRIPTIONS[entry] in refusal(sample_bag.path, capsys, command)
    assert stranger.read_bytes() == before


# Ten of ten of ten of ...: nothing in memory, and no end of text.
LAUGHS = "\n".join(
    f"  a{k}: &a{k} [{', '.join([f'*a{k - 1}' if k else 'ha'] * 10)}]" for k in range(9)
)
LAUGHING = {
    "relative_file_paths: [*a8]": "which is not in the bag",
    "relative_file_paths: {q: *a8}": "not a list",
    "message_count: *a8": "not a number of messages",
}


@pytest.mark.parametrize("entry", LAUGHING)
def test_a_description_that_repeats_itself_is_not_spelt_out(
    sample_bag, capsys: pytest.CaptureFixture[str], entry: str
) -> None:
    """A billion texts by way of aliases: the line is short, and so is the way to it."""
    others = {"message_count": "600", "relative_file_paths": "[sample_0.mcap]"}
    others.pop(entry.partition(":")[0])
    ((name, value),) = others.items()
    text = f"rosbag2_bagfile_information:\n{LAUGHS}\n  {entry}\n  {name}: {value}\n"
    (sample_bag.path / METADATA_FILE).write_text(text, encoding="utf-8")
    tracemalloc.start()
    said = refusal(sample_bag.path, capsys, recover)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert LAUGHING[entry] in said
    assert len(said) < 1000
    assert most < 50e6


def test_numbers_to_base_60_take_no_time(sample_bag) -> None:
    """YAML 1.1 has them; 400 kB of one took half a minute. Here it takes no longer than a text."""
    description = sample_bag.path / METADATA_FILE
    before = description.read_text()

    def taken(other: str) -> float:
        description.write_text(f"{before}other: {other}\n")
        begun = time.process_time()
        assert read_bag(sample_bag.path).complete
        return time.process_time() - begun

    taken("")  # the first reading imports
    assert taken("1:" * 200_000 + "1") < 5.0 * taken("1;" * 200_000 + "1")


def test_what_a_bag_names_commands_no_terminal(sample_bag) -> None:
    """ESC in a name is spelt out, and of many topics some are named."""
    description = sample_bag.path / METADATA_FILE
    text = description.read_text().replace("- sample_0.mcap", '- "\\e[31m.mcap"')
    description.write_text(text)
    with pytest.raises(BagError, match=r"its file \\x1b\[31m\.mcap is missing"):
        read_bag(sample_bag.path)


ODD_TEXTS = """
  custom_data:
    serial: 123456789012345678901234567890
    hexadecimal: 0xffffffffffffffffffffff
    day: 2024-13-45
    answer: !!bool perhaps
    number: !!int ''
    time: !!timestamp soon
    lift: 190:20:30
"""


def test_texts_that_look_like_something_else_are_texts(sample_bag) -> None:
    """As others write them without quotes, where nobody needs them: the bag is read, and ended."""
    description = sample_bag.path / METADATA_FILE
    description.write_text(description.read_text().replace("\n  custom_data: null\n", ODD_TEXTS))
    assert "190:20:30" in description.read_text()
    assert read_bag(sample_bag.path).complete
    assert recover.main([str(sample_bag.path)], Quiet()) == 0


@pytest.mark.parametrize("text", ["- {a: !!int ''}", f"- {{a: 0x{'f' * 20_000}}}"])
def test_a_profile_with_such_a_text_can_be_recovered(tmp_path: Path, text: str) -> None:
    """It is written again as the text that it is."""
    bag = file_of(tmp_path / "bag", records(qos=text))
    assert recover.main([str(bag)], Quiet()) == 0
    assert read_bag(bag).complete


@pytest.mark.parametrize("count", ["abc", "[1]", "1.5"])
def test_a_count_that_is_none(sample_bag, capsys: pytest.CaptureFixture[str], count: str) -> None:
    """`rodless recover` compares with the count of the description: it must be one."""
    description = sample_bag.path / METADATA_FILE
    text = description.read_text()
    description.write_text(text.replace("  message_count: 600", f"  message_count: {count}", 1))
    said = refusal(sample_bag.path, capsys, recover)
    assert "message_count is" in said
    assert "not a number of messages" in said


def test_a_description_too_long_is_not_parsed(sample_bag) -> None:
    """100 MB of YAML would take minutes."""
    with (sample_bag.path / METADATA_FILE).open("wb") as file:
        file.truncate(100_000_000)
    with pytest.raises(BagError, match="longer than 3000000 bytes"):
        read_bag(sample_bag.path)


def through_a_link(bag: Path, stranger: Path) -> None:
    (bag / "sample_0.mcap").unlink()
    (bag / "sample_0.mcap").symlink_to(stranger)


def through_a_folder(bag: Path, stranger: Path) -> None:
    (bag / "deeper").symlink_to(stranger.parent)
    text = (bag / METADATA_FILE).read_text()
    (bag / METADATA_FILE).write_text(text.replace("- sample_0.mcap", f"- deeper/{stranger.name}"))


@pytest.mark.parametrize("lead_out", [through_a_link, through_a_folder])
def test_recovery_follows_no_link_out_of_the_bag(
    sample_bag,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    lead_out: Callable[[Path, Path], None],
) -> None:
    """A link to somebody's cut file does not get that file cut."""
    (tmp_path / "elsewhere").mkdir()
    stranger = tmp_path / "elsewhere" / "stranger_0.mcap"
    stranger.write_bytes((sample_bag.path / "sample_0.mcap").read_bytes()[:30_000])
    before = stranger.read_bytes()
    lead_out(sample_bag.path, stranger)
    assert "leads out of the bag, to" in refusal(sample_bag.path, capsys, recover)
    assert stranger.read_bytes() == before


@pytest.mark.parametrize("exists", [True, False])
def test_recovery_writes_no_description_out_of_the_bag(
    sample_bag, tmp_path: Path, capsys: pytest.CaptureFixture[str], exists: bool
) -> None:
    """A link in place of metadata.yaml, to that of another bag or to what is not there.

    The line says that the link is to be removed; then the bag is recovered.
    """
    cut = sample_bag.path / "sample_0.mcap"
    cut.write_bytes(cut.read_bytes()[:30_000])
    description = sample_bag.path / METADATA_FILE
    stranger = tmp_path / "stranger.yaml"
    before = description.read_bytes()
    if exists:
        stranger.write_bytes(before)
    description.unlink()
    description.symlink_to(stranger)
    said = refusal(sample_bag.path, capsys, recover)
    assert f"metadata.yaml leads out of the bag, to {stranger}; remove that link\n" in said
    assert stranger.exists() == exists
    assert not exists or stranger.read_bytes() == before
    description.unlink()
    assert recover.main([str(sample_bag.path)], Quiet()) == 0
    assert read_bag(sample_bag.path).complete


def test_recovery_of_a_bag_behind_a_link_works(sample_bag, tmp_path: Path) -> None:
    """The folder itself may be a link, as data folders often are."""
    file = sample_bag.path / "sample_0.mcap"
    file.write_bytes(file.read_bytes()[:30_000])
    (tmp_path / "link").symlink_to(sample_bag.path)
    assert recover.main([str(tmp_path / "link")], Quiet()) == 0
    assert read_bag(sample_bag.path).complete


@pytest.mark.parametrize("content", [b"", b"SQLite format 3\0" + bytes(4096), b"hello" * 1000])
def test_what_is_no_database(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], content: bytes
) -> None:
    """A .db3 file that SQLite cannot open, or that is not rosbag2's."""
    (tmp_path / "bag").mkdir()
    (tmp_path / "bag" / "bag_0.db3").write_bytes(content)
    assert "not a bag in SQLite, or damaged" in refusal(tmp_path / "bag", capsys)


def test_the_folder_of_these_tests_can_be_read_at_all(tmp_path: Path) -> None:
    """A bag written the same way, without anything hostile in it, is read."""
    assert list(read_bag(file_of(tmp_path / "bag", records()))["/joint_states"].payloads)


@pytest.mark.parametrize("read", [read_bag, read_run, read_commands])
@pytest.mark.parametrize("name", ["two\nlines", "nul\0", "half \ud800"])
def test_what_names_no_bag_is_refused_in_one_line(
    tmp_path: Path, read: Callable[[str], object], name: str
) -> None:
    """A line break, a NUL, half a character: errors of our own, as for any bag that is missing."""
    with pytest.raises((BagError, RunError)) as refused:
        read(f"{tmp_path}/{name}")
    assert "\n" not in str(refused.value)
