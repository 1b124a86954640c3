# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Which time a recorded message gets in the bag."""

import pytest
from builtin_interfaces.msg import Time
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import FluidPressure
from std_msgs.msg import Header

from rodless_lab.bags import clock as bag_clock
from rodless_lab.bags.clock import Arrival, BagClock, TimeBase, leading_time

WALL = 1_700_000_000_000_000_000


def arrival(topic: str, sent: int, **times: int) -> Arrival:
    return Arrival(topic, b"", WALL + sent, WALL + sent + 5, **times)


def times(timed: list) -> list[tuple[str, int]]:
    return [(message.arrival.topic, message.log_time) for message in timed]


def test_a_command_is_dated_by_the_clock_sent_before_it_whatever_came_first() -> None:
    """The next clock message overtakes a command on its way; the command keeps its own time."""
    clock = BagClock()
    assert times(clock.put(arrival("clock", 0, clock=7000))) == [("clock", 7000)]
    assert times(clock.put(arrival("clock", 100, clock=8000))) == [("clock", 8000)]
    assert times(clock.put(arrival("command", 50))) == [("command", 7000)]


def test_a_command_waits_for_the_clock_message_it_has_overtaken() -> None:
    """A command that comes before the clock message it answers is not dated one sample early."""
    clock = BagClock()
    clock.put(arrival("clock", 0, clock=7000))
    assert clock.put(arrival("command", 150)) == []
    assert clock.poll() == []
    dated = clock.put(arrival("clock", 100, clock=8000)) + clock.finish()
    assert times(dated) == [("clock", 8000), ("command", 8000)]


def test_a_paused_plant_does_not_hold_a_command_for_ever() -> None:
    """When no further clock message comes, a command is dated by the last one after some polls."""
    clock = BagClock()
    clock.put(arrival("clock", 0, clock=7000))
    assert clock.put(arrival("command", 150)) == []
    for _ in range(bag_clock.POLLS - 1):
        assert clock.poll() == []
    assert times(clock.poll()) == [("command", 7000)]
    assert clock.finish() == []


def test_a_stamp_is_the_time_of_its_message() -> None:
    """A sample in plant time needs no clock message around it."""
    clock = BagClock()
    clock.put(arrival("clock", 0, clock=7000))
    assert times(clock.put(arrival("sample", 500, stamp=7500))) == [("sample", 7500)]


@pytest.mark.parametrize("stamp", [0, WALL + 450])
def test_a_stamp_that_is_unset_or_wall_time_does_not_count(stamp: int) -> None:
    """One node that stamps by the wall clock must not stretch a bag over fifty years."""
    clock = BagClock()
    clock.put(arrival("clock", 0, clock=7000))
    clock.put(arrival("sample", 500, stamp=stamp))
    assert times(clock.finish()) == [("sample", 7000)]


def test_messages_of_a_topic_keep_their_order() -> None:
    """The first sample, stamped 0, must wait for the clock; the second waits behind it."""
    clock = BagClock()
    clock.put(arrival("clock", 0, clock=0))
    assert clock.put(arrival("sample", 10, stamp=0)) == []
    assert clock.put(arrival("sample", 110, stamp=1000)) == []
    dated = clock.put(arrival("clock", 100, clock=1000))
    assert times(dated) == [("sample", 0), ("sample", 1000), ("clock", 1000)]


def test_nothing_is_dated_before_the_first_clock_message() -> None:
    """Messages that come before /clock are not stamped 0 or with the wall clock; they wait."""
    clock = BagClock()
    assert clock.put(arrival("sample", 10, stamp=6900)) == []
    assert clock.put(arrival("command", 20)) == []
    assert clock.poll() == []
    dated = clock.put(arrival("clock", 30, clock=7000))
    assert times(dated) == [("sample", 6900), ("command", 7000), ("clock", 7000)]


def test_wall_time_is_when_a_message_was_received_and_sent() -> None:
    """On the wall clock, log time and publication time are those rosbag2 records."""
    clock = BagClock(TimeBase.WALL)
    assert clock.tell(WALL, 5) == []
    (message,) = clock.put(arrival("sample", 10, stamp=6900))
    assert (message.log_time, message.publish_time) == (WALL + 15, WALL + 10)


