# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Bags whose recording ended badly: killed, cut, damaged, or out of disk."""

import contextlib
import errno
import os
import shutil
import struct
import subprocess
import sys
from collections.abc import Callable, Iterator
from io import BytesIO
from pathlib import Path

import pytest
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from rosbags.highlevel import AnyReader
from unmeasured import unmeasured

from rodless_lab.bags.mcap_file.index import MAGIC
from rodless_lab.bags.mcap_file.writer import McapWriter
from rodless_lab.bags.metadata import BagError, BagTopic
from rodless_lab.bags.reader import Bag, read_bag
from rodless_lab.bags.writer import BagWriter, recover_bag
from rodless_lab.cli import recover

# Writes samples of 1 kB until the disk is full, then closes, and prints what it was told.
FILL = """
import resource, sys
from rodless_lab.cli import recover
from rodless_lab.bags.metadata import BagError, BagTopic
from rodless_lab.bags.writer import BagWriter
limit = int(sys.argv[2])
if limit:
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
with BagWriter(sys.argv[1]) as writer:
    writer.add_topic(BagTopic("/x", "std_msgs/msg/Float64"))
    try:
        for k in range(100_000):
            writer.write("/x", k.to_bytes(1000, "little"), k, k)
            if k % 10 == 9:
                writer.flush()
    except BagError as error:
        print(k, error)
    try:
        writer.write("/x", bytes(12), 0, 0)
        print("written")
    except BagError as error:
        print("refused")
"""


def fill(bag: Path, limit: int = 0) -> tuple[int, str]:
    """Fill the disk; return the number of messages written and all that was printed."""
    done = subprocess.run(
        [sys.executable, "-c", FILL, str(bag), str(limit)],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return int(done.stdout.split()[0]), done.stdout


def payloads(bag: Bag) -> dict[str, list[bytes]]:
    return {topic: list(bag[topic].payloads) for topic in bag}


def cut(bag: Path, target: Path, size: int) -> Path:
    """Copy a bag as a kill would have left it after ``size`` bytes."""
    target.mkdir()
    content = (bag / "sample_0.mcap").read_bytes()
    (target / "sample_0.mcap").write_bytes(content[:size])
    return target


@pytest.mark.parametrize("limit", [20_000, 64_000, 200_000, 1_000_000])
def test_a_full_disk_leaves_a_bag_that_opens(tmp_path: Path, limit: int) -> None:
    """When the file can grow no further, the writer says so and ends the bag with what fits."""
    written, said = fill(tmp_path / "bag", limit)
    assert "bag: cannot be written any more: File too large" in said
    assert "refused" in said
    check_full(tmp_path / "bag", written)


def test_a_full_file_system_leaves_a_bag_that_opens(tmp_path: Path) -> None:
    """The same on a real file system without a free byte, where metadata.yaml needs room too."""
    with mounted(tmp_path / "small", "size=1m") as small:
        written, said = fill(small / "bag")
        assert "No space left on device" in said
        check_full(small / "bag", written)


@contextlib.contextmanager
def mounted(small: Path, options: str) -> Iterator[Path]:
    """Mount a small file system; skip the test where that is not allowed."""
    small.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(small)]
    if os.geteuid() != 0 or subprocess.run(mount, capture_output=True, check=False).returncode:
        pytest.skip("no right to mount a small file system")
    try:
        yield small
    finally:
        subprocess.run(["umount", str(small)], check=True)


def test_no_message_makes_room_for_a_file_that_cannot_be_made(tmp_path: Path) -> None:
    """A file system without a place for one more file, but with room: the messages stay."""
    # Three inodes: its root, the bag's folder and the file of the messages.
    with mounted(tmp_path / "small", "size=20m,nr_inodes=3") as small:
        failure = recorded(small / "bag").failure
        assert "metadata.yaml: cannot be written: No space left on device" in str(failure)
        assert len(read_bag(small / "bag", recover=True)["/x"].payloads) == 1000


def test_what_is_in_the_way_of_the_metadata_costs_no_message(tmp_path: Path) -> None:
    """A folder of its name, which no room helps: the line names it, and the bag can be ended."""
    bag = tmp_path / "bag"
    failure = recorded(bag, (bag / "metadata.yaml").mkdir).failure
    assert f"{bag}/metadata.yaml: cannot be written: Is a directory" in str(failure)
    assert f"`rodless recover {bag}` ends the bag" in str(failure)
    (bag / "metadata.yaml").rmdir()
    assert recover_bag(bag) == 1000


