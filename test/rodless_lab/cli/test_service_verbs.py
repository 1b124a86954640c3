# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless pause`, `resume`, `reset`, `enable`, `disable`, and what other verbs say of it."""

import subprocess
import sys
from collections.abc import Callable, Iterator
from typing import cast

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from extent import draws, extensive
from running import StartProcess, StartRig, until_it_says
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64
from std_srvs.srv import SetBool, Trigger

from rodless_base.ros.diagnostics import NAMESAKES
from rodless_base.ros.topics import stamp_nanoseconds
from rodless_lab.cli import disable, enable
from rodless_lab.session import services, set_parameters
from rodless_lab.session.diagnostic import Diagnostic
from rodless_lab.session.observer import Observer
from rodless_lab.session.processes import SessionProcesses
from rodless_lab.session.running_rig import RunningRig

PERIOD = 5e-3
HOLDS = "holds where it is until a new set-point comes"


@pytest.fixture(scope="module", autouse=True)
def rig(start_rig: StartRig) -> Iterator[SessionProcesses]:
    """Run a rig in a namespace of its own."""
    with start_rig(plant={"time.period": PERIOD}, namespace="rig") as processes:
        for node in processes.names:
            # The first start compiles.
            until_it_says(processes[node], "ready: ", 180.0)
        yield processes


def run(rodless: StartProcess, *arguments: str, namespace: str = "/rig") -> tuple[int, str]:
    """Run a verb on the rig; return exit code and output."""
    with rodless(*arguments, "--namespace", namespace) as process:
        code = process.wait()
        assert "Traceback" not in process.output
        return code, process.output


def until_it_reports(
    observer: Observer, node: str, expected: Callable[[Diagnostic], bool], namespace: str = "/rig"
) -> None:
    """Wait for a report of a node of the rig in which something is as expected."""
    reports = observer.diagnostics
    name = f"{namespace}/{node}"
    observer.wait(lambda: name in reports and expected(reports[name]), f"a report of {node}")


@extensive
def test_plant_time_is_paused_and_runs_on(rodless: StartProcess, observer: Observer) -> None:
    """The plant says so itself; pausing twice is no fault."""
    for _ in range(2):
        assert run(rodless, "pause") == (0, "plant/pause: paused\n")
        until_it_reports(observer, "plant", lambda said: said.values["paused"] == "True")
    assert "realtime, paused" in run(rodless, "status")[1]
    assert run(rodless, "resume") == (0, "plant/pause: running\n")
    until_it_reports(observer, "plant", lambda said: said.values["paused"] == "False")


def test_a_disabled_controller_closes_the_valve_until_it_is_enabled(
    rodless: StartProcess, observer: Observer
) -> None:
    """A move says why it cannot be made, and sends nothing."""
    assert run(rodless, "disable") == (0, "controller/enable: disabled: valve closed\n")
    until_it_reports(observer, "controller", lambda said: said.message == "disabled: valve closed")
    code, output = run(rodless, "move", "10")
    assert (code, output) == (2, "the controller does not control: disabled: valve closed\n")
    assert run(rodless, "enable") == (0, f"controller/enable: enabled: {HOLDS}\n")
    assert run(rodless, "move", "10")[0] == 0


@extensive
def test_a_move_that_is_disabled_on_its_way_says_why_it_does_not_settle(
    rodless: StartProcess, observer: Observer
) -> None:
    """Exit code 1, where the carriage is, and what the controller reports."""
    with rodless("move", "190", "--timeout", "6", "--namespace", "/rig") as move:
        until_it_says(move, "to 190 mm")
        assert observer.call(SetBool, "/rig/controller/enable", data=False).success
        assert move.wait() == 1
    assert "not settled within 6 s: the carriage is at" in move.output
    assert "controller: disabled: valve closed" in move.output
    assert run(rodless, "enable")[0] == 0


@extensive
def test_a_reset_leaves_the_carriage_where_it_starts(
    rodless: StartProcess, observer: Observer
) -> None:
    """Whatever set-point it followed: no move from the start, and none later."""
    samples, starts = heard(observer)
    for resets in range(1, draws(4, 3)):
        assert run(rodless, "move", "100")[0] == 0
        observer.more(samples, 1)
        assert run(rodless, "reset")[0] == 0
        # Behind what has come before the reset and is still to be read.
        observer.wait(lambda resets=resets: len(starts) == resets, "the start")
        observer.more(samples, round(0.5 / PERIOD))
        assert max(abs(sample.position[0]) for sample in samples[starts[-1] :]) < 1e-4


