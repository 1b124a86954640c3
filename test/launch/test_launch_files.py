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

import atexit
import re
import shutil
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
from rodless_lab.cli import rig as rig_verb
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


def test_ctrl_c_as_a_launch_ends_leaves_no_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    """One that comes while the parameter files are removed is not heard: all else has ended."""
    at_exit, heard = [], []
    monkeypatch.setattr(atexit, "register", lambda *call: at_exit.append(call))
    nodes = launch_nodes(RIG)
    really_remove = shutil.rmtree

    def removed_meanwhile(folder: Path, ignore_errors: bool) -> None:
        signal.raise_signal(signal.SIGINT)
        really_remove(folder, ignore_errors)

    monkeypatch.setattr(shutil, "rmtree", removed_meanwhile)
    before = signal.signal(signal.SIGINT, lambda *_: heard.append("SIGINT"))
    try:
        for function, *arguments in at_exit:
            function(*arguments)
    finally:
        signal.signal(signal.SIGINT, before)
    assert not heard
    assert not Path(nodes[0].parameters[-1]).parent.exists()


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
        ({"sensors": "data_sheet"}, "sensors.pressure_bias", 5e-3),
        ({"preset": "calibrated"}, "sensors.pressure_bias", 5e-3),
        ({"preset": "calibrated", "sensors": "ideal"}, "sensors.pressure_bias", 0.0),
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
        ({"speed": "nan"}, "speed:=nan: time.speed: nan refused, must be from "),
        ({"speed": "0"}, "speed:=0: time.speed: 0.0 refused, must be from "),
        ({"speed": "1e9"}, "speed:=1e9: time.speed: 1000000000.0 refused, must be from "),
        ({"supply_pressure": "-5"}, "supply_pressure:=-5: supply.pressure: -5.0 refused, must be"),
        ({"supply_pressure": "inf"}, "supply_pressure:=inf: supply.pressure: inf refused, must"),
        ({"cylinder": "CY3R26-500"}, "cylinder:=CY3R26-500: cylinder.model: CY3R26-500 refused"),
        ({"scenario": "nowhere.yaml"}, "scenario:=nowhere.yaml: no file and no scenario of the"),
        ({"log_level": "loud"}, "log_level:=loud: not one of"),
    ],
)
def test_what_is_not_there_is_refused(arguments: dict[str, str], line: str) -> None:
    """Nothing starts; launch shows the line and ends with exit code 1 for an exception."""
    with pytest.raises(RuntimeError, match=re.escape(line)):
        launch_nodes(RIG, **arguments)


@pytest.mark.parametrize("file", [RIG, "two_rigs.launch.py"])
@pytest.mark.parametrize(
    ("text", "line"),
    [
        (
            "/**/plannt: {ros__parameters: {supply.pressure: 600000.0}}",
            "no section is for the plant or controller of namespace /{}; it has /**/plannt",
        ),
        ("", "not a ROS parameter file: no node sections"),
        (
            "plant:\n  ros__parameters:\n    supply.pressure: 1.0\n    supply.pressure: 2.0\n",
            "line 4: 'supply.pressure' stands twice; keep one",
        ),
        (
            "plant: {ros__parameters: {supply.pressure: &p 6.0e+5, leak.a: *p}}",
            "line 1: aliases (*name) are not for ROS; write the values out",
        ),
        (
            "plant: {ros__parameters: {supply.presure: 6.0e+5}}",
            "supply.presure: no such parameter; did you mean supply.pressure?",
        ),
    ],
)
def test_a_parameter_file_is_refused_as_by_rodless_rig(
    tmp_path: Path, file: str, text: str, line: str
) -> None:
    """One for other nodes, none at all, and what ROS would misread: in one line with its name."""
    path = tmp_path / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(RuntimeError) as refusal:
        launch_nodes(file, parameters=str(path))
    namespace = "" if file == RIG else "left"
    assert str(refusal.value) == f"parameters:={path}: {line.format(namespace)}"


