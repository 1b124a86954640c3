# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Bags: bytes of a good one changed, and messages that a sound file holds."""

import re
import shutil
from pathlib import Path

import rig_bag
from draw import Draw
from rclpy.serialization import serialize_message
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from std_msgs.msg import Float64MultiArray
from target import Change, Target

from rodless_lab import read_bag, read_commands, read_run
from rodless_lab.bags.metadata import METADATA_FILE, BagTopic
from rodless_lab.bags.writer import BagWriter, recover_bag
from rodless_lab.runs.measured_run import run_of_trace
from rodless_lab.view.playback import open_tape
from rodless_sim import RigParameters, simulate

TYPES = (
    "std_msgs/msg/Float64", "sensor_msgs/msg/JointState", "sensor_msgs/msg/FluidPressure",
    "rosgraph_msgs/msg/Clock", "std_msgs/msg/String", "no_such/msg/Type", "std_msgs/Float64",
    "../x", "", "std_msgs/msg/Float64Array", "os/path/join", "a/b/c/d",
)  # fmt: skip


# What may stand for a value in a description.
VALUES = (
    "!!bool x", "!!int ''", "!!float ''", "!!timestamp x", "!!binary x", "!!set {a, b}",
    "!!omap [a]", "2024-13-45", "1:1:1", "=", "<<", "{<<: {a: 1}}", "&a [*a]",
    "[&b [1, 1], *b, *b]", "*nothing",
    "0x" + "f" * 40, "9" * 40, ".inf", ".nan", "~", "true", "[]", "{}", "''", "'\\e[31m'", "|",
)  # fmt: skip

ARRAYS = "std_msgs/msg/Float64MultiArray"


def _in_sqlite(bag: Path, copy: Path) -> Path:
    """Write a bag once more, by another program, in the storage that has no checksums."""
    found, types = read_bag(bag), get_typestore(Stores.ROS2_JAZZY)
    with Writer(copy, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        for topic in found:
            messages = found[topic]
            connection = writer.add_connection(topic, messages.topic.type_name, typestore=types)
            for time, payload in zip(messages.log_time.tolist(), messages.payloads, strict=True):
                writer.write(connection, time, payload)
    return copy


def _array(length: int) -> bytes:
    return serialize_message(Float64MultiArray(data=[0.1] * length))


class BagFiles(Target):
    """A change is (a file, bytes that replace others there), or (a topic, what its messages are).

    The bytes of a file are changed as they lie; what a checksum would give away is changed before
    the file is written.
    """

    def __init__(self, folder: Path) -> None:
        """Write the good bag."""
        super().__init__(folder)
        run = simulate(RigParameters(), [6.0] * 40, 1e-3)
        self._good = rig_bag.write(folder / "good", run_of_trace(run, 6e5), setpoint=(0.0, 0.05))
        self._goods = {"mcap": self._good, "sqlite": _in_sqlite(self._good, folder / "sqlite")}
        self._files = {
            storage: {file.name: file.read_bytes() for file in sorted(good.iterdir())}
            for storage, good in self._goods.items()
        }
        self._topics = {
            topic: (
                found.topic.type_name,
                [rig_bag.payload(topic, k * 1e-3, 0.1) for k in range(9)],
            )
            for topic, found in ((t, read_bag(self._good)[t]) for t in read_bag(self._good).topics)
        }
        self._bag = folder / "bag"

    def draw(self, draw: Draw) -> list[Change]:
        """Return changes of the files, or of the messages."""
        recover = ("recover", draw.random() < 0.5)
        if draw.random() < 0.5:
            storage = draw.choice(list(self._goods))
            changes = (self._of_file(draw, storage) for _ in range(draw.choice((1, 1, 2, 4))))
            return [recover, ("storage", storage), *changes]
        return [recover, *(self._of_message(draw) for _ in range(draw.choice((1, 1, 2, 4))))]

    def _of_file(self, draw: Draw, storage: str) -> Change:
        name = draw.choice(list(self._files[storage]))
        content = self._files[storage][name]
        if name == METADATA_FILE and draw.random() < 0.5:
            return self._of_value(draw, content)
        at = draw.randrange(len(content) + 1)
        size = draw.choice((0, 1, 2, 8, 100, len(content)))
        new = draw.choice((b"", draw.text().encode("utf-8", "surrogatepass"), draw.randbytes(size)))
        return "file", name, at, size, new

    @staticmethod
    def _of_value(draw: Draw, content: bytes) -> Change:
        """Put another value behind one of the names in a description."""
        places = [found.span(1) for found in re.finditer(rb": (.*)", content)]
        at, end = draw.choice(places)
        return "file", METADATA_FILE, at, end - at, draw.choice(VALUES).encode()

    def _of_message(self, draw: Draw) -> Change:
        topic = draw.choice(list(self._topics))
        what = draw.randrange(5)
        if what == 4:
            return "arrays", topic, tuple(draw.randrange(4) for _ in range(9))
        if what == 0:
            return "type", topic, draw.choice(TYPES)
        if what == 1:
            # Names come out of DDS, or out of files, and both give texts alone.
            name = draw.text(list(self._topics)).encode("utf-8", "replace").decode("utf-8")
            return "name", topic, name
        number = draw.randrange(9)
        if what == 2:
            return "time", topic, number, draw.integer(0, 2**63 - 1)
        return "data", topic, number, draw.spoilt(self._topics[topic][1][number])

    def run(self, changes: list[Change]) -> object:
        """Read the bag in every way there is."""
        shutil.rmtree(self._bag, ignore_errors=True)
        if any(change[0] in ("type", "name", "time", "data", "arrays") for change in changes):
            self._write(changes)
        else:
            sqlite = ("storage", "sqlite") in changes
            shutil.copytree(self._goods["sqlite" if sqlite else "mcap"], self._bag)
        for _, name, at, size, new in (change for change in changes if change[0] == "file"):
            file = self._bag / name
            content = file.read_bytes()
            file.write_bytes(content[:at] + new + content[at + size :])
        # Without its description where that is as it was: reading that takes most of the time.
        described = any("metadata.yaml" in change for change in changes) or not changes
        (storage,) = (file for file in self._bag.iterdir() if file.name != METADATA_FILE)
        path = self._bag if described else storage
        bag = read_bag(path, recover=("recover", True) in changes)
        for topic in bag.topics:
            bag[topic].columns()
            bag[topic].units()
        read_commands(path)
        open_tape(path)
        found = read_run(path).columns()
        if bag.path.is_dir():
            recover_bag(path)
        return found

    def _write(self, changes: list[Change]) -> None:
        new = {(kind, *where): value for kind, *where, value in changes if where}
        with BagWriter(self._bag) as writer:
            for topic, good in self._topics.items():
                lengths = new.get(("arrays", topic))
                type_name, messages = (ARRAYS, list(map(_array, lengths))) if lengths else good
                name = new.get(("name", topic), topic)
                writer.add_topic(BagTopic(name, new.get(("type", topic), type_name)))
                for number, message in enumerate(messages):
                    time = new.get(("time", topic, number), number * 1_000_000)
                    writer.write(name, new.get(("data", topic, number), message), time, time)