def test_waiting_for_a_clock_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    """A bag without a clock falls back to wall time, all of it, before memory runs out."""
    monkeypatch.setattr(bag_clock, "WAITING", 3)
    clock = BagClock()
    assert clock.put(arrival("a", 10)) == []
    assert clock.put(arrival("b", 15)) == []
    assert clock.put(arrival("a", 20)) == []
    assert not clock.gave_up
    released = clock.put(arrival("a", 30))
    assert clock.gave_up
    assert [message.log_time - WALL for message in released] == [15, 25, 35, 20]
    assert times(clock.put(arrival("clock", 40, clock=7000))) == [("clock", WALL + 45)]


def test_a_reset_of_the_plant_takes_times_back() -> None:
    """After a reset plant time begins anew, also for messages without a stamp."""
    clock = BagClock()
    clock.put(arrival("clock", 0, clock=9000))
    clock.put(arrival("clock", 100, clock=0))
    assert times(clock.put(arrival("late command", 50))) == [("late command", 9000)]
    clock.put(arrival("command", 150))
    assert times(clock.put(arrival("clock", 200, clock=1000))) == [
        ("command", 0),
        ("clock", 1000),
    ]


@pytest.mark.parametrize("hours", [1, -1])
def test_a_wall_clock_that_is_set_leaves_plant_time_as_it_is(hours: int) -> None:
    """Commands before and after are dated by the clock message sent before them; none waits on."""
    step = hours * 3_600_000_000_000
    clock, dated = BagClock(), []
    for k in range(1000):
        sent = 1000 * k + (step if k >= 500 else 0)
        dated += clock.put(arrival("clock", sent, clock=k))
        dated += clock.put(arrival("command", sent + 500))
    dated += clock.put(arrival("clock", 1_000_000 + step, clock=1000))
    commands = [time for topic, time in times(dated) if topic == "command"]
    assert commands == list(range(1000))


def test_a_wall_clock_set_back_before_an_answer_leaves_that_its_time() -> None:
    """The clock message that it follows has the old time; a set-point in a pause has, too.

    By more than a minute: a message may be late by less.
    """
    back = 3_600_000_000_000
    clock, dated = BagClock(), []
    for k in range(1000):
        dated += clock.put(arrival("clock", 1000 * k - (back if k > 500 else 0), clock=k))
        dated += clock.put(arrival("command", 1000 * k + 500 - (back if k >= 500 else 0)))
    dated += clock.put(arrival("clock", 1_000_000 - back, clock=1000))
    commands = [time for topic, time in times(dated) if topic == "command"]
    assert commands == list(range(1000))
    paused = clock.put(arrival("set-point", 1_000_500 - back))
    paused += clock.put(arrival("set-point", 1_000_600 - 2 * back))
    assert times(paused + clock.finish()) == [("set-point", 1000)] * 2


def test_a_latched_message_sent_an_hour_ago_leaves_the_others_their_times() -> None:
    """It comes behind the first clock messages of a recording that joins a rig: no set-back."""
    clock, dated = BagClock(), []
    for k in range(10):
        dated += clock.put(arrival("clock", 1000 * k, clock=k))
        if k == 6:  # the command sent before that clock message is still on its way
            latched = arrival("faults", 1000 * k)
            dated += clock.put(latched._replace(sent=latched.sent - 3_600_000_000_000))
        if k:
            dated += clock.put(arrival("command", 1000 * (k - 1) + 700))
    commands = [time for topic, time in times(dated + clock.finish()) if topic == "command"]
    assert commands == list(range(9))


def test_a_message_that_was_sent_again_late_leaves_the_others_their_times() -> None:
    """What the middleware delivers after it was received before it; both keep their own times."""
    clock, dated = BagClock(), []
    late = range(10, 60)
    for k in range(100):
        dated += clock.put(arrival("clock", 1000 * k, clock=k))
        # The first of them was received last, and holds the others up.
        for number in {late[-1]: late}.get(k, () if k in late else (k,)):
            sent = arrival("command", 1000 * number + 500)
            received = WALL + 60_000 if number == late[0] else sent.received
            dated += clock.put(sent._replace(received=received))
    dated += clock.finish()
    commands = [time for topic, time in times(dated) if topic == "command"]
    assert commands == list(range(100))


def test_remembered_clock_messages_are_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    """A recording of hours keeps only the clock messages that a late message may need."""
    monkeypatch.setattr(bag_clock, "_REMEMBERED", 10)
    clock = BagClock()
    for k in range(1000):
        clock.put(arrival("clock", 100 * k, clock=k))
    assert times(clock.put(arrival("command", 100 * 995 + 50))) == [("command", 995)]
    assert len(clock._bags.sent) <= 20


