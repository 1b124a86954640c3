# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless set`: parameters of a running rig, all or none."""

from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest
from extent import extensive
from running import StartProcess, StartRig, until_it_says
from std_msgs.msg import Float64

from rodless_lab.session.errors import WaitTimeoutError
from rodless_lab.session.observer import Observer
from rodless_lab.session.processes import node_command, write_parameters
from rodless_lab.session.running_rig import RunningRig
from rodless_lab.session.set_parameters import failed_law

PLANT = (
    "supply.pressure",
    "friction.forward.static",
    "friction.forward.coulomb",
    "cylinder.locked",
)
CONTROLLER = ("controller.kp", "reference.type")


@pytest.fixture(scope="module", autouse=True)
def rig(start_rig: StartRig) -> Iterator[None]:
    """Run a rig in a namespace of its own."""
    with start_rig(plant={"time.period": 0.01}, namespace="right") as processes:
        for node in processes.names:
            until_it_says(processes[node], "ready: ")
        yield


def values(observer: Observer) -> dict[str, object]:
    """What both nodes have now."""
    return {
        **observer.get_parameters("/right/plant", PLANT),
        **observer.get_parameters("/right/controller", CONTROLLER),
    }


def run(rodless: StartProcess, *arguments: str) -> tuple[int, str]:
    """Run `rodless set`; return exit code and output."""
    with rodless("set", *arguments, "--namespace", "/right") as process:
        code = process.wait()
        return code, process.output


def test_parameters_of_both_nodes_change_in_one_call(
    rodless: StartProcess, observer: Observer
) -> None:
    """Texts take the parameter's type; old and new are shown; a pair that only fits together is."""
    code, output = run(
        rodless,
        "supply.pressure=600000",
        "friction.forward.static=50",
        "friction.forward.coulomb=40",
        "cylinder.locked=true",
        "controller:controller.kp=700",
        "reference.type=ramp",
    )
    assert code == 0, output
    assert values(observer) == {
        "supply.pressure": 600000.0,
        "friction.forward.static": 50.0,
        "friction.forward.coulomb": 40.0,
        "cylinder.locked": True,
        "controller.kp": 700.0,
        "reference.type": "ramp",
    }
    assert "plant supply.pressure: 621325.0 → 600000.0\n" in output
    assert "plant cylinder.locked: false → true\n" in output
    assert "controller reference.type: setpoint → ramp\n" in output


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ("supply.pressure=500000 controller.kp=-1", "controller.kp"),
        ("controller.kp=500 supply.pressure=90000", "below atmosphere.pressure"),
        ("controller.kp=500 supply.pressure=2e9", "supply.pressure"),
        ("supply.pressure=500000 supply.presure=1", "did you mean supply.pressure?"),
        ("supply.pressure=500000 controller.kp=much", "'much' refused, must be a number"),
        ("supply.pressure=500000 plant:controller.kp=1", "no such parameter on plant"),
        ("supply.pressure=500000 use_sim_time=false", "plant:use_sim_time"),
        ("supply.pressure=500000 valve:controller.kp=1", "no node valve"),
        ("supply.pressure=500000 reference.type=steps", "reference.type"),
    ],
)
def test_one_refusal_means_that_nothing_changes_on_any_node(
    rodless: StartProcess, observer: Observer, changes: str, words: str
) -> None:
    """Exit code 2 and one line with the reason, whichever node it is that refuses."""
    before = values(observer)
    code, output = run(rodless, *changes.split())
    assert code == 2
    assert words in output
    assert len(output.splitlines()) == 1
    assert values(observer) == before


@extensive
def test_a_rig_that_is_not_there_is_named(rodless: StartProcess) -> None:
    """Exit code 2 within the time given, and where there is a rig."""
    with rodless("set", "supply.pressure=5e5", "--timeout", "6") as process:
        assert process.wait() == 2
    assert "no plant in namespace / of ROS domain" in process.output
    assert "there is one in /right: use --namespace" in process.output


def test_what_is_got_can_be_set(rodless: StartProcess, observer: Observer) -> None:
    """Single names, or all: one NAME=VALUE a line, with the node where both have the name."""
    with rodless("get", "cylinder.locked", "reference.type", "--namespace", "/right") as got:
        assert got.wait() == 0
    locked, kind = got.output.splitlines()
    now = values(observer)
    assert locked == f"cylinder.locked={str(now['cylinder.locked']).lower()}"
    assert kind == f"reference.type={now['reference.type']}"
    with rodless("get", "--namespace", "/right") as everything:
        assert everything.wait() == 0
    lines = everything.output.splitlines()
    assert {locked, kind, "plant:use_sim_time=false"} <= set(lines)
    assert len(lines) == len(set(lines)) > len(now)
    changeable = [line for line in lines if line.startswith(("friction.forward.", "controller.k"))]
    code, output = run(rodless, *changeable)
    assert code == 0, output
    assert len(changeable) > 5
    with rodless("get", "supply.presure", "--namespace", "/right") as wrong:
        assert wrong.wait() == 2
    assert "did you mean supply.pressure?" in wrong.output


