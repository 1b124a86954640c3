# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What the launch files start, for which arguments, and how they end.

launch itself is stood in for; the nodes are real.
"""

import re
import signal
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml
from launch_stand_in import ROOT, Context, Node, launch_nodes
from rosgraph_msgs.msg import Clock
from running import StartProcess, until_it_says
from std_msgs.msg import Float64

from rodless_base.parameter_file import read_parameter_file
from rodless_base.topics import FURTHER_TOPICS
from rodless_lab import read_bag
from rodless_lab.session.node_process import NodeProcess
from rodless_lab.session.observer import Observer
from rodless_sim import RigParameters
from rodless_sim.description import BASE, robot_description
from rodless_sim.scenario import shipped_scenario

RIG = "rig.launch.py"


def parameters(nodes: list[Node], node: str) -> dict[str, object]:
    """Return what ``node`` is given; later files win."""
    found: dict[str, object] = {}
    for file in nodes[0].parameters:
        found.update(read_parameter_file(file, node))
    return found


@contextmanager
def running(start_process: StartProcess, nodes: list[Node]) -> Iterator[list[NodeProcess]]:
    """Run the nodes; each has to end well."""
    with ExitStack() as stack:
        processes = [
            stack.enter_context(start_process(node.command, node.executable)) for node in nodes
        ]
        yield processes
        for process in processes:
            process.signal(signal.SIGINT)
        assert [process.wait() for process in processes] == [0] * len(processes)


def test_by_default_it_is_the_paper_in_real_time_with_our_controller() -> None:
    """Two processes under their names, on /clock."""
    nodes = launch_nodes(RIG)
    assert [(node.executable, node.name) for node in nodes] == [
        ("plant", "plant"),
        ("controller", "controller"),
    ]
    plant = RigParameters(parameters(nodes, "plant"))
    assert plant.text("time.mode") == "realtime"
    assert plant["time.publish_clock"] is True
    assert not any("clock" in word for node in nodes for word in node.command)


@pytest.mark.parametrize(
    ("arguments", "name", "value"),
    [
        ({"speed": "0.5"}, "time.speed", 0.5),
        ({"supply_pressure": "600000"}, "supply.pressure", 6e5),
        ({"cylinder": "CY3R32-500"}, "cylinder.model", "CY3R32-500"),
        ({"publish_clock": "false"}, "time.publish_clock", False),
        ({"namespace": "left"}, "time.publish_clock", False),
        ({"namespace": "left", "publish_clock": "true"}, "time.publish_clock", True),
        ({"mode": "lockstep", "record": "true"}, "time.recorders", 1),
        ({"scenario": "leak"}, "time.scenario", str(shipped_scenario("leak"))),
        ({"truth": "true"}, "sensors.publish_truth", True),
        ({"raw": "true"}, "sensors.publish_raw", True),
    ],
)
def test_an_argument_reaches_the_plant(arguments: dict[str, str], name: str, value: object) -> None:
    """As a parameter that wins over preset and file."""
    assert parameters(launch_nodes(RIG, **arguments), "plant")[name] == value


@pytest.mark.parametrize("namespace", ["", "left"])
def test_what_no_argument_asks_for_is_as_the_file_says(tmp_path: Path, namespace: str) -> None:
    """The defaults of the arguments stand below the file, what is given above it."""
    own = {"time.mode": "lockstep", "time.publish_clock": bool(namespace), "time.recorders": 1}
    file = tmp_path / "mine.yaml"
    file.write_text(yaml.safe_dump({"/**": {"ros__parameters": own}}), encoding="utf-8")
    given = {"parameters": str(file), "namespace": namespace}
    nodes = launch_nodes(RIG, **given)
    found = parameters(nodes, "plant")
    assert {name: found[name] for name in own} == own
    assert not any("clock" in word for node in nodes for word in node.command)
    opposite = str(not namespace).lower()
    nodes = launch_nodes(RIG, mode="realtime", publish_clock=opposite, record="true", **given)
    found = parameters(nodes, "plant")
    assert found["time.mode"] == "realtime"
    assert found["time.publish_clock"] is not bool(namespace)
    assert ("recorder:/clock:=clock" in nodes[-1].command) is bool(namespace)


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        ({"parameters": "nowhere.yaml"}, "parameters:=nowhere.yaml: no such file"),
        ({"parameters": "/"}, "parameters:=/: no such file"),
        ({"speed": "fast"}, "speed:=fast: not a number"),
        ({"supply_pressure": "6 bar"}, "supply_pressure:=6 bar: not a number"),
        ({"cylinder": "CY3R26-500"}, "cylinder:=CY3R26-500: cylinder.model: CY3R26-500 refused"),
        ({"scenario": "nowhere.yaml"}, "scenario:=nowhere.yaml: no file and no scenario of the"),
        ({"log_level": "loud"}, "log_level:=loud: not one of"),
    ],
)
def test_what_is_not_there_is_refused(arguments: dict[str, str], line: str) -> None:
    """Nothing starts; launch shows the line and ends with exit code 1 for an exception."""
    with pytest.raises(RuntimeError, match=re.escape(line)):
        launch_nodes(RIG, **arguments)


def test_what_is_published_on_request_is_recorded() -> None:
    """Of truth and voltages what is on, before the topics that the plant waits for."""
    (*_, recorder) = launch_nodes(RIG, record="true", raw="true")
    assert recorder.executable == "recorder"
    topics = [word for word in recorder.command if word in (*FURTHER_TOPICS, "joint_states")]
    assert topics == ["raw/voltages", "joint_states"]
    (*_, recorder) = launch_nodes(RIG, record="true", truth="true", use_composition="false")
    assert [t for t in FURTHER_TOPICS if t in recorder.command] == list(FURTHER_TOPICS[1:])


def test_a_node_that_fails_fails_the_launch(tmp_path: Path, start_process: StartProcess) -> None:
    """One that refused to start, too; the end of one that was asked to end is no failure."""
    file = tmp_path / "misspelt.yaml"
    file.write_text("plant: {ros__parameters: {supply.presure: 6.0e+5}}", encoding="utf-8")
    plant, _ = launch_nodes(RIG, parameters=str(file))
    with start_process(plant.command) as process:
        code = process.wait()
        assert "refused to start: supply.presure: no such parameter" in process.output
    context = Context({})
    event = SimpleNamespace(process_name="plant-1", returncode=code)
    with pytest.raises(RuntimeError, match="plant-1 has ended with exit code 1"):
        plant.on_exit(event, context)
    context.is_shutdown = True
    assert plant.on_exit(event, context).kind == "shutdown"
    event.returncode = 0
    assert plant.on_exit(event, Context({})).reason == "plant-1 has ended"


def test_in_one_process_both_nodes_run_on_their_parameters(
    observer: Observer, start_process: StartProcess
) -> None:
    """At half speed, in a namespace, with its own clock; what is less than a warning is not logged.

    Without our controller there is nothing to share a process with.
    """
    (node,) = launch_nodes(
        RIG, use_composition="true", namespace="both", speed="0.5", log_level="warn"
    )
    assert node.executable == "rig"
    with running(start_process, [node]) as (process,):
        observer.more(observer.collect(Float64, "/both/valve/voltage"), 10)
        assert observer.get_parameters("/both/plant", ["time.speed"]) == {"time.speed": 0.5}
        assert observer.node.count_publishers("/clock") == 0
        assert observer.node.count_subscribers("/clock") == 0
        observer.more(observer.collect(Clock, "/both/clock"), 10)
    assert "[INFO]" not in process.output
    (alone,) = launch_nodes(RIG, use_composition="true", controller="false")
    assert alone.executable == "plant"


@pytest.mark.parametrize(("bag", "arguments"), [("", []), ("run1", ["run1"])])
def test_one_process_records_itself(bag: str, arguments: list[str]) -> None:
    """No recorder beside it; in a namespace, on the rig's own clock."""
    (node,) = launch_nodes(RIG, use_composition="true", record="true", bag=bag, namespace="one")
    start = node.command.index("--record")
    assert node.command[start + 1 : node.command.index("--ros-args")] == arguments
    assert "recorder:/clock:=clock" in node.command


