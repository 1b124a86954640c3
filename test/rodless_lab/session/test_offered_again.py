# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A lock-step plant that offers a sample again has an answer to each offer from a test, too.

It does where commanders come and go, or the middleware gives up a process that is stopped for long.
"""

from dataclasses import dataclass
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from rclpy.node import Node
from rclpy.publisher import Publisher
from running import StartSession
from std_msgs.msg import Float64

from rodless_base.topics import VALVE_VOLTAGE
from rodless_control import PidParameters, references
from rodless_lab import closed_loop
from rodless_lab.harness import RigSession
from rodless_lab.session.commands import OwnCommands, RelayedCommands
from rodless_lab.session.errors import WaitTimeoutError
from rodless_lab.session.plant_hears import PlantHears
from rodless_lab.session.samples import Received, Sample, Stamped, Unstamped
from rodless_sim import RigParameters, simulate


def offer(received: Received, stamp: int, sent: int) -> None:
    """Let all of a sample come that was sent at ``sent`` (ns)."""
    for topic in received.topics:
        topic.put(Stamped(sent, stamp, (4e5, 0.0, 0.0)))


def test_a_law_is_asked_once_and_its_answer_given_to_each_offer() -> None:
    """Whether it was offered again before the answer or after; the next sample has one."""
    received, sent, asked = Received(), list[float](), list[float]()
    own = OwnCommands(received, sent.append, one_per_sample=True)

    def law(sample: Sample) -> float:
        asked.append(sample.time)
        return 5.0 + len(asked)

    own.drive(law, from_now=False)
    for when in (1, 2, 3):
        offer(received, 0, when)
    own.answer()
    assert sent == [6.0] * 3
    offer(received, 0, 4)
    own.answer()
    own.answer()
    assert sent == [6.0] * 4
    offer(received, 0, 4)  # by the middleware, once more
    own.answer()
    assert sent == [6.0] * 4
    offer(received, 1_000_000, 5)
    own.answer()
    assert sent == [*[6.0] * 4, 7.0]
    assert asked == [0.0, 0.001]


def test_a_single_command_is_given_to_each_offer() -> None:
    """A test that sends commands one by one is asked for no further one."""
    received, sent = Received(), list[float]()
    own = OwnCommands(received, sent.append, one_per_sample=True)
    offer(received, 0, 1)
    offer(received, 0, 2)
    own.send(6.0)
    assert not own.is_due
    offer(received, 0, 3)
    own.answer()
    assert sent == [6.0] * 3


def test_each_answer_of_a_controller_is_passed_on_once() -> None:
    """It answers each offer; the second answer is none to the next sample."""
    received, sent = Received(), list[float]()
    relay = RelayedCommands(received, sent.append, one_per_sample=True)
    altered: list[float] = []

    def alter(voltage: float) -> float:
        altered.append(voltage)
        return voltage + 1.0

    relay.alter = alter
    offer(received, 0, 1)
    offer(received, 0, 2)
    received.answers.append(Unstamped(2, 5.0))
    relay.answer()
    received.answers.append(Unstamped(3, 5.0))
    relay.answer()
    assert sent == [6.0, 6.0]
    received.answers.append(Unstamped(4, 5.5))
    relay.answer()
    assert sent == [6.0, 6.0]  # of no sample that is there
    offer(received, 1_000_000, 3)
    relay.answer()
    assert sent == [6.0, 6.0, 6.5]
    assert altered == [5.0, 5.5]


STEP = {"reference.type": "step", "reference.at": 0.02, "reference.target": 0.02}
COMMANDERS = pytest.mark.parametrize("relayed", [False, True], ids=["the test", "relayed"])


def begin(rig_session: StartSession, relayed: bool) -> RigSession:
    """Return a session 50 ms on whose commands come from a law of the test, or a controller."""
    if relayed:
        rig = rig_session("lockstep", controller=STEP, relay_commands=True)
    else:
        rig = rig_session("lockstep", controller=None)
        rig.drive(lambda sample: 5.0 + 4.0 * sample.time)
    rig.run_until(0.05)
    return rig


def check_goes_on(rig: RigSession, relayed: bool) -> None:
    """The run to 0.2 s is that of the commands that are due, without nodes, bit for bit."""
    rig.run_until(0.2)
    run = rig.samples()
    assert len(run) == 201
    if relayed:
        reference = references.step(0.0, 0.02, at=0.02)
        alone = closed_loop(RigParameters(), PidParameters(), reference, 0.3, 1e-3)
        assert np.array_equal(run.voltage[:200], alone.voltage[:200])
        assert np.array_equal(run.position, alone.position[:201])
    else:
        voltage = 5.0 + 4.0 * run.time[:200]
        assert run.voltage[:200] == pytest.approx(voltage, abs=1e-12)
        assert np.array_equal(run.position, simulate(RigParameters(), voltage, 1e-3).position)
    assert np.ptp(run.position) > 1e-5


@COMMANDERS
def test_a_run_goes_on_once_another_commander_is_gone(
    rig_session: StartSession, relayed: bool
) -> None:
    """The plant had offered its sample before, and offers it again: no later one is off by one."""
    rig = begin(rig_session, relayed)
    other = Node("other", context=rig.observer.node.context)
    other.create_publisher(Float64, VALVE_VOLTAGE, 1)
    rig.wait_until(lambda: "more than one" in rig.diagnostics("plant")["message"], "it to hold")
    other.destroy_node()
    check_goes_on(rig, relayed)


def test_a_publisher_of_the_commanders_own_name_is_told_of_once_it_sends(
    rig_session: StartSession,
) -> None:
    """It is silent at first, as a dead one is that the middleware has not missed yet.

    The plant holds then, and the wait says so; with it gone the run is the one without it.
    """
    rig = begin(rig_session, relayed=False)
    node = rig.observer.node
    other = node.create_publisher(Float64, VALVE_VOLTAGE, 1000)
    rig.run_until(0.1)
    for _ in range(300):
        other.publish(Float64(data=9.0))
    with pytest.raises(WaitTimeoutError, match="the plant says: more than one publisher on "):
        rig.run_until(0.2, timeout=3.0)
    node.destroy_publisher(other)
    rig.run_until(0.2)
    run = rig.samples()
    voltage = 5.0 + 4.0 * run.time[:200]
    assert np.array_equal(run.position[:201], simulate(RigParameters(), voltage, 1e-3).position)


@dataclass
class Matched:
    """Stands in for a publisher and its node: whom it is matched with, by name."""

    readers: list[str]
    topic_name: str = "/left/valve/voltage"

    def get_subscription_count(self) -> int:
        """Count them."""
        return len(self.readers)

    def get_subscriptions_info_by_topic(self, topic: str) -> list[SimpleNamespace]:
        """Say who they are, as rclpy's node does."""
        assert topic == self.topic_name
        return [
            SimpleNamespace(endpoint_gid=[place], node_name=name, node_namespace="/left")
            for place, name in enumerate(self.readers)
        ]

    def resolve_topic_name(self, name: str) -> str:
        """Return it in the node's namespace."""
        return f"/left/{name}"


