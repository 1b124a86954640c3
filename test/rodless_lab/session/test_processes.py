# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Plant and controller as processes: whatever happens, none is left behind."""

import signal
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path

import numpy as np
import pytest
import yaml
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64
from std_srvs.srv import Trigger

from rodless_base.parameters import ParameterError
from rodless_lab.session.errors import (
    HarnessError,
    LawFailedError,
    NodeDiedError,
    WaitTimeoutError,
)
from rodless_lab.session.file_parameters import own_parameters
from rodless_lab.session.observer import Observer
from rodless_lab.session.processes import ProcessPlan, SessionProcesses, run_rig
from rodless_lab.session.session import RigSession
from rodless_sim import RigParameters

ENDED_WELL = {"plant": 0, "controller": 0}

Run = Callable[..., AbstractContextManager[SessionProcesses]]


@pytest.fixture
def run(domain: dict[str, str], tmp_path: Path) -> Run:
    """Return a context manager that runs a plan in the module's domain."""
    return lambda **options: run_rig(ProcessPlan(**options), domain, tmp_path)


def until_both_answer(observer: Observer, namespace: str) -> None:
    """Wait until both nodes are at work."""
    assert observer.call(Trigger, f"/{namespace}/plant/reset").success
    assert observer.call(Trigger, f"/{namespace}/controller/reset").success


def test_both_run_within_the_block_and_end_with_it(run: Run, observer: Observer) -> None:
    """At its end both are stopped as by Ctrl-C, and end with 0 and no traceback."""
    with run(namespace="one") as processes:
        assert set(processes.pids) == {"plant", "controller"}
        until_both_answer(observer, "one")
        processes.check()
    assert processes.exit_codes == ENDED_WELL
    assert "loading" in processes.outputs["plant"]
    assert not any("Traceback" in output for output in processes.outputs.values())


def test_both_end_when_the_block_raises(run: Run, observer: Observer) -> None:
    """The error comes out of the block as it was."""
    begun: list[SessionProcesses] = []

    def fail() -> None:
        with run(namespace="two") as processes:
            begun.append(processes)
            until_both_answer(observer, "two")
            raise LookupError("of the test's own")

    with pytest.raises(LookupError, match="of the test's own"):
        fail()
    assert begun[0].exit_codes == ENDED_WELL


def test_a_node_that_dies_is_reported_and_the_other_ended(run: Run, observer: Observer) -> None:
    """A plant that refuses its parameters: check() names it and shows what it printed."""
    with run(namespace="three", plant={"supply.pressure": 1.0}) as processes:
        said: list[str] = []

        def reports() -> bool:
            try:
                processes.check()
            except NodeDiedError as error:
                said.append(str(error))
            return bool(said)

        observer.wait(reports, "check() to report the plant")
        assert said[0].startswith("the plant has ended with exit code 1")
        assert "supply.pressure: 1.0 refused" in said[0]
    assert processes.exit_codes == {"plant": 1, "controller": 0}


def test_the_first_ends_when_the_second_cannot_be_started(
    domain: dict[str, str], tmp_path: Path
) -> None:
    """A machine out of processes between the two leaves none running."""
    commands = {"plant": ["sleep", "600"], "controller": ["/no/such/python"]}
    processes = SessionProcesses(commands, domain, tmp_path)
    with pytest.raises(HarnessError, match=r"no/such/python' cannot be started: No such file"):
        processes.__enter__()
    assert processes.exit_codes == {"plant": -signal.SIGINT, "controller": None}


@pytest.fixture
def deaf() -> Iterator[list[str]]:
    """Return the command of a process that ignores Ctrl-C, as it inherits from this one."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    yield ["sleep", "600"]
    signal.signal(signal.SIGINT, before)


def test_a_process_that_does_not_end_is_killed(deaf: list[str], tmp_path: Path) -> None:
    """What ignores Ctrl-C is not waited for for ever, neither at the end nor by who waits."""
    with (
        SessionProcesses({"deaf": deaf}, output=tmp_path, stop_timeout=0.2) as processes,
        pytest.raises(WaitTimeoutError, match=r"the deaf has not ended within 0\.1 s"),
    ):
        processes["deaf"].wait(0.1)
    assert processes.exit_codes == {"deaf": -signal.SIGKILL}


def test_that_one_was_killed_is_still_known_once_its_next_start_has_ended(
    deaf: list[str], tmp_path: Path
) -> None:
    """Its law did not return; that the next one did is no excuse."""
    with SessionProcesses({"deaf": deaf}, output=tmp_path) as processes:
        processes["deaf"].end(0.0)
        processes["deaf"].start()
        processes["deaf"].kill()
    assert processes["deaf"].had_to_be_killed


def test_an_output_that_somebody_removed_does_not_hide_what_failed(tmp_path: Path) -> None:
    """The error it was to explain is told, and that the output is gone."""
    command = ["sh", "-c", "exit 3"]
    with SessionProcesses({"shell": command}, output=tmp_path) as processes:
        processes["shell"].wait()
        (tmp_path / "shell.txt").unlink()
        said = processes.with_outputs("ended")
    assert said.startswith("ended\n")
    assert "shell.txt: cannot be read: No such file" in said


def test_output_goes_where_this_process_prints_unless_it_is_kept(
    capfd: pytest.CaptureFixture[str],
) -> None:
    """Without a folder, both streams of a process come out of this one's."""
    command = ["sh", "-c", "echo out; echo err >&2"]
    with SessionProcesses({"shell": command}) as processes:
        assert processes["shell"].wait() == 0
    assert capfd.readouterr() == ("out\n", "err\n")
    assert processes.outputs == {"shell": ""}
    assert processes.with_outputs("an error") == "an error"


