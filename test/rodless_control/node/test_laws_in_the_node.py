# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A user's own law in the controller node: the numbers of Python, and no end of the node."""

import importlib
import math
import os
import re
import runpy
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np
import pytest
from extent import extensive, some_of
from running import StartProcess, until_it_says

from rodless_control import (
    ControllerParameters,
    Measurement,
    PidParameters,
    ReferencePoint,
    references,
)
from rodless_control.laws import LAWS as LAWS_BY_NAME
from rodless_control.laws import law_class
from rodless_lab import closed_loop
from rodless_lab.harness import (
    LawFailedError,
    Mode,
    RefusedError,
    RigSession,
    Samples,
    WaitTimeoutError,
)
from rodless_lab.session.observer import Observer
from rodless_lab.session.processes import node_command, write_parameters
from rodless_sim import Rig, RigParameters
from rodless_sim.instruments.instruments import DATA_SHEET

pytestmark = pytest.mark.ros

DURATION = 0.6
STEP = {
    "reference.type": "step",
    "reference.start": 0.02,
    "reference.target": 0.03,
    "reference.at": 0.1,
}
PLANT = {**DATA_SHEET, "cylinder.initial_position": 0.02}

# Uses all that is measured, the velocity of the reference, the interval, and remembers.
LAWS = """
from typing import NamedTuple

from rodless_base.parameters import Parameter, declare
from rodless_control import Law


class Command(NamedTuple):
    voltage: float
    force: float


class Damped(Law):
    PARAMETERS = declare(
        Parameter("mine.gain", 60.0, "V/m", "gain", "tuned", 0.0, 1e4),
        Parameter("mine.damping", 1e-5, "V/Pa", "damping", "tuned", 0.0, 1.0),
    )
    TERMS = ("force",)

    def reset(self):
        self.force, self.integral = None, 0.0

    def update(self, measurement, reference, interval):
        force = measurement.pressure_a - measurement.pressure_b
        change = 0.0 if self.force is None else force - self.force
        self.force = force
        error = reference.position - measurement.position
        self.integral += error * interval
        supply = measurement.supply_pressure / 621325.0
        voltage = (
            5.08
            + self.parameters["mine.gain"] * error / supply
            + 10.0 * self.integral
            + 1e-3 * reference.velocity
            - self.parameters["mine.damping"] * change
        )
        return Command(voltage, force)


class Failing(Law):
    USES_PRESSURES = False
    PARAMETERS = declare(Parameter("mine.healthy", False, "", "whether it works", "test"))

    def update(self, measurement, reference, interval):
        if measurement.time > 0.02 and not self.parameters["mine.healthy"]:
            return {}["no such key"]
        return 5.2


class Endless(Law):
    def update(self, measurement, reference, interval):
        while measurement.time > 0.02:
            pass
        return 5.2


class Interrupting(Law):
    USES_PRESSURES = False

    def update(self, measurement, reference, interval):
        raise KeyboardInterrupt


def stay(seconds):
    import os
    import time

    open(os.environ["MARK"], "w").close()
    while True:
        time.sleep(seconds)


class Spinning(Interrupting):
    def update(self, measurement, reference, interval):
        stay(0.0)


class Sleeping(Interrupting):
    def update(self, measurement, reference, interval):
        stay(1e6)


class Unmade(Interrupting):
    def __init__(self, parameters):
        stay(0.01)


class Stubborn(Interrupting):
    def update(self, measurement, reference, interval):
        while True:
            try:
                stay(0.01)
            except Exception:
                pass
"""