def test_a_file_is_checked_with_what_it_stands_on_and_under(tmp_path: Path) -> None:
    """Preset and arguments; of a controller that does not run nothing is checked."""
    path = tmp_path / "mine.yaml"
    path.write_text(
        "plant: {ros__parameters: {cylinder.initial_position: 0.3}}\n"
        "controller: {ros__parameters: {controller.law: pd}}\n"
    )
    alone = {"parameters": str(path), "controller": "false"}
    (plant,) = launch_nodes(RIG, cylinder="CY3R25-500", **alone)
    assert parameters([plant], "plant")["cylinder.initial_position"] == 0.3
    with pytest.raises(RuntimeError, match=r"mine\.yaml: cylinder\.initial_position: 0\.3 m"):
        launch_nodes(RIG, **alone)
    with pytest.raises(RuntimeError, match=r"mine\.yaml: controller\.law: 'pd' refused"):
        launch_nodes(RIG, cylinder="CY3R25-500", parameters=str(path))


@pytest.mark.parametrize(("own", "expected"), [(None, 0.5), (0.1, 0.1), (0.7, 0.5)])
def test_a_cylinder_leaves_a_file_the_travel_that_it_wants(
    tmp_path: Path, own: float | None, expected: float
) -> None:
    """By argument and by `rodless rig` the limit is the stroke, or the file's own below it."""
    path = tmp_path / "mine.yaml"
    given = {"controller.kp": 100.0} | ({} if own is None else {"reference.maximum": own})
    path.write_text(yaml.safe_dump({"controller": {"ros__parameters": given}}))
    nodes = launch_nodes(RIG, cylinder="CY3R25-500", parameters=str(path))
    assert parameters(nodes, "controller")["reference.maximum"] == expected
    options = rig_verb._options(["--cylinder", "CY3R25-500", "--parameters", str(path)])
    found: dict[str, object] = {}
    for file in rig_verb._plan(options)._parameter_files(tmp_path):
        found.update(read_parameter_file(file, "controller"))
    assert found["reference.maximum"] == expected


@pytest.mark.parametrize(
    "text",
    [
        "plant: {ros__parameters: {supply.pressure: 600000.0}}",
        "left: {plant: {ros__parameters: {supply.pressure: 600000.0}}}",
        "plant: {ros__parameters: {supply.pressure: 600000.0}}\n"
        "/right/plant: {ros__parameters: {supply.pressure: 500000.0}}",
    ],
)
def test_a_file_gives_a_rig_in_a_namespace_what_it_gives_to_rodless_rig(
    tmp_path: Path, text: str
) -> None:
    """A section that names no namespace is for every one, and nested ones are those they name."""
    path = tmp_path / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    nodes = launch_nodes(RIG, parameters=str(path), namespace="left")
    found = [yaml.safe_load(file.read_text("utf-8")) for file in nodes[0].parameters]
    assert {"/**/plant": {"ros__parameters": {"supply.pressure": 6e5}}} in found


@pytest.mark.parametrize(
    ("given", "meant"),
    [
        ("supply_presure", "supply_pressure"),
        ("sped", "speed"),
        ("name_space", "namespace"),
        ("robot", ""),
        ("left_preset", ""),
        ("pressure", ""),
        ("model", ""),
        ("controllers_file", ""),
        ("tf_prefix", ""),
    ],
)
def test_a_misspelt_argument_is_told(
    caplog: pytest.LogCaptureFixture, given: str, meant: str
) -> None:
    """As a warning that names the nearest one; what may be another launch file's is left alone."""
    launch_nodes(RIG, **{given: "600000"})
    line = (
        f"{given}:= is no argument of rig.launch.py and changes nothing here; "
        f"did you mean {meant}:=?"
    )
    assert caplog.messages == [line] * bool(meant)
    assert all(record.levelname == "WARNING" for record in caplog.records)


