# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A simulation that fails: said by name, the valve closed, nothing published, and back by reset.

The rig in these tests has a valve of the printed assembly whose area is negative beyond 8 V: there
it sucks the air out of a chamber until no pressure is left. As such a valve is refused where
parameters are checked, that check is switched off here.
"""

import math
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from outgoing import Outgoing
from paused_plant import PausedPlant
from running import StartProcess
from std_srvs.srv import Trigger

from rodless_control import PidParameters, references
from rodless_lab import closed_loop
from rodless_lab.session.observer import Observer
from rodless_lab.session.processes import node_command, write_parameters
from rodless_sim import ParameterError, Rig, RigParameters, SimulationError, State, simulate
from rodless_sim.node.engine import Engine
from rodless_sim.node.lockstep import Lockstep
from rodless_sim.physics.valve_assemblies import printed

PERIOD = 0.01
BACKWARDS = {
    "valve.assembly": "printed",
    "valve.area_coefficients": [2e-6, math.pi / 8.0, *[0.0] * 7],
    "cylinder.locked": True,
}
with pytest.MonkeyPatch.context() as _unchecked:
    _unchecked.setattr(printed, "check", lambda _: None)
    PARAMETERS = RigParameters(BACKWARDS)
WITHOUT_THE_CHECK = """
import sys
from rodless_base.start import start
from rodless_sim.physics.valve_assemblies import printed
printed.check = lambda _: None
start(sys.argv.pop(1))
"""
LINE = r"^after 0\.\d+ s: a pressure is not positive .*check .*valve\.area_coefficients[^\n]*$"


@pytest.fixture
def unchecked(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let such parameters pass where a test makes them anew."""
    monkeypatch.setattr(printed, "check", lambda _: None)


def test_such_a_valve_is_refused() -> None:
    """With the check in place no such rig is made; the line names the parameter and the voltage."""
    with pytest.raises(ParameterError, match=r"^valve\.area_coefficients: .* at 10 V: "):
        RigParameters(BACKWARDS)


def test_a_long_advance_ends_where_the_pressure_does() -> None:
    """In one advance of a minute the error shows the state of the first step without pressure.

    Sucked on for the rest of the minute, the chamber would be at minus 0.1 MPa and beyond.
    """
    with pytest.raises(SimulationError, match="a pressure is not positive") as error:
        Rig(PARAMETERS).advance(10.0, 60.0)
    found = re.search(r"pressures (\S+) and (\S+) Pa", str(error.value))
    assert found is not None
    assert -2e4 < min(float(found[1]), float(found[2])) <= 0.0


def run_to_failure(rig: Rig) -> tuple[list[State], str]:
    """Return the states of a rig at 10 V until it fails, and what it says then."""
    states = [rig.state]
    for _ in range(1000):
        try:
            states.append(rig.advance(10.0, PERIOD))
        except SimulationError as error:
            return states, str(error)
    raise AssertionError("it did not fail")


def test_the_rig_says_when_what_and_which_parameter_and_stays_as_it_was() -> None:
    """One line; the last sound state remains, and after a reset the rig runs."""
    rig = Rig(PARAMETERS)
    states, error = run_to_failure(rig)
    assert re.match(LINE, error)
    assert len(states) > 1
    assert rig.state == states[-1]
    assert min(rig.state.pressure_a, rig.state.pressure_b) > 0.0
    rig.reset()
    assert rig.advance(10.0, PERIOD) == states[1]


def test_simulate_and_closed_loop_raise_the_same() -> None:
    """At the sample at which the rig fails when it is stepped by hand."""
    states, by_hand = run_to_failure(Rig(PARAMETERS))
    assert len(states) > 1
    with pytest.raises(SimulationError) as at_once:
        simulate(PARAMETERS, np.full(1000, 10.0), PERIOD)
    assert str(at_once.value) == by_hand
    with pytest.raises(SimulationError, match=LINE):
        closed_loop(PARAMETERS, PidParameters(), references.constant(0.2), 10.0, PERIOD)
    with pytest.raises(SimulationError, match=re.escape(by_hand)):
        closed_loop(PARAMETERS, lambda m, r: 10.0, references.constant(0.2), 10.0, PERIOD)  # noqa: ARG005


