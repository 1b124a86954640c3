# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A plant that is stopped is missed in every way of starting, and one that is slow never is."""

import signal

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from extent import some_of
from running import StartRig, StartSession
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64
from std_srvs.srv import SetBool, Trigger

from rodless_control import ControllerParameters
from rodless_lab.session.observer import Observer

CLOSED = ControllerParameters().number("controller.neutral_voltage")

STEP = {"reference.type": "step", "reference.at": 0.02, "reference.target": 0.02}


def test_a_lock_step_plant_that_is_stopped_changes_no_number(rig_session: StartSession) -> None:
    """The loss is said and counted; a command that nobody has asked for would shift the loop."""
    runs = []
    for frozen in (False, True):
        rig = rig_session("lockstep", controller=STEP, duration=0.2, paused=True)
        if frozen:
            # A controller that has never had a position has lost none.
            rig.wait_until(
                lambda rig=rig: np.isfinite(rig.samples().voltage[0]), "the answer to sample 0"
            )
            rig.freeze("plant")
            rig.wait_until(lambda rig=rig: rig.counter("controller", "positions lost") == 1, "loss")
            text = "no position: plant stands still"
            assert rig.diagnostics("controller")["message"] == text
            rig.thaw("plant")
        rig.resume()
        runs.append(rig.run())
        if frozen:
            rig.wait_until(
                lambda rig=rig: (
                    rig.diagnostics("controller")["message"] == "in the last 10 s: positions lost"
                ),
                "the plant to be followed",
            )
    for name in ("time", "position", "pressure_a", "voltage"):
        before, after = (getattr(run, name) for run in runs)
        assert np.array_equal(before, after, equal_nan=True), name
    assert len(runs[0]) == 201
    assert np.ptp(runs[0].position) > 1e-3


@pytest.mark.parametrize("use_sim_time", some_of([False, True], 2))
def test_pauses_steps_and_a_stop_are_told_apart_without_a_clock(
    observer: Observer, start_rig: StartRig, use_sim_time: bool
) -> None:
    """Nobody publishes /clock, and the node's own time is the wall clock's or the samples'.

    Paused for longer than every timeout and stepped in between, the plant is not lost; stopped, it
    is, and the valve commanded closed.
    """
    name = f"clockless_{use_sim_time}".lower()
    plant = {"time.publish_clock": False, "time.period": 5e-3}
    # Half a second, the default, may pass on a crowded machine without anything being wrong.
    controller = {"use_sim_time": use_sim_time, "controller.position_timeout": 1.5}
    with start_rig(namespace=name, plant=plant, controller=controller) as processes:
        commands = observer.collect(Float64, f"/{name}/valve/voltage")
        samples = observer.collect(JointState, f"/{name}/joint_states")
        observer.more(samples, 100)
        assert observer.call(SetBool, f"/{name}/plant/pause", data=True).success
        for _ in range(3):
            for _ in range(3):
                observer.diagnostic(f"/{name}/controller", fresh=True)
            assert observer.call(Trigger, f"/{name}/plant/step").success
        assert observer.counter(f"/{name}/controller", "positions lost", fresh=True) == 0
        assert observer.call(SetBool, f"/{name}/plant/pause", data=False).success
        observer.publisher(Float64, f"/{name}/setpoint").publish(Float64(data=0.15))
        observer.wait(lambda: samples[-1].position[0] > 0.01, "the carriage in mid-move")
        processes["plant"].signal(signal.SIGSTOP)
        try:
            observer.wait(
                lambda: {command.data for command in commands[-5:]} == {CLOSED}, "a closed valve"
            )
            status = observer.diagnostic(f"/{name}/controller", fresh=True)
            assert status.level == DiagnosticStatus.ERROR
            assert status.values["positions lost"] == "1"
        finally:
            processes["plant"].signal(signal.SIGCONT)
        observer.wait(lambda: abs(samples[-1].position[0] - 0.15) < 2e-4, "the carriage to come")


def test_a_slow_plant_is_not_lost(observer: Observer, start_rig: StartRig) -> None:
    """One sample a second, ten times the timeout: without its reports it would be lost."""
    plant = {"time.speed": 5e-3, "time.period": 5e-3}
    with start_rig(namespace="slow", plant=plant):
        observer.more(observer.collect(JointState, "/slow/joint_states"), 6)
        status = observer.diagnostic("/slow/controller", fresh=True)
        assert status.values["positions lost"] == "0"
        assert status.level == DiagnosticStatus.OK
        assert observer.diagnostic("/slow/plant").values["Target frequency (Hz)"] == "1"