def test_a_rig_in_a_namespace_is_recorded_on_its_own_time(
    start_process: StartProcess, tmp_path: Path
) -> None:
    """All that it publishes and its clock, from sample 0 on, dated in its own plant time."""
    bag = tmp_path / "bag"
    nodes = launch_nodes(RIG, namespace="taped", mode="lockstep", record="true", bag=str(bag))
    with running(start_process, nodes) as (_, controller, _):
        until_it_says(controller, "move it with a set-point on /taped/setpoint")
    read = read_bag(bag)
    names = ("joint_states", "supply/pressure", "valve/voltage", "clock")
    first = {name: read[f"/taped/{name}"].log_time[0] for name in names}
    assert first == dict.fromkeys(names, 0)
    assert "/clock" not in read.topics


@pytest.mark.parametrize(("clock", "owners"), [("none", [False, False]), ("right", [False, True])])
def test_two_rigs_start_side_by_side(clock: str, owners: list[bool]) -> None:
    """In namespaces of their own, at most one on /clock; the other's nodes live on its own."""
    nodes = launch_nodes("two_rigs.launch.py", clock=clock, right_preset="calibrated")
    assert [(node.namespace, node.name) for node in nodes] == [
        *(("left", "plant"), ("left", "controller")),
        *(("right", "plant"), ("right", "controller")),
    ]
    left, right = nodes[:2], nodes[2:]
    published = [parameters(rig, "plant")["time.publish_clock"] for rig in (left, right)]
    assert published == owners
    for rig, owner in zip((left, right), owners, strict=True):
        assert ("recorder:/clock:=clock" in rig[1].command) is not owner
    presets = [rig[0].parameters[0].stem for rig in (left, right)]
    assert presets == ["paper", "calibrated"]


def test_the_description_is_that_of_the_rig_it_starts(monkeypatch: pytest.MonkeyPatch) -> None:
    """In its namespace, with its prefix; a missing robot_state_publisher is named."""
    with pytest.raises(RuntimeError, match="needs robot_state_publisher, which is not installed"):
        launch_nodes(RIG, description="true")
    monkeypatch.setattr("launch_stand_in.INSTALLED", {"robot_state_publisher"})
    *_, publisher = launch_nodes(
        RIG, description="true", namespace="left", frame_prefix="left/", supply_pressure="401325"
    )
    assert (publisher.package, publisher.namespace) == ("robot_state_publisher", "left")
    (given,) = publisher.parameters
    values = {"supply.pressure": 401325.0, "frame_prefix": "left/"}
    preset = RigParameters.preset("paper")
    assert given == {"robot_description": robot_description(preset.with_values(values))}
    both = launch_nodes(RIG, description="true", use_composition="true")
    assert [node.executable for node in both] == ["rig", "robot_state_publisher"]


def test_rviz_shows_what_the_description_says() -> None:
    """The fixed frame of the shipped configuration is the root, its topic that of the launch."""
    shown = yaml.safe_load((ROOT / "description" / "rig.rviz").read_text("utf-8"))
    manager = shown["Visualization Manager"]
    assert manager["Global Options"]["Fixed Frame"] == BASE
    (model,) = (one for one in manager["Displays"] if one["Class"].endswith("/RobotModel"))
    assert model["Description Topic"]["Value"] == "/robot_description"
