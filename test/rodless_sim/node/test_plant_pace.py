# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What running nodes say of themselves: ready, and whether plant time keeps up."""

from diagnostic_msgs.msg import DiagnosticStatus
from extent import extensive
from running import StartProcess, until_it_says
from std_srvs.srv import SetBool, Trigger

from rodless_lab.session.observer import Observer

# Ten times real time at 10 kHz: 100 000 samples a second, more than any machine publishes.
IMPOSSIBLE = {"time.speed": 10.0, "time.period": 1e-4}


@extensive
def test_a_plant_that_cannot_keep_up_warns_once_and_shows_by_how_much(
    observer: Observer, start_node: StartProcess
) -> None:
    """One warning with the way out; the lag grows with each report, and stops in a pause.

    After a reset the plant is judged anew, and warns again.
    """
    with start_node("plant", IMPOSSIBLE, namespace="hasty") as process:
        until_it_says(process, "plant time falls behind")
        lags = []
        for _ in range(3):
            observer.diagnostic("/hasty/plant", fresh=True)
            lags.append(observer.counter("/hasty/plant", "lag (s)"))
        assert lags[0] > 0.0
        assert lags == sorted(set(lags))
        assert 0.0 < observer.counter("/hasty/plant", "speed factor") < 9.5
        status = observer.diagnostic("/hasty/plant")
        assert status.level == DiagnosticStatus.WARN
        assert status.message == "plant time falls behind; in the last 10 s: overruns"
        assert observer.call(SetBool, "/hasty/plant/pause", data=True).success
        observer.diagnostic("/hasty/plant", fresh=True)
        status = observer.diagnostic("/hasty/plant", fresh=True)
        assert status.level == DiagnosticStatus.WARN
        assert status.message == "paused; in the last 10 s: overruns"
        assert process.output.count("plant time falls behind") == 1
        held = observer.counter("/hasty/plant", "lag (s)")
        assert observer.counter("/hasty/plant", "speed factor", fresh=True) == 0.0
        assert observer.counter("/hasty/plant", "lag (s)") == held
        assert observer.call(Trigger, "/hasty/plant/reset").success
        assert observer.call(SetBool, "/hasty/plant/pause", data=False).success
        observer.wait(
            lambda: "falls behind" in observer.diagnostic("/hasty/plant").message,
            "what was forgotten by the reset to be noticed anew",
        )
    assert process.output.count("plant time falls behind") == 2
    assert "take a longer time.period or a smaller time.speed" in process.output


def test_nodes_say_once_that_they_are_ready_and_what_to_do_next(start_node: StartProcess) -> None:
    """Names are those of their namespace; what is said after that comes from running."""
    with start_node("plant", {"time.period": 0.01}, namespace="one") as plant:
        until_it_says(plant, "ready: realtime, 100 Hz, supply 0.520 MPa gauge, preset paper")
        with start_node("controller", namespace="one") as controller:
            until_it_says(controller, "rodless move 58 --namespace /one")
        with start_node("controller", {"reference.type": "sine"}, namespace="one") as sine:
            until_it_says(sine, "law pid, reference sine; it moves by itself")
    assert plant.output.count("ready: ") == 1
    assert "waiting for commands on /one/valve/voltage" in plant.output
    assert controller.output.count("started: ") == controller.output.count("ready: ") == 1
    assert "ready: realtime, plant's preset paper, 100 Hz, law pid, " in controller.output
    assert "reference setpoint; move it with a set-point on /one/setpoint" in controller.output
