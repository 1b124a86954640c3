# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless status` and what `rodless rig` says when it is ready."""

import json
import re
import signal

import pytest
from extent import also, extensive
from running import StartProcess, StartRig, until_it_says
from std_srvs.srv import SetBool

from rodless_lab.session.observer import Observer


def test_a_rig_that_runs_is_shown_on_one_screen_and_as_json(
    rodless: StartProcess, start_rig: StartRig, observer: Observer
) -> None:
    """Exit code 0; what it shows is what the topics carry; a pause shows, and a sensor gone."""
    # A busy machine must not close the valve, which is an error.
    plant = {"time.period": 0.01, "valve.command_timeout": 30.0}
    plant["fault.pressure_b.sensor"] = "gone"
    controller = {"controller.position_timeout": 30.0}
    with start_rig(plant=plant, controller=controller, namespace="up"):
        observer.wait(
            lambda: observer.diagnostic("/up/controller", fresh=True).message == "controlling",
            "the controller to control",
        )
        with rodless("status", "--namespace", "up") as screen:
            assert screen.wait() == 0, screen.output
        with rodless("status", "--namespace", "up", "--json") as machine:
            assert machine.wait() == 0
        assert observer.call(SetBool, "/up/plant/pause", data=True).success
        observer.diagnostic("/up/plant", fresh=True)
        with rodless("status", "--namespace", "up") as paused:
            paused.wait()
    assert "rig           /up, realtime, running" in screen.output
    assert "controller    OK: controlling" in screen.output
    assert "position      0.000 mm" in screen.output
    assert "supply        0.520 MPa gauge, 0.621 MPa absolute" in screen.output
    assert "chamber B     -\n" in screen.output
    assert "NaN" not in machine.output
    found = json.loads(machine.output)
    assert found["readings"]["pressure_b"] is None
    assert found["namespace"] == "/up"
    assert found["readings"]["supply_pressure"] == pytest.approx(621325.0)
    assert found["readings"]["time"] > 0.0
    assert found["readings"]["reference"] == pytest.approx(0.0, abs=1e-6)
    assert found["nodes"]["controller"]["level"] == "OK"
    assert float(found["nodes"]["plant"]["values"]["speed factor"]) > 0.0
    assert "rig           /up, realtime, paused" in paused.output
    for reading in ("plant time", "position", "reference", "chamber A", "supply"):
        assert f"{reading:14}-" not in paused.output, reading


@extensive
def test_gauge_pressures_count_from_the_atmosphere_of_the_rig(
    rodless: StartProcess, start_node: StartProcess
) -> None:
    """At 1,500 m, where the air has 84 kPa: what the plant says when it is ready, `status` says."""
    values = {"time.period": 0.01, "atmosphere.pressure": 84e3, "supply.pressure": 604e3}
    with start_node("plant", values, namespace="high") as plant:
        until_it_says(plant, "supply 0.520 MPa gauge")
        with rodless("status", "--namespace", "high", "--timeout", "6") as status:
            status.wait()
    assert "supply        0.520 MPa gauge, 0.604 MPa absolute" in status.output
    lines = re.findall(r"(\S+) MPa gauge, (\S+) MPa absolute", status.output)
    assert [float(absolute) - float(gauge) for gauge, absolute in lines] == pytest.approx(
        3 * [0.084], abs=1.1e-3
    )


@extensive
def test_a_missing_controller_and_a_missing_rig_are_shown(
    rodless: StartProcess, start_node: StartProcess
) -> None:
    """Exit code 1 and the way out."""
    with start_node("plant", {"time.period": 0.01}, namespace="half") as plant:
        until_it_says(plant, "ready: ")
        with rodless("status", "--namespace", "half", "--timeout", "6") as status:
            assert status.wait() == 1
        assert "rig           /half, realtime, running" in status.output
        assert "controller    missing" in status.output
        assert "no controller in namespace /half" in status.output
        with rodless("reset", "--namespace", "half") as reset:
            assert reset.wait() == 0
        left_out = "controller/reset: left out, no controller was found\n"
        assert reset.output == f"{left_out}plant/reset: done\n"
    with rodless("status", "--namespace", "empty", "--timeout", "1") as status:
        assert status.wait() == 1
    assert "no plant in namespace /empty" in status.output


@pytest.mark.parametrize(
    ("options", "line"),
    [
        also(
            "--namespace left",
            "ready: preset paper, real time. Move: rodless move 58 --namespace /left. "
            "State: rodless status --namespace /left. Stop: Ctrl-C.\n",
        ),
        (
            "--lockstep --preset calibrated",
            "ready: preset calibrated, lock-step. Move: rodless move 58. State: rodless status. ",
        ),
        (
            "--without-controller --namespace bare",
            "ready: preset paper, real time. Commands are expected on /bare/valve/voltage. State: ",
        ),
        also(
            "--without-controller --lockstep",
            "ready: preset paper, lock-step. Waiting for a subscriber to /joint_states and "
            "one publisher on /valve/voltage. State: rodless status. ",
        ),
    ],
)
def test_rig_says_when_it_is_ready_and_what_to_do_next(
    rodless: StartProcess, options: str, line: str
) -> None:
    """One line, once the nodes work; Ctrl-C still ends all with 0."""
    with rodless("rig", *options.split()) as rig:
        until_it_says(rig, line, 180.0)  # the first start compiles
        rig.signal(signal.SIGINT)
        assert rig.wait(8.0) == 0
    assert rig.output.count("ready: preset") == 1