@pytest.mark.parametrize("moved", [False, True])
def test_a_bag_that_is_taken_away_is_no_success(tmp_path: Path, *, moved: bool) -> None:
    """Removed or moved while it is recorded: said at once, and no folder stands in its place."""
    bag, elsewhere = tmp_path / "bag", tmp_path / "elsewhere"
    writer = recorded(bag, lambda: bag.rename(elsewhere) if moved else shutil.rmtree(bag))
    assert f"{bag}: was removed or moved while it was recorded" in str(writer.failure)
    assert not bag.exists()
    with pytest.raises(BagError, match="was removed or moved"):
        writer.write("/x", bytes(12), 0, 0)
    if moved:
        assert recover_bag(elsewhere) == 1000


def recorded(bag: Path, midway: Callable[[], object] = lambda: None) -> BagWriter:
    """Write a thousand messages, ``midway`` something else; return the closed writer."""
    with BagWriter(bag) as writer:
        writer.add_topic(BagTopic("/x", "std_msgs/msg/Float64"))
        for k in range(1000):
            writer.write("/x", k.to_bytes(1000, "little"), k, k)
        midway()
        with contextlib.suppress(BagError):
            writer.flush()
    return writer


def check_full(bag: Path, written: int) -> None:
    """Check that the bag opens for two readers and lacks no more than its last few chunks."""
    read = read_bag(bag)
    numbers = [int.from_bytes(data, "little") for data in read["/x"].payloads]
    assert numbers == list(range(len(numbers)))
    assert written - 60 < len(numbers) <= written
    with AnyReader([bag]) as reader:
        assert sum(1 for _ in reader.messages()) == len(numbers)


def killed(sample_bag, bag: Path) -> bytes:
    """Put into ``bag`` what a kill in mid-chunk leaves; return its content."""
    whole = (sample_bag.path / "sample_0.mcap").read_bytes()
    found = heads(whole)
    begun = found[Opcode.CHUNK][0]
    content = whole[: found[Opcode.DATA_END][0]] + whole[begun : begun + 200]
    bag.mkdir()
    (bag / "sample_0.mcap").write_bytes(content)
    return content


def fill_up(small: Path) -> None:
    """Leave no byte free on a small file system; ``rest`` has what was."""
    with contextlib.suppress(OSError), (small / "rest").open("wb", buffering=0) as rest:
        while True:
            rest.write(bytes(4096))


@pytest.mark.parametrize("limit", [4096, 20_000])
def test_recovery_where_a_file_may_not_be_as_long_costs_no_message(
    sample_bag, tmp_path: Path, limit: int
) -> None:
    """Refused in words, the file as it was; without the limit all of it is there."""
    bag = tmp_path / "bag"
    content = killed(sample_bag, bag)
    code = (
        "import resource, sys; from rodless_lab.cli import recover; "
        f"resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, {limit})); "
        "sys.exit(recover.main(sys.argv[1:], None))"
    )
    # Unmeasured: what coverage writes at the end would not fit under the limit either.
    done = subprocess.run(
        [sys.executable, "-c", code, str(bag)],
        env=unmeasured(),
        capture_output=True,
        text=True,
        check=False,
    )
    said = f"{bag}: cannot be written: File too large; no message is lost; where that is mended, "
    assert (done.returncode, done.stdout) == (2, ""), done.stderr
    assert done.stderr == f"{said}try again\n"
    assert contents(bag) == {"sample_0.mcap": content}
    assert recover_bag(bag) == 600


def test_recovery_on_a_full_file_system_costs_no_message(sample_bag, tmp_path: Path) -> None:
    """The same where no byte is free, up to what had been cut off."""
    with mounted(tmp_path / "small", "size=400k") as small:
        content = killed(sample_bag, small / "bag")
        fill_up(small)
        with pytest.raises(BagError, match="No space left on device; no message is lost"):
            recover_bag(small / "bag")
        assert contents(small / "bag") == {"sample_0.mcap": content}
        (small / "rest").unlink()
        assert recover_bag(small / "bag") == 600


