# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Bags as arrays, and every way a bag can be no bag, told in words."""

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from rclpy.serialization import serialize_message
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Header

from rodless_lab.bags.metadata import METADATA_FILE, BagError, BagTopic, listed_messages
from rodless_lab.bags.reader import read_bag
from rodless_lab.bags.writer import BagWriter, recover_bag

JOINT_STATE = "sensor_msgs/msg/JointState"


def bag_of(path: Path, type_name: str, messages: list, times: list[int] | None = None) -> Path:
    """Write one topic, /x."""
    with BagWriter(path) as writer:
        writer.add_topic(BagTopic("/x", type_name))
        for k, message in enumerate(messages):
            log_time = k if times is None else times[k]
            writer.write("/x", serialize_message(message), log_time, log_time)
    return path


def test_messages_come_back_as_arrays(sample_bag) -> None:
    """Times, stamps and fields of each topic are arrays over its messages."""
    bag = read_bag(sample_bag.path)
    assert bag.topics == ["/joint_states", "/valve/voltage", "/silent"]
    assert bag.complete
    states, voltages = bag["/joint_states"], bag["/valve/voltage"]
    assert len(states) == 300
    np.testing.assert_allclose(states.time, 1e-3 * np.arange(300), rtol=1e-15)
    np.testing.assert_allclose(states.stamp, states.time, rtol=1e-15)
    assert states.fields.keys() == {"position", "velocity", "effort"}
    np.testing.assert_array_equal(states.fields["position"], 1e-6 * np.arange(300)[:, None])
    assert states.fields["effort"].shape == (300, 1)
    np.testing.assert_array_equal(voltages.fields["data"], 0.1 * np.arange(300))
    np.testing.assert_array_equal(voltages.publish_time, voltages.log_time + 3)
    assert bag["/silent"].fields == {}
    assert bag["/silent"].stamp.shape == (0,)


def test_a_topic_is_a_table(sample_bag, tmp_path: Path) -> None:
    """Its columns are times, stamps and numbers, a column for each joint, and CSV has them."""
    bag = read_bag(sample_bag.path)
    states = bag["/joint_states"]
    assert list(states.columns()) == ["time", "stamp", "position[0]", "velocity[0]", "effort[0]"]
    assert list(states.units().values()) == ["s", "s", "", "", ""]
    assert list(bag["/valve/voltage"].columns()) == ["time", "data"]
    states.save(tmp_path / "states.csv")
    written = np.loadtxt(tmp_path / "states.csv", delimiter=",", skiprows=2)
    np.testing.assert_array_equal(written[:, 2], 1e-6 * np.arange(300))
    assert len(bag["/silent"].to_dataframe()) == 0


def test_scalars_and_fixed_arrays_keep_their_kind(tmp_path: Path) -> None:
    """A pressure is a real number; texts and lists of messages are no data."""
    pressure = FluidPressure(header=Header(frame_id="a"), fluid_pressure=5e5, variance=2.0)
    fields = read_bag(bag_of(tmp_path / "p", "sensor_msgs/msg/FluidPressure", [pressure]))["/x"]
    assert {name: list(values) for name, values in fields.fields.items()} == {
        "fluid_pressure": [5e5],
        "variance": [2.0],
    }
    status = DiagnosticArray(status=[DiagnosticStatus(name="n")])
    read = read_bag(bag_of(tmp_path / "d", "diagnostic_msgs/msg/DiagnosticArray", [status]))
    assert read["/x"].fields == {}
    assert read["/x"].messages[0].status[0].name == "n"


def test_arrays_that_change_their_length_are_filled_up(tmp_path: Path) -> None:
    """A joint that vanishes for a sample leaves NaN, not a shifted column."""
    states = [JointState(position=[1.0, 2.0]), JointState(position=[3.0])]
    read = read_bag(bag_of(tmp_path / "bag", "sensor_msgs/msg/JointState", states))
    np.testing.assert_array_equal(read["/x"].fields["position"], [[1.0, 2.0], [3.0, np.nan]])


def test_time_that_goes_back_is_pointed_at(tmp_path: Path) -> None:
    """The first message after a reset of the plant is found."""
    states = [JointState()] * 5
    bag = bag_of(tmp_path / "bag", "sensor_msgs/msg/JointState", states, [0, 10, 20, 0, 10])
    assert read_bag(bag)["/x"].restarts() == [3]


def test_one_storage_file_is_read_by_itself(sample_bag) -> None:
    """The .mcap file alone is as good as its folder."""
    assert len(read_bag(sample_bag.path / "sample_0.mcap")["/valve/voltage"]) == 300