@pytest.fixture
def own_laws(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[dict[str, str]]:
    """Write a module outside the package; return the environment in which nodes find it."""
    (tmp_path / "own_laws.py").write_text(LAWS, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    others = os.environ.get("PYTHONPATH")
    yield {"PYTHONPATH": os.pathsep.join([str(tmp_path), *([others] if others else [])])}
    sys.modules.pop("own_laws", None)


@extensive
def test_a_learned_law_in_the_node_gives_the_numbers_of_closed_loop(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What the training example writes, read from its file: in lock-step bit for bit."""
    examples = Path(__file__).parents[3] / "examples"
    monkeypatch.syspath_prepend(examples)
    train = runpy.run_path(str(examples / "train_law.py"))
    weights = train["learn"](generations=1, rigs=2, duration=0.1, progress=lambda *_: None)
    file = tmp_path / "learned.yaml"
    train["write"](file, weights)
    law = ControllerParameters.for_law("learned_law:Learned").from_file(file)
    rig = RigParameters.preset("calibrated").with_values(PLANT)
    expected = closed_loop(rig, law, references.step(0.02, 0.03, at=0.1), DURATION, 1e-3)
    with RigSession(
        "lockstep",
        preset="calibrated",
        plant=PLANT,
        controller={
            **STEP,
            "controller.law": law["controller.law"],
            "learned.weights": law["learned.weights"],
        },
        duration=DURATION,
        environment={"PYTHONPATH": str(examples)},
    ) as session:
        found = session.run()
    assert len(found) == 601
    for name in ("position", "pressure_a", "pressure_b", "voltage"):
        assert np.array_equal(getattr(found, name), getattr(expected, name)), name
    assert np.ptp(found.voltage) > 0.5


def test_a_users_law_in_the_node_gives_the_numbers_of_closed_loop(
    own_laws: dict[str, str],
) -> None:
    """In lock-step, with noisy sensors: every sample and command as in Python, bit for bit.

    The law reads all pressures: they are those of the position's own instant.
    """
    law = importlib.import_module("own_laws").Damped({"mine.gain": 70.0})
    expected = closed_loop(
        RigParameters.preset("paper").with_values(PLANT),
        law,
        references.step(0.02, 0.03, at=0.1),
        DURATION,
        1e-3,
    )
    controller = {**STEP, "controller.law": "own_laws:Damped", "mine.gain": 70.0}
    with RigSession(
        "lockstep", plant=PLANT, controller=controller, duration=DURATION, environment=own_laws
    ) as rig:
        found = rig.run()
        declared = rig.parameters("controller", ["controller.law", "mine.gain", "mine.damping"])
        lost = rig.counter("controller", "samples without all pressures")
    assert len(found) == 601
    for name in ("position", "pressure_a", "pressure_b", "voltage"):
        assert np.array_equal(getattr(found, name), getattr(expected, name)), name
    assert np.ptp(found.voltage) > 0.5
    assert declared == {
        "controller.law": "own_laws:Damped",
        "mine.gain": 70.0,
        "mine.damping": 1e-5,
    }
    assert not lost > 0.0
    # The nine gains of the preset's PID, in one word.
    assert "leaving out parameters of other laws: controller.* (9)" in rig.outputs["controller"]


def test_the_pid_in_the_node_gives_the_numbers_of_closed_loop() -> None:
    """The same for the law of the package, which reads no pressures."""
    expected = closed_loop(
        RigParameters.preset("paper").with_values(PLANT),
        PidParameters.preset("paper"),
        references.step(0.02, 0.03, at=0.1),
        DURATION,
        1e-3,
    )
    with RigSession(
        "lockstep", plant=PLANT, controller=STEP, duration=DURATION, telemetry=True
    ) as rig:
        found = rig.run()
    for name in ("position", "voltage", "reference", "error"):
        assert np.array_equal(getattr(found, name), getattr(expected, name)), name
    for name, values in expected.terms.items():
        assert np.array_equal(getattr(found, name), values), name


@pytest.mark.parametrize("name", some_of([name for name in LAWS_BY_NAME if name != "pid"], 3))
def test_a_law_of_the_package_gives_the_same_bits_however_it_runs(name: str) -> None:
    """Compiled with the rig, sample by sample in Python, and in the node in lock-step.

    With noisy sensors, positions, pressures, commands and each of the law's terms are the same.
    """
    rig_parameters = RigParameters.preset("calibrated").with_values(PLANT)
    step = references.step(0.02, 0.03, at=0.1)
    gains = law_class(name).Parameters.preset("calibrated")
    law, rig = law_class(name)(gains), Rig(rig_parameters)
    expected = closed_loop(rig_parameters, law_class(name)(gains), step, DURATION, 1e-3)
    for k in range(len(expected.time)):
        read = rig.read()
        command: Any = law.update(
            Measurement(*read), ReferencePoint(*step.sample(read.time)), 1e-3 if k else 0.0
        )
        assert (read.position, command.voltage) == (expected.position[k], expected.voltage[k]), k
        for term in law.TERMS:
            assert getattr(command, term) == expected.terms[term][k], (k, term)
        rig.advance(command.voltage, 1e-3)
    with RigSession(
        "lockstep",
        preset="calibrated",
        plant=PLANT,
        controller={**STEP, "controller.law": name},
        duration=DURATION,
        telemetry=True,
        one_process=True,
    ) as session:
        found = session.run()
    assert len(found) == len(expected.time)
    for column in ("position", "pressure_a", "pressure_b", "voltage"):
        assert np.array_equal(getattr(found, column), getattr(expected, column)), column
    for term, values in expected.terms.items():
        assert np.array_equal(found.terms[term], values), term
    assert np.ptp(found.position) > 5e-3


def test_a_reset_of_the_plant_keeps_pressures_and_positions_together(
    own_laws: dict[str, str],
) -> None:
    """The run after a reset is the first run again, bit for bit."""
    controller = {**STEP, "controller.law": "own_laws:Damped"}
    with RigSession("lockstep", plant=PLANT, controller=controller, environment=own_laws) as rig:
        rig.run_until(0.3)
        rig.reset()
        rig.run_until(0.3)
        first, second = rig.samples(0), rig.samples(1)
    assert np.array_equal(first.voltage[:200], second.voltage[:200])
    assert np.array_equal(first.pressure_a[:200], second.pressure_a[:200])
    assert np.ptp(first.voltage[:200]) > 0.1


def test_a_law_that_raises_closes_the_valve_until_it_is_started_again(
    own_laws: dict[str, str],
) -> None:
    """One line in the log, an ERROR in the diagnostics; ~/reset, then ~/enable bring it back.

    Until then it takes no set-point.
    """
    controller = {"controller.law": "own_laws:Failing"}
    options = {"environment": own_laws, "law_may_fail": True}
    with RigSession(plant={"time.period": 5e-3}, controller=controller, **options) as rig:
        rig.run_until(0.1)
        line = LAWS.splitlines().index('            return {}["no such key"]') + 1
        text = (
            f"law Failing failed: KeyError: 'no such key' (own_laws.py, line {line}); "
            "valve closed until ~/reset or ~/enable"
        )
        rig.wait_until(lambda: rig.diagnostics("controller").get("message") == text, "the failure")
        assert rig.counter("controller", "failures of the law") == 1.0
        with pytest.raises(RefusedError, match=r"^setpoint 0\.1 m refused, law Failing failed"):
            rig.setpoint(0.1)
        run = rig.samples()
        # On a crowded machine a sample may have gone unanswered.
        answered = np.isfinite(run.voltage)
        assert set(run.voltage[answered & (run.time > 0.05)]) == {5.08}
        assert run.voltage[answered][0] == 5.2
        rig.reset_controller()
        rig.wait_until(lambda: rig.outputs["controller"].count(text) == 2, "again")
        rig.set_parameters("controller", {"mine.healthy": True})
        rig.enable_controller()
        rig.setpoint(0.1)
        rig.run_for(0.1)
        voltage = rig.samples().voltage
        assert voltage[np.isfinite(voltage)][-4:].tolist() == [5.2] * 4
        output = rig.outputs["controller"]
        with pytest.raises(RefusedError, match=r"mine\.healthy: 3 refused"):
            rig.set_parameters("controller", {"mine.healthy": 3})
    assert output.count("KeyError") == 2
    assert output.count(text) == 2
    assert "Traceback" not in output


def test_a_session_does_not_pass_without_its_law(own_laws: dict[str, str]) -> None:
    """In lock-step, ``run`` raises what the law did; told of each failure, the session goes on."""
    controller = {"controller.law": "own_laws:Failing"}
    failed = r"law Failing failed: KeyError.*law_may_fail"
    with RigSession("lockstep", duration=0.3, controller=controller, environment=own_laws) as rig:

        def run_anew() -> Samples:
            rig.reset_controller()
            rig.reset()
            return rig.run()

        with pytest.raises(LawFailedError, match=failed):
            rig.run()
        with pytest.raises(LawFailedError, match=failed):
            run_anew()
        rig.set_parameters("controller", {"mine.healthy": True})
        assert len(run_anew()) == 301


@pytest.mark.parametrize("one_process", [False, True])
def test_a_failure_at_the_very_end_is_told_by_the_end_of_the_block(
    own_laws: dict[str, str], one_process: bool
) -> None:
    """Nobody waits any more when the law fails: the session says so all the same."""
    controller = {"controller.law": "own_laws:Failing"}
    options = {"environment": own_laws, "one_process": one_process}
    seen_to_fail = []

    def look_away_until_it_has_failed() -> None:
        deadline = monotonic() + 60.0
        with RigSession("lockstep", controller=controller, duration=0.021, **options) as rig:
            rig.run_until(0.02)
            while "failed" not in "".join(rig.outputs.values()):
                assert monotonic() < deadline
            seen_to_fail.append(True)

    with pytest.raises(LawFailedError, match=r"^law Failing failed: KeyError"):
        look_away_until_it_has_failed()
    assert seen_to_fail


@extensive
def test_a_session_does_not_pass_with_a_law_that_does_not_return(own_laws: dict[str, str]) -> None:
    """In real time, where the plant runs on, its end says so; in lock-step the wait does."""
    options = {"controller": {"controller.law": "own_laws:Endless"}, "environment": own_laws}

    def run(mode: Mode) -> None:
        with RigSession(mode, duration=0.3, timeout=30.0, **options) as rig:
            rig.run()

    with pytest.raises(LawFailedError, match=r"own_laws:Endless does not return.*law_may_fail"):
        run("realtime")
    with pytest.raises(
        WaitTimeoutError, match=r"plant time 0\.3 s; the controller is silent: .*law"
    ):
        run("lockstep")


def test_a_law_that_raises_keyboard_interrupt_ends_its_node_cleanly(
    own_laws: dict[str, str], observer: Observer, start_process: StartProcess, tmp_path: Path
) -> None:
    """As Ctrl-C does: exit code 0, no traceback."""
    from sensor_msgs.msg import JointState  # noqa: PLC0415
    from std_msgs.msg import Float64  # noqa: PLC0415

    parameters = {"controller": {"controller.law": "own_laws:Interrupting"}}
    file = write_parameters(tmp_path / "law.yaml", parameters)
    command = node_command("controller", [file], "interrupted")
    with start_process(command, environment=own_laws) as controller:
        # The controller listens to samples once somebody listens to its commands.
        observer.collect(Float64, "/interrupted/valve/voltage")
        samples = observer.publisher(JointState, "/interrupted/joint_states")
        samples.publish(JointState(name=["carriage"], position=[0.05]))
        assert controller.wait() == 0
        assert "Traceback" not in controller.output


@pytest.mark.parametrize("law", ["Spinning", "Sleeping", "Stubborn"])
def test_a_law_that_does_not_return_does_not_keep_its_node(
    own_laws: dict[str, str],
    observer: Observer,
    start_process: StartProcess,
    tmp_path: Path,
    law: str,
) -> None:
    """Asked to end, it breaks the law off, closes the valve and ends, with code 0."""
    from sensor_msgs.msg import JointState  # noqa: PLC0415
    from std_msgs.msg import Float64  # noqa: PLC0415

    mark = tmp_path / "busy"
    parameters = {"controller": {"controller.law": f"own_laws:{law}"}}
    file = write_parameters(tmp_path / "law.yaml", parameters)
    command = node_command("controller", [file], "busy")
    with start_process(command, environment={**own_laws, "MARK": str(mark)}) as controller:
        commands = observer.collect(Float64, "/busy/valve/voltage")
        samples = observer.publisher(JointState, "/busy/joint_states")
        samples.publish(JointState(name=["carriage"], position=[0.05]))
        observer.wait(mark.exists, "the law to be called")
        controller.signal(signal.SIGINT)
        assert controller.wait() == 0
        assert "failed: LawBrokenOffError: it does not return" in controller.output
        assert "Traceback" not in controller.output
    observer.wait(lambda: bool(commands), "the valve to be closed")
    assert commands[-1].data == 5.08


def test_a_law_that_is_never_made_does_not_keep_its_node(
    own_laws: dict[str, str], observer: Observer, start_process: StartProcess, tmp_path: Path
) -> None:
    """It waits for something as it is made: asked to end, the node ends with code 0."""
    mark = tmp_path / "busy"
    parameters = {"controller": {"controller.law": "own_laws:Unmade"}}
    file = write_parameters(tmp_path / "law.yaml", parameters)
    command = node_command("controller", [file], "unmade")
    with start_process(command, environment={**own_laws, "MARK": str(mark)}) as controller:
        observer.wait(mark.exists, "the law to be made")
        controller.signal(signal.SIGINT)
        assert controller.wait() == 0
        assert "Traceback" not in controller.output


def test_a_law_that_there_is_not_stops_the_node_with_one_line(
    domain: dict[str, str], tmp_path: Path
) -> None:
    """The last line that it prints names the parameter, the law, and what is missing."""
    file = write_parameters(
        tmp_path / "law.yaml", {"controller": {"controller.law": "no_such_module:Law"}}
    )
    done = subprocess.run(
        node_command("controller", [file]),
        env={**os.environ, **domain},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 1
    assert re.search(
        r"refused to start: controller\.law: 'no_such_module:Law' refused: "
        r"No module named 'no_such_module'; put its folder on PYTHONPATH",
        done.stderr.splitlines()[-1],
    )


def test_a_set_point_is_refused_and_counted_while_a_sine_runs(
    observer: Observer, start_node: StartProcess
) -> None:
    """One line names the value and the reason; the counter of refusals grows."""
    from std_msgs.msg import Float64  # noqa: PLC0415

    with start_node("controller", {"reference.type": "sine"}, namespace="busy") as controller:
        setpoints = observer.publisher(Float64, "/busy/setpoint")
        setpoints.publish(Float64(data=0.1))
        until_it_says(controller, "set-point: 0.1 m ignored, reference.type is sine")
        assert observer.counter("/busy/controller", "set-points refused", fresh=True) == 1


def test_a_set_point_is_refused_and_counted_while_the_controller_is_off(
    observer: Observer, start_node: StartProcess
) -> None:
    """Switched on again it holds the carriage where it is: the set-point would be forgotten."""
    from sensor_msgs.msg import JointState  # noqa: PLC0415
    from std_msgs.msg import Float64  # noqa: PLC0415
    from std_srvs.srv import SetBool  # noqa: PLC0415

    with start_node("controller", namespace="off") as controller:
        setpoints = observer.publisher(Float64, "/off/setpoint")
        assert observer.call(SetBool, "/off/controller/enable", data=False).success
        setpoints.publish(Float64(data=0.1))
        until_it_says(controller, "set-point: ignored, the controller is disabled; ~/enable it")
        assert observer.counter("/off/controller", "set-points refused", fresh=True) == 1
        commands = observer.publisher(JointState, "/off/joint_commands")
        commands.publish(JointState(name=["carriage"], position=[math.nan]))  # nobody claims it
        commands.publish(JointState(name=["carriage"], position=[0.1]))
        until_it_says(controller, "command: ignored, the controller is disabled; ~/enable it")
        assert observer.counter("/off/controller", "set-points refused", fresh=True) == 2


def test_a_set_point_outside_the_travel_is_refused_and_counted(
    observer: Observer, start_node: StartProcess
) -> None:
    """One line names value, limits and the way out; the counter of refusals grows."""
    from std_msgs.msg import Float64  # noqa: PLC0415

    with start_node("controller", {"reference.maximum": 0.1}, namespace="short") as controller:
        setpoints = observer.publisher(Float64, "/short/setpoint")
        setpoints.publish(Float64(data=0.15))
        until_it_says(
            controller,
            "set-point: 0.15 m refused, must be from reference.minimum (0 m) to "
            "reference.maximum (0.1 m); change reference.maximum for another travel",
        )
        assert observer.counter("/short/controller", "set-points refused", fresh=True) == 1
