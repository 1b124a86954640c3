# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless drive` ends, or says so, where its plant stops, ends or begins anew under it."""

import signal
import sys
from collections.abc import Iterator

import pytest
from extent import extensive
from rclpy.node import Node
from running import StartProcess, until_it_says
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from rodless_lab.identification.excitation import PERIOD, excitation
from rodless_lab.session.node_process import NodeProcess
from rodless_lab.session.observer import Observer

TIMEOUT = 60.0
DRIVE = [sys.executable, "-c", "from rodless_lab.cli.main import main; main()", "drive", "friction"]


class Plant:
    """Samples of a carriage, and ears for commands."""

    def __init__(self, observer: Observer) -> None:
        """Publish nothing yet."""
        self._observer = observer
        self._node = Node("plant", context=observer.context, use_global_arguments=False)
        self._samples = self._node.create_publisher(JointState, "joint_states", 10)
        self.commands: list[Float64] = []
        self._node.create_subscription(Float64, "valve/voltage", self.commands.append, 10)
        observer.add_node(self._node)

    @property
    def voltages(self) -> list[float]:
        """The commands so far, in V."""
        return [command.data for command in self.commands]

    def send(self, second: int) -> None:
        """Send the sample of that time until a command has come."""
        sample = JointState(name=["carriage"], position=[0.06], velocity=[0.0], effort=[0.0])
        sample.header.stamp.sec = second
        before = len(self.commands)

        def answered() -> bool:
            if self._samples.get_subscription_count():
                self._samples.publish(sample)
            return len(self.commands) > before

        self._observer.wait(answered, "a command", TIMEOUT)

    def offer(self, second: int) -> None:
        """Send the sample of that time once, to whoever listens by then."""
        self._observer.wait(self._samples.get_subscription_count, "a listener", TIMEOUT)
        sample = JointState(name=["carriage"], position=[0.06], velocity=[0.0], effort=[0.0])
        sample.header.stamp.sec = second
        self._samples.publish(sample)

    def have_a_recorder_beside(self) -> None:
        """Let somebody else listen to the commands."""
        self._node.create_subscription(Float64, "valve/voltage", lambda _: None, 10)

    def begin_anew(self) -> None:
        """Send a sample of an earlier time."""
        self._samples.publish(JointState(name=["carriage"], position=[0.06]))

    def have_an_arm_beside(self, second: int) -> None:
        """Send a sample of that time of another machine on the same topic."""
        arm = JointState(name=["elbow"], position=[0.5])
        arm.header.stamp.sec = second
        self._samples.publish(arm)

    def close(self) -> None:
        """Leave."""
        self._observer.remove_node(self._node)
        self._node.destroy_node()


@pytest.fixture
def plant(observer: Observer) -> Plant:
    """In the domain of the test."""
    return Plant(observer)


@pytest.fixture
def driver(start_process: StartProcess, plant: Plant) -> Iterator[NodeProcess]:
    """The command, which has begun."""
    with start_process(DRIVE, "driver") as process:
        for second in (0, 5):
            plant.send(second)
        yield process


def test_a_plant_that_begins_anew_ends_it(driver: NodeProcess, plant: Plant) -> None:
    """What comes after it would be no run of the same voltages, also at the time of the first."""
    plant.begin_anew()
    assert driver.wait(TIMEOUT) == 1
    assert "/joint_states: the plant was reset or started again; what was rec" in driver.output
    plant.close()


def test_what_an_arm_on_the_same_topic_sends_is_no_sample(
    driver: NodeProcess, plant: Plant, observer: Observer
) -> None:
    """Whatever its time, late or none: it is not answered, and ends nothing."""
    for second in (1_700_000_000, 0):
        plant.have_an_arm_beside(second)
    plant.send(6)
    due = excitation("friction")[[round(second / PERIOD) for second in (0, 5, 6)]]
    observer.wait(lambda: plant.voltages[-1] == due[-1], "the answer to the plant", TIMEOUT)
    assert set(plant.voltages) == set(due)
    assert driver.exit_code is None
    plant.close()


def test_what_is_offered_again_before_a_recorder_is_there_is_answered_as_often(
    start_process: StartProcess, plant: Plant, observer: Observer
) -> None:
    """A plant in lock-step has other listeners, so that it begins, and waits for each answer."""
    with start_process([*DRIVE, "--recorders", "1"], "driver"):
        plant.offer(0)  # the plant was started anew
        for _ in range(3):
            plant.offer(5)
        plant.have_a_recorder_beside()
        observer.wait(lambda: len(plant.commands) == 3, "three answers", TIMEOUT)
        plant.send(10)
    assert plant.voltages[:4] == list(excitation("friction")[[0, 0, 0, round(5 / PERIOD)]])
    plant.close()


def test_it_ends_where_the_valve_of_its_rig_is_closed(
    start_process: StartProcess, plant: Plant, observer: Observer
) -> None:
    """Elsewhere than the paper's, its carriage would be left to drift."""
    with start_process([*DRIVE, "--closed-voltage", "4.9"], "driver") as process:
        plant.send(0)
        process.signal(signal.SIGINT)
        assert process.wait(TIMEOUT) == 1
    observer.wait(lambda: plant.voltages[-1] == 4.9, "the last command", TIMEOUT)
    plant.close()


def test_a_plant_that_sends_no_first_sample_is_told_of(
    start_process: StartProcess, plant: Plant
) -> None:
    """As one that is paused, or whose run is over: it may go on, and then so does the driver."""
    hasty = "from rodless_lab.session import driver; driver.SILENCE = 0.5; "
    command = [*DRIVE[:2], hasty + DRIVE[2], *DRIVE[3:]]
    with start_process(command, "driver") as process:
        until_it_says(process, "/joint_states: no sample for 0.5 s, the plant is paused", TIMEOUT)
        plant.send(0)
        assert process.exit_code is None
    plant.close()


@extensive
def test_a_plant_that_is_silent_is_told_of_and_one_that_has_ended_ends_it(
    driver: NodeProcess, plant: Plant, observer: Observer
) -> None:
    """Paused, it may go on; what an arm on the same topic calls its time is no plant's."""
    for second in (4, 9):
        plant.have_an_arm_beside(second)
    until_it_says(driver, "/joint_states: no sample for 5 s, the plant is paused", TIMEOUT)
    plant.send(6)
    plant.close()
    observer.wait(lambda: driver.exit_code is not None, "the end of the driver", TIMEOUT)
    assert driver.exit_code == 1
    assert "/joint_states: the plant has ended; what was recorded is of no use" in driver.output
