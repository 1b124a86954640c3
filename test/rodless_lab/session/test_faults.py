# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Faults that a session can make, and that it ends all it started whatever happens."""

import contextlib
import math
import os
import select
import signal
import subprocess
import sys
import textwrap
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from extent import also, some_of
from rosgraph_msgs.msg import Clock
from running import StartSession
from sensor_msgs.msg import JointState

from rodless_base.ros.topics import stamp_nanoseconds
from rodless_lab.harness import (
    HarnessError,
    NodeDiedError,
    RefusedError,
    RigSession,
    SetpointWarning,
    WaitTimeoutError,
)
from rodless_lab.session.observer import Observer
from rodless_sim import RigParameters, simulate

pytestmark = pytest.mark.usefixtures("compiled")

# For a process of a test to end, in wall-clock s.
TIMEOUT = 500.0

SLOW = {"time.period": 5e-3}
HOLD = {"reference.type": "step", "reference.at": 0.05, "reference.target": 0.15}


def ended(pid: int) -> bool:
    """Whether a process is gone within the timeout of this file."""
    with contextlib.suppress(ProcessLookupError):
        handle = os.pidfd_open(pid)
        try:
            return bool(select.select([handle], [], [], TIMEOUT)[0])
        finally:
            os.close(handle)
    return True


def test_a_frozen_controller_closes_the_valve_until_it_is_thawed(rig_session: StartSession) -> None:
    """Without commands the plant closes the valve and says so; thawed, the move goes on.

    The controller answers none of the samples that have waited meanwhile, and says why.
    """
    rig = rig_session(plant=SLOW, controller=HOLD)
    rig.run_until(lambda sample: sample.velocity > 0.02, "the carriage to move")
    rig.freeze("controller")
    rig.wait_until(lambda: rig.counter("plant", "commands lost") == 1, "the plant to miss commands")
    assert rig.counter("/plant", "commands lost") == 1, "by its full name, too"
    assert rig.diagnostics("/plant") == rig.diagnostics("plant")
    rig.run_until(lambda sample: abs(sample.velocity) < 1e-3, "the carriage to stand")
    position = rig.latest.position
    assert position < 0.14
    rig.thaw("controller")
    rig.run_until(lambda sample: sample.position > position + 5e-3, "the carriage to go on")
    rig.wait_until(
        lambda: rig.counter("controller", "samples skipped") > 10, "the controller to count"
    )


def test_lost_commands_close_the_valve(rig_session: StartSession) -> None:
    """Inside the block no command arrives, though the controller sends them."""
    rig = rig_session(plant=SLOW, controller=HOLD, relay_commands=True)
    rig.run_until(lambda sample: sample.velocity > 0.02, "the carriage to move")
    with rig.commands_lost():
        rig.run_until(lambda sample: abs(sample.velocity) < 1e-3, "the carriage to stand")
        position = rig.latest.position
    rig.run_until(lambda sample: sample.position > position + 5e-3, "the carriage to go on")
    assert np.isnan(rig.samples().voltage).sum() > 10


def test_altered_commands_act_from_the_very_sample_on(rig_session: StartSession) -> None:
    """In lock-step a relayed command that is made NaN is exactly one period without a command."""
    rig = rig_session("lockstep", controller=HOLD, relay_commands=True)
    rig.run_until(0.1)
    rig.alter_commands(lambda _: math.nan)
    rig.run_for(1e-3)
    rig.alter_commands(None)
    rig.run_for(0.05)
    voltage = rig.samples().voltage[:-1]
    assert np.flatnonzero(np.isnan(voltage)).tolist() == [100]
    rig.wait_until(lambda: rig.counter("plant", "commands not finite") == 1, "the plant to count")
    with pytest.raises(HarnessError, match="lock-step"), rig.commands_lost():
        pass


def test_friction_and_supply_change_in_mid_run(rig_session: StartSession) -> None:
    """At the same voltage the carriage is slower with more friction and less pressure."""
    rig = rig_session("lockstep", controller=None, preset="calibrated")
    rig.drive(6.0)
    before = rig.run_until(0.5).velocity
    rig.set_parameters("plant", {"friction.forward.viscous": 9000.0, "supply.pressure": 0.4e6})
    after = rig.run_for(0.3).velocity
    assert before > 0.03
    assert abs(after) < 0.8 * before


