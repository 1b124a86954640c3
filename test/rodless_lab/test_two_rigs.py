# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Rigs in namespaces of their own, and who tells the time on /clock."""

import signal

from diagnostic_msgs.msg import DiagnosticStatus
from extent import extensive
from rosgraph_msgs.msg import Clock
from running import StartProcess, StartRig, until_it_says
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64
from std_srvs.srv import SetBool, Trigger

from rodless_base.ros.topics import stamp_nanoseconds
from rodless_lab.session.observer import Observer

PERIOD = {"time.period": 5e-3}
QUIET = {**PERIOD, "time.publish_clock": False}


@extensive
def test_two_rigs_are_told_of_when_both_publish_clock_and_when_nobody_does(
    observer: Observer, start_node: StartProcess
) -> None:
    """A warning in the log, once, and in the diagnostics as long as it lasts."""
    said = "set time.publish_clock to false (publish_clock:=false, rodless rig --no-clock) on all"
    with start_node("plant", PERIOD, namespace="one") as one:
        assert said not in observer.diagnostic("/one/plant").message
        with start_node("plant", PERIOD, namespace="two"):
            until_it_says(one, f"2 publishers on /clock, time jumps for who listens: {said}")
            observer.wait(lambda: said in observer.diagnostic("/one/plant").message, "the warning")
            assert observer.diagnostic("/one/plant").level == DiagnosticStatus.WARN
        observer.wait(
            lambda: said not in observer.diagnostic("/one/plant").message, "one publisher"
        )
    assert one.output.count("publishers on /clock") == 1
    with start_node("plant", QUIET, namespace="three") as three:
        observer.subscribe(Clock, "/clock", lambda _: None)
        until_it_says(three, "nodes wait for /clock and nobody publishes it")


def test_each_controller_lives_on_its_own_rig(observer: Observer, start_rig: StartRig) -> None:
    """Paused and reset beside a rig whose time runs on, a rig loses no position and restarts once.

    Its own clock shows its own time; the neighbour's is on /clock.
    """
    with (
        start_rig(namespace="left", plant=PERIOD) as left,
        start_rig(namespace="right", plant=QUIET),
    ):
        for name in ("left", "right"):
            observer.more(observer.collect(Float64, f"/{name}/valve/voltage"), 5)
        clock = observer.collect(Clock, "/clock")
        own = observer.collect(Clock, "/right/clock")
        samples = observer.collect(JointState, "/right/joint_states")
        assert observer.call(Trigger, "/right/plant/reset").success
        observer.wait(
            lambda: any(stamp_nanoseconds(s.header.stamp) == 0 for s in samples), "sample 0"
        )
        assert observer.call(SetBool, "/right/plant/pause", data=True).success
        del clock[:], own[:]
        observer.wait(lambda: len(clock) > 400 and len(own) > 100, "two seconds")
        assert len({stamp_nanoseconds(message.clock) for message in own}) <= 2
        times = [stamp_nanoseconds(message.clock) for message in clock]
        assert times == sorted(set(times)), "one publisher"
        status = observer.diagnostic("/right/controller", fresh=True)
        assert status.values["positions lost"] == "0"
        assert status.values["restarts by time running backwards"] == "1"
        assert observer.call(SetBool, "/right/plant/pause", data=False).success
        # The neighbour's life is no sign of one's own.
        right = observer.collect(Float64, "/right/valve/voltage")
        left["plant"].signal(signal.SIGSTOP)
        try:
            observer.wait(
                lambda: observer.counter("/left/controller", "positions lost") == 1, "the loss"
            )
            observer.more(right, 100)
        finally:
            left["plant"].signal(signal.SIGCONT)
        assert observer.counter("/right/controller", "positions lost", fresh=True) == 0
        observer.wait(
            lambda: observer.diagnostic("/left/controller").level != DiagnosticStatus.ERROR,
            "the left rig to go on",
        )