def test_both_in_one_process_close_the_loop(run: Run, observer: Observer) -> None:
    """One process instead of two: the same names, parameters of both, the same move, one end."""
    options = {"plant": {"supply.pressure": 6e5}, "controller": {"reference.type": "move"}}
    with run(namespace="four", one_process=True, **options) as processes:
        assert set(processes.pids) == {"rig"}
        pressures = observer.collect(FluidPressure, "/four/supply/pressure")
        samples = observer.collect(JointState, "/four/joint_states")
        observer.more(pressures, 1)
        assert pressures[-1].fluid_pressure == 6e5
        found = observer.get_parameters("/four/controller", ["reference.type", "use_sim_time"])
        assert found == {"reference.type": "move", "use_sim_time": True}
        observer.publisher(Float64, "/four/setpoint").publish(Float64(data=0.02))
        observer.wait(
            lambda: samples and abs(samples[-1].position[0] - 0.02) < 2e-4, "the carriage to come"
        )
    assert processes.exit_codes == {"rig": 0}


def test_plans_that_make_no_sense_are_refused_before_anything_runs(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The text lists the presets there are, or names the option."""
    monkeypatch.setattr(subprocess, "Popen", None)
    with pytest.raises(FileNotFoundError, match="calibrated, paper"):
        ProcessPlan(preset="papier")
    with pytest.raises(ValueError, match="one_process"):
        ProcessPlan(controller=None, one_process=True)
    with pytest.raises(ValueError, match="relay_commands"):
        ProcessPlan(controller=None, relay_commands=True)


def test_a_place_without_temporary_folders_is_named(
    run: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """One line with the way out, of a rig of a verb and of a session; nothing has started."""
    monkeypatch.setattr(subprocess, "Popen", None)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "missing"))
    refused = r"^folder for the nodes' parameters: cannot be written: No such file.*set TMPDIR to"
    with pytest.raises(HarnessError, match=refused), run():
        pass
    with pytest.raises(HarnessError, match=refused), RigSession():
        pass


def test_numbers_of_numpy_are_written_as_numbers(tmp_path: Path) -> None:
    """As a loop over an array gives them, single, in a list and as a name."""
    given = {
        "supply.pressure": np.linspace(5e5, 6e5, 3)[1],
        "sensors.seed": np.int64(7),
        "time.publish_clock": np.bool_(False),
        np.str_("valve.points"): [np.float64(0.5), 1.0],
        "valve.others": np.array([1.0, 2.0]),
    }
    (command,) = ProcessPlan(plant=given, controller=None).command_lines(tmp_path).values()
    written = yaml.safe_load(Path(command[-1]).read_text("utf-8"))["/**/plant"]["ros__parameters"]
    assert written == {
        "supply.pressure": 5.5e5,
        "sensors.seed": 7,
        "time.publish_clock": False,
        "valve.points": [0.5, 1.0],
        "valve.others": [1.0, 2.0],
    }


@pytest.mark.parametrize("node", ["plant", "controller"])
@pytest.mark.parametrize(
    "value",
    [Path("x"), object(), 1j, [Path("x")], None, b"x", {1}, [1, "a"], [1, 2.0], [[1.0]], []],
    ids=lambda value: type(value).__name__,
)
def test_what_no_parameter_can_be_is_refused_by_its_name(node: str, value: object) -> None:
    """Before anything starts, in one line."""
    with pytest.raises(TypeError, match=r"^some\.name: .* refused, must be a number, a text, true"):
        RigSession(**{node: {"some.name": value}})


def test_a_law_is_blamed_for_its_own_process_alone(deaf: list[str], tmp_path: Path) -> None:
    """A plant that had to be killed has no law where the controller has a process of its own."""
    rig = RigSession(controller={"controller.law": "mine:Law"})
    for name, other in (("plant", "controller"), ("controller", "plant")):
        commands = {name: deaf, other: ["true"]}
        with SessionProcesses(commands, output=tmp_path, stop_timeout=0.2) as processes:
            rig._processes = processes
        assert processes[name].had_to_be_killed
        if name == "plant":
            rig._check_that_the_law_returned()
    with pytest.raises(LawFailedError, match=r"^the controller did not end .* its law mine:Law"):
        rig._check_that_the_law_returned()


def test_files_come_before_parameters_and_after_the_preset(tmp_path: Path) -> None:
    """Later files win: preset, the user's own file, single parameters."""
    mine = tmp_path / "mine.yaml"
    mine.write_text(
        "/**:\n  ros__parameters: {supply.pressure: 6.0e+5, use_sim_time: true}\n", "utf-8"
    )
    plan = ProcessPlan(plant={"time.mode": "lockstep"}, controller=None, parameter_file=mine)
    (command,) = plan.command_lines(tmp_path).values()
    files = [command[k + 1] for k, word in enumerate(command) if word == "--params-file"]
    assert [Path(file).name for file in files] == ["paper.yaml", "of_file.yaml", "parameters.yaml"]
    assert "time.mode: lockstep" in Path(files[-1]).read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("node", "values", "reason"),
    [
        ("plant", "valve.dynamics: sideways", "valve.dynamics: 'sideways' refused"),
        ("plant", "time.period: 5.0", "time.period: 5.0 refused"),
        ("plant", "supply.presure: 6.0e+5", "did you mean supply.pressure?"),
        ("controller", "controller.law: pd", "controller.law: 'pd' refused"),
        ("controller", "controller.law: adrc, adrc.bandwidth: -1.0", "adrc.bandwidth: -1.0"),
    ],
)
def test_what_a_node_would_refuse_is_refused_before_one_starts(
    tmp_path: Path, node: str, values: str, reason: str
) -> None:
    """In one line, which begins with the file; a law of the user's own is left to the node."""
    mine = tmp_path / "mine.yaml"
    mine.write_text(f"/**/{node}: {{ros__parameters: {{{values}}}}}", "utf-8")
    with pytest.raises(ParameterError) as refusal:
        ProcessPlan(parameter_file=mine).command_lines(tmp_path)
    assert str(refusal.value).startswith(f"{mine}: ")
    assert reason in str(refusal.value)
    mine.write_text(
        "controller: {ros__parameters: {controller.law: 'mine:Law', mine.gain: 5.0}}", "utf-8"
    )
    assert len(ProcessPlan(parameter_file=mine).command_lines(tmp_path)) == 2


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("/**/plant: {ros__parameters: {supply: {pressure: 1.0}, supply.pressure: 2.0}}", "twice"),
        ("/left/rig_plant: {ros__parameters: {}}", "no section is for .* it has /left/rig_plant"),
        ("/right/plant: {ros__parameters: {supply.pressure: 5.0e+5}}", "namespace /left"),
        ("right: {plant: {ros__parameters: {supply.pressure: 5.0e+5}}}", "it has right/plant"),
        ("{}", "no section is for .* it has none"),
        ("supply.pressure: 5.0e+5", "as in plant: {ros__parameters: {supply.pressure: 6"),
    ],
)
def test_a_file_that_would_change_nothing_or_be_misread_is_refused(
    tmp_path: Path, text: str, found: str
) -> None:
    """A key that stands twice, another node's or namespace's section: before anything runs."""
    path = tmp_path / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ParameterError, match=f"mine.yaml: .*{found}"):
        own_parameters(path, "/left")