def test_a_killed_controller_can_be_started_again(rig_session: StartSession) -> None:
    """The plant goes on without, its valve closed; the new controller takes over.

    Not while the plant is paused: the wait for its first answer would be in vain, and is refused.
    """
    rig = rig_session(plant=SLOW, controller=HOLD)
    rig.run_until(lambda sample: sample.velocity > 0.02, "the carriage to move")
    rig.kill("controller")
    assert rig.exit_codes["controller"] == -signal.SIGKILL
    position = rig.run_for(0.5).position
    rig.pause()
    with pytest.raises(HarnessError, match=r"the plant is paused.*resume\(\) first"):
        rig.restart("controller")
    with pytest.raises(WaitTimeoutError, match=r"the plant is paused: resume\(\) lets it go on"):
        rig.run_for(1.0, timeout=0.5)
    rig.resume()
    rig.restart("controller")
    rig.run_until(lambda sample: sample.position > position + 5e-3, "the carriage to go on")


@pytest.mark.parametrize("one_process", some_of([False, True], 2))
@pytest.mark.parametrize("killed", some_of([False, True], 2))
def test_a_plant_that_ends_while_the_test_is_behind(
    rig_session: StartSession, one_process: bool, killed: bool
) -> None:
    """Thousands of samples wait for a test that has computed: the next run is measured as ever.

    The run before has all that somebody else has seen of it until then, whole and in order.
    """
    rig = rig_session("lockstep", one_process=one_process, telemetry=True)
    other = Observer(environment=rig.environment)
    stamps = [0]
    other.subscribe(
        Clock, "/clock", lambda message: stamps.append(stamp_nanoseconds(message.clock))
    )
    rig.run_for(0.2)
    until = time.monotonic() + 1.0
    other.wait(lambda: time.monotonic() > until and stamps[-1] > 0, "a test that computes")
    name = "rig" if one_process else "plant"
    if killed:
        rig.kill(name)
    rig.restart(name)
    rig.run_for(0.1)
    other.close()
    assert rig.samples(0).time[-1] >= stamps[-1] * 1e-9 > 0.3
    assert rig.samples(1).time[100] == pytest.approx(0.1)


def test_a_plant_that_was_paused_and_started_again_is_not(rig_session: StartSession) -> None:
    """It runs, as a new one does: it takes no steps, and a new controller beside it is awaited."""
    rig = rig_session()
    rig.pause()
    rig.restart("plant")
    rig.run_for(0.05)
    with pytest.raises(RefusedError):
        rig.step()
    rig.restart("controller")
    rig.run_for(0.05)


def test_no_new_controller_is_awaited_once_the_run_is_over(rig_session: StartSession) -> None:
    """Its first answer would not come: neither then, nor where the run ends while it starts."""
    rig = rig_session(duration=0.3)
    rig.run()
    pid = rig.pids["controller"]
    with pytest.raises(HarnessError, match=r"the run is over.*reset\(\) first"):
        rig.restart("controller")
    assert rig.pids["controller"] == pid
    rig.reset()
    # No node starts in 0.3 s.
    with pytest.raises(HarnessError, match=r"the run is over"):
        rig.restart("controller")


def test_a_lockstep_run_goes_on_with_a_restarted_controller(rig_session: StartSession) -> None:
    """No sample is missing and none is there twice, although the last one is offered anew."""
    rig = rig_session("lockstep", controller=HOLD)
    rig.run_until(0.2)
    rig.restart("controller")
    end = rig.latest.time + 0.2
    rig.run_until(end)
    run = rig.samples()
    assert len(run) >= 1 + round(end * 1000)
    assert np.array_equal(np.rint(run.time * 1e9), np.arange(len(run)) * 1_000_000)


def test_a_restarted_plant_begins_a_new_run(rig_session: StartSession) -> None:
    """Sample 0 comes again, and a wait for samples of a killed plant ends at once."""
    rig = rig_session("lockstep", controller=None)
    rig.drive(5.6)
    rig.run_until(0.02)
    rig.kill("plant")
    with pytest.raises(HarnessError, match="the plant was ended by the test"):
        rig.run_until(1.0)
    rig.restart("plant")
    assert rig.run_until(0.02).time == pytest.approx(0.02)
    assert np.array_equal(rig.samples(0).position[:20], rig.samples(1).position[:20])


