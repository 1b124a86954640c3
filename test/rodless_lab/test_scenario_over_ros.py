# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A scenario over topics: the numbers of Python, and what is said of its faults."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from extent import some_of

from rodless_control import PidParameters, references
from rodless_lab.bags.reader import Bag, read_bag
from rodless_lab.session.samples import Samples
from rodless_lab.session.session import RigSession
from rodless_lab.simulation.closed_loop import ClosedLoopTrace, closed_loop
from rodless_sim import RigParameters, Scenario, ScenarioError
from rodless_sim.instruments.instruments import DATA_SHEET

pytestmark = [pytest.mark.ros, pytest.mark.slow]

DURATION = 1.2
SENSORS = {**DATA_SHEET, "sensors.delay": 1.5e-3}
STEP = {"reference.type": "step", "reference.at": 0.1}
GONE = slice(500, 700)

SCENARIO = """
- {at: 0.0, fault.position.offset: 1.0e-3}
- {at: 0.3, fault.valve.offset: 0.05, fault.pressure_a.noise: 300.0}
- {at: 0.5, fault.position.sensor: gone}
- {at: 0.7, fault.position.sensor: works, fault.piston.leak: 1.0e-7}
- {at: 0.9, fault.supply.loss: 0.5, sensors.pressure_lag: 0.01}
"""


class Done(NamedTuple):
    """A run of the nodes, and the same in Python."""

    seen: Samples
    bag: Bag
    expected: ClosedLoopTrace
    said: dict[str, dict[str, str]]  # by status of /diagnostics at the end
    output: str  # of the nodes
    loss: object  # fault.supply.loss, as the plant shows it at the end


@pytest.fixture(
    scope="module", params=some_of([False, True], 2), ids=["two processes", "one process"]
)
def done(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Done:
    """Run it once: all that is asked of it can be read from what remains."""
    folder = tmp_path_factory.mktemp("scenario")
    path = folder / "mine.yaml"
    path.write_text(SCENARIO, encoding="utf-8")
    said: dict[str, dict[str, str]] = {}

    def hear(message: Any) -> None:
        for status in message.status:
            values = {pair.key: pair.value for pair in status.values}
            said[status.name] = {**values, "level": status.level.hex(), "said": status.message}

    with RigSession(
        "lockstep",
        plant={**SENSORS, "sensors.publish_truth": True, "sensors.publish_raw": True},
        controller=STEP,
        scenario=path,
        duration=DURATION,
        one_process=request.param,
        telemetry=True,
        bag=folder / "bag",
    ) as rig:
        seen = rig.run()
        rig.observer.subscribe(DiagnosticArray, "/diagnostics", hear)
        rig.wait_until(lambda: said.get("/plant", {}).get("said") == "ended", "the end")
        name = "fault.supply.loss"
        rig.wait_until(lambda: rig.parameters("plant", [name])[name] == 0.5, "the parameter")
        loss = rig.parameters("plant", [name])[name]
    expected = closed_loop(
        RigParameters(SENSORS),
        PidParameters(),
        references.step(0.0, 0.058, at=0.1),
        DURATION,
        1e-3,
        scenario=Scenario.from_file(path),
    )
    output = "\n".join(rig.outputs.values())
    return Done(seen, read_bag(folder / "bag"), expected, said, output, loss)


def test_the_numbers_are_those_of_python(done: Done) -> None:
    """Readings, commands and the law's terms, bit for bit, the samples without a position too."""
    assert len(done.seen) == 1201
    for name in ("position", "pressure_a", "pressure_b", "velocity", "force"):
        found, expected = getattr(done.seen, name), getattr(done.expected, name)
        assert np.array_equal(found, expected, equal_nan=True), name
    # The node answers the last sample after the run.
    assert np.array_equal(done.seen.voltage[:-1], done.expected.voltage[:-1])
    for name in ("error", "p", "i", "d"):
        found, expected = getattr(done.seen, name), done.expected.columns()[name]
        assert np.array_equal(found[:-1], expected[:-1], equal_nan=True), name
    assert np.all(np.isnan(done.seen.position[GONE]))
    assert np.all(done.seen.voltage[GONE] == 5.08)
    assert not np.isnan(np.delete(done.seen.position, np.r_[GONE])).any()


def test_the_bag_says_which_faults_were_active_when(done: Done) -> None:
    """One message for each change, stamped with the first sample of it."""
    messages = done.bag["/faults"].messages
    stamps = [m.header.stamp.sec * 1000 + m.header.stamp.nanosec * 1e-6 for m in messages]
    assert stamps == [0, 300, 500, 700, 900]
    statuses = [message.status[0] for message in messages]
    assert {(status.name, status.level) for status in statuses} == {("/plant: faults", b"\x01")}
    assert statuses[0].message == "fault.position.offset 0.001 m"
    found = [{pair.key: pair.value for pair in status.values} for status in statuses]
    assert found[2]["fault.position.sensor"] == "gone"
    assert "fault.position.sensor" not in found[3]
    assert found[4]["fault.supply.loss"] == "0.5"


def test_diagnostics_log_and_parameters_say_it(done: Done) -> None:
    """The plant warns of each change and shows what is active; the controller says what it does."""
    assert done.said["/plant: faults"]["level"] == "01"
    assert done.said["/plant: faults"]["fault.supply.loss"] == "0.5"
    assert "fault.valve.offset 0.05 V" in done.said["/plant"]["faults"]
    assert done.loss == 0.5
    assert "scenario at 0.5 s: fault.position.sensor gone" in done.output
    # Once a second of the wall clock, which a busy machine needs for some of the 200 samples.
    assert 1 <= done.output.count("position not finite: valve closed") < 100


def test_truth_and_voltages_are_in_the_bag(done: Done) -> None:
    """The truth has no error, and the voltages are those that the readings stand for."""
    names = ("/joint_states", "/truth/joint_states", "/raw/voltages", "/chamber_a/pressure")
    read, true, raw, pressure = (done.bag[name].messages for name in names)
    assert len(read) == len(true) == len(raw) == len(pressure) == 1201
    assert [m.header.stamp for m in true] == [m.header.stamp for m in raw]
    assert list(raw[0].name) == ["position", "pressure_a", "pressure_b", "supply_pressure"]
    volts = np.array([message.effort for message in raw])
    # Table 1: 1-5 V for 0.2 m and for 1 MPa, 305 µV a bit.
    positions = np.array([message.position[0] for message in read])
    assert volts[:, 0] == pytest.approx(1.0 + 20.0 * positions, abs=1e-12, nan_ok=True)
    pressures = np.array([message.fluid_pressure for message in pressure])
    assert volts[:, 1] == pytest.approx(1.0 + 4e-6 * pressures, abs=1e-12)
    bits = volts[:, 1] / (20.0 / 2**16)
    assert bits == pytest.approx(np.round(bits), abs=1e-6)
    truth = np.array([message.position[0] for message in true])
    assert np.diff(truth).max() < 1e-3
    # At rest 1 mm of the fault, and at the most 0.1 mm of linearity, 10 µm and noise.
    assert np.abs(positions - truth - 1e-3)[:90].max() < 2.2e-4


def test_a_scenario_that_is_none_is_refused_before_anything_starts(tmp_path: Path) -> None:
    """The line names file and entry."""
    path = tmp_path / "bad.yaml"
    path.write_text("- {at: 1, fault.valve.offset: 100}", encoding="utf-8")
    with pytest.raises(ScenarioError, match=r"bad\.yaml: entry 1: fault\.valve\.offset: 100"):
        RigSession(scenario=path)
