# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The recorder over real DDS: every message, byte for byte, however the recording ends."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path

import pytest
from builtin_interfaces.msg import Time
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import serialize_message
from rosbags.highlevel import AnyReader
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64, Header, String

from rodless_lab.bags import clock as bag_clock
from rodless_lab.bags.reader import Bag, read_bag
from rodless_lab.bags.ros.clock_watch import MANY_STEPS
from rodless_lab.bags.ros.recorder import MANY_TURNS, Recorder
from rodless_lab.bags.writer import BagWriter, recover_bag

pytestmark = pytest.mark.usefixtures("hears_hangup")

# For whatever must come, so that a test fails instead of hanging, in wall-clock seconds.
TIMEOUT = 60.0

# Ctrl-C promises 2 s on a machine that has nothing else to do.
STOP_SECONDS = 5.0

RECORD = "from rodless_lab.cli.main import main; main()"

# Deep enough for all that a test sends at once: a publisher forgets what is older, heard or not.
RELIABLE = QoSProfile(depth=10_000)


def stamp(k: int) -> Time:
    """Plant time of sample ``k`` at 1 kHz."""
    return Time(sec=k // 1000, nanosec=k % 1000 * 1_000_000)


def sample(k: int) -> JointState:
    header = Header(stamp=stamp(k))
    return JointState(
        header=header, name=["carriage"], position=[1e-3 * k], velocity=[0.0], effort=[-1.0]
    )


class Plant:
    """A known publisher of clock, samples and voltages, in a context of its own."""

    def __init__(self, domain: Mapping[str, str]) -> None:
        self.context = Context()
        self.context.init(args=[], domain_id=int(domain["ROS_DOMAIN_ID"]))
        self.node = Node("plant", context=self.context, use_global_arguments=False)
        self.clock = self.publisher(Clock, "/clock")
        self.states = self.publisher(JointState, "joint_states")
        self.voltage = self.publisher(Float64, "valve/voltage")
        self.sent = 0

    def publisher(self, kind: type, topic: str, qos: QoSProfile = RELIABLE) -> Publisher:
        """Offer one more topic."""
        return self.node.create_publisher(kind, topic, qos)

    def close(self) -> None:
        """Leave the domain."""
        self.node.destroy_node()
        self.context.try_shutdown()

    def until_heard(self) -> None:
        """Wait until each of the three topics has a subscriber."""
        self.until_heard_by(self.clock, self.states, self.voltage)

    def until_heard_by(self, *publishers: Publisher) -> None:
        """Wait until each of them has a subscriber."""
        self.until(lambda: all(p.get_subscription_count() for p in publishers))

    def until(self, condition: Callable[[], bool]) -> None:
        """Wait until ``condition`` holds."""
        # The graph is rclpy's own business in other threads; there is nothing to spin for.
        deadline = time.monotonic() + TIMEOUT
        turn = threading.Event()
        while not condition():
            assert time.monotonic() < deadline, "waited in vain"
            turn.wait(0.01)

    def send(self, count: int) -> None:
        """Publish clock, sample and voltage of the next ``count`` instants."""
        for k in range(self.sent, self.sent + count):
            self.clock.publish(Clock(clock=stamp(k)))
            self.states.publish(sample(k))
            self.voltage.publish(Float64(data=float(k)))
        self.sent += count

    def delivered(self) -> bool:
        """Whether reliable subscribers have got everything sent so far."""
        timeout = Duration(seconds=TIMEOUT)
        return all(p.wait_for_all_acked(timeout) for p in (self.clock, self.states, self.voltage))


@pytest.fixture
def plant(domain: dict[str, str]) -> Iterator[Plant]:
    plant = Plant(domain)
    yield plant
    plant.close()


class RecorderProcess:
    """``rodless record`` as a process."""

    def __init__(
        self, domain: Mapping[str, str], arguments: list[str], file_limit: int | None = None
    ) -> None:
        limit = [] if file_limit is None else ["prlimit", f"--fsize={file_limit}"]
        self.process = subprocess.Popen(
            [*limit, sys.executable, "-c", RECORD, "record", *arguments],
            env=dict(domain),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        self.output = ""
        self._said = threading.Condition()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def __enter__(self) -> "RecorderProcess":
        return self

    def __exit__(self, *_: object) -> None:
        self.process.kill()
        self.process.wait()
        self._reader.join(TIMEOUT)

    def _read(self) -> None:
        for line in self.process.stdout:
            with self._said:
                self.output += line
                self._said.notify_all()

    def until_it_says(self, text: str) -> None:
        """Wait until its output holds ``text``."""
        with self._said:
            assert self._said.wait_for(lambda: text in self.output, TIMEOUT), self.output

    def end(self, number: int | None = None, timeout: float = TIMEOUT) -> int:
        """Send a signal, if any; return the exit code and have all output."""
        if number is not None:
            self.process.send_signal(number)
        code = self.process.wait(timeout)
        self._reader.join(TIMEOUT)
        return code


TOPICS = ["joint_states", "valve/voltage", "/clock"]


def check_complete(bag: Path, count: int) -> None:
    """Check that the bag holds every message of ``Plant.send``, in plant time."""
    read = read_bag(bag)
    assert {topic: len(read[topic]) for topic in read} == {
        "/clock": count,
        "/joint_states": count,
        "/valve/voltage": count,
    }
    states, voltages = read["/joint_states"], read["/valve/voltage"]
    plant_time = [1_000_000 * k for k in range(count)]
    assert list(states.log_time) == plant_time
    assert list(voltages.log_time) == plant_time
    assert list(read["/clock"].log_time) == plant_time
    assert states.messages == [sample(k) for k in range(count)]
    assert list(voltages.payloads) == [
        serialize_message(Float64(data=float(k))) for k in range(count)
    ]
    with AnyReader([bag]) as reader:
        assert sum(1 for _ in reader.messages()) == 3 * count


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_stopped_recorder_leaves_a_whole_bag(
    domain: dict[str, str], plant: Plant, tmp_path: Path, number: int
) -> None:
    """Ctrl-C, SIGTERM, a closed terminal: exit code 0 soon, no message missing or changed."""
    bag = tmp_path / "bag"
    with RecorderProcess(domain, ["-o", str(bag), *TOPICS]) as recorder:
        recorder.until_it_says("recording ")
        plant.until_heard()
        plant.send(2000)
        assert plant.delivered()
        assert recorder.end(number, STOP_SECONDS) == 0, recorder.output
    assert f"{bag}: waiting for {', '.join(TOPICS)}, until Ctrl-C\n" in recorder.output
    assert "6000 messages in" in recorder.output
    assert "Traceback" not in recorder.output
    assert "lost" not in recorder.output
    check_complete(bag, 2000)


def test_how_much_there_is_stands_before_what_is_missing(
    domain: dict[str, str], plant: Plant, tmp_path: Path
) -> None:
    """In one file, where the view reads its last words, as on a terminal."""
    with RecorderProcess(domain, ["-o", str(tmp_path / "bag"), *TOPICS, "/nobody"]) as recorder:
        plant.until_heard()
        recorder.end(signal.SIGINT, STOP_SECONDS)
    count, missing = recorder.output.splitlines()[-2:]
    assert " messages in " in count
    assert missing == "/nobody: nobody published it"


def test_a_recorder_whose_output_nobody_reads_records_on(
    domain: dict[str, str], plant: Plant, tmp_path: Path
) -> None:
    """Standard output is closed before its first line, as by `| true`; the bag is whole."""
    bag = tmp_path / "bag"
    reader, writer = os.pipe()
    os.close(reader)
    with subprocess.Popen(
        [sys.executable, "-c", RECORD, "record", "-o", str(bag), *TOPICS],
        env=dict(domain),
        stdout=writer,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        os.close(writer)
        try:
            plant.until_heard()
            plant.send(2000)
            assert plant.delivered()
            process.send_signal(signal.SIGINT)
            _, errors = process.communicate(timeout=TIMEOUT)
        finally:
            process.kill()
    assert (process.returncode, errors) == (0, "")
    check_complete(bag, 2000)


def test_all_topics_are_found(domain: dict[str, str], plant: Plant, tmp_path: Path) -> None:
    """Without names, every topic is taken up as it appears, except hidden ones and its own."""
    bag = tmp_path / "bag"
    hidden = plant.publisher(String, "_hidden")
    with RecorderProcess(domain, ["-o", str(bag)]) as recorder:
        plant.until_heard()
        late = plant.publisher(String, "late")
        plant.until_heard_by(late)
        late.publish(String(data="here"))
        plant.send(10)
        assert late.wait_for_all_acked(Duration(seconds=TIMEOUT))
        assert plant.delivered()
        assert hidden.get_subscription_count() == 0
        assert recorder.end(signal.SIGINT) == 0, recorder.output
    read = read_bag(bag)
    assert [message.data for message in read["/late"].messages] == ["here"]
    assert {"/clock", "/joint_states", "/valve/voltage"} <= set(read.topics)
    assert "/_hidden" not in read
    assert len(read["/joint_states"]) == 10


def test_a_killed_recorder_leaves_most_of_its_messages(
    domain: dict[str, str], plant: Plant, tmp_path: Path
) -> None:
    """After SIGKILL everything older than the last flush, 0.1 s, is recovered."""
    bag = tmp_path / "bag"
    with RecorderProcess(domain, ["-o", str(bag), *TOPICS]) as recorder:
        recorder.until_it_says("recording ")
        plant.until_heard()
        plant.send(3000)
        assert plant.delivered()
        # Only what is in the file survives; wait for the recorder's own flush, not for a time.
        plant.until(lambda: number_in(bag) >= 8900)
        plant.send(200)
        recorder.end(signal.SIGKILL)
    found = recover_bag(bag)
    assert 8900 <= found <= 9600
    states = read_bag(bag)["/joint_states"]
    assert states.messages == [sample(k) for k in range(len(states))]


def number_in(bag: Path) -> int:
    """Messages that would be left if the recorder were killed now."""
    read = read_bag(bag, recover=True)
    return sum(len(read[topic]) for topic in read)


def test_a_full_disk_ends_the_recording_with_a_bag_that_opens(
    domain: dict[str, str], plant: Plant, tmp_path: Path
) -> None:
    """When nothing more can be written, the recorder says so, ends by itself with code 1."""
    bag = tmp_path / "bag"
    with RecorderProcess(domain, ["-o", str(bag), *TOPICS], file_limit=300_000) as recorder:
        recorder.until_it_says("recording ")
        plant.until_heard()
        plant.send(2000)
        assert recorder.end() == 1
    assert "bag: cannot be written any more: File too large" in recorder.output
    assert "Traceback" not in recorder.output
    assert 1000 < number_in(bag) < 6000
    states = read_bag(bag)["/joint_states"]
    assert states.messages == [sample(k) for k in range(len(states))]


def test_wrong_use_is_refused_in_words(domain: dict[str, str], tmp_path: Path) -> None:
    """A folder that exists and a name that is no topic end it at once, without a traceback."""
    for arguments, code, said in (
        (["-o", str(tmp_path)], 2, "exists already; a bag is never written over"),
        (["-o", str(tmp_path / "bag"), "two words"], 2, "'two words' is no topic name"),
        (["-o", str(tmp_path / "bag"), "no/1bad"], 2, "'no/1bad' is no topic name"),
        (["-o", str(tmp_path / "bag"), "/x//y"], 2, "'/x//y' is no topic name"),
        (["-o", str(tmp_path / "bag"), "{nobody}"], 2, "'{nobody}' is no topic name"),
        (["-o", str(tmp_path / "bag"), "a" * 300], 2, "longer than 246 characters"),
    ):
        with RecorderProcess(domain, arguments) as recorder:
            assert recorder.end() == code
        assert said in recorder.output
        assert "Traceback" not in recorder.output
    assert not (tmp_path / "bag").exists()


@pytest.mark.parametrize(
    ("change", "more", "code", "said"),
    [
        ("500", [], 2, "ROS_DOMAIN_ID='500': must be a whole number from 0 to 232"),
        ("-1", [], 2, "ROS_DOMAIN_ID='-1': must be a whole number from 0 to 232"),
        ("", ["--ros-args", "-r", "a:b:c"], 1, "refused to start: "),
    ],
)
def test_a_recording_that_cannot_begin_leaves_no_bag(
    domain: dict[str, str], tmp_path: Path, change: str, more: list[str], code: int, said: str
) -> None:
    """The next try under the same name is not refused for it."""
    environment = {**domain, "ROS_DOMAIN_ID": change or domain["ROS_DOMAIN_ID"]}
    with RecorderProcess(environment, ["-o", str(tmp_path / "bag"), *more]) as recorder:
        assert recorder.end() == code
    assert said in recorder.output
    assert not (tmp_path / "bag").exists()


class Recording:
    """A recorder in this process, under an executor of the test's choice."""

    def __init__(self, plant: Plant, bag: Path, make_executor: Callable[..., Executor]) -> None:
        self.context = Context()
        self.context.init(args=[], domain_id=plant.context.get_domain_id())
        self.executor = make_executor(context=self.context)
        self.writer = BagWriter(bag)
        self.told: list[list[str]] = []

    def start(self, *topics: str, **options: object) -> Recorder:
        """Start recording."""
        self.recorder = Recorder(
            self.writer, topics, context=self.context, on_topics=self.told.append, **options
        )
        self.executor.add_node(self.recorder.node)
        return self.recorder

    def until(self, condition: Callable[[], object]) -> None:
        """Run the recorder until ``condition`` holds."""
        deadline = time.monotonic() + TIMEOUT
        while not condition():
            assert time.monotonic() < deadline, "waited in vain"
            self.executor.spin_once(0.05)

    def end(self) -> Bag:
        """Stop recording and read the bag."""
        self.executor.remove_node(self.recorder.node)
        self.recorder.close()
        self.writer.close()
        assert self.writer.failure is None
        return read_bag(self.writer.path)


def events_executor(context: Context) -> Executor:
    return pytest.importorskip("rclpy.experimental").EventsExecutor(context=context)


@pytest.fixture(params=[events_executor, SingleThreadedExecutor])
def recording(request: pytest.FixtureRequest, plant: Plant, tmp_path: Path) -> Iterator[Recording]:
    """Return a recorder in this process, once under each executor."""
    recording = Recording(plant, tmp_path / "bag", request.param)
    yield recording
    recording.context.try_shutdown()


def test_a_recorder_in_process_takes_what_waits_in_its_queues(
    plant: Plant, recording: Recording
) -> None:
    """Messages that came before the end but were not yet handled are in the bag."""
    recorder = recording.start(*TOPICS)
    recording.until(lambda: recorder.ready and recording.told)
    plant.until_heard()
    plant.send(1)
    recording.until(lambda: recording.writer.counts["/clock"] == 1)
    plant.send(999)
    assert plant.delivered()
    recording.end()
    assert [sorted(topics) for topics in recording.told] == [sorted(recorder.topics)]
    assert recorder.lost == {}
    check_complete(recording.writer.path, 1000)


def test_it_is_ready_when_the_last_topic_has_come(plant: Plant, recording: Recording) -> None:
    """A topic that is wanted but not there yet keeps the recorder from being ready."""
    recorder = recording.start("joint_states", "setpoint")
    recording.until(lambda: recorder.topics == ["/joint_states"])
    assert not recorder.ready
    plant.publisher(Float64, "setpoint")
    recording.until(lambda: recording.told)
    assert recorder.ready
    recording.end()


def test_without_a_list_topics_are_told_as_they_come(plant: Plant, recording: Recording) -> None:
    """All there is at first, then each that joins; one that was wanted and never came is known."""
    recorder = recording.start()
    recording.until(lambda: any("/joint_states" in topics for topics in recording.told))
    plant.publisher(Float64, "late")
    # Not alone perhaps: /rosout may take its time as well.
    recording.until(lambda: any("/late" in topics for topics in recording.told[1:]))
    told = [topic for topics in recording.told for topic in topics]
    assert sorted(told) == sorted(set(told))
    assert recorder.missing == []
    recording.end()


def test_a_gap_is_a_loss_only_of_a_publisher_that_is_alone(
    plant: Plant, recording: Recording
) -> None:
    """With two of them nothing is told, not even of a topic that it has lost none.

    Numbers are given by hand: on this machine DDS loses nothing when it is asked to.
    """
    topic = "/supply/pressure"
    both = [plant.publisher(FluidPressure, topic) for _ in range(2)]
    recorder = recording.start(topic)
    recording.until(lambda: recorder.node.count_publishers(topic) == 2)
    for number in (10, 15):
        recorder._count_lost(topic, number)
    assert dict(recorder.lost) == {}
    plant.node.destroy_publisher(both.pop())
    recording.until(lambda: recorder.node.count_publishers(topic) == 1)
    recorder._count_lost(topic, 20)
    assert dict(recorder.lost) == {topic: 4}
    recording.end()


def test_a_bag_of_two_plants_of_one_name_is_told_of(plant: Plant, recording: Recording) -> None:
    """Of topics that a plant alone publishes; several may send set-points, or report.

    One that is started again, even several times, is another publisher, and no second plant.
    """
    troubles: list[str] = []
    recorder = recording.start(on_trouble=troubles.append)
    sent: Counter[str] = Counter()

    def send(publisher: Publisher, message: object) -> None:
        publisher.publish(message)
        topic = publisher.topic_name
        sent[topic] += 1
        recording.until(lambda: recorder.received[topic] == sent[topic])

    for topic, kind in (("supply/pressure", FluidPressure), ("setpoint", Float64)):
        both = [plant.publisher(kind, topic) for _ in range(2)]
        recording.until(lambda both=both: all(p.get_subscription_count() for p in both))
        for _ in range(2 * MANY_TURNS):
            for publisher in both:
                send(publisher, kind())
    for _ in range(3):
        again = plant.publisher(FluidPressure, "chamber_a/pressure")
        recording.until(again.get_subscription_count)
        for _ in range(2 * MANY_TURNS):
            send(again, FluidPressure())
        plant.node.destroy_publisher(again)
    recording.end()
    assert len(troubles) == 1
    said = "/supply/pressure: several nodes publish on it, and the bag mixes what they say; stop"
    assert troubles[0].startswith(said)


@pytest.mark.parametrize("topics", [["joint_states", "setpoint"], []])
def test_a_set_point_of_who_goes_at_once_is_recorded(
    plant: Plant, recording: Recording, topics: list[str]
) -> None:
    """Its sender comes, waits for every listener, sends and goes between two looks for topics.

    Until then nobody has published it, although the recorder listens as the controller does.
    """
    plant.node.create_subscription(Float64, "setpoint", lambda _: None, 10)
    recorder = recording.start(*topics, wall_time=True)
    recording.until(lambda: plant.node.count_subscribers("/setpoint") == 2)
    recording.until(lambda: "/joint_states" in recorder.topics)
    assert recorder.missing == ["/setpoint"] * bool(topics)
    assert "/setpoint" not in recorder.topics
    passer = plant.publisher(Float64, "setpoint")
    plant.until(lambda: passer.get_subscription_count() == 2)
    passer.publish(Float64(data=0.058))
    assert passer.wait_for_all_acked(Duration(seconds=TIMEOUT))
    plant.node.destroy_publisher(passer)
    plant.until(lambda: recorder.node.count_publishers("/setpoint") == 0)
    recording.until(lambda: recorder.received["/setpoint"])
    assert recorder.missing == []
    recording.until(lambda: any("/setpoint" in topics for topics in recording.told))
    # The next one is there long enough to be looked at, and is recorded likewise.
    second = plant.publisher(Float64, "setpoint")
    plant.until(lambda: second.get_subscription_count() == 2)
    recording.until(lambda: recorder.node.count_publishers("/setpoint") == 1)
    second.publish(Float64(data=0.02))
    recording.until(lambda: recorder.received["/setpoint"] == 2)
    assert [message.data for message in recording.end()["/setpoint"].messages] == [0.058, 0.02]


@pytest.mark.parametrize(
    ("offered", "sent"),
    [
        ({"durability": DurabilityPolicy.TRANSIENT_LOCAL}, [1.0, 2.0]),
        ({"reliability": ReliabilityPolicy.BEST_EFFORT}, [3.0]),
        ({}, [2.0, 3.0]),
    ],
)
def test_a_set_point_is_recorded_as_its_publisher_offers_it(
    plant: Plant, recording: Recording, offered: dict[str, object], sent: list[float]
) -> None:
    """Latched ones that are older too, each once; the bag holds what is offered, as for others."""
    plant.node.create_subscription(Float64, "setpoint", lambda _: None, 10)
    recorder = recording.start("setpoint", wall_time=True)
    recording.until(lambda: plant.node.count_subscribers("/setpoint") == 2)
    publisher = plant.publisher(Float64, "setpoint", QoSProfile(depth=10, **offered))
    if 1.0 in sent:
        publisher.publish(Float64(data=1.0))
    if 2.0 in sent:
        plant.until(lambda: publisher.get_subscription_count() == 2)
        publisher.publish(Float64(data=2.0))
        assert publisher.wait_for_all_acked(Duration(seconds=TIMEOUT))
    recording.until(lambda: recorder.ready)
    if 3.0 in sent:
        plant.until_heard_by(publisher)
        publisher.publish(Float64(data=3.0))
    recording.until(lambda: recorder.received["/setpoint"] >= len(sent))
    topic = recording.end()["/setpoint"]
    assert sorted(message.data for message in topic.messages) == sent
    (profile,) = topic.topic.qos
    assert profile["reliability"] == ("best_effort" if "reliability" in offered else "reliable")
    assert profile["durability"] == ("transient_local" if "durability" in offered else "volatile")


@pytest.mark.parametrize("wall_time", [False, True])
def test_a_bag_of_two_clocks_is_told_of(
    plant: Plant, recording: Recording, wall_time: bool
) -> None:
    """Once, with who publishes them, also where the clock only dates the bag.

    One that is dated by the wall clock is in order, whatever is told on a topic of it.
    """
    troubles: list[str] = []
    topics = ("valve/voltage", "/clock") if wall_time else ("valve/voltage",)
    recorder = recording.start(*topics, wall_time=wall_time, on_trouble=troubles.append)
    other = plant.publisher(Clock, "/clock")
    recording.until(lambda: recorder.ready)
    for clock in (plant.clock, other):
        plant.until_heard_by(clock)
    ends = partial(recorder.node.get_publishers_info_by_topic, "/clock")
    recording.until(lambda: [end.node_name for end in ends()] == ["plant", "plant"])
    for k in range(1, 2 * MANY_STEPS + 1):
        plant.clock.publish(Clock(clock=stamp(k)))
        other.publish(Clock(clock=stamp(5000 + k)))
    if wall_time:
        recording.until(lambda: recorder.received["/clock"] >= 4 * MANY_STEPS)
        recorder._look()
        recording.end()
        assert troubles == []
        return
    recording.until(lambda: troubles)
    recording.end()
    (line,) = troubles
    assert line.startswith("/clock: time goes to and fro there, and the times in the bag with it")
    assert (
        "published by /plant, /plant; let one plant alone publish it (publish_clock:=false" in line
    )


def test_a_clock_that_says_nothing_is_told_of_where_the_wall_dates_the_bag(
    plant: Plant, recording: Recording, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As that of a plant in lock-step that waits for its commander while others publish."""
    monkeypatch.setattr(bag_clock, "WAITING", 10)
    troubles: list[str] = []
    recorder = recording.start("joint_states", on_trouble=troubles.append)
    recording.until(lambda: recorder.ready)
    plant.until_heard_by(plant.clock, plant.states)
    before = time.time_ns()
    for k in range(10):
        plant.states.publish(sample(k))
    recording.until(lambda: troubles)
    assert recording.end()["/joint_states"].log_time[0] > before
    assert [line.partition(" before")[0] for line in troubles] == ["/clock: no time came there"]


def test_a_wanted_topic_that_nobody_publishes_is_known(recording: Recording) -> None:
    """The recorder does not keep it to itself."""
    recorder = recording.start("joint_states", "nowhere")
    recording.until(lambda: recorder.topics == ["/joint_states"])
    assert recorder.missing == ["/nowhere"]
    assert recording.told == []
    recording.end()


@pytest.mark.parametrize("told", [True, False])
def test_a_stamp_or_a_clock_before_zero_takes_nothing_with_it(
    plant: Plant, recording: Recording, told: bool
) -> None:
    """Anybody may send one, before there is a clock or beside it: the bag is whole, and closes."""
    recorder = recording.start("joint_states", "joint_commands", "valve/voltage", "/clock")
    commands = plant.publisher(JointState, "joint_commands")
    clock = plant.publisher(Clock, "/clock")
    recording.until(lambda: recorder.ready)
    plant.until_heard_by(plant.clock, plant.states, plant.voltage, commands, clock)
    before = JointState(header=Header(stamp=Time(sec=-1)), name=["carriage"], position=[0.05])
    commands.publish(before)
    if told:
        clock.publish(Clock(clock=Time(sec=-1)))
    plant.send(50)
    commands.publish(before)
    plant.send(50)
    assert plant.delivered()
    assert commands.wait_for_all_acked(Duration(seconds=TIMEOUT))
    assert clock.wait_for_all_acked(Duration(seconds=TIMEOUT))
    bag = recording.end()
    assert [len(bag[f"/{name}"]) for name in ("joint_states", "valve/voltage")] == [100, 100]
    assert len(bag["/joint_commands"]) == 2
    assert list(bag["/joint_states"].log_time) == [1_000_000 * k for k in range(100)]


def test_plant_time_is_taken_from_a_clock_that_is_not_recorded(
    plant: Plant, recording: Recording
) -> None:
    """Voltages are dated by /clock although the bag is to hold nothing but voltages."""
    recorder = recording.start("valve/voltage")
    recording.until(lambda: recorder.ready)
    plant.until_heard_by(plant.clock, plant.voltage)
    plant.send(100)
    assert plant.delivered()
    bag = recording.end()
    assert bag.topics == ["/valve/voltage"]
    assert list(bag["/valve/voltage"].log_time) == [1_000_000 * k for k in range(100)]


@pytest.mark.parametrize(
    "topics", [[], ["right/joint_states", "right/valve/voltage", "right/setpoint"]]
)
def test_two_rigs_in_a_bag_have_each_their_own_time(
    plant: Plant, recording: Recording, topics: list[str]
) -> None:
    """The second rig's commands are dated by its own clock, recorded or not, not by /clock.

    Its time is a minute behind that of the first one, which /clock tells.
    """
    clock = plant.publisher(Clock, "right/clock")
    states = plant.publisher(JointState, "right/joint_states")
    voltage = plant.publisher(Float64, "right/valve/voltage")
    setpoint = plant.publisher(Float64, "right/setpoint")
    recorder = recording.start(*topics)
    recording.until(lambda: recorder.ready and "/right/setpoint" in recorder.topics)
    plant.until_heard_by(plant.clock, clock, states, voltage, setpoint)
    voltage.publish(Float64(data=-1.0))  # before its plant says anything
    for k in range(100):
        plant.clock.publish(Clock(clock=stamp(60_000 + k)))
        clock.publish(Clock(clock=stamp(k)))
        states.publish(sample(k))
        voltage.publish(Float64(data=float(k)))
        if k == 40:
            setpoint.publish(Float64(data=0.05))
    timeout = Duration(seconds=TIMEOUT)
    assert all(one.wait_for_all_acked(timeout) for one in (plant.clock, clock, voltage, setpoint))
    bag = recording.end()
    assert ("/right/clock" in bag) == (not topics)
    milliseconds = bag["/right/valve/voltage"].log_time / 1_000_000
    assert milliseconds.tolist() == [0, *range(100)]
    assert bag["/right/setpoint"].log_time.tolist() == [40_000_000]
    assert bag["/right/joint_states"].log_time.tolist() == [1_000_000 * k for k in range(100)]


@pytest.mark.parametrize("asked", [True, False])
def test_without_a_clock_times_are_those_of_the_wall(
    plant: Plant, recording: Recording, asked: bool
) -> None:
    """On a real rig nobody publishes /clock: messages are dated when they were received."""
    recorder = recording.start("joint_states", wall_time=asked)
    recording.until(lambda: recorder.ready)
    before = time.time_ns()
    if asked:
        plant.send(10)
    else:
        for k in range(10):
            plant.states.publish(sample(k))
    assert plant.delivered()
    states = recording.end()["/joint_states"]
    assert len(states) == 10
    assert before < states.publish_time[0] <= states.log_time[0]
    assert states.log_time[-1] < time.time_ns()


def test_what_publishers_offer_is_met_and_recorded(plant: Plant, recording: Recording) -> None:
    """A latched message sent before the recorder came is recorded, and so is a best-effort one."""
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    description = plant.publisher(String, "description", latched)
    description.publish(String(data="long before"))
    unreliable = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
    beat = plant.publisher(Float64, "beat", unreliable)
    recorder = recording.start("description", "beat", wall_time=True)
    recording.until(lambda: recorder.ready)
    plant.until_heard_by(beat)
    beat.publish(Float64(data=1.0))
    recording.until(lambda: sum(recording.writer.counts.values()) == 2)
    bag = recording.end()
    assert bag["/description"].messages == [String(data="long before")]
    (offered,) = bag["/description"].topic.qos
    assert (offered["reliability"], offered["durability"]) == ("reliable", "transient_local")
    (offered,) = bag["/beat"].topic.qos
    assert (offered["reliability"], offered["durability"]) == ("best_effort", "volatile")
    infinite = {"sec": 9223372036, "nsec": 854775807}
    assert offered["deadline"] == offered["lifespan"] == infinite


def test_messages_that_never_came_are_counted(
    plant: Plant, recording: Recording, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A queue too short for a burst of best-effort messages; the recorder knows what it missed."""
    monkeypatch.setattr("rodless_lab.bags.ros.qos.DEPTH", 5)
    unreliable = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
    beat = plant.publisher(Float64, "beat", unreliable)
    recorder = recording.start("beat", wall_time=True)
    recording.until(lambda: recorder.ready)
    plant.until_heard_by(beat)
    values = iter(range(10_000))

    def heard_again(before: int) -> bool:
        beat.publish(Float64(data=float(next(values))))
        return recording.writer.counts["/beat"] > before

    recording.until(lambda: heard_again(0))
    so_far = recording.writer.counts["/beat"]
    for _ in range(100):
        beat.publish(Float64(data=float(next(values))))
    # What the queue has kept of the burst, and then one after it.
    recording.until(lambda: heard_again(so_far + 5))
    numbers = [int(number) for number in recording.end()["/beat"].fields["data"]]
    missed = set(range(numbers[0], numbers[-1] + 1)) - set(numbers)
    assert len(missed) >= 90
    assert recorder.lost == {"/beat": len(missed)}