@pytest.mark.parametrize("kill_first", some_of([True, False], 2))
def test_a_restarted_plant_holds_the_answer_to_each_of_its_samples(
    rig_session: StartSession, kill_first: bool
) -> None:
    """The test's answer to the last sample of the old plant is none to the new one's first."""
    rig = rig_session("lockstep", controller=None)
    held = dict[int, float]()

    def take(message: JointState) -> None:
        held[stamp_nanoseconds(message.header.stamp)] = message.effort[0]

    rig.observer.subscribe(JointState, "valve/state", take)
    rig.drive(lambda sample: 5.0 + sample.time)
    for _ in range(3):
        rig.run_until(0.02)
        if kill_first:
            rig.kill("plant")
        rig.restart("plant")
    held.clear()
    rig.run_until(0.02)
    run = rig.samples()
    assert run.voltage[:20] == pytest.approx(5.0 + run.time[:20], abs=1e-12)
    rig.wait_until(lambda: 20_000_000 in held, "what the valve held")
    # At its stamp a message tells what was held since the one before.
    own = {stamp: value for stamp, value in held.items() if 0 < stamp <= 20_000_000}
    assert own == pytest.approx({k * 1_000_000: 5.0 + (k - 1) * 1e-3 for k in range(1, 21)})


def test_commands_sent_one_by_one_answer_a_sample_each(rig_session: StartSession) -> None:
    """In lock-step each waits for its sample; one sent ahead would shift all that follow."""
    rig = rig_session("lockstep", controller=None, duration=0.05)
    rig.send_voltage(5.2)
    rig.send_voltage(5.3)
    rig.drive(lambda sample: 5.0 + sample.time)
    run = rig.run()
    assert run.voltage[:50] == pytest.approx([5.2, 5.3, *(5.0 + run.time[2:50])], abs=1e-12)
    held = simulate(RigParameters(), run.voltage[:50], 1e-3)
    assert np.array_equal(run.pressure_a, held.pressure_a)
    rig.drive(None)
    rig.reset()
    rig.send_voltage(5.4)
    rig.run_until(0.001)
    rig.reset()  # its sample 1 waits for a command, which is none to the next sample 0
    rig.send_voltage(5.2)
    rig.send_voltage(5.3)
    rig.drive(lambda sample: 5.0 + sample.time)
    again = rig.run()
    for name in ("voltage", "pressure_a"):
        assert np.array_equal(getattr(run, name)[:50], getattr(again, name)[:50]), name
    rig.reset()
    rig.drive(lambda _: rig.send_voltage(5.0))
    with pytest.raises(HarnessError, match=r"refused in a law of drive\(\)"):
        rig.run_for(0.01)
    rig.drive(5.0)
    rig.run()
    rig.drive(None)
    rig.send_voltage(5.0)
    with pytest.raises(HarnessError, match="the run is over"):
        rig.send_voltage(5.0)
    rig.kill("plant")
    with pytest.raises(HarnessError, match="no sample will come: the plant was ended by the test"):
        rig.send_voltage(5.0)


@pytest.mark.parametrize("process", some_of(["plant", "controller"], 2))
def test_a_relayed_run_after_a_restart_is_that_of_before(
    rig_session: StartSession, process: str
) -> None:
    """Bit for bit: the new node's answers go to the samples that they are for."""
    rig = rig_session(
        "lockstep", controller={**HOLD, "reference.at": 0.0}, relay_commands=True, duration=0.1
    )
    first = rig.run()
    rig.reset()
    rig.run_until(0.05)
    rig.restart(process)
    if process == "controller":
        rig.reset()
    again = rig.run()
    for name in ("position", "pressure_a", "voltage"):
        assert np.array_equal(getattr(first, name)[:-1], getattr(again, name)[:-1]), name