def test_a_section_in_which_nothing_is_set_is_one_all_the_same(tmp_path: Path) -> None:
    """As where all its lines are commented out: the rig is that of the preset, as in Python."""
    path = tmp_path / "mine.yaml"
    path.write_text("plant:\n  ros__parameters:\n    # supply.pressure: 5.0e+5\n", "utf-8")
    assert own_parameters(path, "/left") == {"plant": {}, "controller": {}}
    assert RigParameters.from_file(path) == RigParameters()


def test_a_file_means_the_same_to_the_nodes_and_to_python(tmp_path: Path) -> None:
    """Of sections that all apply the last one wins, and ROS's own parameters are passed on."""
    path = tmp_path / "mine.yaml"
    path.write_text(
        "/**: {ros__parameters: {supply.pressure: 6.0e+5, use_sim_time: true}}\n"
        "/**/plant: {ros__parameters: {supply.pressure: 5.0e+5}}\n"
        "/left/controller: {ros__parameters: {controller.kp: 500.0}}\n",
        encoding="utf-8",
    )
    assert RigParameters.from_file(path)["supply.pressure"] == 5e5
    assert own_parameters(path, "/left") == {
        "plant": {"supply.pressure": 5e5, "use_sim_time": True},
        "controller": {"controller.kp": 500.0, "use_sim_time": True},
    }
    assert "controller.kp" not in own_parameters(path, "/right")["controller"]
