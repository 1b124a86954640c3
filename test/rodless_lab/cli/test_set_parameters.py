"""`rodless set`: parameters of a running rig, all or none."""

from collections.abc import Iterator

import pytest
from running import StartProcess, StartRig, until_it_says

from rodless_lab.session.observer import Observer

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


def test_a_rig_that_is_not_there_is_named(rodless: StartProcess) -> None:
    """Exit code 2 within the time given, and where there is a rig."""
    with rodless("set", "supply.pressure=5e5", "--timeout", "6") as process:
        assert process.wait() == 2
    assert "no plant in namespace / of ROS domain" in process.output
    assert "there is one in /right: use --namespace" in process.output
