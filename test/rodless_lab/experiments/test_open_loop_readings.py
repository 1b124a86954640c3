# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Open-loop runs of an experiment are measurements, the same ones in process and over ROS."""

import numpy as np
import pytest
from extent import extensive

from rodless_lab.experiments import friction, friction_campaign
from rodless_lab.experiments.ros_runner import nodes_runner
from rodless_lab.experiments.runner import IN_PROCESS
from rodless_sim import Rig, RigParameters, simulate

PERIOD = 1e-3
VOLTAGES = np.repeat([6.5, 3.5], 150)

# The converter's 16 bits over 20 V, of which 4 V stand for 0.2 m.
STEP_OF_THE_CONVERTER = 20.0 / 2**16 * 0.2 / 4.0


def test_an_open_loop_run_reads_what_a_rig_reads_step_by_step() -> None:
    """Of the preset with instruments, each reading is that of `Rig.read`, and the rest is true."""
    parameters = RigParameters.preset("calibrated")
    run = IN_PROCESS.open_loop(parameters, VOLTAGES, PERIOD, 0.05)
    rig = Rig(parameters)
    rig.reset(0.05)
    seen = [rig.read()]
    for voltage in VOLTAGES:
        rig.advance(voltage, PERIOD)
        seen.append(rig.read())
    for name in ("position", "pressure_a", "pressure_b"):
        assert np.array_equal(getattr(run, name), [getattr(one, name) for one in seen]), name
    true = simulate(parameters, VOLTAGES, PERIOD, 0.05)
    for name in ("time", "velocity", "voltage", "mass_flow_a", "temperature_a"):
        assert np.array_equal(getattr(run, name), getattr(true, name)), name
    assert len(run.position) == len(VOLTAGES) + 1


def test_an_open_loop_run_shows_the_steps_of_the_converter() -> None:
    """Without noise a position is a whole number of the converter's steps from 0."""
    parameters = RigParameters.preset("calibrated").with_values({"sensors.position_noise": 0.0})
    run = IN_PROCESS.open_loop(parameters, VOLTAGES, PERIOD, 0.05)
    volts = 1.0 + run.position * 4.0 / 0.2
    steps = volts * 2**16 / 20.0
    assert np.abs(steps - np.rint(steps)).max() < 1e-6
    true = simulate(parameters, VOLTAGES, PERIOD, 0.05)
    assert np.ptp(run.position - true.position) > STEP_OF_THE_CONVERTER / 2.0


def test_a_rig_with_ideal_instruments_is_seen_as_it_is() -> None:
    """The run of the preset `paper`, whose instruments are ideal, is that of `simulate`."""
    parameters = RigParameters.preset("paper")
    seen, true = (run(parameters, VOLTAGES, PERIOD) for run in (IN_PROCESS.open_loop, simulate))
    for name, values in true.columns().items():
        assert np.array_equal(getattr(seen, name), values), name


@extensive
@pytest.mark.ros
def test_the_mean_speeds_of_friction_are_the_same_over_ros(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The runs of `calibrated`, shortened to 1.5 s: samples, lengths and speeds, to the last bit.

    The end is so near that a run is cut by what is read, and not by time.
    """
    monkeypatch.setattr(friction_campaign, "LONGEST", 1.5)
    monkeypatch.setattr(friction_campaign, "END", 0.025)
    over_ros = nodes_runner()
    speeds = [friction.mean_speeds("calibrated", where) for where in (IN_PROCESS, over_ros)]
    assert speeds[0] == speeds[1]
    rig = RigParameters.preset("calibrated")
    cut = [friction_campaign.constant_run(rig, 4.395, where) for where in (IN_PROCESS, over_ros)]
    assert len(cut[0].time) == len(cut[1].time) < 1500
    for name in ("time", "position", "velocity", "pressure_a", "pressure_b", "voltage", "force"):
        assert np.array_equal(getattr(cut[0], name), getattr(cut[1], name)), name