def test_nothing_is_answered_while_the_middleware_takes_the_plant_for_gone() -> None:
    """It is not heard until it is found again; whoever else comes and goes changes nothing."""
    matched, clock = Matched([]), iter(range(0, 1000, 10))
    hears = PlantHears(cast(Node, matched), cast(Publisher, matched), lambda: next(clock))
    heard = []
    for matched.readers in (
        [],
        ["plant"],
        ["observer", "plant"],
        ["observer"],  # the plant was stopped for too long
        ["observer", "recorder"],
        ["observer", "recorder", "plant"],
        ["plant", "observer"],  # the recorder was ended
        ["observer"],
        ["_NODE_NAME_UNKNOWN_", "observer"],  # found again, its name not yet
    ):
        hears()
        heard.append(hears())
    assert heard == [False, True, True, False, False, True, True, False, True]
    assert hears.silence == ""
    matched.readers = ["observer"]
    assert "the test answers nothing, as the middleware takes plant for gone" in hears.silence


def test_a_plant_that_has_not_been_heard_of_yet_is_not_gone() -> None:
    """What a session waits for at its start says so itself."""
    nobody = Matched([])
    assert PlantHears(cast(Node, nobody), cast(Publisher, nobody)).silence == ""


def test_what_the_middleware_lists_late_is_asked_again() -> None:
    """Its count of readers may be right before its list of them is."""
    matched, clock = Matched(["plant", "observer"]), iter(range(0, 1000))
    hears = PlantHears(cast(Node, matched), cast(Publisher, matched), lambda: next(clock) / 10)
    assert hears()
    matched.get_subscription_count = lambda: 1  # type: ignore[method-assign]
    assert hears()
    matched.readers = ["observer"]
    assert not hears()
