# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Lock-step runs repeat bit for bit, whatever the machine does and however they are run."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from busy import busy_cores
from extent import EXTENSIVE, also

from rodless_base.constants import CLOSED_VOLTAGE
from rodless_control import PidParameters, references
from rodless_lab.bags.reader import Bag, read_bag
from rodless_lab.cli.replay import replay
from rodless_lab.runs.from_bag import read_run
from rodless_lab.session.domain import own_domain
from rodless_lab.session.observer import Observer
from rodless_lab.session.processes import ProcessPlan, run_rig
from rodless_lab.session.session import RigSession
from rodless_lab.simulation.closed_loop import closed_loop
from rodless_sim import RigParameters
from rodless_sim.instruments.instruments import DATA_SHEET

pytestmark = [pytest.mark.ros, pytest.mark.slow]

# Runs that are left to make test-extensive.
LEFT_OUT = ("second", "one_process", "noisy_one_process")

DURATION = 1.5
SAMPLES = 1501

# Against hanging for ever; the run takes about a second, starting it a few.
TIMEOUT = 180.0


def record_run(
    bag: Path, one_process: bool = False, sensors: Mapping[str, object] | None = None
) -> Bag:
    """Record a lock-step run from sample 0 to its last command."""
    with RigSession(
        "lockstep",
        duration=DURATION,
        plant=sensors,
        controller={"reference.type": "step", "reference.at": 0.1},
        one_process=one_process,
        timeout=TIMEOUT,
        bag=bag,
        bag_topics=["/clock"],
    ) as rig:
        rig.run()
    return read_bag(bag)


def record_itself(bag: Path) -> Bag:
    """Let one process record the same run of its own."""
    plan = ProcessPlan(
        plant={"time.mode": "lockstep", "time.duration": DURATION},
        controller={"reference.type": "step", "reference.at": 0.1},
        one_process=True,
        record=bag,
    )
    with (
        own_domain() as environment,
        run_rig(plan, environment) as processes,
        Observer(environment, timeout=TIMEOUT, check=processes.check) as observer,
    ):
        observer.wait(
            lambda: observer.diagnostic("/plant", fresh=True).message == "ended", "the end"
        )
    return read_bag(bag)


def recordings(bag: Bag) -> dict[str, Any]:
    """What ``bag`` holds, by topic."""
    return {topic: bag[topic] for topic in bag.topics}


@pytest.fixture(scope="module")
def bags(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Bag]:
    """The same run: twice, under load, in one process that is recorded or records itself.

    And twice with the paper's sensors.
    """
    folder = tmp_path_factory.mktemp("bags")
    runs = {"first": record_run(folder / "first")}
    with busy_cores(TIMEOUT):
        runs["loaded"] = record_run(folder / "loaded")
    runs["itself"] = record_itself(folder / "itself")
    runs["noisy"] = record_run(folder / "noisy", sensors=DATA_SHEET)
    if EXTENSIVE:
        runs["second"] = record_run(folder / "second")
        runs["one_process"] = record_run(folder / "one_process", one_process=True)
        runs["noisy_one_process"] = record_run(folder / "noisy_1", True, DATA_SHEET)
    return runs


@pytest.mark.parametrize("name", ["first", "loaded", "itself", "noisy", *map(also, LEFT_OUT)])
def test_no_sample_is_missing(bags: dict[str, Bag], name: str) -> None:
    """Every bag holds samples 0 to N of each topic once, at the plant times k periods."""
    found = recordings(bags[name])
    assert len(found.pop("/setpoint", [])) == 0
    assert found.pop("/faults").log_time.tolist() == [0]
    assert len(found) == 7
    for topic, recording in found.items():
        assert len(recording) == SAMPLES, topic
        assert recording.log_time.tolist() == [k * 1_000_000 for k in range(SAMPLES)], topic


@pytest.mark.parametrize(
    ("name", "model"),
    [
        also("second", "first"),
        ("loaded", "first"),
        also("one_process", "first"),
        ("itself", "first"),
        also("noisy_one_process", "noisy"),
    ],
)
def test_payloads_are_equal_byte_for_byte(bags: dict[str, Bag], name: str, model: str) -> None:
    """All messages of all topics equal those of the other run, serialised."""
    # Nobody has offered set-points to the run that was alone.
    offered = {"/setpoint"} if name == "itself" else set()
    assert set(bags[name].topics) | offered == set(bags[model].topics)
    for topic, recording in recordings(bags[name]).items():
        if topic == "/faults":  # with padding, which rclpy leaves as it was in memory
            assert recording.messages == bags[model][topic].messages
            continue
        assert list(recording.payloads) == list(bags[model][topic].payloads), topic


@pytest.mark.parametrize(("name", "sensors"), [("first", {}), ("noisy", DATA_SHEET)])
def test_in_process_loop_gives_the_same_numbers(
    bags: dict[str, Bag], name: str, sensors: Mapping[str, object]
) -> None:
    """Position, velocity, pressures and voltage are those of closed_loop, to the last bit."""
    run = closed_loop(
        RigParameters.preset("paper").with_values(sensors),
        PidParameters.preset("paper"),
        references.step(0.0, 0.058, at=0.1),
        DURATION,
        1e-3,
    )
    bag = bags[name]
    for topic, field, expected in (
        ("/joint_states", "position", run.position),
        ("/joint_states", "velocity", run.velocity),
        ("/joint_states", "effort", run.force),
        ("/chamber_a/pressure", "fluid_pressure", run.pressure_a),
        ("/chamber_b/pressure", "fluid_pressure", run.pressure_b),
        ("/valve/voltage", "data", run.voltage),
        # What was held up to each sample; before the first the valve was closed.
        ("/valve/state", "effort", np.append(CLOSED_VOLTAGE, run.voltage[:-1])),
    ):
        assert np.array_equal(bag[topic].fields[field].ravel(), expected), (topic, field)


def test_pressures_state_the_variance_of_their_noise(bags: dict[str, Bag]) -> None:
    """200 Pa squared with the paper's instruments; 0, which stands for unknown, with ideal ones."""
    for name, variance in (("first", 0.0), ("noisy", 4e4)):
        for topic in ("/chamber_a/pressure", "/chamber_b/pressure", "/supply/pressure"):
            assert np.all(bags[name][topic].fields["variance"] == variance), (name, topic)
    supply = bags["noisy"]["/supply/pressure"].fields["fluid_pressure"].ravel()
    assert np.std(supply) == pytest.approx(200.0, rel=0.1)
    assert abs(np.mean(supply) - 621325.0) <= 5e3


def test_replay_of_the_bag_gives_what_it_holds(bags: dict[str, Bag]) -> None:
    """The plant fed with a bag's voltages from its start passes through the recorded states."""
    recorded = read_run(bags["first"].path)
    replayed = replay(RigParameters.preset("paper"), recorded)
    assert np.abs(replayed.position - recorded.position).max() < 1e-9
    assert np.abs(replayed.pressure_a - recorded.pressure_a).max() < 1e-3
    assert np.abs(replayed.pressure_b - recorded.pressure_b).max() < 1e-3
    assert np.ptp(recorded.position) > 0.05