def test_a_bag_another_program_wrote_is_read(sample_bag, tmp_path: Path) -> None:
    """A bag of an independent writer gives the messages that were put into it."""
    store = get_typestore(Stores.ROS2_JAZZY)
    sent = sample_bag.messages["/joint_states"]
    with Writer(tmp_path / "other", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connection = writer.add_connection("/joint_states", JOINT_STATE, typestore=store)
        for log_time, data in sent:
            writer.write(connection, log_time, data)
    states = read_bag(tmp_path / "other")["/joint_states"]
    assert list(zip(states.log_time, states.payloads, strict=True)) == sent


@pytest.mark.parametrize(
    "options",
    [
        {"compression": CompressionType.ZSTD},
        {"compression": CompressionType.LZ4},
        {"use_chunking": False},
    ],
)
def test_every_layout_of_a_storage_file_is_read_and_recovered(
    sample_bag, tmp_path: Path, options: dict[str, object]
) -> None:
    """Compressed chunks, or none at all as rosbag2's preset for fast disks has it; also cut."""
    sent = sample_bag.messages["/joint_states"]
    path = tmp_path / "bag_0.mcap"
    with path.open("wb") as stream:
        writer = McapWriter(stream, chunk_size=5000, **options)
        writer.start("ros2")
        channel = writer.register_channel(
            "/joint_states", "cdr", writer.register_schema(JOINT_STATE, "ros2msg", b"")
        )
        for log_time, data in sent:
            writer.add_message(channel, log_time, data, log_time)
        writer.finish()
    assert list(read_bag(path)["/joint_states"].payloads) == [data for _, data in sent]
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 3])
    kept = read_bag(path, recover=True)["/joint_states"]
    assert 20 < len(kept) < 300
    recover_bag(tmp_path)
    with AnyReader([tmp_path]) as reader:
        read = [(log_time, bytes(data)) for _, log_time, data in reader.messages()]
    assert read == sent[: len(kept)]


def test_a_missing_topic_is_named_with_those_there_are(sample_bag) -> None:
    """Asking for a topic that was not recorded lists what was."""
    bag = read_bag(sample_bag.path)
    assert "/clock" not in bag
    with pytest.raises(BagError, match="/clock was not recorded; the bag holds /joint_states, /"):
        bag["/clock"]


def test_a_message_type_that_is_not_installed_is_named(tmp_path: Path) -> None:
    """A bag of somebody else's messages opens; only their fields cannot be had."""
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic(BagTopic("/x", "somebodys_msgs/msg/Thing"))
        writer.write("/x", bytes(12), 0, 0)
    recording = read_bag(tmp_path / "bag")["/x"]
    assert len(recording) == 1
    with pytest.raises(BagError, match="/x: its type somebodys_msgs/msg/Thing is not installed"):
        _ = recording.fields


def test_a_type_without_a_header_has_no_stamps(sample_bag) -> None:
    """Stamps of a plain number are refused in words."""
    with pytest.raises(BagError, match="/valve/voltage: std_msgs/msg/Float64 has no header"):
        _ = read_bag(sample_bag.path)["/valve/voltage"].stamp


def test_what_is_no_bag_is_refused_in_words(sample_bag, tmp_path: Path) -> None:
    """Nothing there, an empty folder, a missing file, a broken description: each is told apart."""
    with pytest.raises(BagError, match="nowhere: no such bag"):
        read_bag(tmp_path / "nowhere")
    (tmp_path / "empty").mkdir()
    with pytest.raises(BagError, match=r"empty: not a bag: neither metadata\.yaml nor"):
        read_bag(tmp_path / "empty")
    for name, content, said in (
        ("text", b"hello there", "text_0.mcap is not an MCAP file"),
        ("nothing", b"", "nothing_0.mcap is not an MCAP file, or cut within"),
    ):
        (tmp_path / name).mkdir()
        (tmp_path / name / f"{name}_0.mcap").write_bytes(content)
        with pytest.raises(BagError, match=said):
            read_bag(tmp_path / name)
    (tmp_path / "results" / "nothing").mkdir(parents=True)
    with pytest.raises(BagError, match=r"nor a storage file in it$"):
        read_bag(tmp_path / "results")
    for name in ("results/bag", "results/second/"):
        shutil.copytree(sample_bag.path, tmp_path / name)
    (tmp_path / "results/second" / METADATA_FILE).unlink()
    results = tmp_path / "results"
    with pytest.raises(BagError, match=f"in it; try {results}/bag or {results}/second$"):
        read_bag(results)
    description = sample_bag.path / "metadata.yaml"
    shutil.move(sample_bag.path / "sample_0.mcap", tmp_path)
    with pytest.raises(BagError, match=r"its file sample_0\.mcap is missing"):
        read_bag(sample_bag.path)
    for broken in ("rosbag2_bagfile_information: 5", "]", "\0", ""):
        description.write_text(broken)
        with pytest.raises(BagError, match=r"metadata.yaml: not the description of a rosbag2 bag"):
            read_bag(sample_bag.path)


@pytest.mark.parametrize("what", ["read_text", "iterdir"])
@pytest.mark.parametrize("use", [read_bag, recover_bag, listed_messages])
def test_a_bag_that_may_not_be_read_is_not_called_unwritable(
    sample_bag, monkeypatch: pytest.MonkeyPatch, what: str, use: Callable[[Path], object]
) -> None:
    """Its description or its folder: the path, and the system's own reason."""
    description = sample_bag.path / METADATA_FILE
    place = description
    if what == "iterdir":
        if use is listed_messages:
            return
        description.unlink()
        place = sample_bag.path

    def refuse(path: Path, *_: object, **__: object) -> str:
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, what, refuse)
    with pytest.raises(BagError) as refused:
        use(sample_bag.path)
    assert str(refused.value) == f"{place}: cannot be read: Permission denied"
