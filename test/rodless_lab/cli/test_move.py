# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless move`: the carriage of a running rig goes where it is sent, and is measured."""

import math
import re
import signal
import time
from collections.abc import Iterator

import pytest
from extent import extensive
from running import StartProcess, StartRig, until_it_says
from std_msgs.msg import Float64
from std_srvs.srv import SetBool

from rodless_control import PidParameters, references
from rodless_lab import closed_loop
from rodless_lab.runs.step_metrics import step_metrics
from rodless_lab.session.observer import Observer
from rodless_sim import RigParameters

PERIOD = 2e-3


@pytest.fixture(scope="module", autouse=True)
def rig(start_rig: StartRig) -> Iterator[None]:
    """Run a rig in real time in the root namespace."""
    with start_rig(plant={"time.period": PERIOD}) as processes:
        until_it_says(processes["plant"], "ready: ")
        yield


def figure(output: str, label: str) -> float:
    """Return a number of the table of metrics."""
    found = re.search(rf"^{re.escape(label)}.* (\S+) \S+$", output, re.MULTILINE)
    assert found, output
    return float(found[1])


def test_a_move_in_real_time_settles_and_says_how(rodless: StartProcess) -> None:
    """Exit code 0, metrics within what a busy machine leaves of them, no progress in a pipe."""
    with rodless("move", "20") as move:
        assert move.wait() == 0
    assert "from 0.00 to 20 mm" in move.output
    assert abs(figure(move.output, "final error")) < 0.2
    assert 0.0 < figure(move.output, "rise time") < figure(move.output, "settling time")
    assert figure(move.output, "peak valve voltage") > 5.08
    assert "times count from" not in move.output
    assert "\r" not in move.output


def test_the_same_set_point_again_is_no_step(rodless: StartProcess) -> None:
    """The carriage is there: that is said, and nothing is measured."""
    with rodless("move", "20") as move:
        assert move.wait() == 0
    assert "the carriage was there already" in move.output
    assert "rise time" not in move.output


def test_in_lock_step_the_metrics_are_those_of_the_closed_loop_in_process(
    rodless: StartProcess, start_rig: StartRig
) -> None:
    """The paper's step by the running nodes and by one compiled loop: to the last digit shown."""
    parameters = RigParameters.preset("paper")
    run = closed_loop(
        parameters, PidParameters.preset("paper"), references.step(0.0, 0.058, at=0.5), 4.0, 1e-3
    )
    expected = step_metrics(run.time, run.position, run.voltage, 0.0, 0.058, at=0.5)
    plant = {"time.mode": "lockstep", "time.publish_clock": False}
    controller = {"use_sim_time": False, "controller.position_timeout": 0.0}
    with start_rig(plant=plant, namespace="exact", controller=controller) as processes:
        until_it_says(processes["plant"], "ready: ")
        with rodless("move", "58", "--namespace", "/exact") as move:
            assert move.wait() == 0, move.output
    for label, value in (
        ("rise time 10-90 %", expected.rise_time),
        ("settling time to ±0.2 mm", expected.settling_time),
        ("overshoot", expected.overshoot * 1e3),
        ("peak valve voltage", expected.peak_voltage),
    ):
        assert figure(move.output, label) == pytest.approx(value, abs=6e-4), label


def test_a_set_point_that_is_refused_ends_it_with_the_reason(rodless: StartProcess) -> None:
    """Exit code 2: twenty metres are beyond every limit."""
    with rodless("move", "20000") as move:
        assert move.wait() == 2
    assert "20000 mm" in move.output
    assert "refused" in move.output
    assert "Traceback" not in move.output


@extensive
def test_a_controller_that_takes_no_set_points_is_named(
    rodless: StartProcess, observer: Observer
) -> None:
    """Exit code 2, and what would change it; nothing is sent."""
    before = observer.get_parameters("/controller", ["reference.type", "reference.amplitude"])
    change = {"reference.type": "sine", "reference.amplitude": 0.0}
    observer.set_parameters("/controller", change)
    try:
        with rodless("move", "30") as move:
            assert move.wait() == 2
        assert "rodless set reference.type=setpoint" in move.output
    finally:
        observer.set_parameters("/controller", before)


def test_a_paused_plant_is_named_and_nothing_is_sent(
    rodless: StartProcess, observer: Observer
) -> None:
    """Exit code 1: plant time stands still, so nothing can settle."""
    setpoints = observer.node.create_subscription(
        Float64, "/setpoint", lambda _: sent.append(1), 10
    )
    sent: list[int] = []
    assert observer.call(SetBool, "/plant/pause", data=True).success
    try:
        with rodless("move", "30") as move:
            assert move.wait() == 1
        assert "plant time stands still: it is paused; no set-point sent" in move.output
        observer.diagnostic("/plant", fresh=True)
        assert not sent
    finally:
        observer.node.destroy_subscription(setpoints)
        assert observer.call(SetBool, "/plant/pause", data=False).success