@extensive
def test_a_reset_beside_a_frozen_controller_is_refused(
    rodless: StartProcess, rig: SessionProcesses, observer: Observer
) -> None:
    """Code 2, one line, and the plant's run goes on: thawed, the controller would drive by itself.

    With the controller back, the same reset is done.
    """
    assert run(rodless, "move", "40")[0] == 0
    samples, starts = heard(observer)
    observer.more(samples, 1)
    rig["controller"].freeze()
    try:
        code, output = run(rodless, "reset")
    finally:
        rig["controller"].thaw()
    assert code == 2, output
    assert output.startswith(
        "controller/reset: refused, nothing has changed: the plant knows /rig/controller, which "
        "does not show itself here: it is frozen"
    )
    assert output.count("\n") == 1
    observer.diagnostic("/rig/plant", fresh=True)
    assert not starts
    until_it_reports(observer, "controller", lambda said: said.level != DiagnosticStatus.ERROR)
    assert run(rodless, "reset") == (0, f"controller/reset: {HOLDS}\nplant/reset: done\n")


def heard(observer: Observer) -> tuple[list[JointState], list[int]]:
    """Return lists that grow: the samples, and where among them plant time has begun anew."""
    samples: list[JointState] = []
    starts: list[int] = []

    def take(sample: JointState) -> None:
        stamps = [stamp_nanoseconds(one.header.stamp) for one in (*samples[-1:], sample)]
        if stamps != sorted(stamps):
            starts.append(len(samples))
        samples.append(sample)

    observer.subscribe(JointState, "/rig/joint_states", take)
    return samples, starts


def test_a_drive_beside_a_controller_is_refused(rodless: StartProcess, observer: Observer) -> None:
    """It names who commands the valve, and gives no voltage: two would answer each sample."""
    before = observer.more(observer.collect(JointState, "/rig/joint_states"), 1)[-1]
    with rodless("drive", "valve", "--ros-args", "-r", "__ns:=/rig") as drive:
        assert drive.wait() == 2
    assert "valve/voltage: /rig/controller commands the valve too; stop it, or" in drive.output
    assert "ended before all voltages were given" in drive.output
    # Closed at rest; its first voltage is 5.35 V, and the carriage would be far off.
    samples = observer.collect(JointState, "/rig/joint_states")
    assert abs(observer.more(samples, 1)[-1].position[0] - before.position[0]) < 1e-4


def test_a_drive_that_somebody_joins_ends(
    rodless: StartProcess, start_node: StartProcess, observer: Observer
) -> None:
    """Who comes and stays is named, with code 1: the bag holds the voltages of two."""
    with start_node("plant", {"time.period": PERIOD}, namespace="bare") as plant:
        until_it_says(plant, "ready: ")
        with rodless("drive", "friction", "--ros-args", "-r", "__ns:=/bare") as drive:
            until_it_reports(
                observer, "plant", lambda said: int(said.values["commands received"]) > 0, "/bare"
            )
            stranger = observer.node.create_publisher(Float64, "/bare/valve/voltage", 10)
            try:
                assert drive.wait() == 1
            finally:
                observer.node.destroy_publisher(stranger)
    assert "valve/voltage: /observer has come to command the valve too: what was" in drive.output