def test_the_leading_time_is_read_from_the_serialized_message() -> None:
    """Stamp and clock are read from CDR without making an object, in either byte order."""
    stamp = Time(sec=12, nanosec=345)
    sample = FluidPressure(header=Header(stamp=stamp, frame_id="x"), fluid_pressure=1.0)
    assert leading_time(serialize_message(sample)) == 12_000_000_345
    assert leading_time(serialize_message(Clock(clock=stamp))) == 12_000_000_345
    big_endian = bytes([0, 0, 0, 0]) + (12).to_bytes(4, "big") + (345).to_bytes(4, "big")
    assert leading_time(big_endian) == 12_000_000_345


@pytest.mark.parametrize("time", [Time(sec=-1), Time(sec=-(2**31), nanosec=999_999_999)])
def test_a_time_before_zero_counts_as_zero(time: Time) -> None:
    """A bag has no such time: of a stamp, and of a clock that dates all the others."""
    assert leading_time(serialize_message(Clock(clock=time))) == 0
    assert leading_time(serialize_message(FluidPressure(header=Header(stamp=time)))) == 0


def test_each_of_two_rigs_has_its_own_time() -> None:
    """The second rig began 7 s later: its commands are of its samples, not of the first rig's."""
    clock = BagClock()
    clock.put(arrival("clock", 0, clock=7000))
    assert clock.put(arrival("early", 5, clock_of="right")) == []
    clock.put(arrival("right", 10, clock=0, clock_of="right"))
    assert clock.put(arrival("command", 20, clock_of="right")) == []
    clock.put(arrival("clock", 100, clock=8000))
    dated = clock.put(arrival("right", 110, clock=1000, clock_of="right"))
    assert times(dated) == [("command", 0), ("right", 1000)]
    assert times(clock.put(arrival("other", 50))) == [("other", 7000)]


def test_what_a_rig_says_before_its_clock_is_of_its_start() -> None:
    """A controller that begins before its plant is not dated by another rig's time."""
    clock = BagClock()
    clock.put(arrival("clock", 0, clock=7000))
    assert clock.put(arrival("command", 5, clock_of="right")) == []
    clock.put(arrival("clock", 100, clock=8000))
    dated = clock.put(arrival("right", 110, clock=0, clock_of="right"))
    assert times(dated) == [("command", 0), ("right", 0)]


def test_a_rig_without_a_clock_has_the_bags_time() -> None:
    """It is waited for once, as long as for any clock message, and then no more."""
    clock = BagClock()
    clock.put(arrival("clock", 0, clock=7000))
    clock.put(arrival("command", 5, clock_of="right"))
    clock.put(arrival("clock", 100, clock=8000))
    dated = [one for _ in range(bag_clock.POLLS) for one in clock.poll()]
    assert times(dated) == [("command", 7000)]
    assert times(clock.put(arrival("command", 50, clock_of="right"))) == [("command", 7000)]
    # Should one come in the end, it counts.
    clock.put(arrival("right", 110, clock=0, clock_of="right"))
    clock.put(arrival("right", 210, clock=1000, clock_of="right"))
    assert times(clock.put(arrival("command", 150, clock_of="right"))) == [("command", 0)]


def test_what_has_waited_for_a_clock_that_nobody_tells_is_dated_right() -> None:
    """Also where the machine polls every 0.15 s instead of 0.1, and whenever the rig began."""
    clock = BagClock()
    began = 50_000
    dated = []
    for k in range(began + 20_000):
        dated += clock.put(arrival("clock", 100 * k, clock=k))
        if k % 1000 == 0 and k >= began:
            dated += clock.put(arrival("command", 100 * k + 50, clock_of="right"))
        if k % 150 == 0:
            dated += clock.poll()
    commands = [time for topic, time in times(dated) if topic == "command"]
    assert commands == [began + 1000 * k for k in range(20)]


def test_the_clock_of_one_of_several_rigs_makes_no_plant_time_of_a_bag() -> None:
    """Without /clock nothing dates what is of no rig: all of the bag is in wall time."""
    clock = BagClock()
    assert clock.put(arrival("right", 10, clock=5, clock_of="right")) == []
    assert clock.put(arrival("command", 20, clock_of="right")) == []
    dated = clock.finish()
    assert [one.publish_time - WALL for one in dated] == [10, 20]