def test_two_rigs_take_the_arguments_of_one_and_tell_misspelt_ones(
    caplog: pytest.LogCaptureFixture,
) -> None:
    """Each has a preset of its own where it is given one; a warning names the file it is about."""
    both = {"speed": "0.5", "preset": "calibrated"}
    nodes = launch_nodes("two_rigs.launch.py", left_preset="paper", **both)
    speeds = [parameters(rig, "plant")["time.speed"] for rig in (nodes[:2], nodes[2:])]
    assert speeds == [0.5, 0.5]
    presets = [rig[0].parameters[0].stem for rig in (nodes[:2], nodes[2:])]
    assert presets == ["paper", "calibrated"]
    assert not caplog.messages
    launch_nodes("two_rigs.launch.py", left_prset="calibrated")
    assert caplog.messages == [
        "left_prset:= is no argument of two_rigs.launch.py and changes nothing here; "
        "did you mean left_preset:=?"
    ]
    caplog.clear()
    launch_nodes("two_rigs.launch.py", sped="0.5")
    assert len(caplog.messages) == 2
    assert all("no argument of rig.launch.py" in line for line in caplog.messages)


def test_two_rigs_share_a_parameter_file_or_have_their_own(tmp_path: Path) -> None:
    """Each takes its sections of the one; a file of one rig leaves the other as it is."""
    both, right = tmp_path / "both.yaml", tmp_path / "right.yaml"
    both.write_text(
        "left: {plant: {ros__parameters: {supply.pressure: 500000.0}}}\n"
        "right: {plant: {ros__parameters: {supply.pressure: 600000.0}}}\n"
    )
    right.write_text("plant: {ros__parameters: {supply.pressure: 700000.0}}")

    def pressures(**given: str) -> list[object]:
        nodes = launch_nodes("two_rigs.launch.py", **given)
        return [parameters(rig, "plant").get("supply.pressure") for rig in (nodes[:2], nodes[2:])]

    assert pressures(parameters=str(both)) == [5e5, 6e5]
    assert pressures(right_parameters=str(right)) == [None, 7e5]
    assert pressures(parameters=str(both), right_parameters=str(right)) == [5e5, 7e5]


@pytest.mark.parametrize(
    ("given", "recorded"),
    [
        ({}, False),
        ({"bag": "run1"}, True),
        ({"bag": "run1", "record": "auto"}, True),
        ({"record": "true"}, True),
        ({"bag": "run1", "record": "false"}, False),
    ],
)
@pytest.mark.parametrize("composition", ["false", "true"])
def test_a_bag_that_is_named_is_recorded(
    given: dict[str, str], composition: str, *, recorded: bool
) -> None:
    """Beside the nodes or by their process, unless it is switched off."""
    nodes = launch_nodes(RIG, use_composition=composition, **given)
    words = [word for node in nodes for word in (node.executable, *node.command)]
    assert ("recorder" in words or "--record" in words) is recorded
    assert ("run1" in words) is (recorded and "bag" in given)
    assert ("time.recorders" in parameters(nodes, "plant")) is recorded


@pytest.mark.parametrize("argument", [{"bag": "run1"}, {"record": "true"}])
def test_two_rigs_have_bags_of_their_own(argument: dict[str, str]) -> None:
    """One for both, or two named after the same second, are refused; one rig may have none."""
    with pytest.raises(RuntimeError, match=r"refused: each rig has a bag of its own; give left_b"):
        launch_nodes("two_rigs.launch.py", **argument)
    for record in ("auto", "true"):
        nodes = launch_nodes("two_rigs.launch.py", left_bag="a", right_bag="b", record=record)
        recorders = [node.command for node in nodes if node.executable == "recorder"]
        assert [(one.count("a"), one.count("b")) for one in recorders] == [(1, 0), (0, 1)]
    with pytest.raises(RuntimeError, match=r"^left_bag:=a and right_bag:=b/\.\./a refused: .* one"):
        launch_nodes("two_rigs.launch.py", left_bag="a", right_bag="b/../a")
    nodes = launch_nodes("two_rigs.launch.py", right_bag="b")
    assert sum(node.executable == "recorder" for node in nodes) == 1