def test_a_law_that_fails_again_once_it_is_enabled_is_told(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """With its next sample, after the answer: code 1, and what it says."""
    monkeypatch.setattr(services, "ask_each", lambda *_: [("controller/enable", "enabled")])
    monkeypatch.setattr(set_parameters, "failed_law", lambda _: "no more")
    rig = cast(RunningRig, None)
    assert enable.main._ask(rig, 1.0) == 1
    assert disable.main._ask(rig, 1.0) == 0
    said = capsys.readouterr()
    assert said.out == "controller/enable: enabled\n" * 2
    assert said.err == "controller: no more\n"


def test_a_second_node_that_commands_is_reported(rodless: StartProcess, observer: Observer) -> None:
    """By name, as a warning, for as long as it is there; the controller goes on."""
    stranger = observer.node.create_publisher(Float64, "/rig/valve/voltage", 10)
    both = "2 nodes publish on valve/voltage (/observer, /rig/controller), the valve follows"
    try:
        until_it_reports(observer, "plant", lambda said: said.message.startswith(both))
        assert f"plant         WARN: {both} whichever came last" in run(rodless, "status")[1]
    finally:
        observer.node.destroy_publisher(stranger)
    until_it_reports(observer, "plant", lambda said: said.message == "running")


def test_a_move_whose_set_point_is_not_followed_ends_soon(
    rodless: StartProcess, observer: Observer
) -> None:
    """Where another one comes between unheard: code 2 long before the time to settle is over."""
    with rodless("move", "180", "--timeout", "60", "--namespace", "/rig") as move:
        target = observer.collect(Float64, "/rig/controller/reference")
        observer.wait(lambda: target and target[-1].data == 0.18, "the set-point")
        # A reset of the controller alone: the carriage holds where it is, and nobody sends that.
        assert observer.call(Trigger, "/rig/controller/reset").success
        assert move.wait() == 2
    assert "the controller's reference rests at " in move.output
    assert " mm: another set-point has taken the place of this one" in move.output


def test_a_reset_begins_anew(
    rodless: StartProcess, start_rig: StartRig, observer: Observer
) -> None:
    """A plant whose duration is over says so to status and move; reset gives it another run."""
    plant = {"time.period": PERIOD, "time.duration": 1.0, "time.publish_clock": False}
    controller = {"use_sim_time": False}
    with start_rig(plant=plant, controller=controller, namespace="short") as processes:
        until_it_says(processes["controller"], "ready: ")
        # On a crowded machine a second of plant time takes longer than a verb to start.
        observer.wait(
            lambda: observer.diagnostic("/short/plant").message.startswith("ended"), "the end"
        )
        code, output = run(rodless, "move", "10", namespace="/short")
        assert code == 1
        assert output == (
            "plant time stands still: its time.duration is over; rodless reset begins anew; no "
            "set-point sent\n"
        )
        assert (
            "realtime, ended: time.duration is over"
            in run(rodless, "status", namespace="/short")[1]
        )
        over = "plant/pause: stands still: time.duration is over; ~/reset begins anew\n"
        assert run(rodless, "resume", namespace="/short") == (0, over)
        done = f"controller/reset: {HOLDS}\nplant/reset: done\n"
        assert run(rodless, "reset", namespace="/short") == (0, done)


def test_a_plant_that_freezes_under_way_is_not_said_to_run(
    rodless: StartProcess, rig: SessionProcesses
) -> None:
    """What it reported last is no reason: it is silent."""
    with rodless("move", "100", "--timeout", "9", "--namespace", "/rig") as move:
        until_it_says(move, "to 100 mm")
        rig["plant"].freeze()
        try:
            assert move.wait() == 1
        finally:
            rig["plant"].thaw()
    assert (
        "plant time stands still: the plant is silent: compiling for its first start, killed"
        in move.output
    )
    assert "plant: silent: compiling for its first start, killed, frozen" in move.output


@extensive
def test_two_rigs_of_one_name_are_refused_by_name(
    rodless: StartProcess, start_rig: StartRig, rig: SessionProcesses, observer: Observer
) -> None:
    """Nothing is sent, nothing is changed: move, set, get and pause end with 2, status with 1."""
    plant = {"time.period": PERIOD, "time.publish_clock": False}
    with start_rig(plant=plant, namespace="rig") as twin:
        for processes in (rig, twin):
            for name in ("plant", "controller"):
                until_it_says(processes[name], f"2 nodes named {name}")
        words = "in namespace /rig of ROS domain"
        for verb in ("move 20", "set supply.pressure=5e5", "get supply.pressure", "pause"):
            code, output = run(rodless, *verb.split())
            assert code == 2, output
            assert "2 nodes named " in output, output
            assert words in output, output
        code, output = run(rodless, "status")
        assert code == 1, output
        assert "2 nodes named " in output, output
        for node in ("plant", "controller"):
            text = f"2 nodes named {node} {words}"
            until_it_reports(observer, node, lambda said, text=text: text in said.message)
            assert twin[node].output.count(text) == 1
    # A loaded machine may lose the word that the twin leaves: its lease ends 20 s later.
    for node in ("plant", "controller"):
        until_it_reports(observer, node, lambda said: said.values[NAMESAKES] == "1")
    assert observer.get_parameters("/rig/plant", ["supply.pressure"]) == {
        "supply.pressure": 621325.0
    }
    # Two plants on one topic wind up the integral of both controllers.
    assert run(rodless, "reset") == (0, f"controller/reset: {HOLDS}\nplant/reset: done\n")


@extensive
def test_a_reader_who_leaves_ends_neither_verb_nor_rig(
    domain: dict[str, str], observer: Observer
) -> None:
    """Behind `head`, /dev/null's full brother and a closed output: no traceback, the work done."""
    for redirection, code, errors in (
        ("| head -n 1", 0, ""),
        (">&-", 0, ""),
        (">/dev/full", 1, "standard output: cannot be written: No space left on device\n"),
    ):
        for arguments in ("move 30", "set supply.pressure=600000", "get"):
            done = subprocess.run(
                [
                    "bash",
                    "-c",
                    f'set -o pipefail; "$0" -c "$1" {arguments} --namespace /rig {redirection}',
                    sys.executable,
                    "from rodless_lab.cli.main import main; main()",
                ],
                env=domain,
                capture_output=True,
                text=True,
                timeout=120,
                check=False,
            )
            assert (done.returncode, done.stderr) == (code, errors), arguments
    observer.diagnostic("/rig/plant", fresh=True)