@extensive
def test_a_pause_under_way_is_said_and_ctrl_c_leaves_the_rig_running(
    rodless: StartProcess, observer: Observer
) -> None:
    """A warning while it lasts; exit code 1 at Ctrl-C; the next move finds the rig at work."""
    with rodless("move", "190", "--timeout", "60") as move:
        until_it_says(move, "to 190 mm")
        assert observer.call(SetBool, "/plant/pause", data=True).success
        until_it_says(move, "plant time stands still: it is paused")
        move.signal(signal.SIGINT)
        assert move.wait() == 1
        assert "interrupted; what was running keeps running" in move.output
        assert "Traceback" not in move.output
    assert observer.call(SetBool, "/plant/pause", data=False).success
    with rodless("move", "40") as move:
        assert move.wait() == 0


def test_who_else_commands_the_valve_is_named(rodless: StartProcess, observer: Observer) -> None:
    """The move settles, for the other one sends nothing now; its figures may not be the law's."""
    other = observer.publisher(Float64, "/valve/voltage")
    try:
        observer.wait(
            lambda: "2 nodes publish" in observer.diagnostic("/plant", fresh=True).message,
            "the plant to find the other",
        )
        with rodless("move", "35") as move:
            assert move.wait() == 0
        assert "2 nodes publish on valve/voltage (" in move.output
    finally:
        observer.node.destroy_publisher(other)


def test_what_does_not_settle_in_time_is_said(rodless: StartProcess) -> None:
    """Half a second of rest cannot have passed within 0.2 s: exit code 1, and where it is."""
    with rodless("move", "150", "--timeout", "0.2") as move:
        assert move.wait() == 1
    assert "not settled within 0.2 s: the carriage is at" in move.output
    assert "mm from the set-point" in move.output


def test_a_move_whose_set_point_is_replaced_says_by_which(
    rodless: StartProcess, observer: Observer
) -> None:
    """Exit code 2, at once: the carriage goes elsewhere, and not because anything is slow."""
    sender = observer.publisher(Float64, "/setpoint")
    with rodless("move", "190", "--timeout", "60") as move:
        until_it_says(move, "to 190 mm")
        # The controller, and the move itself.
        observer.wait(lambda: sender.get_subscription_count() >= 2, "the move to be known")
        times = iter(range(40))

        def sent() -> bool:
            sender.publish(Float64(data=0.06))
            return next(times) == 39

        observer.wait(sent, "the other set-points to go out")
        assert move.wait() == 2
    assert "another set-point, 60 mm, has taken the place of this one" in move.output


@extensive
def test_a_move_beside_another_that_sends_nonsense_goes_on(
    rodless: StartProcess, observer: Observer
) -> None:
    """The controller refuses what is no number, and says so, but not of this set-point."""
    sender = observer.publisher(Float64, "/setpoint")
    last = 0.0

    def ended() -> bool:
        nonlocal last
        if time.monotonic() - last > 0.05:
            last = time.monotonic()
            sender.publish(Float64(data=math.nan))
        return move.exit_code is not None

    try:
        with rodless("move", "45") as move:
            observer.wait(ended, "the move to end", 60.0)
            assert move.wait() == 0, move.output
        assert observer.counter("/controller", "set-points refused", fresh=True) > 2
    finally:
        observer.node.destroy_publisher(sender)
    assert "to 45 mm" in move.output


def test_a_move_whose_rig_ends_does_not_wait_for_it(
    rodless: StartProcess, start_rig: StartRig
) -> None:
    """Exit code 2, long before the time it was given.

    Plant time passes slowly, or the carriage might be there before the plant has ended.
    """
    plant = {"time.publish_clock": False, "time.speed": 0.05}
    with start_rig(namespace="gone", plant=plant) as processes:
        until_it_says(processes["plant"], "ready: ")
        with rodless("move", "190", "--namespace", "/gone", "--timeout", "600") as move:
            until_it_says(move, "to 190 mm")
            processes["plant"].ask_to_stop()
            assert move.wait() == 2
    assert "the plant has ended during the move" in move.output


def test_what_is_missing_is_named_with_the_way_out(
    rodless: StartProcess, start_node: StartProcess
) -> None:
    """No rig in this namespace but one elsewhere; a plant without a controller. Exit code 2."""
    with rodless("move", "10", "--namespace", "nowhere") as move:
        assert move.wait() == 2
    assert "no plant in namespace /nowhere" in move.output
    assert "there is one in /: use --namespace" in move.output
    with start_node("plant", {"time.publish_clock": False}, namespace="alone") as plant:
        until_it_says(plant, "ready: ")
        with rodless("move", "10", "--namespace", "/alone") as move:
            assert move.wait() == 2
        assert "no controller in namespace /alone" in move.output