def test_in_lock_step_every_sample_has_its_command_when_it_is_looked_at(
    rig_session: StartSession,
) -> None:
    """Commands come on a topic of their own; all but that to the last sample are waited for."""
    rig = rig_session("lockstep", controller=HOLD)
    for _ in range(30):
        rig.run_for(0.01)
        assert np.isfinite(rig.samples().voltage[:-1]).all()


def test_nobody_waits_for_the_answer_of_a_node_that_the_test_has_killed(
    rig_session: StartSession,
) -> None:
    """Whatever is asked of it fails and names it; what needs the other node goes on."""
    rig = rig_session(plant=SLOW)
    rig.kill("plant")
    asked: dict[str, Callable[[], object]] = {
        "reset": rig.reset,
        "pause": rig.pause,
        "resume": rig.resume,
        "set": lambda: rig.set_parameters("plant", {"supply.pressure": 5e5}),
        "get": lambda: rig.parameters("/plant", ["supply.pressure"]),
    }
    for what, ask in asked.items():
        with pytest.raises(HarnessError, match="plant will come: the plant was ended") as caught:
            ask()
        assert not isinstance(caught.value, TimeoutError), what
    assert rig.parameters("controller", ["controller.kp"])
    with pytest.raises(TimeoutError, match=r"waiting for rain.*; the plant was ended"):
        rig.wait_until(lambda: False, "rain", timeout=0.2)
    rig.kill("controller")
    with pytest.raises(HarnessError, match="no answer of controller will come: the controller"):
        rig.reset_controller()
    with pytest.raises(HarnessError, match="no controller will take a set-point: the controller"):
        rig.setpoint(0.05)


def test_a_set_point_that_a_frozen_controller_has_not_got_is_told_of(
    rig_session: StartSession,
) -> None:
    """A warning says so; thawed, the controller takes it, and the next one warns of nothing."""
    rig = rig_session(plant=SLOW)
    rig.freeze("controller")
    with pytest.warns(SetpointWarning, match=r"^setpoint 0\.12 m has not arrived .* frozen"):
        rig.setpoint(0.12)
    rig.thaw("controller")
    rig.run_until(lambda sample: sample.position > 0.11, "the carriage to come")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        rig.setpoint(0.05)


def test_a_wait_for_a_frozen_plant_says_so(rig_session: StartSession) -> None:
    """Until it is thawed."""
    rig = rig_session(plant=SLOW)
    rig.freeze("plant")
    with pytest.raises(
        WaitTimeoutError, match=r"the plant was frozen by the test: thaw\('plant'\)"
    ):
        rig.run_for(0.1, timeout=0.5)
    rig.thaw("plant")
    with pytest.raises(WaitTimeoutError) as caught:
        rig.wait_until(lambda: False, "nothing", timeout=0.1)
    assert "frozen by the test" not in str(caught.value)


def test_a_killed_process_of_both_nodes_is_named(rig_session: StartSession) -> None:
    """Where they share one, it is that which was ended."""
    rig = rig_session(plant=SLOW, one_process=True)
    rig.kill("rig")
    for ask in (rig.reset, rig.reset_controller):
        with pytest.raises(HarnessError, match="will come: the rig was ended by the test"):
            ask()


def test_a_wait_ends_when_a_node_dies_by_itself(rig_session: StartSession) -> None:
    """The wait ends at once, whatever it was for."""
    rig = rig_session(plant=SLOW)
    os.kill(rig.pids["controller"], signal.SIGKILL)
    with pytest.raises(NodeDiedError, match="controller has ended with exit code -9"):
        rig.wait_until(lambda: False, "nothing")
    rig.kill("controller")  # so that the end of this test does not complain as well


def test_a_plant_that_dies_by_itself_is_not_called_ended_by_the_test(
    rig_session: StartSession,
) -> None:
    """In a wait for a sample, too, its exit code and what it has printed are shown."""
    rig = rig_session(plant=SLOW)
    os.kill(rig.pids["plant"], signal.SIGKILL)
    with pytest.raises(NodeDiedError, match="plant has ended with exit code -9\n--- output"):
        rig.run_for(100.0)
    rig.kill("plant")


