"""Plant and controller as processes: whatever happens, none is left behind."""

import signal
import subprocess
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from node_process import OUTPUTS
from observer import Observer
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64
from std_srvs.srv import Trigger

from rodless_lab.session import processes
from rodless_lab.session.processes import RigProcesses

ENDED_WELL = {"plant": 0, "controller": 0}

MakeRig = Callable[..., RigProcesses]


@pytest.fixture
def output(tmp_path: Path) -> Iterator[Path]:
    """Return a file for what the processes print, shown with a failing test."""
    path = tmp_path / "output"
    path.touch()
    OUTPUTS["rig"] = path.read_text
    yield path
    del OUTPUTS["rig"]


@pytest.fixture
def make_rig(domain: dict[str, str], output: Path) -> Iterator[MakeRig]:
    """Return RigProcesses in the module's domain, not entered yet."""
    with output.open("w") as file:
        yield lambda **options: RigProcesses(environment=domain, output=file, **options)


def until_both_answer(observer: Observer, namespace: str) -> None:
    """Wait until both nodes are at work."""
    assert observer.call(Trigger, f"/{namespace}/plant/reset").success
    assert observer.call(Trigger, f"/{namespace}/controller/reset").success


def test_both_run_within_the_block_and_end_with_it(
    make_rig: MakeRig, observer: Observer, output: Path
) -> None:
    """At its end both are stopped as by Ctrl-C, and end with 0 and no traceback."""
    with make_rig(namespace="one") as rig:
        assert set(rig.pids) == {"plant", "controller"}
        until_both_answer(observer, "one")
        rig.check()
    assert rig.stop() == ENDED_WELL
    assert "Traceback" not in output.read_text()


def test_both_end_when_the_block_raises(make_rig: MakeRig, observer: Observer) -> None:
    """The error comes out of the block as it was."""
    rig = make_rig(namespace="two")

    def run() -> None:
        with rig:
            until_both_answer(observer, "two")
            raise LookupError("of the test's own")

    with pytest.raises(LookupError, match="of the test's own"):
        run()
    assert rig.stop() == ENDED_WELL


def test_a_node_that_dies_is_reported_and_the_other_ended(
    make_rig: MakeRig, observer: Observer, output: Path
) -> None:
    """A plant that refuses its parameters: check() names it, and the controller ends as ever."""
    with make_rig(namespace="three", plant={"supply.pressure": 1.0}) as rig:
        said: list[str] = []

        def reports() -> bool:
            try:
                rig.check()
            except RuntimeError as error:
                said.append(str(error))
            return bool(said)

        observer.until(reports, "check() to report the plant")
        assert said == ["the plant has ended with exit code 1"]
    assert rig.stop() == {"plant": 1, "controller": 0}
    assert "supply.pressure: 1.0 refused" in output.read_text()


def test_the_first_ends_when_the_second_cannot_be_started(
    make_rig: MakeRig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A machine out of processes between the two leaves none running."""
    real = processes.node_command

    def command(process: str, *arguments: object) -> list[str]:
        return ["/no/such/python"] if process == "controller" else real(process, *arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(processes, "node_command", command)
    rig = make_rig()
    with pytest.raises(FileNotFoundError, match="no/such/python"):
        rig.__enter__()
    assert list(rig.stop()) == ["plant"]


def test_a_process_that_does_not_end_is_killed(
    make_rig: MakeRig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What ignores Ctrl-C is not waited for for ever."""
    monkeypatch.setattr(processes, "node_command", lambda *_: ["sleep", "600"])
    rig = make_rig()
    with ExitStack() as stack:
        # The children inherit it.
        before = signal.signal(signal.SIGINT, signal.SIG_IGN)
        try:
            stack.enter_context(rig)
        finally:
            signal.signal(signal.SIGINT, before)
    assert set(rig.stop().values()) == {-signal.SIGKILL}


def test_both_in_one_process_close_the_loop(make_rig: MakeRig, observer: Observer) -> None:
    """One process instead of two: the same names, parameters of both, the same move, one end."""
    options = {"plant": {"supply.pressure": 6e5}, "controller": {"reference.type": "move"}}
    with make_rig(namespace="four", one_process=True, **options) as rig:
        assert set(rig.pids) == {"rig"}
        pressures = observer.record(FluidPressure, "/four/supply/pressure")
        samples = observer.record(JointState, "/four/joint_states")
        observer.more(pressures, 1)
        assert pressures[-1].fluid_pressure == 6e5
        found = observer.get("/four/controller", ["reference.type", "use_sim_time"])
        assert found == {"reference.type": "move", "use_sim_time": True}
        observer.publisher(Float64, "/four/setpoint").publish(Float64(data=0.02))
        observer.until(
            lambda: samples and abs(samples[-1].position[0] - 0.02) < 2e-4, "the carriage to come"
        )
    assert rig.stop() == {"rig": 0}


def test_an_unknown_preset_is_refused_before_anything_runs(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The text lists the presets there are."""
    monkeypatch.setattr(subprocess, "Popen", None)
    with pytest.raises(FileNotFoundError, match="calibrated, paper"):
        RigProcesses(preset="papier")