def in_lockstep(stamps: list[int]) -> tuple[Engine, Lockstep]:
    """Return a plant that has begun; it notes the stamp of each sample."""
    engine = Engine(
        PARAMETERS.with_values({"time.mode": "lockstep", "time.period": PERIOD}),
        lambda seen, _: stamps.append(seen.stamp),
    )
    plant = Lockstep(
        engine, 1.0, lambda: True, lambda: {b"1": "/controller"}, lambda: 1, Outgoing(), lambda: 0.0
    )
    plant.poll()
    return engine, plant


@pytest.mark.usefixtures("unchecked")
def test_a_step_that_fails_says_so() -> None:
    """In lock-step too: whoever asked would wait for its sample."""
    stamps: list[int] = []
    _, plant = in_lockstep(stamps)
    plant.pause(True)
    said: list[str | None] = []
    while plant.problem is None and len(said) < 1000:
        plant.receive(10.0)
        said.append(plant.step())
    assert re.match(LINE.rstrip("$"), plant.problem or "")
    assert said == [None] * (len(stamps) - 1) + [plant.problem]


@pytest.mark.usefixtures("unchecked")
def test_lockstep_holds_until_a_reset() -> None:
    """No sample answers the command that fails; a reset needs no further answer."""
    stamps: list[int] = []
    engine, plant = in_lockstep(stamps)
    for _ in range(1000):
        plant.receive(10.0)
        if plant.problem is not None:
            break
    assert plant.problem is not None
    assert re.match(LINE.rstrip("$"), plant.problem)
    assert not plant.running
    handed_out = len(stamps)
    plant.receive(10.0)
    plant.pause(True)
    assert plant.step() == plant.problem
    plant.pause(False)
    assert len(stamps) == handed_out
    assert engine.command.voltage(engine.rig.nanoseconds) == 5.08
    assert plant.reset() == "done"
    assert plant.problem is None
    assert stamps[-1] == 0
    plant.receive(10.0)
    assert stamps[-1] == round(PERIOD * 1e9)


@pytest.fixture
def plant(observer: Observer, start_process: StartProcess, tmp_path: Path) -> Iterator[PausedPlant]:
    """Run a plant that only the test commands."""
    values = {"plant": {"time.period": PERIOD, **BACKWARDS}}
    python, *_, module, _, files, path = node_command(
        "plant", [write_parameters(tmp_path / "parameters.yaml", values)]
    )
    assert python == sys.executable
    command = [python, "-c", WITHOUT_THE_CHECK, module, "--ros-args", files, path]
    with start_process(command, "plant"):
        yield PausedPlant(observer)


def test_the_node_reports_the_error_goes_silent_and_runs_again_after_a_reset(
    plant: PausedPlant,
) -> None:
    """/diagnostics goes on with the line as an error; samples end until ~/reset."""
    start = plant.reset()
    first = len(plant.samples)
    answer = Trigger.Response(success=True)
    while answer.success and len(plant.samples) < first + 100:
        plant.command(10.0)
        answer = plant.observer.call(Trigger, "/plant/step")
    assert not answer.success
    assert re.match(LINE.rstrip("$"), answer.message)
    seen = len(plant.samples)
    assert not plant.observer.call(Trigger, "/plant/step").success
    status = plant.diagnostic()
    assert (status.level, status.message) == (DiagnosticStatus.ERROR, answer.message)
    assert len(plant.samples) == seen
    assert plant.reset().position == start.position
    assert plant.diagnostic().message != answer.message
    assert len(plant.steps(1)) == 1