def test_a_node_that_died_fails_a_test_that_waits_for_nothing_more() -> None:
    """Leaving the block raises, although nothing else went wrong in it."""
    rig = RigSession(plant=SLOW).__enter__()
    os.kill(rig.pids["plant"], signal.SIGKILL)
    assert os.waitid(os.P_PID, rig.pids["plant"], os.WEXITED | os.WNOWAIT)
    with pytest.raises(NodeDiedError, match="plant has ended with exit code -9"):
        rig.__exit__(None, None, None)
    assert rig.exit_codes["controller"] == 0


def fail_with(rig: RigSession, frozen: bool) -> None:
    """Start ``rig`` and raise inside its block."""
    with rig:
        if frozen:
            rig.freeze("plant")
        raise ZeroDivisionError(list(rig.pids.values()))


@pytest.mark.parametrize("frozen", [False, True], ids=["running", "frozen"])
def test_all_ends_when_the_test_raises(frozen: bool) -> None:
    """Neither node outlives the block, frozen or not, and the test's own exception comes out."""
    rig = RigSession(plant=SLOW)
    with pytest.raises(ZeroDivisionError) as caught:
        fail_with(rig, frozen)
    assert all(ended(pid) for pid in caught.value.args[0])
    assert rig.exit_codes == {"plant": 0, "controller": 0}
    assert "loading" in rig.outputs["plant"]


def test_all_ends_when_the_start_fails() -> None:
    """A controller that never publishes: the plant that was started meanwhile does not stay."""
    silent = [sys.executable, "-c", "import signal; signal.pause()"]
    rig = RigSession(plant=SLOW, controller=silent, timeout=3.0)
    with pytest.raises(TimeoutError, match="a publisher of valve/voltage"):
        rig.__enter__()
    assert None not in rig.exit_codes.values()


LEAVES_A_CHILD = """
    import subprocess, sys
    print(subprocess.Popen([sys.executable, "-c", "import signal; signal.pause()"]).pid, flush=True)
"""


def test_what_a_controller_leaves_behind_ends_too(
    rig_session: StartSession, tmp_path: Path
) -> None:
    """A command that starts another process and ends: that one is found and ended."""
    with pytest.raises(NodeDiedError, match="controller has ended with exit code 0"):
        rig_session(
            plant=SLOW,
            controller=[sys.executable, "-c", textwrap.dedent(LEAVES_A_CHILD)],
            output=tmp_path,
        )
    assert ended(int((tmp_path / "controller.txt").read_text(encoding="utf-8")))


@pytest.mark.parametrize("place", ["file", "file/below"])
def test_an_output_that_cannot_be_is_named(
    rig_session: StartSession, tmp_path: Path, place: str
) -> None:
    """In one line of the harness, before anything starts; nothing is left where it was to be."""
    (tmp_path / "file").touch()
    output = tmp_path / place
    with pytest.raises(HarnessError, match=r"^\S+: cannot be written: (File exists|Not a dir)"):
        rig_session(plant=SLOW, output=output)
    assert list(tmp_path.iterdir()) == [tmp_path / "file"]


def test_an_output_is_of_one_session_and_keeps_what_is_there(
    rig_session: StartSession, tmp_path: Path
) -> None:
    """Another that would write there is refused; no parameters go there, nor come from there."""
    mine = tmp_path / "parameters.yaml"
    mine.write_text("mine", encoding="utf-8")
    rig = rig_session(plant=SLOW, output=tmp_path)
    with pytest.raises(HarnessError, match=rf"^output {tmp_path}: another session or process wri"):
        RigSession(plant=SLOW, output=tmp_path).__enter__()
    rig.restart("plant")
    assert rig.parameters("plant", list(SLOW)) == SLOW
    rig.__exit__(None, None, None)
    assert mine.read_text("utf-8") == "mine"
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {"parameters.yaml", "plant.txt", "controller.txt"}
    with RigSession("lockstep", duration=0.01, output=tmp_path) as next_rig:
        next_rig.run()


@contextmanager
def running(program: str) -> Iterator[tuple["subprocess.Popen[str]", list[int]]]:
    """Run a test's program; yield its process and the process IDs that it prints."""
    with subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(program)],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    ) as process:
        assert process.stdout is not None
        yield process, [int(pid) for pid in process.stdout.readline().split()]