@pytest.mark.parametrize(
    ("argument", "line"),
    [
        ({"namespace": "lab"}, "namespace:=lab changes nothing: the rigs are in left and right"),
        (
            {"publish_clock": "true"},
            "publish_clock:= changes nothing: clock:= says whose time /clock shows",
        ),
    ],
)
def test_two_rigs_say_what_has_no_effect(
    caplog: pytest.LogCaptureFixture, argument: dict[str, str], line: str
) -> None:
    """What this launch file gives each rig itself."""
    nodes = launch_nodes("two_rigs.launch.py", **argument)
    assert len(nodes) == 4
    assert caplog.messages == [line]


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
    file = tmp_path / "no_law.yaml"
    file.write_text("controller: {ros__parameters: {controller.law: 'nowhere:Law'}}", "utf-8")
    _, controller = launch_nodes(RIG, parameters=str(file))
    with start_process(controller.command) as process:
        code = process.wait()
        assert "refused to start: controller.law: 'nowhere:Law'" in process.output
    context = Context({})
    event = SimpleNamespace(process_name="controller-1", returncode=code)
    with pytest.raises(RuntimeError, match="controller-1 has ended with exit code 1"):
        controller.on_exit(event, context)
    context.is_shutdown = True
    assert controller.on_exit(event, context).kind == "shutdown"
    event.returncode = 0
    assert controller.on_exit(event, Context({})).reason == "controller-1 has ended"


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
        *(("/left", "plant"), ("/left", "controller")),
        *(("/right", "plant"), ("/right", "controller")),
    ]
    left, right = nodes[:2], nodes[2:]
    published = [parameters(rig, "plant")["time.publish_clock"] for rig in (left, right)]
    assert published == owners
    for rig, owner in zip((left, right), owners, strict=True):
        assert ("recorder:/clock:=clock" in rig[1].command) is not owner
    presets = [rig[0].parameters[0].stem for rig in (left, right)]
    assert presets == ["paper", "calibrated"]


def test_the_description_is_that_of_the_rig_it_starts(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """In its namespace, with its prefix; a missing robot_state_publisher is named."""
    with pytest.raises(RuntimeError, match="needs robot_state_publisher, which is not installed"):
        launch_nodes(RIG, description="true")
    monkeypatch.setattr("launch_stand_in.INSTALLED", {"robot_state_publisher"})
    *_, publisher = launch_nodes(
        RIG, description="true", namespace="left", frame_prefix="left/", supply_pressure="401325"
    )
    assert (publisher.package, publisher.namespace) == ("robot_state_publisher", "/left")
    (given,) = publisher.parameters
    values = {"supply.pressure": 401325.0, "frame_prefix": "left/"}
    preset = RigParameters.preset("paper")
    assert given == {"robot_description": robot_description(preset.with_values(values))}
    file = tmp_path / "all.yaml"
    file.write_text("/**: {ros__parameters: {use_sim_time: true, supply.pressure: 401325.0}}")
    *_, publisher = launch_nodes(RIG, description="true", parameters=str(file))
    described = robot_description(preset.with_values({"supply.pressure": 401325.0}))
    assert publisher.parameters == [{"robot_description": described}]
    both = launch_nodes(RIG, description="true", use_composition="true")
    assert [node.executable for node in both] == ["rig", "robot_state_publisher"]


def test_rviz_shows_what_the_description_says() -> None:
    """The fixed frame of the shipped configuration is the root, its topic that of the launch."""
    shown = yaml.safe_load((ROOT / "description" / "rig.rviz").read_text("utf-8"))
    manager = shown["Visualization Manager"]
    assert manager["Global Options"]["Fixed Frame"] == BASE
    (model,) = (one for one in manager["Displays"] if one["Class"].endswith("/RobotModel"))
    assert model["Description Topic"]["Value"] == "/robot_description"