def test_a_refusal_that_only_the_node_can_give_takes_the_other_back(
    rodless: StartProcess, observer: Observer
) -> None:
    """The set-point in force is beyond the new limit: that is said, and the plant is as it was."""
    change = {"reference.type": "setpoint"}
    observer.set_parameters("/right/controller", change)
    references = observer.collect(Float64, "/right/controller/reference")
    observer.publisher(Float64, "/right/setpoint").publish(Float64(data=0.15))
    observer.wait(lambda: references and references[-1].data == 0.15, "the set-point in force")
    before = values(observer)
    code, output = run(rodless, "reference.maximum=0.1", "supply.pressure=550000")
    assert code == 2
    assert output == (
        "controller: reference.maximum: 0.1 m refused, the set-point in force is 0.15 m; send "
        "another set-point first; nothing has changed\n"
    )
    assert values(observer) == before
    assert run(rodless, "reference.maximum=0.16")[0] == 0


def test_a_law_comes_with_its_gains_in_one_command(
    rodless: StartProcess, observer: Observer
) -> None:
    """Another law and what only that has, and back; what the law would not have changes nothing."""
    code, output = run(rodless, "state_feedback.velocity_gain=3", "controller.law=state_feedback")
    assert code == 0, output
    assert "controller controller.law: pid → state_feedback\n" in output
    assert "controller state_feedback.velocity_gain: none → 3.0\n" in output
    found = observer.get_parameters(
        "/right/controller", ["controller.law", "state_feedback.velocity_gain"]
    )
    assert found == {"controller.law": "state_feedback", "state_feedback.velocity_gain": 3.0}
    for change, words in {
        "controller.kp=x": "'x' refused, must be a number",
        "controller.kp=-1": "controller.kp: -1.0 refused",
        "state_feedback.velocity_gain=4": "belongs to the law state_feedback",
        "supply.pressure=1": "supply.pressure",
    }.items():
        code, output = run(rodless, "controller.law=pid", change)
        assert (code, len(output.splitlines())) == (2, 1), output
        assert words in output
        assert observer.get_parameters("/right/controller", list(found)) == found
    code, output = run(rodless, "controller:controller.law=pid", "controller.kp=650")
    assert code == 0, output
    assert observer.get_parameters("/right/controller", ["controller.law", "controller.kp"]) == {
        "controller.law": "pid",
        "controller.kp": 650.0,
    }


@extensive
def test_a_law_that_fails_with_the_new_values_is_reported(
    rodless: StartProcess, start_process: StartProcess, tmp_path: Path
) -> None:
    """Exit code 1 and the law's own words: the parameters are in force and the valve is closed."""
    (tmp_path / "brittle.py").write_text(BRITTLE, encoding="utf-8")
    parameters = {"controller.law": "brittle:Brittle"}
    file = write_parameters(tmp_path / "law.yaml", {"controller": parameters})
    command = node_command("controller", [file], "/brittle")
    with start_process(command, "controller", {"PYTHONPATH": str(tmp_path)}) as controller:
        until_it_says(controller, "started: ")
        with rodless("set", "brittle.gain=20", "--namespace", "/brittle") as fits:
            assert fits.wait() == 0, fits.output
        with rodless("set", "brittle.gain=90", "--namespace", "/brittle") as fails:
            assert fails.wait() == 1, fails.output
    assert "controller brittle.gain: 20.0 → 90.0\n" in fails.output
    assert "Brittle failed: ValueError: too much for me" in fails.output
    assert "; the new values are in force\n" in fails.output


def test_a_controller_that_says_nothing_after_a_change_is_told_of() -> None:
    """The change is in force: that its law may not return is no reason to say that none is made."""

    def silent(*_: object) -> None:
        raise WaitTimeoutError("timed out")

    for answer in (silent, lambda *_: {"controller.law": "mine:Law"}):
        observer = SimpleNamespace(get_parameters=answer)
        rig = SimpleNamespace(observer=observer, next_diagnostic=lambda *_: None)
        said = failed_law(cast(RunningRig, rig))
        assert said == "does not answer any more; its law may not return"


BRITTLE = """
from rodless_base.parameters import Parameter, declare
from rodless_control import Law


class Brittle(Law):
    PARAMETERS = declare(Parameter("brittle.gain", 1.0, "V/m", "gain", "tuned", 0.0, 100.0))

    def configure(self, parameters):
        if parameters["brittle.gain"] > 50.0:
            raise ValueError("too much for me")

    def update(self, measurement, reference, interval):
        return 5.08
"""


def test_faults_are_made_shown_and_cleared(rodless: StartProcess) -> None:
    """`rodless fault` names those that are active, `rodless status` too; cleared, none is left."""

    def fault(*arguments: str) -> tuple[int, str]:
        with rodless("fault", *arguments, "--namespace", "/right") as process:
            code = process.wait()
            return code, process.output

    code, output = fault("valve.offset=0.2", "fault.carriage.seized=true")
    assert code == 0, output
    assert "fault.valve.offset: 0.0 → 0.2" in output
    code, output = fault()
    assert code == 0, output
    active = [line.split()[1] for line in output.splitlines() if line.startswith("* ")]
    assert active == ["valve.offset", "carriage.seized", "active"]
    with rodless("status", "--namespace", "/right") as status:
        status.wait()
    assert "fault.valve.offset 0.2 V, fault.carriage.seized true" in status.output
    code, output = fault("valve.offset=20")
    assert code == 2
    assert "fault.valve.offset: 20.0 refused, must be from -10 to 10 (V)" in output
    code, output = fault("--clear")
    assert code == 0, output
    assert "fault.carriage.seized: true → false" in output
    assert fault("--clear") == (0, "no fault is active\n")
    cleared = "not active, so nothing to clear: valve.offset\n"
    assert fault("--clear", "valve.offset") == (0, cleared)