PROGRAM = """
    import signal
    from rodless_lab.harness import RigSession
    # A shell without job control lets what it starts in the background ignore Ctrl-C.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    with RigSession(plant={"time.period": 5e-3}) as rig:
        print(*rig.pids.values(), flush=True)
        rig.wait_until(lambda: False, "the end")
"""


@pytest.mark.parametrize("number", [signal.SIGINT, also(signal.SIGTERM), signal.SIGKILL])
def test_all_ends_when_the_test_is_ended_from_outside(number: int) -> None:
    """Ctrl-C, a CI's SIGTERM or SIGKILL on the test's process: no node is left behind."""
    with running(PROGRAM) as (program, pids):
        assert len(pids) == 2
        program.send_signal(number)
        assert all(ended(pid) for pid in pids)
        program.wait(TIMEOUT)


FORKING = """
    import multiprocessing
    import sys
    import time
    from rodless_lab.harness import RigSession
    with RigSession(plant={"time.period": 5e-3}) as rig:
        child = multiprocessing.get_context("fork").Process(target=time.sleep, args=(600.0,))
        child.start()
        print(child.pid, *rig.pids.values(), flush=True)
        rig.wait_until(lambda: False, "the end")
"""


def test_a_child_of_a_killed_test_keeps_no_node_alive() -> None:
    """Forked inside the block, as multiprocessing does, it outlives the test, and nothing else."""
    with running(FORKING) as (program, (child, *nodes)):
        try:
            program.kill()
            assert [ended(pid) for pid in nodes] == [True, True]
        finally:
            os.kill(child, signal.SIGKILL)  # which is still there
        program.wait(TIMEOUT)


FAILING = """
    def test_fails(rig_session):
        rig = rig_session(plant={"time.period": 5e-3})
        print("pids", *rig.pids.values())
        assert rig.latest.position > 1.0

    def test_passes(rig_session):
        rig_session(plant={"time.period": 5e-3})
"""


def test_a_failing_test_shows_what_the_nodes_have_printed(
    tmp_path: Path, run_pytest: Callable[..., subprocess.Popen[str]]
) -> None:
    """Below the failure stands the output of each node, and the nodes are gone."""
    (tmp_path / "test_it.py").write_text(textwrap.dedent(FAILING), encoding="utf-8")
    output = run_pytest("test_it.py").communicate(timeout=TIMEOUT)[0]
    assert "1 failed, 1 passed" in output
    for name in ("plant", "controller"):
        assert output.count(f"output of rig 0: {name}") == 1
    assert "loading the compiled plant" in output
    (line,) = [line for line in output.splitlines() if line.startswith("pids")]
    assert all(ended(int(pid)) for pid in line.split()[1:])


def test_a_test_that_is_run_again_shows_the_nodes_of_its_last_try(
    tmp_path: Path, run_pytest: Callable[..., subprocess.Popen[str]]
) -> None:
    """With pytest-rerunfailures: what those before have printed would be another rig's."""
    (tmp_path / "test_it.py").write_text(
        "def test_it(rig_session):\n    rig_session(plant={'supply.presure': 1.0})\n",
        encoding="utf-8",
    )
    output = run_pytest("test_it.py", "--reruns", "1").communicate(timeout=TIMEOUT)[0]
    assert "1 failed" in output
    assert "1 rerun" in output
    assert output.count("output of rig 0: plant") == 1
    assert "output of rig 1" not in output


def test_the_plugin_costs_nothing_until_it_is_used() -> None:
    """Loading it loads neither ROS nor the rest of the product."""
    script = "import sys, rodless_pytest; print([m for m in sys.modules if m.startswith('r')])"
    loaded = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, timeout=60
    ).stdout
    assert "rodless_pytest" in loaded
    assert not any(name in loaded for name in ("rclpy", "rodless_lab", "rodless_sim"))


def test_a_timeout_is_wall_clock_time() -> None:
    """A wait for what never comes lasts as long as it may, not as long as something happens."""
    with RigSession(plant=SLOW) as rig:
        start = time.monotonic()
        with pytest.raises(TimeoutError):
            rig.run_until(1e5, timeout=0.5)
        assert time.monotonic() - start >= 0.5