def test_messages_that_make_room_for_the_end_of_a_recording_are_told(tmp_path: Path) -> None:
    """All were written before the disk was full: how many of them were given up for the end."""
    with mounted(tmp_path / "small", "size=400k") as small:
        with BagWriter(small / "bag") as writer:
            writer.add_topic(BagTopic("/x", "std_msgs/msg/Float64"))
            for k in range(100):
                writer.write("/x", k.to_bytes(1000, "little"), k, k)
            writer.flush()
            fill_up(small)
        left = len(read_bag(small / "bag")["/x"].payloads)
        assert left < 100
        assert f"the last {100 - left} messages were given up" in str(writer.failure)


def test_a_long_recording_finds_room_for_its_end_in_few_tries(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The end of one of a day is long: to drop a tenth of a second a try would take hours."""
    tries: list[int] = []
    finish = McapWriter.finish

    def on_a_full_disk(self: McapWriter, name: str, text: dict[str, str]) -> None:
        tries.append(len(self.index.stretches))
        if len(self.index.stretches) > 200:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(tmp_path))
        finish(self, name, text)

    monkeypatch.setattr(McapWriter, "finish", on_a_full_disk)
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic(BagTopic("/x", "std_msgs/msg/Float64"))
        for k in range(300):
            writer.write("/x", bytes(12), k, k)
            writer.flush()
    left = tries[-1]
    assert 100 <= left <= 200
    assert len(tries) < 10
    assert f"the last {300 - left} messages were given up" in str(writer.failure)
    assert len(read_bag(tmp_path / "bag")["/x"].payloads) == left


def test_a_disk_full_from_the_start_is_told_apart(tmp_path: Path) -> None:
    """Where not even an empty bag fits, that is said, without a traceback."""
    said = r"BagError: .*bag: cannot be written: File too large"
    with pytest.raises(AssertionError, match=said):
        fill(tmp_path / "bag", 100)


@pytest.mark.slow
def test_a_bag_cut_anywhere_can_be_recovered(sample_bag, tmp_path: Path) -> None:
    """Wherever a kill cuts the file, all whole chunks before are read, and ended in place."""
    whole = payloads(read_bag(sample_bag.path))
    size = (sample_bag.path / "sample_0.mcap").stat().st_size
    most = 0
    for k, end in enumerate(range(size, 0, -size // 37)):
        bag = cut(sample_bag.path, tmp_path / str(k), end)
        if end < 8:
            with pytest.raises(BagError, match="is not an MCAP file, or cut within"):
                recover_bag(bag)
            continue
        read = read_bag(bag, recover=True)
        found = payloads(read)
        assert all(found[topic] == whole[topic][: len(found[topic])] for topic in found)
        count = sum(map(len, found.values()))
        most = max(most, count)
        if read.complete:
            assert end == size
        else:
            rest = f"; {count} messages can be" if count else "$"
            with pytest.raises(BagError, match=f"was never closed .* was killed{rest}"):
                read_bag(bag)
        assert recover_bag(bag) == count
        recovered = read_bag(bag)
        assert recovered.complete
        assert payloads(recovered) == found
        with AnyReader([bag]) as reader:
            assert sum(1 for _ in reader.messages()) == count
    assert most == 600


def test_recovering_a_bag_twice_changes_nothing(sample_bag, tmp_path: Path) -> None:
    """A closed or recovered bag passes through recovery untouched."""
    bag = cut(sample_bag.path, tmp_path / "cut", 30_000)
    recover_bag(bag)
    before = {file.name: file.read_bytes() for file in bag.iterdir()}
    recover_bag(bag)
    assert {file.name: file.read_bytes() for file in bag.iterdir()} == before


def test_a_bag_of_several_files_is_recovered_as_one(sample_bag, tmp_path: Path) -> None:
    """When one of several files was cut, the description names them all again."""
    bag = cut(sample_bag.path, tmp_path / "several", 30_000)
    shutil.copy(sample_bag.path / "sample_0.mcap", bag / "sample_1.mcap")
    count = recover_bag(bag)
    assert 600 < count < 1200
    with AnyReader([bag]) as reader:
        assert sum(1 for _ in reader.messages()) == count


def two_files(sample_bag, tmp_path: Path) -> tuple[Path, Path]:
    """Return a bag of two files with a description of both, and the second file."""
    bag = tmp_path / "two"
    shutil.copytree(sample_bag.path, bag)
    second = shutil.copy(bag / "sample_0.mcap", bag / "sample_1.mcap")
    (bag / "metadata.yaml").unlink()
    assert recover_bag(bag) == 1200
    return bag, second


def contents(bag: Path) -> dict[str, bytes]:
    """What is in the folder."""
    return {file.name: file.read_bytes() for file in bag.iterdir()}


def test_of_several_files_the_one_that_is_cut_is_named(sample_bag, tmp_path: Path) -> None:
    """And the way to the rest leads there: recovery ends that one."""
    bag, second = two_files(sample_bag, tmp_path)
    second.write_bytes(second.read_bytes()[:30_000])
    said = r"two: sample_1\.mcap is cut off, .* messages can be recovered \(rodless recover\)$"
    with pytest.raises(BagError, match=said):
        read_bag(bag)
    assert 600 < recover_bag(bag) < 1200
    assert read_bag(bag).complete


@pytest.mark.parametrize("content", [b"", b"\0"])
def test_the_way_to_what_lies_beside_damage_leads_there(
    sample_bag, tmp_path: Path, content: bytes
) -> None:
    """An empty file, or one with a bad byte: recovery, which would cost what it has, is not it."""
    bag, second = two_files(sample_bag, tmp_path)
    half = second.read_bytes()[:30_000]
    second.write_bytes(content and half + content + half)
    before = contents(bag)
    with pytest.raises(BagError, match=r"sample_1\.mcap is .*; \d+ messages can be") as refused:
        read_bag(bag)
    assert str(refused.value).endswith("(read_bag(..., recover=True))")
    with pytest.raises(
        BagError, match=r"nothing is changed; read_bag\(\.\.\., recover=True\) reads"
    ):
        recover_bag(bag)
    assert contents(bag) == before
    rest = sum(map(len, payloads(read_bag(bag, recover=True)).values()))
    assert f"; {rest} messages can be recovered" in str(refused.value)
    assert rest >= 600


def test_the_way_to_a_file_or_past_a_link_leads_there(sample_bag, tmp_path: Path) -> None:
    """What recovery does not take, one file or one that leads out of its bag, is read as it is."""
    elsewhere = cut(sample_bag.path, tmp_path / "cut", 30_000) / "sample_0.mcap"
    (tmp_path / "link").mkdir()
    (tmp_path / "link" / "sample_0.mcap").symlink_to(elsewhere)
    for bag in (elsewhere, tmp_path / "link"):
        with pytest.raises(BagError, match=r"recovered \(read_bag\(\.\.\., recover=True\)\)$"):
            read_bag(bag)
        with pytest.raises(BagError, match=r"not the folder of a bag|leads out of the bag"):
            recover_bag(bag)


def test_a_closed_bag_with_other_messages_is_no_success(
    sample_bag, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """With a file of another bag recovery says what readers say, and leaves all as it is."""
    bag, second = two_files(sample_bag, tmp_path)
    recorded(tmp_path / "other")
    shutil.copy(tmp_path / "other" / "other_0.mcap", second)
    before = contents(bag)
    with pytest.raises(BagError, match=r"metadata.yaml says .*, then rodless recover") as refused:
        read_bag(bag)
    assert recover.main([str(bag)], None) == 2
    assert capsys.readouterr() == ("", f"{refused.value}\n")
    assert contents(bag) == before
    (bag / "metadata.yaml").unlink()
    assert recover.main([str(bag)], None) == 0
    assert read_bag(bag).complete


@pytest.mark.parametrize("attempt", [recover_bag, read_bag])
def test_a_file_that_is_listed_twice_is_named(
    sample_bag, tmp_path: Path, attempt: Callable[[Path], object]
) -> None:
    """Its messages would count twice; as the line says, without the description they do not."""
    bag, second = two_files(sample_bag, tmp_path)
    description = bag / "metadata.yaml"
    description.write_text(description.read_text().replace("- sample_0.mcap", "- sample_1.mcap"))
    before = contents(bag)
    said = f"{bag}: metadata.yaml lists {second.name} twice; remove metadata.yaml, and all files in"
    with pytest.raises(BagError, match=said):
        attempt(bag)
    assert contents(bag) == before
    description.unlink()
    attempt(bag)
    assert sum(map(len, payloads(read_bag(bag)).values())) == 1200


@pytest.mark.parametrize("attempt", [recover_bag, read_bag])
@pytest.mark.parametrize("link", [Path.symlink_to, Path.hardlink_to])
def test_a_link_to_another_file_of_the_bag_is_named(
    sample_bag,
    tmp_path: Path,
    attempt: Callable[[Path], object],
    link: Callable[[Path, Path], None],
) -> None:
    """As a file that is listed twice; the way out leads out."""
    bag, second = two_files(sample_bag, tmp_path)
    second.unlink()
    link(second, bag / "sample_0.mcap")
    said = "sample_0.mcap and sample_1.mcap are the same file; remove sample_1.mcap, and metadata"
    with pytest.raises(BagError, match=said):
        attempt(bag)
    second.unlink()
    (bag / "metadata.yaml").unlink()
    attempt(bag)


def test_a_stray_file_with_a_digit_that_is_no_number_is_left_out(sample_bag) -> None:
    """A small 2 is a digit to Python: a file of another name is told, and the bag is read."""
    shutil.copy(sample_bag.path / "sample_0.mcap", sample_bag.path / "a_\u00b2.mcap")
    bag = read_bag(sample_bag.path)
    assert bag.complete
    (note,) = bag.notes
    assert "a_\u00b2.mcap left out" in note


def test_the_command_says_what_it_saved_or_why_not(
    sample_bag, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """`rodless recover` tells the number of messages, or the fault with exit code 2."""
    bag = cut(sample_bag.path, tmp_path / "cut", 30_000)
    assert recover.main([str(bag)], None) == 0
    count = sum(map(len, payloads(read_bag(bag)).values()))
    assert capsys.readouterr().out == f"{count} messages in {bag}\n"
    assert recover.main([str(tmp_path / "nothing")], None) == 2
    assert capsys.readouterr().err == f"{tmp_path / 'nothing'}: not the folder of a bag\n"


def test_a_bag_cut_after_it_was_closed_says_how_much_is_gone(
    sample_bag, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its description still knows how many messages there were."""
    description = (sample_bag.path / "metadata.yaml").read_text(encoding="utf-8")
    bag = cut(sample_bag.path, tmp_path / "cut", 30_000)
    name = next(bag.glob("*.mcap")).name
    (bag / "metadata.yaml").write_text(description.replace("sample_0.mcap", name))
    assert recover.main([str(bag)], None) == 0
    count = sum(map(len, payloads(read_bag(bag)).values()))
    assert 0 < count < 600
    assert capsys.readouterr().out == f"{count} messages in {bag}, of 600 once recorded\n"
    assert recover.main([str(bag)], None) == 0
    assert capsys.readouterr().out == f"{count} messages in {bag}\n"


def test_losing_only_the_description_is_recovered(sample_bag) -> None:
    """A bag that lacks nothing but metadata.yaml opens, and recovery writes the same again."""
    description = sample_bag.path / "metadata.yaml"
    before = description.read_text()
    description.unlink()
    assert len(read_bag(sample_bag.path)["/joint_states"]) == 300
    recover_bag(sample_bag.path)
    assert description.read_text() == before


def test_damage_is_found_and_named(sample_bag, tmp_path: Path) -> None:
    """A flipped bit in a message is not read as a value: the place is named, recovery refused."""
    bag = tmp_path / "bag"
    shutil.copytree(sample_bag.path, bag)
    file = bag / "sample_0.mcap"
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 0x10
    file.write_bytes(content)
    with pytest.raises(BagError, match=r"sample_0.mcap is damaged at byte \d+"):
        read_bag(bag)
    with pytest.raises(BagError, match=r"sample_0.mcap: is damaged at byte \d+"):
        recover_bag(bag)
    assert file.read_bytes() == content
    rest = read_bag(bag, recover=True)
    assert not rest.complete
    assert 0 < len(rest["/joint_states"]) < 300


@pytest.mark.parametrize("described", [True, False])
def test_a_length_that_leads_out_of_a_closed_file_is_no_cut_end(
    sample_bag, tmp_path: Path, described: bool
) -> None:
    """What stands behind it is whole: recovery would cost that, and says so instead."""
    bag = tmp_path / "bag"
    shutil.copytree(sample_bag.path, bag)
    if not described:
        (bag / "metadata.yaml").unlink()
    file = bag / "sample_0.mcap"
    content = bytearray(file.read_bytes())
    chunks = heads(content)[Opcode.CHUNK]
    content[chunks[1] + 5] ^= 0x40
    file.write_bytes(content)
    said = f"is damaged at byte {chunks[1]}: a record of no possible length"
    with pytest.raises(BagError, match=f"sample_0.mcap {said}"):
        read_bag(bag)
    with pytest.raises(BagError, match=f"sample_0.mcap: {said}; nothing is changed; "):
        recover_bag(bag)
    assert file.read_bytes() == content
    assert 0 < len(read_bag(bag, recover=True)["/joint_states"]) < 300


def by_another(count: int, **options: object) -> bytearray:
    """Return a file of so many messages on ``/x`` as the mcap library writes it."""
    file = BytesIO()
    writer = Writer(file, **options)
    writer.start("ros2")
    schema = writer.register_schema("std_msgs/msg/Float64", "ros2msg", b"float64 data")
    channel = writer.register_channel("/x", "cdr", schema)
    for k in range(count):
        writer.add_message(channel, k, bytes(12), k)
    writer.finish()
    return bytearray(file.getvalue())


def heads(content: bytes) -> dict[int, list[int]]:
    """Where the records of each kind begin."""
    found: dict[int, list[int]] = {}
    place = len(MAGIC)
    while place < len(content) - len(MAGIC):
        opcode, length = struct.unpack_from("<BQ", content, place)
        found.setdefault(opcode, []).append(place)
        place += struct.calcsize("<BQ") + length
    return found


@pytest.mark.parametrize("closed", [True, False])
def test_a_flipped_bit_in_the_head_of_a_record_costs_no_message_in_silence(
    sample_bag, tmp_path: Path, *, closed: bool
) -> None:
    """A kind or length that is wrong may lead past others, out of the file or to nowhere.

    What stands behind it is neither left out nor taken for a cut end. The description is lost, too.
    """
    whole = payloads(read_bag(sample_bag.path))
    content = (sample_bag.path / "sample_0.mcap").read_bytes()
    records = heads(content)
    if not closed:
        content = content[: records[Opcode.DATA_END][0]]
    bag = tmp_path / "bag"
    refused = 0
    for kind in (Opcode.CHUNK, Opcode.MESSAGE_INDEX, Opcode.METADATA):
        begin = records[kind][len(records[kind]) // 2]
        for bit in range(8 * struct.calcsize("<BQ")):
            damaged = bytearray(content)
            damaged[begin + bit // 8] ^= 1 << bit % 8
            shutil.rmtree(bag, ignore_errors=True)
            bag.mkdir()
            (bag / "sample_0.mcap").write_bytes(damaged)
            try:
                recover_bag(bag)
                assert payloads(read_bag(bag)) == whole, (kind, bit, begin, len(content))
            except BagError:
                refused += 1
                assert (bag / "sample_0.mcap").read_bytes() == damaged
    assert refused > 100


def test_a_killed_recording_of_uncompressed_chunks_can_be_recovered(tmp_path: Path) -> None:
    """Whole messages stand behind where it is cut: they are within the chunk that was begun."""
    content = by_another(100, chunk_size=1000, compression=CompressionType.NONE)
    found = heads(content)
    begun = found[Opcode.CHUNK][-2]
    bag = tmp_path / "bag"
    bag.mkdir()
    (bag / "bag_0.mcap").write_bytes(content[: begun + 800])
    # An entry of 16 bytes for each message.
    sizes = [
        struct.unpack_from("<HI", content, place + struct.calcsize("<BQ"))[1]
        for place in found[Opcode.MESSAGE_INDEX]
        if place < begun
    ]
    assert recover_bag(bag) == sum(sizes) // 16 > 0


def test_the_last_chunk_is_not_cut_where_its_indices_stand(sample_bag, tmp_path: Path) -> None:
    """A killed recording, and a flipped bit in the length of the chunk that it ended with."""
    content = bytearray((sample_bag.path / "sample_0.mcap").read_bytes())
    found = heads(content)
    del content[found[Opcode.DATA_END][0] :]
    content[found[Opcode.CHUNK][-1] + 5] ^= 0x40
    (tmp_path / "sample_0.mcap").write_bytes(content)
    with pytest.raises(BagError, match="a record of no possible length, with a whole one behind"):
        recover_bag(tmp_path)
    assert (tmp_path / "sample_0.mcap").read_bytes() == content


@pytest.mark.parametrize(
    ("kind", "damaged", "place", "bit"),
    [
        (Opcode.HEADER, 0, 4, 1),
        (Opcode.SCHEMA, 0, 4, 1),
        (Opcode.CHANNEL, 0, 4, 1),
        (Opcode.MESSAGE, 5, 4, 1),
        (Opcode.MESSAGE, -2, 4, 1),
        (Opcode.MESSAGE, 0, 0, 0x80),
        (Opcode.MESSAGE, 5, 0, 0x80),
        (Opcode.MESSAGE, 5, 0, 0x10),
    ],
)
def test_damage_to_a_bag_without_chunks_is_no_cut_end(
    tmp_path: Path, kind: Opcode, damaged: int, place: int, bit: int
) -> None:
    """Whole messages behind a record of no possible length tell, and one of an unknown kind."""
    content = by_another(20, use_chunking=False)
    found = heads(content)
    del content[found[Opcode.DATA_END][0] :]
    content[found[kind][damaged] + place] ^= bit
    (tmp_path / "bag_0.mcap").write_bytes(content)
    said = "of no possible length, with a whole one behind" if place else "calls itself a record"
    with pytest.raises(BagError, match=said):
        recover_bag(tmp_path)
    assert (tmp_path / "bag_0.mcap").read_bytes() == content


@pytest.mark.parametrize("compression", list(CompressionType))
def test_a_flipped_bit_in_what_a_chunk_says_of_its_length_is_damage(
    tmp_path: Path, compression: CompressionType
) -> None:
    """Recovery would pass it on in a bag that no other reader opens."""
    content = by_another(20, compression=compression)
    (chunk,) = heads(content)[Opcode.CHUNK]
    name = {CompressionType.NONE: "", CompressionType.LZ4: "lz4", CompressionType.ZSTD: "zstd"}
    length = chunk + struct.calcsize("<BQQQQII") + len(name[compression])
    for bit in range(64):
        damaged = bytearray(content)
        damaged[length + bit // 8] ^= 1 << bit % 8
        (tmp_path / "bag_0.mcap").write_bytes(damaged)
        with pytest.raises(BagError, match=f"damaged at byte {chunk}"):
            recover_bag(tmp_path)


def test_a_flipped_bit_in_a_chunk_without_checksum_costs_no_message_in_silence(
    tmp_path: Path,
) -> None:
    """In the heads of the records within it: they are of few kinds and fill their chunk."""
    content = by_another(20, compression=CompressionType.NONE, enable_crcs=False)
    (chunk,) = heads(content)[Opcode.CHUNK]
    message = content.index(struct.pack("<BQ", Opcode.MESSAGE, 22 + 12), chunk)
    for bit in range(8 * struct.calcsize("<BQ")):
        damaged = bytearray(content)
        damaged[message + bit // 8] ^= 1 << bit % 8
        (tmp_path / "bag_0.mcap").write_bytes(damaged)
        with pytest.raises(BagError, match=r"damaged at|statistics"):
            recover_bag(tmp_path)
        del damaged[heads(damaged)[Opcode.DATA_END][0] :]
        (tmp_path / "bag_0.mcap").write_bytes(damaged)
        with pytest.raises(BagError, match=f"damaged at byte {chunk}"):
            recover_bag(tmp_path)
        assert (tmp_path / "bag_0.mcap").read_bytes() == damaged


def test_what_looks_like_many_records_is_searched_without_copies(tmp_path: Path) -> None:
    """The cut end is full of heads of messages that overlap: copied, they would be 300 GB."""
    looks = struct.pack("<BQ", Opcode.MESSAGE, 2**20) * 330_000
    cut_off = struct.pack("<BQ", Opcode.ATTACHMENT, 2**40) + looks
    content = by_another(20)
    end = heads(content)[Opcode.DATA_END][0]
    (tmp_path / "bag_0.mcap").write_bytes(content[:end] + cut_off)
    assert recover_bag(tmp_path) == 20


def test_one_message_before_the_cut_end_is_found(tmp_path: Path) -> None:
    """Behind a damaged length stands one that is whole, and half of another."""
    content = by_another(20, use_chunking=False)
    found = heads(content)
    del content[found[Opcode.DATA_END][0] - 5 :]
    content[found[Opcode.MESSAGE][-3] + 4] ^= 1
    (tmp_path / "bag_0.mcap").write_bytes(content)
    with pytest.raises(BagError, match="of no possible length, with a whole one behind"):
        recover_bag(tmp_path)


def has_its_summary_made_anew(file: Path) -> bool:
    """Recover a damaged bag of 20 messages; not one whose number of messages is another.

    All messages stand before the summary, and the mcap library reads them from the recovered file.
    """
    with pytest.raises(BagError) as refused:
        read_bag(file.parent)
    if "holds 20 messages, its statistics" in str(refused.value):
        return False
    assert "has a damaged summary behind its messages; 20 messages can be" in str(refused.value)
    assert recover_bag(file.parent) == 20
    assert read_bag(file.parent).complete
    with file.open("rb") as opened:
        assert sum(1 for _ in make_reader(opened).iter_messages()) == 20
    return True


def test_a_damaged_summary_is_told_and_made_anew(tmp_path: Path) -> None:
    """Whichever byte is changed, but for the number of messages: another may be right."""
    content = by_another(20)
    found = heads(content)
    file = tmp_path / "bag_0.mcap"
    (behind,) = found[Opcode.DATA_END]
    summary = behind + struct.calcsize("<BQI")
    recovered = 0
    for place in range(summary, len(content) - len(MAGIC), 7):
        damaged = bytearray(content)
        damaged[place] ^= 0x10
        (tmp_path / "metadata.yaml").unlink(missing_ok=True)
        file.write_bytes(damaged)
        recovered += has_its_summary_made_anew(file)
    assert recovered > 30


def test_a_summary_without_a_checksum_is_made_anew_where_bytes_of_it_are_gone(
    tmp_path: Path,
) -> None:
    """Other readers go by the lengths in it: recovery had said that all was well, and left it."""
    content = by_another(20, enable_crcs=False)
    file = tmp_path / "bag_0.mcap"
    file.write_bytes(content)
    assert read_bag(tmp_path).complete
    (behind,) = heads(content)[Opcode.DATA_END]
    (footer,) = heads(content)[Opcode.FOOTER]
    recovered = 0
    for place in range(behind + struct.calcsize("<BQI"), footer - 16, 16):
        (tmp_path / "metadata.yaml").unlink(missing_ok=True)
        file.write_bytes(content[:place] + content[place + 16 :])
        recovered += has_its_summary_made_anew(file)
    assert recovered > 10


def test_a_closed_file_without_an_end_of_its_data_is_damaged(tmp_path: Path) -> None:
    """Each length in it is right, and nothing is cut off."""
    (tmp_path / "bag_0.mcap").write_bytes(MAGIC + MAGIC)
    with pytest.raises(BagError, match="damaged at byte 8: it lacks the end of its data"):
        read_bag(tmp_path)


def test_a_message_of_no_channel_is_damage(tmp_path: Path) -> None:
    """Recovery counts messages by channel: one that the file does not declare is named."""
    bag = tmp_path / "bag"
    bag.mkdir()
    loose = struct.pack("<BQHIQQ", 5, 22 + 12, 26888, 0, 1, 1) + bytes(12)
    (bag / "bag_0.mcap").write_bytes(MAGIC + loose)
    with pytest.raises(BagError, match=r"holds a message of the unknown channel 26888; nothing"):
        recover_bag(bag)


@pytest.mark.slow
def test_no_damage_gives_anything_but_a_bag_error(sample_bag, tmp_path: Path) -> None:
    """Whatever byte is wrong, the user reads a sentence, or the messages are right."""
    bag = tmp_path / "bag"
    shutil.copytree(sample_bag.path, bag)
    file = bag / "sample_0.mcap"
    content = file.read_bytes()
    whole = payloads(read_bag(bag))
    for place in range(0, len(content), 331):
        damaged = bytearray(content)
        damaged[place] ^= 0xFF
        file.write_bytes(damaged)
        with contextlib.suppress(BagError):
            found = payloads(read_bag(bag))
            assert found.keys() <= whole.keys()
            assert all(set(found[topic]) <= set(whole[topic]) for topic in found)
