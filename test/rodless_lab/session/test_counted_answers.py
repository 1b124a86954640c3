# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A lock-step plant and a test that commands it never get one sample apart.

Commands have no stamp: offers and answers are counted on both sides. Here both work together,
without ROS, while another commander comes, sends, and goes, the plant is reset, and the test takes
its time. As in ROS what two send comes mixed, and one that has gone is still heard; that there is
another is seen at once by the number of connections, who it is some time later.
"""

from collections import deque

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from outgoing import Outgoing

from rodless_base.ros.publish import UNKNOWN
from rodless_lab.session.commands import OwnCommands
from rodless_lab.session.samples import Received, Sample, Stamped
from rodless_sim import RigParameters
from rodless_sim.node.engine import Engine
from rodless_sim.node.lockstep import Lockstep
from rodless_sim.node.time_keeper import RESET_DONE

# s; longer than any test takes, as in a session.
TIMEOUT = 1000.0

# What the other one sends, V; the test's commands are above.
STRANGE = 1.0

EVENTS = (
    "the plant polls",
    "the test runs",
    "a command arrives",
    "another comes",
    "another sends",
    "another goes",
    "who is there is told",
    "the publisher is made anew",
    "reset",
)
NEAR = (-60, -9, -2, -1, 0, 1, 2, 1000)  # numbers of the other's first command, from the test's


class Together:
    """A plant in lock-step, a test that answers its samples, and what is on its way there."""

    def __init__(self, near: list[int], names: list[str]) -> None:
        self.received, self.sent = Received(), 0
        self.coming: deque[tuple[float, int]] = deque()
        self.numbers, self.others, self.others_next = 99, 0, 0
        self.near, self.names, self.made = near, names, 0
        self.acted: list[tuple[int, float]] = []
        self.key = b"of the test's process 0"
        self.there, self.told = {self.key: "/test"}, {self.key: UNKNOWN}
        self.seen = True
        engine = Engine(
            RigParameters({"time.mode": "lockstep"}), lambda seen, _: self.offer(seen.stamp)
        )
        take = engine.receive

        def note(voltage: float) -> None:
            self.acted.append((engine.rig.nanoseconds, voltage))
            take(voltage)

        engine.receive = note  # type: ignore[method-assign]
        self.plant = Lockstep(
            engine,
            TIMEOUT,
            lambda: True,
            lambda: self.told,
            lambda: len(self.there),
            Outgoing(),
            lambda: 0.0,
        )
        self.own = OwnCommands(self.received, self.send, one_per_sample=True)
        self.own.drive(self.law, from_now=False)

    def law(self, sample: Sample) -> float:
        """Return what belongs to this sample, and no other of its run."""
        return 5.0 + sample.time

    def offer(self, stamp: int) -> None:
        """Let a sample come to the test."""
        self.sent += 1
        for topic in self.received.topics:
            topic.put(Stamped(self.sent, stamp, (4e5, 0.0, 0.0)))

    def send(self, voltage: float) -> None:
        """Let a command of the test be on its way."""
        self.numbers += 1
        self.coming.append((voltage, self.numbers))

    def happen(self, event: str) -> None:
        """Let one thing happen."""
        if event == "the plant polls":
            self.plant.poll()
            self.seen = True
            self.arrive()  # the executor takes turns
        elif event == "the test runs":
            self.own.answer()
        elif event == "a command arrives":
            self.arrive()
        elif event == "another comes":
            self.come()
        elif event == "another sends" and len(self.there) > 1:
            self.coming.append((STRANGE, self.others_next))
            self.others_next += 1
        elif event == "another goes" and self.seen:
            self.there = {self.key: "/test"}
        elif event == "who is there is told":
            self.told = dict(self.there)
        elif event == "the publisher is made anew":
            self.make_anew()
        elif event == "reset":
            self.reset()

    def make_anew(self) -> None:
        """Let the test's publisher go, which is seen, and a new one come, which counts anew."""
        is_known = [*self.plant._present] == [*self.there] == [self.key] and self.plant._started
        if not is_known or self.plant._own.last != self.numbers:
            return  # an answer that was dropped in a crowd is told by its publisher's next one only
        name = self.there.pop(self.key)
        self.told = dict(self.there)
        self.happen("the plant polls")
        self.made += 1
        self.key, self.numbers = b"of the test's process %d" % self.made, 0
        self.there = {self.key: name}
        self.seen = False

    def arrive(self) -> None:
        """Let the plant take what comes next."""
        if self.coming:
            self.plant.receive(*self.coming.popleft())
            self.seen = True

    def come(self) -> None:
        """Let a new one be connected, whose numbers are near those of the test, or far off."""
        if len(self.there) > 1:
            return
        self.others += 1
        name = self.names[self.others % len(self.names)]
        self.there = {self.key: "/test", b"one of another %d" % self.others: name}
        self.others_next = max(self.numbers + self.near[self.others % len(self.near)], 1)
        self.seen = False

    def reset(self) -> None:
        """As a session does it: it runs until sample 0 is there."""
        runs = self.received.runs
        for topic in self.received.topics:
            topic.run_expected_since = self.sent + 1
        said = self.plant.reset()
        self.own.end_run(runs, at_once=said == RESET_DONE)
        for _ in range(20):
            self.own.answer()
            self.happen("the plant polls")
            self.happen("a command arrives")
            if self.received.runs > runs:
                break
            self.alone()
        assert self.received.runs > runs
        for topic in self.received.topics:
            topic.run_expected_since = None

    def alone(self) -> None:
        """Let the other one be gone for good."""
        for event in ("the plant polls", "another goes", "who is there is told"):
            self.happen(event)

    def go_on(self, samples: int) -> None:
        """Run on, alone with each other."""
        self.alone()
        for _ in range(20 * samples):
            for event in EVENTS[:3]:
                self.happen(event)
            if len(self.received.joint.runs[-1]) > samples:
                return
        raise AssertionError("the plant stands still")


@settings(max_examples=300, deadline=None)
@given(
    st.lists(st.sampled_from(EVENTS), max_size=80),
    st.lists(st.sampled_from(NEAR), min_size=1, max_size=3),
    st.lists(st.sampled_from(["/other", UNKNOWN]), min_size=1, max_size=2),
)
def test_each_command_acts_at_the_sample_that_it_answers(
    events: list[str], near: list[int], names: list[str]
) -> None:
    """Whatever happened before, and the run goes on: nobody waits for an answer too many."""
    together = Together(near, names)
    for event in (*EVENTS[:3], *events):
        together.happen(event)
    together.go_on(30)
    for stamp, voltage in together.acted:
        assert voltage == pytest.approx(5.0 + stamp * 1e-9, abs=1e-9)
